"""The convex program of a step in minimum time or minimum travel, for a motion by moves.

A move lasts as long as the joint that turns furthest, and its joint travel is a sum of absolute values. So with a
bound on each component and one on the largest of a move both are linear. The free angles of a move, or of a loop
that repeats, are in a block of their own; the arrival and the bend limit tie the blocks.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import cos
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.convex import Blocks, least
from purcell_cli.planner.refine.inequalities import Linearised
from purcell_cli.planner.refine.segments import AT_ONCE
from purcell_cli.planner.refine.shooting import Equations

Rows = NDArray[np.int64]

_ACCURATE = 1e-5
"""Accuracy of a program, as a part of what the motion costs."""
_NEAR = 4.0
"""Bends with less slack than this times the reach are in a program from the first, in the cosine of the bend, as a
part of the limit's [1 per rad]."""
_MORE = 4
"""The most programs of a step: each has the bends that the one before breaks."""


@frozen_dataclass
class Weights:
    """What a motion by moves costs.

    Attributes:
        time: Cost of a second, at a joint rate of 1 rad/s.
        travel: Cost of a radian of joint travel.
        rates: How fast limbs turn, in units of the joint rate; as fast as that where not given. Shape (6,).
    """

    time: float
    travel: float
    rates: Array | None = None

    def durations(self, turn: Array) -> Array:
        """Return how long moves last at a joint rate of 1 rad/s. Shape (n, 6) to (n,)."""
        size = np.abs(turn)
        return np.asarray(np.max(size if self.rates is None else size / self.rates, axis=1))

    def cost(self, turn: Array, cycles: Array) -> float:
        """Return what moves cost.

        Args:
            turn: Their rotation vectors [rad]. Shape (n, 6).
            cycles: How often each is played. Shape (n,).
        """
        size = np.abs(turn)
        each = self.time * self.durations(turn) + self.travel * np.add.reduce(size, axis=1)
        return float(np.add.reduce(cycles * each))


@frozen_dataclass(eq=False)
class Group:
    """The moves that share free angles: where they begin, and how their turns depend on those. Shape (6 n, f)."""

    first: int
    moves: int
    tie: Array


def groups(motion: Equations) -> list[Group]:
    """Return a motion's moves in groups, in the order of its free angles."""
    out: list[Group] = []
    first = 0
    for segment in motion.segments:
        n, tie = segment.pieces, segment.tie
        if tie is None or len(tie) == AT_ONCE:
            axes = np.eye(AT_ONCE) if tie is None else tie
            out += [Group(first + k, 1, axes) for k in range(n)]
        else:
            out.append(Group(first, n, tie))
        first += n
    return [group for group in out if group.tie.shape[1]]


def _walls(group: Group, weights: Weights) -> tuple[Rows, Array]:
    """Return the components that a group's turns have, and the walls of its variables, see `MoveProgram`."""
    tie = group.tie
    felt = np.flatnonzero(np.any(tie != 0.0, axis=1))
    n, c, f = group.moves, len(felt), tie.shape[1]
    wall = np.zeros((3 * c + 2 * f, n + c + f))
    row, change = np.arange(c), slice(n + c, None)
    for low, sign in ((0, 1.0), (c, -1.0)):
        wall[low + row, n + row] = -1.0
        wall[low : low + c, change] = sign * tie[felt]
    wall[2 * c + row, n + row] = 1.0
    wall[2 * c + row, felt // 6] = -1.0 if weights.rates is None else -weights.rates[felt % 6]
    wall[3 * c : 3 * c + f, change] = np.eye(f)
    wall[3 * c + f :, change] = -np.eye(f)
    return felt, wall


class MoveProgram:
    """The programs of one motion, for any turns and any reach.

    The variables of a block are the durations of its moves, the sizes of its turns' components and the changes of its
    free angles.

    Args:
        motion: The motion.
        weights: What is to be least.
    """

    def __init__(self, motion: Equations, weights: Weights) -> None:
        cost: list[float] = []
        walls: list[Array] = []
        linked: list[int] = []
        kinds: list[tuple[int, int, int]] = []  # of a wall: its sign, the component it is about, whether it is a reach
        ours: list[tuple[int, int]] = []  # of a variable: its move, or its component beyond all moves, or neither
        known: dict[tuple[int, int], tuple[Rows, Array]] = {}  # moves with the same axes have the same walls
        for group in groups(motion):
            key = id(group.tie), group.moves
            if key not in known:
                known[key] = _walls(group, weights)
            felt, wall = known[key]
            n, c, f = group.moves, len(felt), group.tie.shape[1]
            component = 6 * group.first + felt
            kinds += [(-1, int(k), 0) for k in component] + [(1, int(k), 0) for k in component]
            kinds += [(0, 0, 0)] * c + [(0, 0, 1)] * (2 * f)
            ours += [(group.first + k, -1) for k in range(n)] + [(-1, int(k)) for k in component] + [(-1, -1)] * f
            played = float(motion.cycles[group.first])
            cost += [weights.time * played] * n + [weights.travel * played] * c + [0.0] * f
            linked.append(f)
            walls.append(wall)
        self.motion, self.weights = motion, weights
        self._deepest = 1.0 - cos(motion.swimmer.max_bend_rad)
        self._share = min(1.0, motion.swimmer.max_bend_rad)
        self.blocks = Blocks.of(walls, linked, cost)
        self._sign, self._component, self._reach = np.array(kinds).T
        self._move, self._size = np.array(ours).T

    def cost(self, turn: Array) -> float:
        """Return what the motion costs by some turns of joints [rad]. Shape (k, 6)."""
        return self.weights.cost(turn, self.motion.cycles)

    def step(self, here: Linearised, price: float, reach: float) -> tuple[Array, float] | None:
        """Return the change of the free angles that costs least, within reach, and what the motion then costs.

        Args:
            here: The motion where it starts.
            price: What a violation costs [1 per L or rad].
            reach: The largest change of a free angle [rad], at a bend limit of 1 rad or more; less in proportion below.
        """
        reach, values = reach * self._share, here.values
        turn = values.turn.ravel()
        bound = self._sign * turn[self._component] + self._reach * reach
        margin = 0.5 * reach
        slowest = 1.0 if self.weights.rates is None else float(np.min(self.weights.rates))
        longest = self.weights.durations(values.turn)
        begun = np.where(self._move >= 0, longest[self._move] + 2.0 * margin / slowest, 0.0)
        begun = np.where(self._size >= 0, np.abs(turn[self._size]) + margin, begun)
        enough = _ACCURATE * (1.0 + self.weights.cost(values.turn, self.motion.cycles))
        m, near = len(values.residual), here.slack < _NEAR * reach * self._deepest
        for _ in range(_MORE):
            slope = np.concatenate([values.derivative, -here.slope[near]])
            wanted = np.concatenate([-values.residual, here.slack[near]])
            found = least(self.blocks, bound, slope.T, wanted, m, price, begun, enough)
            if found is None:
                return None
            change = found[(self._move < 0) & (self._size < 0)]
            slack = here.slack + (here.slope * change).sum(axis=1)
            broken = (slack < 0.0) & ~near
            if not np.any(broken):
                break
            near = near | broken
        cost = self.weights.cost(self.motion.turned(change, values.turn), self.motion.cycles)
        missed = np.abs((values.derivative * change).sum(axis=1) + values.residual)
        return change, cost + price * (float(np.add.reduce(missed)) - float(np.add.reduce(np.minimum(slack, 0.0))))
