"""Loops: the displacements of the planner's square strokes, tabulated for a swimmer.

A stroke goes from the collinear shape to a corner of a square of both yaw joints, round the square n
times, and back. With an offset, limb 1 bent by c and limb 2 by -c, it swims an arc. An offset in the
plane of the loop moves the square's centre, and shares the bend limit with the half side. An offset across
that plane is a pitch; a limb's bend is then arccos(cos c cos yaw), so both may be larger.

Seen from the collinear shape one cycle has the displacement exp(L), the ways there and back together
exp(U), and the stroke exp(n L) exp(U). L and U are tabulated once as Chebyshev series in the loop's
largest bend and in the part of it that is offset. Every arc then has a closed form.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import functools
import itertools

import numpy as np
from numpy.polynomial import chebyshev

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.linear_systems import inverse as inverted
from purcell_cli.geometry.reproducible import arccos, arcsin, arctan, arctan2, cos, matmul, sin, tan
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.chains import LoopTable
from purcell_cli.mechanics.collocation import Accuracy
from purcell_cli.mechanics.lift import piece_work
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limits import BEND_MARGIN_RAD
from purcell_cli.planner.prepared import run_displacements_kept

NAME = "arc"
"""Name of the stroke."""

_PITCH_1, _YAW_1, _PITCH_2, _YAW_2 = 1, 2, 4, 5
"""Indices of the controls, of 0 to 5, by which the limbs pitch and yaw."""
_ACROSS_BEND_RAD = 1.5
"""The largest bend of loops with an offset across their plane, whatever the bend limit [rad]."""
_LEAST_OFFSET_SHARE = {False: 0.0, True: 4e-4}
"""The least offset share over the largest, by `across`; positive across, since A(r) is sharp near zero."""
_POWER = {False: 1, True: 2}
"""The root of the offset share that is the series' second variable, by `across`; 2 adds nodes where A(r) is sharp."""
_TABLED = Accuracy(stages=3, step=0.8, settled=1e-7)
"""Accuracy of the flow in the table: errors of 1e-5 (L, rad), less than those of the series."""
_LEAST_BEND = 0.2
"""The smallest loops in the table, in units of the bend limit."""
_MOST_OFFSET_SHARE = {False: 0.775, True: 0.95}
"""The largest offset share, by `across`: c over the bend in the plane, and across it an angle on the sphere [rad]."""
_TERMS = {False: (8, 8), True: (8, 16)}
"""Numbers of Chebyshev terms in the bend and in the offset share, by `across`."""
_SQUARE = ((_YAW_1, 2.0, 0.0), (_YAW_2, -2.0, 0.0), (_YAW_1, -2.0, 0.0), (_YAW_2, 2.0, 0.0))
"""One cycle of a loop: controls, and their angles per half side and per offset."""
_STROKES = {
    False: (
        ((_YAW_1, -0.5, 0.5), (_YAW_2, 1.0, -1.0), (_YAW_1, -0.5, 0.5)),
        _SQUARE,
        ((_YAW_1, 0.5, -0.5), (_YAW_2, -1.0, 1.0), (_YAW_1, 0.5, -0.5)),
    ),
    True: (
        ((_PITCH_1, 0.0, 1.0), (_PITCH_2, 0.0, -1.0), (_YAW_1, -1.0, 0.0), (_YAW_2, 1.0, 0.0)),
        _SQUARE,
        ((_YAW_1, 1.0, 0.0), (_YAW_2, -1.0, 0.0), (_PITCH_2, 0.0, 1.0), (_PITCH_1, 0.0, -1.0)),
    ),
}
"""The way to a loop's corner, the loop, and the way back: controls, and their angles per half side and per offset.

With an offset across the plane the way back is not the way there: together they go round a square of the side
`half_side`, the same way round as the loop. In the plane, the way there moves limb 1 half way, limb 2, and limb 1
again, which hardly turns the base.
"""


