"""Searches for the free angles of a motion, step by step in Python: what the kernel's are compared with."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.shooting import bounded_step
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.planner.refine.active_set import loose
from purcell_cli.planner.refine.inequalities import ACTIVE, least_cosines, least_distances, limit_rows
from purcell_cli.planner.refine.shooting import Equations, Values
from purcell_cli.planner.refine.trust_region import descended
from reference.clearance_slack import numbered_clearance_slack
from reference.program import penalised
from reference.shooting import numbered_bend_rows

TURNING, IDLE, PASSING = range(3)
"""Kinds of rows: of a primitive that turns; of one at angle zero; of such a one before another of the same row."""


def kinds(sequence: PrimitiveSequence, of: NDArray[np.int64], alike: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the kinds of rows of primitives; rows are the same while angles are zero where `alike` is."""
    turns = sequence.angle != 0.0
    runs, out = np.cumsum(turns), np.where(turns[of], TURNING, IDLE)
    idle = [(run, same) if not turn else None for run, same, turn in zip(runs[of], alike, turns[of], strict=True)]
    for k, here in enumerate(idle):
        if here is not None and here in idle[k + 1 :]:
            out[k] = PASSING
    return out


@dataclasses.dataclass(frozen=True)
class Point:
    """Free angles, the equations there, the slack of the limits and of what kinds that is, violation and merit."""

    angle: Array
    values: Values
    slack: Array
    slope: Array
    kind: NDArray[np.int64]
    violation: float
    merit: float


class Search:
    """A search for angles of less joint travel; see `Descent.shortened`."""

    def __init__(
        self, equations: Equations, max_bend_rad: float, clearance: float, price: float, own: bool = False
    ) -> None:
        self.equations, self.price = equations, price
        self.least = least_cosines(equations.phase, equations.start, equations.goal, max_bend_rad, equations.home)
        self.apart = least_distances(equations, clearance)
        self.share, self.change = np.ones(len(equations.angles)), np.zeros(len(equations.angles))
        self.own = own
        self.before: Point | None = None

    def point(self, angle: Array) -> Point:
        values = self.equations.at(angle)
        sequence, shapes, swimmer = values.sequence, values.shapes, self.equations.swimmer
        bends, *bent = numbered_bend_rows(sequence, shapes, self.least, self.equations.fixed, ACTIVE)
        gaps, *near = numbered_clearance_slack(swimmer, sequence, shapes, self.apart, 0.25)
        slack, slope = (np.concatenate(part) for part in zip(bent, near, strict=True))
        alike = sequence.limb[bends], np.zeros(len(gaps), dtype=np.int64)
        kind = np.concatenate([kinds(sequence, *rows) for rows in zip((bends, gaps), alike, strict=True)])
        broken = np.minimum(slack[kind == TURNING], 0.0)
        violation = float(np.sum(np.abs(values.residual)) - np.sum(broken))
        merit = self.equations.weight @ np.abs(angle) + self.price * violation
        return Point(angle, values, slack, self.equations.by_free_angles(slope), kind, violation, merit)

    def step(self, here: Point, reach: float) -> tuple[Array, float] | None:
        if self.own and self.before is not None and here is not self.before:
            change = here.angle - self.before.angle
            along = change * self.change
            self.share[(along < 0.0) & (self.share > 0.1 / 0.7)] *= 0.7
            self.share[(along > 0.0) & (self.share < 4.0 / 1.2)] *= 1.2
            self.change = np.where(change != 0.0, change, self.change)
        self.before = here
        within = self.share * reach * loose(here.values.derivative)
        rows = here.kind != PASSING
        slope = np.concatenate([here.values.derivative, -here.slope[rows]])
        wanted = slope @ here.angle - np.concatenate([here.values.residual, -here.slack[rows]])
        bounds = here.angle - within, here.angle + within
        many = len(here.values.residual)
        found = penalised(self.equations.weight, slope, wanted, many, self.price, *bounds, here.angle)
        if found is None:
            return None
        missed = slope @ found[0] - wanted
        counted = here.kind[rows] == TURNING
        missed = np.sum(np.abs(missed[:many])) + np.sum(np.maximum(missed[many:][counted], 0.0))
        return found[0], float(self.equations.weight @ np.abs(found[0]) + self.price * missed)

    def restored(self, here: Point, reach: float, enough: float = 1e-4, slopes: Array | None = None) -> Point:
        """Return the point moved back to the arrival, by a derivative from elsewhere as long as that is swift."""
        for _ in range(8 if np.any(np.abs(here.angle) > 1e-9) else 0):
            if here.violation < enough:
                break
            own = slopes is None
            slopes = here.values.derivative if slopes is None else slopes
            used, move, values = np.abs(here.angle) > 1e-9, np.zeros_like(here.angle), here.values
            rows = here.kind == TURNING
            limits = here.slack[rows], here.slope[rows][:, used]
            move[used] = bounded_step(slopes[:, used], values.residual, *limits, reach, False)
            there = self.point(here.angle + move)
            left = there.violation / here.violation
            if own and left > 0.9:
                break
            here = there if left <= (0.9 if own else 0.25) else here
            slopes = slopes if left <= 0.25 else None
        return here

    def landed(self, here: Point, angle: Array, promised: float, reach: float) -> Point:
        there = self.point(angle)
        if here.merit - there.merit >= 0.5 * promised:
            return there
        enough = max(min(1e-4, 0.3 * promised / self.price), 1e-7)
        return self.restored(there, max(reach, 0.25), enough, here.values.derivative)

    def run(self, begun: Point, steps: int) -> Point:
        return descended(begun, self.step, self.landed, steps, lambda _: 1e-5)[0]


def approached(equations: Equations, max_bend_rad: float, reach: float, patience: int) -> tuple[Array, Values, float]:
    """Return free angles at which little is missing, the values there, and what is missing."""
    least = least_cosines(equations.phase, equations.start, equations.goal, max_bend_rad, equations.home)
    angle, values = equations.angles, equations.at(equations.angles)
    best, kept, known, idle, halved = np.inf, angle, values, 0, np.inf
    for _ in range(20):
        slack, slope = limit_rows(equations, values, least)
        off = max(values.size, 100.0 * float(-np.min(slack, initial=0.0)))
        if off < best:
            best, kept, known = off, angle, values
        idle, halved = (0, best) if best < 0.5 * halved else (idle + 1, halved)
        if best < 3e-4 or idle > patience:
            break
        fine = not 1e-5 * off < 3e-4
        step = bounded_step(values.derivative, values.residual, slack, slope, reach, fine)
        for shorter in (1.0, 0.4, 0.15, 0.05):
            there = equations.at(angle + shorter * step)
            if there.size < values.size:
                break
        angle, values = angle + shorter * step, there
    return kept, known, best
