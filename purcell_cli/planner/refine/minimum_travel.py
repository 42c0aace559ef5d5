"""Minimum travel: sequential linear programming on the joint travel under the exact arrival.

The joint travel is a sum of absolute values, so its minimum is sparse: most angles are zero. Each
round inserts every control at every switch, at angle zero, and a linear program or a few within a trust
region choose which to use. Controls that stay at zero are dropped, equal neighbours are merged, and more
programs follow. An exact l1 penalty keeps the violations of the arrival and of the bend limit small;
`exact_arrival` removes the rest.

Method: Fletcher and de la Maza (1989), Math. Program. 43, sequential linear programming with an
exact l1 penalty and a second-order correction.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import normal_numbers
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.lift import ROUGH, SEARCHING
from purcell_cli.mechanics.primitives import PrimitiveSequence, joined
from purcell_cli.planner.refine.inequalities import ACTIVE, bend_limits, rows_besides
from purcell_cli.planner.refine.segments import Segment, free_primitives
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refine.trust_region import FIRST_REACH, LARGEST_REACH, LEAST_REACH

NAME = "refined strokes"
"""Name of strokes that have been optimised together."""
_DROPPED_RAD = 1e-6
"""Primitives of a smaller angle than this are dropped [rad]."""
_NEAR = 0.3
"""A search may begin at a point whose violations sum to less than this: linear programs bring it back [L, rad]."""
_ASTRAY = 0.02
"""A point that begins or ends with larger violations than this, after Newton steps, is given up [L, rad]."""
_FEWEST = 6
"""Linear programs in a round however long a motion is."""
_LITTLE = 0.999
"""A round that leaves more than this part of the joint travel is the last."""
_REACHES = FIRST_REACH, LARGEST_REACH, LEAST_REACH
"""The trust region's first radius, its largest and its least [rad]."""
_UNEVEN = (0.02, 0.002, 0.0)
"""Standard deviations of the relative changes of the first angles, in turn until the motion can be moved back to the
arrival; without any, a symmetric motion can be a saddle that no step leaves. Later rounds begin where one ended."""


@frozen_dataclass
class Pace:
    """How long a motion is optimised.

    Attributes:
        rounds: How often all controls are inserted anew.
        steps: Linear programs in a round, after those in which controls may enter.
        split: Into how many parts each primitive is cut for new controls to enter.
        price: Cost of a violation [rad per L or rad].
        longest: Motions of more free primitives than this are offered no more controls.
        work: The most linear programs in a round times free primitives: long motions take fewer and dearer ones.
        entering: Linear programs in which controls that are offered may enter, at the beginning of a round. Then what
            is still idle leaves, so that the others are small.
        worth: A program that promises to save less than this part of the joint travel is the last of its round.
        own: Whether each angle has a radius of the trust region of its own; see `Descent.shortened`.
    """

    rounds: int
    steps: int
    split: int = 1
    price: float = 500.0
    longest: int = 100
    work: float = math.inf
    entering: int = 2
    worth: float = 0.0
    own: bool = False


def _searched(
    equations: Equations, max_bend_rad: float, clearance: float, pace: Pace
) -> Callable[..., tuple[Array, float, float]]:
    """Return what searches for angles of less joint travel; see `Descent.shortened`."""
    least = bend_limits(equations, max_bend_rad)
    search = equations.descent(least, ACTIVE, *rows_besides(equations, clearance))

    def shortened(
        angle: Array, steps: int, close: float = math.inf, astray: float = math.inf
    ) -> tuple[Array, float, float]:
        until = close, astray, pace.worth, pace.own
        return search.shortened(angle, equations.weight, pace.price, steps, _REACHES, *until)

    return shortened


def offered(sequence: PrimitiveSequence, split: int, every: Sequence[int] = range(6)) -> PrimitiveSequence:
    """Return a sequence with every other control that there is offered, at angle zero, at every switch."""
    controls, angles = list(every), [0.0] * len(every)
    for control, angle in zip(sequence.control.tolist(), sequence.angle.tolist(), strict=True):
        for _ in range(split):
            controls += [control, *(c for c in every if c != control)]
            angles += [angle / split, *[0.0] * (len(every) - 1)]
    return PrimitiveSequence(np.array(controls), np.array(angles))


