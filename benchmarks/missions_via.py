"""How much less joint travel a mission through waypoints takes than plans from each waypoint to the next.

Each of the random missions has waypoints that all name a position; some name an orientation or a limb too. The
separate plans take what a waypoint leaves free as it was before it, or as a configuration's file has it: level and
straight.

    python -m benchmarks.missions_via --missions 100 --out via.jsonl --write

`--out` gains a line a mission, so that a run may be done in pieces: the table is of all of its lines. `--write` puts it
into docs/how-to/missions.md.
"""

from __future__ import annotations

import argparse
import statistics
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import pages
from benchmarks.resumed import outcomes, printed
from purcell_cli import Configuration, Mission, Waypoint, plan_mission
from purcell_cli.motion.verdict import Verdict
from purcell_cli.planning import planned

SIDE_L = 10.0
"""Side of the cube that positions are in [L]."""
ORIENTED, BENT = 0.3, 0.2
"""Parts of the waypoints that name an orientation, and a limb."""


def random_mission(seed: int, waypoints: int) -> Mission:
    """Return a mission from the origin through random waypoints."""
    rng = np.random.default_rng(seed)

    def place() -> np.ndarray:
        return rng.uniform(-0.5 * SIDE_L, 0.5 * SIDE_L, 3) * 0.1

    via = []
    for _ in range(waypoints):
        other = Configuration.from_angles(
            base_euler_deg=60.0 * rng.normal(size=3), limb1_euler_deg=20.0 * rng.normal(size=3)
        )
        turn = other.pose[:3, :3] if rng.random() < ORIENTED else None
        via.append(Waypoint(place(), turn, other.shape[0] if rng.random() < BENT else None))
    goal = Configuration.from_angles(place(), 60.0 * rng.normal(size=3))
    return Mission(Configuration(), goal, tuple(via))


def separate_rad(mission: Mission, kept: bool) -> float:
    """Return the joint travel of plans from each waypoint to the next [rad]."""
    here, spent, level = mission.start, 0.0, Configuration()
    for waypoint in mission.via:
        there = waypoint.filled(here if kept else level)
        spent += planned(here, there).joint_travel_rad
        here = there
    return spent + planned(here, mission.goal).joint_travel_rad


def outcome(seed: int, waypoints: int) -> dict[str, Any]:
    """Plan one mission, and the separate plans beside it, and return their figures."""
    mission = random_mission(seed, waypoints)
    begun = time.process_time()
    found = plan_mission(mission)
    told = {"seed": seed, "verdict": str(found.verdict), "seconds": time.process_time() - begun}
    kept, level = (separate_rad(mission, one) for one in (True, False))
    return {**told, "travel": found.joint_travel_rad, "kept": kept, "level": level}


def table(rows: list[dict[str, Any]]) -> list[str]:
    """Return what came of missions, as lines of Markdown."""
    reached = [row for row in rows if row["verdict"] == Verdict.REACHED]
    seconds = [row["seconds"] for row in rows]
    lines = [
        f"{len(reached)} of {len(rows)} missions reached, in {statistics.median(seconds):.1f} s of processor time in "
        f"the median and {max(seconds):.1f} s at most.",
        "",
        "| joint travel over that of plans from each waypoint to the next | mean | least | most | less in |",
        "| --- | --- | --- | --- | --- |",
    ]
    for key, name in (
        ("kept", "what is free kept as it was at the waypoint before"),
        ("level", "what is free as a configuration's file has it, level and straight"),
    ):
        share = np.array([row["travel"] / row[key] for row in reached])
        less = f"{np.count_nonzero(share < 1.0)} of {len(share)}"
        lines.append(f"| {name} | {share.mean():.2f} | {share.min():.2f} | {share.max():.2f} | {less} |")
    return lines


def main() -> None:
    """Plan the missions that are not in the file yet, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--missions", type=int, default=100)
    parser.add_argument("--waypoints", type=int, default=5)
    parser.add_argument("--from", dest="first", type=int, default=0, help="the first mission's seed")
    parser.add_argument("--out", type=Path, required=True, help="gains a line a mission")
    parser.add_argument("--seconds", type=float, default=1e9, help="begin no mission after so much processor time")
    parser.add_argument("--write", action="store_true", help="put the table into the documentation")
    asked = parser.parse_args()
    seeds = range(asked.first, asked.first + asked.missions)
    rows = outcomes(
        asked.out,
        seeds,
        lambda seed: outcome(seed, asked.waypoints),
        printed,
        lambda: time.process_time() <= asked.seconds,
    )
    lines = table(rows)
    print("\n".join(lines))
    if asked.write:
        pages.put("how-to/missions.md", "missions via", "\n".join(lines))


if __name__ == "__main__":
    main()
