"""The incumbent: the best plan so far. It only compares and keeps."""

from __future__ import annotations

import math

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.motion.limits import LimitsReport
from purcell_cli.planner.refine.shooting import Equations

ARRIVES = 1e-10
"""A motion that misses the goal by less than this arrives [L, rad]: a tenth of what its certificate allows."""

_FAULTS = {
    "bend": "bends a limb too far",
    "joint": "turns a limb about an axis that its joint has not",
    "range": "leaves a joint's range",
    "clearance": "brings the limbs too near each other",
    "workspace": "leaves the workspace",
    "obstacle": "touches an obstacle",
}
"""What a motion that breaks a limit does, in words."""


@frozen_dataclass(eq=False)
class Contender:
    """A motion that contends for the plan.

    Attributes:
        motion: The motion.
        words: What it is made of.
        off: What it misses the goal by [L, rad].
        excess: By how much it breaks its limits in all [L, rad].
        cost: What it spends of the objective.
        report: How near it comes to its limits, where that was looked at.
    """

    motion: Equations
    words: str
    off: float
    excess: float = math.inf
    cost: float = math.inf
    report: LimitsReport | None = None

    @property
    def arrives(self) -> bool:
        """Whether it arrives, within limits or not."""
        return self.off < ARRIVES

    @property
    def good(self) -> bool:
        """Whether it arrives within limits."""
        return self.arrives and self.excess == 0.0

    @property
    def fault(self) -> str:
        """What keeps it from being good, in words; empty where nothing does."""
        if not self.arrives:
            return f"misses the goal by {self.off:.1e} L or rad"
        broken = () if self.report is None else self.report.violations
        return " and ".join(dict.fromkeys(_FAULTS[v.limit] for v in broken))

    @property
    def rank(self) -> tuple[bool, float, float, float]:
        """What it is compared by, the less the better: whether it fails to arrive, its excess, its miss, its cost."""
        return not self.arrives, self.excess, 0.0 if self.arrives else self.off, self.cost


class Incumbent:
    """The best contender so far: one that arrives before one that does not, then within limits, then least cost.

    Attributes:
        best: The best contender.
        least_rad: The joint travel of the plan of least joint travel, where something else is minimised [rad].
            Contenders of less are not taken: a search for something else finds them by chance.
    """

    def __init__(self) -> None:
        self.best: Contender | None = None
        self.least_rad = 0.0

    def consider(self, contender: Contender) -> bool:
        """Keep a contender if it is better than the best so far, and return whether it is."""
        better = self.best is None or contender.rank < self.best.rank
        better = better and contender.motion.joint_travel_rad >= self.least_rad
        if better:
            self.best = contender
        return better

    @property
    def arrives(self) -> bool:
        """Whether there is a plan that arrives, within limits or not."""
        return self.best is not None and self.best.arrives

    @property
    def good(self) -> bool:
        """Whether there is a plan that arrives within limits."""
        return self.best is not None and self.best.good

    @property
    def leaves_workspace(self) -> bool:
        """Whether the best plan arrives, but not all in its workspace."""
        report = None if self.best is None or not self.best.arrives else self.best.report
        return report is not None and any(v.limit == "workspace" for v in report.violations)

    def better_than(self, other: Incumbent) -> bool:
        """Return whether the best of this is better than the other's."""
        return self.best is not None and (other.best is None or self.best.rank < other.best.rank)

    def beats(self, cost: float) -> bool:
        """Return whether no motion of a cost can be better: there is a good plan that costs no more."""
        return self.best is not None and self.best.good and self.best.cost <= cost

    @property
    def joint_travel_rad(self) -> float:
        """The joint travel of the best so far; infinite where there is none [rad]."""
        return math.inf if self.best is None else self.best.motion.joint_travel_rad
