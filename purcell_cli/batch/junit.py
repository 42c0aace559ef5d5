"""A batch's outcome as a JUnit report, which CI services read: one test case a scenario."""

from __future__ import annotations

import html
import re
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from purcell_cli.batch.results_folder import kept_file
from purcell_cli.batch.rows import CRASHED, Row

_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write_report(rows: Iterable[Row], totals: Mapping[str, int], path: Path, seconds: float) -> None:
    """Write the report.

    Args:
        rows: The rows of the summary.
        totals: How many scenarios, failures and crashes there are.
        path: The file.
        seconds: How long the batch took [s].
    """
    suite = {
        "name": "purcell batch",
        "package": "purcell",
        "id": 0,
        "timestamp": datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%S"),
        "hostname": "localhost",
        "tests": totals["scenarios"],
        "failures": totals["failed"] - totals["crashed"],
        "errors": totals["crashed"],
        "time": f"{seconds:.3f}",
    }
    with kept_file(path) as stream:
        stream.write(
            f'<?xml version="1.0" encoding="UTF-8"?>\n<testsuites>\n<testsuite{_attributes(suite)}>\n'.encode()
        )
        stream.write(b"<properties/>\n")
        for row in rows:
            stream.write(_case(row).encode())
        stream.write(b"<system-out/>\n<system-err/>\n</testsuite>\n</testsuites>\n")


def _case(row: Row) -> str:
    attributes = {"name": row["name"], "classname": _class(row["file"]), "time": f"{row['wall_time_s']:.3f}"}
    begun = f"<testcase{_attributes(attributes)}"
    if row["passed"]:
        return f"{begun}/>\n"
    kind = "error" if row["verdict"] == CRASHED else "failure"
    about = {"message": "; ".join(row["reasons"]), "type": row["verdict"]}
    text = _clean("\n".join(row["reasons"]))
    return f"{begun}><{kind}{_attributes(about)}>{text}</{kind}></testcase>\n"


def _class(file: str) -> str:
    """Return a file's path in the form of a class name, by which services sort test cases."""
    parts = [part for part in Path(file).with_suffix("").parts if part not in {"/", "\\", ".", ".."}]
    return ".".join(parts) or "scenario"


def _attributes(values: Mapping[str, Any]) -> str:
    return "".join(f' {name}="{_clean(str(value))}"' for name, value in values.items())


def _clean(text: str) -> str:
    """Return a text as XML writes it; characters that XML has no place for are replaced."""
    return html.escape(_NOT_XML.sub("\N{REPLACEMENT CHARACTER}", text))
