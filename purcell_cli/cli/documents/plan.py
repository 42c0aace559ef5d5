"""The documents of `purcell plan`, `purcell run`, `purcell replan` and `purcell verify`."""

from __future__ import annotations

from typing import Annotated, Literal, NotRequired, TypedDict

from purcell_cli.cli.documents.common import (
    CertificatePart,
    DeviationPart,
    DisplacementPart,
    SwimmerPart,
    TolerancePart,
)
from purcell_cli.motion.options import Controls
from purcell_cli.motion.verdict import PlanVerdict, Verdict


class StrokePart(TypedDict):
    """One stroke: a gait played a number of times."""

    gait: Annotated[str, "its name"]
    amplitude_rad: Annotated[float | None, "its amplitude, if it has one [rad]"]
    cycles: Annotated[int, "how often it is played"]
    primitives: Annotated[int, "primitives or moves, of all cycles"]
    joint_travel_rad: Annotated[float, "sum of |angle| over them [rad]"]
    duration_s: Annotated[float, "how long it takes [s]"]
    energy_j: Annotated[float, "energy dissipated [J]"]
    displacement: Annotated[DisplacementPart, "what it moves the base by"]


class PhasePart(TypedDict):
    """One of the three phases of a plan."""

    phase: Annotated[int, "1, 2 or 3"]
    name: Annotated[str, "what it does"]
    primitives: Annotated[int, "primitives or moves"]
    joint_travel_rad: Annotated[float, "sum of |angle| over them [rad]"]
    duration_s: Annotated[float, "how long it takes [s]"]
    energy_j: Annotated[float, "energy dissipated [J]"]
    largest_bend_rad: Annotated[float | None, "largest angle between a limb's axis and the base's; null if still [rad]"]
    displacement: Annotated[DisplacementPart, "what it moves the base by"]
    strokes: Annotated[list[StrokePart], "its strokes, in order"]


class WorkspacePart(TypedDict):
    """A box that all links stay in."""

    min: Annotated[list[float | None], "the corner of least x, y and z, null for no wall there [m]"]
    max: Annotated[list[float | None], "the opposite corner, null for no wall there [m]"]


class ViolationPart(TypedDict):
    """A limit that the motion breaks, where it breaks it most."""

    limit: Annotated[Literal["clearance", "bend", "joint", "range", "workspace", "obstacle", "follow"], "which limit"]
    excess: Annotated[float, "by how much, in `unit`"]
    unit: Annotated[Literal["m", "rad"], "the unit of `excess`"]
    time_s: Annotated[float, "when [s]"]
    phase: Annotated[int, "in which phase"]
    what: Annotated[str, "what breaks it, in words"]


class EncounterPart(TypedDict):
    """How near a motion comes to obstacles, and where it comes nearest."""

    distance_m: Annotated[float, "least distance between a link's surface and an obstacle's, never more than it is [m]"]
    error_m: Annotated[float, "how much more it may be [m]"]
    link: Annotated[Literal["base", "limb 1", "limb 2", "body"], "which link"]
    obstacle: Annotated[int, "which obstacle, its index from 0"]
    between: Annotated[str, "both, in words"]
    time_s: Annotated[float, "when [s]"]
    phase: Annotated[int, "in which phase"]


class BlockedPart(TypedDict):
    """How near a search for a way round obstacles came that found none, and what is in the way."""

    position_m: Annotated[
        list[float], "where the base's middle is at the pose nearest to the goal that ways lead to [m]"
    ]
    left_m: Annotated[float, "how far that is from the goal, or from the leg's end [m]"]
    obstacle: Annotated[int | None, "what is first in the way, its index from 0; null for a wall of the workspace"]
    leg: Annotated[int, "which leg of a mission, from 0"]
    words: Annotated[str, "all that, in words"]


class LimitsPart(TypedDict):
    """The limits of a plan and whether it keeps them."""

    clearance_m: Annotated[float, "least distance wanted between the limbs' surfaces [m]"]
    max_bend_rad: Annotated[float, "largest bend wanted [rad]"]
    workspace_m: Annotated[WorkspacePart | None, "the box to stay in, if there is one [m]"]
    workspace_violation_m: Annotated[float | None, "how far a link leaves the box; null without a box [m]"]
    obstacle: Annotated[EncounterPart | None, "how near links come to obstacles; null without any"]
    kept: Annotated[bool, "whether all limits are kept over the whole path"]
    violations: Annotated[list[ViolationPart], "the limits that are broken"]


class MissingPart(DisplacementPart):
    """A displacement still to be made, and its size."""

    position_over_L: Annotated[float, "its distance in units of L"]  # noqa: N815  # L is the length
    angle_rad: Annotated[float, "its angle [rad]"]


