"""Scenarios as YAML."""

from __future__ import annotations

import dataclasses
import warnings
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from purcell_cli.environment.mesh import Mesh
from purcell_cli.environment.scene import Scene
from purcell_cli.errors import PurcellWarning
from purcell_cli.files.configuration_file import CONFIGURATION, GOAL, WORKSPACE_FIELD, Goal
from purcell_cli.files.containers import Either, Field, Record
from purcell_cli.files.documents import Document, Made
from purcell_cli.files.elements import Element, ValueT
from purcell_cli.files.gait_file import GAIT
from purcell_cli.files.mission_elements import MISSION_FIELDS
from purcell_cli.files.obstacle_elements import OBSTACLES
from purcell_cli.files.option_elements import choice
from purcell_cli.files.paths import UnreadableError
from purcell_cli.files.place import Place, shortened
from purcell_cli.files.scalars import NAME, Number, Text
from purcell_cli.files.sweep import SWEEP
from purcell_cli.files.swimmer_file import SWIMMER
from purcell_cli.files.yaml_source import file_bytes, load, read_document
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.mission import Follow, Mission, Order, Waypoint
from purcell_cli.motion.verdict import Verdict
from purcell_cli.motion.workspace import Workspace

_FAR_L = 400.0
"""A goal farther away than this many L is remarked on.

To swim so far takes the paper's swimmer more than two hours; its 500 L are 50 m, which may be 50 mm mistaken."""


def _inline_or_path(document: Document[ValueT]) -> Element[ValueT]:
    """Return the element for a document that stands inline or in a file of its own."""

    def read(name: str, place: Place) -> ValueT:
        path = place.folder / name
        try:
            data = file_bytes(path)
        except UnreadableError as error:
            raise place.error("the path of a readable file", f"{error} at '{shortened(str(path))}'") from error
        return read_document(document, data, str(path), path.parent)

    return Either(Made(Text(meaning="the path of a file"), read), document.element)


@frozen_dataclass
class Expect:
    """What a scenario must come to; None asks for nothing beyond the planner's own.

    Attributes:
        verdict: What it must end with.
        position_tolerance: How far from the goal the base may end, in units of L.
        angle_tolerance_rad: How far from the goal an orientation may end [rad].
        max_joint_travel_rad: How far the joints may turn in sum [rad].
        max_duration_s: How long the motion may take [s].
        min_clearance_m: How far apart the limbs must stay [m].
        error: A part of the message that it must be refused with; the verdict wanted is then "error".
    """

    verdict: Verdict = Verdict.REACHED
    position_tolerance: float | None = None
    angle_tolerance_rad: float | None = None
    max_joint_travel_rad: float | None = None
    max_duration_s: float | None = None
    min_clearance_m: float | None = None
    error: str | None = None


@frozen_dataclass
class Scenario:
    """A reconfiguration to plan and what is expected of it.

    Attributes:
        name: Its name.
        start: Where it starts.
        goal: Where it is to end.
        swimmer: Who swims.
        expect: What it must come to.
        workspace: The box to stay in, if there is one.
        obstacles: What no link may touch, if there is anything.
        via: The waypoints to pass.
        order: In which order.
        follow: The curve to follow, if there is one.
    """

    name: str
    start: Configuration
    goal: Configuration
    swimmer: Swimmer = dataclasses.field(default_factory=Swimmer)
    expect: Expect = dataclasses.field(default_factory=Expect)
    workspace: Workspace | None = None
    obstacles: Scene | None = None
    via: tuple[Waypoint, ...] = ()
    order: Order = Order.GIVEN
    follow: Follow | None = None

    @property
    def mission(self) -> Mission:
        """What is to be done."""
        return Mission(self.start, self.goal, self.via, self.order, self.follow)


def _expect(value: dict[str, Any], place: Place) -> Expect:
    if "error" in value:
        if value.get("verdict", Verdict.ERROR) != Verdict.ERROR:
            raise place.at("verdict").error("error, which the key error asks for")
        value = {**value, "verdict": Verdict.ERROR}
    return Expect(**value)


