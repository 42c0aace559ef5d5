"""The library's public names: one table with an example each that runs, types for users, short representations."""

from __future__ import annotations

import functools
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from pages import PAGES

import purcell_cli
from purcell_cli import (
    Box,
    Capsule,
    Configuration,
    Gait,
    HalfSpace,
    Joint,
    Mission,
    PlanOptions,
    PrimitiveSequence,
    PurcellError,
    Scene,
    Sphere,
    Swimmer,
    Tube,
    connection,
    curvature,
    design,
    fit,
    flow,
    flow_and_jacobian,
    flow_of_rates,
    load_scenario,
    plan,
    plan_mission,
    read_csv,
    realise,
    shape_from_angles,
    stored_gaits,
    stored_scenarios,
    write_csv,
    write_plan,
    write_swimmer,
)
from purcell_cli.errors import ParameterError, UnknownNameError
from purcell_cli.geometry.rotations import from_euler
from purcell_cli.lie_brackets.controllability import controllability

BALL = Sphere((0.0, 1.0, 0.0), 0.2)
PAGE = PAGES["docs/reference/library.md"].partition("## All names\n")[2].partition("\n## ")[0]
ROWS = re.findall(r"^\| \[`(\w+)`\]\(#[\w.]+\) \| [^|]+ \| `(.+?)` \| `(.+?)` \|$", PAGE, re.MULTILINE)
SQUARE = PrimitiveSequence.of([("limb1 yaw", 0.5), ("limb2 yaw", 0.5), ("limb1 yaw", -0.5), ("limb2 yaw", -0.5)])


def test_the_table_has_every_public_name_once_and_every_name_can_be_loaded() -> None:
    assert sorted(name for name, _, _ in ROWS) == sorted(purcell_cli.__all__)
    assert all(re.search(rf"\b{name}\b", example) or name in {"Effort", "PrimitiveSequence", "Gait"}
               for name, example, _ in ROWS if name not in {"Solution", "Stroke", "MoveSequence"})  # fmt: skip
    for name in purcell_cli.__all__:
        assert not isinstance(getattr(purcell_cli, name), type(sys)), f"{name} is a module"


def test_every_link_of_the_table_leads_to_a_section_of_the_page() -> None:
    page = PAGES["docs/reference/library.md"]
    linked = set(re.findall(r"\]\(#(purcell_cli\.\w+)\)", page))
    assert len(linked) > 60
    sections = re.findall(r"^::: (purcell_cli\.\w+)$", page, re.MULTILINE)
    assert linked <= set(sections)
    assert len(sections) == len(set(sections))


@pytest.mark.slow
def test_every_example_gives_what_is_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    exec(re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)[1], names)
    assert {name: repr(eval(example, names)) for name, example, _ in ROWS} == {name: gives for name, _, gives in ROWS}


_PROGRAM = """
from purcell_cli import Configuration, Swimmer, connection, flow, plan, stored_gaits
reveal_type(plan(Configuration(), Configuration()).joint_travel_rad)
reveal_type(stored_gaits()["roll"])
reveal_type(Swimmer().slenderness)
connection(Swimmer())
"""


@pytest.mark.slow
def test_a_users_mypy_sees_the_types(tmp_path: Path) -> None:
    pytest.importorskip("mypy")
    assert (Path(purcell_cli.__file__).parent / "py.typed").is_file()
    (tmp_path / "own.py").write_text(_PROGRAM)
    command = [sys.executable, "-m", "mypy", "--strict", "--no-incremental", "own.py"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, encoding="utf-8", check=False)
    found = re.findall(r'Revealed type is "(?:builtins\.)?([\w.]+)"', done.stdout)
    assert found == ["float", "purcell_cli.gaits.gait.Gait", "float"], done.stdout
    assert 'Missing positional argument "shape" in call to "connection"' in done.stdout
    assert "Any" not in done.stdout


