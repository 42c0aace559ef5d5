"""Minimum travel: sequential linear programming on the joint travel under the exact arrival.

The joint travel is a sum of absolute values, so its minimum is sparse: most angles are zero. Each
round inserts every control at every switch, at angle zero, and linear programs within a trust region
choose which to use. Controls that stay at zero are dropped, and equal neighbours are merged. An exact
l1 penalty keeps the violations of the arrival and of the bend limit small; `exact_arrival` removes
the rest.

Method: Fletcher and de la Maza (1989), Math. Program. 43, sequential linear programming with an
exact l1 penalty and a second-order correction.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from purcell_cli.geometry.reproducible import matmul, normal_numbers
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.program import penalised
from purcell_cli.mechanics.lift import ROUGH, SEARCHING
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.planner.refine.active_set import bounded_step, loose
from purcell_cli.planner.refine.inequalities import bend_rows, clearance_rows, least_cosines, least_distances
from purcell_cli.planner.refine.shooting import Equations, Values
from purcell_cli.planner.refine.trust_region import descended

NAME = "refined strokes"
"""Name of strokes that have been optimised together."""
_DROPPED_RAD = 1e-6
"""Primitives of a smaller angle than this are dropped [rad]."""
_WORTH_RAD = 1e-5
"""A linear program that promises to save less joint travel than this is the last [rad]."""
_RESTORING = 8
"""The most Newton steps that move a point back to the arrival."""
_RESTORED = 1e-4
"""A point whose residuals and broken limits sum to less than this is at the arrival [L, rad]."""
_REACH_RAD = 0.25
"""The least reach of those Newton steps: the largest change of an angle in one [rad]."""
_NEAR = 0.3
"""A search may begin at a point whose violations sum to less than this: linear programs bring it back [L, rad]."""
_ASTRAY = 0.02
"""A point that begins or ends with larger violations than this, after Newton steps, is given up [L, rad]."""
_UNEVEN = (0.02, 0.002, 0.0)
"""Standard deviations of the relative changes of the first angles, in turn until the motion can be moved back to the
arrival; without any, a symmetric motion can be a saddle that no step leaves."""


@dataclasses.dataclass(frozen=True, slots=True)
class Pace:
    """How long a motion is optimised.

    Attributes:
        rounds: How often all controls are inserted anew.
        steps: Linear programs in a round.
        split: Into how many parts each primitive is cut for new controls to enter.
        price: Cost of a violation [rad per L or rad].
        longest: Motions of more free primitives than this are offered no more controls.
    """

    rounds: int
    steps: int
    split: int = 1
    price: float = 500.0
    longest: int = 100


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class _Point:
    """A point of the search: free angles, the equations there, the room below the limits, violation and merit."""

    angle: Array
    values: Values
    room: Array
    room_derivative: Array
    violation: float
    merit: float


class _Search:
    def __init__(self, equations: Equations, max_bend_rad: float, clearance: float, price: float) -> None:
        self.equations, self.price = equations, price
        self.least = least_cosines(equations.phase, equations.start, equations.goal, max_bend_rad, equations.home)
        self.apart = least_distances(equations, clearance)

    def point(self, angle: Array) -> _Point:
        values = self.equations.at(angle)
        motion = self.equations, values.sequence, values.shapes
        rows = bend_rows(*motion, self.least), clearance_rows(*motion, self.apart)
        room, slope = (np.concatenate(part) for part in zip(*rows, strict=True))
        violation = float(np.sum(np.abs(values.residual)) - np.sum(np.minimum(room, 0.0)))
        merit = float(matmul(self.equations.weight, np.abs(angle))) + self.price * violation
        return _Point(angle, values, room, slope, violation, merit)

    def step(self, here: _Point, reach: float) -> tuple[Array, float] | None:
        """Return the angles that minimise the linearised merit within reach, and that merit."""
        angle, residual = here.angle, here.values.residual
        within = reach * loose(here.values.derivative)
        slope = np.concatenate([here.values.derivative, -here.room_derivative])
        wanted = matmul(slope, angle) - np.concatenate([residual, -here.room])
        bounds = angle - within, angle + within
        return penalised(self.equations.weight, slope, wanted, len(residual), self.price, *bounds, angle)

    def restored(self, here: _Point, reach: float) -> _Point:
        """Return a point moved back to the arrival and within the bend limit by the angles in use."""
        used = np.abs(here.angle) > 1e-9
        if not np.any(used):
            return here
        for _ in range(_RESTORING):
            if here.violation < _RESTORED:
                break
            move = np.zeros_like(here.angle)
            values, slope = here.values, here.room_derivative[:, used]
            move[used] = bounded_step(values.derivative[:, used], values.residual, here.room, slope, reach)
            there = self.point(here.angle + move)
            if there.violation > 0.9 * here.violation:
                break
            here = there
        return here

    def landed(self, here: _Point, angle: Array, promised: float, reach: float) -> _Point:
        """Return the point at some angles, moved back to the arrival if it keeps less than half of its promise."""
        there = self.point(angle)
        if here.merit - there.merit < 0.5 * promised:
            there = self.restored(there, max(reach, _REACH_RAD))
        return there

    def run(self, begun: _Point, steps: int) -> _Point:
        return descended(begun, self.step, self.landed, steps, lambda _: _WORTH_RAD)


def offered(sequence: PrimitiveSequence, split: int, every: Sequence[int] = range(6)) -> PrimitiveSequence:
    """Return a sequence with every other control that there is offered, at angle zero, at every switch."""
    controls, angles = list(every), [0.0] * len(every)
    for control, angle in zip(sequence.control.tolist(), sequence.angle.tolist(), strict=True):
        for _ in range(split):
            controls += [control, *(c for c in every if c != control)]
            angles += [angle / split, *[0.0] * (len(every) - 1)]
    return PrimitiveSequence(np.array(controls), np.array(angles))


def merged(sequence: PrimitiveSequence) -> PrimitiveSequence:
    """Return a sequence without idle primitives, neighbours of one control made one."""
    controls: list[int] = []
    angles: list[float] = []
    for control, angle in zip(sequence.control.tolist(), sequence.angle.tolist(), strict=True):
        if abs(angle) < _DROPPED_RAD:
            continue
        if controls and controls[-1] == control:
            angles[-1] += angle
        else:
            controls.append(control)
            angles.append(angle)
    return PrimitiveSequence(np.array(controls, dtype=np.int64), np.array(angles))


def _uneven(angle: Array, part: float, rng: np.random.Generator) -> Array:
    """Return angles a little off, since a symmetric motion can be a saddle that no step leaves."""
    return np.asarray(angle * (1.0 + part * normal_numbers(rng, (len(angle),))))


def minimise_travel(equations: Equations, max_bend_rad: float, pace: Pace, clearance: float = 0.0) -> Equations:
    """Return the equations of a motion of less joint travel that still arrives, almost exactly.

    Args:
        equations: The equations of the motion to begin with.
        max_bend_rad: How far a limb may bend in phase 2 [rad].
        pace: How long to go on.
        clearance: How far the limbs stay apart in phases 1 and 3 [L].
    """
    found, rng = equations.at_accuracy(ROUGH), np.random.default_rng(0)
    for _ in range(pace.rounds):
        parts = found.segments
        if sum(len(s.sequence) for s in parts if s.free) <= pace.longest:
            parts = tuple(
                s.renamed(NAME, offered(s.sequence, pace.split, found.controls)) if s.free else s for s in parts
            )
        tried = found.of(parts)
        search = _Search(tried, max_bend_rad, clearance, pace.price)
        for uneven in _UNEVEN:
            begun = search.point(_uneven(tried.angles, uneven, rng))
            if begun.violation < _NEAR:
                break
            begun = search.restored(begun, _REACH_RAD)
            if begun.violation < _ASTRAY:
                break
        ended = search.run(begun, pace.steps)
        if ended.violation > _ASTRAY:
            break
        shorter = [s.renamed(NAME, merged(s.sequence)) if s.free else s for s in tried.with_angles(ended.angle)]
        before, found = found.joint_travel_rad, found.of(shorter)
        if found.joint_travel_rad > 0.999 * before:
            break
    return _arriving(found.at_accuracy(SEARCHING), max_bend_rad, pace, clearance).at_accuracy(equations.accuracy)


def _arriving(equations: Equations, max_bend_rad: float, pace: Pace, clearance: float) -> Equations:
    """Return a motion, shortened on a rough flow, moved back to the arrival."""
    search = _Search(equations, max_bend_rad, clearance, pace.price)
    begun = search.point(equations.angles)
    ended = search.restored(begun, _REACH_RAD)
    return equations if ended is begun else equations.of(equations.with_angles(ended.angle))


def tightened(equations: Equations, max_bend_rad: float, pace: Pace, clearance: float = 0.0) -> Equations:
    """Return the same primitives at angles of less joint travel, for a first look: no control is inserted."""
    search = _Search(equations, max_bend_rad, clearance, pace.price)
    return equations.of(equations.with_angles(search.run(search.point(equations.angles), pace.steps).angle))
