"""The horizontal lift: the flow of the base pose along a path of shapes (section V-A, appendix A).

Any path here is a chain of pieces on which the limb rates are constant; a primitive is a piece on
which one limb turns about one of its own axes. On a piece both limbs turn about axes that are
fixed in the base frame, so the base's twist is a known analytic function of time, and the flow is
a linear equation on SE(3). It is solved by Gauss collocation (order 2 x stages, and orthogonal by
construction) on a mesh graded by how near the limbs come to the collinear shape: there A(r) is
sharp, because only spin drag resists roll. All steps of a whole sequence go through as one batch.

Rates are kept in base coordinates here, u_i = A_i omega_i: see `twist`. Conventions: `rotations`.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array, orthonormalised
from purcell_cli.mechanics.base_velocity import TwistModel, twist_model
from purcell_cli.mechanics.collocation import (
    Accuracy,
    _base_rates,
    _collocation,
    _mesh,
    _node_states,
    _solve,
)
from purcell_cli.mechanics.connection import COLLINEAR, checked_shape
from purcell_cli.mechanics.moves import ControlSequence
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer

_BATCH = 4096
"""Steps evaluated at once: bounds the memory of a long path."""


SEARCHING = Accuracy(stages=5, step=0.8, settled=1e-9)
"""Errors of about 1e-7 (L, rad): enough to choose by, and three times quicker."""

EXACT = Accuracy()
"""Errors below 1e-12 (L, rad) a primitive, most far below: all that is reported or written uses it."""


def _displacements(model: TwistModel, shapes: Array, rate: Array, duration: Array, accuracy: Accuracy) -> Array:
    """Return the base's displacement on each piece, in units of L. Shape (n, 4, 4).

    The exact ones are put together in extended precision.
    """
    precision = np.longdouble if accuracy == EXACT else np.float64
    out = np.zeros((len(duration), 4, 4), dtype=precision)
    for low in range(0, len(duration), _BATCH):
        part = slice(low, low + _BATCH)
        mesh = _mesh(model, shapes[part, :, :, 0], _base_rates(shapes[part], rate[part]), duration[part], accuracy.step)
        poses = np.zeros((len(mesh.piece), 4, 4), dtype=precision)
        for first in range(0, len(poses), _BATCH):
            some = slice(first, first + _BATCH)
            poses[some] = _solve(model, mesh[some], accuracy, gradient=False).step_pose
        out[part] = se3.normalised(se3.products(poses, np.bincount(mesh.piece, minlength=len(duration[part]))))
    return out


def piece_displacements(swimmer: Swimmer, pieces: Pieces, accuracy: Accuracy = EXACT) -> Array:
    """Return the base's body displacement on pieces of constant limb rates, each from a shape of its own.

    Args:
        swimmer: The swimmer.
        pieces: The pieces.
        accuracy: Order and step of the method.

    Returns:
        Poses relative to each piece's beginning [m]. Shape (n, 4, 4).
    """
    model = twist_model(swimmer)
    out = _displacements(model, pieces.shapes, pieces.rates, pieces.durations, accuracy).astype(np.float64)
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
    are put together in extended precision, where the machine has it.

    Args:
        swimmer: The swimmer.
        pieces: The pieces of one cycle of each run.
        counts: How many pieces each run has, in order. Shape (k,).
        cycles: How often each run is played. Shape (k,).
        accuracy: Order and step of the method.

    Returns:
        Poses relative to each run's beginning [m]. Shape (k, 4, 4).
    """
    moves = _displacements(twist_model(swimmer), pieces.shapes, pieces.rates, pieces.durations, accuracy)
    once = se3.normalised(se3.products(moves, counts))
    out = se3.repeated(once, cycles).astype(np.float64)
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

    It is g_start^-1 g_end, exact to rounding for `EXACT`.

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
    return scale * _summed_power(swimmer, pieces.shapes, pieces.rates, pieces.durations)


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
    return np.asarray(scale * _summed_power(swimmer, pieces.shapes, pieces.rates, pieces.durations, root=True))


def _cubed(length: float) -> float:
    return length * length * length


def _summed_power(swimmer: Swimmer, shapes: Array, rate: Array, duration: Array, root: bool = False) -> Array:
    """Return the integral of the scaled swimmer's dissipated power, or of its root, over each piece. Shape (n,)."""
    model = twist_model(swimmer)
    mesh = _mesh(model, shapes[:, :, :, 0], _base_rates(shapes, rate), duration, EXACT.step)
    nodes, weights, _ = _collocation(EXACT.stages)
    power = model.joint_power(*_node_states(mesh, nodes)).reshape(len(nodes), -1)
    summed = matmul(weights, np.sqrt(np.maximum(power, 0.0)) if root else np.maximum(power, 0.0)) * mesh.duration
    return np.asarray(np.bincount(mesh.piece, weights=summed, minlength=len(duration)), dtype=np.float64)


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
    shapes = np.empty((len(times) + 1, 2, 3, 3))
    shapes[0] = checked_shape(start)
    turns = se3.rotation(rates.reshape(-1, 2, 3) * times[:, None, None])
    for k, turn in enumerate(turns):
        shapes[k + 1] = orthonormalised(matmul(shapes[k], turn))
    return shapes, se3.prefix_products(piece_displacements(swimmer, Pieces(shapes[:-1], rates, times), accuracy))
