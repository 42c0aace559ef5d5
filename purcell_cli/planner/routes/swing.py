"""How much room strokes take: the capsule that the links stay in while the swimmer cruises or swims arcs.

A stroke of a smaller bend swings its limbs less far aside, but turns less tightly and advances less for its joint
travel. A roadmap asks for the room at each of a few bends, the largest first.
"""

from __future__ import annotations

import dataclasses
import functools

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
_PARTS = 6
"""Into how many parts a primitive is cut to see how far the links swing."""


@frozen_dataclass(eq=False)
class Swing:
    """The room that strokes of one bend limit take, and what they cost.

    Attributes:
        bend_rad: The bend limit [rad].
        radius: How far links swing aside of the axis of the swimmer's mean pose, their own radius included [L].
        half: How far the axis of a capsule of that radius reaches from the base's middle, so that it holds them [L].
        loops: The loops that arcs are swum by.
    """

    bend_rad: float
    radius: float
    half: float
    loops: Fan


def swings(swimmer: Swimmer) -> tuple[Swing, ...]:
    """Return the room that strokes take, the largest bends first.

    Args:
        swimmer: The swimmer; one without ball joints is seen as if it had them.
    """
    unit, flat = dataclasses.replace(swimmer, joints=Swimmer().joints).scaled(), plane_axis(swimmer) is not None
    bends = [share * unit.max_bend_rad for share in SHARES]
    few = [bend for k, bend in enumerate(bends) if k == 0 or bend >= _LEAST_BEND_RAD]
    return tuple(_swing(dataclasses.replace(unit, max_bend_rad=bend), flat) for bend in few)


@functools.lru_cache(maxsize=64)
def _swing(unit: Swimmer, flat: bool) -> Swing:
    """Return the room that strokes of a swimmer on ball joints take; flat ones stay in a plane."""
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
    half = float(np.max(np.abs(x) - np.sqrt(np.maximum(radius**2 - r**2, 0.0))))
    return Swing(unit.max_bend_rad, radius + thick, half, loops)


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
