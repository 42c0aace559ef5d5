"""The certificate: an independent re-integration of written controls, and how far it may be wrong.

Nothing here uses the code that made the plan: see `replay`.
"""

from __future__ import annotations

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration, Deviation
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.mission import Waypoint
from purcell_cli.verification.replay import TOLERANCE_L, TOLERANCE_RAD, Replay, replay


@frozen_dataclass
class Certificate:
    """What the re-integration of a motion found.

    Attributes:
        deviation: How far the replayed end is from the goal.
        bound: By how much the re-integration may be wrong: what its last extrapolation still changed at the end.
        tolerance_m: Position tolerance [m].
        tolerance_rad: Angle tolerance [rad].
        segments: How many segments of constant control there are.
        integrated: How many of them had to be integrated; the rest repeat those.
    """

    deviation: Deviation
    bound: Deviation
    tolerance_m: float
    tolerance_rad: float
    segments: int
    integrated: int

    @property
    def reached(self) -> bool:
        """Whether the goal is met within the tolerances, even if the re-integration errs by its bound."""
        return self.allows(self.deviation)

    def allows(self, off: Deviation) -> bool:
        """Return whether a distance from the re-integration's end or rows is within the tolerances less its bound."""
        return off.within(self.tolerance_m - self.bound.position_m, self.tolerance_rad - self.bound.base_rad)

    def __repr__(self) -> str:
        off, told = self.deviation, "reached" if self.reached else "not reached"
        angle = max(off.base_rad, off.limb1_rad, off.limb2_rad)
        return f"<Certificate: {told}, off by {off.position_m:.2g} m and {angle:.2g} rad, {self.segments} segments>"


def certify(
    swimmer: Swimmer,
    start: Configuration,
    goal: Configuration,
    time_s: Array,
    rate_rad_s: Array,
    tolerance_l: float = TOLERANCE_L,
    tolerance_rad: float = TOLERANCE_RAD,
) -> Certificate:
    """Return whether controls, as written, carry the swimmer from start to goal.

    Args:
        swimmer: The swimmer.
        start: The start configuration.
        goal: The goal configuration.
        time_s: Times [s]. Shape (n,).
        rate_rad_s: Limb rates, each holding until the next time [rad/s]. Shape (n, 6).
        tolerance_l: Position tolerance, in units of L.
        tolerance_rad: Angle tolerance [rad].
    """
    found = replay(swimmer, start, time_s, rate_rad_s, False, tolerance_l, tolerance_rad)
    return judged(found, goal, tolerance_l * swimmer.length_m, tolerance_rad)


def judged(found: Replay, goal: Configuration | Waypoint, tolerance_m: float, tolerance_rad: float) -> Certificate:
    """Return whether a replayed motion ends at a goal, within tolerances [m] and [rad] less the replay's bound.

    Of a waypoint only what it names counts.
    """
    end = found.end
    deviation = goal.deviation(end) if isinstance(goal, Waypoint) else Deviation.between(end, goal)
    counts = len(found.which), len(found.moves.fine)
    return Certificate(deviation, found.bound, tolerance_m, tolerance_rad, *counts)
