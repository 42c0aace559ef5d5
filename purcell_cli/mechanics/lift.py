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

import dataclasses
import functools
import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.geometry import se3
from purcell_cli.geometry.component_first import cross_rows, dot_rows
from purcell_cli.geometry.rotations import Array, as_vector, orthonormalised
from purcell_cli.mechanics.base_velocity import TwistModel, twist_model
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.moves import ControlSequence, MoveSequence
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer

_SPIN_SHARE = 0.25
"""A limb's spin about its own axis counts for this much of a sweep in the length of steps."""
_BATCH = 4096
"""Steps evaluated at once: bounds the memory of a long path."""


@dataclasses.dataclass(frozen=True, slots=True)
class Accuracy:
    """How finely the lift is computed.

    Attributes:
        stages: Collocation nodes in a step; the order is twice that.
        step: Largest step, as a fraction of the distance from the collinear shape.
        settled: The iteration for the orientations ends with a change by less; what is left is far less.
    """

    stages: int = 8
    step: float = 0.4
    settled: float = 1e-14


SEARCHING = Accuracy(stages=5, step=0.8, settled=1e-9)
"""Errors of about 1e-7 (L, rad): enough to choose by, and three times quicker."""

EXACT = Accuracy()
"""Errors below 1e-12 (L, rad) a primitive, most far below: all that is reported or written uses it."""


@functools.cache
def _collocation(stages: int) -> tuple[Array, Array, Array]:
    """Return nodes on [0, 1], weights, and weights of the integral from 0 to each node."""
    x, w = np.polynomial.legendre.leggauss(stages)
    values = np.polynomial.legendre.legvander(x, stages - 1)
    integrals = np.stack(
        [np.polynomial.legendre.legval(x, np.polynomial.legendre.legint(row, lbnd=-1)) for row in np.eye(stages)],
        axis=-1,
    )
    to_node = 0.5 * np.asarray(np.linalg.solve(values.T, integrals.T).T, dtype=np.float64)
    return (x + 1) / 2, w / 2, to_node


@dataclasses.dataclass(frozen=True, slots=True)
class _Steps:
    """The mesh: steps, each within one piece; shapes last, as in `twist`.

    Attributes:
        piece: The piece each step is of, ascending. Shape (n,).
        axes: The limbs' axes where it begins. Shape (3, 2, n).
        rates: Rates of the limbs in base coordinates. Shape (3, 2, n).
        duration: How long it lasts. Shape (n,).
    """

    piece: NDArrayInt
    axes: Array
    rates: Array
    duration: Array

    def __getitem__(self, part: slice) -> _Steps:
        return _Steps(self.piece[part], self.axes[..., part], self.rates[..., part], self.duration[part])


NDArrayInt = np.ndarray[tuple[int, ...], np.dtype[np.int64]]


def _mesh(model: TwistModel, axes: Array, rates: Array, duration: Array, step: float) -> _Steps:
    """Cut pieces into steps that are short against the distance from the collinear shape.

    The distance changes at most `steepness` times as fast as the limbs turn, so a step that is
    short enough at its middle is everywhere. A limb spinning about its own axis sweeps nothing, but
    turns the base; a piece of no duration needs no step.

    Args:
        model: The swimmer.
        axes: The limbs' axes where the pieces begin. Shape (n, 2, 3).
        rates: Rates of the limbs in base coordinates. Shape (n, 2, 3).
        duration: How long the pieces last. Shape (n,).
        step: Largest step, as a fraction of the distance.
    """
    axes, rates = (np.ascontiguousarray(np.moveaxis(x, 0, -1).swapaxes(0, 1)) for x in (axes, rates))
    swept, spun = cross_rows(rates, axes), _SPIN_SHARE * dot_rows(rates, axes)
    sweep = np.sqrt((dot_rows(swept, swept) + spun * spun).sum(axis=0))
    piece = np.flatnonzero(duration)
    start, length = np.zeros(len(piece)), duration[piece]
    done: list[tuple[NDArrayInt, Array, Array]] = [(piece[:0], start[:0], length[:0])]
    while len(piece):
        turned = _rotate(rates[..., piece] * (start + 0.5 * length), axes[..., piece])
        arc = sweep[piece] * length
        near = model.distance(turned)
        nearest = np.maximum(near - 0.5 * model.steepness * arc, model.sharpness)
        ratio = arc / (step * nearest)
        parts = np.where(arc > step * near, np.minimum(np.ceil(ratio), 8), 1).astype(np.int64)
        good = parts == 1
        done.append((piece[good], start[good], length[good]))
        parts = parts[~good]
        index = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
        length = np.repeat(length[~good] / parts, parts)
        start = np.repeat(start[~good], parts) + index * length
        piece = np.repeat(piece[~good], parts)
    piece, start, length = (np.concatenate(column) for column in zip(*done, strict=True))
    order = np.lexsort((start, piece))
    piece, start, length = piece[order], start[order], length[order]
    turning = rates[..., piece]
    return _Steps(piece, _rotate(turning * start, axes[..., piece]), turning, length)


