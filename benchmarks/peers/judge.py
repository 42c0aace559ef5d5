"""What a planner answers, and the one replay that judges all answers alike."""

from __future__ import annotations

import dataclasses

import numpy as np

from benchmarks.peers.queries import Query
from purcell_cli.verification.certificate import certify

LOOSE = 0.05
"""A tolerance that sampling planners can meet (L, rad)."""


@dataclasses.dataclass(frozen=True)
class Answer:
    """Controls, each held for a time.

    Attributes:
        duration_s: Durations [s]. Shape (n,).
        rate_rad_s: Limb rates [rad/s]. Shape (n, 6).
    """

    duration_s: np.ndarray
    rate_rad_s: np.ndarray

    @property
    def joint_travel_rad(self) -> float:
        """The sum over all joints of |rate| x time [rad]."""
        return float(np.sum(np.abs(self.rate_rad_s) * self.duration_s[:, None]))


def error(query: Query, answer: Answer) -> float:
    """Return how far from the goal the controls end, by the certificate: the largest of position [L] and angles."""
    times = np.concatenate([[0.0], np.cumsum(answer.duration_s)])
    rates = np.concatenate([answer.rate_rad_s, np.zeros((1, 6))])
    off = certify(query.swimmer, query.start, query.goal, times, rates).deviation
    return max(off.position_m / query.swimmer.length_m, off.base_rad, off.limb1_rad, off.limb2_rad)
