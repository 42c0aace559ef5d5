"""A trajectory as a table of numbers: what its file holds, row by row."""

from __future__ import annotations

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array

_FAR = 1e4
"""A first row farther from the origin than this many times the motion's extent is far: pictures have 24 bits."""


@frozen_dataclass(eq=False)
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
        rate_rad_s: The controls [rad/s]. Shape (n, 6).
    """

    time_s: Array
    phase: Array
    gait: np.ndarray[tuple[int, ...], np.dtype[np.str_]]
    position_m: Array
    base: Array
    limbs: Array
    euler_rad: Array
    rate_rad_s: Array

    @property
    def origin_m(self) -> Array:
        """Where pictures measure positions from [m]: the world's origin, or, where that is far, the first row."""
        first, extent = self.position_m[0], float(np.max(np.ptp(self.position_m, axis=0)))
        far = float(np.max(np.abs(first))) > _FAR * extent > 0.0
        return first if far else np.zeros(3)

    def __repr__(self) -> str:
        return f"<Table: {len(self.time_s)} rows, {self.time_s[-1]:.6g} s>"
