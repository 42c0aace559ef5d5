"""The command line keeps its promises: exit codes, one JSON document, nothing written on bad input."""

from __future__ import annotations

import csv
import dataclasses
import errno
import functools
import io
import json
import math
import re
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import pytest
from helpers import Run, mostly_slow, runner

import purcell_cli.missions
from purcell_cli import Configuration, __version__, plan, write_csv
from purcell_cli.solution import Solution

DONE, NOT_REACHED, MISUSE = 0, 1, 2
COMMAND = [sys.executable, "-W", "error", "-c", "from purcell_cli.cli.app import main; main()"]
WRITTEN_BEFORE = "what was here before\n"

START = """\
base: {position_m: [0.2, -0.1, 0.3], orientation: {euler_deg: [40, -20, 75]}}
limb1: {euler_deg: [30, 10, 0]}
"""
GOAL = """\
base: {position_m: [0.2, -0.1, 0.3], orientation: {euler_deg: [40, -20, 120]}}
limb2: {euler_deg: [0, 15, 0]}
"""
ERROR_KEYS = {"schema": None, "verdict": None, "error": None}


@functools.cache
def solution() -> Solution:
    """Return the plan from START to GOAL, the controls of all good files."""
    start = Configuration.from_angles((0.2, -0.1, 0.3), (40, -20, 75), (30, 10, 0))
    return plan(start, Configuration.from_angles((0.2, -0.1, 0.3), (40, -20, 120), (0, 0, 0), (0, 15, 0)))


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working folder, with a start, a goal and a scenario file in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "whole.yaml").write_text("name: whole\nstart: {}\ngoal: {}\n")
    (tmp_path / "start.yaml").write_text(START)
    (tmp_path / "goal.yaml").write_text(GOAL)
    return tmp_path


@pytest.fixture
def good(folder: Path) -> Path:
    """Return a good trajectory file in the working folder."""
    path = folder / "good.csv"
    write_csv(solution().trajectory, path)
    return path