class StrokeReasonPart(TypedDict):
    """What a stroke is for."""

    phase: Annotated[int, "1, 2 or 3"]
    gait: Annotated[str, "its name"]
    description: Annotated[str, "what it does"]
    cycles: Annotated[int, "how often it is played"]
    joint_travel_rad: Annotated[float, "what it costs [rad]"]
    energy_j: Annotated[float, "energy dissipated [J]"]
    missing: Annotated[MissingPart, "what is left to be done after it: to phase 3, or to the goal"]
    largest_bend_rad: Annotated[float, "largest bend of a limb while it is played [rad]"]
    limits: Annotated[list[str], "which limits it is at"]


class StructurePart(TypedDict):
    """A way to build the plan that was weighed."""

    description: Annotated[str, "what it does"]
    joint_travel_rad: Annotated[float, "its joint travel, as estimated [rad]"]
    why_not: Annotated[str, "why it was not taken though it has less joint travel; else empty"]


class LargestPart(TypedDict):
    """The stroke that has the largest part in a sensitivity."""

    stroke: Annotated[int, "its index in `strokes`, from 0"]
    share: Annotated[float, "its part of the whole, 0 to 1"]
    description: Annotated[str, "what makes it sensitive; empty if nothing does"]


class SensitivityPart(TypedDict):
    """What a swimmer that is a little off does to the end of the motion."""

    parameter: Annotated[str, "which parameter of the swimmer is off"]
    change: Annotated[float, "by which fraction; of both signs the worse"]
    position_m: Annotated[float, "how far the end moves [m]"]
    position_over_L: Annotated[float, "the same in units of L"]
    angle_rad: Annotated[float, "how far the end turns [rad]"]
    largest_part: Annotated[LargestPart | None, "where most of it comes from; null if nothing moves"]


class OnBeadsPart(TypedDict):
    """Where a plan would end if links felt each other's flow, to two per cent of it."""

    position_m: Annotated[float | None, "how far from the goal; null where it is not known [m]"]
    position_over_L: Annotated[float | None, "the same in units of L"]
    angle_rad: Annotated[float | None, "how far the base is turned from the goal; null where it is not known [rad]"]
    why_not: Annotated[str, "why it is not known, in words; else empty"]


class ExplanationPart(TypedDict):
    """Why a plan is as it is."""

    strokes: Annotated[list[StrokeReasonPart], "what each stroke is for, in order"]
    structures: Annotated[list[StructurePart], "what was weighed, the one taken first"]
    sensitivity: Annotated[list[SensitivityPart], "what would upset the plan, a parameter each"]
    on_beads: Annotated[OnBeadsPart, "where it would end if links felt each other's flow"]


class RestPart(TypedDict):
    """What is left of a plan from a measured configuration."""

    kept: Annotated[bool, "whether it is made of the plan's own strokes; else it was planned anew"]
    off_way: Annotated[
        float | None,
        "how far from the plan's way the configuration is, a radian as L [L]; null where all joints turn at once",
    ]
    done_rad: Annotated[float, "the plan's joint travel up to the nearest place of its way, or by `--after` [rad]"]
    left_rad: Annotated[float, "the plan's joint travel from there on [rad]"]


class WaypointPart(TypedDict):
    """A waypoint that is passed."""

    index: Annotated[int, "its place in the scenario's list, from 0"]
    names: Annotated[list[Literal["position_m", "orientation", "limb1", "limb2"]], "what it names; the rest is free"]
    time_s: Annotated[float, "when it is passed [s]"]
    error: Annotated[DeviationPart, "from what it names to the re-integrated motion then; 0 in what is free"]


class CurvePart(TypedDict):
    """A curve that is followed."""

    length_m: Annotated[float, "how long it is [m]"]
    tolerance_m: Annotated[float, "how far from it the base's middle may be [m]"]
    distance_m: Annotated[float, "what its distance from the curve does not exceed at any instant [m]"]
    turned_rad: Annotated[
        float | None,
        "what the base's turn from the curve's orientation does not exceed at any instant [rad]; null where it is free",
    ]