@functools.cache
def arrays() -> dict[str, np.ndarray]:
    turned = from_euler(np.radians([10.0, 20.0, 30.0]))
    return {
        "zeros": np.zeros((2, 3, 3)),
        "a scaled rotation": 1.01 * np.stack([turned, turned]),
        "a reflection": np.stack([turned, turned * [1.0, 1.0, -1.0]]),
        "not numbers": np.full((2, 3, 3), np.nan),
        "one limb": turned,
    }


@pytest.mark.parametrize("name", arrays())
def test_arrays_that_are_no_rotations_are_errors_everywhere(name: str) -> None:
    wrong, body = arrays()[name], Swimmer()
    for action in (
        lambda: connection(body, wrong),
        lambda: curvature(body, wrong),
        lambda: controllability(body, wrong),
        lambda: flow(body, SQUARE, wrong),
        lambda: flow_and_jacobian(body, SQUARE, wrong),
        lambda: flow_of_rates(body, np.ones((1, 6)), np.ones(1), wrong),
    ):
        with pytest.raises(ParameterError, match=r"limb orientations"):
            action()


def test_shapes_from_angles_are_the_configurations() -> None:
    wanted = Configuration.from_angles(limb1_euler_deg=(10, 20, 30), limb2_euler_deg=(-40, 5, 6)).shape
    assert np.array_equal(shape_from_angles((10, 20, 30), (-40, 5, 6)), wanted)
    assert shape_from_angles(np.zeros((7, 3)), np.ones((7, 3))).shape == (7, 2, 3, 3)


@pytest.mark.parametrize("given", [[0.0, 0.0], 1.0, ["left", 0, 0], [0.0, np.nan, 0.0], [[0.0] * 3] * 2])
@pytest.mark.parametrize("name", ["position_m", "base_euler_deg", "limb1_euler_deg", "limb2_euler_deg"])
def test_what_is_not_three_numbers_is_told_by_its_name(name: str, given: object) -> None:
    with pytest.raises(ParameterError, match=rf"{name}: three finite numbers are wanted, found"):
        Configuration.from_angles(**{name: given})
    assert Configuration.from_angles(**{name: np.zeros(3)}).pose.shape == (4, 4)


@pytest.mark.parametrize("joints", [("hinge", "hinge"), (Joint(),), (Joint("universal"), "ball"), None])
def test_joints_that_are_none_are_refused(joints: tuple[object, ...] | None) -> None:
    with pytest.raises(ParameterError, match="joints: two of type Joint"):
        Swimmer(joints=joints)
    assert Swimmer(joints=(Joint("universal"), Joint("hinge", "yaw"))).joints[1].name == "yaw hinge"


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda here: plan(here, None), "goal: a Configuration is wanted, found None"),
        (lambda here: plan({}, here), "start: a Configuration is wanted, found {}"),
        (lambda here: plan(here, here, swimmer="planar"), "swimmer: a Swimmer is wanted, found 'planar'"),
        (lambda here: plan(here, here, options={"dt_s": 0.1}), "options: a PlanOptions is wanted, found {'dt_s': 0.1}"),
        (lambda here: plan_mission(here), "mission: a Mission is wanted, found <Configuration"),
        (lambda here: plan_mission(Mission(here, here), options={}), "options: a PlanOptions is wanted, found {}"),
        (lambda here: plan_mission(Mission(here, here), swimmer="beads"), "swimmer: a Swimmer is wanted"),
        (lambda here: Mission(here, None), "goal: a Configuration is wanted, found None"),
        (lambda here: Mission(here, here, [here]), r"via\[0\]: a Waypoint is wanted, found <Configuration"),
        (lambda _: PlanOptions(obstacles=[BALL]), r"obstacles: a Scene is wanted, found \[Sphere\("),
        (lambda _: PlanOptions(workspace=(0, 1)), r"workspace: a Workspace is wanted, found \(0, 1\)"),
        (lambda here: plan(here, here, gaits="mine"), "gaits: a Mapping is wanted, found 'mine'"),
        (lambda here: Mission(here, here, order="any"), "order: one of given, free is wanted, found 'any'"),
        (lambda here: Mission(here, here, follow=BALL), "follow: a Follow is wanted, found Sphere"),
        (lambda _: realise("x-motion", Swimmer()), "gait: a Gait is wanted, found 'x-motion'"),
        (lambda _: design(Swimmer(), "x"), "task: a DesignTask is wanted, found 'x'"),
        (lambda _: controllability("planar"), "swimmer: a Swimmer is wanted, found 'planar'"),
        (lambda _: fit(["swim.csv"]), r"measured\[0\]: a MeasuredTrajectory is wanted, found 'swim.csv'"),
        (lambda here: write_csv(here, "a.csv"), "trajectory: a Trajectory is wanted, found <Configuration"),
        (lambda here: write_plan(here, "a.json"), "document: a PlanDocument is wanted, found <Configuration"),
        (lambda here: write_swimmer(here, "a.yaml"), "swimmer: a Swimmer is wanted, found <Configuration"),
        (lambda _: Scene(BALL), "obstacles: an Iterable is wanted, found Sphere"),
        (lambda _: Sphere((0, 0, 0), "wide"), "radius_m: a finite number above 0 is wanted, found 'wide'"),
        (lambda _: Tube([(0, 0, 0), (1, 0, 0)], 0.3), "radii_m: an Iterable is wanted, found 0.3"),
        (lambda _: Scene([BALL, "box"]), r"obstacles\[1\]: an Obstacle is wanted, found 'box'"),
    ],
)
def test_arguments_of_another_type_are_told_with_what_is_wanted(call: Callable[[object], object], message: str) -> None:
    with pytest.raises(PurcellError, match=f"^{message}"):
        call(Configuration())


