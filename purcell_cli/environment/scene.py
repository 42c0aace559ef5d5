"""A scene: all obstacles of a scenario, and how near segments are to the nearest of them."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from purcell_cli.environment.mesh import Mesh
from purcell_cli.environment.obstacle import Obstacle, dot
from purcell_cli.environment.solids import Box, Sphere
from purcell_cli.environment.tube import Tube, inside, together
from purcell_cli.errors import ParameterError, refuse_types
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.distances import from_balls, from_boxes

MOST = 10_000
"""Obstacles of a scene at most: with more, a distance takes longer than the flow of what it is computed for."""


@frozen_dataclass(slots=False)
class Scene:
    """Obstacles. Tubes are one vessel together: the swimmer stays in their union.

    Attributes:
        obstacles: The obstacles, one or more.

    Raises:
        ParameterError: None, too many, or one that is no obstacle.
    """

    obstacles: tuple[Obstacle, ...]

    def __post_init__(self) -> None:
        refuse_types(obstacles=(self.obstacles, Iterable))
        object.__setattr__(self, "obstacles", tuple(self.obstacles))
        for k, one in enumerate(self.obstacles):
            refuse_types(**{f"obstacles[{k}]": (one, Obstacle)})
        if not 0 < len(self.obstacles) <= MOST:
            raise ParameterError(f"obstacles: from 1 to {MOST} are wanted, found {len(self.obstacles)}")
        spheres, boxes, tubes = (
            [k for k, one in enumerate(self.obstacles) if isinstance(one, kind)] for kind in (Sphere, Box, Tube)
        )
        balls = [one for one in self.obstacles if isinstance(one, Sphere)]
        solid = [one for one in self.obstacles if isinstance(one, Box)]
        vessel = [one for one in self.obstacles if isinstance(one, Tube)]
        others = sorted(set(range(len(self.obstacles))) - {*spheres, *boxes, *tubes})
        self.__dict__.update(
            _spheres=np.array(spheres, dtype=np.int64),
            _centres=np.array([b.centre_m for b in balls]).reshape(-1, 3),
            _radii=np.array([b.radius_m for b in balls]),
            _boxes=np.array(boxes, dtype=np.int64),
            _middles=np.array([b.centre_m for b in solid]).reshape(-1, 3),
            _turns=np.array([b.orientation for b in solid]).reshape(-1, 3, 3),
            _halves=0.5 * np.array([b.size_m for b in solid]).reshape(-1, 3),
            _tubes=np.array(tubes, dtype=np.int64),
            _cones=together(vessel) if vessel else None,
            _owner=np.repeat(tubes, [len(t.cones[0]) for t in vessel]) if vessel else None,
            _others=[(k, *_ball(self.obstacles[k].bounds())) for k in others],
        )

    @property
    def tubes(self) -> tuple[Tube, ...]:
        """The tubes, one vessel together."""
        return tuple(one for one in self.obstacles if isinstance(one, Tube))

    def name(self, index: int) -> str:
        """Return what messages call an obstacle, by its place among them from 1 on."""
        return f"obstacle {index + 1} ({self.obstacles[index].kind})"

    def distance(self, first: Array, last: Array, most_m: float = np.inf) -> tuple[Array, NDArray[np.int64]]:
        """Return how far segments are from the nearest obstacle, never more than the truth [m], and from which.

        Args:
            first: The segments' beginnings [m]. Shape (n, 3).
            last: Their ends [m]. Shape (n, 3).
            most_m: Distances above this need not be known [m].

        Returns:
            Distances, negative inside, and indices of obstacles. Shapes (n,).
        """
        best, which = np.full(len(first), most_m), np.zeros(len(first), dtype=np.int64)
        inner = self.__dict__
        if len(inner["_spheres"]):
            found, ball = from_balls(first, last, inner["_centres"], inner["_radii"])
            which, best = inner["_spheres"][ball], np.minimum(best, found)
        if len(inner["_boxes"]):
            found, box = from_boxes(first, last, inner["_middles"], inner["_turns"], inner["_halves"])
            which = np.where(found < best, inner["_boxes"][box], which)
            best = np.minimum(best, found)
        middle, half = 0.5 * (first + last), 0.5 * np.sqrt(dot(last - first, last - first))
        for k, centre, reach in inner["_others"]:
            off = middle - centre
            row = np.flatnonzero(np.sqrt(dot(off, off)) - half - reach < best)
            one = self.obstacles[k]
            begin, end = first[row], last[row]
            found = one.within(begin, end, best[row]) if isinstance(one, Mesh) else one.distance(begin, end)
            nearer = row[found < best[row]]
            best[nearer], which[nearer] = found[found < best[row]], k
        if inner["_cones"] is not None:
            found, cone = inside(inner["_cones"], first, last)
            which = np.where(found < best, inner["_owner"][cone], which)
            best = np.minimum(best, found)
        return best, which

    def inside_meshes(self, points: Array) -> NDArray[np.int64]:
        """Return the indices of the meshes that have one of some points inside. Shape (n, 3)."""
        found = [k for k, one in enumerate(self.obstacles) if isinstance(one, Mesh) and np.any(one.contains(points))]
        return np.array(found, dtype=np.int64)

    def bounds(self) -> Array:
        """Return the least and the largest x, y and z of what has an end [m]; nan if nothing has. Shape (2, 3)."""
        every = np.array([one.bounds() for one in self.obstacles])
        every = every[np.all(np.isfinite(every), axis=(1, 2))]
        return np.stack([every[:, 0].min(axis=0), every[:, 1].max(axis=0)]) if len(every) else np.full((2, 3), np.nan)


def _ball(bounds: Array) -> tuple[Array, float]:
    """Return the middle and the radius of a ball round a box [m]; of one without an end, anything and infinity."""
    if not np.all(np.isfinite(bounds)):
        return np.zeros(3), np.inf
    half = 0.5 * (bounds[1] - bounds[0])
    return bounds[0] + half, float(np.sqrt(dot(half, half)))
