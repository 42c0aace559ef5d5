"""Plans random queries over all combinations of joints, and says how many arrive and what they take.

    python -m benchmarks.joints --count 1000 --out joints.jsonl
    python -m benchmarks.joints --from 200 --count 100 --seconds 270 --out joints.jsonl
    python -m benchmarks.joints --count 0 --out joints.jsonl --write

Each plan is integrated once more, and no joint may turn about an axis that it has not or leave its range, looked at
every 0.01 rad: both by code that shares nothing with the planner.

`--out` gains a line a query, so that a run may be done in pieces: the table is of all of its lines. `--write` puts it
into docs/how-to/joints.md.
"""

from __future__ import annotations

import argparse
import statistics
import sys
import time
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))  # where its queries are

from joint_queries import EVERY, joint_faults, plane_fault, random_query
from reintegrated import missed

from benchmarks import pages
from benchmarks.resumed import Row, outcomes
from purcell_cli.errors import ParameterError
from purcell_cli.geometry import se3
from purcell_cli.motion.verdict import Verdict
from purcell_cli.planning import plan

_ERROR, _PLANE = 1e-9, 1e-12
"""What a plan may miss, and how far parallel hinges may take the base out of its plane [L, rad]."""


def outcome(seed: int) -> dict[str, Any]:
    """Plan one query and return its figures, and what is wrong with it."""
    name = list(EVERY)[seed % len(EVERY)]
    query = random_query(name, seed)
    begun = time.process_time()
    try:
        solution = plan(query.start, query.goal, swimmer=query.swimmer)
    except ParameterError as error:
        told = {"seed": seed, "joints": name, "error": 0.0, "joint_travel_rad": 0.0}
        return {**told, "seconds": time.process_time() - begun, "faults": [f"refused: {error}"]}
    seconds = time.process_time() - begun
    off = solution.certificate.deviation
    error = max(off.position_m / query.swimmer.length_m, off.base_rad, off.limb1_rad, off.limb2_rad)
    if solution.verdict == Verdict.REACHED:
        wanted = se3.inverse(query.start.pose) @ query.goal.pose
        error = max(error, missed(query.swimmer, solution.trajectory, wanted))
    faults = joint_faults(query, solution.trajectory)
    faults += [] if solution.verdict == Verdict.REACHED else [str(solution.verdict)]
    faults += [f"off by {error:.2g}"] if error > _ERROR else []
    plane = plane_fault(query, name, solution.trajectory)
    faults += [f"out of its plane by {plane:.2g}"] if plane > _PLANE else []
    travel = solution.joint_travel_rad
    told = {"seed": seed, "joints": name, "error": error, "joint_travel_rad": travel, "seconds": seconds}
    return {**told, "faults": faults}


def table(rows: list[dict[str, Any]]) -> list[str]:
    """Return what came of queries, as lines of Markdown."""
    good = [row for row in rows if not row["faults"]]
    error = max((row["error"] for row in good), default=0.0)
    lines = [
        f"{len(good)} of {len(rows)} random queries reached, at most {error:.1e} off (L, rad).",
        "",
        "| joints | reached | median joint travel [rad] | greatest [rad] | median time [s] | greatest [s] |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for name in EVERY:
        some = [row for row in rows if row["joints"] == name]
        reached = [row for row in some if not row["faults"]]
        if reached:
            cells = [f"{name} | {len(reached)} of {len(some)}"]
            for key, digits in (("joint_travel_rad", 0), ("seconds", 1)):
                own = [row[key] for row in reached]
                cells += [f"{value:.{digits}f}" for value in (statistics.median(own), max(own))]
            lines.append(f"| {' | '.join(cells)} |")
    return lines


def main() -> int:
    """Plan the queries, print a line for each that fails and the table, and return the exit code."""
    options = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    options.add_argument("--count", type=int, default=1000, help="how many queries")
    options.add_argument("--from", dest="first", type=int, default=0, help="the number of the first")
    options.add_argument("--seconds", type=float, default=float("inf"), help="stop after so much time")
    options.add_argument(
        "--out", type=Path, help="a file that gains a line a query; those that it has are not done again"
    )
    options.add_argument("--write", action="store_true", help="put the table into docs/how-to/joints.md")
    asked = options.parse_args()
    begun = time.monotonic()

    def told(row: Row) -> None:
        if row["faults"]:
            print(f"{row['seed']} {row['joints']}: {'; '.join(row['faults'])}", flush=True)

    seeds = range(asked.first, asked.first + asked.count)
    rows = outcomes(asked.out, seeds, outcome, told, lambda: time.monotonic() - begun <= asked.seconds)
    text = "\n".join(table(rows))
    print(text)
    if asked.write:
        pages.put("how-to/joints.md", "figures", text)
    return 1 if any(row["faults"] for row in rows) else 0


if __name__ == "__main__":
    sys.exit(main())