def stroke(
    half_side: float, offset: float, across: bool
) -> tuple[PrimitiveSequence, PrimitiveSequence, PrimitiveSequence]:
    """Return the way to a loop's corner, the loop, and the way back [rad].

    Args:
        half_side: Half the square's side [rad].
        offset: How far limb 1 is bent aside, and limb 2 the other way [rad].
        across: Whether they are bent aside across the loop's plane.
    """
    parts = [
        PrimitiveSequence.of((c, half_side * p + offset * q) for c, p, q in part).busy() for part in _STROKES[across]
    ]
    return parts[0], parts[1], parts[2]


@frozen_dataclass(eq=False)
class LoopValues:
    """The twists of loops, and on the first axis their derivatives by the bend and by the offset share.

    Attributes:
        cycle: Twists L of one cycle [L, rad]. Shape (3, n, 6).
        ways: Twists U of the ways there and back together [L, rad]. Shape (3, n, 6).
    """

    cycle: Array
    ways: Array


class Loops:
    """The loops of one scaled swimmer, bent aside in the plane or across it.

    Attributes:
        across: Which of the two.
        least_rad: The least of the largest bends in the table [rad].
        most_rad: The greatest [rad].
        least_offset_share: The least offset share in the table.
        most_offset_share: The greatest.
        measure: What costs are.
        even: Whether the swimmer is alike end for end, so that the base's middle swims along circles.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        measure: One of `objectives.MEASURES`: what costs are.
        across: Whether the limbs are bent aside across the loops' plane, or in it.
    """

    def __init__(self, swimmer: Swimmer, measure: str, across: bool) -> None:
        self.across, self.even = across, swimmer.equal_limbs
        limit = swimmer.max_bend_rad - BEND_MARGIN_RAD
        self.most_rad = min(limit, _ACROSS_BEND_RAD) if across else limit
        self.least_rad, self.most_offset_share = _LEAST_BEND * self.most_rad, _MOST_OFFSET_SHARE[across]
        self.least_offset_share, self._power = _LEAST_OFFSET_SHARE[across] * self.most_offset_share, _POWER[across]
        self._terms = _TERMS[across]
        x, y = (chebyshev.chebpts1(k) for k in self._terms)
        bend = self.least_rad + 0.5 * (x + 1.0) * (self.most_rad - self.least_rad)
        offset_share = (0.5 * (y + 1.0)) ** self._power * self.most_offset_share
        grid = (part.ravel() for part in np.meshgrid(bend, offset_share, indexing="ij"))
        self.measure = measure
        values = _values(swimmer, *self.sides(*grid), across, measure).reshape(*self._terms, -1)
        inverse = [inverted(chebyshev.chebvander(nodes, len(nodes) - 1)) for nodes in (x, y)]
        series = matmul(inverse[1], matmul(inverse[0], values.reshape(len(x), -1)).reshape(len(x), *values.shape[1:]))
        slopes = [np.zeros_like(series), np.zeros_like(series)]
        slopes[0][:-1] = chebyshev.chebder(series, axis=0) * 2.0 / (self.most_rad - self.least_rad)
        slopes[1][:, :-1] = chebyshev.chebder(series, axis=1)
        self._series = np.stack([series, *slopes]).reshape(3, -1, series.shape[-1])

    def table(self, unit: float) -> LoopTable:
        """Return the loops as the kernel takes them, with costs in a unit."""
        bounds = self.least_rad, self.most_rad, self.least_offset_share, self.most_offset_share
        shape = *self._terms, self._series.shape[-1]
        return LoopTable(np.array([*bounds, self._power, self.across, unit, *shape], dtype=np.float64), self._series)

    def sides(self, bend: Array, offset_share: Array) -> tuple[Array, Array]:
        """Return the half sides and offsets of loops [rad]. Shapes (n,)."""
        if not self.across:
            return bend * (1.0 - offset_share), bend * offset_share
        return arctan(tan(bend) * cos(offset_share)), arcsin(sin(bend) * sin(offset_share))

    def place(self, half_side: Array, offset: Array) -> tuple[Array, Array]:
        """Return the largest bends of loops of such half sides and offsets, and their offset shares. Shapes (n,)."""
        if not self.across:
            return half_side + offset, offset / (half_side + offset)
        bend = arccos(cos(half_side) * cos(offset))
        return bend, arctan2(sin(offset), cos(offset) * sin(half_side))

    def clipped(self, bend: Array, offset_share: Array) -> tuple[Array, Array]:
        """Return bends and offset shares within the table. Shapes (n,)."""
        return np.clip(bend, self.least_rad, self.most_rad), np.clip(
            offset_share, self.least_offset_share, self.most_offset_share
        )

    def at(self, bend: Array, offset_share: Array) -> LoopValues:
        """Return what loops do. Shapes (n,)."""
        found = self._summed(bend, offset_share)
        return LoopValues(found[..., :6], found[..., 6:12])

    def costs(self, bend: Array, offset_share: Array) -> tuple[Array, Array]:
        """Return what a cycle costs, and the ways there and back together, as `objectives` has it. Shapes (n,)."""
        if self.measure == "energy":
            found = self._summed(bend, offset_share)[0]
            return found[:, 12], found[:, 13]
        if self.measure == "switches":
            return np.full(len(bend), 4.0), np.full(len(bend), 8.0 if self.across else 6.0)
        half_side, offset = self.sides(bend, offset_share)
        return 8.0 * half_side, 4.0 * (half_side + offset if self.across else np.abs(half_side - offset))

    def _summed(self, bend: Array, offset_share: Array) -> Array:
        """Return the series and their slopes. Shape (3, n, k)."""
        x = 2.0 * (bend - self.least_rad) / (self.most_rad - self.least_rad) - 1.0
        root = (np.maximum(offset_share, self.least_offset_share) / self.most_offset_share) ** (1.0 / self._power)
        y = 2.0 * root - 1.0
        row, column = (chebyshev.chebvander(v, k - 1) for v, k in zip((x, y), self._terms, strict=True))
        weight = (row[:, :, None] * column[:, None, :]).reshape(len(bend), self._series.shape[1])
        found = matmul(weight, self._series)
        found[2] *= 2.0 / (self._power * self.most_offset_share * root ** (self._power - 1))[:, None]
        return np.asarray(found)


