"""Plan documents: a plan reads back bit for bit, plays the same file again, and a bad one is one clear message."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers import Run, calls, random_rotations, random_swimmer, runner
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from purcell_cli import (
    Configuration,
    PlanOptions,
    PrimitiveSequence,
    Swimmer,
    load_plan,
    stored_scenarios,
    write_csv,
    write_plan,
)
from purcell_cli.errors import InputError
from purcell_cli.files.plan_file import PLAN, SCHEMA, PlanDocument
from purcell_cli.files.scenario_file import load_scenario
from purcell_cli.geometry.rotations import Array
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.plan import Plan
from purcell_cli.motion.workspace import Workspace
from purcell_cli.planning import plan
from purcell_cli.solution import carried_out

DONE, NOT_REACHED, MISUSE = 0, 1, 2
SQUARE = [["limb1 yaw", 1.0], ["limb2 yaw", 1.0], ["limb1 yaw", -1.0], ["limb2 yaw", -1.0]]


def document(**changes: Any) -> dict[str, Any]:
    """Return a small good plan document as JSON values, with other values for some keys."""
    block = {"phase": 2, "gait": "square", "amplitude_rad": 1.0, "cycles": 3, "primitives": SQUARE}
    return {
        "schema": SCHEMA,
        "purcell": "1.2.3",
        "swimmer": {},
        "start": {},
        "goal": {},
        "dt_s": 0.05,
        "clearance_m": 0.01,
        "blocks": [block],
        **changes,
    }


def block(**changes: Any) -> dict[str, Any]:
    """Return a good block with other values for some keys."""
    return {**document()["blocks"][0], **changes}


def random_plan(rng: np.random.Generator, count: int) -> Plan:
    """Return a plan that goes nowhere in particular, of many random primitives."""
    sequences = [PrimitiveSequence(rng.integers(0, 6, 8), rng.normal(size=8)) for _ in range(count // 8)]
    blocks = tuple(Block(2, "any", sequence, 1, rng.normal()) for sequence in sequences)
    return Plan(random_swimmer(rng), *(configuration(rng) for _ in range(2)), blocks)


def configuration(rng: np.random.Generator) -> Configuration:
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = random_rotations(rng), rng.normal(size=3) * 10.0 ** rng.integers(-12, 6, 3)
    return Configuration(pose, random_rotations(rng, 2))


def numbers(plan: Plan) -> list[Array]:
    """Return all numbers of a plan."""
    ends = [part for c in (plan.start, plan.goal) for part in (c.pose, c.shape)]
    inside = [np.array([b.phase, b.cycles, b.amplitude_rad, *b.sequence.control]) for b in plan.blocks]
    return [*ends, *inside, *(b.sequence.angle for b in plan.blocks)]


# --- What is written reads back ------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_plan_reads_back_bit_for_bit(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    for _ in range(10):
        made = random_plan(rng, 1000)
        workspace = Workspace((-0.1 / 3.0, -1e-9, -2.0), (0.1 / 3.0, 1e9, 2.0))
        options = PlanOptions(dt_s=0.1 / 3.0, clearance_m=0.1 / 7.0, workspace=workspace)
        write_plan(PlanDocument(made, options), tmp_path / "plan.json")
        found = load_plan(tmp_path / "plan.json")
        assert (found.plan.swimmer, found.options) == (made.swimmer, options)
        assert [b.gait for b in found.plan.blocks] == [b.gait for b in made.blocks]
        assert [n.tobytes() for n in numbers(found.plan)] == [n.tobytes() for n in numbers(made)]


@pytest.mark.slow
def test_the_work_of_reading_a_plan_grows_as_the_plan_does(tmp_path: Path) -> None:
    work = []
    for count in (500, 1000, 2000):
        write_plan(PlanDocument(random_plan(np.random.default_rng(0), count)), tmp_path / "plan.json")
        work.append(calls(lambda: load_plan(tmp_path / "plan.json")))
    assert work[2] - work[1] <= 2.2 * (work[1] - work[0])
    assert work[2] < 200 * 2000


def test_a_plan_document_is_json(tmp_path: Path) -> None:
    made = random_plan(np.random.default_rng(1), 16)
    write_plan(PlanDocument(made), tmp_path / "plan.json")
    read = json.loads((tmp_path / "plan.json").read_text())
    assert list(read) == list(document())
    assert list(read["blocks"][0]) == ["phase", "gait", "amplitude_rad", "cycles", "primitives"]
    assert read["schema"] == "purcell/plan-document/1"
    known = {*read, "effort", "controls", "minimize", "workspace_m", "obstacles", "seed", "via", "follow"}
    assert set(PLAN.json_schema()["properties"]) == known  # type: ignore[call-overload]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["nearby", "far", "unequal-links", "bent-goal"])
def test_a_plan_plays_the_same_file_again(tmp_path: Path, name: str) -> None:
    scenario = load_scenario(stored_scenarios()[name])
    made = plan(scenario.start, scenario.goal, swimmer=scenario.swimmer)
    write_plan(PlanDocument(made.plan), tmp_path / "plan.json")
    again = carried_out(load_plan(tmp_path / "plan.json").plan)
    write_csv(made.trajectory, tmp_path / "first.csv")
    write_csv(again.trajectory, tmp_path / "again.csv")
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "first.csv").read_bytes()
    assert again.certificate == made.certificate
    assert again.verdict == "reached"
    assert (name != "far") or max(b.cycles for b in again.plan.blocks) > 10


def test_a_plan_of_nothing_reads_back(tmp_path: Path) -> None:
    here = Configuration.from_angles((0.1, 0.2, 0.3), (1, 2, 3), (4, 5, 6))
    write_plan(PlanDocument(plan(here, here).plan), tmp_path / "plan.json")
    found = load_plan(tmp_path / "plan.json")
    assert found.plan.blocks == ()
    assert carried_out(found.plan, found.options).verdict == "reached"


# --- The commands --------------------------------------------------------------------------------------------------


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that runs a command in an empty folder: exit code, stdout, stderr."""
    monkeypatch.chdir(tmp_path)

    return runner(capsys)


