"""Outputs: never an input nor another output, in no command; links followed, modes kept, devices and - refused."""

from __future__ import annotations

import contextlib
import os
import stat
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers import Run, runner

from purcell_cli.cli.app import built
from purcell_cli.errors import InputError
from purcell_cli.files import used_files
from purcell_cli.files.atomic_file import whole_file, writable
from purcell_cli.files.plan_file import PlanDocument, write_plan
from purcell_cli.files.trajectory_csv import write_csv
from purcell_cli.files.used_files import note_input, one_command
from purcell_cli.gaits.gait import Stroke
from purcell_cli.gaits.sampling import sample_stroke
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.plan import Plan

STILL = "limb1: {euler_deg: [5, 0, 0]}\n"
GAIT = "name: own\nsummary: s\nmoves: none\namplitude: {symbol: a, means: m, default_rad: 1}\ncycle: [{limb1 yaw: a}]\n"
SCENARIO = f"name: a\nstart: start.yaml\ngoal: {{{STILL.strip()}}}\n"
SUMMARY = '{"rows": [{"name": "a", "verdict": "reached", "joint_travel_rad": 1, "position_error_over_L": 0, '
SUMMARY += '"base_error_rad": 0, "limb1_error_rad": 0, "limb2_error_rad": 0}]}'

INPUTS: dict[tuple[str, str], str] = {
    **{(command, "swimmer"): "swimmer" for command in ("gait", "plot", "view", "figures", "design", "controllability")},
    ("track", "start"): "start",
    ("track", "goal"): "start",
    ("track", "swimmer"): "swimmer",
    ("track", "truth"): "swimmer",
    **{(command, "gaits"): "gaits" for command in ("plan", "gait", "plot", "batch")},
    ("plan", "start"): "start",
    ("plan", "goal"): "start",
    ("plan", "swimmer"): "swimmer",
    ("run", "document"): "plan",
    ("replan", "document"): "plan",
    ("replan", "measured"): "start",
    ("plot", "what"): "trajectory",
    ("view", "trajectory"): "trajectory",
    ("export", "trajectory"): "trajectory",
    ("export", "servo_map"): "servos",
    ("export", "swimmer"): "swimmer",
    ("view", "beside"): "trajectory",
    **{(command, "scenario"): "scenario" for command in ("view", "plot")},
    ("simulate", "trajectory"): "trajectory",
    ("simulate", "swimmer"): "swimmer",
    ("simulate", "model"): "swimmer",
    ("fit", "measured"): "trajectory",
    ("fit", "swimmer"): "swimmer",
    ("batch", "paths"): "scenario",
    ("batch", "baseline"): "summary",
}
"""The arguments that name what a command with outputs reads: what it is."""

OUTPUTS: dict[tuple[str, str], str] = {
    **{(command, "out"): "csv" for command in ("plan", "run", "replan", "gait", "simulate", "track")},
    ("plan", "plan_out"): "json",
    ("replan", "plan_out"): "json",
    ("plot", "out"): "png",
    ("view", "out"): "html",
    ("export", "out"): "csv",
    ("figures", "out"): "",
    ("design", "out"): "yaml",
    ("fit", "out"): "yaml",
    ("controllability", "plot"): "svg",
    ("batch", "out"): "",
    ("batch", "junit"): "xml",
    ("schema", "out"): "json",
    ("init", "folder"): "",
}
"""The arguments that name what a command writes: the ending, none for a folder."""

NEITHER = {
    *{("verify", name) for name in ("trajectory", "start", "goal", "swimmer")},
    ("validate", "files"),
    ("controllability", "shape"),  # --plot is refused beside it
}
"""Arguments of commands that write nothing, or write nothing where these are."""

POSITIONAL = {
    "plan": {"start": "start.yaml", "goal": "start.yaml"},
    "simulate": {"trajectory": "trajectory.yaml"},
    "track": {"start": "start.yaml", "goal": "start.yaml"},
    "fit": {"measured": "trajectory.yaml"},
    "run": {"document": "plan.yaml"},
    "replan": {"document": "plan.yaml"},
    "gait": {"name": "x-motion"},
    "plot": {"what": "x-motion"},
    "view": {"trajectory": "trajectory.yaml"},
    "export": {"trajectory": "trajectory.yaml"},
    "batch": {"paths": "scenario.yaml"},
}
"""What stands on a command's places where nothing else does."""

ALWAYS = {"controllability": ["--map"], "export": ["--to", "servo"], "replan": ["--from", "start.yaml"]}
"""What a command is given besides, to write something."""

