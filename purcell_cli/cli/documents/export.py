"""The document of `purcell export`."""

from __future__ import annotations

from typing import Annotated, Literal, TypedDict

from purcell_cli.cli.documents.common import Done


class ExportDocument(TypedDict):
    """What `purcell export` prints."""

    schema: Annotated[Literal["purcell/export/1"], "the form of the document"]
    verdict: Done
    trajectory: Annotated[str, "the trajectory's file"]
    to: Annotated[Literal["servo", "mcap", "rerun", "urdf"], "what it is exported to"]
    file: Annotated[str, "the file that was written"]
    holds: Annotated[str, "what the file has many of: ticks, messages, rows or joints"]
    count: Annotated[int, "how many of those"]
    joints: Annotated[list[str], "the hinges' names, in the order of the file; none for rerun"]
    duration_s: Annotated[float, "how long the motion takes [s]"]
    bytes: Annotated[int, "size of the file [bytes]"]