def _rotate(axis_angle: Array, vector: Array) -> Array:
    """Return vectors turned by rotation vectors, both (3, ...)."""
    angle = np.sqrt(dot_rows(axis_angle, axis_angle))
    half = 0.5 * angle
    small = angle < 1e-100
    safe = np.where(small, 1.0, angle)
    a = np.where(small, 1.0, np.sin(angle) / safe)
    b = np.where(small, 0.5, 2.0 * (np.sin(half) / safe) ** 2)
    first = cross_rows(axis_angle, vector)
    return np.asarray(vector + a * first + b * cross_rows(axis_angle, first))


@dataclasses.dataclass(frozen=True, slots=True)
class _Solution:
    """The flow on every step, from the step's start; at its nodes too where a gradient is wanted.

    Attributes:
        step_pose: Displacements. Shape (n, 4, 4).
        node_rotation: Orientations at the nodes. Shape (3, 3, m, n).
        node_position: Positions at the nodes. Shape (3, m, n).
        node_change: How turning a limb changes the twist, times the node's weight. Shape (6, 2, 3, m, n).
    """

    step_pose: Array
    node_rotation: Array
    node_position: Array
    node_change: Array


def _node_states(steps: _Steps, nodes: Array) -> tuple[Array, Array]:
    """Return the limbs' axes and rates at the nodes of all steps. Shapes (3, 2, m n)."""
    times = nodes[:, None] * steps.duration
    rates = np.broadcast_to(steps.rates[:, :, None], (3, 2, *times.shape))
    axes = _rotate(rates * times, steps.axes[:, :, None])
    return axes.reshape(3, 2, -1), rates.reshape(3, 2, -1)


def _solve(model: TwistModel, steps: _Steps, accuracy: Accuracy, gradient: bool) -> _Solution:
    """Solve g' = g hat(xi) from the identity on every step by Gauss collocation, orientations as quaternions."""
    nodes, weights, to_node = _collocation(accuracy.stages)
    n, m = len(steps.duration), len(nodes)
    axes, rates = _node_states(steps, nodes)
    change = np.empty(0)
    if gradient:
        xi, change = model.twist_and_change(axes, rates)
        change = change.reshape(6, 2, 3, m, n) * (weights[:, None] * steps.duration)
    else:
        xi = model.twist(axes, rates)
    xi = xi.reshape(6, m, n) * steps.duration
    omega = 0.5 * xi[3:]
    scalar, vector = np.ones((m, n)), to_node @ omega
    # Picard iteration: the error falls faster than any power, by |omega / 2|^k / k!.
    for _ in range(100):
        scalar = 1.0 - to_node @ dot_rows(vector, omega)
        renewed = to_node @ (scalar * omega + cross_rows(vector, omega))
        changed = float(np.max(np.abs(renewed - vector), initial=0.0))
        vector = renewed
        if changed < accuracy.settled:
            break
    velocity = _turned(scalar, vector, xi[:3])
    end = np.stack(
        [1.0 + weights @ -dot_rows(vector, omega), *(weights @ (scalar * omega + cross_rows(vector, omega)))]
    )
    end /= np.sqrt(np.sum(end * end, axis=0))
    step_pose = se3.pose(np.moveaxis(_matrix(end[0], end[1:]), -1, 0), (weights @ velocity).T)
    if not gradient:
        return _Solution(step_pose, change, change, change)
    return _Solution(step_pose, _matrix(scalar, vector), to_node @ velocity, change)


