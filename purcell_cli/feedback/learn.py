"""A better model on the way: drag fitted to what was measured so far, for `track` to plan the rest with."""

from __future__ import annotations

import math

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.feedback.fit import fit
from purcell_cli.feedback.measured import EXACTLY, Measuring
from purcell_cli.feedback.track import Tracking
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul, normal_numbers
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.measured_trajectory import MeasuredTrajectory
from purcell_cli.motion.trajectory import Trajectory

_ROWS = 3000
"""Rows that are fitted at most, the last ones: 150 s of motion with 20 rows a second, fitted in some 5 s."""


@frozen_dataclass
class Learning:
    """Fits drag to all rows that were swum, measured with noise; `track` may ask it for a model between parts.

    Attributes:
        model: The swimmer that drag is fitted for; where too little was measured, it stays as it is.
        measuring: How exactly each row is measured.
    """

    model: Swimmer
    measuring: Measuring = EXACTLY

    def __call__(self, so_far: Tracking) -> Swimmer | None:
        """Return the fitted swimmer; None where the motion so far does not tell it."""
        measured, rows = [], 0
        for number, part in reversed(list(enumerate(so_far.parts))):
            if rows < _ROWS:
                one = self._measured(part.trajectory, number, _ROWS - rows)
                measured.append(one)
                rows += len(one)
        try:
            found = fit(measured, self.model)
        except ParameterError:
            return None
        return found.swimmer if found.settled else None

    def _measured(self, trajectory: Trajectory, number: int, most: int) -> MeasuredTrajectory:
        """Return the last rows of a part as they are measured."""
        exact = MeasuredTrajectory.of(trajectory)
        low = max(len(exact) - most, 0)
        pose = exact.pose[low:]
        if self.measuring.position_l or self.measuring.base_deg:
            rng = np.random.default_rng([self.measuring.seed, number])
            size = self.measuring.position_l * self.model.length_m, math.radians(self.measuring.base_deg)
            twist = np.repeat(size, 3) * normal_numbers(rng, (len(pose), 6))
            pose = se3.normalised(matmul(pose, se3.exp(twist)))
        return MeasuredTrajectory(exact.time_s[low:], pose, exact.shape[low:], exact.seen[low:], f"part {number + 1}")
