"""The numpy reference of the kernel's derivatives of the flow by every angle."""

from __future__ import annotations

import dataclasses
import itertools
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift_derivatives import Repeat
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from reference.base_velocity import TwistModel, twist_model
from reference.collocation import (
    Accuracy,
    NDArrayInt,
    _base_rates,
    _collocation,
    _mesh,
    _node_states,
    _Solution,
    _solve,
    _Steps,
)

EXACT = Accuracy()


def _power_sums(poses: Array, cycles: NDArrayInt) -> Array:
    """Return 1 + Ad_g + ... + Ad_g^(n-1) of each pose, by doubling. Shape (k, 6, 6)."""
    power = se3.adjoint(poses)
    total, block = np.zeros_like(power), np.tile(np.eye(6), (len(power), 1, 1))
    done, left = block.copy(), cycles.copy()
    while np.any(left):
        odd = (left % 2 == 1)[:, None, None]
        total, done = np.where(odd, total + matmul(done, block), total), np.where(odd, matmul(done, power), done)
        block, power, left = block + matmul(power, block), matmul(power, power), left // 2
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
            seen[part, i] = (row * each[part]).sum(axis=2).sum(axis=0)
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
    cycle = se3.normalised(matmul(se3.inverse(before[first]), before[stop]))
    extra = matmul(matmul(before[first], se3.power(cycle, cycles - 1)), se3.inverse(before[first]))
    over = np.stack([np.eye(4), *itertools.accumulate(extra, lambda done, one: matmul(done, one))])
    begins = matmul(over[np.searchsorted(stop, np.arange(m + 1), side="right")], before)
    ends = matmul(over[np.searchsorted(stop, np.arange(m), side="right")], before[1:])
    inside = np.zeros(n, dtype=np.int64)
    for k, part in enumerate(repeats, 1):
        inside[part.first : part.stop] = k
    around = se3.adjoint(begins[first])
    spread = matmul(matmul(around, _power_sums(cycle, cycles)), se3.adjoint(se3.inverse(begins[first])))
    all_cycles = np.concatenate([np.eye(6)[None], spread])
    carried = np.zeros((m + 1, 6, 6))
    carried[:-1] = matmul(se3.adjoint(begins[:-1]), _carried_to_step(solved, solved.node_change))
    within = np.cumsum(carried[::-1], axis=0)[::-1]
    carried[:-1] = matmul(all_cycles[inside[mesh.piece]], carried[:-1])
    later = np.cumsum(carried[::-1], axis=0)[::-1][stop_of]
    for k, part in enumerate(repeats, 1):
        mine = slice(part.first, part.stop)
        later[mine] = matmul(all_cycles[k], within[stop_of[mine]] - within[stop_of[part.stop - 1]])
    idle = np.bincount(mesh.piece, minlength=n) == 0
    end = np.where(idle[:, None, None], begins[stop_of], ends[np.maximum(stop_of - 1, 0)] if m else begins[stop_of])
    at_end = matmul(all_cycles[inside], se3.adjoint(end))
    return _Chain(begins, all_cycles, inside, at_end, later, se3.normalised(begins[-1]))


def _seen_at_end(model: TwistModel, chain: _Chain, seen_at_start: Array) -> tuple[Array, Array]:
    """Return the displacement [m] and its derivative in the end's frame, from twists (6, k) seen at the start."""
    g = chain.end.copy()
    jacobian = matmul(se3.adjoint(se3.inverse(g)), seen_at_start)
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
    """Return the displacement along a sequence and its derivative by every angle: see the package's."""
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
    seen_at_start = (matmul(chain.at_end, xi_end[..., None]))[..., 0]
    seen_at_start += (matmul(chain.later.reshape(n, 6, 2, 3)[np.arange(n), :, limb], turned_about[..., None]))[..., 0]
    return _seen_at_end(model, chain, seen_at_start.T)


def flow_and_jacobian_of_moves(
    swimmer: Swimmer,
    moves: MoveSequence,
    start: ArrayLike = COLLINEAR,
    accuracy: Accuracy = EXACT,
    repeats: Sequence[Repeat] = (),
) -> tuple[Array, Array]:
    """Return the displacement along moves and its derivative by every component of every turn: see the package\'s."""
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
    change = _turned_change(solved.node_change, turning)
    change += _turned_change(per_rate * (weights[:, None] * mesh.duration), se3.rotation(turned))
    own = np.zeros((n, 6, 6))
    np.add.at(own, mesh.piece, matmul(se3.adjoint(chain.begins[:-1]), _carried_to_step(solved, change)))
    own = matmul(chain.all_cycles[chain.inside], own)
    own += _by_limb(chain.later, se3.left_jacobian(turns)).reshape(n, 6, 6)
    seen_at_start = _by_limb(own, shapes[:-1]).transpose(1, 0, 2, 3).reshape(6, 6 * n)
    g, jacobian = _seen_at_end(model, chain, seen_at_start)
    return g, jacobian.reshape(6, n, 6)


def _turned_change(change: Array, turning: Array) -> Array:
    """Return changes by turns in base coordinates as changes by other turns.

    Shapes (6, 2, 3, m, n) and (m, n, 2, 3, 3).
    """
    by = turning.transpose(2, 3, 4, 0, 1)
    return np.asarray(sum(change[:, :, s, None] * by[:, s] for s in range(3)))


def _by_limb(twists: Array, turning: Array) -> Array:
    """Return twists by each limb's rotation vectors as twists by others.

    Shapes (n, 6, 6) and (n, 2, 3, 3) to (n, 6, 2, 3).
    """
    return np.swapaxes(matmul(np.swapaxes(twists.reshape(-1, 6, 2, 3), 1, 2), turning), 1, 2)
