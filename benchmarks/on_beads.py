"""How far plans among links that feel each other end from their goals on the beads themselves.

    python -m benchmarks.on_beads --slenderness 0.05 --count 30

Random queries of up to 3 L, planned with the table, then replayed as ``purcell verify --full`` does: the beads are
solved anew at each node. Of each a line, and the worst at the end.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

from benchmarks.fit import random_goal
from purcell_cli import Swimmer, plan
from purcell_cli.mechanics.beads import solved_anew
from purcell_cli.motion.options import PlanOptions
from purcell_cli.motion.trajectory import as_table
from purcell_cli.verification.verify import verify

BOUND = 1e-7
"""Within so much each must end [L, rad]."""
ROWS = PlanOptions(dt_s=0.2)
"""Rows are at most so far apart: with one every 0.05 s a replay ends at the same place in three times as long."""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--slenderness", type=float, default=0.05, help="of all links")
    parser.add_argument("--count", type=int, default=30, help="queries")
    parser.add_argument("--first", type=int, default=0, help="number of the first")
    asked = parser.parse_args()
    body = Swimmer(slenderness=asked.slenderness, fluid="beads")
    worst, within = np.zeros(2), 0
    for seed in range(asked.first, asked.first + asked.count):
        start, goal = random_goal(np.random.default_rng([5, seed]))
        begun = time.process_time()
        solution = plan(start, goal, swimmer=body, options=ROWS)
        planned = time.process_time()
        rows = [as_table(solution.trajectory)]
        found = verify(rows, start, goal, body, BOUND, BOUND, resistances=solved_anew)
        off = found.certificate.deviation
        ends = np.array([off.position_m / body.length_m, off.base_rad])
        worst, within = np.maximum(worst, ends), within + found.holds
        spent = f"planned in {planned - begun:.1f} s, replayed in {time.process_time() - planned:.1f} s"
        print(
            f"{seed}: {solution.joint_travel_rad:.1f} rad, off by {ends[0]:.1e} L, {ends[1]:.1e} rad; {spent}",
            flush=True,
        )
    print(f"{within} of {asked.count} end within {BOUND:g} L and rad; worst {worst[0]:.1e} L, {worst[1]:.1e} rad")


if __name__ == "__main__":
    main()
