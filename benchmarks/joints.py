"""Plans random queries over all combinations of joints, and says how many arrive and what they take.

    python benchmarks/joints.py [QUERIES] [FIRST SEED]

Each plan is re-integrated; no joint may turn about an axis that it has not or leave its range, looked at every 0.01
rad by code that shares nothing with the planner.
"""

from __future__ import annotations

import statistics
import sys
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))  # where its queries are

from joint_queries import COMBINATIONS, joint_faults, plane_fault, random_query

from purcell_cli.motion.verdict import Verdict
from purcell_cli.solution import plan


def main(queries: int, first: int) -> int:
    """Plan the queries, print a line for each that fails and a table at the end, and return how many failed."""
    failed = 0
    found: dict[str, list[tuple[float, float]]] = {name: [] for name in COMBINATIONS}
    worst = 0.0
    for k in range(first, first + queries):
        name = list(COMBINATIONS)[k % len(COMBINATIONS)]
        query = random_query(name, k)
        begun = time.process_time()
        solution = plan(query.start, query.goal, swimmer=query.swimmer)
        seconds = time.process_time() - begun
        faults = joint_faults(query, solution.trajectory)
        off = solution.certificate.deviation
        error = max(off.position_m / query.swimmer.length_m, off.base_rad, off.limb1_rad, off.limb2_rad)
        plane = plane_fault(query, name, solution.trajectory)
        if solution.verdict != Verdict.REACHED or faults or error > 1e-9 or plane > 1e-12:
            failed += 1
            print(
                f"{k} {name}: {solution.verdict}, off by {error:.2g}, plane {plane:.2g}; {'; '.join(faults)}",
                flush=True,
            )
        else:
            worst = max(worst, error)
            found[name].append((solution.joint_travel_rad, seconds))
    print(f"{queries - failed} of {queries} reached, at most {worst:.2g} off")
    for name, each in found.items():
        if each:
            travel, seconds = (statistics.median(column) for column in zip(*each, strict=True))
            print(f"{name}: {len(each)} plans, median joint travel {travel:.1f} rad, {seconds:.2f} s")
    return failed


if __name__ == "__main__":
    given = [int(word) for word in sys.argv[1:]] + [1000, 0][len(sys.argv) - 1 :]
    sys.exit(1 if main(*given) else 0)
