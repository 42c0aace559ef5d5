"""The documents of `purcell gait` and `purcell design`."""

from __future__ import annotations

from typing import Annotated, Literal, TypedDict

from purcell_cli.cli.documents.common import Done, Moves, SwimmerPart
from purcell_cli.motion.options import Controls


class PrimitivePart(TypedDict):
    """One primitive."""

    control: Annotated[str, "which limb turns about which of its axes"]
    angle_rad: Annotated[float, "by how much [rad]"]


class MovePart(TypedDict):
    """One move: all joints at once."""

    turn_rad: Annotated[dict[str, float], "by how much each control turns its joint [rad]"]


class TwistPart(TypedDict):
    """A displacement of the base by x, y, z and roll, pitch, yaw."""

    x_m: Annotated[float, "along x [m]"]
    y_m: Annotated[float, "along y [m]"]
    z_m: Annotated[float, "along z [m]"]
    roll_rad: Annotated[float, "about x [rad]"]
    pitch_rad: Annotated[float, "about y [rad]"]
    yaw_rad: Annotated[float, "about z [rad]"]


class GaitDocument(TypedDict):
    """What `purcell gait NAME` prints."""

    schema: Annotated[Literal["purcell/gait/1"], "the form of the document"]
    verdict: Done
    gait: Annotated[str, "the gait's name"]
    summary: Annotated[str, "what it does, in words"]
    amplitude_rad: Annotated[float, "its amplitude [rad]"]
    amplitude_means: Annotated[str, "what the amplitude is, in words"]
    cycles: Annotated[int, "how often it is played"]
    swimmer: Annotated[SwimmerPart, "who swims"]
    approach: Annotated[list[PrimitivePart] | list[MovePart], "played once before the cycles and undone after them"]
    cycle: Annotated[list[PrimitivePart] | list[MovePart], "one cycle"]
    joint_travel_rad: Annotated[float, "sum of |angle| over all that is played [rad]"]
    duration_s: Annotated[float, "how long it takes [s]"]
    displacement: Annotated[TwistPart, "what all cycles move the base by"]
    moves: Annotated[Moves, "what it is made to do"]
    cross_talk: Annotated[float | None, "largest part of the twist beside its own motion; null for `none` [L, rad]"]
    closure_rad: Annotated[float, "how far the limbs end from where they began [rad]"]
    energy_j: Annotated[float, "energy dissipated [J]"]
    trajectory: Annotated[str | None, "the trajectory's file"]


class ListedPart(TypedDict):
    """One stored gait."""

    name: Annotated[str, "its name"]
    also: Annotated[list[str], "its other names"]
    moves: Annotated[Moves, "what it is made to do"]
    amplitude_means: Annotated[str, "what the amplitude is, in words"]
    default_amplitude_rad: Annotated[float, "the amplitude it has where none is given [rad]"]
    summary: Annotated[str, "what it does, in words"]


class GaitListDocument(TypedDict):
    """What `purcell gait --list` prints."""

    schema: Annotated[Literal["purcell/gait-list/1"], "the form of the document"]
    verdict: Done
    gaits: Annotated[list[ListedPart], "the stored gaits"]


class MotionPart(TypedDict):
    """A displacement of the base by x, y, z in units of L and roll, pitch, yaw."""

    x_L: Annotated[float, "along x [L]"]
    y_L: Annotated[float, "along y [L]"]
    z_L: Annotated[float, "along z [L]"]
    roll_rad: Annotated[float, "about x [rad]"]
    pitch_rad: Annotated[float, "about y [rad]"]
    yaw_rad: Annotated[float, "about z [rad]"]


class _NamedPart(TypedDict):
    """Which gait an entry of the atlas is of."""

    gait: Annotated[str, "its name"]
    moves: Annotated[Moves, "what it is made to do"]
    amplitude_rad: Annotated[float, "its amplitude [rad]"]


class EntryPart(_NamedPart, MotionPart):
    """What one cycle of a gait does, seen from the collinear shape."""

    cross_talk: Annotated[float | None, "largest part of the twist beside its own motion; null for `none` [L, rad]"]
    joint_travel_rad: Annotated[float, "how far the joints turn in a cycle, in sum [rad]"]
    duration_s: Annotated[float, "how long a cycle lasts [s]"]
    energy_j: Annotated[float, "what a cycle dissipates [J]"]
    L_per_rad: Annotated[float, "distance over joint travel [L/rad]"]
    turn_per_rad: Annotated[float, "angle turned over joint travel [rad/rad]"]
    efficiency: Annotated[float, "hydrodynamic efficiency of a cycle"]