def _turned(scalar: Array, vector: Array, v: Array) -> Array:
    """Return vectors (3, ...) turned by almost unit quaternions, given as scalar and vector parts."""
    across = 2.0 * cross_rows(vector, v)
    return np.asarray(v + scalar * across + cross_rows(vector, across))


def _matrix(scalar: Array, vector: Array) -> Array:
    """Return the matrices (3, 3, ...) of almost unit quaternions, given as scalar and vector parts."""
    columns = [_turned(scalar, vector, e.reshape(3, *(1 for _ in scalar.shape))) for e in np.eye(3)]
    return np.stack(columns, axis=1)


def _base_rates(shapes: Array, rate: Array) -> Array:
    """Return u_i = A_i omega_i. Shapes (n, 2, 3, 3) and (n, 6) to (n, 2, 3)."""
    return np.asarray(np.einsum("nlij,nlj->nli", shapes, rate.reshape(-1, 2, 3)))


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


def piece_displacements(
    swimmer: Swimmer, shapes: Array, rate: Array, duration: Array, accuracy: Accuracy = EXACT
) -> Array:
    """Return the base's body displacement on pieces of constant limb rates, each from a shape of its own.

    Args:
        swimmer: The swimmer.
        shapes: Shapes at the beginning of the pieces. Shape (n, 2, 3, 3).
        rate: Limb rates (omega_1, omega_2) [rad/s]. Shape (n, 6).
        duration: Durations [s], not negative. Shape (n,).
        accuracy: Order and step of the method.

    Returns:
        Poses relative to each piece's beginning [m]. Shape (n, 4, 4).
    """
    out = _displacements(twist_model(swimmer), shapes, rate, duration, accuracy).astype(np.float64)
    out[:, :3, 3] *= swimmer.length_m
    return out


def run_displacements(
    swimmer: Swimmer,
    pieces: tuple[Array, Array, Array],
    counts: ArrayLike,
    cycles: ArrayLike,
    accuracy: Accuracy = EXACT,
) -> Array:
    """Return the base's body displacement along runs of pieces, each played a number of times.

    Where a run repeats n times, an error of its heading grows with n squared. So steps and cycles
    are put together in extended precision, where the machine has it.

    Args:
        swimmer: The swimmer.
        pieces: Shapes, limb rates and durations, as for `piece_displacements`, of one cycle each.
        counts: How many pieces each run has, in order. Shape (k,).
        cycles: How often each run is played. Shape (k,).
        accuracy: Order and step of the method.

    Returns:
        Poses relative to each run's beginning [m]. Shape (k, 4, 4).
    """
    once = se3.normalised(se3.products(_displacements(twist_model(swimmer), *pieces, accuracy), counts))
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
    return piece_displacements(swimmer, sequence.shapes(start)[:-1], sequence.rates(), sequence.duration, accuracy)


def flow(
    swimmer: Swimmer, sequence: ControlSequence, start: ArrayLike = COLLINEAR, accuracy: Accuracy = EXACT
) -> Array:
    """Return the base's body displacement along a sequence of controls [m]. Shape (4, 4)."""
    return np.asarray(se3.prefix_products(displacements(swimmer, sequence, start, accuracy))[-1])


def work(swimmer: Swimmer, sequence: ControlSequence, start: ArrayLike = COLLINEAR) -> Array:
    """Return the energy dissipated during each piece, at the swimmer's joint rate [J]. Shape (n,).

    The joints' torques do the work, since no net force or torque acts on the whole.
    """
    return piece_work(swimmer, sequence.shapes(start)[:-1], sequence.rates(), sequence.duration)


