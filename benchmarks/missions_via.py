"""How much less joint travel a mission through waypoints takes than plans from each waypoint to the next.

Each of the random missions has waypoints that all name a position; some name an orientation or a limb too. The
separate plans take what a waypoint leaves free as it was before it, or as a configuration's file has it: level and
straight. Run: python benchmarks/missions_via.py [--missions 100] [--waypoints 5] [--seconds 300]
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from purcell_cli import Configuration, Mission, Waypoint, plan_mission
from purcell_cli.solution import planned

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


def main() -> None:
    """Measure, and print a line for each mission and the whole."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--missions", type=int, default=100)
    parser.add_argument("--waypoints", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=300.0, help="begin no mission after so much processor time")
    asked = parser.parse_args()
    shares, seconds, reached = [], [], 0
    for seed in range(asked.missions):
        if time.process_time() > asked.seconds:
            break
        mission = random_mission(seed, asked.waypoints)
        begun = time.process_time()
        found = plan_mission(mission)
        seconds.append(time.process_time() - begun)
        reached += found.verdict == "reached"
        apart = [separate_rad(mission, kept) for kept in (True, False)]
        shares.append([found.joint_travel_rad / one for one in apart])
        print(
            f"{seed:3d}  {found.verdict}  {found.joint_travel_rad:8.1f} rad in {seconds[-1]:5.2f} s; "
            f"separate plans: kept {apart[0]:8.1f} rad, level {apart[1]:8.1f} rad",
            flush=True,
        )
    share = np.array(shares)
    print(f"{len(share)} missions of {asked.waypoints} waypoints, {reached} reached, {np.median(seconds):.2f} s each")
    for k, name in enumerate(("kept as before", "level and straight")):
        below = np.count_nonzero(share[:, k] < 1.0)
        print(
            f"joint travel over that of separate plans, free parts {name}: mean {share[:, k].mean():.3f}, "
            f"from {share[:, k].min():.3f} to {share[:, k].max():.3f}; below 1 in {below}"
        )


if __name__ == "__main__":
    main()