def test_obstacles_from_python_are_those_of_files(tmp_path: Path) -> None:
    file = tmp_path / "past.yaml"
    file.write_text("""name: past
start: {}
goal: {base: {position_m: [1, 0, 0]}}
obstacles:
  - sphere: {centre_m: [0, 1, 0], radius_m: 0.2}
  - capsule: {from_m: [0, 2, 0], to_m: [1, 2, 0], radius_m: 0.1}
  - box: {centre_m: [0, 0, 3], size_m: [1, 2, 1]}
  - half_space: {point_m: [0, 0, -5], normal: [0, 0, 2]}
""")
    rod, box = Capsule((0, 2, 0), (1, 2, 0), 0.1), Box((0, 0, 3), (1, 2, 1))
    assert load_scenario(file).obstacles == Scene([BALL, rod, box, HalfSpace((0, 0, -5), (0, 0, 1))])
    vessel = load_scenario(stored_scenarios()["vessel"]).obstacles
    assert vessel is not None
    assert Scene([Tube(one.points_m, one.radii_m) for one in vessel.tubes]) == vessel


def test_other_names_of_gaits_work_and_unknown_ones_are_told_with_the_nearest() -> None:
    gaits = stored_gaits()
    assert gaits["roll"] is gaits["x-rotation"]
    assert "roll" not in set(gaits), "each gait stands there once"
    with pytest.raises(UnknownNameError, match="did you mean 'x-rotation'"):
        gaits["x-rotaton"]
    assert issubclass(UnknownNameError, (PurcellError, LookupError))


@pytest.mark.slow
def test_what_is_shown_of_a_value_is_one_line(tmp_path: Path) -> None:
    solution = plan(Configuration(), Configuration.from_angles(base_euler_deg=(0, 0, 5)))
    purcell_cli.write_csv(solution.trajectory, tmp_path / "swim.csv")
    gaits = stored_gaits()
    values = [
        solution,
        solution.plan,
        solution.trajectory,
        solution.plan.start,
        read_csv(tmp_path / "swim.csv"),
        SQUARE,
    ]
    values += [gaits["x-motion"], gaits["x-loop"], purcell_cli.realise(gaits["x-loop"], Swimmer()), Swimmer()]
    values += [controllability(Swimmer()), solution.certificate]
    for value in values:
        assert "\n" not in repr(value)
        assert len(repr(value)) < 300, repr(value)
    assert isinstance(gaits["x-motion"], Gait)
