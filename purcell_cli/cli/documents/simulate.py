"""The document of `purcell simulate`."""

from __future__ import annotations

from typing import Annotated, Literal, TypedDict

from purcell_cli.cli.documents.common import DeviationPart, Done, SwimmerPart


class NoisePart(TypedDict):
    """What disturbed the swimmer: standard deviations."""

    angle_deg: Annotated[float, "of the joints' zeros [deg]"]
    rate: Annotated[float, "of the part by which rates are off"]
    drift_m_s: Annotated[float, "of each component of a stream's velocity [m/s]"]
    seed: Annotated[int, "seed of the numbers"]


class CoordinatesPart(TypedDict):
    """By how much each coordinate is off, in the world; limbs in the base."""

    position_m: Annotated[list[float], "x, y, z of the base's middle [m]"]
    base_euler_rad: Annotated[list[float], "psi, theta, phi of the base [rad]"]
    limb1_euler_rad: Annotated[list[float], "psi, theta, phi of limb 1 [rad]"]
    limb2_euler_rad: Annotated[list[float], "psi, theta, phi of limb 2 [rad]"]


class LossPart(TypedDict):
    """A stroke, and by how much it alone moves the end."""

    phase: Annotated[int, "its phase"]
    gait: Annotated[str, "its name"]
    begins_s: Annotated[float, "when it begins [s]"]
    ends_s: Annotated[float, "when it ends [s]"]
    position_m: Annotated[float, "how far the end moves by it [m]"]
    position_over_L: Annotated[float, "the same in units of L"]
    angle_rad: Annotated[float, "how far the end turns by it [rad]"]


class SimulateDocument(TypedDict):
    """What `purcell simulate` prints."""

    schema: Annotated[Literal["purcell/simulate/1"], "the form of the document"]
    verdict: Done
    trajectory: Annotated[str, "the file whose controls are played"]
    model: Annotated[SwimmerPart | None, "whose trajectory it is, where that is known"]
    swimmer: Annotated[SwimmerPart, "who swims"]
    noise: Annotated[NoisePart, "what disturbs it"]
    slower_s: Annotated[float, "by how much longer it takes than the file says, at the joints' own pace [s]"]
    off: Annotated[DeviationPart, "how far the end is from the trajectory's"]
    coordinates: Annotated[CoordinatesPart, "the same, coordinate by coordinate"]
    strokes: Annotated[list[LossPart], "the strokes, in order"]
    worst_stroke: Annotated[int | None, "the index of the one that lost most, null where nothing is lost"]
    out: Annotated[str | None, "the file of what really happened"]
