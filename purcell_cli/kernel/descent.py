"""Motions brought to their goal, and shortened, by the kernel: all steps of a search in one call."""

from __future__ import annotations

import ctypes
import math
from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.kernel.arrays import Array, address, doubles, wholes
from purcell_cli.kernel.clearance import Apart
from purcell_cli.kernel.flow import Flow, refuse, repeats_of
from purcell_cli.kernel.library import KERNEL
from purcell_cli.kernel.shapes import control_numbers

More = Callable[[Array], tuple[Array, Array]]
"""Gives more inequalities at the angles of all primitives, shape (n,): the room that is left, shape (j,), and its
derivative by the free angles, shape (j, u). It may not keep what it is given."""
_IDLE: list[Array] = []
"""Memory that a search has worked in, for the next one: new memory costs as much as a short search."""
_MOST_KEPT = 1 << 24
"""More numbers than this are not kept."""
_WATCHER = ctypes.CFUNCTYPE(ctypes.c_int64)


class Descent:
    """Searches for the free angles of one motion of primitives.

    Primitive k turns by sign[k] times the free angle index[k], or by given[k] where that is -1.

    Args:
        flow: The flow of the base.
        controls: Which control each primitive turns, 6 and 7 about the base's z. Shape (n,).
        given: Their angles where they have no free one [rad]. Shape (n,).
        index: The free angle of each. Shape (n,).
        sign: Its sign. Shape (n,).
        free: How many free angles there are.
        repeats: Parts played more than once; see `Flow.with_derivatives`. Shape (k, 3).
        start: Shape before the first primitive. Shape (2, 3, 3).
        wanted_inverse: The inverse of the displacement. Shape (4, 4).
        stops: The primitives before which shapes are wanted, n for the end. Shape (t,).
        ends: Those shapes. Shape (t, 2, 3, 3).
        least: The least cosine of each limb's bend on each primitive. Shape (n, 2).
        fixed: 1 for primitives whose bends do not matter, else 0. Shape (n,).
        near: More room below the bend limit than this does not matter, in the cosine of the bend.
        apart: How far limbs must be apart, if that matters.
        more: More inequalities, if any.
        most: How many they are at most.
        watched: Whether Ctrl-C is heard between two points; more inequalities are asked for only then.

    Raises:
        ValueError: Arrays that do not fit together.
    """

    def __init__(
        self,
        flow: Flow,
        controls: ArrayLike,
        given: ArrayLike,
        index: ArrayLike,
        sign: ArrayLike,
        free: int,
        repeats: ArrayLike,
        start: ArrayLike,
        wanted_inverse: ArrayLike,
        stops: ArrayLike,
        ends: ArrayLike,
        least: ArrayLike,
        fixed: ArrayLike,
        near: float,
        apart: Apart | None = None,
        more: More | None = None,
        most: int = 0,
        watched: bool = True,
    ) -> None:
        known = doubles(given, "given", (-1,))
        n = len(known)
        control, parts, stop = control_numbers(controls, n), repeats_of(repeats, n), wholes(stops, "stops", (-1,))
        own, still, t = wholes(index, "index", (n,)), wholes(fixed, "fixed", (n,)), len(stop)
        if control is None or free < 0 or (n and not -1 <= int(own.min()) <= int(own.max()) < free):
            raise ValueError(f"index: numbers from -1 to {free - 1} are wanted, and controls")
        if t and not 0 <= int(stop.min()) <= int(stop.max()) <= n:
            raise ValueError(f"stops: numbers from 0 to {n} are wanted")
        bending = int(np.count_nonzero(((control % 3 != 0) | (control >= 6)) & (still == 0)))
        self.n, self.free, self.equations, self._more = n, free, 6 + 6 * t, more
        self._most = most if more is not None else 0
        rows = bending + (0 if apart is None else n) + self._most
        self._angles, self._room, self._slope = np.empty(n), np.empty(self._most), np.empty((self._most, free))
        whole = np.empty(1, dtype=np.int64)
        self._numbers = KERNEL.purcell_descent_room(
            n, free, self.equations, len(parts), rows, self._most, address(whole)
        )
        self._size = self._numbers + int(whole[0])
        self._stopped: BaseException | None = None
        watching = self._watching()
        next(watching)
        self._watcher = _WATCHER(watching.__next__)
        arrays = [
            *(control, own, still, parts, stop, doubles(start, "start", (2, 3, 3)), known, doubles(sign, "sign", (n,))),
            doubles(wanted_inverse, "wanted_inverse", (4, 4)),
            *(doubles(ends, "ends", (t, 2, 3, 3)), doubles(least, "least", (n, 2))),
            *(self._angles, self._room, self._slope),
        ]
        distances = [] if apart is None else [doubles(apart.least, "apart", (n,)), apart.numbers()]
        at = [address(array) for array in arrays]
        gaps: list[int | None] = [address(array) for array in distances] if distances else [None, None]
        watcher = ctypes.cast(self._watcher, ctypes.c_void_p).value if watched else None
        limits = float(near), *gaps, *((0.0, 0.0) if apart is None else (float(apart.straight), float(apart.near)))
        middle = (*limits, rows, self._most, watcher)
        self._motion = (*flow.head, n, free, *at[:3], len(parts), at[3], t, at[4], *at[5:11], *middle, *at[11:])
        self._kept = arrays, distances, flow

    def shortened(
        self,
        angles: ArrayLike,
        weight: ArrayLike,
        price: float,
        steps: int,
        reaches: tuple[float, float, float],
        close: float,
        astray: float,
        worth: float = 0.0,
        own: bool = False,
    ) -> tuple[Array, float, float]:
        """Return free angles of less joint travel, by sequential linear programs.

        Args:
            angles: Where to begin [rad]. Shape (u,).
            weight: Joint travel per free angle, not negative. Shape (u,).
            price: Joint travel that a violation counts as, positive [rad per L or rad].
            steps: The most programs.
            reaches: The first, the largest and the least radius of the trust region [rad].
            close: A beginning whose violations sum to this or more is moved back first [L, rad].
            astray: It is given up where they then sum to this or more [L, rad].
            worth: A program that promises to save less than this part of the joint travel is the last.
            own: Whether each angle has a radius of its own, which shrinks where its change turns back and grows where
                it goes on (move limits: Svanberg 1987, Int. J. Numer. Methods Eng. 24, 359).

        Returns:
            Angles, shape (u,), and the sums of the violations where the programs began, infinite where it was given
            up, and where they ended.

        Raises:
            ValueError: A piece is so long that it has more than two million steps.
        """
        angle, each = np.array(doubles(angles, "angles", (self.free,))), doubles(weight, "weight", (self.free,))
        if np.any(each < 0.0) or not price > 0.0 or not np.all(np.isfinite(angle)):
            raise ValueError("weight, price and angles: numbers that are not negative, positive and finite are wanted")
        radius, missed = doubles(reaches, "reaches", (3,)), np.empty(2)
        programs = int(steps), int(own)
        limits = float(price), float(close), float(astray), float(worth), *programs
        places = address(radius), address(angle), address(missed)
        self._searched(KERNEL.purcell_descend, address(each), *limits, *places)
        return angle, float(missed[0]), float(missed[1])

    def approached(
        self,
        angles: ArrayLike,
        enough: float,
        reach: float,
        patience: int,
        stuck: int,
        trials: int = 0,
        hopeless: float = math.inf,
        most_tried: int = 1000,
        nearly: float = 0.0,
    ) -> tuple[Array, Array, Array, Array, float]:
        """Return free angles at which little is missing and no limit is broken, by Newton steps.

        Args:
            angles: Where to begin [rad]. Shape (u,).
            enough: What may be missing [L, rad].
            reach: The largest change of an angle in a step [rad].
            patience: Rounds in which what is missing does not even halve before it is given up.
            stuck: Steps in a row of which the smallest part or none helps before it is given up.
            trials: After so many evaluations it is given up if more than `hopeless` is still missing.
            hopeless: A beginning that misses by more is given up at once [L, rad].
            most_tried: After so many evaluations it is given up whatever is missing.
            nearly: Where less is missing, a step is taken too if the next one would be half as long: where links are
                nearly straight, what is missing may grow although the arrival is nearer [L, rad].

        Returns:
            Angles, shape (u,), what is missing there, shape (m,), and its derivative, shape (m, u), shapes, shape
            (n + 1, 2, 3, 3), and the largest that is missing, or broken at a hundred times its size.

        Raises:
            ValueError: A piece is so long that it has more than two million steps.
        """
        angle = np.array(doubles(angles, "angles", (self.free,)))
        residual, derivative = np.empty(self.equations), np.empty((self.equations, self.free))
        shapes, off = np.empty((self.n + 1, 2, 3, 3)), np.empty(1)
        places = (address(part) for part in (angle, residual, derivative, shapes, off))
        given_up = int(patience), int(stuck), int(trials), float(hopeless), int(most_tried), float(nearly)
        self._searched(KERNEL.purcell_approach, float(enough), float(reach), *given_up, *places)
        return angle, residual, derivative, shapes, float(off[0])

    def _watching(self) -> Iterator[int]:
        """Give more inequalities to the kernel at each point: how many they are; between two points, Ctrl-C is heard.

        What a signal raises is raised as soon as Python runs again. A function that the kernel calls would not have
        come to its first line then, and nobody would hear of it; this goes on where it was left, which is in the `try`.
        """
        given = 0
        while True:
            try:
                while True:  # within the `try`, since to go round hears of signals, too
                    yield given
                    given = self._given()
            except GeneratorExit:
                return
            except BaseException as error:  # the kernel ends, and it is raised then
                self._stopped, given = error, -1

    def _given(self) -> int:
        if self._more is None:
            return 0
        room, slope = self._more(self._angles)
        if len(room) > self._most or slope.shape != (len(room), self.free):
            raise ValueError(f"more: at most {self._most} inequalities are wanted, found {len(room)}")
        self._room[: len(room)], self._slope[: len(room)] = room, slope
        return len(room)

    def _searched(self, search: Callable[..., int], *rest: float | None) -> None:
        """Make a search in memory of its own: what watches it may begin another one."""
        try:
            work = _IDLE.pop()
        except IndexError:
            work = np.empty(0)
        if len(work) < self._size:
            work = np.empty(self._size)
        place = address(work)
        fault = search(*self._motion, place, place + work.itemsize * self._numbers, *rest)
        if len(work) <= _MOST_KEPT:
            _IDLE.append(work)
        stopped, self._stopped = self._stopped, None
        if stopped is not None:
            raise stopped
        refuse(fault, 0)
