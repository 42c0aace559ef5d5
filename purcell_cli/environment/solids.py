"""Solid obstacles of a closed form: spheres, capsules, boxes, half spaces."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from purcell_cli.environment.obstacle import Obstacle, Point, dot, length, point
from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array, from_matrix
from purcell_cli.kernel.distances import from_balls, from_boxes
from purcell_cli.kernel.linear import nearest_on_segments

Matrix = tuple[Point, Point, Point]
"""A rotation matrix, rows first."""

LEVEL: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
"""The world's own orientation."""


@frozen_dataclass
class Sphere(Obstacle):
    """A ball.

    Attributes:
        centre_m: Its middle [m].
        radius_m: Its radius [m].
    """

    kind: ClassVar[str] = "sphere"
    centre_m: Point
    radius_m: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "centre_m", point(self.centre_m, "centre_m"))
        object.__setattr__(self, "radius_m", length(self.radius_m, "radius_m"))

    def distance(self, first: Array, last: Array) -> Array:
        """Return the signed distances of segments, exact [m]. Shapes (n, 3) to (n,)."""
        return from_balls(first, last, np.array([self.centre_m]), np.array([self.radius_m]))[0]

    def bounds(self) -> Array:
        """Return the least and the largest x, y and z [m]. Shape (2, 3)."""
        return np.array([self.centre_m, self.centre_m]) + self.radius_m * np.array([[-1.0], [1.0]])


@frozen_dataclass
class Capsule(Obstacle):
    """A rod with round ends.

    Attributes:
        from_m: One end of its axis [m].
        to_m: The other [m].
        radius_m: Its radius [m].
    """

    kind: ClassVar[str] = "capsule"
    from_m: Point
    to_m: Point
    radius_m: float

    def __post_init__(self) -> None:
        for name in ("from_m", "to_m"):
            object.__setattr__(self, name, point(getattr(self, name), name))
        object.__setattr__(self, "radius_m", length(self.radius_m, "radius_m"))

    def distance(self, first: Array, last: Array) -> Array:
        """Return the distances of segments, exact outside [m]. Shapes (n, 3) to (n,)."""
        begin, end = np.array(self.from_m), np.array(self.to_m)
        way = np.broadcast_to(end - begin, first.shape)
        return np.asarray(nearest_on_segments(first - begin, last - first, way)[:, 2]) - self.radius_m

    def bounds(self) -> Array:
        """Return the least and the largest x, y and z [m]. Shape (2, 3)."""
        ends = np.array([self.from_m, self.to_m])
        return np.stack([ends.min(axis=0) - self.radius_m, ends.max(axis=0) + self.radius_m])


@frozen_dataclass
class Box(Obstacle):
    """A box.

    Attributes:
        centre_m: Its middle [m].
        size_m: Its edges along its own axes [m].
        orientation: Turns its axes into the world's.
    """

    kind: ClassVar[str] = "box"
    centre_m: Point
    size_m: Point
    orientation: Matrix = LEVEL

    def __post_init__(self) -> None:
        for name in ("centre_m", "size_m"):
            object.__setattr__(self, name, point(getattr(self, name), name))
        for edge in self.size_m:
            length(edge, "size_m")
        turned = from_matrix(self.orientation)
        object.__setattr__(self, "orientation", tuple(tuple(float(x) for x in row) for row in turned))

    def distance(self, first: Array, last: Array) -> Array:
        """Return the signed distances of segments, exact outside, to 1e-8 of their length inside [m]. (n, 3), (n,)."""
        boxes = np.array([self.centre_m]), np.array([self.orientation]), 0.5 * np.array([self.size_m])
        return from_boxes(first, last, *boxes)[0]

    def bounds(self) -> Array:
        """Return the least and the largest x, y and z [m]. Shape (2, 3)."""
        reach = np.sum(np.abs(np.array(self.orientation)) * 0.5 * np.array(self.size_m), axis=1)
        return np.asarray(np.array(self.centre_m) + np.stack([-reach, reach]))


@frozen_dataclass
class HalfSpace(Obstacle):
    """All that lies behind a plane; the swimmer stays on the side that the normal points to.

    Attributes:
        point_m: A point of the plane [m].
        normal: Its normal; of any length but 0.
    """

    kind: ClassVar[str] = "half_space"
    point_m: Point
    normal: Point

    def __post_init__(self) -> None:
        object.__setattr__(self, "point_m", point(self.point_m, "point_m"))
        normal = np.array(point(self.normal, "normal"))
        largest = float(np.max(np.abs(normal)))
        if not largest > 0.0:
            raise ParameterError(f"normal: a vector other than 0 is wanted, found {self.normal!r}")
        normal = normal / largest
        object.__setattr__(self, "normal", tuple((normal / np.sqrt(dot(normal, normal))).tolist()))

    def distance(self, first: Array, last: Array) -> Array:
        """Return the signed distances of segments, exact [m]. Shapes (n, 3) to (n,)."""
        normal, origin = np.array(self.normal), np.array(self.point_m)
        return np.asarray(np.minimum(dot(first - origin, normal), dot(last - origin, normal)))

    def bounds(self) -> Array:
        """Return the least and the largest x, y and z [m]. Shape (2, 3)."""
        return np.array([[-np.inf] * 3, [np.inf] * 3])
