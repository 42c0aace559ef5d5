"""How far standard and thorough plans are from the best that a long search finds, by class of query.

    python -m benchmarks.long_search --count 2 --seconds 240 --out long.jsonl --write

The long search is a thorough one, and then the best plan so far shaken and shortened again and again, until so many
seconds of processor time are spent on a query; 14 queries of 240 s are about an hour. `--out` gains a line a query, so
that a run may be done in pieces; `--write` puts the table into docs/explanation/planner.md.
"""

from __future__ import annotations

import argparse
import dataclasses
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import pages
from benchmarks.classes import CLASSES, query
from benchmarks.resumed import outcomes, printed
from purcell_cli import PlanOptions, Swimmer, plan, stored_gaits
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.motion.limits import Limits
from purcell_cli.planner.exploration import Exploration
from purcell_cli.planner.limbs.quarter_rolls import QuarterRolls
from purcell_cli.planner.reconfiguration import careful_bend_rad, searched
from purcell_cli.planner.refine.minimum_travel import Pace
from purcell_cli.planner.refine.segments import free_primitives
from purcell_cli.planner.refine.shooting import Equations

SHAKEN = (0.03, 0.1, 0.25)
"""Standard deviations of the relative changes of the best plan's angles, in turn."""
LONG = Pace(rounds=3, steps=40, price=300.0, longest=300, work=6000, own=True)
"""How long what is shaken is shortened."""


def shaken(motion: Equations, part: float, rng: np.random.Generator) -> Equations:
    """Return a motion whose free angles are all a little others."""
    return motion.of(motion.with_angles(motion.angles * (1.0 + part * rng.normal(size=len(motion.angles)))))


def shaken_on(search: Exploration, pace: Pace, until: float, wider: Callable[[int], None] | None = None) -> None:
    """Search on: shake the best plan so far, bring it to the goal again and shorten it, again and again.

    Args:
        search: The search.
        pace: How long what is shaken is shortened.
        until: When it ends [s of this process].
        wider: Looks more widely, with a seed; done before each of the first half.
    """
    half, rng, seed = 0.5 * (time.process_time() + until), np.random.default_rng(0), 10
    while time.process_time() < until:
        if wider is not None and time.process_time() < half:
            wider(seed)
        best = search.incumbent.best
        if best is not None and free_primitives(best.motion.segments):
            near = search.refinement.near(shaken(best.motion.at_accuracy(SEARCHING), SHAKEN[seed % len(SHAKEN)], rng))
            if near.close:
                search.consider(search.refinement.shorter(near.motion, pace), "shaken")
        seed += 1


def outcome(number: int, seconds: float) -> dict[str, Any]:
    """Return the joint travel of a query's plans [rad]; queries of the classes take turns."""
    name = list(CLASSES)[number % len(CLASSES)]
    start, goal = query(name, number // len(CLASSES))
    standard = plan(start, goal, options=PlanOptions(max_memory_gb=4.0))
    swimmer, limits, rolls, began = Swimmer(), Limits(), QuarterRolls.least(start, goal), time.process_time()
    careful = dataclasses.replace(swimmer, max_bend_rad=careful_bend_rad(swimmer, limits))
    found = searched(careful, rolls.seen(start), rolls.seen(goal), stored_gaits(), "thorough", "travel", limits).search
    thorough = found.incumbent.joint_travel_rad
    shaken_on(found, LONG, began + seconds)
    told = {"standard_rad": standard.joint_travel_rad, "thorough_rad": thorough}
    return {"seed": number, "class": name, **told, "long_rad": found.incumbent.joint_travel_rad}


def table(rows: list[dict[str, Any]]) -> str:
    """Return what came of the classes, as lines of Markdown."""
    lines = [
        "| class | queries | best of the long search, mean [rad] | thorough above it, mean | worst "
        "| standard above it, mean | worst |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    for name in CLASSES:
        mine = [row for row in rows if row["class"] == name]
        if not mine:
            continue
        best = np.array([row["long_rad"] for row in mine])
        cells = [name, str(len(mine)), f"{np.mean(best):.1f}"]
        for effort in ("thorough", "standard"):
            above = np.array([row[f"{effort}_rad"] for row in mine]) / best - 1.0
            cells += [f"{np.mean(above):.1%}", f"{np.max(above):.1%}"]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> None:
    """Search, print the table, and put it into the page if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=2, help="queries of each class")
    parser.add_argument("--seconds", type=float, default=240.0, help="processor time of the long search for a query")
    parser.add_argument("--out", type=Path, help="a file that gains a line a query; those in it are not done again")
    parser.add_argument("--write", action="store_true", help="put the table into docs/explanation/planner.md")
    asked = parser.parse_args()
    numbers = range(asked.count * len(CLASSES))
    text = table(outcomes(asked.out, numbers, lambda number: outcome(number, asked.seconds), printed))
    print(text)
    if asked.write:
        pages.put("explanation/planner.md", "long search", text)


if __name__ == "__main__":
    main()
