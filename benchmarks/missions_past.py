"""Missions through waypoints past obstacles, in a workspace: how many are found, and what they take.

    python -m benchmarks.missions_past --count 20 --out past.jsonl --write

Each seeded world has a box that all links stay in, fifteen balls of 1 to 2 L in it, and three waypoints between the
start and the goal, of which the second names a limb, too. Each plan's clearance is confirmed by dense sampling with
another library (python-fcl); the certificate says that waypoints are passed. Beside it stands the mission in empty
water. `--out` gains a line a mission, so that a run may be done in pieces.
"""

from __future__ import annotations

import argparse
import statistics
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import pages
from benchmarks.missions_worlds import confirmed
from benchmarks.resumed import outcomes, printed
from purcell_cli import Configuration, Mission, PlanOptions, Waypoint, plan_mission
from purcell_cli.environment.obstacle import Obstacle
from purcell_cli.environment.scene import Scene
from purcell_cli.environment.solids import Sphere
from purcell_cli.errors import ParameterError
from purcell_cli.geometry.rotations import from_euler
from purcell_cli.motion.verdict import Verdict
from purcell_cli.motion.workspace import Workspace

BALLS = 15
"""Balls of a world."""
ROOM_M = 0.15
"""How far waypoints are from balls [m]."""


def world(seed: int) -> tuple[Mission, Scene, Workspace]:
    """Return a mission, and what stands in its way."""
    rng = np.random.default_rng(seed)
    balls: list[Sphere] = []
    ends = [np.array([x, *rng.uniform(-0.3, 0.3, 2)]) for x in (0.0, 1.8)]
    while len(balls) < BALLS:
        place, radius = rng.uniform([-0.2, -0.8, -0.8], [2.0, 0.8, 0.8]), float(rng.uniform(0.1, 0.2))
        if min(float(np.linalg.norm(place - end)) for end in ends) > radius + 0.35:
            balls.append(Sphere((float(place[0]), float(place[1]), float(place[2])), radius))
    via: list[Waypoint] = []
    while len(via) < 3:
        place = np.array([0.45 * (len(via) + 1), *rng.uniform(-0.5, 0.5, 2)])
        if min(float(np.linalg.norm(place - one.centre_m)) - one.radius_m for one in balls) > ROOM_M:
            limb = from_euler(np.radians([20.0, 0.0, 0.0])) if len(via) == 1 else None
            via.append(Waypoint(place, limb1=limb))
    start, goal = (
        Configuration.from_angles(tuple(end.tolist()), (*tuple(rng.uniform(-40.0, 40.0, 2)), 0.0)) for end in ends
    )
    obstacles: list[Obstacle] = [*balls]
    return Mission(start, goal, tuple(via)), Scene(tuple(obstacles)), Workspace((-0.8, -1.1, -1.1), (2.6, 1.1, 1.1))


def outcome(seed: int) -> dict[str, Any]:
    """Plan one mission and return its figures."""
    mission, scene, box = world(seed)
    told: dict[str, Any] = {"seed": seed}
    begun = time.process_time()
    try:
        found = plan_mission(mission, options=PlanOptions(obstacles=scene, workspace=box, dt_s=0.2))
    except ParameterError as error:
        return {**told, "verdict": f"refused: {error}", "seconds": time.process_time() - begun}
    told |= {"verdict": str(found.verdict), "seconds": time.process_time() - begun, "travel": found.joint_travel_rad}
    told["blocked"] = None if found.plan.blocked is None else found.plan.blocked.words
    if found.verdict == Verdict.REACHED:
        told["empty"] = plan_mission(mission, options=PlanOptions(dt_s=0.2)).joint_travel_rad
        near, bound = confirmed(found.trajectory, found.plan.swimmer, scene), found.limits.obstacle
        told["sampled_m"], told["bound_m"] = near, None if bound is None else bound.distance_m
        if bound is None or not near >= bound.distance_m - 1e-6:
            raise AssertionError(f"{seed}: the bound is above what sampling shows")
    return told


def table(rows: list[dict[str, Any]]) -> list[str]:
    """Return what came of missions, as lines of Markdown."""
    good = [row for row in rows if row["verdict"] == Verdict.REACHED]
    times, over = [row["seconds"] for row in rows], [row["travel"] / row["empty"] for row in good]
    return [
        "| missions | found | s, median | s, most | travel over empty water's, median | most | least clearance [mm] |",
        "| --- | --- | --- | --- | --- | --- | --- |",
        f"| {len(rows)} | {len(good)} | {statistics.median(times):.1f} | {max(times):.1f} "
        f"| {statistics.median(over):.2f} | {max(over):.2f} | {1e3 * min(row['sampled_m'] for row in good):.1f} |",
    ]


def main() -> None:
    """Plan the missions that are not in the file yet, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--out", type=Path, required=True, help="gains a line a mission")
    parser.add_argument("--seconds", type=float, default=1e9, help="begin no mission after so much processor time")
    parser.add_argument("--write", action="store_true", help="put the table into the documentation")
    asked = parser.parse_args()
    seeds = range(asked.count)
    rows = outcomes(asked.out, seeds, outcome, printed, lambda: time.process_time() <= asked.seconds)
    lines = table(rows)
    print("\n".join(lines))
    if asked.write:
        pages.put("how-to/obstacles.md", "missions past obstacles", "\n".join(lines))


if __name__ == "__main__":
    main()
