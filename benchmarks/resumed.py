"""Outcomes of numbered queries, a line of JSON each in a file: a run that is broken off goes on from there."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

Row = dict[str, Any]


def outcomes(
    file: Path | None,
    seeds: Iterable[int],
    outcome: Callable[[int], Row],
    told: Callable[[Row], None],
    on: Callable[[], bool] = lambda: True,
) -> list[Row]:
    """Return what a file holds and the outcomes that are not in it yet, each of which it gains at once.

    Args:
        file: The file; None keeps nothing.
        seeds: The queries' numbers, which rows hold under "seed".
        outcome: Returns the row of a query.
        told: Is told each new row.
        on: Whether another query is begun.
    """
    known = file.read_text(encoding="utf-8").splitlines() if file and file.exists() else []
    rows = [json.loads(line) for line in known]
    done = {row["seed"] for row in rows}
    for seed in seeds:
        if seed in done:
            continue
        if not on():
            break
        rows.append(outcome(seed))
        told(rows[-1])
        if file:
            with file.open("a", encoding="utf-8") as stream:
                stream.write(json.dumps(rows[-1]) + "\n")
    return rows


def printed(row: Row) -> None:
    """Print a row as JSON."""
    print(json.dumps(row), flush=True)
