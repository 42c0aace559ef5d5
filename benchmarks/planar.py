"""Standard plans of the planar swimmer against a long search, from small displacements to far ones.

    python -m benchmarks.planar --out planar.jsonl --write

Both limbs hang on yaw hinges and are bent at both ends. The long search is a thorough plan, then wider searches with
other seeds, then the best plan so far shaken and shortened again and again, until half a minute of processor time is
spent. `--out` gains a line a query, so that a run may be done in pieces; `--write` puts the table into
docs/how-to/joints.md.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import math
import statistics
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks import pages
from benchmarks.long_search import LONG, shaken_on
from benchmarks.resumed import outcomes
from purcell_cli import Configuration, Swimmer, plan
from purcell_cli.files.builtin import find_swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import about_axis
from purcell_cli.mechanics.configuration import displacement_between
from purcell_cli.mechanics.joint_motion import flattened
from purcell_cli.mechanics.joints import limb_at
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.options import Effort, PlanOptions
from purcell_cli.planner.effort import Stage
from purcell_cli.planner.exploration import Exploration
from purcell_cli.planner.joints.candidates import joint_candidates
from purcell_cli.planner.joints.effort import JointBreadth
from purcell_cli.planner.refine.minimum_travel import Pace
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refinement import Refinement

CLASSES = {"small": (0.02, 0.3), "mid": (0.4, 2.5), "far": (4.0, 30.0)}
"""The classes of queries, and how far their goals are, at least and at most [L]."""
BENT_RAD = 0.9
"""Limbs are bent at most so far at the start and the goal [rad]."""
WIDE = JointBreadth(ways=4, chains=4000, kept=6, short=40, arcs=48, pace=Pace(3, 30))
STAGE = Stage(candidates=6, pace=LONG, most_apart=80)
"""How widely the long search looks, with each seed, and how long it shortens what it finds."""


@dataclasses.dataclass(frozen=True)
class Query:
    """A start and a goal, and the class that they are of."""

    kind: str
    start: Configuration
    goal: Configuration


def query(seed: int, swimmer: Swimmer) -> Query:
    """Return a random query in the x-y plane; one seed in three is small, one mid, one far."""
    rng = np.random.default_rng([55, seed])
    kind = list(CLASSES)[seed % len(CLASSES)]
    low, high = CLASSES[kind]
    away = low * (high / low) ** rng.random()
    way, turn = rng.uniform(-math.pi, math.pi), rng.uniform(-1.0, 1.0) * min(math.pi, 3.0 * away)
    place = away * swimmer.length_m * np.array([math.cos(way), math.sin(way), 0.0])
    bends = rng.uniform(-BENT_RAD, BENT_RAD, (2, 2))
    shapes = [np.stack([limb_at(float(psi), 0.0) for psi in both]) for both in bends]
    pose = se3.pose(about_axis(2, turn), place)
    return Query(kind, Configuration(shape=shapes[0]), Configuration(pose, shapes[1]))


def long_search(swimmer: Swimmer, asked: Query, seconds: float) -> float:
    """Return the least joint travel of plans that a search of some length finds [rad].

    Args:
        swimmer: The swimmer.
        asked: The query.
        seconds: How long it looks [s of processor time].
    """
    began = time.process_time()
    thorough = plan(asked.start, asked.goal, swimmer=swimmer, options=PlanOptions(effort=Effort.THOROUGH))
    wanted = flattened(swimmer, displacement_between(asked.start, asked.goal, swimmer.length_m))
    empty = Equations(swimmer.scaled(), (), asked.start.shape, asked.goal.shape, wanted, SEARCHING)
    search = Exploration(empty, Refinement(swimmer, asked.start, Limits(), "travel"))

    def wider(seed: int) -> None:
        wide = dataclasses.replace(WIDE, seed=seed)
        search.explore(STAGE, joint_candidates(swimmer.scaled(), asked.start.shape, asked.goal.shape, wanted, wide))

    shaken_on(search, LONG, began + seconds, wider)
    return min(search.incumbent.joint_travel_rad, thorough.joint_travel_rad)


def outcome(seed: int, seconds: float) -> dict[str, Any]:
    """Plan one query and return its figures."""
    swimmer = find_swimmer("planar")
    asked = query(seed, swimmer)
    begun = time.process_time()
    standard = plan(asked.start, asked.goal, swimmer=swimmer)
    spent = time.process_time() - begun
    if standard.verdict != "reached":
        raise SystemExit(f"{seed}: {standard.verdict}")
    away = float(np.linalg.norm(asked.goal.pose[:3, 3])) / swimmer.length_m
    told = {"seed": seed, "class": asked.kind, "away_l": away, "seconds": spent}
    return {**told, "standard_rad": standard.joint_travel_rad, "long_rad": long_search(swimmer, asked, seconds)}


def table(rows: list[dict[str, Any]]) -> list[str]:
    """Return what came of queries, as lines of Markdown."""
    lines = [
        "| query | class | distance [L] | standard [rad] | long search [rad] | standard is longer by | time [s] |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    order = list(CLASSES)
    for row in sorted(rows, key=lambda r: (order.index(r["class"]), r["seed"])):
        more = row["standard_rad"] / min(row["standard_rad"], row["long_rad"]) - 1.0
        cells = row["seed"], row["class"], f"{row['away_l']:.2f}", f"{row['standard_rad']:.1f}"
        lines.append(f"| {' | '.join(map(str, cells))} | {row['long_rad']:.1f} | {more:.1%} | {row['seconds']:.2f} |")
    more = [row["standard_rad"] / min(row["standard_rad"], row["long_rad"]) - 1.0 for row in rows]
    within = sum(m <= 0.1 for m in more)
    lines += ["", f"{within} of {len(rows)} within 10 %, median {statistics.median(more):.1%}, most {max(more):.1%}."]
    return lines


def main() -> None:
    """Plan the queries, print the table, and put it into the page if asked."""
    options = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    options.add_argument("--count", type=int, default=12, help="how many queries")
    options.add_argument("--from", dest="first", type=int, default=0, help="the number of the first")
    options.add_argument("--seconds", type=float, default=30.0, help="how long the long search takes a query")
    options.add_argument("--out", type=Path, help="a file that gains a line a query; those in it are not done again")
    options.add_argument("--write", action="store_true", help="put the table into docs/how-to/joints.md")
    asked = options.parse_args()
    seeds = range(asked.first, asked.first + asked.count)
    rows = outcomes(
        asked.out,
        seeds,
        lambda seed: outcome(seed, asked.seconds),
        lambda row: print(json.dumps(row), file=sys.stderr, flush=True),
    )
    text = "\n".join(table(rows))
    print(text)
    if asked.write:
        pages.put("how-to/joints.md", "planar", text)


if __name__ == "__main__":
    main()