class PlanDocument(TypedDict):
    """What `purcell plan`, `purcell run` and `purcell replan` print."""

    schema: Annotated[Literal["purcell/plan/1", "purcell/run/1", "purcell/replan/1"], "the form of the document"]
    verdict: Annotated[PlanVerdict, "how it ended; only `reached` is success"]
    swimmer: Annotated[SwimmerPart, "who swims"]
    controls: Annotated[Controls, "whether joints turn one after the other or at once"]
    joint_travel_rad: Annotated[float, "sum of |angle| over all primitives, or over all moves and joints [rad]"]
    duration_s: Annotated[float, "how long the motion takes [s]"]
    energy_j: Annotated[float, "energy dissipated [J]"]
    primitives: Annotated[int, "primitives or moves"]
    cycles: Annotated[int, "cycles of the strokes of phase 2"]
    phases: Annotated[list[PhasePart], "the three phases"]
    planned_error: Annotated[DeviationPart, "from the goal to the end by the planner's own flow"]
    verified_error: Annotated[DeviationPart, "from the goal to the end by re-integration"]
    rows_error: Annotated[DeviationPart, "largest distance of the rows from the re-integration, where controls change"]
    tolerance: Annotated[TolerancePart, "deviations up to which the goal is reached"]
    certificate: Annotated[CertificatePart, "how the controls were re-integrated"]
    clearance_m: Annotated[float, "least distance of the limbs' surfaces over the whole path [m]"]
    largest_bend_rad: Annotated[float | None, "largest bend in phase 2; null if nothing moves in it [rad]"]
    limits: Annotated[LimitsPart, "the limits, and what breaks them"]
    blocked: Annotated[BlockedPart | None, "where a search for a way round obstacles ended; null where none failed"]
    waypoints: Annotated[list[WaypointPart], "the waypoints, in the order in which they are passed"]
    follow: Annotated[CurvePart | None, "the curve that is followed; null without one"]
    table_error: NotRequired[
        Annotated[
            float,
            "of links that feel each other: joint travel times the largest error of their table's twists at rows of "
            "the trajectory, about what the end on the beads themselves is off at most [L, rad]",
        ]
    ]
    rows: Annotated[int, "rows of the trajectory"]
    trajectory: Annotated[str | None, "the trajectory's file"]
    plan_document: Annotated[str | None, "the plan document's file, written or read"]
    rest: NotRequired[Annotated[RestPart, "of `purcell replan`: what is left of the plan"]]
    explanation: NotRequired[Annotated[ExplanationPart, "with `--explain`: why the plan is as it is"]]


class PassingPart(TypedDict):
    """Where a waypoint is passed, or where the motion comes nearest to it."""

    index: Annotated[int, "its place in the scenario's list, from 0"]
    passed: Annotated[bool, "whether it is passed within the tolerance"]
    time_s: Annotated[float, "when [s]"]
    error: Annotated[DeviationPart, "from what it names to the re-integrated motion then; 0 in what is free"]


class JudgedPart(TypedDict):
    """The limits that a trajectory was held against."""

    clearance_m: Annotated[float, "least distance wanted between the limbs' surfaces [m]"]
    max_bend_rad: Annotated[float, "largest bend wanted in phase 2; in 1 and 3 also the start's and goal's own [rad]"]
    workspace_m: Annotated[WorkspacePart | None, "the box to stay in; null where none is known [m]"]
    joint_rate_rad_s: Annotated[list[float], "greatest rate wanted of limb 1's joint and of limb 2's [rad/s]"]
    joint_acceleration_rad_s2: Annotated[
        float | None, "greatest acceleration wanted of them; null where rates may jump [rad/s^2]"
    ]
    joint_ranges: Annotated[bool, "whether joints were held against axes and ranges; not where both are ball joints"]


class VerifyDocument(TypedDict):
    """What `purcell verify` prints."""

    schema: Annotated[Literal["purcell/verify/1"], "the form of the document"]
    verdict: Annotated[Literal[Verdict.REACHED, Verdict.NOT_REACHED], "whether the file holds"]
    swimmer: Annotated[SwimmerPart, "who swims"]
    start_error: Annotated[DeviationPart, "from the start to the first row"]
    verified_error: Annotated[DeviationPart, "from the goal to the end by re-integration"]
    tolerance: Annotated[TolerancePart, "deviations that are allowed"]
    certificate: Annotated[CertificatePart, "how the controls were re-integrated"]
    clearance_m: Annotated[float, "least distance of the limbs' surfaces over the whole path [m]"]
    largest_bend_rad: Annotated[float | None, "largest bend in phase 2; null if nothing moves in it [rad]"]
    workspace_violation_m: Annotated[float | None, "how far a link leaves the workspace; null without one [m]"]
    obstacle_distance_m: Annotated[float | None, "least distance of a link from an obstacle; null without any [m]"]
    waypoints: Annotated[list[PassingPart], "where waypoints are passed, or nearest, in the order of the rows"]
    follow: Annotated[CurvePart | None, "the curve that is to be followed; null without one"]
    judged: Annotated[JudgedPart, "the limits that the file was held against"]
    faults: Annotated[list[str], "what is wrong, a sentence each"]
