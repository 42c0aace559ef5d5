"""The peers' settings, one changed at a time, on other queries than the contest's.

    python -m benchmarks.peers.tuning --cap 6 --count 3

Each row is a peer with its chosen settings, or with one of them changed. The errors are medians over the queries of a
class; the last column is the geometric mean of the errors' ratios to those of the chosen settings, query by query,
where an error that the contest lets pass counts as its tolerance.
"""

from __future__ import annotations

import argparse
import dataclasses
import functools
import os
from typing import Any

import numpy as np

from benchmarks.peers import sampling, shooting
from benchmarks.peers.judge import LOOSE, Answer, error
from benchmarks.peers.processes import Planner, outcome
from benchmarks.peers.queries import query
from benchmarks.peers.tables import line, middle, table

KINDS = ("small", "near")
GRID: dict[str, dict[str, tuple[Any, ...]]] = {
    "RRT": {
        "goal_bias": (0.05, 0.1, 0.3),
        "longest_s": (0.5, 2.0, 5.0, 10.0, 20.0),
        "step_s": (0.1, 0.25),
        "limb_weight": (0.3, 1.0),
        "least_reach": (0.2, 1.0),
        "intermediate": (True, False),
    },
    **{
        name: {
            "longest_s": (0.5, 2.0, 5.0, 10.0, 20.0),
            "step_s": (0.1, 0.25),
            "projection": ("position", "left"),
            "cells": (3.0, 10.0, 30.0),
        }
        for name in ("KPIECE1", "EST")
    },
    "IPOPT": {
        "intervals_s": ((0.1, 0.2), (0.2, 0.4), (0.3, 0.6)),
        "horizons": ((0.5, 1.0, 2.0), (1.0, 2.0), (0.25, 0.5, 1.0)),
    },
}
"""What is tried for each setting of each peer."""


def with_settings(name: str, **changed: Any) -> Planner:
    """Return a peer with its chosen settings, some of them changed."""
    if name == "IPOPT":
        return functools.partial(shooting.answer, dataclasses.replace(shooting.SETTINGS, **changed))
    return functools.partial(sampling.answer, name, dataclasses.replace(sampling.SETTINGS[name], **changed))


def alternatives(name: str) -> list[dict[str, Any]]:
    """Return the changes to try: none, and each value of the grid that is not the chosen one."""
    chosen = shooting.SETTINGS if name == "IPOPT" else sampling.SETTINGS[name]
    return [{}, *({key: v} for key, values in GRID[name].items() for v in values if v != getattr(chosen, key))]


def row(peer: str, setting: str, found: list[dict[str, Any]], first: list[dict[str, Any]]) -> list[str]:
    """Return a row of the table: a peer's figures with one setting, beside those with the chosen ones."""
    ended = [[r for r in found if r["kind"] == kind and r["error"] is not None] for kind in KINDS]
    both = [(r["error"], f["error"]) for r, f in zip(found, first, strict=True)]
    ratios = [max(LOOSE, a) / max(LOOSE, b) for a, b in both if a is not None and b is not None]
    ratio = format(float(np.exp(np.mean(np.log(ratios)))), ".2f") if ratios else "-"
    return [peer, setting, *(middle(e, "error", ".2g") for e in ended), middle(found, "processor_s", ".1f"), ratio]


def main() -> None:
    """Try all and print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=3, help="queries of each class")
    parser.add_argument("--cap", type=float, default=6.0, help="processor time for each query [s]")
    parser.add_argument("--seed", type=int, default=1, help="another than the contest's")
    parser.add_argument("--only", choices=tuple(GRID), action="append", help="this peer; may be given again")
    asked = parser.parse_args()
    os.environ |= {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    queries = [query(kind, number, asked.seed) for kind in KINDS for number in range(asked.count)]
    head = ["peer", "setting", *(f"error, {kind}" for kind in KINDS), "processor [s]", "beside the chosen"]
    print(table(head, []))
    still = Answer(np.ones(1), np.zeros((1, 6)))
    errors = [{"kind": q.kind, "error": error(q, still), "processor_s": 0.0} for q in queries]
    print(line(row("none", "standing still", errors, errors)))
    for name in asked.only or GRID:
        first: list[dict[str, Any]] = []
        for changed in alternatives(name):
            planner = with_settings(name, **changed)
            found = [outcome(planner, q, asked.cap, asked.seed) for q in queries]
            first = first or found
            setting = ", ".join(f"{key} {value}" for key, value in changed.items()) or "as chosen"
            print(line(row(name, setting, found, first)), flush=True)


if __name__ == "__main__":
    main()
