"""A trajectory as cameras and encoders measure it: poses of the base, some of them unseen, and limb orientations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.motion.trajectory import Trajectory


@frozen_dataclass(eq=False)
class MeasuredTrajectory:
    """Rows of a measured motion, in order; they need not be evenly spaced.

    Attributes:
        time_s: Times [s]. Shape (n,).
        pose: The base's poses in the world; any where it was not seen [m]. Shape (n, 4, 4).
        shape: The limbs' orientations in the base. Shape (n, 2, 3, 3).
        seen: Whether the base's pose was measured. Shape (n,).
        source: What messages call it: its file.
    """

    time_s: Array
    pose: Array
    shape: Array
    seen: NDArray[np.bool_]
    source: str = "a measured trajectory"

    def __repr__(self) -> str:
        return f"<MeasuredTrajectory: {len(self)} rows, {self.time_s[-1] - self.time_s[0]:.6g} s, {self.source}>"

    def __len__(self) -> int:
        return len(self.time_s)

    @classmethod
    def of(cls, trajectory: Trajectory) -> MeasuredTrajectory:
        """Return a trajectory as if it had been measured exactly, row by row."""
        seen = np.ones(len(trajectory), dtype=np.bool_)
        return cls(trajectory.time_s, trajectory.pose, trajectory.shape, seen)
