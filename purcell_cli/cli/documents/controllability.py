"""The documents of `purcell controllability`."""

from __future__ import annotations

from typing import Annotated, Literal, NotRequired, TypedDict

from purcell_cli.cli.documents.common import Direction, Done, SwimmerPart
from purcell_cli.lie_brackets.controllability import Shown


class ShapePart(TypedDict):
    """A shape of the swimmer."""

    limb1_euler_deg: Annotated[list[float], "psi, theta, phi of limb 1 in the base [deg]"]
    limb2_euler_deg: Annotated[list[float], "psi, theta, phi of limb 2 in the base [deg]"]


class BesidePart(TypedDict):
    """How a swimmer sees its wall."""

    height_m: Annotated[float, "how high the base's middle is above it [m]"]
    normal: Annotated[list[float], "its normal in base coordinates"]


class RankPart(TypedDict):
    """The rank of some twists, and how safely it is known."""

    dimension: Annotated[int, "how many directions are above rounding"]
    not_weak: Annotated[int, "how many of them are not weak"]
    singular_values: Annotated[list[float], "of the twists, largest first [L, rad]"]
    rounding: Annotated[float, "what rounding can leave of a singular value that is 0"]
    gap: Annotated[float | None, "smallest singular value that counts over the largest that does not; null if infinite"]
    decision: Annotated[Literal["clear", "weak", "undecided"], "how safe the rank is"]


class LevelPart(RankPart):
    """One bracket depth, or one space h_k, with all below it."""

    level: Annotated[int, "the depth, or k"]
    brackets: Annotated[int, "how many brackets are of this level"]
    new_directions: Annotated[list[dict[str, float]], "directions that are new, each as its parts"]


class BracketPart(TypedDict):
    """A bracket of the controls and the base motion that it leaves."""

    bracket: Annotated[str, "the bracket, by controls"]
    depth: Annotated[int, "how many controls are in it"]
    rate: Annotated[float, "motion in the direction [L or rad per rad^depth]"]
    twist: Annotated[dict[str, float], "all its motion, by direction [L, rad per rad^depth]"]
    limbs_to_bring_back: Annotated[dict[str, float], "the limb rotation that it leaves, by control [rad per rad^depth]"]
    trusted_rad: Annotated[float | None, "up to which turns the leading order holds [rad]; null beside a wall"]


class DirectionPart(TypedDict):
    """A direction of the base, and the brackets that make it."""

    direction: Annotated[Direction, "the direction"]
    brackets: Annotated[list[BracketPart], "the brackets that make it, the strongest first"]


class ControllabilityDocument(TypedDict):
    """What `purcell controllability` prints."""

    schema: Annotated[Literal["purcell/controllability/1"], "the form of the document"]
    verdict: Annotated[Shown, "what is shown within the depth"]
    swimmer: Annotated[SwimmerPart, "who swims"]
    shape: Annotated[ShapePart, "the shape"]
    beside: NotRequired[Annotated[BesidePart, "where the wall is, for a swimmer beside one"]]
    planar: Annotated[bool, "whether the yaw joints alone turn"]
    depth: Annotated[int, "the deepest brackets asked for"]
    dimension: Annotated[int, "dimension of the configuration space: 12, or 5 in the plane"]
    growth_vector: Annotated[list[int], "the dimension that brackets up to depth 1, 2, ... span"]
    chow: Annotated[bool, "whether Chow's condition holds within the depth"]
    weak_level: Annotated[
        int | None, "the k at which h_1 + ... + h_k is all of se(3); null if it is not seen, and beside a wall"
    ]
    weak_below: Annotated[float, "singular values below this are weak [L, rad]"]
    direct: Annotated[RankPart, "rank of A(r), what the controls do directly"]
    null_directions: Annotated[list[dict[str, float]], "limb rates that leave the base still, each by control"]
    depths: Annotated[list[LevelPart], "brackets by depth, from 2"]
    filtration: Annotated[list[LevelPart], "the spaces h_1 + ... + h_k of appendix A; none beside a wall"]
    trusted_within: Annotated[float, "the error that `trusted_rad` allows, as a fraction"]
    directions: Annotated[list[DirectionPart], "which brackets make which direction"]


class WeakestPart(RankPart):
    """A rank, and its weakest direction."""

    least: Annotated[float, "the least singular value, 0 for rounding [L, rad]"]
    weakest: Annotated[Direction, "the direction that it is mostly in"]


class StrengthPart(TypedDict):
    """How strong the directions are at one shape, both limbs bent alike."""

    bend_deg: Annotated[float, "the bend of both limbs [deg]"]
    roll_deg: Annotated[float, "the angle between their planes [deg]"]
    direct: Annotated[RankPart, "what the controls do directly"]
    filtration_2: Annotated[WeakestPart, "h_1 + h_2, the shape left free"]
    brackets: Annotated[WeakestPart, "brackets up to the depth, the limbs brought back"]


class MapDocument(TypedDict):
    """What `purcell controllability --map` prints."""

    schema: Annotated[Literal["purcell/controllability-map/1"], "the form of the document"]
    verdict: Done
    swimmer: Annotated[SwimmerPart, "who swims"]
    depth: Annotated[int, "the deepest brackets"]
    weak_below: Annotated[float, "singular values below this are weak [L, rad]"]
    shapes: Annotated[list[StrengthPart], "one for each shape of the grid"]
    picture: Annotated[str | None, "the picture's file, if it is drawn"]
