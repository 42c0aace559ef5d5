"""Minimum energy in a given time: sequential quadratic programming on the dissipation under the exact arrival.

Played in a time d at constant rates, a move that takes the energy W in unit time takes W / d. For given moves the
durations that take least are proportional to the roots of W, as far as the joints' rates allow. For given durations
the energy is a sum of quadratic forms of the moves, in the metric of dissipation at the shapes where they are, and
that is what a program knows of its curvature; its slope also knows how later moves change with the shapes they are at.

The trust region, the arrival and the bend limit are those of `minimum_time`.
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import apply, matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.convex import Blocks, least
from purcell_cli.kernel.flow import connection
from purcell_cli.mechanics.base_velocity import kernel_numbers
from purcell_cli.mechanics.collocation import flow_of
from purcell_cli.mechanics.joint_turns import by_turns, frames, has_universal, rotation_vectors
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.planner.refine.active_set import loose
from purcell_cli.planner.refine.inequalities import Linearised
from purcell_cli.planner.refine.move_program import groups
from purcell_cli.planner.refine.shooting import Equations

_ROOM = 1.02
"""How much longer than it must a move lasts at least, so that a program can begin within the rates."""
_NUDGE = 1e-4
"""By how much moves and shapes are changed to find how the energy changes [rad]."""
_ACCURATE = 1e-6
"""Accuracy of a program, as a part of the energy."""
_PATIENCE = 60
"""The most rounds in which moves are found that the rates hold back."""


def durations(work: Array, turn: Array, cycles: Array, total: float) -> Array:
    """Return the durations of moves that take least energy in a time, at joint rates of at most 1 rad/s. Shape (n,).

    Args:
        work: What each takes in unit time. Shape (n,).
        turn: Turns of their joints [rad]. Shape (n, 6).
        cycles: How often each is played. Shape (n,).
        total: The time of all of them [s].
    """
    shortest = _ROOM * np.max(np.abs(turn), axis=1) + 1e-12
    root, held = np.sqrt(np.maximum(work, 0.0)) + 1e-12, np.zeros(len(work), dtype=bool)
    out = shortest
    for _ in range(_PATIENCE):
        left = total - float(np.add.reduce((cycles * shortest)[held]))
        pace = left / max(float(np.add.reduce((cycles * root)[~held])), 1e-300)
        out = np.where(held, shortest, pace * root)
        more = ~held & (out < shortest)
        if not np.any(more):
            break
        held = held | more
    return np.asarray(np.maximum(out, shortest))


class Dissipation:
    """What moves dissipate, for a motion.

    Args:
        motion: The motion.
        total: The time it has at a joint rate of 1 rad/s [s].
    """

    def __init__(self, motion: Equations, total: float) -> None:
        self.motion, self.total = motion, total
        self.flow = flow_of(motion.swimmer, SEARCHING)
        self.numbers = kernel_numbers(motion.swimmer)

    def work(self, turn: Array) -> Array:
        """Return what turns of joints take in unit time. Shape (n, 6) to (n,)."""
        shapes, vectors = self._played(turn)
        return self.flow.work(shapes[:-1], vectors, np.ones(len(turn)))

    def _played(self, turn: Array) -> tuple[Array, Array]:
        """Return the shapes along turns of joints, (n + 1, 2, 3, 3), and the rotation vectors that they are, (n, 6)."""
        vectors = rotation_vectors(self.motion.swimmer, self.motion.start, turn)
        return MoveSequence.of_turns(vectors).shapes(self.motion.start), vectors

    def slope(self, turn: Array, each: Array) -> Array:
        """Return the derivative of the energy by the turns, the durations as they are. Shape (n, 6).

        Args:
            turn: Turns of joints [rad]. Shape (n, 6).
            each: Cycles over duration of each move [1/s]. Shape (n,).
        """
        n = len(turn)
        shapes, vectors = self._played(turn)
        before, unit = shapes[:-1], np.eye(6)
        off = se3.rotation((_NUDGE * np.concatenate([unit, -unit])).reshape(12, 2, 3))
        turned = matmul(off[:, None], before[None])  # the shapes before, turned in base coordinates
        other = vectors[None] + _NUDGE * np.concatenate([unit, -unit])[:, None]
        starts = np.concatenate([turned, np.broadcast_to(before, (12, n, 2, 3, 3))]).reshape(-1, 2, 3, 3)
        rates = np.concatenate([np.broadcast_to(vectors, (12, n, 6)), other]).reshape(-1, 6)
        work = self.flow.work(starts, rates, np.ones(len(rates))).reshape(4, 6, n)
        by_shape = each[:, None] * ((work[0] - work[1]) / (2.0 * _NUDGE)).T
        by_turn = each[:, None] * ((work[2] - work[3]) / (2.0 * _NUDGE)).T
        later = np.zeros((n, 6))
        later[:-1] = np.cumsum(by_shape[:0:-1], axis=0)[::-1]  # of all moves after each
        turning = matmul(se3.left_jacobian(apply(before, vectors.reshape(n, 2, 3))), before)
        by_vector = by_turn + apply(np.swapaxes(turning, -1, -2), later.reshape(n, 2, 3)).reshape(n, 6)
        return by_turns(self.motion.swimmer, self.motion.start, turn, by_vector.reshape(1, -1)).reshape(n, 6)

    def metric(self, turn: Array) -> Array:
        """Return the metric of dissipation in the middle of each move, by its joints' rates. Shape (n, 6, 6)."""
        n = len(turn)
        shapes, vectors = self._played(turn)
        middle = matmul(shapes[:-1], se3.rotation(0.5 * vectors.reshape(n, 2, 3)))
        pairs = [(i, j) for i in range(6) for j in range(i + 1)]
        rates = np.array([np.eye(6)[i] + (np.eye(6)[j] if i != j else 0.0) for i, j in pairs])
        base = apply(middle[None], np.broadcast_to(rates[:, None], (len(pairs), n, 6)).reshape(-1, n, 2, 3))
        axes = np.broadcast_to(middle[..., 0], (len(pairs), n, 2, 3))
        power = connection(self.numbers, axes.reshape(-1, 2, 3), base.reshape(-1, 2, 3)).power.reshape(-1, n)
        out = np.empty((n, 6, 6))
        for k, (i, j) in enumerate(pairs):
            if i == j:
                out[:, i, i] = power[k]
        for k, (i, j) in enumerate(pairs):
            if i != j:
                out[:, i, j] = out[:, j, i] = 0.5 * (power[k] - out[:, i, i] - out[:, j, j])
        if not has_universal(self.motion.swimmer):
            return out
        own = frames(self.motion.swimmer, self.motion.start, turn)
        return matmul(np.swapaxes(own, -1, -2), matmul(out, own))


