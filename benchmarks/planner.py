"""How quick the planner is, in one table: the flow, plans of seven classes, the shell, far ways, batches, and efforts.

    python -m benchmarks.planner --count 300 --write
    python -m benchmarks.planner --beside OTHER/bin/python

Processor times in one thread with all tables warm, but for commands and batches, which the clock times. `--beside`
measures another version too, installed where that Python finds it: each part runs in turn in a process of either,
and of all rounds each query's least time counts. `--write` puts the table into docs/explanation/planner.md.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
CLASSES = ("tiny", "small", "small, bent", "mid", "mid, bent", "near", "far")
SCENARIOS = ("nearby", "far", "along-z")
PRIMITIVES, DIRECTIONS, SMALL_SCENARIOS = 27, 8, 1000
_CHILD = """
import json, sys
import purcell_cli
part, count, root = json.loads(sys.argv[1])
sys.path.insert(0, root)  # the package stays that of this Python
from benchmarks.planner import PARTS
print(json.dumps(PARTS[part](count)))
"""

Times = list[float]
"""Seconds, of one query after the other; of a batch, scenarios a second; of far ways, how many times as long."""


def seconds_of(call: Callable[..., object], *given: object, **named: object) -> float:
    """Return the processor time of a call [s]."""
    began = time.process_time()
    call(*given, **named)
    return time.process_time() - began


def plans_of(name: str, **options: object) -> Callable[[int], Times]:
    """Return what times plans of a class's first queries."""

    def times(count: int) -> Times:
        from benchmarks.classes import timed
        from purcell_cli import PlanOptions

        asked = PlanOptions(max_memory_gb=4.0, **options)
        timed(name, count, asked)
        return [timed(name, number, asked)[1] for number in range(count)]

    return times


def flows(count: int) -> Times:
    """Time the flow of random primitives and its derivatives."""
    from purcell_cli import PrimitiveSequence, Swimmer, flow_and_jacobian
    from purcell_cli.mechanics.lift import SEARCHING

    times = []
    for number in range(count):
        rng = np.random.default_rng(number)
        sequence = PrimitiveSequence(rng.integers(6, size=PRIMITIVES), rng.uniform(-0.3, 0.3, PRIMITIVES))
        again = [seconds_of(flow_and_jacobian, Swimmer(), sequence, accuracy=SEARCHING) for _ in range(5)]
        times.append(min(again))
    return times


def commands(count: int) -> Times:
    """Time `purcell plan SCENARIO`, with its trajectory, from the shell."""
    surroundings = {k: v for k, v in os.environ.items() if k != "PYTHONDONTWRITEBYTECODE"}
    code, times = "from purcell_cli.cli.app import main; main()", []
    with tempfile.TemporaryDirectory() as folder:
        for number in range(count + 1):
            command = [sys.executable, "-P", "-c", code, "plan", SCENARIOS[number % len(SCENARIOS)]]
            began = time.perf_counter()
            subprocess.run(command, cwd=folder, env=surroundings, capture_output=True, check=True)  # noqa: S603
            times.append(time.perf_counter() - began)
    return times[1:]


def far_ways(count: int) -> Times:
    """Return how many times as long a plan for 1,000 L takes as one for 20 L, in random directions."""
    from benchmarks.random_queries import random_rotations
    from purcell_cli import Configuration, PlanOptions, Swimmer, plan

    def seconds(number: int, distance: float) -> float:
        rng = np.random.default_rng(number)
        away = rng.normal(size=3)
        pose = np.eye(4)
        pose[:3, :3] = random_rotations(rng, 1)[0]
        pose[:3, 3] = away * distance * Swimmer().length_m / np.linalg.norm(away)
        options = PlanOptions(max_memory_gb=8.0)
        return min(seconds_of(plan, Configuration(), Configuration(pose), options=options) for _ in range(3))

    return [seconds(number, 1000.0) / seconds(number, 20.0) for number in range(count)]


def batches(_count: int) -> Times:
    """Return how many small scenarios a second a batch of two workers plans."""
    from benchmarks.batch import ROLL, run

    return [run(ROLL, SMALL_SCENARIOS, 2)["rate"]]


