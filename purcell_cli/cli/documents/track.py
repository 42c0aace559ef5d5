"""The document of `purcell track`."""

from __future__ import annotations

from typing import Annotated, Literal, TypedDict

from purcell_cli.cli.documents.common import DeviationPart, SwimmerPart


class MeasuringPart(TypedDict):
    """The noise of measurements: standard deviations of each component."""

    position_l: Annotated[float, "of the base's position, in units of L"]
    base_deg: Annotated[float, "of the base's orientation [deg]"]
    seed: Annotated[int, "seed of the numbers"]
    at_rest: Annotated[int, "how often a swimmer that rests is measured; the mean counts"]


class TrackPart(TypedDict):
    """A plan that was swum, or its beginning."""

    leg: Annotated[int, "which leg of a mission it is of, from 1"]
    joint_travel_rad: Annotated[float, "the joint travel that was swum [rad]"]
    duration_s: Annotated[float, "how long that took [s]"]
    measured_off: Annotated[
        DeviationPart, "how far from the leg's end the swimmer was measured to be after it, in what counts"
    ]
    off: Annotated[DeviationPart, "how far from there it really was"]


class TrackDocument(TypedDict):
    """What `purcell track` prints."""

    schema: Annotated[Literal["purcell/track/1"], "the form of the document"]
    verdict: Annotated[Literal["reached", "not reached"], "whether the goal was reached within the tolerances"]
    model: Annotated[SwimmerPart, "the swimmer that was planned for"]
    truth: Annotated[SwimmerPart, "the swimmer that swam"]
    noise: Annotated[MeasuringPart, "the noise of measurements"]
    tolerance_l: Annotated[float, "position tolerance, in units of L"]
    tolerance_deg: Annotated[float, "angle tolerance [deg]"]
    replans: Annotated[int, "how often it was planned again; a mission's legs have a first plan each"]
    joint_travel_rad: Annotated[float, "joint travel of all parts [rad]"]
    off: Annotated[DeviationPart, "how far from the goal the swimmer really ended"]
    off_curve_m: Annotated[float | None, "how far from the curve to follow the base's middle really was at most [m]"]
    obstacle_m: Annotated[float | None, "how near a link really came to an obstacle in any row, negative inside [m]"]
    parts: Annotated[list[TrackPart], "the parts that were swum, in order, with a new plan after each but the last"]
    out: Annotated[str | None, "the file of what really happened"]
