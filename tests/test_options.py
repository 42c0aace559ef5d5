"""Plan options are declared once: library, command line, batch and plan documents take the same values."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path
from typing import Any

import pytest
from helpers import Run, mostly_slow, runner
from hypothesis import given
from hypothesis import strategies as st

from purcell_cli import Configuration, Controls, Effort, Objective, PlanOptions, Swimmer, Workspace, load_plan, plan
from purcell_cli.cli.app import built
from purcell_cli.environment.scene import Scene
from purcell_cli.environment.solids import Capsule, Sphere
from purcell_cli.errors import InputError, ParameterError, UnknownNameError
from purcell_cli.files.option_elements import OPTION_FIELDS
from purcell_cli.files.plan_file import PLAN, SCHEMA, PlanDocument
from purcell_cli.files.scenario_file import EXPECT
from purcell_cli.files.yaml_source import read_document
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.options import OPTIONS
from purcell_cli.motion.plan import Plan
from purcell_cli.motion.verdict import Verdict

HERE = Configuration()
NAMED: dict[str, Any] = {
    name: option for name, option in OPTIONS.items() if option.kind in {Effort, Controls, Objective}
}
FLAGGED: dict[str, Any] = {name: option for name, option in OPTIONS.items() if option.flag is not None}
PLANNING = ("plan", "batch")

STILL = "name: still\nstart: {}\ngoal: {}\n"
"""A scenario whose goal is its start: planned at once, with any options."""


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Run:
    monkeypatch.chdir(tmp_path)
    Path("still.yaml").write_text(STILL)
    return runner(capsys)


def shown(command: str) -> dict[str, Any]:
    """Return the parameters of a command as typer has them, by flag."""
    parameters = built().commands[command].params
    return {parameter.opts[0]: parameter for parameter in parameters}


# --- The type --------------------------------------------------------------------------------------------------------


def test_the_strings_are_those_that_users_type() -> None:
    assert [str(e) for e in Effort] == ["quick", "standard", "thorough"]
    assert [str(c) for c in Controls] == ["primitive", "simultaneous"]
    assert [str(o) for o in Objective] == ["travel", "time", "energy", "switches", "sensitivity"]
    assert set(NAMED) == {"effort", "controls", "objective"}


def test_the_defaults() -> None:
    asked = PlanOptions()
    assert (asked.effort, asked.controls, asked.objective) == (Effort.STANDARD, Controls.PRIMITIVE, Objective.TRAVEL)
    assert (asked.clearance_m, asked.workspace, asked.dt_s) == (0.0, None, 0.05)


def test_what_is_least_where_nothing_is_said_depends_on_the_controls() -> None:
    """Also in a document that does not say it; one that says travel, the foil, keeps it."""
    both = PlanOptions(controls=Controls.SIMULTANEOUS)
    assert both.objective is Objective.TIME
    assert options_in(document(controls="simultaneous")) == both
    told = PlanOptions(controls=Controls.SIMULTANEOUS, objective=Objective.TRAVEL)
    assert told.objective is Objective.TRAVEL
    assert options_in(document(controls="simultaneous", minimize="travel")) == told
    nowhere = Plan(Swimmer(), HERE, HERE, ())
    assert "minimize" not in json.loads(PlanDocument(nowhere, both).as_text())
    assert json.loads(PlanDocument(nowhere, told).as_text())["minimize"] == "travel"


def test_options_are_named_and_stay_as_they_are() -> None:
    with pytest.raises(TypeError, match="positional"):
        PlanOptions(0.05)
    with pytest.raises(TypeError, match="positional"):
        plan(HERE, HERE, Swimmer())
    asked = PlanOptions()
    with pytest.raises(dataclasses.FrozenInstanceError):
        asked.dt_s = 1.0
    assert {asked: 1}[PlanOptions()] == 1


@pytest.mark.parametrize("name", list(NAMED))
def test_a_name_is_as_good_as_the_member_and_becomes_it(name: str) -> None:
    for one in NAMED[name].kind:
        asked = PlanOptions(**{name: str(one)})
        assert getattr(asked, name) is one
        assert asked == PlanOptions(**{name: one})
    assert len({PlanOptions(**{name: one}) for one in NAMED[name].kind}) == len(NAMED[name].kind)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"effort": "quik"}, r"effort: one of quick, standard, thorough \(nearest: quick\) is wanted, found 'quik'"),
        ({"effort": "lazy"}, r"effort: one of quick, standard, thorough is wanted, found 'lazy'"),
        ({"effort": "QUICK"}, r"effort: one of .* is wanted, found 'QUICK'"),
        ({"effort": None}, r"effort: one of .* is wanted, found None"),
        ({"controls": "primitiv"}, r"controls: one of primitive, simultaneous \(nearest: primitive\) is wanted"),
        ({"objective": "haste"}, r"objective: one of travel, .*, sensitivity is wanted, found 'haste'"),
    ],
)
def test_a_name_that_is_none_is_refused(given: dict[str, Any], message: str) -> None:
    with pytest.raises(UnknownNameError, match=f"^{message}"):
        PlanOptions(**given)


@pytest.mark.parametrize("value", [-1e-9, -1.0, math.nan, math.inf, -math.inf, "0.1", None, True])
def test_a_clearance_that_is_none_is_refused(value: Any) -> None:
    for make in (lambda: PlanOptions(clearance_m=value), lambda: Limits(value)):
        with pytest.raises(ParameterError) as caught:
            make()
        assert str(caught.value) == f"clearance: a finite length of 0 m or more is wanted, found {value!r}"
    assert PlanOptions(clearance_m=0.0).clearance_m == 0.0


@pytest.mark.parametrize("value", [0.0, -0.05, math.nan, math.inf, "0.1", None, True])
def test_a_time_between_rows_that_is_none_is_refused(value: Any) -> None:
    with pytest.raises(ParameterError) as caught:
        PlanOptions(dt_s=value)
    assert str(caught.value) == f"dt: a time above 0 s, and finite, is wanted, found {value!r}"
    assert PlanOptions(dt_s=5e-324).dt_s == 5e-324


def test_limits_are_those_of_the_options() -> None:
    box = Workspace((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0))
    assert Limits.of(PlanOptions(clearance_m=0.1, workspace=box)) == Limits(0.1, box)
    assert Limits.of(PlanOptions()) == Limits()


def test_a_solution_knows_what_was_asked() -> None:
    asked = PlanOptions(dt_s=0.25, clearance_m=0.1, effort=Effort.QUICK)
    found = plan(HERE, HERE, options=asked)
    assert found.options == asked
    assert found.limits.limits == Limits(0.1)
    assert found.verdict is Verdict.REACHED


# --- The command line ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("command", mostly_slow(PLANNING, 1))
@pytest.mark.parametrize("name", list(FLAGGED))
def test_a_command_shows_an_option_as_it_is_declared(command: str, name: str) -> None:
    option, found = FLAGGED[name], shown(command)[FLAGGED[name].flag]
    listed = f" One of {', '.join(option.kind)}." if found.metavar == "WHAT" else ""  # too many for a column
    assert found.help.lower() == f"{option.meaning}.{listed}".lower()
    assert found.help[0].isupper()
    assert bool(listed) == (name == "objective")
    assert found.default == option.default
    assert found.metavar == ("WHAT" if listed else option.metavar or "|".join(option.kind))


@pytest.mark.parametrize("command", mostly_slow(PLANNING, 1))
@pytest.mark.parametrize("name", list(NAMED))
def test_a_command_takes_the_members_and_nothing_else(command: str, name: str, run: Run) -> None:
    option = NAMED[name]
    for one in option.kind:
        code, out, err = run(command, "still.yaml", option.flag, str(one), "--json")
        assert code == 0, err
        assert json.loads(out)["verdict"] == ("reached" if command == "plan" else "passed")
    for other in (option.kind.__name__, "", str(option.default).upper(), f"{option.default} "):
        before = set(Path().iterdir())
        code, out, err = run(command, "still.yaml", option.flag, other)
        names = ", ".join(option.kind)
        assert (code, out) == (2, "")
        assert err.startswith(f"purcell {command}: {option.flag}: one of {names}")
        assert err.endswith(f" is wanted, found {other!r}\n")
        assert set(Path().iterdir()) == before


@pytest.mark.slow
def test_a_batch_plans_with_its_options(run: Run) -> None:
    names = ("--effort", "quick", "--minimize", "energy", "--controls", "simultaneous")
    given = (*names, "--clearance", "0.01", "--dt", "0.5")
    assert run("batch", "still.yaml", "--out", "found", *given)[0] == 0
    asked = PlanOptions(effort="quick", objective="energy", clearance_m=0.01, dt_s=0.5, controls="simultaneous")
    assert load_plan("found/still.json").options == asked
    assert run("plan", "still.yaml", "--plan-out", "plan.json", *given)[0] == 0
    assert load_plan("plan.json").options == asked


# --- Plan documents --------------------------------------------------------------------------------------------------


def document(**changes: Any) -> str:
    """Return a plan document that goes nowhere, as text, with values for some keys."""
    least = {"schema": SCHEMA, "purcell": "0", "swimmer": {}, "start": {}, "goal": {}, "blocks": []}
    return json.dumps({**least, **changes})


def options_in(text: str) -> PlanOptions:
    return read_document(PLAN, text.encode(), "plan.json", Path()).options


@pytest.mark.parametrize("name", list(NAMED))
def test_a_plan_document_takes_the_members_and_nothing_else(name: str) -> None:
    option = NAMED[name]
    names = [str(one) for one in option.kind]
    assert OPTION_FIELDS[option.key].json_schema()["enum"] == names
    for one in names:
        assert options_in(document(**{option.key: one})) == PlanOptions(**{name: one})
    for other in (names[0][:-1], names[0].upper(), "", 1, None):
        with pytest.raises(InputError, match=rf"^plan.json:1: {option.key}: wanted one of {', '.join(names)}"):
            options_in(document(**{option.key: other}))


def test_a_plan_document_has_a_key_for_every_option_and_leaves_defaults_out() -> None:
    assert list(OPTION_FIELDS) == [option.key for option in OPTIONS.values() if option.saved]
    assert [name for name, option in OPTIONS.items() if not option.saved] == ["max_memory_gb"]
    nowhere = Plan(Swimmer(), HERE, HERE, ())
    plain = json.loads(PlanDocument(nowhere).as_text())
    assert set(plain) & set(OPTION_FIELDS) == {"dt_s", "clearance_m"}
    told = json.loads(PlanDocument(nowhere, PlanOptions(effort=Effort.QUICK)).as_text())
    assert told == {**plain, "effort": "quick"}
    assert options_in(document()) == PlanOptions()


sides = st.none() | st.floats(-1e6, -1e-6)
corners = st.tuples(st.floats(-1e6, -1e-6), sides, sides)
boxes = st.builds(lambda low, high: Workspace(low, tuple(v and -v for v in high)), corners, corners)
points = st.tuples(*[st.floats(-1e3, 1e3)] * 3)
radii = st.floats(1e-3, 1e3)
obstacles = st.builds(Sphere, points, radii) | st.builds(Capsule, points, points, radii)
scenes = st.builds(Scene, st.lists(obstacles, min_size=1, max_size=3).map(tuple))
every_option: dict[str, Any] = {
    "dt_s": st.floats(1e-6, 1e6),
    "effort": st.sampled_from(Effort),
    "controls": st.sampled_from(Controls),
    "objective": st.sampled_from(Objective),
    "clearance_m": st.floats(0.0, 1e6),
    "workspace": st.none() | boxes,
    "obstacles": st.none() | scenes,
    "seed": st.integers(0, 2**32 - 1),
}


@given(st.builds(PlanOptions, **every_option))
@pytest.mark.slow
def test_options_read_back_from_a_plan_document(asked: PlanOptions) -> None:
    assert set(every_option) == {name for name, option in OPTIONS.items() if option.saved}
    made = PlanDocument(Plan(Swimmer(), HERE, HERE, ()), asked)
    found = read_document(PLAN, made.as_text().encode(), "plan.json", Path())
    assert found.options == asked
    assert found.as_text() == made.as_text()


# --- Verdicts --------------------------------------------------------------------------------------------------------


def test_what_a_scenario_may_expect_is_how_a_plan_can_end() -> None:
    found: dict[str, Any] = EXPECT.json_schema()["properties"]
    assert found["verdict"] == {
        "enum": [str(v) for v in Verdict],
        "description": "how it must end",
        "default": "reached",
    }
    assert [str(v) for v in Verdict] == ["reached", "not reached", "not found within limits", "error"]