def piece_work(swimmer: Swimmer, shapes: Array, rate: Array, duration: Array) -> Array:
    """Return the energy dissipated on pieces of constant limb rates, each from a shape of its own [J].

    Args:
        swimmer: The swimmer.
        shapes: Shapes at the beginning of the pieces. Shape (n, 2, 3, 3).
        rate: Limb rates at a joint rate of 1 rad/s [rad/s]. Shape (n, 6).
        duration: Durations at that joint rate [s]. Shape (n,).

    Returns:
        Energies at the swimmer's joint rate. Shape (n,).
    """
    scale = swimmer.lateral_drag() * swimmer.length_m**3 * swimmer.joint_rate_rad_s
    return scale * _summed_power(swimmer, shapes, rate, duration, 1.0)


def piece_effort(swimmer: Swimmer, shapes: Array, rate: Array, duration: Array) -> Array:
    """Return the integral of the root of the dissipated power, which no change of pace changes [sqrt(J s)].

    It is the length of the path in the metric of dissipation. Played in a time T at the pace of even
    power, which is the best, a path of length l takes the energy l^2 / T.

    Args:
        swimmer: The swimmer.
        shapes: Shapes at the beginning of the pieces. Shape (n, 2, 3, 3).
        rate: Limb rates [rad/s]. Shape (n, 6).
        duration: Durations [s]. Shape (n,).

    Returns:
        Lengths. Shape (n,).
    """
    scale = np.sqrt(swimmer.lateral_drag() * swimmer.length_m**3)
    return np.asarray(scale * _summed_power(swimmer, shapes, rate, duration, 0.5))


def _summed_power(swimmer: Swimmer, shapes: Array, rate: Array, duration: Array, exponent: float) -> Array:
    """Return the integral of a power of the scaled swimmer's dissipated power over each piece. Shape (n,)."""
    model = twist_model(swimmer)
    mesh = _mesh(model, shapes[:, :, :, 0], _base_rates(shapes, rate), duration, EXACT.step)
    nodes, weights, _ = _collocation(EXACT.stages)
    power = model.joint_power(*_node_states(mesh, nodes)).reshape(len(nodes), -1)
    summed = weights @ np.maximum(power, 0.0) ** exponent * mesh.duration
    return np.asarray(np.bincount(mesh.piece, weights=summed, minlength=len(duration)), dtype=np.float64)


@dataclasses.dataclass(frozen=True, slots=True)
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


def _power_sums(poses: Array, cycles: NDArrayInt) -> Array:
    """Return 1 + Ad_g + ... + Ad_g^(n-1) of each pose, by doubling. Shape (k, 6, 6)."""
    power = se3.adjoint(poses)
    total, block = np.zeros_like(power), np.tile(np.eye(6), (len(power), 1, 1))
    done, left = block.copy(), cycles.copy()
    while np.any(left):
        odd = (left % 2 == 1)[:, None, None]
        total, done = np.where(odd, total + done @ block, total), np.where(odd, done @ power, done)
        block, power, left = block + power @ block, power @ power, left // 2
    return total


@dataclasses.dataclass(frozen=True, slots=True)
class _Chain:
    """The steps of a whole path put together, repeats played out; twists are seen from the path's start.

    Attributes:
        begins: Poses where the steps begin, and the end. Shape (m + 1, 4, 4).
        all_cycles: What carries a change in one cycle to all cycles, the unrepeated one first. Shape (k, 6, 6).
        inside: Which of them holds for each piece. Shape (n,).
        at_end: What carries the body twist at each piece's end there. Shape (n, 6, 6).
        later: What turning the limbs from each piece's end on changes. Shape (n, 6, 6).
        end: The displacement of the whole path. Shape (4, 4).
    """

    begins: Array
    all_cycles: Array
    inside: NDArrayInt
    at_end: Array
    later: Array
    end: Array


