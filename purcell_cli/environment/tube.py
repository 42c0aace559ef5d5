"""Tubes round a polyline: the swimmer stays inside, and in one of them where there are several.

A tube is the union of the balls along its centreline, whose radius changes evenly from point to point. The swimmer is
inside by as much as the point's distance from the centre of some ball falls short of its radius: for one piece of
the centreline, a cone with round ends, that is concave, so that on a stretch of a link it is least at an end of it.
So a link is cut into cells, and each cell is held to be inside by the best of the cones that both its ends are in.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from purcell_cli.environment.obstacle import Obstacle, Point, along, dot, length, point
from purcell_cli.errors import ParameterError, PointError, refuse_types
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.distances import inside_cones

_CELLS = 8
"""Cells of a link; in a tube whose centreline turns by 0.1 rad at a point they cost 0.01 of its length at most."""
_COARSE = 0.01
"""Points of a centreline are left out where that moves it by no more than this part of the least radius; the radius
then shrinks by as much as it is moved."""
_BLUNT_RAD = math.radians(20.0)
"""Turns of a centreline up to this are not held against it: measured points lie a little to and fro [rad]."""
_BACK_RAD = math.radians(165.0)
"""A centreline that turns by more at a point goes back along itself: its points are not in order [rad]."""
_JUST = 0.9
"""A polygon round a circle of the tube's own radius is allowed: it turns this much tighter than the circle at most."""


class CentrelineError(PointError):
    """A point of a centreline that cannot be; see `PointError`."""

    def __init__(self, point: int, wanted: str, found: str) -> None:
        super().__init__(f"centreline: {wanted} are wanted, found {found} at point {point + 1}", point, wanted, found)


@frozen_dataclass(slots=False)
class Tube(Obstacle):
    """A tube that the swimmer stays inside of.

    Attributes:
        points_m: The points of its centreline [m].
        radii_m: The tube's radius at each [m].
        file: The file that says them, if there is one.

    Raises:
        ParameterError: Fewer than two points.
        CentrelineError: Two points alike in a row, or a tube that turns back or tighter than its radius.
    """

    kind: ClassVar[str] = "tube"
    points_m: tuple[Point, ...]
    radii_m: tuple[float, ...]
    file: str = dataclasses.field(default="", compare=False)

    def __post_init__(self) -> None:
        refuse_types(points_m=(self.points_m, Iterable), radii_m=(self.radii_m, Iterable))
        points = tuple(point(p, "centreline") for p in self.points_m)
        object.__setattr__(self, "points_m", points)
        object.__setattr__(self, "radii_m", tuple(length(r, "radius_m") for r in self.radii_m))
        if len(points) < 2 or len(points) != len(self.radii_m):
            raise ParameterError(f"centreline: two points or more, a radius each, are wanted, found {len(points)}")
        way = np.diff(np.array(points), axis=0)
        if len(flat := np.flatnonzero(dot(way, way) == 0.0)):
            raise CentrelineError(int(flat[0]) + 1, "points that differ", "two alike")
        _refuse_tight(np.array(points), np.array(self.radii_m))
        object.__setattr__(self, "_cones", _cones(np.array(points), np.array(self.radii_m)))

    @property
    def cones(self) -> tuple[Array, Array, Array, Array]:
        """The cones that stand for it: beginnings (m, 3), ways (m, 3), radii there (m,) and their change (m,) [m]."""
        cones: tuple[Array, Array, Array, Array] = self.__dict__["_cones"]
        return cones

    def distance(self, first: Array, last: Array) -> Array:
        """Return how far inside segments are at the least [m]. Shapes (n, 3) to (n,)."""
        return inside(self.cones, first, last)[0]

    def bounds(self) -> Array:
        """Return the least and the largest x, y and z [m]. Shape (2, 3)."""
        points, radii = np.array(self.points_m), np.array(self.radii_m)[:, None]
        return np.stack([(points - radii).min(axis=0), (points + radii).max(axis=0)])


def together(tubes: list[Tube]) -> tuple[Array, Array, Array, Array]:
    """Return the cones of several tubes."""
    first, way, radius, change = (np.concatenate(parts) for parts in zip(*(t.cones for t in tubes), strict=True))
    return first, way, radius, change


def inside(cones: tuple[Array, Array, Array, Array], first: Array, last: Array) -> tuple[Array, NDArray[np.int64]]:
    """Return how far inside the union of cones segments are at the least [m], and in which. Shapes (n, 3) to (n,)."""
    return inside_cones(first, last, _CELLS, *cones)


def _refuse_tight(points: Array, radii: Array) -> None:
    """Refuse a centreline that turns tighter than the tube's radius: its wall would cross itself.

    Between the middles of two of its pieces it turns by some angle over some way, at a corner over the half of each
    side that the shorter one allows; on a circle of the radius the way would be the angle times the radius.
    """
    way = np.diff(points, axis=0)
    size = np.sqrt(dot(way, way))
    heading = way / size[:, None]
    back = np.flatnonzero(dot(heading[1:], heading[:-1]) < math.cos(_BACK_RAD))
    if len(back):
        raise CentrelineError(int(back[0]) + 1, f"turns of at most {math.degrees(_BACK_RAD):g} degrees", "one back")
    middle, at_end = np.cumsum(size) - 0.5 * size, radii[1:]
    for k in range(len(way) - 1):
        some = slice(k + 1, int(np.searchsorted(middle, middle[k] + math.pi * float(np.max(radii)))) + 1)
        cosine = np.clip(dot(heading[some], heading[k]), -1.0, 1.0)
        turn, gap = np.arccos(cosine), middle[some] - middle[k]
        gap[:1] = np.minimum(size[k], size[k + 1])
        tight = (turn > _BLUNT_RAD) & (gap < _JUST * turn * at_end[some])
        if np.any(tight):
            n = int(np.flatnonzero(tight)[0])
            wanted = f"turns no tighter than the tube's radius ({at_end[some][n]:g} m)"
            raise CentrelineError(k + 1 + n, wanted, f"one of {gap[n] / turn[n]:.3g} m")


def _cones(points: Array, radii: Array) -> tuple[Array, Array, Array, Array]:
    """Return the cones of a centreline without the points that hardly matter, the tube smaller by what that moves."""
    most = _COARSE * float(np.min(radii))
    kept, shrunk, k = [0], [], 0
    while k < len(points) - 1:
        step, slack, wider = 1, 0.0, 1
        while wider and k + step + 1 < len(points):
            tried = min(step + wider, len(points) - 1 - k)
            moved = _moved(points, radii, k, k + tried)
            if moved <= most:
                step, slack, wider = tried, moved, 2 * wider
            else:
                wider //= 2
        k += step
        kept.append(k)
        shrunk.append(slack)
    way, less = np.diff(points[kept], axis=0), np.array(shrunk)
    return points[kept[:-1]], way, radii[kept[:-1]] - less, np.diff(radii[kept])


def _moved(points: Array, radii: Array, first: int, last: int) -> float:
    """Return by how much the balls of one straight cone may stick out of those of the centreline between two points."""
    way = points[last] - points[first]
    between = points[first : last + 1]
    foot = dot(between - points[first], way)
    if np.any(np.diff(foot) <= 0.0):
        return math.inf
    part = along(between, points[first], way)
    off = between - points[first] - part[:, None] * way
    wider = radii[first] + part * (radii[last] - radii[first]) - radii[first : last + 1]
    return float(np.max(np.sqrt(dot(off, off)) + np.maximum(wider, 0.0)))