PARTS: dict[str, Callable[[int], Times]] = {
    "flow": flows,
    **{name: plans_of(name) for name in CLASSES},
    "shell": commands,
    "far ways": far_ways,
    "batch": batches,
    **{f"thorough, {name}": plans_of(name, effort="thorough") for name in CLASSES},
    **{f"simultaneous, {name}": plans_of(name, controls="simultaneous") for name in ("tiny", "small", "near")},
}
"""What is measured, each in a process of its own: gives the figures of so many queries."""

WORDS = {
    "flow": ("the flow of 27 primitives and its derivatives", "0.0005 s"),
    **{name: (f"plan, warm: {name}", "0.02 s, 99 of 100 within 0.15 s") for name in CLASSES},
    "shell": ("`purcell plan`, its trajectory included, from the shell", "0.6 s"),
    "far ways": ("1,000 L, times as long as 20 L", "1.2"),
    "batch": (f"batch of {SMALL_SCENARIOS:,} small scenarios, 2 workers, a second", "60"),
    **{f"thorough, {name}": (f"thorough: {name}", "10 s") for name in CLASSES},
    **{
        f"simultaneous, {name}": (f"all joints at once: {name}", "1 s, 99 of 100 within 3 s")
        for name in ("tiny", "small", "near")
    },
}
"""What each is, and what is aimed at."""


def measured(part: str, count: int, python: str) -> Times:
    """Return the figures of a part, in a process of that Python's own.

    Raises:
        subprocess.CalledProcessError: it failed.
    """
    asked = json.dumps([part, count, str(ROOT)])
    with tempfile.TemporaryDirectory() as folder:  # where nothing shadows what that Python has installed
        done = subprocess.run(  # noqa: S603  # this very program
            [python, "-P", "-c", _CHILD, asked],
            cwd=folder,
            env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
            stdout=subprocess.PIPE,
            text=True,
            check=True,
        )
    return list(json.loads(done.stdout))


def row(part: str, count: int, rounds: int, pythons: list[str]) -> str:
    """Return a part's row of the table."""
    best = max if part == "batch" else min
    found = [np.array([])] * len(pythons)
    for _ in range(rounds):
        for k, python in enumerate(pythons):
            new = np.array(measured(part, count, python))
            found[k] = np.array([best(pair) for pair in zip(found[k], new, strict=True)]) if len(found[k]) else new
    what, wanted = WORDS[part]
    here = found[0]
    cells = [what, str(len(here)), *(f"{f(here):.3g}" for f in (np.median, lambda x: np.percentile(x, 99), np.max))]
    if len(pythons) > 1:
        cells += [f"{np.median(found[1]):.3g}", f"{np.median(found[1] / here):.3g}"]
    return f"| {' | '.join([*cells, wanted])} |"


def main() -> None:
    """Measure, print and perhaps write."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    counts = "queries of each class; a tenth of them all joints at once, a hundredth thorough"
    parser.add_argument("--count", type=int, default=20, help=counts)
    parser.add_argument("--rounds", type=int, default=1, help="how often each is measured")
    parser.add_argument("--beside", metavar="PYTHON", help="the Python of another version's environment")
    parser.add_argument("--only", nargs="*", default=list(PARTS), choices=list(PARTS), metavar="PART")
    parser.add_argument("--write", action="store_true", help="put the table into docs/explanation/planner.md")
    asked = parser.parse_args()
    pythons = [sys.executable, *([asked.beside] if asked.beside else [])]
    beside = ["the other's median", "times ours"] if asked.beside else []
    heads = ["what", "number", "median", "99th percentile", "worst", *beside, "aim"]
    lines = [f"| {' | '.join(heads)} |", "| --- " * len(heads) + "|"]
    few = {part: 10 if part == "shell" else DIRECTIONS if part == "far ways" else asked.count for part in PARTS}
    for part in asked.only:
        share = 100 if part.startswith("thorough") else 10 if part.startswith("simultaneous") else 1
        lines.append(row(part, few[part] if share == 1 else max(few[part] // share, 2), asked.rounds, pythons))
        print(lines[-1], flush=True)
    if asked.write:
        from benchmarks import pages

        pages.put("explanation/planner.md", "speed", "\n".join(lines))


if __name__ == "__main__":
    main()
