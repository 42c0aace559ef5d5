"""Doubles as text, by the kernel: the fewest digits that read back as the same double, on every machine."""

from __future__ import annotations

import functools
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from purcell_cli.kernel.arrays import address, doubles, wholes
from purcell_cli.kernel.library import KERNEL

_POWERS = range(-292, 325)
"""The exponents of ten that doubles need."""
_LONGEST = 25
"""A number of 17 digits with its sign, point, exponent and comma, in characters."""


@functools.cache
def _powers_of_ten() -> NDArray[np.uint64]:
    """Return the highest 128 bits of powers of ten, rounded up, in two halves. Shape (617, 2)."""
    out = []
    for exponent in _POWERS:
        power, under = 10 ** max(exponent, 0), 10 ** max(-exponent, 0)
        shift = 127 - ((exponent * 1741647) >> 19)  # so that the first of the 128 bits is set
        scaled, beneath = power << max(shift, 0), under << max(-shift, 0)
        bits = -(-scaled // beneath)
        out.append((bits >> 64, bits & (2**64 - 1)))
    return np.array(out, dtype=np.uint64)


def rows_as_text(numbers: ArrayLike, words: Sequence[str], which: ArrayLike) -> bytes:
    """Return rows of numbers as lines of text with commas between, as a CSV file has them.

    Args:
        numbers: The numbers. Shape (n, m), m >= 1.
        words: What may stand after the first number of a row, as it is written.
        which: Which of the words stands there. Shape (n,).

    Raises:
        ValueError: Another shape, or no such word.
    """
    values = doubles(numbers, "numbers", (-1, -1))
    rows, columns = values.shape
    chosen = wholes(which, "which", (rows,))
    if not rows or not columns:
        return b""
    if int(chosen.min()) < 0 or int(chosen.max()) >= len(words):
        raise ValueError(f"which: words 0 to {len(words) - 1} are there, found {chosen.min()} to {chosen.max()}")
    coded = [word.encode() for word in words]
    stops = np.cumsum([0, *map(len, coded)])
    text = np.frombuffer(b"".join(coded) or b" ", dtype=np.uint8)
    out = np.empty(rows * (columns * _LONGEST + int(np.diff(stops).max())), dtype=np.uint8)
    given = (address(part) for part in (values, _powers_of_ten(), chosen, stops, text, out))
    length = KERNEL.purcell_rows_as_text(rows, columns, *given)
    return out[:length].tobytes()
