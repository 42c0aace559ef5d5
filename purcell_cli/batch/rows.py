"""The rows of a batch's summary, and the summary, as types."""

from __future__ import annotations

from typing import Annotated, Any, Final, Literal, TypedDict

from purcell_cli.motion.verdict import Verdict

CRASHED: Final = "crashed"
"""The verdict of a scenario that no input explains: a fault of the program, or a worker that died."""

RowVerdict = Verdict | Literal["crashed"]
"""How a scenario of a batch can end."""


class Numbers(TypedDict):
    """What is measured of a plan; null where there is none."""

    joint_travel_rad: Annotated[float | None, "sum of |angle| over all primitives, or over all moves and joints [rad]"]
    duration_s: Annotated[float | None, "how long the motion takes [s]"]
    energy_j: Annotated[float | None, "energy dissipated [J]"]
    position_error_over_L: Annotated[float | None, "from the goal to the re-integrated end, the base's position [L]"]
    base_error_rad: Annotated[float | None, "the same, the base's orientation [rad]"]
    limb1_error_rad: Annotated[float | None, "the same, limb 1's orientation in the base [rad]"]
    limb2_error_rad: Annotated[float | None, "the same, limb 2's orientation in the base [rad]"]
    clearance_m: Annotated[float | None, "least distance of the limbs' surfaces over the whole path [m]"]
    largest_bend_rad: Annotated[float | None, "largest bend in phase 2 [rad]"]
    primitives: Annotated[int | None, "primitives or moves"]
    cycles: Annotated[int | None, "cycles of the strokes of phase 2"]
    rows: Annotated[int | None, "rows of the trajectory"]


class Result(Numbers):
    """What came of a scenario, before it is judged."""

    verdict: Annotated[RowVerdict, "how it ended"]
    error: Annotated[str | None, "why it has no plan, or what blocks its way round obstacles"]
    wall_time_s: Annotated[float, "how long it took [s]"]


class _Judged(TypedDict):
    """What a row says before its numbers."""

    name: Annotated[str, "the scenario's name, which its files bear"]
    file: Annotated[str, "the file that it stands in"]
    sweep: Annotated[dict[str, Any], "what each swept key is"]
    verdict: Annotated[RowVerdict, "how it ended"]
    passed: Annotated[bool, "whether it is what it must be"]
    reasons: Annotated[list[str], "why not, a sentence each"]
    error: Annotated[str | None, "why it has no plan, or what blocks its way round obstacles"]


class Row(_Judged, Numbers):
    """One scenario of a batch: what it came to, and its numbers, null where there is no plan."""

    wall_time_s: Annotated[float, "how long it took [s]; the one value that differs from run to run"]


class Summary(TypedDict):
    """The file `summary.json` of `purcell batch`."""

    schema: Annotated[Literal["purcell/batch-summary/1"], "the form of the document"]
    verdict: Annotated[Literal["passed", "failed"], "whether all scenarios are what they must be"]
    scenarios: Annotated[int, "how many there are"]
    failed: Annotated[int, "how many are not what they must be"]
    crashed: Annotated[int, "how many of those crashed"]
    rows: Annotated[list[Row], "the scenarios, in the batch's order"]


NUMBERS = tuple(Numbers.__annotations__)
"""What is measured of a plan, in the order of the summary's columns."""

COLUMNS = tuple(Row.__annotations__)
"""The columns of a summary."""
