"""The document of `purcell fit`."""

from __future__ import annotations

from typing import Annotated, Literal, TypedDict

from purcell_cli.cli.documents.common import SwimmerPart


class FactorPart(TypedDict):
    """A factor on the drag of some links."""

    name: Annotated[str, "its name"]
    links: Annotated[list[Literal["base", "limb1", "limb2"]], "the links that it is for"]
    drag: Annotated[Literal["along", "across", "turn", "spin", "ratio"], "which drag; ratio: across over along"]
    value: Annotated[float, "by how much the guess is multiplied"]
    standard_error: Annotated[float | None, "of the value; null where the data do not tell it"]
    told: Annotated[bool, "whether the data tell it; else it stays as in the guess"]
    only_with: Annotated[list[str], "where they do not: the factors that they tell only together with it"]
    guess: Annotated[list[float], "the links' drag in the guess [N s/m; N m s of turn and spin; a number of ratio]"]
    fitted: Annotated[list[float], "the same, fitted"]


class LeftPart(TypedDict):
    """What is left of the displacements: root mean squares over the rows of all windows."""

    position_l: Annotated[float, "of each component of the position, in units of L"]
    angle_deg: Annotated[float, "of each component of the rotation [deg]"]


class FitDocument(TypedDict):
    """What `purcell fit` prints."""

    schema: Annotated[Literal["purcell/fit/1"], "the form of the document"]
    verdict: Annotated[Literal["fitted", "not settled"], "whether the fit ended at drags that links can have"]
    measured: Annotated[list[str], "the measured trajectories' files"]
    what: Annotated[Literal["ratio", "kinds", "links"], "which factors are fitted"]
    guess: Annotated[SwimmerPart, "the swimmer that was begun with"]
    swimmer: Annotated[SwimmerPart, "the swimmer that was fitted"]
    factors: Annotated[list[FactorPart], "the factors between the two; none on the base's drag across, the unit"]
    untold: Annotated[list[str], "the names of those that the data do not tell"]
    rows: Annotated[int, "rows that were used"]
    windows: Annotated[int, "windows that they were parted into"]
    left_by_guess: Annotated[LeftPart, "what the guess leaves of the displacements"]
    left: Annotated[LeftPart, "what the fitted swimmer leaves of them"]
    out: Annotated[str | None, "the file of the fitted swimmer; null where nothing was written"]