def offered_at(sequence: PrimitiveSequence, places: int, every: Sequence[int] = range(6)) -> PrimitiveSequence:
    """Return a sequence with every control that there is offered, at angle zero, at so many of its switches."""
    idle = PrimitiveSequence(np.array(every), np.zeros(len(every)))
    stops = [len(sequence) * k // places for k in range(places + 1)]
    parts = [[idle, sequence[low:high]] for low, high in itertools.pairwise(stops)]
    return joined(list(itertools.chain.from_iterable(parts)))


def offering(segments: Sequence[Segment], every: Sequence[int]) -> list[Segment]:
    """Return segments whose free strokes are offered every control that there is, see `offered`."""
    return [s.changed(lambda part: offered(part, 1, every)) if s.free else s for s in segments]


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
    found = equations.at_accuracy(ROUGH)
    for k in range(pace.rounds):
        there, violation = _round(_offering(found, pace), max_bend_rad, clearance, pace, (0.0,) if k else _UNEVEN)
        if violation > _ASTRAY:
            break
        before = found.joint_travel_rad
        # What is begun with may miss, and then is shorter; what a later round begins with arrives.
        found = min(found, there, key=lambda one: one.joint_travel_rad) if k else there
        if there.joint_travel_rad > _LITTLE * before:
            break
    return _arriving(found.at_accuracy(SEARCHING), max_bend_rad, pace, clearance).at_accuracy(equations.accuracy)


def _offering(equations: Equations, pace: Pace) -> Equations:
    """Return a motion with every control offered at every switch of its free strokes, unless it is too long."""
    if free_primitives(equations.segments) > pace.longest:
        return equations

    def every(sequence: PrimitiveSequence) -> PrimitiveSequence:
        return offered(sequence, pace.split, equations.controls)

    return equations.of([s.renamed(NAME, every(s.sequence)) if s.free else s for s in equations.segments])


def _round(
    equations: Equations, max_bend_rad: float, clearance: float, pace: Pace, uneven: Sequence[float]
) -> tuple[Equations, float]:
    """Return a motion after a round, and the sum of its violations; see `_shortened`."""
    there, _ = _shortened(equations, max_bend_rad, clearance, pace, pace.entering, uneven)
    return _shortened(there, max_bend_rad, clearance, pace, pace.steps, (0.0,))


def _shortened(
    equations: Equations, max_bend_rad: float, clearance: float, pace: Pace, programs: int, uneven: Sequence[float]
) -> tuple[Equations, float]:
    """Return a motion after some linear programs, what is idle by then left out, and the sum of its violations.

    Args:
        equations: The motion.
        max_bend_rad: How far a limb may bend in phase 2 [rad].
        clearance: How far the limbs stay apart in phases 1 and 3 [L].
        pace: What else is asked.
        programs: The most programs.
        uneven: By how much the angles are changed at first, in turn until that can be moved back; see `_UNEVEN`.
    """
    steps = int(min(programs, max(pace.work // max(free_primitives(equations.segments), 1), _FEWEST)))
    search, rng = _searched(equations, max_bend_rad, clearance, pace), np.random.default_rng(0)
    for part in uneven:
        angle, begun, violation = search(
            _uneven(equations.angles, part, rng), steps, _NEAR, _ASTRAY if part else math.inf
        )
        if begun < math.inf:
            break
    parts = [s.renamed(NAME, merged(s.sequence)) if s.free else s for s in equations.with_angles(angle)]
    return equations.of(parts), violation


def _arriving(equations: Equations, max_bend_rad: float, pace: Pace, clearance: float) -> Equations:
    """Return a motion, shortened on a rough flow, moved back to the arrival."""
    angle, _, _ = _searched(equations, max_bend_rad, clearance, pace)(equations.angles, 0, 0.0)
    return equations.of(equations.with_angles(angle))


def tightened(equations: Equations, max_bend_rad: float, pace: Pace, clearance: float = 0.0) -> Equations:
    """Return a motion by its own controls at angles of less joint travel, for a first look: none is inserted."""
    return _round(equations, max_bend_rad, clearance, pace, (0.0,))[0]