class EnergyProgram:
    """The programs of least energy of one motion.

    Args:
        motion: The motion.
        total: The time it has at a joint rate of 1 rad/s [s].
    """

    def __init__(self, motion: Equations, total: float) -> None:
        self.motion = motion
        self.dissipation = Dissipation(motion, total)
        self.groups = groups(motion)
        walls, self._rows = [], []
        for group in self.groups:
            felt = np.flatnonzero(np.any(group.tie != 0.0, axis=1))
            sides, own = group.tie[felt], np.eye(group.tie.shape[1])
            walls.append(np.concatenate([sides, -sides, own, -own]))
            self._rows.append((felt // 6 + group.first, 6 * group.first + felt))
        linked = [group.tie.shape[1] for group in self.groups]
        self.walls = Blocks.of(walls, linked, np.zeros(sum(linked)))

    def cost(self, turn: Array) -> float:
        """Return the energy of turns (n, 6) [rad], for a lateral drag per length of 1 and a joint rate of 1 rad/s."""
        work = self.dissipation.work(turn)
        each = durations(work, turn, self.motion.cycles, self.dissipation.total)
        return float(np.add.reduce(self.motion.cycles * work / each))

    def step(self, here: Linearised, price: float, reach: float) -> tuple[Array, float] | None:
        """Return the change of the free angles that minimises the model of the energy, and what that promises.

        Args:
            here: The motion where it starts.
            price: What a violation costs [1 per L or rad].
            reach: The largest change of a free angle [rad]; one that moves the base more may change less.
        """
        cycles, values, turn = self.motion.cycles, here.values, here.values.turn
        lasting = durations(self.dissipation.work(turn), turn, cycles, self.dissipation.total)
        slope = self.motion.by_free_angles(self.dissipation.slope(turn, cycles / lasting).reshape(1, -1))[0]
        metric = (2.0 * cycles / lasting)[:, None, None] * self.dissipation.metric(turn)
        within, flat = reach * loose(values.derivative), turn.ravel()
        curves, bounds, first = [], [], 0
        for group, (moves, components) in zip(self.groups, self._rows, strict=True):
            n, f = group.moves, group.tie.shape[1]
            tie = group.tie.reshape(n, 6, f)
            own = matmul(np.swapaxes(tie, -1, -2), matmul(metric[group.first : group.first + n], tie))
            curves.append(np.add.reduce(own, axis=0).ravel())
            most, at, far = lasting[moves], flat[components], within[first : first + f]
            bounds += [most - at, most + at, far, far]
            first += f
        blocks = dataclasses.replace(self.walls, cost=slope, curve=np.concatenate(curves))
        rows = np.concatenate([values.derivative, -here.slope])
        wanted = np.concatenate([-values.residual, here.slack])
        energy = self.cost(turn)
        m, enough = len(values.residual), _ACCURATE * (1.0 + energy)
        bound, begun = np.concatenate(bounds), np.zeros(len(slope))
        change = least(blocks, bound, rows.T, wanted, m, price, begun, enough)
        if change is None:
            return None
        moved = self.motion.turned(change, np.zeros_like(turn))
        bent = 0.5 * float(np.add.reduce((moved * apply(metric, moved)).ravel()))
        missed = (rows * change).sum(axis=1) - wanted
        missed[m:] = np.maximum(missed[m:], 0.0)
        promised = energy + float(np.add.reduce(slope * change)) + bent
        return change, promised + price * float(np.add.reduce(np.abs(missed)))


def paced(motion: Equations, total: float) -> Array:
    """Return how long each move lasts for the least energy in a time, at a joint rate of 1 rad/s. Shape (n,)."""
    turn = np.concatenate([segment.turn for segment in motion.segments])
    found = durations(Dissipation(motion, total).work(turn), turn, motion.cycles, total)
    spent = math.fsum((motion.cycles * found).tolist())
    return found if spent <= total else np.max(np.abs(turn), axis=1)
