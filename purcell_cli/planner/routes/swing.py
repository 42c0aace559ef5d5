"""How much room strokes take: what the links stay in while the swimmer cruises or swims arcs.

That is a capsule along the mean pose's axis; of hinges that keep the swimmer in a plane, a flat one: a row of thin ones
side by side in that plane. A stroke of a smaller bend swings its limbs less far aside, but turns less tightly and
advances less for its joint travel. A roadmap asks for the room at each of a few bends, the largest first.
"""

from __future__ import annotations

import dataclasses
import functools
import math

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.joint_motion import plane_axis
from purcell_cli.mechanics.lift import SEARCHING, piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.workspace import link_ends
from purcell_cli.planner.arcs.arc_price import tightest
from purcell_cli.planner.arcs.loop_family import Fan, fan
from purcell_cli.planner.arcs.loops import stroke

SHARES = (1.0, 0.6, 0.35, 0.2, 0.1)
"""Shares of the bend limit whose strokes are tried, the largest first; each takes some half of the room."""
_LEAST_BEND_RAD = 0.1
"""The least bend limit of strokes [rad]: loops beyond are many."""
_SPACING_L = 0.2
"""How far apart the thin capsules of a flat one are, at most [L]."""
_PARTS = 6
"""Into how many parts a primitive is cut to see how far the links swing."""


@frozen_dataclass(eq=False)
class Swing:
    """The room that strokes of one bend limit take, and what they cost.

    Attributes:
        bend_rad: The bend limit [rad].
        lines: How far aside the axes of capsules are, together the room: of one, 0 [L]. Shape (m,).
        thick: The radius of each, where there are no gaps between them [L].
        half: How far the axes reach to both sides from the base's middle [L].
        aside: Along which axis of the base the capsules are aside, by its index.
        loops: The loops that arcs are swum by.
    """

    bend_rad: float
    lines: Array
    thick: float
    half: float
    aside: int
    loops: Fan

    @property
    def radius(self) -> float:
        """How far links swing aside of the axis of the swimmer's mean pose, their own radius included [L]."""
        return float(self.lines[-1]) + self.thick

    def wanted_m(self, length_m: float, clearance_m: float) -> float:
        """Return how far obstacles are from each axis where no part of the room is nearer to them than this [m].

        Between two axes a gap is left: what is in their plane is off the nearer one by half of it at most.
        """
        gap = 0.5 * float(self.lines[1] - self.lines[0]) if len(self.lines) > 1 else 0.0
        return math.sqrt((gap * length_m) ** 2 + (self.thick * length_m + clearance_m) ** 2)


def swings(swimmer: Swimmer) -> tuple[Swing, ...]:
    """Return the room that strokes take, the largest bends first.

    Args:
        swimmer: The swimmer; one without ball joints is seen as if it had them.
    """
    unit, axis = dataclasses.replace(swimmer, joints=Swimmer().joints).scaled(), plane_axis(swimmer)
    bends = [share * unit.max_bend_rad for share in SHARES]
    few = [bend for k, bend in enumerate(bends) if k == 0 or bend >= _LEAST_BEND_RAD]
    return tuple(_swing(dataclasses.replace(unit, max_bend_rad=bend), axis) for bend in few)


@functools.lru_cache(maxsize=64)
def _swing(unit: Swimmer, axis: str | None) -> Swing:
    """Return the room that strokes of a swimmer on ball joints take; with an axis of hinges those about it."""
    flat = axis is not None
    loops = fan(unit, "travel", False) if flat else tightest((fan(unit, "travel", True), fan(unit, "travel", False)))
    along, aside = [], []
    for k in (0, len(loops.bend) - 1):
        half_side, offset = (
            float(x[0])
            for x in loops.loops.sides(loops.bend[k : k + 1], np.maximum(loops.offset_share[k : k + 1], 1e-3))
        )
        x, r = _spread(unit, stroke(half_side, offset, loops.loops.across))
        along.append(x)
        aside.append(r)
    x, r = np.concatenate(along), np.concatenate(aside)
    thick = max(*(radius for radius in unit.radii_m), unit.body_radius_m)
    radius = float(np.max(r))
    if not flat:
        half = float(np.max(np.abs(x) - np.sqrt(np.maximum(radius**2 - r**2, 0.0))))
        return Swing(unit.max_bend_rad, np.zeros(1), radius + thick, half, 1, loops)
    lines = np.linspace(-radius, radius, 1 + math.ceil(2.0 * radius / _SPACING_L))
    return Swing(unit.max_bend_rad, lines, thick, float(np.max(np.abs(x))), 1 if axis == "yaw" else 2, loops)


def _spread(unit: Swimmer, parts: tuple[PrimitiveSequence, ...]) -> tuple[Array, Array]:
    """Return where the links' ends come to along and aside of the mean pose's axis, in a stroke of two cycles [L].

    The mean pose goes evenly from where the stroke begins to where it ends.
    """
    whole = [*parts[0], *parts[1], *parts[1], *parts[2]]
    fine = PrimitiveSequence.of([(control, angle / _PARTS) for control, angle in whole for _ in range(_PARTS)])
    shapes = fine.shapes(COLLINEAR)
    poses = se3.prefix_products(piece_displacements(unit, Pieces.between(fine, shapes), SEARCHING))
    share = np.linspace(0.0, 1.0, len(poses))
    mean = se3.exp(share[:, None] * se3.log(poses[-1]))
    ends = link_ends(unit, se3.normalised(matmul(se3.inverse(mean), poses)), shapes[..., 0])
    return ends[..., 0].ravel(), np.sqrt(ends[..., 1] ** 2 + ends[..., 2] ** 2).ravel()