@pytest.fixture
def run(folder: Path, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that runs a command in the working folder: exit code, stdout, stderr."""

    return runner(capsys)


def contents(folder: Path) -> dict[str, bytes | None]:
    """Return every file below a folder with what it holds."""
    return {str(p.relative_to(folder)): p.read_bytes() if p.is_file() else None for p in sorted(folder.rglob("*"))}


def document_of(text: str) -> Any:
    """Return the one JSON document of a text of one line; NaN and infinity have no place in it."""

    def refuse(name: str) -> NoReturn:
        raise AssertionError(f"{name} in a JSON document")

    assert text.endswith("\n")
    assert text.count("\n") == 1
    return json.loads(text, parse_constant=refuse)


def keys(value: Any) -> Any:
    """Return the keys of a document, nested; a list stands for the keys of all its items, which must agree."""
    if isinstance(value, dict):
        return {key: keys(inner) for key, inner in value.items()}
    if isinstance(value, list) and value and isinstance(value[0], dict):
        assert all(keys(item) == keys(value[0]) for item in value)
        return [keys(value[0])]
    return None


def plain(text: str) -> str:
    """Return a message on one line, as a terminal of any width would show it."""
    return " ".join(re.sub(r"[│╭╮╰╯─]", " ", text).split())


# --- What a good command prints and writes -------------------------------------------------------------------------

SWIMMER_KEYS = dict.fromkeys(
    (
        "base_half_length_m",
        "limb_half_length_m",
        "slenderness",
        "viscosity_pa_s",
        "drag_ratio",
        "max_bend_rad",
        "joint_rate_rad_s",
        "L_m",
    )
)
DISPLACEMENT_KEYS = dict.fromkeys(("position_m", "psi_rad", "theta_rad", "phi_rad"))
DEVIATION_KEYS = dict.fromkeys(("position_m", "position_over_L", "base_rad", "limb1_rad", "limb2_rad"))
TOLERANCE_KEYS = dict.fromkeys(("position_m", "angle_rad"))
CERTIFICATE_KEYS = {**dict.fromkeys(("method", "segments", "integrated")), "bound": TOLERANCE_KEYS}
COST_KEYS = dict.fromkeys(("primitives", "joint_travel_rad", "duration_s", "energy_j"))
STROKE_KEYS = {"gait": None, "amplitude_rad": None, "cycles": None, **COST_KEYS, "displacement": DISPLACEMENT_KEYS}
PHASE_KEYS = {
    "phase": None,
    "name": None,
    **COST_KEYS,
    "largest_bend_rad": None,
    "displacement": DISPLACEMENT_KEYS,
    "strokes": [STROKE_KEYS],
}
VIOLATION_KEYS = dict.fromkeys(("limit", "excess", "unit", "time_s", "phase", "what"))
LIMIT_KEYS = dict.fromkeys(
    ("clearance_m", "max_bend_rad", "workspace_m", "workspace_violation_m", "obstacle", "kept", "violations")
)
PLAN_KEYS = {
    "schema": None,
    "verdict": None,
    "swimmer": SWIMMER_KEYS,
    "controls": None,
    **COST_KEYS,
    "cycles": None,
    "phases": [PHASE_KEYS],
    "planned_error": DEVIATION_KEYS,
    "verified_error": DEVIATION_KEYS,
    "rows_error": DEVIATION_KEYS,
    "tolerance": TOLERANCE_KEYS,
    "certificate": CERTIFICATE_KEYS,
    "clearance_m": None,
    "largest_bend_rad": None,
    "limits": LIMIT_KEYS,
    "blocked": None,
    "waypoints": None,
    "follow": None,
    "rows": None,
    "trajectory": None,
    "plan_document": None,
}
PRIMITIVE_KEYS = dict.fromkeys(("control", "angle_rad"))
GAIT_KEYS = {
    **dict.fromkeys(("schema", "verdict", "gait", "summary", "amplitude_rad", "amplitude_means", "cycles")),
    "swimmer": SWIMMER_KEYS,
    "approach": [PRIMITIVE_KEYS],
    "cycle": [PRIMITIVE_KEYS],
    **dict.fromkeys(("joint_travel_rad", "duration_s")),
    "displacement": dict.fromkeys(("x_m", "y_m", "z_m", "roll_rad", "pitch_rad", "yaw_rad")),
    **dict.fromkeys(("moves", "cross_talk", "closure_rad", "energy_j", "trajectory")),
}
LISTED_KEYS = dict.fromkeys(("name", "also", "moves", "amplitude_means", "default_amplitude_rad", "summary"))
GAIT_LIST_KEYS = {"schema": None, "verdict": None, "gaits": [LISTED_KEYS]}
VERIFY_KEYS = {
    "schema": None,
    "verdict": None,
    "swimmer": SWIMMER_KEYS,
    "start_error": DEVIATION_KEYS,
    "verified_error": DEVIATION_KEYS,
    "tolerance": TOLERANCE_KEYS,
    "certificate": CERTIFICATE_KEYS,
    "clearance_m": None,
    "largest_bend_rad": None,
    "workspace_violation_m": None,
    "obstacle_distance_m": None,
    "waypoints": None,
    "follow": None,
    "judged": dict.fromkeys(
        (
            "clearance_m",
            "max_bend_rad",
            "workspace_m",
            "joint_rate_rad_s",
            "joint_acceleration_rad_s2",
            "joint_ranges",
        )
    ),
    "faults": None,
}


def test_a_plans_document_has_exactly_its_keys_and_the_file_holds_the_plan(run: Run, folder: Path) -> None:
    code, out, err = run("plan", "start.yaml", "goal.yaml", "--json")
    document = document_of(out)
    assert (code, err) == (DONE, "")
    assert keys(document) == PLAN_KEYS
    assert (document["schema"], document["verdict"]) == ("purcell/plan/1", "reached")
    assert [p["phase"] for p in document["phases"]] == [1, 2, 3]
    assert document["trajectory"] == "trajectory.csv"
    assert document["certificate"]["method"] == "extrapolation"
    assert document["verified_error"]["position_over_L"] <= 1e-9
    write_csv(solution().trajectory, folder / "wanted.csv")
    assert (folder / "trajectory.csv").read_bytes() == (folder / "wanted.csv").read_bytes()
    assert document["rows"] == (folder / "trajectory.csv").read_bytes().count(b"\n") - 1
    for cost in ("primitives", "joint_travel_rad", "duration_s", "energy_j"):
        assert math.isclose(sum(p[cost] for p in document["phases"]), document[cost], rel_tol=1e-9)
        for phase in document["phases"]:
            assert math.isclose(sum(s[cost] for s in phase["strokes"]), phase[cost], rel_tol=1e-9)


def test_a_plan_of_nothing_has_the_keys_too(run: Run, folder: Path) -> None:
    (folder / "here.yaml").write_text("{}")
    code, out, err = run("plan", "here.yaml", "here.yaml", "--json")
    document = document_of(out)
    assert (code, err) == (DONE, "")
    assert {**keys(document), "phases": None} == {**PLAN_KEYS, "phases": None}
    assert [phase["strokes"] for phase in document["phases"]] == [[], [], []]
    assert (document["rows"], document["joint_travel_rad"], document["verdict"]) == (1, 0, "reached")


def test_a_gaits_document_has_exactly_its_keys(run: Run, folder: Path) -> None:
    code, out, err = run("gait", "cruise", "--amplitude", "0.5", "--cycles", "3", "--json")
    document = document_of(out)
    assert (code, err) == (DONE, "")
    assert keys(document) == GAIT_KEYS
    assert (document["schema"], document["verdict"], document["gait"]) == ("purcell/gait/1", "done", "x-cruise")
    assert (document["amplitude_rad"], document["cycles"], document["trajectory"]) == (0.5, 3, "x-cruise.csv")
    assert document["displacement"]["x_m"] > 0.0
    travel = 2 * sum(abs(p["angle_rad"]) for p in document["approach"])
    travel += 3 * sum(abs(p["angle_rad"]) for p in document["cycle"])
    assert math.isclose(document["joint_travel_rad"], travel, rel_tol=1e-12)
    with (folder / "x-cruise.csv").open(newline="") as file:
        last = list(csv.DictReader(file))[-1]
    assert math.isclose(float(last["x_m"]), document["displacement"]["x_m"], rel_tol=1e-9)
    assert math.isclose(float(last["t_s"]), document["duration_s"], rel_tol=1e-9)


def test_the_list_of_gaits_has_exactly_its_keys_and_writes_nothing(run: Run, folder: Path) -> None:
    before = contents(folder)
    code, out, err = run("gait", "--list", "--json")
    document = document_of(out)
    assert (code, err) == (DONE, "")
    assert keys(document) == GAIT_LIST_KEYS
    assert (document["schema"], document["verdict"]) == ("purcell/gait-list/1", "done")
    assert {"x-motion", "y-motion", "z-motion", "x-rotation"} <= {g["name"] for g in document["gaits"]}
    assert contents(folder) == before


def test_a_checks_document_has_exactly_its_keys_and_writes_nothing(run: Run, folder: Path, good: Path) -> None:
    before = contents(folder)
    for goal, verdict, code in (("goal.yaml", "reached", DONE), ("start.yaml", "not reached", NOT_REACHED)):
        found, out, err = run("verify", good.name, "start.yaml", goal, "--json")
        document = document_of(out)
        assert (found, err) == (code, "")
        assert keys(document) == VERIFY_KEYS
        assert (document["schema"], document["verdict"]) == ("purcell/verify/1", verdict)
        assert bool(document["faults"]) == (verdict == "not reached")
        assert document["clearance_m"] > 0.19
    assert contents(folder) == before


@pytest.mark.slow
def test_people_read_tables_on_stdout(run: Run, folder: Path, good: Path) -> None:
    commands = {
        ("plan", "start.yaml", "goal.yaml"): ["base displacement", "reached", "joint travel", "rows in trajectory.csv"],
        ("gait", "yaw", "--amplitude", "0.5"): ["z-rotation", "limb1 yaw", "trajectory in z-rotation.csv"],
        ("gait", "--list"): ["x-motion", "cruise", "printed-phi"],
        ("verify", "good.csv", "start.yaml", "goal.yaml"): ["re-integrated end", "extrapolation", "reached"],
    }
    for command, parts in commands.items():
        code, out, err = run(*command)
        assert (code, err) == (DONE, "")
        assert all(part in out for part in parts), out
        with pytest.raises(json.JSONDecodeError):
            json.loads(out)


def test_a_table_cuts_no_number_short(run: Run, folder: Path) -> None:
    (folder / "far.yaml").write_text("base: {position_m: [0.05, 0.02, 0.01], orientation: {euler_deg: [10, 20, 30]}}")
    _, out, _ = run("plan", "start.yaml", "far.yaml")
    assert "…" not in out


@pytest.mark.slow
def test_simultaneous_controls_make_a_quicker_plan_that_verifies(run: Run, folder: Path) -> None:
    """The same keys; less time; moves instead of primitives in the table."""
    _, out, _ = run("plan", "limb-rolls", "--json")
    plain = document_of(out)
    code, out, err = run("plan", "limb-rolls", "--controls", "simultaneous", "--json", "--out", "q.csv")
    quick = document_of(out)
    assert (code, err, set(quick)) == (DONE, "", set(plain))
    assert [set(phase) for phase in quick["phases"]] == [set(phase) for phase in plain["phases"]]
    assert (plain["controls"], quick["controls"]) == ("primitive", "simultaneous")
    assert quick["duration_s"] < plain["duration_s"]
    assert math.isclose(sum(p["duration_s"] for p in quick["phases"]), quick["duration_s"], rel_tol=1e-9)
    assert run("verify", "q.csv", "limb-rolls")[0] == DONE
    assert " moves, " in run("plan", "limb-rolls", "--controls", "simultaneous")[1]


@pytest.mark.slow
def test_help_and_version_are_printed_and_done(run: Run, folder: Path) -> None:
    before = contents(folder)
    for command in (["--help"], ["plan", "--help"], ["gait", "--help"], ["verify", "--help"], ["run", "--help"]):
        code, out, err = run(*command)
        assert (code, err) == (DONE, "")
        assert "Usage: " in out
    assert run("--version") == (DONE, f"purcell {__version__}\n", "")
    assert contents(folder) == before


def test_out_names_the_file(run: Run, folder: Path) -> None:
    (folder / "sub").mkdir()
    before = set(contents(folder))
    for arguments in (["plan", "start.yaml", "goal.yaml"], ["gait", "z-motion"]):
        code, out, _ = run(*arguments, "--out", "sub/mine.csv", "--json")
        assert code == DONE
        assert document_of(out)["trajectory"] == "sub/mine.csv"
        assert set(contents(folder)) - before == {"sub/mine.csv"}


def test_the_swimmer_of_the_option_swims(run: Run, folder: Path) -> None:
    (folder / "swimmer.yaml").write_text("slenderness: 0.02\njoint_rate_rad_s: 4\n")
    code, out, _ = run("plan", "start.yaml", "goal.yaml", "--swimmer", "swimmer.yaml", "--json")
    document = document_of(out)
    assert code == DONE
    assert document["swimmer"]["slenderness"] == 0.02
    assert math.isclose(4.0 * document["duration_s"], document["joint_travel_rad"], rel_tol=1e-12)
    check = ["verify", "trajectory.csv", "start.yaml", "goal.yaml"]
    assert run(*check, "--swimmer", "swimmer.yaml")[0] == DONE
    assert run(*check)[0] == NOT_REACHED


def test_the_start_can_come_from_standard_input(run: Run, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(START.encode())))
    code, out, err = run("plan", "-", "goal.yaml", "--json")
    assert (code, err) == (DONE, "")
    assert document_of(out)["joint_travel_rad"] == solution().joint_travel_rad


def test_a_scenario_is_planned_and_checked_by_its_file(run: Run, folder: Path) -> None:
    (folder / "mine.yaml").write_text("name: mine\nstart: start.yaml\ngoal: goal.yaml\n")
    assert run("plan", "mine.yaml")[0] == DONE
    assert run("verify", "trajectory.csv", "mine.yaml")[0] == DONE


def test_a_plan_that_does_not_arrive_is_no_success(run: Run, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def almost(*_: object, **__: object) -> Solution:
        found = solution()
        pose = found.plan.goal.pose.copy()
        pose[0, 3] += 1e-6
        elsewhere = dataclasses.replace(found.plan, goal=Configuration(pose, found.plan.goal.shape))
        return Solution(elsewhere, found.options, found.replay, found.limits)

    monkeypatch.setattr(purcell_cli.missions, "plan", almost)
    code, out, err = run("plan", "start.yaml", "goal.yaml", "--json")
    document = document_of(out)
    assert (code, err, document["verdict"]) == (NOT_REACHED, "", "not reached")
    assert keys(document) == PLAN_KEYS
    code, out, _ = run("plan", "start.yaml", "goal.yaml")
    assert code == NOT_REACHED
    assert "not reached" in out


# --- Limits --------------------------------------------------------------------------------------------------------

FOLDED = "limb1: {euler_deg: [180, 0, 0]}"
ROOMY = "workspace_m: {min: [-1, -1, -1], max: [1, 1, 1]}"
TIGHT = "workspace_m: {min: [-0.018, -0.308, 0.173], max: [0.4185, 0.092, 0.476]}"
"""A box that the links touch at the start and at the goal."""


@pytest.mark.parametrize("name", ["start", "goal"])
def test_a_configuration_whose_limbs_overlap_is_refused_and_nothing_is_written(
    run: Run, folder: Path, name: str
) -> None:
    """Folded onto the base a limb as long as the base reaches the other limb."""
    (folder / f"{name}.yaml").write_text(FOLDED)
    message = "a clearance of at least 0 m between limb 1 and limb 2 is wanted, found -0.004 m (they overlap)"
    assert_misuse(run, folder, ["plan", "start.yaml", "goal.yaml"], f"{name}: {message}")


@pytest.mark.slow
def test_a_plan_says_how_near_it_comes_to_its_limits(run: Run, folder: Path) -> None:
    (folder / "goal.yaml").write_text(f"{GOAL}{ROOMY}\n")
    code, out, _ = run("plan", "start.yaml", "goal.yaml", "--clearance", "0.1", "--json")
    document = document_of(out)
    assert (code, document["verdict"]) == (DONE, "reached")
    assert math.isclose(document["clearance_m"], 0.196, rel_tol=1e-12)
    assert 0.0 < document["largest_bend_rad"] <= 1.0 + 1e-9
    assert document["largest_bend_rad"] == document["phases"][1]["largest_bend_rad"]
    assert document["limits"] == {
        "clearance_m": 0.1,
        "max_bend_rad": 1.0,
        "workspace_m": {"min": [-1.0, -1.0, -1.0], "max": [1.0, 1.0, 1.0]},
        "workspace_violation_m": 0.0,
        "obstacle": None,
        "kept": True,
        "violations": [],
    }
    _, out, _ = run("plan", "start.yaml", "goal.yaml")
    assert "limbs 196 mm apart or more, bent" in out
    assert "rad at most in phase 2, inside the workspace" in out


@pytest.mark.slow
def test_a_plan_that_leaves_its_workspace_is_no_success(run: Run, folder: Path) -> None:
    (folder / "goal.yaml").write_text(f"{GOAL}{TIGHT}\n")
    code, out, err = run("plan", "start.yaml", "goal.yaml", "--effort", "quick", "--plan-out", "plan.json", "--json")
    document = document_of(out)
    assert (code, err, document["verdict"]) == (NOT_REACHED, "", "not found within limits")
    assert keys({**document, "limits": None}) == {**PLAN_KEYS, "limits": None}
    (broken,) = document["limits"]["violations"]
    assert keys(broken) == VIOLATION_KEYS
    assert (broken["limit"], broken["unit"]) == ("workspace", "m")
    assert broken["excess"] == document["limits"]["workspace_violation_m"] > 0.0
    assert re.fullmatch(r"(joint of|end of) limb [12] beyond the (least|largest) [xyz]", broken["what"])
    code, out, _ = run("run", "plan.json")
    assert code == NOT_REACHED
    assert "not found within limits" in out
    assert "- workspace: " in out
    code, out, _ = run("run", "plan.json", "--json")
    again = document_of(out)
    assert (code, again["verdict"], again["limits"]) == (NOT_REACHED, document["verdict"], document["limits"])


# --- Bad input: exit 2, one message, nothing written ---------------------------------------------------------------

BILLION_LAUGHS = "a: &a [x, x, x, x, x, x, x, x, x, x]\n" + "".join(
    f"{b}: &{b} [{', '.join(['*' + a] * 10)}]\n" for a, b in zip("abcdefgh", "bcdefghi", strict=True)
)
BAD_STARTS: dict[str, tuple[str | bytes, str]] = {
    "misspelt key": ("\nlimb_1: {euler_deg: [1, 2, 3]}", "start.yaml:2: limb_1: wanted one of the keys"),
    "unknown inner key": ("base: {position: [1, 2, 3]}", "start.yaml:1: base.position: wanted one of the keys"),
    "wrong type": ("base: {position_m: far}", "start.yaml:1: base.position_m: wanted a list of 3"),
    "wrong shape": ("base: {position_m: [1, 2]}", "start.yaml:1: base.position_m: wanted a list of 3"),
    "NaN": ("limb1: {euler_deg: [0, .nan, 0]}", "start.yaml:1: limb1.euler_deg[1]: wanted a finite number"),
    "infinity": ("base: {position_m: [0, 0, -.inf]}", "start.yaml:1: base.position_m[2]: wanted a finite number"),
    "no rotation": ("limb1: {matrix: [[1, 0, 0], [0, 1, 0], [0, 0.1, 1]]}", "limb1.matrix: wanted"),
    "reflection": ("limb1: {matrix: [[1, 0, 0], [0, 1, 0], [0, 0, -1]]}", "limb1.matrix: wanted"),
    "zero quaternion": ("limb2: {quaternion_wxyz: [0, 0, 0, 0]}", "limb2.quaternion_wxyz: wanted"),
    "two forms": ("limb1: {euler_deg: [0, 0, 0], euler_rad: [0, 0, 0]}", "limb1: wanted a mapping with exactly one"),
    "no form": ("limb1: {}", "limb1: wanted a mapping with exactly one"),
    "empty": ("", "start.yaml:1: the document: wanted"),
    "malformed": ("base: {position_m: [1, 2", "start.yaml:"),
    "a tab": ("base:\n\t- 1", "start.yaml:2:"),
    "twice the same key": (
        "limb1: {euler_deg: [0, 0, 0]}\nlimb1: {euler_deg: [0, 0, 1]}",
        "start.yaml:2: limb1: wanted",
    ),
    "two documents": ("{}\n---\n{}", "start.yaml:"),
    "aliases that explode": (BILLION_LAUGHS, "aliases expanded, found more"),
    "absurd size": ("# " + "x" * (1 << 20), "start.yaml:1: the document: wanted at most"),
    "a tag": ("base: !!python/object:os.system {}", "wanted plain YAML"),
    "not UTF-8": (b"limb1: {euler_deg: [0, 0, 0]} # \xff", "start.yaml:1: the document: wanted UTF-8"),
    "a list": ("- 1\n- 2", "start.yaml:1: the document: wanted a mapping"),
}
BAD_SWIMMERS: dict[str, tuple[str, str]] = {
    "negative length": (
        "base_half_length_m: -0.1",
        "swimmer.yaml:1: base_half_length_m: wanted a finite number above 1e-12",
    ),
    "zero viscosity": ("viscosity_pa_s: 0", "swimmer.yaml:1: viscosity_pa_s: wanted a finite number above 1e-12"),
    "a drag ratio of one": ("drag_ratio: 1", "swimmer.yaml:1: drag_ratio: wanted a finite number above 1"),
    "a fat link": ("slenderness: 0.5", "swimmer.yaml:1: slenderness: wanted a finite number above 1e-06"),
    "misspelt key": ("joint_rate: 1", "swimmer.yaml:1: joint_rate: wanted one of the keys"),
}
BAD_COMMANDS: dict[str, tuple[list[str], str]] = {
    "missing start": (["plan", "missing.yaml", "goal.yaml"], "missing.yaml: wanted a readable file"),
    "missing goal": (["plan", "start.yaml", "missing.yaml"], "missing.yaml: wanted a readable file"),
    "a folder for a file": (["plan", ".", "goal.yaml"], "wanted a readable file, found a directory"),
    "missing swimmer": (
        ["plan", "start.yaml", "goal.yaml", "--swimmer", "missing.yaml"],
        "missing.yaml: wanted a file, or a stored swimmer",
    ),
    "no scenario": (["plan", "start.yaml"], "the goal is missing: start.yaml is a configuration"),
    "a scenario for a start": (
        ["plan", "whole.yaml", "goal.yaml"],
        "whole.yaml is a scenario, with a start",
    ),
    "a scenario for a goal": (
        ["plan", "start.yaml", "whole.yaml"],
        "whole.yaml is a scenario, with a start",
    ),
    "unknown scenario": (["plan", "nonesuch-scenario"], "nonesuch-scenario: wanted a file, or a stored scenario"),
    "no arguments": (["plan"], "Missing argument 'START'"),
    "too many arguments": (["plan", "start.yaml", "goal.yaml", "goal.yaml"], "unexpected extra argument"),
    "unknown option": (["plan", "start.yaml", "goal.yaml", "--fast"], "No such option: --fast"),
    "unknown command": (["swim"], "No such command 'swim'"),
    "out is a folder": (["plan", "start.yaml", "goal.yaml", "--out", "."], "wanted a file to write, found a folder"),
    "out in no folder": (["plan", "start.yaml", "goal.yaml", "--out", "no/t.csv"], "no/t.csv: "),
    "dt of nothing": (["plan", "start.yaml", "goal.yaml", "--dt", "0"], "dt: a time above"),
    "dt NaN": (["plan", "start.yaml", "goal.yaml", "--dt", "nan"], "dt: a time above"),
    "dt no number": (["plan", "start.yaml", "goal.yaml", "--dt", "soon"], "--dt: a number is wanted, found 'soon'"),
    "clearance negative": (
        ["plan", "start.yaml", "goal.yaml", "--clearance=-1e-3"],
        "clearance: a finite length of 0 m or more is wanted, found -0.001",
    ),
    "clearance NaN": (["plan", "start.yaml", "goal.yaml", "--clearance", "nan"], "clearance: a finite length of 0 m"),
    "clearance no number": (
        ["plan", "start.yaml", "goal.yaml", "--clearance", "far"],
        "--clearance: a number is wanted, found 'far'",
    ),
    "a start not clear": (
        ["plan", "start.yaml", "goal.yaml", "--clearance", "0.2"],
        "start: a clearance of at least 0.2 m between limb 1 and limb 2 is wanted, found 0.196 m",
    ),
    "unknown effort": (
        ["plan", "start.yaml", "goal.yaml", "--effort", "lazy"],
        "effort: one of quick, standard, thorough",
    ),
    "unknown controls": (
        ["plan", "start.yaml", "goal.yaml", "--controls", "both"],
        "controls: one of primitive, simultaneous",
    ),
    "plan dt too small": (["plan", "start.yaml", "goal.yaml", "--dt", "1e-12"], "dt: a time above"),
    "unknown gait": (["gait", "z-mtion"], "no gait is called 'z-mtion'; did you mean 'z-motion'?"),
    "no gait": (["gait"], "a gait's name is wanted"),
    "amplitude of nothing": (["gait", "yaw", "--amplitude", "0"], "amplitude: an angle other than 0"),
    "amplitude NaN": (["gait", "yaw", "--amplitude", "nan"], "amplitude: an angle other than 0"),
    "amplitude beyond pi": (["gait", "yaw", "--amplitude=-3.2"], "amplitude: an angle other than 0"),
    "no cycles": (["gait", "yaw", "--cycles", "0"], "--cycles: a whole number from 1 to 1000000 is wanted, found '0'"),
    "half a cycle": (["gait", "yaw", "--cycles", "1.5"], "--cycles: a whole number from 1 to 1000000 is wanted"),
    "a number with an underscore": (["gait", "yaw", "--amplitude", "1_0"], "--amplitude: a number is wanted, found"),
    "a number of another script": (
        ["plan", "start.yaml", "goal.yaml", "--seed", "٣"],
        "--seed: a whole number is wanted",
    ),
    "a number with its unit": (["plan", "start.yaml", "goal.yaml", "--dt", "5ms"], "--dt: a number is wanted"),
    "gait out in no folder": (["gait", "yaw", "--out", "no/t.csv"], "no/t.csv: "),
    "missing gaits": (["gait", "yaw", "--gaits", "missing"], "missing: wanted a folder of gait files"),
    "a swimmer that is none": (["gait", "yaw", "--swimmer", "goal.yaml"], "goal.yaml:1: base: wanted one of the keys"),
    "gait dt of nothing": (["gait", "yaw", "--dt", "0"], "dt: a time above"),
    "gait dt negative": (["gait", "yaw", "--dt=-1"], "dt: a time above"),
    "gait dt NaN": (["gait", "yaw", "--dt", "nan"], "dt: a time above"),
    "gait dt too small": (["gait", "yaw", "--dt", "1e-12"], "dt: a time above"),
    "missing trajectory": (
        ["verify", "missing.csv", "start.yaml", "goal.yaml"],
        "missing.csv: wanted a trajectory file",
    ),
    "no trajectory": (["verify", "goal.yaml", "start.yaml", "goal.yaml"], "goal.yaml:1: column 1: wanted 't_s'"),
    "check of nothing": (["verify"], "Missing argument 'TRAJECTORY'"),
    "no truth": (["track", "roll"], "Missing option '--truth'"),
    "no measured configuration": (["replan", "plan.json"], "Missing option '--from'"),
    "no fitted file": (["fit", "x.csv"], "Missing option '--out'"),
    "an amplitude of a trajectory": (
        ["plot", "x.csv", "--amplitude", "1"],
        "--amplitude: none is wanted for a traject",
    ),
    "validate no kind": (["validate", "goal.yaml", "--kind", "gaol"], "--kind: a kind of document is wanted"),
    "a tolerance of nothing": (
        ["verify", "x.csv", "start.yaml", "goal.yaml", "--tolerance", "0"],
        "--tolerance: a number above 0",
    ),
    "a tolerance NaN": (
        ["verify", "x.csv", "start.yaml", "goal.yaml", "--tolerance", "nan"],
        "--tolerance: a number above 0",
    ),
}


def assert_misuse(run: Run, folder: Path, arguments: list[str], message: str) -> None:
    """Assert that a command is refused with a message, for people and for machines, and that it writes nothing."""
    before = contents(folder)
    code, out, err = run(*arguments)
    assert (code, out) == (MISUSE, "")
    assert message in plain(err)
    assert "Traceback" not in err
    code, out, err = run(*arguments, "--json")
    document = document_of(out)
    assert code == MISUSE
    assert keys(document) == ERROR_KEYS
    assert document["verdict"] == "error"
    assert re.fullmatch(r"purcell/[a-z]+/1", document["schema"])
    assert message in plain(document["error"])
    assert document["error"] in err
    assert contents(folder) == before


@pytest.mark.parametrize("kind", BAD_STARTS)
def test_a_bad_configuration_is_refused_and_nothing_is_written(run: Run, folder: Path, kind: str) -> None:
    text, message = BAD_STARTS[kind]
    (folder / "start.yaml").write_bytes(text if isinstance(text, bytes) else text.encode())
    assert_misuse(run, folder, ["plan", "start.yaml", "goal.yaml"], message)


@pytest.mark.parametrize("kind", BAD_SWIMMERS)
def test_a_bad_swimmer_is_refused_and_nothing_is_written(run: Run, folder: Path, kind: str) -> None:
    text, message = BAD_SWIMMERS[kind]
    (folder / "swimmer.yaml").write_text(text)
    assert_misuse(run, folder, ["gait", "x-motion", "--swimmer", "swimmer.yaml"], message)


@pytest.mark.parametrize("kind", mostly_slow(BAD_COMMANDS, 12))
def test_a_bad_command_is_refused_and_nothing_is_written(run: Run, folder: Path, kind: str) -> None:
    assert_misuse(run, folder, *BAD_COMMANDS[kind])


def test_a_bad_gait_of_ones_own_is_refused_and_nothing_is_written(run: Run, folder: Path) -> None:
    (folder / "own").mkdir()
    (folder / "own" / "g.yaml").write_text("name: g\nsummary: s\nmoves: x\namplitude: 1\ncycle: []\n")
    assert_misuse(run, folder, ["gait", "g", "--gaits", "own"], "own/g.yaml:4: amplitude: wanted a mapping")


def test_a_bad_command_leaves_the_file_of_a_good_one(run: Run, folder: Path) -> None:
    (folder / "trajectory.csv").write_text(WRITTEN_BEFORE)
    (folder / "x-motion.csv").write_text(WRITTEN_BEFORE)
    (folder / "bad.yaml").write_text("limb3: {}")
    assert run("plan", "start.yaml", "bad.yaml")[0] == MISUSE
    assert run("gait", "x-motion", "--amplitude", "7")[0] == MISUSE
    assert (folder / "trajectory.csv").read_text() == WRITTEN_BEFORE
    assert (folder / "x-motion.csv").read_text() == WRITTEN_BEFORE


def test_a_full_disk_is_said_and_leaves_the_old_file(run: Run, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> NoReturn:
        raise OSError(errno.ENOSPC, "No space left on device")

    (folder / "x-motion.csv").write_text(WRITTEN_BEFORE)
    monkeypatch.setattr("os.replace", full)
    assert_misuse(run, folder, ["gait", "x-motion"], "x-motion.csv: cannot be written (No space left on device)")


# --- Checking a trajectory file ------------------------------------------------------------------------------------


def cells(path: Path) -> list[list[str]]:
    """Return the cells of a file, the header first."""
    return [line.split(",") for line in path.read_text().splitlines()]


def tampered(path: Path, row: int, changes: dict[str, Callable[[float], float]]) -> int:
    """Change cells in one row of a file, -1 being the last; return the row's line."""
    table = cells(path)
    line = row % len(table)
    for column, change in changes.items():
        k = table[0].index(column)
        table[line][k] = repr(change(float(table[line][k])))
    path.write_text("".join(",".join(row) + "\n" for row in table))
    return line + 1


def acting(path: Path, row: int) -> str:
    """Return the column of the control that acts in a row."""
    table = cells(path)
    return next(name for name, cell in zip(table[0][-6:], table[row][-6:], strict=True) if float(cell) != 0.0)


def faults(run: Run, good: Path, *arguments: str) -> list[str]:
    """Return what a check finds wrong; the tables say the same."""
    command = ["verify", good.name, "start.yaml", *(arguments or ("goal.yaml",))]
    code, out, err = run(*command, "--json")
    document = document_of(out)
    assert (code, err) == ((NOT_REACHED, "") if document["faults"] else (DONE, ""))
    assert document["verdict"] == ("not reached" if document["faults"] else "reached")
    code, out, _ = run(*command)
    assert code == (NOT_REACHED if document["faults"] else DONE)
    assert all(fault in out for fault in document["faults"])
    assert plain(out).endswith(document["verdict"])
    return list(document["faults"])


def test_a_good_file_holds(run: Run, good: Path) -> None:
    assert faults(run, good) == []


@pytest.mark.parametrize("share", [0.2, 0.5, 0.9])
def test_one_control_turned_round_is_found_at_the_end_and_where_it_is(run: Run, good: Path, share: float) -> None:
    row = int(share * (len(cells(good)) - 2)) + 1
    line = tampered(good, row, {acting(good, row): lambda rate: -rate})
    found = faults(run, good)
    assert any(re.match(r"re-integrated end against the goal: .* off .* by [-+]", fault) for fault in found)
    placed = [
        int(m[1]) for fault in found if (m := re.match(r"line (\d+) \(t = .* s\) against the re-integration", fault))
    ]
    assert placed
    assert line < min(placed)
    assert not any(fault.startswith(("first row", "last row")) for fault in found)


def test_a_goal_moved_by_a_micrometre_is_missed_by_a_micrometre(run: Run, good: Path) -> None:
    (good.parent / "moved.yaml").write_text(GOAL.replace("-0.1,", "-0.100001,"))
    found = faults(run, good, "moved.yaml")
    assert len(found) == 2
    for fault, label in zip(found, ("re-integrated end", "last row"), strict=True):
        assert re.match(rf"{label} against the goal: base position off in x by .*, y by \+1\.000e-06 m, z by", fault)
    assert faults(run, good, "moved.yaml", "--tolerance", "2e-5") == []


@pytest.mark.parametrize(
    ("column", "change", "row", "message"),
    [
        ("z_m", lambda v: v - 1e-6, -1, r"last row against the goal: base position off in x by .*, z by -1\.000e-06 m"),
        (
            "x_m",
            lambda v: v + 1e-6,
            1,
            r"first row against the start: base position off in x by \+1\.000e-06 m, y by \+0",
        ),
        (
            "l2_qz",
            lambda v: v + 1e-7,
            -1,
            r"last row against the goal: limb 2 orientation off about x by .* z by \+1\.98",
        ),
        ("phi_rad", lambda v: v + 1e-6, 1, r"line 2: the base's Euler angles are not those of its quaternion"),
        ("l1_psi_rad", lambda v: v + 1e-6, 30, r"line 31: the limb 1's Euler angles are not those of its quaternion"),
        ("w2y_rad_s", lambda _: 0.5, -1, r"line \d+: the controls of the last row must be 0"),
    ],
    ids=["end moved", "start moved", "limb turned", "Euler angle", "a limb's Euler angle", "a control at the end"],
)
def test_a_cell_that_was_changed_is_found_with_its_coordinate_and_amount(
    run: Run, good: Path, column: str, change: Callable[[float], float], row: int, message: str
) -> None:
    tampered(good, row, {column: change})
    found = faults(run, good)
    assert any(re.match(message, fault) for fault in found)
    assert not any(fault.startswith("re-integrated") for fault in found)


def test_a_row_between_switches_that_was_moved_is_found(run: Run, good: Path) -> None:
    table = cells(good)
    row = next(k for k in range(2, len(table) - 2) if table[k - 1][-6:] == table[k][-6:] == table[k + 1][-6:])
    line = tampered(good, row, {"y_m": lambda v: v + 1e-3})
    assert any(f"line {line}" in fault for fault in faults(run, good))


def test_the_wrong_swimmer_misses_the_goal(run: Run, good: Path) -> None:
    (good.parent / "other.yaml").write_text("slenderness: 0.02")
    found = faults(run, good, "goal.yaml", "--swimmer", "other.yaml")
    assert any(
        fault.startswith("re-integrated end against the goal: base orientation off about x by") for fault in found
    )
    (good.parent / "slow.yaml").write_text("joint_rate_rad_s: 0.5")
    assert faults(run, good, "goal.yaml", "--swimmer", "slow.yaml") == [
        "line 2: a joint turns at 1 rad/s, more than 0.5"
    ]


def test_the_wrong_start_is_found(run: Run, good: Path) -> None:
    (good.parent / "start.yaml").write_text(START.replace("[40,", "[40.001,"))
    assert faults(run, good)[0].startswith("first row against the start: base orientation off about x by")


@pytest.mark.slow
def test_rows_left_out_or_shuffled_are_found(run: Run, good: Path) -> None:
    lines = good.read_text().splitlines(keepends=True)
    good.write_text("".join(lines[:-1]))
    assert any("the controls of the last row must be 0" in fault for fault in faults(run, good))
    good.write_text("".join([*lines[:20], *lines[40:]]))
    assert any("re-integrated" in fault for fault in faults(run, good))
    good.write_text("".join([*lines[:20], lines[25], *lines[20:]]))
    assert_misuse(run, good.parent, ["verify", "good.csv", "start.yaml", "goal.yaml"], "wanted a time of at least")


@pytest.mark.parametrize(
    ("row", "column", "change", "message"),
    [
        (30, "qw", lambda v: v + 1e-3, "good.csv:31: "),
        (30, "t_s", lambda _: 0.0, "good.csv:31: "),
    ],
    ids=["quaternion", "time"],
)
def test_a_row_that_is_no_configuration_is_refused_at_its_line(
    run: Run, good: Path, row: int, column: str, change: Callable[[float], float], message: str
) -> None:
    tampered(good, row, {column: change})
    assert_misuse(run, good.parent, ["verify", "good.csv", "start.yaml", "goal.yaml"], message)


# --- From the shell ------------------------------------------------------------------------------------------------


def shell(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a command as a process of its own."""
    return subprocess.run([*COMMAND, *arguments], cwd=folder, capture_output=True, text=True, check=False, timeout=120)


@pytest.mark.slow
def test_a_process_ends_with_the_exit_code(folder: Path, good: Path) -> None:
    """0 done, 1 not reached, 2 misuse; without a warning."""
    tampered(good, -1, {"x_m": lambda v: v + 1e-6})
    ended = {
        DONE: shell(folder, "gait", "x-motion", "--json"),
        NOT_REACHED: shell(folder, "verify", "good.csv", "start.yaml", "goal.yaml", "--json"),
        MISUSE: shell(folder, "plan", "start.yaml", "missing.yaml", "--json"),
    }
    for code, process in ended.items():
        assert process.returncode == code
        document_of(process.stdout)
        assert (process.stderr == "") == (code != MISUSE)
    assert ended[MISUSE].stderr == f"purcell plan: {json.loads(ended[MISUSE].stdout)['error']}\n"


@pytest.mark.slow
def test_a_gait_made_without_a_solution_ends_without_a_file(run: Run, folder: Path) -> None:
    (folder / "own").mkdir()
    (folder / "own" / "g.yaml").write_text(
        "name: hopeless\nsummary: s\nmoves: x\namplitude: {symbol: a, means: m, default_rad: 1}\n"
        "cycle:\n  - limb2 yaw: a\n  - limb1 yaw: a\n  - limb2 yaw: -a\n  - limb1 yaw: -a\n"
        "  - limb1 roll: b\n  - limb1 roll: -b\nfree:\n  b: {guess: 0.5}\n"
    )
    before = contents(folder)
    code, out, err = run("gait", "hopeless", "--gaits", "own", "--json")
    assert code != DONE
    assert document_of(out)["verdict"] != "done"
    assert "no pure stroke" in err
    assert contents(folder) == before


INTERRUPTIBLE = "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one process")
@pytest.mark.parametrize(
    "arguments",
    [
        ["gait", "x-motion", "--cycles", "200", "--dt", "2e-3", "--out", "swim.csv"],
        ["plan", "start.yaml", "goal.yaml", "--dt", "5e-4", "--out", "swim.csv", "--json"],
        ["plan", "start.yaml", "goal.yaml", "--dt", "5e-4", "--out", "swim.csv", "--plan-out", "plan.json"],
    ],
    ids=["gait", "plan", "plan and its document"],
)
@pytest.mark.parametrize("by", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupt_while_writing_leaves_the_old_file_and_no_other(
    folder: Path, arguments: list[str], by: signal.Signals
) -> None:
    (folder / "swim.csv").write_text(WRITTEN_BEFORE)
    before = contents(folder)
    code = INTERRUPTIBLE + COMMAND[-1]
    with subprocess.Popen(
        [sys.executable, "-c", code, *arguments], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        writing = False
        while not writing and process.poll() is None:
            time.sleep(0.01)
            writing = any(folder.glob(".swim.csv.*"))
        process.send_signal(by)
        out, err = process.communicate(timeout=60)
    assert writing, err
    assert process.returncode == 128 + by
    assert contents(folder) == before
    assert "Traceback" not in err
    if by == signal.SIGTERM:
        return
    assert "interrupted; nothing was written" in err
    if "--json" in arguments:
        assert document_of(out)["verdict"] == "error"


def test_an_interrupt_while_planning_writes_nothing(run: Run, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupted(*_: object, **__: object) -> NoReturn:
        raise KeyboardInterrupt

    before = contents(folder)
    monkeypatch.setattr(purcell_cli.missions, "plan", interrupted)
    for arguments in ([], ["--json"]):
        code, out, err = run("plan", "start.yaml", "goal.yaml", *arguments)
        assert code not in {DONE, NOT_REACHED, MISUSE}
        assert err == "purcell plan: interrupted; nothing was written\n"
        assert (document_of(out)["verdict"] == "error") if arguments else (out == "")
    assert contents(folder) == before


def test_an_interrupt_after_writing_says_what_was_written(
    run: Run, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object, **__: object) -> NoReturn:
        raise KeyboardInterrupt

    monkeypatch.setattr("purcell_cli.cli.gait._show", interrupted)
    code, _, err = run("gait", "x-motion")
    assert code not in {DONE, NOT_REACHED, MISUSE}
    assert (folder / "x-motion.csv").exists()
    assert err == "purcell gait: interrupted; x-motion.csv was written\n"


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["plan", "start.yaml", "far.yaml"], "far.yaml: goal: position_m: coordinates up to 112589 m are wanted"),
        (["plan", "far.yaml", "goal.yaml"], "far.yaml: start: position_m: coordinates"),
        (["verify", "good.csv", "start.yaml", "far.yaml"], "far.yaml: goal: position_m: coordinates"),
        (["track", "start.yaml", "far.yaml", "--truth", "level.yaml"], "far.yaml: goal: position_m: coordinates"),
        (["plan", "far-scenario.yaml"], "far-scenario.yaml: goal: position_m: coordinates"),
        (["plan", "still.yaml"], "still.yaml: swimmer: joints that can move the base"),
        (["plan", "level.yaml", "level.yaml", "--swimmer", "fixed.yaml"], "fixed.yaml: swimmer: joints that can move"),
        (["plan", "start.yaml", "goal.yaml", "--dt", "-1"], "--dt: a time above 0 s"),
    ],
)
def test_refusals_of_what_was_read_name_its_file(run: Run, good: Path, words: list[str], message: str) -> None:
    far, fixed = "{base: {position_m: [1e9, 0, 0]}}", "{joints: {limb1: hinge, limb2: fixed}}"
    Path("far.yaml").write_text(far)
    Path("far-scenario.yaml").write_text(f"name: far\nstart: {{}}\ngoal: {far}\n")
    Path("level.yaml").write_text("{}")
    Path("fixed.yaml").write_text(fixed)
    Path("still.yaml").write_text(f"name: still\nstart: {{}}\ngoal: {{}}\nswimmer: {fixed}\n")
    code, out, err = run(*words)
    assert (code, out) == (2, "")
    assert err.splitlines()[-1].startswith(f"purcell {words[0]}: {message}")
