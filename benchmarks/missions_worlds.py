"""Seeded worlds of five kinds with obstacles, and what plans come to in them by other means than the planner's."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import fcl
import numpy as np

from purcell_cli import Configuration, Swimmer
from purcell_cli.environment.obstacle import Obstacle
from purcell_cli.environment.scene import Scene
from purcell_cli.environment.solids import Box, Sphere
from purcell_cli.environment.tube import Tube
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, from_euler
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.motion.obstacle_distance import link_radii, link_segments
from purcell_cli.motion.trajectory import Trajectory

SWIMMER = Swimmer()
World = tuple[Scene, Configuration, Configuration]


def collinear(place: Array, yaw_deg: float, pitch_deg: float = 0.0) -> Configuration:
    """Return a collinear configuration."""
    return Configuration(se3.pose(from_euler(np.radians([yaw_deg, pitch_deg, 0.0])), place), COLLINEAR)


def slab(low: list[float], high: list[float]) -> Box:
    """Return the box between two corners [m]."""
    middle, size = (0.5 * np.add(low, high)).tolist(), np.subtract(high, low).tolist()
    return Box((middle[0], middle[1], middle[2]), (size[0], size[1], size[2]))


def curve(points: Array, radius: float) -> Tube:
    """Return a tube of one radius round points."""
    return Tube(tuple((float(x), float(y), float(z)) for x, y, z in points), (radius,) * len(points))


def wall(rng: np.random.Generator) -> World:
    """A wall with a window of 2.5 to 5 L, start and goal on either side."""
    width, height = rng.uniform(0.25, 0.5, 2)
    boxes = [slab([-0.025, s, -1.5], [0.025, 1.5 + s - width / 2, 1.5]) for s in [width / 2]]
    boxes.append(slab([-0.025, -1.5, -1.5], [0.025, -width / 2, 1.5]))
    boxes.append(slab([-0.025, -width / 2, height / 2], [0.025, width / 2, 1.5]))
    boxes.append(slab([-0.025, -width / 2, -1.5], [0.025, width / 2, -height / 2]))
    ends = [
        collinear(
            np.array([s * rng.uniform(0.6, 1.2), *rng.uniform(-0.6, 0.6, 2)]),
            *rng.uniform(-60.0, 60.0, 2),
        )
        for s in (-1.0, 1.0)
    ]
    return Scene(tuple(boxes)), ends[0], ends[1]


def forest(rng: np.random.Generator) -> World:
    """Thirty balls of 1 to 2 L between start and goal, 24 L apart."""
    ends = [collinear(np.array([x, *rng.uniform(-0.3, 0.3, 2)]), *rng.uniform(-40.0, 40.0, 2)) for x in (0.0, 2.4)]
    balls: list[Obstacle] = []
    while len(balls) < 30:
        place, radius = rng.uniform([0.0, -0.8, -0.8], [2.4, 0.8, 0.8]), rng.uniform(0.1, 0.2)
        if min(float(np.linalg.norm(place - e.pose[:3, 3])) for e in ends) > radius + 0.35:
            balls.append(Sphere((float(place[0]), float(place[1]), float(place[2])), float(radius)))
    return Scene(tuple(balls)), ends[0], ends[1]


def tube(rng: np.random.Generator) -> World:
    """A tube of 1.6 to 2.5 L radius that bends by 50 to 110 degrees on a circle of 12 to 20 L."""
    circle, bend, radius = rng.uniform(1.2, 2.0), np.radians(rng.uniform(50.0, 110.0)), rng.uniform(0.16, 0.25)
    angle = np.linspace(0.0, bend, 24)
    arc = np.stack([circle * np.sin(angle), circle - circle * np.cos(angle), 0.0 * angle], axis=1)
    along = np.array([np.cos(bend), np.sin(bend), 0.0])
    points = np.concatenate([[[-0.8, 0.0, 0.0]], arc, arc[-1:] + 0.8 * along])
    goal = collinear(arc[-1] + 0.3 * along, float(np.degrees(bend)))
    return Scene((curve(points, radius),)), collinear(np.array([-0.3, 0.0, 0.0]), 0.0), goal


def branch(rng: np.random.Generator) -> World:
    """A vessel of 2 to 3 L radius that branches; from the trunk into one of two branches."""
    radius, turns = rng.uniform(0.2, 0.3), np.radians([rng.uniform(30.0, 70.0), -rng.uniform(30.0, 70.0)])
    tubes, ends = [curve(np.array([[-1.0, 0.0, 0.0], [0.2, 0.0, 0.0]]), radius)], []
    for turn in turns:
        along = np.array([np.cos(turn), np.sin(turn), 0.0])
        tubes.append(curve(np.stack([np.zeros(3), 1.6 * along]), 0.9 * radius))
        ends.append(collinear(1.1 * along, float(np.degrees(turn))))
    return Scene(tuple(tubes)), collinear(np.array([-0.5, 0.0, 0.0]), 0.0), ends[int(rng.integers(2))]


def corner(rng: np.random.Generator) -> World:
    """A corridor 4.5 to 6 L wide round a corner of 90 degrees, too tight to swim round it forwards in one go."""
    width, height, wall_ = rng.uniform(0.45, 0.6), rng.uniform(0.5, 0.7), 0.1
    reach, half = 1.6, 0.5 * width
    boxes = [
        slab([-reach, half, -height / 2], [half - width, half + wall_, height / 2]),
        slab([-reach, -half - wall_, -height / 2], [half + wall_, -half, height / 2]),
        slab([half, -half, -height / 2], [half + wall_, reach, height / 2]),
        slab([-half - wall_, half, -height / 2], [-half, reach, height / 2]),
        slab([-reach, -half - wall_, height / 2], [half + wall_, reach, height / 2 + wall_]),
        slab([-reach, -half - wall_, -height / 2 - wall_], [half + wall_, reach, -height / 2]),
    ]
    return Scene(tuple(boxes)), collinear(np.array([-1.1, 0.0, 0.0]), 0.0), collinear(np.array([0.0, 1.1, 0.0]), 90.0)


KINDS: dict[str, Callable[[np.random.Generator], World]] = {
    "wall": wall,
    "forest": forest,
    "tube": tube,
    "branch": branch,
    "corner": corner,
}


def world(number: int) -> tuple[str, World]:
    """Return the kind of a numbered world, and the world: the kinds take turns."""
    kind = [*KINDS][number % len(KINDS)]
    return kind, KINDS[kind](np.random.default_rng(number // len(KINDS)))


def confirmed(rows: Trajectory, swimmer: Swimmer, scene: Scene) -> float:
    """Return the least distance between links and obstacles in a plan's rows, by other means than the planner's [m].

    Solids by another library's capsules, tubes by points on the links.
    """
    tubes = tuple(one for one in scene.obstacles if isinstance(one, Tube))
    least = float(np.min(sampled(rows, swimmer, tubes))) if tubes else np.inf
    first, last = link_segments(swimmer, rows.pose, rows.shape[..., 0])
    radii = link_radii(swimmer)
    solids = [shape for one in scene.obstacles if (shape := as_fcl(one)) is not None]
    if solids:
        manager = fcl.DynamicAABBTreeCollisionManager()
        manager.registerObjects(solids)
        manager.setup()
        for link, radius in enumerate(radii.tolist()):
            size = float(np.linalg.norm(last[0, link] - first[0, link]))
            for a, b in zip(first[:, link], last[:, link], strict=True):
                body = fcl.CollisionObject(fcl.Capsule(radius, size), placed(0.5 * (a + b), b - a))
                found = fcl.DistanceData()
                manager.distance(body, found, fcl.defaultDistanceCallback)
                least = min(least, found.result.min_distance)
    return least


def sampled(rows: Trajectory, swimmer: Swimmer, obstacles: tuple[Obstacle, ...]) -> Array:
    """Return how far points on the links are from obstacles in each row, negative inside [m]. Shape (n,)."""
    first, last = link_segments(swimmer, rows.pose, rows.shape[..., 0])
    part, out = np.linspace(0.0, 1.0, 17)[:, None], []
    for low in range(0, len(first), 512):
        a, b = first[low : low + 512, :, None], last[low : low + 512, :, None]
        points = a + part * (b - a)
        least, inside = np.full(points.shape[:-1], np.inf), np.full(points.shape[:-1], -np.inf)
        for one in obstacles:
            if isinstance(one, Tube):
                inside = np.maximum(inside, in_tube(points, one))
            elif isinstance(one, Sphere):
                least = np.minimum(least, np.linalg.norm(points - one.centre_m, axis=-1) - one.radius_m)
            elif isinstance(one, Box):
                beyond = np.abs((points - one.centre_m) @ np.array(one.orientation)) - 0.5 * np.array(one.size_m)
                out_of = np.linalg.norm(np.maximum(beyond, 0.0), axis=-1)
                least = np.minimum(least, out_of + np.minimum(np.max(beyond, axis=-1), 0.0))
        if any(isinstance(one, Tube) for one in obstacles):
            least = np.minimum(least, inside)
        out.append(np.min(least - link_radii(swimmer)[:, None], axis=(1, 2)))
    return np.concatenate(out)


def in_tube(points: Array, one: Tube) -> Array:
    """Return how far points are from the wall of a tube of one radius, negative outside [m]. (..., 3) to (...)."""
    deep = np.full(points.shape[:-1], -np.inf)
    for a, b in itertools.pairwise(np.array(one.points_m)):
        share = np.clip(((points - a) @ (b - a)) / float((b - a) @ (b - a)), 0.0, 1.0)[..., None]
        deep = np.maximum(deep, one.radii_m[0] - np.linalg.norm(points - a - share * (b - a), axis=-1))
    return deep


def placed(middle: Array, along: Array) -> fcl.Transform:
    """Return the placement of a capsule, which lies along z, by its middle and its axis."""
    z = along / np.linalg.norm(along)
    helper = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = np.cross(helper, z)
    x /= np.linalg.norm(x)
    return fcl.Transform(np.stack([x, np.cross(z, x), z], axis=1), middle)


def as_fcl(one: Obstacle) -> fcl.CollisionObject | None:
    """Return a solid of that library; None for a tube."""
    if isinstance(one, Sphere):
        return fcl.CollisionObject(fcl.Sphere(one.radius_m), fcl.Transform(np.array(one.centre_m)))
    if isinstance(one, Box):
        return fcl.CollisionObject(
            fcl.Box(*one.size_m), fcl.Transform(np.array(one.orientation), np.array(one.centre_m))
        )
    return None
