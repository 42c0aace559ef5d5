"""The horizontal lift: the flow of the base pose along a path of shapes (section V-A, appendix A).

Any path here is a chain of pieces on which the limb rates are constant; a primitive is a piece on
which one limb turns about one of its own axes. On a piece both limbs turn about axes that are
fixed in the base frame, so the base's twist is a known analytic function of time, and the flow is
a linear equation on SE(3). It is solved by Gauss collocation (order 2 x stages, and orthogonal by
construction) on a mesh graded by how near the limbs come to the collinear shape: there A(r) is
sharp, because only spin drag resists roll. The kernel does it (`collocation.c`). Conventions: `rotations`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.shapes import shapes_along
from purcell_cli.mechanics.collocation import Accuracy, flow_of
from purcell_cli.mechanics.connection import COLLINEAR, checked_shape
from purcell_cli.mechanics.moves import ControlSequence
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer

SEARCHING = Accuracy(stages=5, step=0.8, settled=1e-9)
"""Errors of about 1e-7 (L, rad): enough to choose by, and three times quicker."""

ROUGH = Accuracy(stages=3, step=1.2, settled=1e-7)
"""Errors of 1e-4 (L, rad), which the exact arrival removes: enough to compare ways and to shorten motions."""
EXACT = Accuracy()
"""Errors below 1e-12 (L, rad) a primitive, most far below: all that is reported or written uses it."""


def piece_displacements(swimmer: Swimmer, pieces: Pieces, accuracy: Accuracy = EXACT) -> Array:
    """Return the base's body displacement on pieces of constant limb rates, each from a shape of its own.

    Args:
        swimmer: The swimmer.
        pieces: The pieces.
        accuracy: Order and step of the method.

    Returns:
        Poses relative to each piece's beginning [m]. Shape (n, 4, 4).
    """
    out = flow_of(swimmer, accuracy).pieces(pieces.shapes, pieces.rates, pieces.durations)
    out[:, :3, 3] *= swimmer.length_m
    return out


def run_displacements(
    swimmer: Swimmer,
    pieces: Pieces,
    counts: ArrayLike,
    cycles: ArrayLike,
    accuracy: Accuracy = EXACT,
) -> Array:
    """Return the base's body displacement along runs of pieces, each played a number of times.

    Where a run repeats n times, an error of its heading grows with n squared. So steps and cycles
    are put together with twice the digits.

    Args:
        swimmer: The swimmer.
        pieces: The pieces of one cycle of each run.
        counts: How many pieces each run has, in order. Shape (k,).
        cycles: How often each run is played. Shape (k,).
        accuracy: Order and step of the method.

    Returns:
        Poses relative to each run's beginning [m]. Shape (k, 4, 4).
    """
    out = flow_of(swimmer, accuracy).runs(pieces.shapes, pieces.rates, pieces.durations, counts, cycles)
    out[:, :3, 3] *= swimmer.length_m
    return out


def displacements(
    swimmer: Swimmer, sequence: ControlSequence, start: ArrayLike = COLLINEAR, accuracy: Accuracy = EXACT
) -> Array:
    """Return the base's body displacement during each piece of a sequence.

    Left invariance makes it the same from every pose.

    Args:
        swimmer: The swimmer.
        sequence: The controls.
        start: Shape before the first piece. Shape (2, 3, 3).
        accuracy: Order and step of the method.

    Returns:
        Poses relative to each piece's beginning [m]. Shape (n, 4, 4).
    """
    return piece_displacements(swimmer, Pieces.of(sequence, start), accuracy)


def flow(
    swimmer: Swimmer, sequence: ControlSequence, start: ArrayLike = COLLINEAR, accuracy: Accuracy = EXACT
) -> Array:
    """Return the base's body displacement along a sequence of controls [m]. Shape (4, 4).

    It is g_start^-1 g_end, exact to rounding for `EXACT`. How links that feel each other's flow drag, a table says:
    bends beyond 1.6 rad, where it ends, are not looked for here, and what comes of them is no motion of theirs.

    Args:
        swimmer: The swimmer.
        sequence: The controls: a `PrimitiveSequence` or a `MoveSequence`.
        start: Shape (A_1, A_2) before the first of them; the collinear one where none is given. Shape (2, 3, 3).
        accuracy: Order and step of the method.

    Raises:
        ParameterError: A start of another form, or of matrices that are no rotations.
    """
    return np.asarray(se3.prefix_products(displacements(swimmer, sequence, checked_shape(start), accuracy))[-1])


def work(swimmer: Swimmer, sequence: ControlSequence, start: ArrayLike = COLLINEAR) -> Array:
    """Return the energy dissipated during each piece, at the swimmer's joint rate [J]. Shape (n,).

    The joints' torques do the work, since no net force or torque acts on the whole.
    """
    return piece_work(swimmer, Pieces.of(sequence, start))


def piece_work(swimmer: Swimmer, pieces: Pieces) -> Array:
    """Return the energy dissipated on pieces of constant limb rates, each from a shape of its own [J].

    Args:
        swimmer: The swimmer.
        pieces: The pieces, at a joint rate of 1 rad/s.

    Returns:
        Energies at the swimmer's joint rate. Shape (n,).
    """
    scale = swimmer.lateral_drag() * _cubed(swimmer.length_m) * swimmer.joint_rate_rad_s
    return scale * flow_of(swimmer, EXACT).work(pieces.shapes, pieces.rates, pieces.durations)


def piece_effort(swimmer: Swimmer, pieces: Pieces) -> Array:
    """Return the integral of the root of the dissipated power, which no change of pace changes [sqrt(J s)].

    It is the length of the path in the metric of dissipation. Played in a time T at the pace of even
    power, which is the best, a path of length l takes the energy l^2 / T.

    Args:
        swimmer: The swimmer.
        pieces: The pieces.

    Returns:
        Lengths. Shape (n,).
    """
    scale = math.sqrt(swimmer.lateral_drag() * _cubed(swimmer.length_m))
    return np.asarray(scale * flow_of(swimmer, EXACT).work(pieces.shapes, pieces.rates, pieces.durations, root=True))


def _cubed(length: float) -> float:
    return length * length * length


def flow_of_rates(
    swimmer: Swimmer, rate: ArrayLike, duration: ArrayLike, start: ArrayLike = COLLINEAR, accuracy: Accuracy = EXACT
) -> tuple[Array, Array]:
    """Return shapes and poses along a path on which all six controls act at once.

    Args:
        swimmer: The swimmer.
        rate: Limb rates (omega_1, omega_2), constant on each piece [rad/s]. Shape (n, 6).
        duration: Durations of the pieces [s], not negative. Shape (n,).
        start: Shape at the beginning. Shape (2, 3, 3).
        accuracy: Order and step of the method.

    Returns:
        Shapes, (n + 1, 2, 3, 3), and poses relative to the beginning [m], (n + 1, 4, 4).

    Raises:
        ParameterError: A start of another form, or of matrices that are no rotations.
    """
    rates = np.asarray(rate, dtype=np.float64).reshape(-1, 6)
    times = np.asarray(duration, dtype=np.float64).reshape(-1)
    shapes = shapes_along(checked_shape(start), None, rates * times[:, None])
    return shapes, se3.prefix_products(piece_displacements(swimmer, Pieces(shapes[:-1], rates, times), accuracy))