def _carried_to_step(solved: _Solution, change: Array) -> Array:
    """Return the sum over a step's nodes of changes of the twist, seen from the step's beginning.

    Args:
        solved: The flow on the steps.
        change: Twists at the nodes. Shape (6, 2, 3, m, n).

    Returns:
        Twists. Shape (n, 6, 6).
    """
    _, _, _, m, n = change.shape
    each = change.reshape(2, 3, 6, m, n)
    seen = np.empty((2, 3, 6, n))
    for i in range(3):
        row = solved.node_rotation[i, :, None]
        for part in (0, 1):
            seen[part, i] = np.einsum("jkmn,jkmn->kn", np.broadcast_to(row, each[part].shape), each[part])
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        for sign, along, across in ((1.0, j, k), (-1.0, k, j)):
            turned = (solved.node_rotation[across, :, None] * each[1]).sum(axis=0)
            seen[0, i] += sign * (solved.node_position[along] * turned).sum(axis=1)
    return np.ascontiguousarray(seen.reshape(6, 6, n).transpose(2, 0, 1))


def _chained(mesh: _Steps, solved: _Solution, n: int, repeats: Sequence[Repeat]) -> _Chain:
    m = len(mesh.piece)
    stop_of = np.searchsorted(mesh.piece, np.arange(n), side="right")
    before = se3.prefix_products(solved.step_pose)
    # Before a repeat is played out begins and ends are those of one cycle of each; the further cycles
    # of all repeats that are over lie between them and the path's start.
    first, stop = (
        np.array([int(stop_of[k - 1]) if k else 0 for k in edge], dtype=np.int64)
        for edge in ([part.first for part in repeats], [part.stop for part in repeats])
    )
    cycles = np.array([part.cycles for part in repeats], dtype=np.int64)
    cycle = se3.normalised(se3.inverse(before[first]) @ before[stop])
    extra = before[first] @ se3.power(cycle, cycles - 1) @ se3.inverse(before[first])
    over = np.stack([np.eye(4), *itertools.accumulate(extra, lambda done, one: done @ one)])
    begins = over[np.searchsorted(stop, np.arange(m + 1), side="right")] @ before
    ends = over[np.searchsorted(stop, np.arange(m), side="right")] @ before[1:]
    inside = np.zeros(n, dtype=np.int64)
    for k, part in enumerate(repeats, 1):
        inside[part.first : part.stop] = k
    around = se3.adjoint(begins[first])
    spread = around @ _power_sums(cycle, cycles) @ se3.adjoint(se3.inverse(begins[first]))
    all_cycles = np.concatenate([np.eye(6)[None], spread])
    carried = np.zeros((m + 1, 6, 6))
    carried[:-1] = se3.adjoint(begins[:-1]) @ _carried_to_step(solved, solved.node_change)
    within = np.cumsum(carried[::-1], axis=0)[::-1]
    carried[:-1] = all_cycles[inside[mesh.piece]] @ carried[:-1]
    later = np.cumsum(carried[::-1], axis=0)[::-1][stop_of]
    for k, part in enumerate(repeats, 1):
        mine = slice(part.first, part.stop)
        later[mine] = all_cycles[k] @ (within[stop_of[mine]] - within[stop_of[part.stop - 1]])
    idle = np.bincount(mesh.piece, minlength=n) == 0
    end = np.where(idle[:, None, None], begins[stop_of], ends[np.maximum(stop_of - 1, 0)] if m else begins[stop_of])
    at_end = all_cycles[inside] @ se3.adjoint(end)
    return _Chain(begins, all_cycles, inside, at_end, later, se3.normalised(begins[-1]))


