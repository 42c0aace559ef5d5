"""Time and joint travel of plans, by class of query: from tiny displacements to far goals.

    python -m benchmarks.classes --count 40 --thorough 3 --write

Times are those of the processor, for library calls with all tables warm. `--thorough` compares the first few queries
of each class with `--effort thorough`, minutes each. `--write` puts the table into docs/explanation/planner.md.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from benchmarks import pages
from benchmarks.random_queries import random_rotations, shape
from purcell_cli import Configuration, Effort, PlanOptions, Solution, Swimmer, plan
from purcell_cli.geometry import se3
from purcell_cli.mechanics.connection import COLLINEAR

CLASSES = {
    "tiny": (0.005, 0.05, False, False),
    "small": (0.05, 0.3, False, False),
    "small, bent": (0.05, 0.3, True, False),
    "mid": (0.3, 3.0, False, True),
    "mid, bent": (0.3, 3.0, True, True),
    "near": (3.0, 10.0, True, True),
    "far": (10.0, 50.0, True, True),
}
"""Of each class: the nearest and the farthest [L], whether limbs are bent (else straight at both ends), and whether
rotations are uniform on the group (else at most as many rad as the distance is L)."""


def query(name: str, seed: int) -> tuple[Configuration, Configuration]:
    """Return the start and the goal of a numbered query of a class."""
    nearest, farthest, bent, turned = CLASSES[name]
    rng, swimmer = np.random.default_rng([list(CLASSES).index(name), seed]), Swimmer()
    distance = nearest * (farthest / nearest) ** rng.random()
    away, turn = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
    small = se3.exp(np.concatenate([np.zeros(3), distance * rng.random() * turn]))[:3, :3]
    rotation = random_rotations(rng, 1)[0] if turned else small
    first, last = (shape(rng, swimmer) if bent else COLLINEAR for _ in range(2))
    end = se3.pose(rotation, distance * swimmer.length_m * away)
    return Configuration(np.eye(4), first), Configuration(end, last)


def timed(name: str, seed: int, options: PlanOptions) -> tuple[Solution, float]:
    """Return the plan of a query, and the processor's time for it [s]."""
    ends = query(name, seed)
    began = time.process_time()
    found = plan(*ends, options=options)
    return found, time.process_time() - began


def row(name: str, count: int, thorough: int) -> str:
    """Return a class's row of the table."""
    standard, widest = (PlanOptions(effort=effort, max_memory_gb=4.0) for effort in (Effort.STANDARD, Effort.THOROUGH))
    timed(name, count, standard)
    found = [timed(name, seed, standard) for seed in range(count)]
    reached = sum(s.verdict == "reached" for s, _ in found)
    times, travel = np.array([t for _, t in found]), [s.joint_travel_rad for s, _ in found]
    told = "| not measured " * 4 + "|"
    if thorough:
        wide = [timed(name, seed, widest) for seed in range(thorough)]
        excess = np.array(travel[:thorough]) / [s.joint_travel_rad for s, _ in wide] - 1.0
        lasted = [t for _, t in wide]
        told = f"| {np.mean(excess):.1%} | {np.max(excess):.1%} | {np.median(lasted):.1f} | {np.max(lasted):.1f} |"
    return (
        f"| {name} | {reached} of {count} | {np.median(times):.3f} | {np.percentile(times, 99):.3f} "
        f"| {np.max(times):.3f} | {np.mean(travel):.1f} {told}"
    )


def main() -> None:
    """Measure, print and perhaps write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=40, help="queries of each class")
    parser.add_argument("--thorough", type=int, default=0, help="how many of them are compared with thorough plans")
    parser.add_argument("--only", nargs="*", default=list(CLASSES), choices=list(CLASSES), metavar="CLASS")
    parser.add_argument("--write", action="store_true", help="put the table into docs/explanation/planner.md")
    asked = parser.parse_args()
    lines = [
        "| class | reached | median [s] | 99th percentile [s] | worst [s] | mean joint travel [rad] "
        "| above thorough, mean | above thorough, worst | thorough, median [s] | thorough, worst [s] |",
        "| --- " * 10 + "|",
    ]
    for name in asked.only:
        lines.append(row(name, asked.count, asked.thorough))
        print(lines[-1], flush=True)
    text = "\n".join(lines)
    print(text)
    if asked.write:
        pages.put("explanation/planner.md", "classes", text)


if __name__ == "__main__":
    main()
