"""purcell init, validate and schema: what they write, find and print, and that an editor agrees with them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema
import pytest
import yaml
from helpers import Run, runner

from purcell_cli import PlanOptions, Swimmer, load_scenario, load_swimmer, stored_scenarios
from purcell_cli.files.builtin import data_folder, stored_swimmers
from purcell_cli.files.scenario_file import SCHEMAS
from purcell_cli.files.templates import FILES
from purcell_cli.missions import refuse_waypoints
from purcell_cli.query import refuse_query


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that runs a command in an empty folder: exit code, stdout, stderr."""
    monkeypatch.chdir(tmp_path)

    return runner(capsys)


def test_init_writes_files_that_are_good_and_refuses_to_write_over_any(run: Run, tmp_path: Path) -> None:
    code, out, _ = run("init", "swim/first", "--json")
    assert (code, json.loads(out)["files"]) == (0, [f"swim/first/{name}" for name in FILES])
    scenario = load_scenario("swim/first/scenario.yaml")
    assert load_swimmer("swim/first/swimmer.yaml") == scenario.swimmer == Swimmer(), "the values shown are the defaults"
    code, out, _ = run("validate", *(f"swim/first/{name}" for name in FILES))
    assert code == 0
    assert out.count(": good, a ") == 6
    (tmp_path / "swim" / "first" / "start.yaml").unlink()
    (tmp_path / "swim" / "first" / "goal.yaml").write_text("mine")
    code, out, err = run("init", "swim/first")
    assert (code, out) == (2, "")
    assert "swim/first/goal.yaml: wanted no such file yet" in err
    assert (tmp_path / "swim" / "first" / "goal.yaml").read_text() == "mine"
    assert not (tmp_path / "swim" / "first" / "start.yaml").exists()


def test_what_the_templates_leave_commented_out_is_good_too(run: Run, tmp_path: Path) -> None:
    assert run("init")[0] == 0
    text = (tmp_path / "scenario.yaml").read_text().replace("start: start.yaml", "start: {}")
    text = text.replace("goal: goal.yaml", "goal: {base: {position_m: [0, 0, 0]}}").replace("swimmer: swimmer.yaml", "")
    for line in ("max_joint_travel_rad: 20", "max_duration_s: 20", "min_clearance_m: 0.05"):
        assert f"  # {line}" in text
        text = text.replace(f"  # {line}", f"  {line}")
    head, _, sweep = text.partition("# sweep:")
    (tmp_path / "all.yaml").write_text(head + "sweep:" + sweep.replace("\n#", "\n"))
    (tmp_path / "goal.yaml").write_text((tmp_path / "goal.yaml").read_text().replace("# workspace_m", "workspace_m"))
    code, out, _ = run("validate", "all.yaml", "goal.yaml")
    assert (code, out) == (0, "all.yaml: good, a scenario of 33 combinations\ngoal.yaml: good, a goal\n")


def test_the_template_has_obstacles_of_every_kind(run: Run, tmp_path: Path) -> None:
    """They are good as they stand, and the start is clear of them; without the mesh's file its line is told."""
    assert run("init")[0] == 0
    text = (tmp_path / "scenario.yaml").read_text()
    lines = text.splitlines()
    first = next(k for k, line in enumerate(lines) if line.startswith("# obstacles:"))
    last = next(k for k, line in enumerate(lines) if line.startswith("expect:"))
    lines[first:last] = [line.removeprefix("# ") for line in lines[first:last]]
    (tmp_path / "scenario.yaml").write_text("\n".join(lines))
    (tmp_path / "vessel.csv").write_text("x_m,y_m,z_m\n-0.6,0,0\n0.6,0,0\n")
    code, out, _ = run("validate", "scenario.yaml")
    assert code == 2
    assert f"scenario.yaml:{last}: obstacles[5].mesh.file: wanted the path of a readable file" in out
    corners = ((0, 0, 0), (100, 0, 0), (0, 100, 0), (0, 0, 100))
    faces = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {' '.join(map(str, corners[k]))}\n" for k in face)
        + "endloop\nendfacet\n"
        for face in ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))
    )
    (tmp_path / "part.stl").write_text(f"solid part\n{faces}endsolid part\n")
    assert run("validate", "scenario.yaml")[0] == 0
    scene = load_scenario("scenario.yaml").obstacles
    assert scene is not None
    assert [one.kind for one in scene.obstacles] == ["sphere", "capsule", "box", "half_space", "tube", "mesh"]


@pytest.mark.parametrize("swimmer", stored_swimmers())
def test_the_template_of_a_mission_is_one_for_every_stored_swimmer(run: Run, swimmer: str) -> None:
    assert run("init", "--swimmer", swimmer)[0] == 0
    found = load_scenario("mission.yaml")
    assert len(found.via) == 2
    refuse_query(found.start, found.goal, found.swimmer, PlanOptions(obstacles=found.obstacles))
    refuse_waypoints(found.mission, found.swimmer, PlanOptions(obstacles=found.obstacles))