def _seen_at_end(model: TwistModel, chain: _Chain, seen_at_start: Array) -> tuple[Array, Array]:
    """Return the displacement [m] and its derivative in the end's frame, from twists (6, k) seen at the start."""
    g = chain.end.copy()
    jacobian = se3.adjoint(se3.inverse(g)) @ seen_at_start
    g[:3, 3] *= model.length_m
    jacobian[:3] *= model.length_m
    return g, jacobian


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
    model = twist_model(swimmer)
    shapes = sequence.shapes(start)
    base_rates = _base_rates(shapes[:-1], sequence.rates())
    n = len(sequence)
    mesh = _mesh(model, shapes[:-1, :, :, 0], base_rates, sequence.duration, accuracy.step)
    solved = _solve(model, mesh, accuracy, gradient=True)
    chain = _chained(mesh, solved, n, repeats)
    limb, axis = sequence.control // 3, sequence.control % 3
    turned_about = shapes[np.arange(n), limb, :, axis]
    sign = np.where(sequence.angle < 0, -1.0, 1.0)
    xi_end = sign[:, None] * model.twist(*(x.transpose(2, 1, 0) for x in (shapes[1:, :, :, 0], base_rates))).T
    seen_at_start = (chain.at_end @ xi_end[..., None])[..., 0]
    seen_at_start += (chain.later.reshape(n, 6, 2, 3)[np.arange(n), :, limb] @ turned_about[..., None])[..., 0]
    return _seen_at_end(model, chain, seen_at_start.T)


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
    model = twist_model(swimmer)
    shapes = moves.shapes(start)
    n = len(moves)
    turns = _base_rates(shapes[:-1], moves.turn)
    mesh = _mesh(model, shapes[:-1, :, :, 0], turns, np.ones(n), accuracy.step)
    solved = _solve(model, mesh, accuracy, gradient=True)
    chain = _chained(mesh, solved, n, repeats)
    nodes, weights, _ = _collocation(accuracy.stages)
    m, k = len(mesh.piece), len(nodes)
    begun = np.cumsum(mesh.duration) - mesh.duration - mesh.piece
    part = begun + nodes[:, None] * mesh.duration
    turned = np.moveaxis(part * mesh.rates[:, :, None], (0, 1), (-1, -2))  # (k, m, 2, 3)
    per_rate = model.per_rate(_node_states(mesh, nodes)[0]).reshape(6, 2, 3, k, m)
    turning = part[..., None, None, None] * se3.left_jacobian(turned)
    change = np.einsum("alskm,kmlsj->aljkm", solved.node_change, turning)
    change += np.einsum("alskm,kmlsj->aljkm", per_rate * (weights[:, None] * mesh.duration), se3.rotation(turned))
    own = np.zeros((n, 6, 6))
    np.add.at(own, mesh.piece, se3.adjoint(chain.begins[:-1]) @ _carried_to_step(solved, change))
    own = chain.all_cycles[chain.inside] @ own
    own += np.einsum("nals,nlsj->nalj", chain.later.reshape(n, 6, 2, 3), se3.left_jacobian(turns)).reshape(n, 6, 6)
    seen_at_start = np.einsum("nalj,nlji->anli", own.reshape(n, 6, 2, 3), shapes[:-1]).reshape(6, 6 * n)
    g, jacobian = _seen_at_end(model, chain, seen_at_start)
    return g, jacobian.reshape(6, n, 6)


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
    gap = as_vector(shapes[-1] @ np.swapaxes(end, -1, -2)).ravel()
    limb, axis = sequence.control // 3, sequence.control % 3
    turned = shapes[np.arange(len(sequence)), limb, :, axis].T
    return gap, np.concatenate([np.where(limb == i, turned, 0.0) for i in (0, 1)])


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
    """
    rates = np.asarray(rate, dtype=np.float64).reshape(-1, 6)
    times = np.asarray(duration, dtype=np.float64).reshape(-1)
    shapes = np.empty((len(times) + 1, 2, 3, 3))
    shapes[0] = start
    turns = se3.rotation(rates.reshape(-1, 2, 3) * times[:, None, None])
    for k, turn in enumerate(turns):
        shapes[k + 1] = orthonormalised(shapes[k] @ turn)
    return shapes, se3.prefix_products(piece_displacements(swimmer, shapes[:-1], rates, times, accuracy))
