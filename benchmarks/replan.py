"""How long replans take: the rest of plans from configurations measured on their way.

    python -m benchmarks.replan --count 100

Times are those of the processor, for library calls with all tables and the plans' ways warm; the certificate is
included. Measurements are off by 1e-3 L and 0.1 degree in each component, at places all along stored scenarios' ways.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from purcell_cli.feedback.measured import Measuring
from purcell_cli.feedback.replan import replan
from purcell_cli.files.builtin import find_scenario
from purcell_cli.geometry import se3
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.planner.plan_path import PlanPath
from purcell_cli.planning import plan

NAMES = (
    "along-x",
    "along-y",
    "bent-goal",
    "bent-start",
    "far",
    "half-turn",
    "nearby",
    "pitch",
    "planar-manoeuvre",
    "yaw",
)


def main() -> None:
    """Print the times of the processor and how often the plan's own strokes were kept."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=100, help="replans")
    count, rng = parser.parse_args().count, np.random.default_rng(0)
    ways = []
    for name in NAMES:
        query = find_scenario(name)
        ways.append(PlanPath.of(plan(query.start, query.goal, swimmer=query.swimmer).plan))
    seconds, kept, reached = [], 0, 0
    for k in range(count + 1):
        way = ways[k % len(ways)]
        length_m, place = way.plan.swimmer.length_m, int(rng.integers(len(way.travel_rad)))
        left = way.left[place].copy()
        left[:3, 3] *= length_m
        real = Configuration(way.plan.goal.pose @ se3.inverse(left), way.shape[place])
        measured = Measuring(1e-3, 0.1).of(real, length_m, rng.normal(size=(2, 3)))
        began = time.process_time()
        found = replan(way, measured)
        reached += found.solution.verdict == "reached"
        kept += found.kept
        seconds.append(time.process_time() - began)
    milliseconds = 1e3 * np.array(seconds[1:])  # the first warms up
    print(f"{reached} of {count + 1} reached, {kept} of the plan's own strokes")
    for word, part in (("median", 0.5), ("90th percentile", 0.9), ("longest", 1.0)):
        print(f"{word}: {np.quantile(milliseconds, part):.0f} ms")


if __name__ == "__main__":
    main()
