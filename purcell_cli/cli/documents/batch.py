"""The document of `purcell batch`; that of its summary is `batch.rows.Summary`."""

from __future__ import annotations

from typing import Annotated, Literal, TypedDict

from purcell_cli.batch.rows import RowVerdict


class FailurePart(TypedDict):
    """A scenario that is not what it must be."""

    name: Annotated[str, "its name"]
    file: Annotated[str, "the file that it stands in"]
    verdict: Annotated[RowVerdict, "how it ended"]
    reasons: Annotated[list[str], "why it failed, a sentence each"]


class BatchDocument(TypedDict):
    """What `purcell batch` prints."""

    schema: Annotated[Literal["purcell/batch/1"], "the form of the document"]
    verdict: Annotated[Literal["passed", "failed"], "whether all scenarios are what they must be"]
    scenarios: Annotated[int, "how many there are"]
    solved: Annotated[int, "how many were solved now, the others being finished before"]
    failed: Annotated[int, "how many are not what they must be"]
    crashed: Annotated[int, "how many of those crashed"]
    compared: Annotated[int | None, "how many are in the baseline; null without one"]
    vanished: Annotated[list[str] | None, "scenarios of the baseline that are not in the batch; null without one"]
    failures: Annotated[list[FailurePart], "those that failed, at most 1000"]
    wall_time_s: Annotated[float, "how long the batch took [s]"]
    folder: Annotated[str, "the folder of results"]
    junit: Annotated[str | None, "the JUnit report's file, if one is written"]
    passed_over: Annotated[int, "files in folders that are parts of scenarios and none themselves"]
