"""Plans on which all joints turn at once beside CasADi with IPOPT, under the same bounds: rates, and no bend limit.

    python -m pip install . "casadi>=3.7"
    python -m benchmarks.peers.simultaneous --count 10 --cap 120 --out all-at-once.jsonl

The queries are those of `benchmarks.peers`. CasADi minimises squared controls over three horizons; this package least
time and least joint travel. `--only` and `--planner` pick some.
Begun again with the same file, it goes on after the last query that is in it.
"""

from __future__ import annotations

import argparse
import functools
import json
import math
import os
from pathlib import Path
from typing import Any

from benchmarks.peers import shooting
from benchmarks.peers.judge import LOOSE
from benchmarks.peers.processes import Planner, outcome, planned
from benchmarks.peers.queries import CLASSES, query
from benchmarks.peers.tables import table, written
from purcell_cli import PlanOptions

PAGE = Path(__file__).parents[2] / "docs" / "explanation" / "benchmarks.md"
ALL_AT_ONCE = {m: PlanOptions(controls="simultaneous", objective=m) for m in ("time", "travel")}
PLANNERS: dict[str, Planner] = {
    **{f"least {m}": functools.partial(planned, options, math.pi) for m, options in ALL_AT_ONCE.items()},
    "CasADi + IPOPT": functools.partial(shooting.answer, shooting.SETTINGS),
}


def rows(results: list[dict[str, Any]]) -> list[list[str]]:
    """Return the table: a row for each query that all planners have answered."""
    found = {(r["kind"], r["number"], r["planner"]): r for r in results}
    out = []
    for kind in CLASSES:
        for number in sorted({r["number"] for r in results if r["kind"] == kind}):
            mine = [found.get((kind, number, name)) for name in PLANNERS]
            if all(mine):
                out.append([f"{kind} {number}", *(cell for one in mine if one for cell in cells(one))])
    return out


def cells(one: dict[str, Any]) -> tuple[str, str, str]:
    """Return duration [s], joint travel [rad] and processor time [s] of an answer, if it arrives."""
    if one["error"] is None or one["error"] > LOOSE:
        return "-", "-", f"{one['processor_s']:.1f}"
    return f"{one['duration_s']:.2f}", f"{one['joint_travel_rad']:.2f}", f"{one['processor_s']:.1f}"


def main() -> None:
    """Ask what is not yet in the file, and write the table into the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=3, help="queries of each class")
    parser.add_argument("--cap", type=float, default=60.0, help="processor time for each query [s]")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", choices=tuple(CLASSES), nargs="+", default=list(CLASSES), help="these classes alone")
    parser.add_argument("--planner", choices=tuple(PLANNERS), nargs="+", default=list(PLANNERS), help="these alone")
    parser.add_argument("--out", type=Path, required=True, help="a file with a line for every answer")
    asked = parser.parse_args()
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}  # for the planners' processes
    results = [json.loads(line) for line in asked.out.read_text().splitlines()] if asked.out.exists() else []
    done = {(r["kind"], r["number"], r["planner"]) for r in results if not r["fault"]}
    with asked.out.open("a", encoding="utf-8") as file:
        for number in range(asked.count):
            for kind in asked.only:
                for name in asked.planner:
                    if (kind, number, name) in done:
                        continue
                    found = outcome(PLANNERS[name], query(kind, number, asked.seed), asked.cap, asked.seed)
                    results.append({"planner": name, "cap_s": asked.cap, **found})
                    file.write(json.dumps(results[-1]) + "\n")
                    file.flush()
    head = [
        "query",
        *(f"{name}: {what}" for name in PLANNERS for what in ("time [s]", "travel [rad]", "processor [s]")),
    ]
    page = PAGE.read_text(encoding="utf-8")
    PAGE.write_text(written(page, "all at once", table(head, rows(results))), encoding="utf-8")


if __name__ == "__main__":
    main()
