"""Arrays as the compiled kernel takes them: of doubles, in one piece, and of the shape that is wanted."""

from __future__ import annotations

import ctypes
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

_Kind = TypeVar("_Kind", np.float64, np.longdouble, np.int64)

Array = NDArray[np.float64]
Whole = NDArray[np.int64]

_DOUBLE, _WHOLE = np.dtype(np.float64), np.dtype(np.int64)
_AS_BUFFER = (ctypes.c_char * 0).from_buffer
"""What gives the memory of an array that may be written: a third of the time that `numpy.ndarray.ctypes` takes."""


def doubles(value: ArrayLike, what: str, shape: tuple[int, ...] | None = None) -> Array:
    """Return numbers as an array of doubles in one piece; a copy of what may not be written, for `address`.

    Args:
        value: The numbers.
        what: What they are, for messages.
        shape: The shape wanted, -1 for any length; None for any shape.

    Raises:
        TypeError: Something that is no real number, or has more digits than a double.
        ValueError: Another shape.
    """
    if type(value) is np.ndarray and value.dtype is _DOUBLE and value.flags.carray:
        return value if shape is None or value.shape == shape else _of_shape(value, what, shape)
    found = np.asarray(value)
    if found.dtype is not _DOUBLE and (found.dtype.kind not in "fiu" or found.dtype.itemsize > _DOUBLE.itemsize):
        raise TypeError(f"{what}: real numbers no wider than doubles are wanted, found {found.dtype}")
    return _of_shape(_own(np.asarray(found, dtype=_DOUBLE, order="C")), what, shape)


def wholes(value: ArrayLike, what: str, shape: tuple[int, ...] | None = None) -> Whole:
    """Return whole numbers as an array in one piece; see `doubles`."""
    if type(value) is np.ndarray and value.dtype is _WHOLE and value.flags.carray:
        return value if shape is None or value.shape == shape else _of_shape(value, what, shape)
    found = np.asarray(value)
    if found.dtype is not _WHOLE and found.dtype.kind not in "iu" and found.size:
        raise TypeError(f"{what}: whole numbers are wanted, found {found.dtype}")
    return _of_shape(_own(np.asarray(found, dtype=_WHOLE, order="C")), what, shape)


def extended(value: ArrayLike, what: str, shape: tuple[int, ...]) -> NDArray[np.longdouble]:
    """Return numbers as an array in extended precision in one piece; see `doubles`."""
    found = np.array(value, dtype=np.longdouble, order="C", copy=None)
    return _of_shape(_own(found), what, shape)


def _own(found: NDArray[_Kind]) -> NDArray[_Kind]:
    """Return an array that may be written: where it begins is told in a tenth of the time."""
    return found if found.flags.writeable else found.copy()


def _of_shape(found: NDArray[_Kind], what: str, shape: tuple[int, ...] | None) -> NDArray[_Kind]:
    if shape is not None and found.shape != shape:
        fits = len(shape) == found.ndim
        for n, m in zip(shape, found.shape, strict=False):
            fits = fits and n in (-1, m)
        if not fits:
            wanted = ", ".join("n" if n < 0 else str(n) for n in shape)
            raise ValueError(f"{what}: an array of shape ({wanted}) is wanted, found {found.shape}")
    return found


def address(array: Any) -> int:
    """Return where an array in one piece begins; it must live while the address is used."""
    try:
        return ctypes.addressof(_AS_BUFFER(array))
    except TypeError:  # it may not be written
        return int(array.ctypes.data)
