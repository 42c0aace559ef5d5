"""How complete and short the planner is.

    python benchmarks/random_queries.py --count 1000 --jobs 2

Three parts.

Random queries: half are for the paper's swimmer, half for random ones (limb 0.3 to 3 times the base,
slenderness 0.002 to 0.05), of which a third have drags, links or a body of their own, and a third other joints than
ball joints, with ranges, rates and ramps. Poses are 0.01 to 50 L apart, evenly in the logarithm; rotations and limb
orientations are uniform on the rotation group (or as joints have them, and turned by some radians), limbs that
overlap drawn again, but for every fourth query, whose limbs are collinear. Times are those of
library calls, re-integration included: the first one, which makes the tables of a random swimmer, and the
same again, with all tables warm.

Known displacements: joint travel, beside the best known.

Memory: the peak of the command that writes half a million rows. How quick everything else is:
`python -m benchmarks.planner`.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from purcell_cli import Configuration, Effort, PlanOptions, Swimmer, plan
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import from_quaternion
from purcell_cli.mechanics.connection import COLLINEAR

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))  # where random swimmers are
from joint_queries import COMBINATIONS, displacement_of, shape_of
from random_swimmers import jointed, of_its_own, room


def random_rotations(rng: np.random.Generator, count: int) -> np.ndarray:
    """Return rotations uniform on the group. Shape (count, 3, 3)."""
    q = rng.normal(size=(count, 4))
    return from_quaternion(q / np.linalg.norm(q, axis=1, keepdims=True))


def shape(rng: np.random.Generator, swimmer: Swimmer) -> np.ndarray:
    """Return limb orientations, uniform on the rotation group for ball joints, without overlap. Shape (2, 3, 3)."""
    while True:
        limbs = random_rotations(rng, 2) if swimmer.ball_joints else shape_of(rng, swimmer)
        if room(swimmer, limbs[..., 0]) > 0.0:
            return limbs


def query(seed: int) -> tuple[Swimmer, Configuration, Configuration, float]:
    """Return the swimmer, the start, the goal and the distance in L of a numbered query."""
    rng = np.random.default_rng(seed)
    swimmer, joints = Swimmer(), ""
    if seed % 2:
        swimmer = Swimmer(0.1, 0.1 * 0.3 * 10.0 ** rng.random(), 0.002 * 25.0 ** rng.random())
        own = np.random.default_rng(seed)
        if seed % 3 == 0:
            swimmer = of_its_own(own, swimmer)
        elif seed % 3 == 1:
            joints = str(own.choice(list(COMBINATIONS)))
            swimmer = jointed(own, swimmer, COMBINATIONS[joints])
    distance = 0.01 * 5000.0 ** rng.random()
    away = rng.normal(size=3)
    away *= distance * swimmer.length_m / np.linalg.norm(away)
    first, second = random_rotations(rng, 2)
    start, goal = (shape(rng, swimmer) if seed % 4 else COLLINEAR for _ in range(2))
    here, there = se3.pose(first, np.zeros(3)), se3.pose(second, away)
    if joints:
        there = here @ displacement_of(own, swimmer, joints, distance * swimmer.length_m)
    return swimmer, Configuration(here, start), Configuration(there, goal), distance


def outcome(seed: int) -> dict[str, float | int | str]:
    """Plan one query and return its figures."""
    swimmer, start, goal, distance = query(seed)
    took = []
    for _ in range(2):
        began = time.perf_counter()
        solution = plan(start, goal, swimmer=swimmer)
        took.append(time.perf_counter() - began)
    off = solution.certificate.deviation
    return {
        "seed": seed,
        "distance_L": distance,
        "verdict": solution.verdict,
        "error": max(off.position_m / swimmer.length_m, off.base_rad, off.limb1_rad, off.limb2_rad),
        "joint_travel_rad": solution.joint_travel_rad,
        "first_s": took[0],
        "warm_s": took[1],
    }


def random_table(rows: list[dict[str, float | int | str]]) -> list[str]:
    """Return the table of random queries."""
    reached = [r for r in rows if r["verdict"] == "reached"]
    error = max((float(r["error"]) for r in reached), default=math.nan)
    lines = [
        f"{len(reached)} of {len(rows)} reached, largest error {error:.1e} (L, rad).",
        "",
        "| random queries | number | median, warm [s] | 99th percentile [s] | median, first call [s] "
        "| median joint travel [rad] |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for label, near in (("under 3 L", True), ("from 3 L on", False)):
        some = [r for r in rows if (float(r["distance_L"]) < 3) == near]
        if some:
            warm, first, travel = (np.array([r[k] for r in some]) for k in ("warm_s", "first_s", "joint_travel_rad"))
            lines.append(
                f"| {label} | {len(some)} | {np.median(warm):.3f} | {np.percentile(warm, 99):.3f} "
                f"| {np.median(first):.3f} | {np.median(travel):.1f} |"
            )
    return lines


DISPLACEMENTS = (
    ("0.1 L along x", 0.7, 4.52, (0.1, 0, 0), (0, 0, 0)),
    ("0.05 L along y", 1.5, 5.32, (0, 0.05, 0), (0, 0, 0)),
    ("0.05 L along z", 1.5, 5.32, (0, 0, 0.05), (0, 0, 0)),
    ("yaw by 5 degrees", 1.5, 5.72, (0, 0, 0), (5, 0, 0)),
    ("roll by 30 degrees", 1.0, 0.371, (0, 0, 0), (0, 0, 30)),
    ("20 L along x", 1.0, 20 / 0.0451, (20, 0, 0), (0, 0, 0)),
    ("20 L along x", 1.2, 20 / 0.0460, (20, 0, 0), (0, 0, 0)),
    ("(0.1, 0.05, 0.02) L and 5 degrees each", 1.5, 8.72, (0.1, 0.05, 0.02), (5, 5, 5)),
)


def known_table() -> list[str]:
    """Return the table of displacements whose best known joint travel is published with the model."""
    lines = [
        "| displacement | bend limit [rad] | best known [rad] | standard [rad] | thorough [rad] |",
        "| --- | --- | --- | --- | --- |",
    ]
    for label, bend, best, way, turn in DISPLACEMENTS:
        swimmer = Swimmer(max_bend_rad=bend)
        goal = Configuration.from_angles(tuple(swimmer.length_m * np.array(way, dtype=float)), turn)
        found = [
            plan(Configuration(), goal, swimmer=swimmer, options=PlanOptions(effort=effort))
            for effort in (Effort.STANDARD, Effort.THOROUGH)
        ]
        told = [f"{s.joint_travel_rad:.3f}" if s.verdict == "reached" else s.verdict for s in found]
        lines.append(f"| {label} | {bend:g} | {best:.4g} | {told[0]} | {told[1]} |")
    return lines


def shell(goal: str, *options: str) -> tuple[float, float, int]:
    """Return the time [s], peak memory [MB] and rows of one `purcell plan` from the shell."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "start.yaml").write_text("{}\n")
        (folder / "goal.yaml").write_text(goal)
        code = "from purcell_cli.cli.app import main; main()"
        command = [sys.executable, "-c", code, "plan", "start.yaml", "goal.yaml", *options]
        began = time.perf_counter()
        done = subprocess.Popen(command, cwd=folder, stdout=subprocess.DEVNULL)  # noqa: S603  # this program's own words
        _, status, used = os.wait4(done.pid, 0)
        took = time.perf_counter() - began
        if os.waitstatus_to_exitcode(status) != 0:
            raise SystemExit(f"purcell plan ended with {os.waitstatus_to_exitcode(status)} for {goal}")
        with (folder / "trajectory.csv").open("rb") as stream:
            rows = sum(1 for _ in stream) - 1
    return took, used.ru_maxrss / 1024.0, rows


def memory_line() -> str:
    """Return what the command that writes half a million rows takes."""
    goal = "base: {position_m: [94.0, 28.0, 19.0], orientation: {euler_deg: [40, 10, -20]}}\n"
    took, memory, rows = shell(goal, "--dt", "0.04")
    return f"From the shell 1,000 L and {rows} rows take {took:.1f} s and {memory:.0f} MB of memory at most."


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100, help="random queries")
    parser.add_argument("--first", type=int, default=0, help="seed of the first one")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", type=Path, help="a JSON file for every random query's figures")
    parser.add_argument("--random-only", action="store_true", help="leave the other parts out")
    asked = parser.parse_args()
    with multiprocessing.Pool(asked.jobs, initializer=outcome, initargs=(asked.first,)) as pool:
        rows = pool.map(outcome, range(asked.first, asked.first + asked.count), chunksize=4)
    if asked.out:
        asked.out.write_text(json.dumps(rows, indent=1))
    for row in rows:
        if row["verdict"] != "reached":
            print("not reached:", row)
    lines = random_table(rows)
    if not asked.random_only:
        lines = [*known_table(), "", *lines, "", memory_line()]
    print("\n".join(lines))


if __name__ == "__main__":
    main()