@pytest.mark.parametrize(
    ("name", "text", "kind", "message"),
    [
        ("a", "slendernes: 0.01\n", "swimmer", "a.yaml:1: slendernes: wanted one of the keys"),
        ("a", "slendernes: 0.01\n", "swimmer", "(nearest: slenderness), found the unknown key 'slendernes'"),
        ("a", "limb1: {euler_dg: [1, 2, 3]}\n", "start", "a.yaml:1: limb1.euler_dg: wanted"),
        ("a", "\nlimb1: {euler_deg: [1, 2]}\n", "start", "a.yaml:2: limb1.euler_deg: wanted a list of 3"),
        ("a", "name: n\nstart: {}\n", "scenario", "goal: wanted"),
        ("a", "name: n\ncycle: []\nmoves: x\n", "gait", "a.yaml:1: summary: wanted"),
        ("a", "name: n\nstart: {}\ngoal: {}\nsweep: {swimmer.drag_ratio: [2, -1]}\n", "scenario", "swimmer.drag_ratio"),
        ("a", "schema: purcell/plan-document/1\nblocks: []\n", "plan", "a.yaml:1: purcell: wanted"),
        ("a", "[", None, "a.yaml:2: the document: wanted one YAML document"),
        ("a", "", None, "found an empty file"),
        ("missing/a", "", None, "missing/a.yaml: wanted a readable file, found none"),
    ],
)
def test_validate_names_file_line_key_and_what_was_meant(
    run: Run, tmp_path: Path, name: str, text: str, kind: str | None, message: str
) -> None:
    if name == "a":
        (tmp_path / "a.yaml").write_text(text)
    (tmp_path / "good.yaml").write_text("viscosity_pa_s: 1.0")
    code, out, err = run("validate", f"{name}.yaml", "good.yaml", "--json")
    document = json.loads(out)
    assert (code, err, document["verdict"]) == (2, "", "bad")
    bad, good = document["files"]
    assert bad["kind"] == kind
    assert message in bad["error"]
    assert (good["kind"], good["error"]) == ("swimmer", None), "a bad file does not stop the others"


@pytest.mark.slow
def test_all_stored_documents_are_good_by_their_own_kind_and_by_their_json_schema(run: Run) -> None:
    gaits, scenarios = sorted(data_folder("gaits").glob("*.yaml")), list(stored_scenarios().values())
    code, out, _ = run("validate", *map(str, [*gaits, *scenarios]), "--json")
    assert code == 0
    kinds = [checked["kind"] for checked in json.loads(out)["files"]]
    assert kinds == ["gait"] * len(gaits) + ["scenario"] * len(scenarios)
    for kind, files in (("gait", gaits), ("scenario", scenarios)):
        code, out, _ = run("schema", kind)
        schema = json.loads(out)
        jsonschema.Draft202012Validator.check_schema(schema)
        validator = jsonschema.Draft202012Validator(schema)
        for file in files:
            validator.validate(yaml.load(file.read_text(), Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader)))


DOCUMENTS: list[tuple[str, Any, bool]] = [
    ("scenario", {"name": "a", "start": {}, "goal": "goal.yaml", "sweep": {"swimmer.slenderness": [0.01]}}, True),
    ("scenario", {"name": "a", "start": {}, "goal": {}, "sweep": {"name": ["b"]}}, False),
    ("scenario", {"name": "a", "start": {}, "goal": {}, "sweep": {"goal.base.position_m[0]": {"start": 0}}}, False),
    ("scenario", {"name": "a", "start": {}, "goal": {}, "expect": {"error": "x", "min_clearance_m": 0}}, True),
    ("scenario", {"name": "../a", "start": {}, "goal": {}}, False),
    ("start", {"limb1": {"euler_deg": [1, 2, 3]}}, True),
    ("start", {"limb1": {"euler_deg": [1, 2, 3], "euler_rad": [1, 2, 3]}}, False),
    ("swimmer", {"slenderness": 0.01}, True),
    ("swimmer", {"slenderness": -0.01}, False),
]


@pytest.mark.parametrize(("kind", "document", "good"), DOCUMENTS)
def test_the_json_schema_and_the_check_agree(run: Run, tmp_path: Path, kind: str, document: Any, good: bool) -> None:
    (tmp_path / "goal.yaml").write_text("{}")
    (tmp_path / "a.yaml").write_text(json.dumps(document))
    assert run("validate", "a.yaml", "--kind", kind)[0] == (0 if good else 2)
    assert jsonschema.Draft202012Validator(SCHEMAS[kind].json_schema()).is_valid(document) == good


def test_schema_writes_a_file_and_refuses_a_kind_that_there_is_not(run: Run, tmp_path: Path) -> None:
    assert run("schema", "gait", "--out", "gait.json") == (0, "JSON Schema in gait.json\n", "")
    assert json.loads((tmp_path / "gait.json").read_text()) == SCHEMAS["gait"].json_schema()
    code, out, err = run("schema", "gait", "--json")
    assert (json.loads(out), out.count("\n")) == (SCHEMAS["gait"].json_schema(), 1)
    code, out, err = run("schema", "gaits")
    assert (code, out) == (2, "")
    assert "(nearest: gait)" in err


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        ("purcell b", {"batch"}),
        ("purcell schema s", {"start", "swimmer", "scenario", "servo-map"}),
        ("purcell batch --ju", {"--junit"}),
    ],
)
def test_the_shell_completes_commands_options_and_kinds(words: str, wanted: set[str]) -> None:
    done = subprocess.run(
        [sys.executable, "-c", "import sys; from purcell_cli.cli.app import main; sys.argv = ['purcell']; main()"],
        env=os.environ
        | {"_PURCELL_COMPLETE": "complete_bash", "COMP_WORDS": words, "COMP_CWORD": str(len(words.split()) - 1)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert set(done.stdout.split()) == wanted


@pytest.mark.slow
def test_a_scenario_can_come_from_standard_input(tmp_path: Path) -> None:
    text = "name: a\nstart: {limb1: {euler_deg: [1, 0, 0]}}\ngoal: {limb1: {euler_deg: [1, 0, 0]}}\n"
    main = "import sys; from purcell_cli.cli.app import main; main()"
    for arguments in (["plan", "-"], ["validate", "-"]):
        done = subprocess.run(
            [sys.executable, "-c", main, *arguments, "--json"],
            input=text,
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
        )
        assert json.loads(done.stdout)["verdict"] in {"reached", "good"}
    assert (tmp_path / "trajectory.csv").exists()
