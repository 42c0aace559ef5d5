"""Plans round obstacles in seeded worlds of five kinds, and says how many are found and what they take.

    python benchmarks/missions.py [--count N] [--first SEED] [--kind NAME] [--long]

Each plan's clearance is confirmed by dense sampling with another library's capsules (python-fcl); tubes, which it does
not know, by points on the links and balls along the centrelines. Beside it stands the plan that ignores obstacles, and
with `--long` that of a thorough search, of a minute or more.
"""

from __future__ import annotations

import argparse
import dataclasses
import itertools
import statistics
import time
from collections.abc import Callable

import fcl
import numpy as np

from purcell_cli import Configuration, PlanOptions, Swimmer, plan
from purcell_cli.environment.obstacle import Obstacle
from purcell_cli.environment.scene import Scene
from purcell_cli.environment.solids import Box, Sphere
from purcell_cli.environment.tube import Tube
from purcell_cli.errors import ParameterError
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, from_euler
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.motion.obstacle_distance import link_radii, link_segments
from purcell_cli.motion.options import Effort
from purcell_cli.motion.verdict import Verdict
from purcell_cli.solution import Solution

SWIMMER = Swimmer()
LIMIT_S = 10.0
"""Processor time in which a way is wanted [s]."""

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


def confirmed(solution: Solution, scene: Scene) -> float:
    """Return the least distance between links and obstacles in a plan's rows, by other means than the planner's [m]."""
    rows, swimmer = solution.trajectory, solution.plan.swimmer
    first, last = link_segments(swimmer, rows.pose, rows.shape[..., 0])
    radii, least = link_radii(swimmer), np.inf
    tubes = [one for one in scene.obstacles if isinstance(one, Tube)]
    for low in range(0, len(first) if tubes else 0, 512):
        part = np.linspace(0.0, 1.0, 17)[:, None]
        some = slice(low, low + 512)
        points = first[some, :, None] + part * (last - first)[some, :, None]
        deep = np.full(points.shape[:-1], -np.inf)
        for one in tubes:
            centres = np.array(one.points_m)
            for a, b in itertools.pairwise(centres):
                share = np.clip(((points - a) @ (b - a)) / float((b - a) @ (b - a)), 0.0, 1.0)[..., None]
                deep = np.maximum(deep, one.radii_m[0] - np.linalg.norm(points - a - share * (b - a), axis=-1))
        least = min(least, float(np.min(deep - radii[:, None])))
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


@dataclasses.dataclass(frozen=True)
class Found:
    """What was found in one world."""

    reached: bool
    seconds: float
    travel: float = np.nan
    empty: float = np.nan
    touches: bool = False
    best: float = np.nan


def tried(kind: str, seed: int, long: bool) -> Found | None:
    """Plan in one world, and perhaps search long; None for a world whose start or goal touches."""
    scene, start, goal = KINDS[kind](np.random.default_rng(seed))
    begun = time.process_time()
    try:
        solution = plan(start, goal, swimmer=SWIMMER, options=PlanOptions(obstacles=scene, dt_s=0.2))
    except ParameterError as error:
        print(f"{kind} {seed}: no world: {error}", flush=True)
        return None
    seconds = time.process_time() - begun
    reached = solution.verdict == Verdict.REACHED
    told, near = solution.limits.obstacle, confirmed(solution, scene) if reached else np.nan
    empty = plan(start, goal, swimmer=SWIMMER)
    touches = confirmed(empty, scene) < 0.0
    bound = np.nan if told is None else told.distance_m
    best = np.nan
    if long:
        asked = PlanOptions(obstacles=scene, dt_s=0.2, effort=Effort.THOROUGH)
        longest = plan(start, goal, swimmer=SWIMMER, options=asked)
        best = longest.joint_travel_rad if longest.verdict == Verdict.REACHED else np.nan
    print(
        f"{kind} {seed}: {solution.verdict}, {seconds:.1f} s, {solution.joint_travel_rad:.0f} rad, empty water "
        f"{empty.joint_travel_rad:.0f} rad{' (touches)' if touches else ''}, bound {1e3 * bound:.1f} mm, "
        f"sampled {1e3 * near:.1f} mm{f', long search {best:.0f} rad' if long else ''}",
        flush=True,
    )
    if reached and not near >= bound - 1e-6:
        raise AssertionError(f"{kind} {seed}: the bound is above what sampling shows")
    return Found(reached, seconds, solution.joint_travel_rad, empty.joint_travel_rad, touches, best)


def main() -> None:
    """Plan the worlds, print a line for each and a table at the end."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--kind", choices=[*KINDS])
    parser.add_argument("--long", action="store_true", help="search long, too")
    asked = parser.parse_args()
    found: dict[str, list[Found]] = {}
    for k in range(asked.count):
        kind = asked.kind or list(KINDS)[k % len(KINDS)]
        one = tried(kind, asked.first + k // (1 if asked.kind else len(KINDS)), asked.long)
        if one is not None:
            found.setdefault(kind, []).append(one)
    print(
        f"| world | found | within {LIMIT_S:g} s | s, median | s, most | travel over empty water's, median "
        "| over the long search's, most | empty plan touches |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    for kind, every in found.items():
        good = [one for one in every if one.reached]
        times = [one.seconds for one in every]
        ratio = statistics.median([one.travel / one.empty for one in good]) if good else np.nan
        touch = sum(one.touches for one in every)
        soon = sum(one.seconds <= LIMIT_S for one in good)
        longest = [one.travel / one.best for one in good if np.isfinite(one.best)]
        over = f"{max(longest):.2f}" if longest else "not measured"
        print(
            f"| {kind} | {len(good)} of {len(every)} | {soon} | {statistics.median(times):.1f} | {max(times):.1f} "
            f"| {ratio:.2f} | {over} | {touch} of {len(every)} |"
        )


if __name__ == "__main__":
    main()
