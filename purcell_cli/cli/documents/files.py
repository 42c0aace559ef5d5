"""The documents of `purcell init`, `validate`, `schema`, `plot`, `figures` and `view`."""

from __future__ import annotations

from typing import Annotated, Literal, TypedDict

from purcell_cli.cli.documents.common import Done

Kind = Literal["start", "goal", "swimmer", "scenario", "gait", "plan", "servo-map"]


class InitDocument(TypedDict):
    """What `purcell init` prints."""

    schema: Annotated[Literal["purcell/init/1"], "the form of the document"]
    verdict: Done
    files: Annotated[list[str], "the files that were written"]


class CheckedPart(TypedDict):
    """One file that was checked."""

    file: Annotated[str, "the file"]
    kind: Annotated[Kind | None, "what kind of document it is; null if that cannot be told"]
    error: Annotated[str | None, "what is wrong; null if nothing is"]
    scenarios: Annotated[int | None, "how many scenarios a scenario's file stands for; null for others"]


class ValidateDocument(TypedDict):
    """What `purcell validate` prints."""

    schema: Annotated[Literal["purcell/validate/1"], "the form of the document"]
    verdict: Annotated[Literal["good", "bad"], "whether all files are good"]
    files: Annotated[list[CheckedPart], "the files, in the order given"]


class SchemaDocument(TypedDict):
    """What `purcell schema` prints where `--out` is given; without it, it prints the JSON Schema itself."""

    schema: Annotated[Literal["purcell/schema/1"], "the form of the document"]
    verdict: Done
    kind: Annotated[Kind, "the kind of document that the JSON Schema is of"]
    file: Annotated[str, "the file that it was written to"]


class PlotDocument(TypedDict):
    """What `purcell plot` prints."""

    schema: Annotated[Literal["purcell/plot/1"], "the form of the document"]
    verdict: Done
    of: Annotated[str, "the file or gait that is drawn"]
    kind: Annotated[Literal["trajectory", "gait"], "which of the two"]
    picture: Annotated[str, "the picture's file"]


class FiguresDocument(TypedDict):
    """What `purcell figures` prints."""

    schema: Annotated[Literal["purcell/figures/1"], "the form of the document"]
    verdict: Done
    pictures: Annotated[list[str], "the pictures' files"]


class ViewDocument(TypedDict):
    """What `purcell view` prints."""

    schema: Annotated[Literal["purcell/view/1"], "the form of the document"]
    verdict: Done
    trajectory: Annotated[str, "the trajectory's file"]
    page: Annotated[str, "the page's file"]
    rows: Annotated[int, "rows of the trajectory"]
    frames: Annotated[int, "rows that the page has"]
    bytes: Annotated[int, "size of the page [bytes]"]


class FilmDocument(TypedDict):
    """What `purcell view` prints of a film."""

    schema: Annotated[Literal["purcell/film/1"], "the form of the document"]
    verdict: Done
    trajectory: Annotated[str, "the trajectory's file"]
    film: Annotated[str, "the film's file"]
    rows: Annotated[int, "rows of the trajectory"]
    frames: Annotated[int, "frames of the film"]
    fps: Annotated[float, "frames in a second"]
    width_px: Annotated[int, "width of a frame [pixels]"]
    height_px: Annotated[int, "height of a frame [pixels]"]
    bytes: Annotated[int, "size of the film [bytes]"]
