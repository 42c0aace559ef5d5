"""Poses for a roadmap: anywhere in the region, in narrow places, and along tubes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from purcell_cli.environment.scene import Scene
from purcell_cli.environment.tube import Tube
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import inner, matmul, norm, normal_numbers
from purcell_cli.geometry.rotations import Array, cross
from purcell_cli.planner.routes.edges import first_with_room, room
from purcell_cli.planner.routes.swing import Swing

_TRIED = 3000
"""Poses that are drawn at random, of which a few are kept."""
_PROBED = 20_000
"""Points that are drawn at random to find narrow places."""
_ROUND_WAY = 0.3
"""How far aside of the straight way places round it are, as a part of its length, or of a swimmer's if that is more."""
_ASIDE_L = 4.0
"""Within so much something stands to both sides of a point in a narrow place [L]."""
_NEAR_L = 1e-3
"""Steps by which it is found where the nearest of it stands [L]."""
_HEADINGS = 40
"""Headings that are tried at a point in a narrow place."""
_TURNED = 0.3
"""Poses near others are turned by this for each L that they are moved [rad]: limbs' ends then move about as far."""
_CLIMBS = 12
"""Rounds in which a pose in a narrow place moves to where there is more room."""
_MARGIN_L = 6.0
"""How far the region of a roadmap goes beyond the start, the goal and what stands near them [L]: a swimmer's length."""


@frozen_dataclass(eq=False)
class Plane:
    """The plane that two hinges of one axis keep the base in.

    Attributes:
        axis: The axis of the hinges, "yaw" or "pitch".
        start: The pose at the start [m]. Shape (4, 4).
    """

    axis: str
    start: Array

    @property
    def normal(self) -> Array:
        """The plane's normal, along the hinges' axis. Shape (3,)."""
        return self.start[:3, 2 if self.axis == "yaw" else 1]

    def projected(self, vectors: Array, place: bool) -> Array:
        """Return the parts of vectors along the plane, or the feet of the perpendiculars from places. Shapes (n, 3)."""
        off = vectors - self.start[:3, 3] if place else vectors
        return np.asarray(vectors - inner(off, self.normal)[:, None] * self.normal)

    def poses(self, places: Array, headings: Array) -> Array:
        """Return poses in the plane nearest to places, that look in directions. Shapes (n, 3) to (n, 4, 4)."""
        unit, normal = _unit(self.projected(headings, False), self.start[:3, 0]), self.normal
        normals = np.broadcast_to(normal, unit.shape)
        columns = [unit, cross(normals, unit), normals] if self.axis == "yaw" else [unit, normals, cross(unit, normals)]
        return se3.pose(np.stack(columns, axis=2), self.projected(places, True))


