"""How far plans of least travel and of least sensitivity end from their goals among links that feel each other.

    python -m benchmarks.sensitivity --count 100 --out FILE

Random queries of up to 3 L, planned for links alone with both objectives and replayed with ``fluid: beads``. Of each a
line, kept in the file, so that a run goes on where it was stopped; the medians at the end.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

from benchmarks.fit import BEADS, off, random_goal
from purcell_cli import PlanOptions, plan
from purcell_cli.feedback.simulate import simulate
from purcell_cli.motion.trajectory import as_table

OBJECTIVES = ("travel", "sensitivity")


def measured(seed: int) -> dict[str, list[float]]:
    """Return the miss (L and rad together) and the joint travel [rad] of a query's plans, by objective."""
    start, goal = random_goal(np.random.default_rng([9, seed]))
    out = {}
    for objective in OBJECTIVES:
        solution = plan(start, goal, options=PlanOptions(objective=objective))  # type: ignore[arg-type]
        missed = off(simulate(as_table(solution.trajectory), BEADS).end, goal)
        out[objective] = [missed, solution.joint_travel_rad]
    return out


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=100, help="queries")
    parser.add_argument("--out", type=Path, required=True, help="a line of JSON for each")
    asked = parser.parse_args()
    lines = asked.out.read_text(encoding="utf-8").splitlines() if asked.out.exists() else []
    rows = [json.loads(line) for line in lines[: asked.count]]
    for seed in range(len(rows), asked.count):
        rows.append(measured(seed))
        with asked.out.open("a", encoding="utf-8") as file:
            file.write(json.dumps(rows[-1]) + "\n")
    values = np.array([[row[objective] for objective in OBJECTIVES] for row in rows])
    miss = np.median(values[..., 0], axis=0)
    ratio, apart = values[:, 1] / values[:, 0], np.abs(values[:, 1, 1] / values[:, 0, 1] - 1.0) > 1e-9
    print(f"{len(rows)} queries, {np.count_nonzero(apart)} of them with two different plans")
    print(f"median miss {miss[0]:.3f} by least travel, {miss[1]:.3f} by least sensitivity")
    print(f"of one query: miss {np.median(ratio[:, 0]):.2f} times as large, travel {np.median(ratio[:, 1]):.2f} times")
    if np.any(apart):
        middle = np.median(ratio[apart], axis=0)
        print(f"where the plans differ: miss {middle[0]:.2f} times as large, travel {middle[1]:.2f} times")


if __name__ == "__main__":
    main()
