"""Waypoints that a trajectory passes, at which of its rows."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import norm
from purcell_cli.geometry.rotations import Array, angle_between
from purcell_cli.mechanics.configuration import Configuration, Deviation
from purcell_cli.motion.mission import Order, Waypoint


@frozen_dataclass
class Passing:
    """Where a trajectory passes a waypoint, or comes nearest to it.

    Attributes:
        index: The waypoint's place in the list, from 0.
        row: The row, from 0.
        time_s: When [s].
        off: How far the re-integration is from what the waypoint names; 0 in what is free.
        met: Whether that is within the tolerances.
    """

    index: int
    row: int
    time_s: float
    off: Deviation
    met: bool


class WaypointsPassed:
    """Looks for rows at which waypoints are passed, in the order given or in any.

    Args:
        via: The waypoints.
        order: In which order they are passed.
        limit_m: How far the position may be off [m].
        limit_rad: How far an orientation may be off [rad].
    """

    def __init__(self, via: Sequence[Waypoint], order: Order, limit_m: float, limit_rad: float) -> None:
        self._via, self._order, self._limits = via, order, (limit_m, limit_rad)
        self._found: dict[int, Passing] = {}
        self._least = np.full(len(via), np.inf)
        self._next, self._from = 0, 0

    def look(self, row: int, time_s: Array, pose: Array, shape: Array, bound: Deviation) -> None:
        """Look at some more rows, as they are re-integrated.

        Args:
            row: The number of the first.
            time_s: Their times [s]. Shape (n,).
            pose: The base's poses [m]. Shape (n, 4, 4).
            shape: The limbs' orientations. Shape (n, 2, 3, 3).
            bound: By how much they may themselves be wrong.
        """
        if self._order == Order.FREE:
            for k in range(len(self._via)):
                if not self._met(k):
                    self._nearest(k, 0, row, time_s, pose, shape, bound)
            return
        while self._next < len(self._via):
            first = max(self._from - row, 0)
            self._nearest(self._next, first, row, time_s, pose, shape, bound)
            if not self._met(self._next):
                return
            self._from = self._found[self._next].row
            self._next += 1

    @property
    def passings(self) -> tuple[Passing, ...]:
        """Where each waypoint is passed or nearest, in the order of the rows; none for one that was not looked for."""
        return tuple(sorted(self._found.values(), key=lambda one: (one.row, one.index)))

    def faults(self) -> list[str]:
        """Return which waypoints are not passed, in words."""
        out = []
        for k in range(len(self._via)):
            one = self._found.get(k)
            if one is not None and one.met:
                continue
            where = "one before it is not"
            if one is not None:
                off = max(one.off.base_rad, one.off.limb1_rad, one.off.limb2_rad)
                where = f"nearest on line {one.row + 2} (t = {one.time_s:.6g} s): {one.off.position_m:.3e} m and "
                where += f"{off:.3e} rad off"
            out.append(f"waypoint via[{k}] is not passed{'' if one is None else ' where it is due'}; {where}")
        return out

    def _met(self, k: int) -> bool:
        return k in self._found and self._found[k].met

    def _nearest(
        self, k: int, first: int, row: int, time_s: Array, pose: Array, shape: Array, bound: Deviation
    ) -> None:
        """Note the first row at which a waypoint is met, or else the row that is nearest to it."""
        if first >= len(time_s):
            return
        one, limit = self._via[k], (self._limits[0] - bound.position_m, self._limits[1] - bound.base_rad)
        parts = [np.zeros(len(time_s) - first)]
        if one.position_m is not None:
            parts.append(norm(pose[first:, :3, 3] - one.position_m) / max(limit[0], 1e-300))
        pairs = ((one.orientation, pose[first:, :3, :3]), (one.limb1, shape[first:, 0]), (one.limb2, shape[first:, 1]))
        parts += [angle_between(wanted, found) / max(limit[1], 1e-300) for wanted, found in pairs if wanted is not None]
        off = np.max(parts, axis=0)
        met = np.flatnonzero(off <= 1.0)
        n = int(met[0]) if len(met) else int(np.argmin(off))
        if off[n] < self._least[k]:
            self._least[k], at = off[n], first + n
            away = one.deviation(Configuration(pose[at], shape[at]))
            self._found[k] = Passing(k, row + at, float(time_s[at]), away, bool(off[n] <= 1.0))