EXPECT: Element[Expect] = Made(
    Record(
        {
            "verdict": Field(choice(Verdict), "how it must end", default=Verdict.REACHED),
            "position_tolerance": Field(Number(above=0.0), "how far from the goal the base may end, in units of L"),
            "angle_tolerance_rad": Field(Number(above=0.0), "how far from the goal an orientation may end [rad]"),
            "max_joint_travel_rad": Field(Number(at_least=0.0), "how far the joints may turn in sum [rad]"),
            "max_duration_s": Field(Number(at_least=0.0), "how long the motion may take [s]"),
            "min_clearance_m": Field(Number(at_least=0.0), "how far apart the limbs must stay [m]"),
            "error": Field(Text(), "a part of the message that it must be refused with"),
        }
    ),
    _expect,
)
"""The element for what a scenario must come to."""


def warn_if_far(scenario: Scenario, label: str = "") -> None:
    """Warn of a goal or a waypoint so far away, or a mesh so large, that it might be meant in another unit.

    Args:
        scenario: The scenario.
        label: What stands before the warning.
    """
    places = {f"via[{k}]": one.position_m for k, one in enumerate(scenario.via) if one.position_m is not None}
    places["the goal"] = scenario.goal.pose[:3, 3]
    far_m = {name: float(np.linalg.norm(at - scenario.start.pose[:3, 3])) for name, at in places.items()}
    name = max(far_m, key=lambda one: far_m[one])
    lengths = far_m[name] / scenario.swimmer.length_m
    if lengths > _FAR_L:
        far = f"{lengths:.6g} L ({far_m[name]:.6g} m) from the start"
        text = f"{label}{name} is {far}, which may be hours of swimming; position_m is in metres"
        warnings.warn(text, PurcellWarning, stacklevel=2)
    for k, one in enumerate(() if scenario.obstacles is None else scenario.obstacles.obstacles):
        wide_m = float(np.max(np.diff(one.bounds(), axis=0))) if isinstance(one, Mesh) else 0.0
        if wide_m > _FAR_L * scenario.swimmer.length_m:
            wide = f"{wide_m / scenario.swimmer.length_m:.6g} L ({wide_m:.6g} m) wide"
            text = f"{label}obstacles[{k}].mesh is {wide}; files in millimetres want the key scale: 0.001"
            warnings.warn(text, PurcellWarning, stacklevel=2)


def _scenario(value: dict[str, Any], place: Place) -> Scenario:
    if "sweep" in value:
        raise place.at("sweep").error("a scenario without a sweep here (purcell batch expands it)", "one")
    follow: Follow | None = value.get("follow")
    goal: Goal | None = value.pop("goal", None)
    if goal is None:
        assert follow is not None  # noqa: S101  # one of the two is there
        goal = Goal(follow.goal(value["start"]))
    workspace = value.pop("workspace_m", None)
    if workspace is not None and goal.workspace is not None:
        raise place.at("workspace_m").error("one workspace, the scenario's or its goal's", "both")
    value["via"] = tuple(value.get("via", ()))
    scenario = Scenario(goal=goal.configuration, workspace=workspace or goal.workspace, **value)
    _ = scenario.mission  # refused here, where the line is known
    return scenario


_SCENARIO = Document(
    "A scenario",
    Made(
        Record(
            {
                "name": Field(NAME, "its name", required=True),
                "start": Field(_inline_or_path(CONFIGURATION), "where it starts", required=True),
                "goal": Field(_inline_or_path(GOAL), "where it is to end; with follow, left out, the curve's end"),
                "swimmer": Field(_inline_or_path(SWIMMER), "who swims; left out, the paper's swimmer"),
                "expect": Field(EXPECT, "what it must come to"),
                **WORKSPACE_FIELD,
                "obstacles": Field(OBSTACLES, "what no link may touch; left out, there is nothing"),
                **MISSION_FIELDS,
                "sweep": Field(SWEEP, "values for keys; purcell batch makes a scenario of each combination"),
            },
            one_at_least=("goal", "follow"),
        ),
        _scenario,
    ),
)

SCHEMAS: Mapping[str, Element[Any]] = MappingProxyType(
    {"start": CONFIGURATION, "goal": GOAL, "swimmer": SWIMMER, "scenario": _SCENARIO, "gait": GAIT}
)
"""Every kind of document by name."""


def load_scenario(path: Path | str) -> Scenario:
    """Return the scenario of a file; paths in it start from its folder. The path - is standard input.

    Raises:
        InputError: The file, or one that it names, does not say what is wanted.
    """
    return load(path, _SCENARIO)
