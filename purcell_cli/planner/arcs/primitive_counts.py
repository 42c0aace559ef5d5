"""How many primitives a swimmer takes to swim, to turn and to roll, and for which swimmers plans are promised."""

from __future__ import annotations

import math
from collections.abc import Mapping

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.gaits.gait import Gait
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.planner.arcs.loop_family import Fan, fan
from purcell_cli.planner.arcs.roll_stroke import roll_stroke, rolling


@frozen_dataclass
class PrimitiveCounts:
    """About how many primitives a swimmer's best strokes take, or how many they may take.

    Attributes:
        length: To swim its own length L.
        turn: To turn by a radian.
        roll: To roll by a radian.
    """

    length: float
    turn: float
    roll: float

    @classmethod
    def of(cls, swimmer: Swimmer, gaits: Mapping[str, Gait]) -> PrimitiveCounts:
        """Return those of a swimmer, within its bend limit, with stored gaits."""
        unit = swimmer.scaled()
        fans = [fan(unit, "travel", across) for across in (True, False)]
        rolled = rolling(gaits)
        return cls(
            1.0 / (fans[1].straight * _side_rad(fans[1], 0)),
            min(1.0 / (one.tight * _side_rad(one, -1)) for one in fans),
            roll_stroke(rolled[0], unit).primitives_per_radian if rolled else 0.0,
        )

    def within(self, most: PrimitiveCounts) -> bool:
        """Return whether all three are at most others."""
        return self.length <= most.length and self.turn <= most.turn and self.roll <= most.roll

    def __str__(self) -> str:
        return (
            f"{self.length:,.0f} primitives to swim its length L, {self.turn:,.0f} to turn by a radian and "
            f"{self.roll:,.0f} to roll by one"
        )


PROMISED = PrimitiveCounts(50_000.0, 200_000.0, 1_000.0)
"""The most primitives of swimmers for which every plan within 8 L is promised: it then takes some 1.5 million and 2 GB.
Of 120 random swimmers 82 % need fewer."""

LEAST_BEND_RAD = 0.3
"""The least bend limit of swimmers on other joints than ball joints for which plans are promised [rad]: below, chains
of their loops are often not found. All of 13 random ones from it on were planned, none of 2 below 0.1."""


LIMBS = 0.1, 10.0
"""The least and the largest length of limbs on other than ball joints for which plans are promised, as parts of the
base's: of some 140 random swimmers the two without a plan had limbs of 0.07 and of 11.5 and 16, on universal joints."""


def _swing_rad(swimmer: Swimmer) -> float:
    """Return how far the joint that swings least does so within its range and the bend limit [rad]; no ball joint."""
    limit = swimmer.max_bend_rad
    ends = [joint.range_rad(name) for joint in swimmer.joints for name in joint.angles if joint.kind != "ball"]
    return min((min(high, limit) - max(low, -limit) for low, high in ends), default=math.inf)


def _side_rad(loops: Fan, knot: int) -> float:
    """Return the joint travel of each primitive of one of the loops [rad]."""
    half_side, _ = loops.loops.sides(loops.bend[knot : knot + 1 or None], loops.offset_share[knot : knot + 1 or None])
    return 2.0 * float(half_side[0])


LEAST_SLENDERNESS = 2e-4
"""The least slenderness of links for which plans are promised: where limbs are nearly straight, doubles round a roll by
1e-16 over its square. Of 300 random swimmers four had plans that ended some 1e-9 rad off, of a slenderness of 1.0e-4 to
1.2e-4 all of them."""


def promised(swimmer: Swimmer, gaits: Mapping[str, Gait]) -> bool:
    """Return whether plans are promised for a swimmer: that it is not too thin, and its strokes are not too many."""
    if min(swimmer.slenderness_of(link) for link in range(3)) < LEAST_SLENDERNESS:
        return False
    if not swimmer.ball_joints and min(swimmer.max_bend_rad, 0.5 * _swing_rad(swimmer)) < LEAST_BEND_RAD:
        return False
    least, most = (part * swimmer.base_half_length_m for part in LIMBS)
    if not swimmer.ball_joints and not least <= min(swimmer.halves_m[1:]) <= max(swimmer.halves_m[1:]) <= most:
        return False
    return PrimitiveCounts.of(swimmer, gaits).within(PROMISED)


def advice(swimmer: Swimmer, gaits: Mapping[str, Gait]) -> str:
    """Return what would take a swimmer fewer primitives, for a message; nothing where it needs few."""
    found = PrimitiveCounts.of(swimmer, gaits)
    if found.within(PROMISED):
        return ""
    return (
        f"; this swimmer takes some {found}, and plans are promised up to {PROMISED.length:,.0f}, {PROMISED.turn:,.0f} "
        f"and {PROMISED.roll:,.0f}: a larger max_bend_rad, limbs about as long as the base or a larger drag_ratio "
        "takes fewer"
    )