@frozen_dataclass(eq=False)
class Region:
    """Where the poses of a roadmap are.

    Attributes:
        scene: The obstacles.
        swings: The room that strokes take, the largest bends first.
        length_m: The swimmer's L [m].
        clearance_m: How far links stay from obstacles [m].
        low: The least x, y and z [m]. Shape (3,).
        high: The largest [m]. Shape (3,).
        plane: The plane that the swimmer stays in, if its joints keep it in one.
        walls: How many of the last obstacles are walls of the workspace.
    """

    scene: Scene
    swings: tuple[Swing, ...]
    length_m: float
    clearance_m: float
    low: Array
    high: Array
    plane: Plane | None = None
    walls: int = 0

    @property
    def obstacles(self) -> int:
        """How many of the scene's obstacles are the scenario's own; walls of the workspace come after them."""
        return len(self.scene.obstacles) - self.walls

    @classmethod
    def of(
        cls,
        scene: Scene,
        swings: tuple[Swing, ...],
        length_m: float,
        clearance_m: float,
        start: Array,
        goal: Array,
        axis: str | None = None,
    ) -> Region:
        """Return the region round a start, a goal and what stands between or near them. Shapes (4, 4)."""
        ends = np.stack([start[:3, 3], goal[:3, 3]])
        low, high = ends.min(axis=0), ends.max(axis=0)
        wide = max(_MARGIN_L * length_m, 0.25 * float(np.max(high - low)))
        low, high = low - wide, high + wide
        reach_low, reach_high = low, high
        for one in scene.obstacles:
            bounds = one.bounds()
            if np.all(np.isfinite(bounds)) and np.all(bounds[0] <= high) and np.all(bounds[1] >= low):
                more = 0.0 if isinstance(one, Tube) else _MARGIN_L * length_m
                reach_low = np.minimum(reach_low, bounds[0] - more)
                reach_high = np.maximum(reach_high, bounds[1] + more)
        plane = None if axis is None else Plane(axis, start)
        return cls(scene, swings, length_m, clearance_m, reach_low, reach_high, plane)

    def _poses(self, places: Array, headings: Array) -> Array:
        return _poses(places, headings) if self.plane is None else self.plane.poses(places, headings)

    def _in_plane(self, vectors: Array, place: bool) -> Array:
        return vectors if self.plane is None else self.plane.projected(vectors, place)

    def room(self, poses: Array, swing: int = -1, most_m: float = np.inf) -> Array:
        """Return how much room poses have beyond the smallest strokes, so much at most [m]. (..., 4, 4) to (...)."""
        return room(self.scene, self.swings[swing], self.length_m, self.clearance_m, poses, most_m)

    def widest(self, poses: Array) -> NDArray[np.int64]:
        """Return which of the swings first has room at poses; how many there are if none. Shapes (n, 4, 4) to (n,)."""
        return first_with_room(self.scene, self.swings, self.length_m, self.clearance_m, poses)

    def drawn(self, rng: np.random.Generator, count: int, ends: Array) -> Array:
        """Return poses with room for the smallest strokes: a third in narrow places, the others anywhere.

        Args:
            rng: Draws them.
            count: How many at most.
            ends: The start and the goal [m]. Shape (2, 4, 4).
        """
        parts = [self._anywhere(rng, count - count // 3, ends), self._narrow(rng, count // 3, ends)]
        if self.scene.tubes:
            parts.append(self._along_tubes(rng))
        found = np.concatenate(parts)
        return found[self.room(found, most_m=0.0) >= 0.0]

    def near(self, rng: np.random.Generator, poses: Array, count: int, spread: float) -> Array:
        """Return poses near others, with room for the smallest strokes.

        Args:
            rng: Draws them.
            poses: The others [m]. Shape (n, 4, 4).
            count: How many near each.
            spread: How far from them [L], and by how much turned.
        """
        twist = spread * normal_numbers(rng, (len(poses), count, 6))
        twist[..., :3] *= self.length_m
        twist[..., 3:] *= _TURNED
        moved = se3.normalised(matmul(poses[:, None], se3.exp(twist)).reshape(-1, 4, 4))
        if self.plane is not None:
            moved = self.plane.poses(moved[:, :3, 3], moved[:, :3, 0])
        return moved[self.room(moved, most_m=0.0) >= 0.0]

    def _anywhere(self, rng: np.random.Generator, count: int, ends: Array) -> Array:
        places = self._places(rng, _TRIED, ends)
        headings = normal_numbers(rng, (_TRIED, 3))
        way = ends[1, :3, 3] - ends[0, :3, 3]
        if float(norm(way)) > 0.0:  # half of them look roughly where the goal is
            headings[::2] = 0.4 * headings[::2] + way / norm(way)
        poses = self._poses(places, headings)
        return poses[np.flatnonzero(self.room(poses, most_m=0.0) >= 0.0)[:count]]

    def _places(self, rng: np.random.Generator, count: int, ends: Array) -> Array:
        """Return places anywhere in the region, every other one round the straight way from the start to the goal."""
        places = self.low + rng.random((count, 3)) * (self.high - self.low)
        way = ends[1, :3, 3] - ends[0, :3, 3]
        aside = _ROUND_WAY * max(float(norm(way)), _MARGIN_L * self.length_m)
        some = places[1::2]
        some[:] = ends[0, :3, 3] + rng.random((len(some), 1)) * way + aside * normal_numbers(rng, (len(some), 3))
        return self._in_plane(np.clip(places, self.low, self.high), True)

    def _narrow(self, rng: np.random.Generator, count: int, ends: Array) -> Array:
        """Return poses where something stands to both sides, moved to where there is most room."""
        places = self._places(rng, _PROBED, ends)
        most = _ASIDE_L * self.length_m
        near = self.scene.distance(places, places, most)[0]
        some = (near >= self.swings[-1].thick * self.length_m + self.clearance_m) & (near < most)
        places, near = places[some], near[some]
        step = _NEAR_L * self.length_m
        beside = [self.scene.distance(places + step * axis, places + step * axis)[0] for axis in np.eye(3)]
        away = self._in_plane(np.stack(beside, axis=1) - near[:, None], False)
        away *= (most / np.maximum(norm(away), 1e-9))[:, None]
        places = places[self.scene.distance(places, places + away)[0] < 0.0][:count]
        if not len(places):
            return np.empty((0, 4, 4))
        headings = normal_numbers(rng, (_HEADINGS, 3))
        every = self._poses(np.repeat(places, _HEADINGS, axis=0), np.tile(headings, (len(places), 1)))
        room = self.room(every).reshape(len(places), _HEADINGS)
        poses = every.reshape(len(places), _HEADINGS, 4, 4)[np.arange(len(places)), np.argmax(room, axis=1)]
        room = room.max(axis=1)
        for k in range(_CLIMBS):
            step = 0.6 * 0.8**k
            twist = normal_numbers(rng, (len(poses), 6)) * step
            twist[:, :3] *= self.length_m
            twist[:, 3] = 0.0
            moved = matmul(poses, se3.exp(twist))
            if self.plane is not None:
                moved = self.plane.poses(moved[:, :3, 3], moved[:, :3, 0])
            found = self.room(moved)
            poses, room = np.where((found > room)[:, None, None], moved, poses), np.maximum(found, room)
        return se3.normalised(poses)

    def _along_tubes(self, rng: np.random.Generator) -> Array:
        """Return poses along the tubes' centrelines, half a swimmer's length apart, from a random place on."""
        out = []
        for tube in self.scene.tubes:
            points = np.array(tube.points_m)
            sides = np.diff(points, axis=0)
            size = norm(sides)
            ends = np.concatenate([[0.0], np.cumsum(size)])
            step = 3.0 * self.length_m
            at = np.arange(float(rng.random()) * step, float(ends[-1]), step)
            side = np.clip(np.searchsorted(ends, at, side="right") - 1, 0, len(size) - 1)
            places = points[side] + ((at - ends[side]) / size[side])[:, None] * sides[side]
            before, after = (self._at(points, ends, at + s * 2.0 * self.length_m) for s in (-1.0, 1.0))
            out.append(self._poses(places, after - before))
        return np.concatenate(out)

    def _at(self, points: Array, ends: Array, at: Array) -> Array:
        return np.stack([np.interp(at, ends, points[:, k]) for k in range(3)], axis=1)


def _poses(places: Array, headings: Array) -> Array:
    """Return poses at places that look in directions. Shapes (n, 3) to (n, 4, 4)."""
    unit = _unit(headings, np.array([1.0, 0.0, 0.0]))
    helper = np.zeros_like(unit)
    helper[np.arange(len(unit)), np.argmin(np.abs(unit), axis=1)] = 1.0
    across = cross(helper, unit)
    across /= norm(across)[:, None]
    return se3.pose(np.stack([unit, across, cross(unit, across)], axis=2), places)


def _unit(vectors: Array, otherwise: Array) -> Array:
    """Return vectors of length 1 along others; of those of no length, another one. Shape (n, 3)."""
    size = norm(vectors)[:, None]
    return np.asarray(np.where(size > 0.0, vectors / np.where(size > 0.0, size, 1.0), otherwise))
