"""A curve in space: a polyline that the base's middle follows, and distances from it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from purcell_cli.errors import ParameterError, PointError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import inner, matmul, norm
from purcell_cli.geometry.rotations import Array, angle_between, from_matrix

_JUMP = 20.0
"""A step longer than so many times the middle one of all steps is a jump: a lost row, or a slip in a number."""
_FEWEST = 8
"""Curves of fewer steps have no jumps: too few to tell."""
_LARGEST_TURN_RAD = 3.0
"""The largest turn of the orientation from a point to the next [rad]: of larger ones the sense could be mistaken."""


class CurveError(PointError):
    """A point of a curve that cannot be; see `PointError`."""

    def __init__(self, point: int, wanted: str, found: str) -> None:
        super().__init__(f"point {point + 1} of the curve: {wanted} is wanted, found {found}", point, wanted, found)


@frozen_dataclass(eq=False)
class Curve:
    """A polyline, and the base's orientation at its points if that is wanted too.

    Attributes:
        point_m: The points, in order [m]. Shape (n, 3).
        orientation: The base's orientations there; None where they are free. Shape (n, 3, 3).

    Raises:
        CurveError: Fewer than two points, one that repeats or is not finite, or a jump.
    """

    point_m: Array
    orientation: Array | None = None

    def __post_init__(self) -> None:
        points = np.array(self.point_m, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3 or len(points) < 2:
            raise CurveError(max(len(points) - 1, 0), "a list of two points or more, three numbers each,", "another")
        bad = np.flatnonzero(~np.all(np.isfinite(points), axis=1))
        if len(bad):
            raise CurveError(int(bad[0]), "finite numbers", "others")
        steps = norm(np.diff(points, axis=0))
        same = np.flatnonzero(steps == 0.0)
        if len(same):
            raise CurveError(int(same[0]) + 1, "another point than the one before", "it again")
        middle = float(np.median(steps))
        if len(steps) >= _FEWEST and float(np.max(steps)) > _JUMP * middle:
            k = int(np.argmax(steps))
            wanted = f"a step of at most {_JUMP:g} times the middle step of {middle:.6g} m (points on a straight part)"
            raise CurveError(k + 1, wanted, f"a jump of {float(steps[k]):.6g} m")
        points.setflags(write=False)
        object.__setattr__(self, "point_m", points)
        if self.orientation is None:
            return
        orientation = from_matrix(self.orientation)
        if orientation.shape != (len(points), 3, 3):
            raise CurveError(0, "an orientation for each point", f"{len(orientation)} for {len(points)}")
        turns = angle_between(orientation[:-1], orientation[1:])
        if float(np.max(turns)) > _LARGEST_TURN_RAD:
            k = int(np.argmax(turns))
            wanted = f"a turn of at most {_LARGEST_TURN_RAD:g} rad from the point before"
            raise CurveError(k + 1, wanted, f"one of {float(turns[k]):.6g} rad")
        orientation.setflags(write=False)
        object.__setattr__(self, "orientation", orientation)

    def __repr__(self) -> str:
        turned = "" if self.orientation is None else " with orientations"
        return f"<Curve: {len(self.point_m)} points{turned}, {self.length_m:.6g} m>"

    @property
    def along_m(self) -> Array:
        """How far along the curve each point is [m]. Shape (n,)."""
        return np.concatenate([[0.0], np.cumsum(norm(np.diff(self.point_m, axis=0)))])

    @property
    def length_m(self) -> float:
        """How long it is [m]."""
        return float(self.along_m[-1])

    def at(self, along_m: Array) -> Array:
        """Return the points so far along the curve [m]. Shapes (m,) to (m, 3)."""
        known = self.along_m
        return np.stack([np.interp(along_m, known, self.point_m[:, k]) for k in range(3)], axis=-1)

    def part(self, begin_m: float, end_m: float) -> Curve:
        """Return the part of the curve between two places along it [m], without orientations."""
        known = self.along_m
        inner_ones = known[(known > begin_m) & (known < end_m)]
        places = np.concatenate([[begin_m], inner_ones, [end_m]])
        points = self.at(places)
        kept = np.concatenate([[True], norm(np.diff(points, axis=0)) > 0.0])
        return _unchecked(points[kept])

    def rest(self, point_m: Array, near_m: float) -> Curve | None:
        """Return what is left of the curve from where it is nearest to a point on; None where that is its end.

        Args:
            point_m: The point [m]. Shape (3,).
            near_m: About how far along the curve that is [m]: it tells laps apart.
        """
        off, share = (x[0] for x in _distances(point_m[None], self.point_m[:-1], np.diff(self.point_m, axis=0)))
        slack = _AS_NEAR * float(np.max(np.abs(self.point_m)))
        known = self.along_m
        along = known[:-1] + share * np.diff(known)
        far = np.where(off <= np.min(off) + slack, np.abs(along - near_m), np.inf)
        k = int(np.argmin(far))
        kept = np.flatnonzero(known > along[k])
        if not len(kept):
            return None
        points = np.concatenate([self.at(along[k : k + 1]), self.point_m[kept]])
        if self.orientation is None:
            return _unchecked(points)
        turn = se3.log(se3.pose(matmul(self.orientation[k].T, self.orientation[k + 1]), np.zeros(3)))[3:]
        begun = matmul(self.orientation[k], se3.rotation(share[k] * turn))
        return Curve(points, np.concatenate([begun[None], self.orientation[kept]]))

    def distance_m(self, point_m: Array) -> Array:
        """Return how far points are from the curve [m]. Shapes (m, 3) to (m,).

        Points are taken some at a time; only steps that may be nearest to one of these are looked at.
        """
        out = np.empty(len(point_m))
        begin, edge = self._steps_once()
        for some, near in _nearby(point_m, begin, edge):
            out[some] = np.min(_distances(point_m[some], begin[near], edge[near])[0], axis=1)
        return out

    def turned_from(self, pose: Array) -> Array:
        """Return how far poses are turned from the curve's orientation where it is nearest [rad]. (m, 4, 4) to (m,).

        Where it is equally near at several places, as in laps, the least of these counts.

        Raises:
            ParameterError: The curve has no orientations.
        """
        if self.orientation is None:
            raise ParameterError("a curve with orientations is wanted, found one without")
        point_m, begin, edge = pose[:, :3, 3], self.point_m[:-1], np.diff(self.point_m, axis=0)
        step = matmul(np.swapaxes(self.orientation[:-1], 1, 2), self.orientation[1:])
        turn = se3.log(se3.pose(step, np.zeros((len(step), 3))))[:, 3:]
        slack = _AS_NEAR * float(np.max(np.abs(self.point_m)))
        out = np.full(len(pose), np.inf)
        for some, near in _nearby(point_m, begin, edge):
            off, share = _distances(point_m[some], begin[near], edge[near])
            row, which = np.nonzero(off <= np.min(off, axis=1)[:, None] + slack)
            place = np.flatnonzero(near)[which]
            there = matmul(self.orientation[place], se3.rotation(share[row, which, None] * turn[place]))
            np.minimum.at(out, some.start + row, angle_between(there, pose[some.start + row, :3, :3]))
        return out

    def _steps_once(self) -> tuple[Array, Array]:
        """Return where steps begin, and what they add; those that laps repeat once. Shapes (n, 3)."""
        steps = np.concatenate([self.point_m[:-1], np.diff(self.point_m, axis=0)], axis=1)
        _, first = np.unique(np.round(steps / (_SAME * float(np.max(np.abs(steps))))) + 0.0, axis=0, return_index=True)
        once = steps[np.sort(first)]
        return once[:, :3], once[:, 3:]


_SAME = 1e-12
"""Steps whose ends differ by less than this part of the largest coordinate are the same."""
_TOGETHER = 64
"""Points whose distances from a curve are computed at once: neighbours on a path, so that few steps are near them."""
_ROUNDED = 1.0 + 1e-9
"""Room for rounding in which steps may be nearest."""


_AS_NEAR = 1e-9
"""Places whose distances differ by less than this part of the largest coordinate are equally near."""


def _nearby(point_m: Array, begin_m: Array, edge_m: Array) -> Iterator[tuple[slice, NDArray[np.bool_]]]:
    """Return points, some at a time, and which steps may be nearest to one of them. Shapes (m, 3), (n, 3), (n, 3)."""
    for low in range(0, len(point_m), _TOGETHER):
        some = slice(low, min(low + _TOGETHER, len(point_m)))
        middle = 0.5 * (point_m[some].min(axis=0) + point_m[some].max(axis=0))
        radius = float(np.max(norm(point_m[some] - middle)))
        rough = _distances(middle[None], begin_m, edge_m)[0][0]
        yield some, rough <= float(np.min(rough)) * _ROUNDED + 2.0 * _ROUNDED * radius


def _distances(point_m: Array, begin_m: Array, edge_m: Array) -> tuple[Array, Array]:
    """Return how far points are from the steps of a curve [m], and at which share of these.

    Shapes (m, 3), (n, 3) and (n, 3) to (m, n) each.
    """
    away = point_m[:, None] - begin_m
    share = np.clip(inner(away, edge_m) / inner(edge_m, edge_m), 0.0, 1.0)
    return norm(away - share[..., None] * edge_m), share


def _unchecked(points: Array) -> Curve:
    """Return a curve of points that are known to be good."""
    curve = object.__new__(Curve)
    object.__setattr__(curve, "point_m", points)
    object.__setattr__(curve, "orientation", None)
    return curve
