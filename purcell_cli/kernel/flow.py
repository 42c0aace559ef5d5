"""The local connection, the flow of the base and its derivatives, by the kernel: in units of L, per lateral drag."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.kernel.arrays import Array, Whole, address, doubles, wholes
from purcell_cli.kernel.beads import swimmer_numbers
from purcell_cli.kernel.library import KERNEL
from purcell_cli.kernel.shapes import control_numbers

_BLOCK = 500
"""Pieces a call: Ctrl-C waits for one call, some milliseconds."""
MOST_STAGES = 16
"""Collocation nodes in a step at most."""


@frozen_dataclass(eq=False)
class Rule:
    """How the flow is integrated.

    Attributes:
        nodes: Nodes on [0, 1]. Shape (m,).
        weights: Their weights. Shape (m,).
        to_node: Weights of the integral from 0 to each node. Shape (m, m).
        step: Largest step, as a fraction of the distance from the collinear shape.
        settled: The iteration for the orientations ends with a change by less.
    """

    nodes: Array
    weights: Array
    to_node: Array
    step: float
    settled: float

    def __post_init__(self) -> None:
        nodes = doubles(self.nodes, "nodes", (-1,))
        m = len(nodes)
        if not 1 <= m <= MOST_STAGES:
            raise ValueError(f"nodes: 1 to {MOST_STAGES} are wanted, found {m}")
        if not (self.step > 0.0 and self.settled > 0.0):
            raise ValueError(f"step and settled: positive numbers are wanted, found {self.step!r}, {self.settled!r}")
        object.__setattr__(self, "nodes", nodes)
        object.__setattr__(self, "weights", doubles(self.weights, "weights", (m,)))
        object.__setattr__(self, "to_node", doubles(self.to_node, "to_node", (m, m)))


class Flow:
    """The flow of one swimmer by one rule.

    Attributes:
        swimmer: Its numbers, in the order of `struct swimmer` in `kernel.h`. Shape (25 + the table's,).
        rule: How it is integrated.
        head: Where both stand, as the kernel's functions take them first.
    """

    def __init__(self, swimmer: ArrayLike, rule: Rule) -> None:
        self.swimmer, self.rule = swimmer_numbers(swimmer), rule
        m = len(rule.nodes)
        arrays = address(rule.nodes), address(rule.weights), address(rule.to_node)
        self.head = (address(self.swimmer), m, *arrays, float(rule.step), float(rule.settled))

    def pieces(self, shapes: ArrayLike, rates: ArrayLike, durations: ArrayLike) -> Array:
        """Return the displacements on pieces of constant limb rates.

        Args:
            shapes: Shapes where they begin. Shape (n, 2, 3, 3).
            rates: Limb rates (omega_1, omega_2). Shape (n, 6).
            durations: How long they last. Shape (n,).

        Returns:
            Displacements [L, rad]. Shape (n, 4, 4).

        Raises:
            ValueError: A piece is so long that it has more than two million steps.
        """
        return self._pieces(shapes, rates, durations, None)

    def runs(
        self, shapes: ArrayLike, rates: ArrayLike, durations: ArrayLike, counts: ArrayLike, cycles: ArrayLike
    ) -> Array:
        """Return the displacements of runs of pieces, each played a number of times; see `pieces`.

        Args:
            shapes: Shapes where the pieces begin. Shape (n, 2, 3, 3).
            rates: Limb rates. Shape (n, 6).
            durations: How long they last. Shape (n,).
            counts: How many pieces each run has, in order; n together. Shape (k,).
            cycles: How often each is played. Shape (k,).
        """
        count, cycle = wholes(counts, "counts", (-1,)), wholes(cycles, "cycles", (-1,))
        wide = np.empty((len(np.asarray(durations)), 24))
        self._pieces(shapes, rates, durations, wide)
        if len(count) != len(cycle) or np.any(count < 0) or np.any(cycle < 0) or int(np.sum(count)) != len(wide):
            raise ValueError("counts and cycles: as many, none negative, and all pieces counted once are wanted")
        out = np.empty((len(count), 4, 4))
        KERNEL.purcell_runs(address(wide), len(count), address(count), address(cycle), address(out))
        return out

    def _pieces(self, shapes: ArrayLike, rates: ArrayLike, durations: ArrayLike, wide: Array | None) -> Array:
        duration = doubles(durations, "durations", (-1,))
        n = len(duration)
        shape, rate = doubles(shapes, "shapes", (n, 2, 3, 3)), doubles(rates, "rates", (n, 6))
        out = np.empty((n, 4, 4))
        at = address(shape), address(rate), address(duration), address(out), 0 if wide is None else address(wide)
        sizes = (144, 48, 8, 128, 192)
        for low in range(0, n, _BLOCK):
            places = [start + low * size if start else None for start, size in zip(at, sizes, strict=True)]
            refuse(KERNEL.purcell_flow_of_pieces(*self.head, min(_BLOCK, n - low), *places), low)
        return out

    def work(self, shapes: ArrayLike, rates: ArrayLike, durations: ArrayLike, root: bool = False) -> Array:
        """Return the integral of the dissipated power over each piece, or of its root; see `pieces`. Shape (n,)."""
        duration = doubles(durations, "durations", (-1,))
        n = len(duration)
        shape, rate = doubles(shapes, "shapes", (n, 2, 3, 3)), doubles(rates, "rates", (n, 6))
        out = np.empty(n)
        at = address(shape), address(rate), address(duration)
        for low in range(0, n, _BLOCK):
            places = [start + low * size for start, size in zip(at, (144, 48, 8), strict=True)]
            many = min(_BLOCK, n - low)
            found = KERNEL.purcell_work_on_pieces(*self.head, many, *places, int(root), address(out) + 8 * low)
            refuse(found, low)
        return out

    def with_derivatives(
        self,
        shapes: ArrayLike,
        controls: ArrayLike | None,
        amounts: ArrayLike,
        repeats: Sequence[tuple[int, int, int]] = (),
    ) -> tuple[Array, Array]:
        """Return the displacement along pieces, and the body twists at the end per change of an angle.

        Args:
            shapes: Shapes before, between and after the pieces. Shape (n + 1, 2, 3, 3).
            controls: Which control each primitive turns, 6 and 7 about the base's z, shape (n,); None for moves. A limb
                that turns about the base's z may turn about its own y besides, and about no other axis.
            amounts: The primitives' angles, shape (n,), or the moves' rotation vectors, shape (n, 6) [rad].
            repeats: Parts played more than once, in order: first piece, the piece after the last, cycles.

        Returns:
            The displacement [L, rad], shape (4, 4), and derivatives, shape (6, n), or (6, n, 6) of moves.

        Raises:
            ValueError: A piece is so long that it has more than two million steps.
        """
        amount = doubles(amounts, "amounts", (-1,) if controls is not None else (-1, 6))
        n = len(amount)
        shape = doubles(shapes, "shapes", (n + 1, 2, 3, 3))
        control = control_numbers(controls, n)
        parts = repeats_of(repeats, n)
        pose, derivative = np.empty((4, 4)), np.empty((6, n) if control is not None else (6, n, 6))
        room = np.empty(94 * n + 36 * len(parts))
        places = address(shape), None if control is None else address(control), address(amount), len(parts)
        rest = address(parts), address(room), address(pose), address(derivative)
        refuse(KERNEL.purcell_flow_and_derivatives(*self.head, n, *places, *rest), 0)
        return pose, derivative

    def equations(
        self,
        start: ArrayLike,
        controls: ArrayLike,
        angles: ArrayLike,
        repeats: ArrayLike,
        wanted_inverse: ArrayLike,
        stops: ArrayLike,
        ends: ArrayLike,
    ) -> tuple[Array, Array, Array]:
        """Return the shapes along primitives, what is missing of a displacement and of shapes, and its derivative.

        Args:
            start: Shape before the first primitive. Shape (2, 3, 3).
            controls: Which control each turns, 6 and 7 about the base's z. Shape (n,).
            angles: By how much [rad]. Shape (n,).
            repeats: Parts played more than once; see `with_derivatives`. Shape (k, 3).
            wanted_inverse: The inverse of the displacement. Shape (4, 4).
            stops: The primitives before which shapes are wanted, n for the end. Shape (t,).
            ends: Those shapes. Shape (t, 2, 3, 3).

        Returns:
            Shapes before, between and after the primitives, shape (n + 1, 2, 3, 3); a twist and rotation vectors in
            base coordinates [L, rad], shape (6 + 6 t,); and the derivative, shape (6 + 6 t, n).

        Raises:
            ValueError: A piece is so long that it has more than two million steps.
        """
        angle = doubles(angles, "angles", (-1,))
        n = len(angle)
        control, parts, stop = control_numbers(controls, n), repeats_of(repeats, n), wholes(stops, "stops", (-1,))
        t = len(stop)
        begun, wanted = doubles(start, "start", (2, 3, 3)), doubles(wanted_inverse, "wanted_inverse", (4, 4))
        end = doubles(ends, "ends", (t, 2, 3, 3))
        if t and not 0 <= int(stop.min()) <= int(stop.max()) <= n:
            raise ValueError(f"stops: numbers from 0 to {n} are wanted")
        shapes, residual, derivative = np.empty((n + 1, 2, 3, 3)), np.empty(6 + 6 * t), np.empty((6 + 6 * t, n))
        room = np.empty(94 * n + 36 * len(parts))
        places = address(begun), address(control), address(angle), len(parts), address(parts), address(wanted), t
        rest = (address(part) for part in (stop, end, room, shapes, residual, derivative))
        refuse(KERNEL.purcell_equations(*self.head, n, *places, *rest), 0)
        return shapes, residual, derivative


def repeats_of(repeats: ArrayLike, n: int) -> Whole:
    """Return the parts of n pieces that are played more than once. Shape (k, 3).

    Raises:
        ValueError: They overlap, or are beyond the pieces.
    """
    parts = wholes(repeats, "repeats").reshape(-1, 3)
    if len(parts):
        edges = parts[:, :2].ravel()
        within = np.all(parts[:, 2] >= 1) and np.all(parts[:, 0] < parts[:, 1]) and np.all(np.diff(edges) >= 0)
        if not (within and edges[0] >= 0 and edges[-1] <= n):
            raise ValueError(f"repeats: parts in order, within {n} pieces, and at least one cycle are wanted")
    return parts


def refuse(number: int, before: int) -> None:
    """Refuse a piece that is too long, by its number, counted from 1 after those before; 0 is none.

    Raises:
        ValueError: There is one.
    """
    if number:
        raise ValueError(f"piece {before + number - 1}: it is too long, it would take more than two million steps")


class Connection(NamedTuple):
    """The base's motion at some shapes.

    Attributes:
        twist: The base's twist [L/s, rad/s]. Shape (n, 6).
        change: Its derivatives when limb i, with its rate, is turned about axis j of the base. Shape (n, 2, 3, 6).
        per_rate: The twists for a unit rate of limb i about axis j of the base. Shape (n, 2, 3, 6).
        power: The power of both joints' torques, for a lateral drag per length of 1. Shape (n,).
    """

    twist: Array
    change: Array
    per_rate: Array
    power: Array


def connection(swimmer: ArrayLike, axes: ArrayLike, rates: ArrayLike) -> Connection:
    """Return the base's motion for limb rates in base coordinates.

    Args:
        swimmer: See `Flow`.
        axes: The limbs' axes in base coordinates. Shape (n, 2, 3).
        rates: The limbs' rates in base coordinates [rad/s]. Shape (n, 2, 3).
    """
    numbers, axis = swimmer_numbers(swimmer), doubles(axes, "axes", (-1, 2, 3))
    n = len(axis)
    rate = doubles(rates, "rates", (n, 2, 3))
    out = Connection(np.empty((n, 6)), np.empty((n, 2, 3, 6)), np.empty((n, 2, 3, 6)), np.empty(n))
    KERNEL.purcell_connections(address(numbers), n, address(axis), address(rate), *(address(part) for part in out))
    return out


def played(here: Array, moves: ArrayLike, cycles: int) -> Array:
    """Return the poses before each of some displacements that are played over and over, in order.

    Args:
        here: Where the first begins, with twice the digits (see `with_twice_the_digits`); set to where the last ends.
        moves: Displacements. Shape (n, 4, 4).
        cycles: How often they are played.

    Returns:
        Poses. Shape (cycles, n, 4, 4).
    """
    move = doubles(moves, "moves", (-1, 4, 4))
    if here.shape != (3, 4, 2) or here.dtype != np.float64 or not here.flags.c_contiguous or not here.flags.writeable:
        raise ValueError(f"here: an array of shape (3, 4, 2) to write to is wanted, found {here.shape}")
    if cycles < 0:
        raise ValueError(f"cycles: a number that is not negative is wanted, found {cycles}")
    out = np.empty((cycles, len(move), 4, 4))
    KERNEL.purcell_played(address(here), len(move), address(move), cycles, address(out))
    return out


def with_twice_the_digits(pose: ArrayLike) -> Array:
    """Return a pose as sums of two numbers each. Shape (4, 4) to (3, 4, 2)."""
    out = np.zeros((3, 4, 2))
    out[..., 0] = doubles(pose, "pose", (4, 4))[:3]
    return out
