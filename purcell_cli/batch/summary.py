"""The summary of a batch as JSON, CSV and Parquet: one row a scenario, in the batch's order, never all in memory."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from purcell_cli.batch.results_folder import kept_file
from purcell_cli.batch.rows import COLUMNS, Row
from purcell_cli.errors import ResultsError
from purcell_cli.processes import outside_forks

SCHEMA = "purcell/batch-summary/1"


def write_json(rows: Iterable[Row], totals: Mapping[str, Any], path: Path) -> None:
    """Write summary.json: totals, and each row on a line of its own."""
    head = json.dumps({"schema": SCHEMA, **totals}, allow_nan=False, ensure_ascii=False)
    with kept_file(path) as stream:
        stream.write(f'{head[:-1]}, "rows": ['.encode())
        between = "\n"
        for row in rows:
            text = json.dumps(_in_order(row), allow_nan=False, ensure_ascii=False)
            stream.write(f"{between}{text}".encode())
            between = ",\n"
        stream.write(b"\n]}\n")


def write_csv(rows: Iterable[Row], path: Path) -> None:
    """Write summary.csv: numbers at full double precision, nothing where there is no value."""
    with kept_file(path) as stream:
        text = io.TextIOWrapper(stream, encoding="utf-8", newline="", write_through=True)
        table = csv.writer(text, lineterminator="\n")
        table.writerow(COLUMNS)
        for row in rows:
            table.writerow([_cell(value) for value in _in_order(row).values()])
        text.detach()


def _in_order(row: Row) -> dict[str, Any]:
    values: Mapping[str, Any] = row
    return {name: values[name] for name in COLUMNS}


def _cell(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return "; ".join(value)
    if isinstance(value, dict):
        return json.dumps(value, ensure_ascii=False) if value else ""
    return value if isinstance(value, str) else repr(value)


@outside_forks
def write_parquet(table: Path, path: Path) -> None:
    """Write summary.parquet from summary.csv, with the same columns."""
    from purcell_cli.files.polars_package import polars

    pl = polars()
    texts = dict.fromkeys(("name", "file", "sweep", "verdict", "reasons", "error"), pl.String)
    whole = dict.fromkeys(("primitives", "cycles", "rows"), pl.Int64)
    types = dict.fromkeys(COLUMNS, pl.Float64) | texts | whole | {"passed": pl.Boolean}
    with table.open("rb") as rows, kept_file(path) as stream:  # polars takes a path for a pattern, or for an address
        try:
            pl.scan_csv(rows, schema=types).sink_parquet(stream)
        except pl.exceptions.PolarsError as error:
            raise ResultsError(f"{path}: cannot be written ({error})") from error
