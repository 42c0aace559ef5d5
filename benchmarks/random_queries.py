"""Random reconfigurations: how many are reached, how exactly, how fast, how far the joints travel.

    python benchmarks/random_queries.py --count 1000 --jobs 2

Half of the queries are for the paper's swimmer, half for random ones (limb 0.3 to 3 times the base,
slenderness 0.002 to 0.05). Poses are 0.01 to 50 L apart, evenly in the logarithm; rotations and
limb orientations are uniform on the rotation group, limbs that overlap drawn again, but for every
fourth query, whose limbs are collinear. Times are those of one warm library call, re-integration included.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import time
from pathlib import Path

import numpy as np

from purcell_cli import Configuration, Swimmer, plan, se3
from purcell_cli.clearance import limb_distance
from purcell_cli.connection import COLLINEAR
from purcell_cli.rotations import from_quaternion


def random_rotations(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return rotations uniform on the group. Shape (count, 3, 3)."""
    q = rng.normal(size=(count, 4))
    return from_quaternion(q / np.linalg.norm(q, axis=1, keepdims=True))


def shape(rng: np.random.Generator, swimmer: Swimmer) -> np.ndarray:
    """Return limb orientations uniform on the rotation group, drawn again while the limbs overlap. Shape (2, 3, 3)."""
    while True:
        limbs = random_rotations(rng, 2)
        if limb_distance(swimmer, limbs[..., 0]) > 0.0:
            return limbs


def query(seed: int) -> tuple[Swimmer, Configuration, Configuration, float]:
    """Return the swimmer, the start, the goal and the distance in L of a numbered query."""
    rng = np.random.default_rng(seed)
    swimmer = Swimmer()
    if seed % 2:
        swimmer = Swimmer(0.1, 0.1 * 0.3 * 10.0 ** rng.random(), 0.002 * 25.0 ** rng.random())
    distance = 0.01 * 5000.0 ** rng.random()
    away = rng.normal(size=3)
    away *= distance * swimmer.length_m / np.linalg.norm(away)
    first, second = random_rotations(rng, 2)
    start, goal = (shape(rng, swimmer) if seed % 4 else COLLINEAR for _ in range(2))
    start, goal = Configuration(se3.pose(first, np.zeros(3)), start), Configuration(se3.pose(second, away), goal)
    return swimmer, start, goal, distance


def outcome(seed: int) -> dict[str, float | int | str]:
    """Plan one query and return its figures."""
    swimmer, start, goal, distance = query(seed)
    began = time.perf_counter()
    solution = plan(start, goal, swimmer)
    took = time.perf_counter() - began
    off = solution.certificate.deviation
    return {
        "seed": seed,
        "distance_L": distance,
        "verdict": solution.verdict,
        "error": max(off.position_m / swimmer.length_m, off.base_rad, off.limb1_rad, off.limb2_rad),
        "joint_travel_rad": solution.joint_travel_rad,
        "time_s": took,
        "rows": len(solution.trajectory),
    }


def main() -> None:
    """Run the queries and print their figures."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="seed of the first query")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", type=Path, help="a JSON file for every query's figures")
    asked = parser.parse_args()
    outcome(asked.first)  # warm up
    with multiprocessing.Pool(asked.jobs, initializer=outcome, initargs=(asked.first,)) as pool:
        rows = pool.map(outcome, range(asked.first, asked.first + asked.count), chunksize=4)
    reached = [r for r in rows if r["verdict"] == "reached"]
    print(f"{len(reached)} of {len(rows)} reached")
    for row in rows:
        if row["verdict"] != "reached":
            print("  not reached:", row)
    if reached:
        error = np.array([r["error"] for r in reached])
        print(f"largest error of those reached: {error.max():.1e} (L, rad)")
    for label, some in (
        ("near (under 3 L)", [r for r in rows if r["distance_L"] < 3]),
        ("far", [r for r in rows if r["distance_L"] >= 3]),
    ):
        if some:
            times, travel = (np.array([r[k] for r in some]) for k in ("time_s", "joint_travel_rad"))
            print(
                f"{label}: {len(some)} queries, time median {np.median(times):.3f} s, 99th percentile "
                f"{np.percentile(times, 99):.3f} s; joint travel median {np.median(travel):.1f} rad"
            )
    if asked.out:
        asked.out.write_text(json.dumps(rows, indent=1))


if __name__ == "__main__":
    main()
