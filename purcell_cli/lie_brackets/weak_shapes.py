"""Where the swimmer is weak: the least singular value of its brackets over shapes bent alike (appendix A of the paper).

Both limbs are bent by the same angle, towards the same side (the U) at roll 0, and limb 2's bend is then rolled about
the base's axis: at 180 deg it points to the other side (the Z). Conventions: `rotations`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.lie_brackets.control_fields import brackets_by_depth, frame
from purcell_cli.lie_brackets.controllability import DIRECTIONS
from purcell_cli.lie_brackets.ranks import Rank, rank_of
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.mechanics.wall import refuse_wall


@frozen_dataclass(eq=False)
class ShapeStrength:
    """How strong the weakest direction is at a shape.

    Attributes:
        bend_rad: The bend of both limbs [rad].
        roll_rad: By how much limb 2's bend is rolled against limb 1's [rad].
        direct: The rank of A(r): h_1.
        weak: The rank of A(r) and DA(r): h_1 + h_2, which bring the base anywhere, the shape left free.
        strong: The rank of all brackets up to the depth: they bring the limbs back too.
    """

    bend_rad: float
    roll_rad: float
    direct: Rank
    weak: Rank
    strong: Rank


def bent_alike(bend_rad: float, roll_rad: float) -> Array:
    """Return the shape with both limbs bent by one angle and limb 2's bend rolled. Shape (2, 3, 3)."""
    second = about_axis(0, roll_rad) @ about_axis(2, -bend_rad) @ about_axis(0, -roll_rad)
    return np.stack([about_axis(2, bend_rad), second])


def weakest(rank: Rank) -> tuple[float, str]:
    """Return the least singular value, 0 for rounding, and the base direction it is mostly in, the first of equals."""
    value = float(rank.singular_values[-1])
    return (value if rank.dimension == len(rank.weakest) else 0.0), DIRECTIONS[int(np.argmax(rank.weakest))]


def strength(swimmer: Swimmer, bend_rad: float, roll_rad: float, depth: int) -> ShapeStrength:
    """Return how strong the weakest direction is at a shape of both limbs bent alike.

    Args:
        swimmer: The swimmer.
        bend_rad: The bend of both limbs [rad].
        roll_rad: The roll of limb 2's bend [rad].
        depth: The deepest brackets, from 2.

    Raises:
        ParameterError: A swimmer beside a wall, for which a shape says too little.
    """
    refuse_wall(swimmer)
    around = frame(swimmer, bent_alike(bend_rad, roll_rad), depth - 1)
    direct = around.fields.twist[0]
    vertical = [around.vertical(fields)[0] for fields in brackets_by_depth(around)]
    return ShapeStrength(
        bend_rad,
        roll_rad,
        rank_of(direct, around.rounding),
        rank_of(np.concatenate([direct, vertical[0]]), around.rounding),
        rank_of(np.concatenate(vertical), around.rounding),
    )


def strengths(
    swimmer: Swimmer, bends_rad: Sequence[float], rolls_rad: Sequence[float], depth: int
) -> list[ShapeStrength]:
    """Return the strength at every bend with every roll, bend by bend."""
    return [strength(swimmer, bend, roll, depth) for bend in bends_rad for roll in rolls_rad]