@pytest.mark.slow
def test_run_plays_what_plan_wrote_and_says_the_same(run: Any, tmp_path: Path) -> None:
    code, planned, err = run("plan", "nearby", "--plan-out", "plan.json", "--dt", "0.03", "--out", "first.csv")
    assert (code, err) == (DONE, "")
    assert planned.endswith("\nplan in plan.json\n")
    code, played, err = run("run", "plan.json", "--out", "again.csv")
    assert (code, err) == (DONE, "")
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "first.csv").read_bytes()
    assert played == planned.replace("first.csv", "again.csv").replace("plan in plan.json\n", "")
    documents = [json.loads(run(*c, "--json")[1]) for c in (["plan", "nearby", "--dt", "0.03"], ["run", "plan.json"])]
    assert [d.pop("schema") for d in documents] == ["purcell/plan/1", "purcell/run/1"]
    assert [d.pop("plan_document") for d in documents] == [None, "plan.json"]
    assert documents[0] == documents[1]


@pytest.mark.slow
def test_run_works_from_another_folder_as_a_process_of_its_own(run: Any, tmp_path: Path) -> None:
    assert run("plan", "along-x", "--plan-out", "plan.json")[0] == DONE
    (tmp_path / "elsewhere").mkdir()
    command = [sys.executable, "-W", "error", "-c", "from purcell_cli.cli.app import main; main()"]
    done = subprocess.run(
        [*command, "run", "../plan.json"], cwd=tmp_path / "elsewhere", capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (DONE, "")
    assert (tmp_path / "elsewhere" / "trajectory.csv").read_bytes() == (tmp_path / "trajectory.csv").read_bytes()


@pytest.mark.slow
def test_a_plan_that_does_not_reach_its_goal_is_no_success(run: Any, tmp_path: Path) -> None:
    assert run("plan", "along-x", "--plan-out", "plan.json")[0] == DONE
    read = json.loads((tmp_path / "plan.json").read_text())
    read["goal"]["base"]["position_m"][1] += 1e-6
    (tmp_path / "plan.json").write_text(json.dumps(read))
    code, out, err = run("run", "plan.json", "--json")
    told = json.loads(out)
    assert (code, err, told["verdict"]) == (NOT_REACHED, "", "not reached")
    assert math.isclose(told["verified_error"]["position_m"], 1e-6, rel_tol=1e-3)


@pytest.mark.slow
def test_a_full_disk_leaves_neither_file(run: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object) -> None:
        raise InputError("swim.csv: cannot be written (No space left on device)")

    monkeypatch.setattr("purcell_cli.files.trajectory_formats.write_csv", full)
    assert run("plan", "along-x", "--plan-out", "plan.json", "--out", "swim.csv")[0] == MISUSE
    assert list(tmp_path.iterdir()) == []


# --- Bad documents -------------------------------------------------------------------------------------------------

NESTED = "[" * 10000 + "]" * 10000
BAD: dict[str, tuple[Any, str]] = {
    "empty": ("", "plan.json:1: the document: wanted a mapping"),
    "a list": ([], "plan.json:1: the document: wanted a mapping"),
    "cut off": (json.dumps(document())[:-9], "blocks[0].primitives[3]: wanted one YAML document"),
    "a trajectory": ("t_s,phase,gait\n0,1,x\n", "plan.json:1: the document: wanted a mapping"),
    "a scenario": ({"name": "x", "start": {}, "goal": {}}, "plan.json:1: name: wanted one of the keys schema"),
    "another form": (document(schema="purcell/plan-document/9"), "plan.json:1: schema: wanted one of purcell/plan-doc"),
    "what --json prints": (
        {"schema": "purcell/plan/1", "verdict": "reached"},
        "plan.json:1: wanted a plan document, as --plan-out writes it, found what --json prints",
    ),
    "unknown key": (document(goals={}), "plan.json:1: goals: wanted one of the keys"),
    "no blocks": ({k: v for k, v in document().items() if k != "blocks"}, "plan.json:1: blocks: wanted a list"),
    "NaN": ('{"dt_s": NaN, ' + json.dumps(document())[1:], "plan.json:1: dt_s: wanted each key once"),
    "dt NaN": (document(dt_s=math.nan), "plan.json:1: dt_s: wanted a finite number above 0, found the text 'NaN'"),
    "dt of nothing": (document(dt_s=0), "plan.json:1: dt_s: wanted a finite number above 0"),
    "dt too small": (document(dt_s=1e-9), "plan.json:1: dt_s: wanted a time above"),
    "angle NaN": (document(blocks=[block(primitives=[["limb1 yaw", math.nan]])]), "blocks[0].primitives[0][1]: wanted"),
    "angle in words": (document(blocks=[block(primitives=[["limb1 yaw", "1"]])]), "primitives[0][1]: wanted a finite"),
    "angle beyond measure": (document(blocks=[block(primitives=[["limb1 yaw", 1e9]])]), "primitives[0][1]: wanted"),
    "half a primitive": (
        document(blocks=[block(primitives=[["limb1 yaw"]])]),
        "primitives[0]: wanted a list of one of",
    ),
    "unknown control": (
        document(blocks=[block(primitives=[["limb3 yaw", 1]])]),
        "primitives[0][0]: wanted one of limb1",
    ),
    "unknown key inside": (document(blocks=[block(angle=1)]), "plan.json:1: blocks[0].angle: wanted one of the keys"),
    "a phase too many": (document(blocks=[block(phase=4)]), "plan.json:1: blocks[0].phase: wanted a whole number"),
    "phases in disorder": (document(blocks=[block(), block(phase=1)]), "blocks[1].phase: wanted a phase of at least 2"),
    "half a cycle": (document(blocks=[block(cycles=1.5)]), "blocks[0].cycles: wanted a whole number"),
    "no cycle": (document(blocks=[block(cycles=0)]), "blocks[0].cycles: wanted a whole number"),
    "cycles without end": (document(blocks=[block(cycles=10**9)]), "plan.json:1: blocks: wanted at most 3e+06 prim"),
    "an open stroke repeated": (
        document(blocks=[block(primitives=SQUARE[:3])]),
        "plan.json:1: blocks[0].cycles: wanted 1 for a stroke that does not bring the limbs back",
    ),
    "markup for a name": (document(blocks=[block(gait="[red]x")]), "blocks[0].gait: wanted a stroke's name"),
    "no rotation": (
        document(goal={"limb1": {"matrix": [[2, 0, 0], [0, 1, 0], [0, 0, 1]]}}),
        "goal.limb1.matrix: wanted",
    ),
    "no swimmer": (document(swimmer={"slenderness": -1}), "swimmer.slenderness: wanted a finite number above 1e-06"),
    "deep": (NESTED, "wanted at most 20 levels of nesting"),
    "deep inside": (json.dumps(document(blocks=0)).replace("0}", NESTED + "}"), "wanted at most 20 levels of nesting"),
    "huge": (" " * (1 << 20) + json.dumps(document()), "plan.json:1: the document: wanted at most 1048576 bytes"),
    "bytes": (b"\xff\xfe{}", "plan.json:1: the document: wanted UTF-8"),
}


@pytest.mark.parametrize("kind", BAD)
def test_a_bad_document_is_one_clear_message_and_nothing_is_written(run: Any, tmp_path: Path, kind: str) -> None:
    content, message = BAD[kind]
    text = content if isinstance(content, str | bytes) else json.dumps(content)
    (tmp_path / "plan.json").write_bytes(text if isinstance(text, bytes) else text.encode())
    told: list[tuple[int, str, str]] = []
    assert calls(lambda: told.append(run("run", "plan.json", "--out", "again.csv"))) < 2_000_000
    ((code, out, err),) = told
    assert (code, out) == (MISUSE, "")
    assert message in err
    assert err.startswith("purcell run: plan.json:")
    assert err.count("\n") == 1
    code, out, err = run("run", "plan.json", "--out", "again.csv", "--json")
    assert code == MISUSE
    assert {"schema": "purcell/run/1", "verdict": "error"}.items() <= json.loads(out).items()
    assert [p.name for p in tmp_path.iterdir()] == ["plan.json"]


@pytest.mark.slow
@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_a_document_with_a_stretch_of_other_characters_reads_or_is_refused(tmp_path: Path, data: st.DataObject) -> None:
    text = json.dumps(document())
    low = data.draw(st.integers(0, len(text)))
    high = data.draw(st.integers(low, min(len(text), low + 12)))
    other = data.draw(st.text(st.sampled_from('[]{}",:0123456789.eE+-*&!<<| \n\taN'), max_size=8))
    path = tmp_path / "plan.json"
    path.write_text(text[:low] + other + text[high:])
    try:
        found = load_plan(path)
    except InputError as error:
        assert re.match(rf"{re.escape(str(path))}:\d+: .*: wanted .*, found ", str(error))  # noqa: PT017  # or reads
    else:
        assert found.plan.duration_s / found.options.dt_s <= 3e6


def test_the_good_document_that_the_bad_ones_are_made_from_is_good(run: Any, tmp_path: Path) -> None:
    (tmp_path / "plan.json").write_text(json.dumps(document()))
    code, _, err = run("run", "plan.json")
    assert (code, err) == (NOT_REACHED, "")
    found = load_plan(tmp_path / "plan.json").plan
    assert (found.swimmer, found.primitives, found.joint_travel_rad) == (Swimmer(), 12, 12.0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["run"], "Missing argument 'PLAN'"),
        (["run", "missing.json"], "missing.json: wanted a readable file"),
        (["run", "."], "wanted a readable file, found a directory"),
        (["run", "plan.json", "--out", "plan.json"], "--out: wanted a file other than plan.json"),
        (["run", "plan.json", "--out", "no/x.csv"], "no/x.csv: wanted a file in a folder that exists"),
        (["plan", "along-x", "--plan-out", "no/x.json"], "no/x.json: wanted a file in a folder that exists"),
        (["plan", "along-x", "--plan-out", "trajectory.csv"], "--plan-out: wanted a file other than trajectory.csv"),
        (["plan", "along-x", "--plan-out", "."], "wanted a file to write, found a folder"),
    ],
)
def test_bad_commands_are_refused_and_write_nothing(
    run: Any, tmp_path: Path, arguments: list[str], message: str
) -> None:
    (tmp_path / "plan.json").write_text(json.dumps(document()))
    before = {p.name: p.read_bytes() for p in tmp_path.iterdir()}
    code, out, err = run(*arguments)
    assert (code, out) == (MISUSE, "")
    assert message in " ".join(err.replace("│", " ").split())
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == before
