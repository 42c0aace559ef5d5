"""Derivatives of the lift by every angle of a motion."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array, as_vector
from purcell_cli.mechanics.collocation import Accuracy, flow_of
from purcell_cli.mechanics.connection import COLLINEAR, checked_shape
from purcell_cli.mechanics.lift import EXACT
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer


@frozen_dataclass
class Repeat:
    """A part of a sequence that is played more than once; each cycle brings the limbs back to where they were.

    Attributes:
        first: Its first primitive.
        stop: The primitive after its last.
        cycles: How often it is played.
    """

    first: int
    stop: int
    cycles: int


def flow_and_jacobian(
    swimmer: Swimmer,
    sequence: PrimitiveSequence,
    start: ArrayLike = COLLINEAR,
    accuracy: Accuracy = EXACT,
    repeats: Sequence[Repeat] = (),
) -> tuple[Array, Array]:
    """Return the displacement along a sequence and its derivative by every angle.

    Lengthening primitive k turns the limb's whole later path by a constant rotation in the base
    frame, about the axis n_k the limb turned on. So one pass that carries six such rotations back
    from the end gives all derivatives at once, whatever the number of primitives.

    A part that is repeated costs one cycle: the others are conjugate to it by powers of its
    displacement. Its own angles may only change together, so that it still closes; what they do
    within a cycle is then all they do.

    Args:
        swimmer: The swimmer.
        sequence: The controls; a zero angle is taken as turning the positive way.
        start: Shape before the first primitive. Shape (2, 3, 3).
        accuracy: Order and step of the method.
        repeats: Parts that are played more than once, in order.

    Returns:
        The displacement g [m], shape (4, 4), and the body twists g^-1 dg/d(angle_k) [m/rad,
        rad/rad], shape (6, n).
    """
    shapes = sequence.shapes(checked_shape(start))
    return _in_metres(swimmer, accuracy, shapes, sequence.control, sequence.angle, repeats)


def flow_and_jacobian_of_moves(
    swimmer: Swimmer,
    moves: MoveSequence,
    start: ArrayLike = COLLINEAR,
    accuracy: Accuracy = EXACT,
    repeats: Sequence[Repeat] = (),
) -> tuple[Array, Array]:
    """Return the displacement along moves and its derivative by every component of every turn.

    The path depends on a move only through its turn v = rate times duration; so the derivative by
    a rate is the duration times the one by the turn, and the derivative by the duration is the one
    by the turn along the rate. Changing v by dv turns the limb, a part s into the move, by
    J(s u) s A dv in the base frame, J being `se3.left_jacobian` and u = A v, and adds the turned
    A dv to its rate; the limb's whole later path turns by J(u) A dv.

    Args:
        swimmer: The swimmer.
        moves: The controls.
        start: Shape before the first move. Shape (2, 3, 3).
        accuracy: Order and step of the method.
        repeats: Parts that are played more than once, in order; see `flow_and_jacobian`.

    Returns:
        The displacement g [m], shape (4, 4), and the body twists g^-1 dg/d(turn) [m/rad, rad/rad],
        shape (6, n, 6).
    """
    return _in_metres(swimmer, accuracy, moves.shapes(checked_shape(start)), None, moves.turn, repeats)


def _in_metres(
    swimmer: Swimmer,
    accuracy: Accuracy,
    shapes: Array,
    controls: NDArray[np.int64] | None,
    amounts: Array,
    repeats: Sequence[Repeat],
) -> tuple[Array, Array]:
    parts = [(part.first, part.stop, part.cycles) for part in repeats]
    g, jacobian = flow_of(swimmer, accuracy).with_derivatives(shapes, controls, amounts, parts)
    g[:3, 3] *= swimmer.length_m
    jacobian[:3] *= swimmer.length_m
    return g, jacobian


def shape_gap(sequence: PrimitiveSequence, shapes: Array, end: Array) -> tuple[Array, Array]:
    """Return the rotation vectors from the wanted end shape to the found one, and their derivative.

    Args:
        sequence: The controls.
        shapes: Shapes before, between and after them. Shape (n + 1, 2, 3, 3).
        end: Shape wanted after them. Shape (2, 3, 3).

    Returns:
        Rotation vectors in base coordinates [rad], shape (6,), and derivatives by the angles,
        leading order in the gap, shape (6, n).
    """
    gap = as_vector(matmul(shapes[-1], np.swapaxes(end, -1, -2))).ravel()
    turned = turning_axes(sequence, shapes, np.full(len(sequence), len(sequence))).T
    limb = sequence.limb
    return gap, np.concatenate([np.where(limb == i, turned, 0.0) for i in (0, 1)])


def turning_axes(sequence: PrimitiveSequence, shapes: Array, seen: NDArray[np.int64]) -> Array:
    """Return the axes that each primitive's angle turns its limb's shape about, at a later place.

    A limb on ball joints turns about the axis it turned on, wherever it is seen. The pitch of a limb that turns about
    the base's z too turns it about its own y there.

    Args:
        sequence: The controls.
        shapes: Shapes before, between and after them. Shape (n + 1, 2, 3, 3).
        seen: The number of the shape at which each is seen. Shape (n,).

    Returns:
        Axes in base coordinates. Shape (n, 3).
    """
    limb, axis = sequence.limb, sequence.axis
    out = shapes[np.arange(len(sequence)), limb, :, axis]
    based = sequence.control >= 6
    if np.any(based):
        out[based] = np.array([0.0, 0.0, 1.0])
        pitched = ~based & np.isin(limb, limb[based])
        out[pitched] = shapes[seen[pitched], limb[pitched], :, 1]
    return np.asarray(out)
