"""The planner beside what people would pick instead, and its numerics: the tables of docs/explanation/benchmarks.md.

    python -m pip install . -r benchmarks/requirements.txt
    python -m benchmarks.peers --count 5 --cap 60

Every planner gets the same seeded queries, one after the other, each in a process of its own. The clock runs for the
query alone: imports, and for this package one plan before, are not counted. What a planner answers is replayed by
DOP853, and counts by where that ends.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from benchmarks.peers.contest import PLANNERS
from benchmarks.peers.judge import LOOSE
from benchmarks.peers.processes import outcome
from benchmarks.peers.queries import CLASSES, query
from benchmarks.peers.tables import middle, table, written
from purcell_cli.verification.certificate import TOLERANCE_L

PAGE = Path(__file__).parents[2] / "docs" / "explanation" / "benchmarks.md"


def rows(results: list[dict[str, Any]]) -> list[list[str]]:
    """Return the table of the planners: a row for each class and planner."""
    out = []
    for kind in CLASSES:
        for name in PLANNERS:
            mine = [r for r in results if r["kind"] == kind and r["planner"] == name]
            ended = [r for r in mine if r["error"] is not None]
            near = [r for r in ended if r["error"] <= LOOSE]
            exact = sum(r["error"] <= TOLERANCE_L for r in ended)
            medians = (middle(ended, "error", ".1e"), middle(mine, "wall_s", ".1f"), middle(mine, "processor_s", ".2f"))
            travel = middle(near, "joint_travel_rad", ".1f")
            out.append([kind, name, f"{exact} of {len(mine)}", f"{len(near)} of {len(mine)}", *medians, travel])
    return out


def main() -> None:
    """Run all and write the tables into the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=3, help="queries of each class")
    parser.add_argument("--cap", type=float, default=60.0, help="processor time for each query [s]")
    parser.add_argument("--jobs", type=int, default=1, help="planners at once; wall times suffer")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", choices=("planners", "numerics"), help="one table alone")
    parser.add_argument("--out", type=Path, help="a JSON file for every query's figures")
    asked = parser.parse_args()
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}  # for the planners' processes
    page = PAGE.read_text(encoding="utf-8")
    if asked.only != "planners":
        from benchmarks.peers import numerics

        head = [
            "what is integrated",
            "accuracy",
            "error",
            "flow [ms]",
            "DOP853's rtol",
            "error",
            "DOP853 [ms]",
            "ratio",
        ]
        page = written(page, "numerics", table(head, numerics.rows()))
    if asked.only != "numerics":
        results = []
        queries = [query(kind, number, asked.seed) for number in range(asked.count) for kind in CLASSES]
        with ThreadPoolExecutor(asked.jobs) as pool:  # each thread waits for a process
            waiting = {
                pool.submit(outcome, planner, q, asked.cap, asked.seed): name
                for q in queries
                for name, planner in PLANNERS.items()
            }
            for done in as_completed(waiting):
                results.append({"planner": waiting[done], **done.result()})
                print(json.dumps(results[-1]), flush=True)
        if asked.out:
            asked.out.write_text(json.dumps(results, indent=1))
        head = ["class", "planner", "within 1e-9", f"within {LOOSE:g}", "error", "wall [s]", "processor [s]"]
        head.append("joint travel [rad]")
        faults = [f"{r['planner']} {r['fault']}" for r in results if r["fault"]]
        given = f"--count {asked.count} --cap {asked.cap:g} --seed {asked.seed} --jobs {asked.jobs}"
        about = (
            f"`python -m benchmarks.peers {given}`: {asked.count} queries a class, {asked.cap:g} s of processor time "
            f"for each, {asked.jobs} at once on {os.cpu_count()} cores shared with other work, Python "
            f"{platform.python_version()}. Faults: {', '.join(faults) or 'none'}.\n\n"
        )
        page = written(page, "planners", about + table(head, rows(results)))
    PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
