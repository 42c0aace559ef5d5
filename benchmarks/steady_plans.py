"""Adds plans to the motion library that make joint travel grow steadily: along and about axes and diagonals.

    python -m benchmarks.steady_plans --directions 0 1 2 --out plans.jsonl
    python -m benchmarks.steady_plans --add plans.jsonl

Displacements grow by a quarter each until plans take 27 rad. Each search begins with what the planner finds, the
library's best plan and the last plan found, scaled; then all are gone through again from the largest to the smallest,
each beginning with the plan for the next larger one. A plan is kept where the library promises 2 % more or the
planner finds 1 % more. Some minutes a direction.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator
from math import sqrt
from pathlib import Path

import numpy as np

from benchmarks.larger_plans import BODY, NAMED, best
from benchmarks.motion_library import LIBRARY
from purcell_cli import Configuration, Swimmer, plan
from purcell_cli.geometry import se3
from purcell_cli.mechanics.primitives import PrimitiveSequence, joined
from purcell_cli.planner.library.plan_library import library_for

LEAST, LARGER, LEAST_RAD, MOST_RAD, MOST = 0.01, 1.25, 3.0, 26.9, 1.0
"""The least displacement [L, rad], each beside the last, the least joint travel of a plan that is kept and the most
[rad], and the largest displacement: scaled from very small ones, plans promise too much."""
PROMISED, FOUND, KEPT_PRIMITIVES = 1.02, 1.01, 70
"""A plan is kept where the library promises, or the planner finds, so many times its joint travel, and where it has no
more primitives than so many."""


def planned(twist: np.ndarray) -> PrimitiveSequence:
    """Return what the planner finds for a displacement, collinear to collinear, as one sequence."""
    pose = se3.exp(twist)
    pose[:3, 3] *= Swimmer().length_m
    blocks = plan(Configuration(), Configuration(pose)).plan.blocks
    return joined([b.sequence.times(b.cycles) for b in blocks if isinstance(b.sequence, PrimitiveSequence)])


def steady(direction: np.ndarray) -> Iterator[PrimitiveSequence]:
    """Yield plans for ever more of a twist, those that the library and the planner have not as short."""
    library, known = library_for(BODY), list[tuple[np.ndarray, PrimitiveSequence, float, float]]()
    amount, bigger = LEAST, sqrt(LARGER)
    while amount < MOST and (not known or known[-1][1].joint_travel_rad < MOST_RAD):
        twist = amount * direction
        goal, own = se3.exp(twist), planned(twist)
        entry = next(library.nearest(goal[None], np.zeros(1), 1))
        starts = [own, entry.lap.times(entry.laps)]
        if known:
            starts.append(known[-1][1].with_angles(bigger * known[-1][1].angle))
        short = min(best(goal, starts) or own, own, key=lambda p: p.joint_travel_rad)
        known.append((goal, short, own.joint_travel_rad, entry.estimate_rad))
        print(
            f"{amount:.4f}: {entry.estimate_rad:.2f}, {own.joint_travel_rad:.2f} -> {short.joint_travel_rad:.2f} rad",
            flush=True,
        )
        amount *= LARGER
    for k in range(len(known) - 2, -1, -1):
        goal, short, own_rad, promised_rad = known[k]
        next_one = known[k + 1][1]
        back = best(goal, [next_one.with_angles(next_one.angle / bigger)])
        if back is not None and back.joint_travel_rad < short.joint_travel_rad:
            print(f"  back: {short.joint_travel_rad:.2f} -> {back.joint_travel_rad:.2f} rad", flush=True)
            known[k] = goal, back, own_rad, promised_rad
    for _, short, own_rad, promised_rad in known:
        better = promised_rad > PROMISED * short.joint_travel_rad or own_rad > FOUND * short.joint_travel_rad
        if better and len(short) <= KEPT_PRIMITIVES and LEAST_RAD < short.joint_travel_rad < MOST_RAD:
            yield short


def main() -> None:
    """Find plans, or add those that were found to the library."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--directions", type=int, nargs="*", default=range(len(NAMED)), help="which of nine directions")
    parser.add_argument("--out", type=Path, help="a file that found plans are added to, one a line")
    parser.add_argument("--add", type=Path, nargs="*", default=(), help="files whose plans join the library")
    asked = parser.parse_args()
    if asked.add:
        plans = json.loads(LIBRARY.read_text(encoding="ascii"))["plans"]
        plans += [json.loads(line) for file in asked.add for line in file.read_text(encoding="ascii").splitlines()]
        LIBRARY.write_text('{"plans": [\n' + ",\n".join(json.dumps(w) for w in plans) + "\n]}\n", encoding="ascii")
        return
    for k in asked.directions:
        direction = np.array(NAMED[k]) / np.linalg.norm(NAMED[k])
        print(direction.round(3).tolist(), flush=True)
        for short in steady(direction):
            if asked.out:
                row = {"control": short.control.tolist(), "angle": np.round(short.angle, 6).tolist()}
                with asked.out.open("a", encoding="ascii") as file:
                    print(json.dumps(row), file=file)


if __name__ == "__main__":
    main()
