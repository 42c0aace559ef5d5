"""A trajectory as a table of numbers: what its file holds, row by row."""

from __future__ import annotations

import dataclasses

import numpy as np

from purcell_cli.geometry.rotations import Array


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Table:
    """What a trajectory file says.

    Attributes:
        time_s: Times [s]. Shape (n,).
        phase: Phases. Shape (n,).
        gait: Strokes' names. Shape (n,).
        position_m: The base's positions [m]. Shape (n, 3).
        base: The base's quaternions (w, x, y, z). Shape (n, 4).
        limbs: The limbs' quaternions. Shape (n, 2, 4).
        euler_rad: Euler angles of base, limb 1 and limb 2 [rad]. Shape (n, 3, 3).
        rate_rad_s: The controls. Shape (n, 6).
    """

    time_s: Array
    phase: Array
    gait: np.ndarray[tuple[int, ...], np.dtype[np.str_]]
    position_m: Array
    base: Array
    limbs: Array
    euler_rad: Array
    rate_rad_s: Array

    def __repr__(self) -> str:
        return f"<Table: {len(self.time_s)} rows, {self.time_s[-1]:.6g} s>"
