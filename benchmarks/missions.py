"""Plans round obstacles in seeded worlds of five kinds, and says how many are found and what they take.

    python -m benchmarks.missions --out DIR [--only plans|long|ompl] [--count N] [--first N] [--seconds S] [--write]

Each plan's clearance is confirmed by dense sampling with another library's capsules (python-fcl); tubes, which it does
not know, by points on the links and balls along the centrelines. Beside it stands the plan that ignores obstacles.
`--only long` searches for so many seconds of processor time: the thorough search, and again from other seeds while
there is time left. `--only ompl` gives OMPL's planners as long on the same model, with the same obstacles. Each has a
file of its own in the folder, which gains a line a world, so that a run may be done in pieces; `--write` puts tables
of what the files hold into docs/explanation/benchmarks.md.
"""

from __future__ import annotations

import argparse
import functools
import statistics
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from benchmarks import pages
from benchmarks.missions_worlds import KINDS, SWIMMER, confirmed, sampled, world
from benchmarks.resumed import Row, outcomes, printed
from purcell_cli import PlanOptions, plan
from purcell_cli.errors import ParameterError
from purcell_cli.motion.options import Effort
from purcell_cli.motion.verdict import Verdict

LIMIT_S = 10.0
"""Processor time in which a way is wanted [s]."""
PLANNERS = ("RRT", "KPIECE1", "EST")
"""Planners of OMPL that are asked."""


def tried(number: int) -> Row:
    """Plan in a world, and in empty water."""
    kind, (scene, start, goal) = world(number)
    row: Row = {"seed": number, "kind": kind}
    begun = time.process_time()
    try:
        solution = plan(start, goal, swimmer=SWIMMER, options=PlanOptions(obstacles=scene, dt_s=0.2))
    except ParameterError as error:
        return {**row, "verdict": f"no world: {error}"}
    row |= {"verdict": str(solution.verdict), "seconds": time.process_time() - begun}
    row["travel"] = solution.joint_travel_rad
    if solution.verdict == Verdict.REACHED and solution.limits.obstacle is not None:
        row["bound_mm"] = 1e3 * solution.limits.obstacle.distance_m
        row["sampled_mm"] = 1e3 * confirmed(solution.trajectory, SWIMMER, scene)
        if not row["sampled_mm"] >= row["bound_mm"] - 1e-3:
            raise AssertionError(f"{kind} {number}: the bound is above what sampling shows")
    empty = plan(start, goal, swimmer=SWIMMER, options=PlanOptions(dt_s=0.05))
    near = sampled(empty.trajectory, SWIMMER, scene.obstacles)
    row |= {"empty": empty.joint_travel_rad, "deep_mm": max(-1e3 * float(np.min(near)), 0.0)}
    return {**row, "touching": float(np.mean(near < 0.0))}


def searched(seconds: float, number: int) -> Row:
    """Search long in a world: thoroughly, from one seed after the other while time is left."""
    kind, (scene, start, goal) = world(number)
    begun, best, runs = time.process_time(), np.inf, 0
    while time.process_time() - begun < seconds:
        asked = PlanOptions(obstacles=scene, dt_s=0.2, effort=Effort.THOROUGH, seed=runs)
        found, runs = plan(start, goal, swimmer=SWIMMER, options=asked), runs + 1
        if found.verdict == Verdict.REACHED:
            best = min(best, found.joint_travel_rad)
    return {"seed": number, "kind": kind, "travel": best, "seconds": time.process_time() - begun, "searches": runs}


def sampled_by_ompl(seconds: float, number: int) -> Row:
    """Let OMPL's planners look for a way in a world."""
    from benchmarks.missions_ompl import asked_of

    kind, (scene, start, goal) = world(number)
    every = {name: asked_of(name, scene, start, goal, seconds, number) for name in PLANNERS}
    return {"seed": number, "kind": kind, "seconds": seconds, "planners": every}


def table(rows: list[Row], long: list[Row]) -> list[str]:
    """Return what came of the worlds, a line a kind."""
    best = {row["seed"]: row["travel"] for row in long}
    lines = [
        f"| world | found | within {LIMIT_S:g} s | s, median | s, most | travel over empty water's, median "
        "| over the long search's, median | most | worlds | empty plan touches | of its time, median | deepest [mm] |",
        "| --- " * 12 + "|",
    ]
    for kind in KINDS:
        every = [row for row in rows if row["kind"] == kind and "seconds" in row]
        if not every:
            continue
        good = [row for row in every if row["verdict"] == Verdict.REACHED]
        times = [row["seconds"] for row in every]
        over = [row["travel"] / best[row["seed"]] for row in good if row["seed"] in best]
        longer = f"{statistics.median(over):.2f} | {max(over):.2f} | {len(over)}" if over else "- | - | 0"
        hits = [row for row in every if row["deep_mm"] > 0.0]
        touching = f"{100.0 * statistics.median([row['touching'] for row in hits]):.0f} %" if hits else "-"
        lines.append(
            f"| {kind} | {len(good)} of {len(every)} | {sum(row['seconds'] <= LIMIT_S for row in good)} "
            f"| {statistics.median(times):.1f} | {max(times):.1f} "
            f"| {statistics.median([row['travel'] / row['empty'] for row in good]):.2f} | {longer} "
            f"| {len(hits)} of {len(every)} | {touching} | {max(row['deep_mm'] for row in every):.0f} |"
        )
    return lines


def table_of_ompl(rows: list[Row], plans: list[Row]) -> list[str]:
    """Return what OMPL came to, a line a world: how near to the goal each planner comes."""
    ours = {row["seed"]: row for row in plans}
    lines = [
        "| world | this package | " + " | ".join(f"OMPL {name}" for name in PLANNERS) + " |",
        "| --- " * (2 + len(PLANNERS)) + "|",
    ]
    for row in rows:
        mine = ours.get(row["seed"], {})
        told = f"{mine['verdict']} in {mine['seconds']:.1f} s" if mine else "-"
        ends = [row["planners"][name] for name in PLANNERS]
        words = ["no motion" if one["error"] is None else f"{one['error']:.2g} off" for one in ends]
        lines.append(f"| {row['kind']} {row['seed'] // len(KINDS)} | {told} | " + " | ".join(words) + " |")
    return lines


def main() -> None:
    """Go on with the worlds that are not in the files yet, and print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="folder of what was measured")
    parser.add_argument("--only", choices=["plans", "long", "ompl"], default="plans")
    parser.add_argument("--count", type=int, default=50)
    parser.add_argument("--first", type=int, default=0, help="number of the first world; the five kinds take turns")
    parser.add_argument("--seconds", type=float, default=300.0, help="processor time of a long search, or of OMPL")
    parser.add_argument("--write", action="store_true", help="put the tables into the documentation")
    asked = parser.parse_args()
    asked.out.mkdir(parents=True, exist_ok=True)
    work: dict[str, Callable[[int], Row]] = {
        "plans": tried,
        "long": functools.partial(searched, asked.seconds),
        "ompl": functools.partial(sampled_by_ompl, asked.seconds),
    }
    every: dict[str, list[Row]] = {}
    for name, one in work.items():
        numbers = range(asked.first, asked.first + asked.count) if name == asked.only else ()
        every[name] = outcomes(asked.out / f"{name}.jsonl", numbers, one, printed)
    tables = {
        "missions": table(every["plans"], every["long"]),
        "missions by OMPL": table_of_ompl(every["ompl"], every["plans"]),
    }
    for name, lines in tables.items():
        print("\n".join(lines))
        if asked.write:
            pages.put("explanation/benchmarks.md", name, "\n".join(lines))


if __name__ == "__main__":
    main()