class LeftOutPart(TypedDict):
    """A gait that this swimmer has no stroke of."""

    gait: Annotated[str, "its name"]
    why: Annotated[str, "why"]


class AtlasDocument(TypedDict):
    """What `purcell gait --all` prints."""

    schema: Annotated[Literal["purcell/atlas/1"], "the form of the document"]
    verdict: Done
    swimmer: Annotated[SwimmerPart, "who swims"]
    gaits: Annotated[list[EntryPart], "what one cycle of each gait does"]
    left_out: Annotated[list[LeftOutPart], "gaits without a stroke for this swimmer"]
    atlas: Annotated[str | None, "the CSV file, if it is written"]


class AmplitudePart(TypedDict):
    """A gait at one amplitude."""

    amplitude_rad: Annotated[float, "the amplitude [rad]"]
    displacement: Annotated[float | None, "one cycle's, exact, in `unit`; null where no stroke is pure"]
    prediction: Annotated[float | None, "the same to leading order, in `unit`"]
    order: Annotated[int, "the order of the prediction in the turns, or 0"]
    reversed: Annotated[bool, "whether the direction has changed since the row before"]


class SweepDocument(TypedDict):
    """What `purcell gait NAME --sweep A:B:STEP` prints."""

    schema: Annotated[Literal["purcell/sweep/1"], "the form of the document"]
    verdict: Done
    gait: Annotated[str, "the gait's name"]
    swimmer: Annotated[SwimmerPart, "who swims"]
    along: Annotated[Moves, "the motion that is told"]
    unit: Annotated[Literal["L", "rad"], "the unit of displacements"]
    rows: Annotated[list[AmplitudePart], "one for each amplitude"]
    sweep: Annotated[str | None, "the CSV file, if it is written"]


class RatioPart(TypedDict):
    """A gait for a swimmer of one link ratio."""

    ratio: Annotated[float, "length of the middle over an outer link"]
    displacement: Annotated[float, "one cycle's, in `unit`"]


class LinkRatioDocument(TypedDict):
    """What `purcell gait NAME --link-ratio A:B:STEP` prints."""

    schema: Annotated[Literal["purcell/link-ratio/1"], "the form of the document"]
    verdict: Done
    gait: Annotated[str, "the gait's name"]
    swimmer: Annotated[SwimmerPart, "the swimmer whose full length is kept"]
    along: Annotated[Moves, "the motion that is told"]
    unit: Annotated[Literal["full lengths", "rad"], "the unit of displacements"]
    best_ratio: Annotated[float, "the ratio that moves most"]
    rows: Annotated[list[RatioPart], "one for each ratio"]
    sweep: Annotated[str | None, "the CSV file, if it is written"]


class DesignDocument(TypedDict):
    """What `purcell design` prints."""

    schema: Annotated[Literal["purcell/design/1"], "the form of the document"]
    verdict: Done
    direction: Annotated[Moves, "what it was made to do"]
    maximize: Annotated[Literal["speed", "efficiency"], "what it has most of"]
    planar: Annotated[bool, "whether all bends are in one plane"]
    controls: Annotated[Controls, "whether a move turns one joint or all"]
    max_bend_rad: Annotated[float, "how far limbs may bend [rad]"]
    moves: Annotated[int, "moves in a cycle"]
    seed: Annotated[int, "seed of the random starts"]
    starts: Annotated[int, "how many starts were looked at"]
    interrupted: Annotated[bool, "whether the search was ended before all starts were over"]
    swimmer: Annotated[SwimmerPart, "who swims"]
    per_joint_travel: Annotated[float, "displacement over joint travel, in `unit`"]
    unit: Annotated[Literal["L/rad", "rad/rad"], "the unit of `per_joint_travel`"]
    largest_bend_rad: Annotated[float, "the largest bend of the stroke [rad]"]
    stroke: Annotated[EntryPart, "what one cycle does"]
    gait: Annotated[str, "the gait's file"]