FOLDERS = {"figures": "x-motion-stroke.svg", "batch": "a.json"}
"""Names of files that a command writes into its folder."""


def parameters() -> Iterator[tuple[str, Any]]:
    """Yield each command's arguments and options."""
    for name, command in built().commands.items():
        for parameter in command.params:
            yield name, parameter


def test_every_argument_that_names_a_file_is_known_here() -> None:
    named = {
        (command, p.name)
        for command, p in parameters()
        if p.metavar in {"FILE", "DIR", "FILE...", "PATH", "START", "GOAL", "TRAJECTORY", "MEASURED", "PLAN"}
    }
    named.add(("plot", "what"))  # or a gait's name
    assert named == INPUTS.keys() | OUTPUTS.keys() | NEITHER, "a new argument needs its place in one of these tables"


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that runs a command in a folder of good files: exit code, stdout, stderr."""
    monkeypatch.chdir(tmp_path)
    Path("gaits").mkdir()
    texts = {
        "start": STILL,
        "swimmer": "slenderness: 0.02\n",
        "servos": "lock_margin_deg: 4.0\n",
        "truth": "slenderness: 0.03\n",
        "gaits/own": GAIT,
        "scenario": SCENARIO,
        "summary": SUMMARY,
    }
    for name, text in texts.items():
        Path(f"{name}.yaml").write_text(text)
    swimmer, sequence = Swimmer(), PrimitiveSequence.of([("limb1 yaw", 0.1), ("limb1 yaw", -0.1)])
    write_plan(PlanDocument(Plan(swimmer, Configuration(), Configuration(), ())), "plan.yaml")
    stroke = Stroke("own", 0.1, PrimitiveSequence.of([]), sequence)
    write_csv(sample_stroke(swimmer, Configuration(), stroke, 1, 0.1), "trajectory.yaml")
    return runner(capsys)


WAYS: dict[str, Callable[[Path], str]] = {
    "itself": str,
    "another spelling": lambda path: f"../{Path.cwd().name}/{path}",
    "a link": lambda path: _linked(path, Path.symlink_to),
    "a hard link": lambda path: _linked(path, Path.hardlink_to),
    "a link to a link": lambda path: _linked(Path(_linked(path, Path.symlink_to)), Path.symlink_to),
}
"""Ways to name a file once more."""


def _linked(path: Path, link: Callable[[Path, Path], None]) -> str:
    other = path.with_name(f"other-{path.name}")
    link(other, path.absolute())
    return str(other)


def option(command: str, name: str, value: str) -> list[str]:
    """Return the words that give an argument a value."""
    found = next(p for c, p in parameters() if (c, p.name) == (command, name))
    flag = found.opts[0]
    return [flag, value] if flag.startswith("-") else [value]


def pairs() -> list[tuple[str, str, str, str]]:
    """Return command, input, output and way of every case."""
    ways = {True: list(WAYS), False: ["itself", "another spelling"]}
    return [
        (command, name, out, way)
        for command, name in INPUTS
        for other, out in OUTPUTS
        if command == other
        for way in ways[bool(OUTPUTS[command, out])]
    ]


def contents(folder: Path) -> dict[str, bytes]:
    """Return what the files below a folder hold."""
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


def words(command: str, name: str, value: str) -> list[str]:
    """Return a command with one of its inputs given, and its places filled."""
    places = {**POSITIONAL.get(command, {}), **({name: value} if name in POSITIONAL.get(command, {}) else {})}
    if (command, name) == ("plot", "scenario"):  # it stands around a trajectory, not a gait
        places["what"] = "trajectory.yaml"
    given = [] if name in places else option(command, name, value)
    needs = {"simulate": "swimmer", "track": "truth"}.get(command, name)
    more = ALWAYS.get(command, [])
    more = more if needs == name else [*more, f"--{needs}", "truth.yaml"]
    return [command, *places.values(), *more, *given]


def placed(kind: str, ending: str, command: str) -> tuple[Path, Path]:
    """Return an input and what an output must not be: a file with the output's ending, or in the output's folder."""
    source = Path("gaits/own.yaml" if kind == "gaits" else f"{kind}.yaml")
    if kind == "gaits":
        if not ending:
            return Path("gaits"), Path("gaits")
        file = source.rename(f"gaits/own.{ending}")
        Path("gaits/link.yaml").symlink_to(file.name)
        return Path("gaits"), file
    if ending:
        file = source.with_suffix(f".{ending}")
        return file, source.rename(file) if source != file else file
    Path("made").mkdir()
    name = "summary.json" if kind == "summary" else FOLDERS[command]
    Path("made/start.yaml").write_text(STILL)
    return source.rename(f"made/{name}"), Path("made")


@pytest.mark.parametrize(("command", "name", "out", "way"), pairs())
def test_an_output_that_is_an_input_is_refused(
    run: Run, tmp_path: Path, command: str, name: str, out: str, way: str
) -> None:
    """The input has an ending that fits the output, so that nothing else is wrong."""
    for place in POSITIONAL.get(command, {}).values():  # what stands on other places is another file
        if Path(place).exists():
            Path(f"beside-{place}").write_bytes(Path(place).read_bytes())
    given, target = placed(INPUTS[command, name], OUTPUTS[command, out], command)
    arguments = [
        word if Path(word).exists() or not Path(f"beside-{word}").exists() else f"beside-{word}"
        for word in words(command, name, str(given))
    ]
    named = WAYS[way](target)
    before = contents(tmp_path)
    code, shown, err = run(*arguments, *option(command, out, named))
    assert (code, shown) == (2, "")
    assert "wanted a file other than" in err
    assert err.count("\n") == 1
    assert contents(tmp_path) == before


@pytest.mark.parametrize(
    ("arguments", "read"),
    [
        (["plan", "trajectory.csv", "trajectory.csv"], "start"),
        (["run", "trajectory.csv"], "plan"),
        (["gait", "x-motion", "--swimmer", "x-motion.csv"], "swimmer"),
        (["view", "swim.html"], "trajectory"),
        (["export", "trajectory.yaml", "--to", "urdf", "--swimmer", "trajectory.urdf"], "swimmer"),
        (["plot", "swim.png"], "trajectory"),
        (["design", "--swimmer", "my-gait.yaml"], "swimmer"),
    ],
)
def test_the_file_that_is_written_where_none_is_named_is_no_input_either(
    run: Run, tmp_path: Path, arguments: list[str], read: str
) -> None:
    Path(f"{read}.yaml").rename(arguments[-1])
    before = contents(tmp_path)
    code, _, err = run(*arguments)
    assert code == 2
    assert f"--out: wanted a file other than {arguments[-1]}, which is read, found the same" in err
    assert contents(tmp_path) == before


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["plan", "start.yaml", "start.yaml", "--out", "x", "--plan-out", "x"],
            "--plan-out: wanted a file other than x",
        ),
        (["plan", "start.yaml", "start.yaml", "--out", "x", "--plan-out", "link"], "other than x, which --out names"),
        (["plan", "start.yaml", "start.yaml", "--plan-out", "trajectory.csv"], "other than trajectory.csv"),
        (
            ["batch", "scenario.yaml", "--out", "r", "--junit", "link2"],
            "--junit: wanted a file other than r/summary.json",
        ),
        (["plan", "start.yaml", "start.yaml", "--out", "-"], "--out: wanted the name of a file, found -"),
        (["batch", "scenario.yaml", "--out", "-"], "--out: wanted the name of a folder, found -"),
        (["schema", "gait", "--out", "-"], "--out: wanted the name of a file, found -"),
        (["view", "trajectory.yaml", "--out", "/dev/stdout"], "found a way to a device or to an open file"),
        (["view", "trajectory.yaml", "--out", "stdout"], "found a way to a device or to an open file"),
        (["view", "trajectory.yaml", "--out", "round"], "found links that lead round"),
        (["view", "trajectory.yaml", "--out", "n" * 256], "File name too long"),
        (["batch", "scenario.yaml", "--out", "n" * 256], "File name too long"),
        (["plan", "start.yaml", "start.yaml", "--out", "t.xlsx"], ".csv, .parquet, .npz, .tum is wanted, found .xlsx"),
        (["run", "plan.yaml", "--out", "t.bag"], ".csv, .parquet, .npz, .tum is wanted, found .bag"),
        (["plan", "start.yaml", "start.yaml", "--plan-out", "p.csv"], "--plan-out: wanted a name that ends in .json"),
        (["gait", "--all", "--out", "a.parquet"], "--out: wanted a name that ends in .csv, found .parquet"),
        (
            ["export", "trajectory.yaml", "--to", "servo", "--out", "a.xlsx"],
            "--out: wanted a name that ends in .csv, found",
        ),
        (["export", "trajectory.yaml", "--to", "urdf", "--out", "a.sdf"], "ends in .urdf, .xml, found .sdf in a.sdf"),
        (
            ["view", "trajectory.yaml", "--out", "a.pdf"],
            "--out: wanted a name that ends in .html, .htm, .gif, .mp4, found .pdf",
        ),
        (["design", "--out", "a.csv"], "--out: wanted a name that ends in .yaml, .yml, found .csv"),
        (["schema", "gait", "--out", "a.yaml"], "--out: wanted a name that ends in .json, found .yaml"),
        (["batch", "scenario.yaml", "--junit", "a.json"], "--junit: wanted a name that ends in .xml, found .json"),
    ],
)
def test_an_output_that_is_no_good_place_is_refused(
    run: Run, tmp_path: Path, arguments: list[str], message: str
) -> None:
    Path("link").symlink_to("x")
    Path("link2").symlink_to("r/summary.json")
    Path("stdout").symlink_to("/proc/self/fd/1")
    Path("round").symlink_to("round2")
    Path("round2").symlink_to("round")
    before = contents(tmp_path)
    code, shown, err = run(*arguments)
    assert (code, shown) == (2, "")
    assert message in err
    after = contents(tmp_path)
    assert {name: data for name, data in after.items() if not name.startswith(("r/", "purcell-results/"))} == before


def test_a_link_stays_a_link_and_a_file_keeps_its_mode(run: Run, tmp_path: Path) -> None:
    (tmp_path / "elsewhere").mkdir()
    real = tmp_path / "elsewhere" / "real.json"
    real.write_text("old")
    real.chmod(0o640)
    Path("link.json").symlink_to("elsewhere/real.json")
    Path("new.json").symlink_to("elsewhere/made.json")
    for name in ("link.json", "new.json"):
        assert run("schema", "gait", "--out", name)[0] == 0
        assert Path(name).is_symlink()
    assert "JSON" not in real.read_text()[:1]
    assert real.read_bytes() == (tmp_path / "elsewhere" / "made.json").read_bytes()
    assert stat.S_IMODE(real.stat().st_mode) == 0o640
    assert sorted(p.name for p in (tmp_path / "elsewhere").iterdir()) == ["made.json", "real.json"]


def test_names_that_differ_in_case_are_one_file_where_the_folder_says_so(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    with one_command():
        writable("a.csv", "--out")
        writable("A.csv", "--plan-out")  # two files here
        writable("E\N{COMBINING ACUTE ACCENT}.csv", "--plan-out")
    assert list(tmp_path.iterdir()) == []
    real = used_files.status

    def without_case(path: Any) -> os.stat_result | None:
        names = {p.name.casefold(): p for p in Path(path).parent.iterdir()}
        return real(names.get(Path(path).name.casefold(), path))

    monkeypatch.setattr(used_files, "status", without_case)
    with one_command():
        writable("a.csv", "--out")
        with pytest.raises(InputError, match=r"--plan-out: wanted a file other than a.csv, which --out names"):
            writable("A.CSV", "--plan-out")
    Path("Start.yaml").write_text("")
    with one_command():
        note_input("Start.yaml")
        with pytest.raises(InputError, match=r"--out: wanted a file other than Start.yaml, which is read"):
            writable("start.yaml", "--out")


def test_a_file_that_is_read_after_it_was_claimed_is_refused_too(tmp_path: Path) -> None:
    file = tmp_path / "a"
    file.write_text("mine")
    with one_command():
        writable(file, "--out")
        with pytest.raises(InputError, match=r"--out: wanted a file other than .*a, which is read"):
            note_input(file)
    with one_command():
        note_input(file)
        with pytest.raises(InputError, match="which is read"), whole_file(file) as stream:
            stream.write(b"no option, no claim")
    assert file.read_text() == "mine"
    with whole_file(file) as stream:  # outside a command, in the library, one may
        stream.write(b"other")
    assert file.read_text() == "other"


@pytest.mark.slow
def test_what_is_printed_does_not_go_where_an_output_goes(tmp_path: Path) -> None:
    for number in (1, 2):
        with contextlib.ExitStack() as stack:
            streams: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
            streams["stdout" if number == 1 else "stderr"] = stack.enter_context((tmp_path / "a.json").open("w"))
            done = subprocess.run(
                [sys.executable, "-m", "purcell_cli", "schema", "gait", "--out", "a.json"],
                cwd=tmp_path,
                text=True,
                **streams,
            )
        assert done.returncode == 2
        assert [p.name for p in tmp_path.iterdir()] == ["a.json"]
        text = done.stderr or (tmp_path / "a.json").read_text()
        assert f"standard {'output' if number == 1 else 'error'}, which goes there, found the same" in text
