"""Rotations and poses by the thousand, by the kernel."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, address, doubles
from purcell_cli.kernel.library import KERNEL


def _each(
    function: Callable[[int, int, int], None],
    value: ArrayLike,
    what: str,
    taken: tuple[int, ...],
    given: tuple[int, ...],
) -> Array:
    """Return what a function makes of each of many arrays."""
    found = doubles(value, what)
    lead = found.ndim - len(taken)
    if lead < 0 or found.shape[lead:] != taken:
        raise ValueError(
            f"{what}: an array of shape (..., {', '.join(map(str, taken))}) is wanted, found {found.shape}"
        )
    out = np.empty((*found.shape[:lead], *given))
    if out.size:
        function(out.size // _size(given), address(found), address(out))
    return out


def _size(shape: tuple[int, ...]) -> int:
    return shape[0] if len(shape) == 1 else shape[0] * shape[1]


def exp(twist: ArrayLike) -> Array:
    """Return the displacements made by constant body twists (v, omega) in unit time. Shape (..., 6) to (..., 4, 4)."""
    return _each(KERNEL.purcell_exp, twist, "twist", (6,), (4, 4))


def log(pose: ArrayLike) -> Array:
    """Return the twists (v, omega) of poses, rotated by at most pi. Shape (..., 4, 4) to (..., 6)."""
    return _each(KERNEL.purcell_log, pose, "pose", (4, 4), (6,))


def rotation(vector: ArrayLike) -> Array:
    """Return the rotations with rotation vectors [rad]. Shape (..., 3) to (..., 3, 3)."""
    return _each(KERNEL.purcell_rotations, vector, "rotation vector", (3,), (3, 3))


def adjoint(pose: ArrayLike) -> Array:
    """Return the matrices Ad_g on (v, omega). Shape (..., 4, 4) to (..., 6, 6)."""
    return _each(KERNEL.purcell_adjoints, pose, "pose", (4, 4), (6, 6))


def inverse(pose: ArrayLike) -> Array:
    """Return inverse poses. Shape (..., 4, 4)."""
    return _each(KERNEL.purcell_inverses, pose, "pose", (4, 4), (4, 4))


def quaternion(rotation: ArrayLike) -> Array:
    """Return the unit quaternions (w, x, y, z) of rotations, w >= 0. Shape (..., 3, 3) to (..., 4)."""
    return _each(KERNEL.purcell_quaternions, rotation, "rotation", (3, 3), (4,))


def orthonormalised(matrix: ArrayLike) -> Array:
    """Return almost orthogonal matrices, or poses, whose rotation a Newton step of the polar factor has mended.

    Args:
        matrix: Shape (..., 3, 3) or (..., 4, 4).
    """
    out = np.array(doubles(matrix, "matrix"))
    if out.ndim < 2 or out.shape[-2:] not in {(3, 3), (4, 4)}:
        raise ValueError(f"matrix: an array of shape (..., 3, 3) or (..., 4, 4) is wanted, found {out.shape}")
    if out.size:
        d = out.shape[-1]
        KERNEL.purcell_orthonormalise(out.size // (d * d), d, address(out))
    return out