def _values(swimmer: Swimmer, half_sides: Array, offsets: Array, across: bool, measure: str) -> Array:
    """Return L and U, and with energy as the measure what they cost. Shape (n, 12) or (n, 14)."""
    counts = np.tile([len(part) for part in _STROKES[across]], len(half_sides))
    control, *share = (np.array(column) for column in zip(*itertools.chain(*_STROKES[across]), strict=True))
    angle = half_sides[:, None] * share[0] + offsets[:, None] * share[1]
    every = PrimitiveSequence(np.tile(control, len(half_sides)), angle.ravel())
    pieces = Pieces.of(every)
    table = f"loops-{'across' if across else 'in-plane'}"
    moves = run_displacements_kept(table, swimmer, pieces, counts, _TABLED).reshape(-1, 3, 4, 4)
    cycle = (matmul(se3.adjoint(moves[:, 0]), se3.log(moves[:, 1])[..., None]))[..., 0]
    columns = [cycle, se3.log(se3.normalised(matmul(moves[:, 0], moves[:, 2])))]
    if measure == "energy":
        first = np.cumsum(counts) - counts
        paid = np.add.reduceat(piece_work(swimmer, pieces), first).reshape(-1, 3)
        columns += [paid[:, 1:2], paid[:, :1] + paid[:, 2:]]
    return np.concatenate(columns, axis=1)


@functools.lru_cache(maxsize=128)
def loops(swimmer: Swimmer, measure: str, across: bool) -> Loops:
    """Return the loops of a scaled swimmer for a measure, made once."""
    return Loops(swimmer, measure, across)
