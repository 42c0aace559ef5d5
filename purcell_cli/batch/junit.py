"""A batch's outcome as a JUnit report, which CI services read: one test case a scenario."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterable, Iterator, Mapping
from datetime import UTC, datetime
from pathlib import Path
from types import MappingProxyType
from typing import Any
from xml.sax.saxutils import XMLGenerator
from xml.sax.xmlreader import AttributesImpl

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
        xml = XMLGenerator(stream, "UTF-8", short_empty_elements=True)
        xml.startDocument()
        with _element(xml, "testsuites"), _element(xml, "testsuite", suite):
            with _element(xml, "properties"):
                pass
            for row in rows:
                _write_case(xml, row)
            for name in ("system-out", "system-err"):
                with _element(xml, name):
                    pass


def _write_case(xml: XMLGenerator, row: Row) -> None:
    attributes = {"name": row["name"], "classname": _class(row["file"]), "time": f"{row['wall_time_s']:.3f}"}
    with _element(xml, "testcase", attributes):
        if not row["passed"]:
            about = {"message": "; ".join(row["reasons"]), "type": row["verdict"]}
            with _element(xml, "error" if row["verdict"] == CRASHED else "failure", about):
                xml.characters(_clean("\n".join(row["reasons"])))
    xml.ignorableWhitespace("\n")


@contextlib.contextmanager
def _element(xml: XMLGenerator, name: str, attributes: Mapping[str, Any] = MappingProxyType({})) -> Iterator[None]:
    """Write an element round what is written inside the context."""
    xml.startElement(name, AttributesImpl({key: _clean(str(value)) for key, value in attributes.items()}))
    yield
    xml.endElement(name)


def _class(file: str) -> str:
    """Return a file's path in the form of a class name, by which services sort test cases."""
    parts = [part for part in Path(file).with_suffix("").parts if part not in {"/", "\\", ".", ".."}]
    return ".".join(parts) or "scenario"


def _clean(text: str) -> str:
    """Return a text without the characters that XML has no place for, which are replaced."""
    return _NOT_XML.sub("\N{REPLACEMENT CHARACTER}", text)
