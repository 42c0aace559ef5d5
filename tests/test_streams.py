"""Standard streams: a full disk, a closed pipe, another encoding or odd names end in no traceback."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers import Run, mostly_slow, runner

from purcell_cli.cli.app import built
from purcell_cli.cli.reports.common import displacement_cells, displacement_document
from purcell_cli.cli.terminal import show
from purcell_cli.cli.warnings import warnings_on_stderr
from purcell_cli.errors import PurcellWarning
from purcell_cli.geometry.se3 import pose
from purcell_cli.wording import nearest

PROGRAM = [sys.executable, "-m", "purcell_cli"]
FULL = Path("/dev/full")


def started(*arguments: str, cwd: Path, **streams: Any) -> subprocess.Popen[bytes]:
    """Start a command as a process of its own."""
    return subprocess.Popen([*PROGRAM, *arguments], cwd=cwd, **streams)


@pytest.mark.slow
@pytest.mark.skipif(not FULL.exists(), reason="needs a device that is always full")
@pytest.mark.parametrize(
    "arguments", [["--help"], ["gait", "--list"], ["gait", "--list", "--json"], ["schema", "gait"]]
)
def test_a_full_disk_behind_stdout_is_told_on_one_line(tmp_path: Path, arguments: list[str]) -> None:
    with FULL.open("w") as full:
        process = started(*arguments, cwd=tmp_path, stdout=full, stderr=subprocess.PIPE)
        _, err = process.communicate()
    assert process.returncode == 2
    assert b"standard output: No space left on device" in err
    assert err.count(b"\n") == 1


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="closes file numbers")
@pytest.mark.parametrize("closed", [0, 1, 2])
def test_a_stream_that_is_closed_changes_no_result(tmp_path: Path, closed: int) -> None:
    shell = 'exec "$0" "$@" ' + ["<&-", ">&-", "2>&-"][closed]
    for arguments, code in ((["gait", "y", "--out", "y.csv", "--json"], 0), (["plan", "nowhere", "--json"], 2)):
        done = subprocess.run(
            ["/bin/sh", "-c", shell, *PROGRAM, *arguments], cwd=tmp_path, capture_output=True, text=True
        )
        assert done.returncode == code
        assert "Traceback" not in done.stderr
        if closed != 1:
            assert json.loads(done.stdout)["verdict"] == ("done" if code == 0 else "error")
    header = (tmp_path / "y.csv").read_bytes().splitlines()[0]
    assert header.startswith(b"t_s,phase,gait,"), "a file that is written does not get a stream's number"


@pytest.mark.slow
@pytest.mark.parametrize("arguments", [["gait", "--list"], ["schema", "scenario"], ["--help"]])
def test_a_pipe_that_is_closed_early_leaves_the_exit_code(tmp_path: Path, arguments: list[str]) -> None:
    process = started(*arguments, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.close()
    process.stdout = None
    with process:
        assert (process.communicate()[1], process.returncode) == (b"", 0)


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["ascii", "cp1252", "latin-1", "ascii:strict", "utf-8"])
def test_what_stdout_cannot_encode_is_escaped(tmp_path: Path, encoding: str) -> None:
    """JSON is UTF-8, whatever stdout is."""
    name = "µ→é😀.json"
    surroundings = {**os.environ, "PYTHONIOENCODING": encoding}
    (tmp_path / name).write_text("{}")
    for arguments in (["validate", name, "--kind", "start"], ["validate", name, "--kind", "start", "--json"]):
        done = subprocess.run([*PROGRAM, *arguments], cwd=tmp_path, env=surroundings, capture_output=True, check=True)
        text = done.stdout.decode(encoding.partition(":")[0])
        if "--json" in arguments:
            assert json.loads(done.stdout.decode("utf-8"))["files"][0]["file"] == name, (
                "JSON is UTF-8, whatever stdout is"
            )
        else:
            assert text.endswith(": good, a start or goal\n")
            assert (name in text) == (encoding == "utf-8")


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that runs a command in an empty folder: exit code, stdout, stderr."""
    monkeypatch.chdir(tmp_path)
    return runner(capsys)


ODD_TEXTS = [
    "advances [m] per [/b], see [1] :snake:",
    "[/red]",
    "[bold]x[/bold] [link=http://a]b[/link]",
    "$x^2$ %s {0}",
]
GAIT = "name: own\nmoves: none\namplitude: {{symbol: a, means: {0}, default_rad: 1}}\nsummary: {0}\n"
GAIT += "cycle: [{{limb1 yaw: a}}, {{limb1 yaw: -a}}]\n"


@pytest.mark.parametrize("text", ODD_TEXTS)
def test_a_text_is_shown_as_it_is(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    """No table takes [ ] for markup, nor : : for a picture."""
    (tmp_path / "g").mkdir()
    (tmp_path / "g" / "own.yaml").write_text(GAIT.format(json.dumps(text)))
    code, out, _ = run("gait", "own", "--gaits", "g")
    assert code == 0
    assert f"own: {text}\n" in out
    assert f"({text})" in out
    monkeypatch.setenv("COLUMNS", "250")  # so that no cell is broken
    code, out, _ = run("gait", "--list", "--gaits", "g")
    assert code == 0
    assert out.count(text) == 2


NAMES = [
    "[/red].csv",
    "[bold]x[/].csv",
    ":smile:.csv",
    "a$b$.csv",
    "a$\\bad{$.csv",
    "<b>&.csv",
    "a\nb\x1b[31m.csv",
    "%s{}.csv",
]


@pytest.mark.skipif(os.name != "posix", reason="other systems do not take such names")
@pytest.mark.parametrize("name", mostly_slow([*NAMES, "é" * 120 + ".csv", "-x.csv"], 1))
def test_a_file_may_have_any_name(run: Run, tmp_path: Path, name: str) -> None:
    """It is written, read, drawn and shown under it."""
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    code, out, _ = run("gait", "y", f"--out={name}", "--json")
    assert (code, json.loads(out)["trajectory"]) == (0, name)
    assert path.exists()
    code, out, err = run("gait", "y", f"--out={name}")
    assert (code, err) == (0, "")
    assert f"trajectory in {name}"[:40] in out
    for command, file in (("view", "v.html"), ("plot", "p.png")):
        code, _, err = run(command, f"--out={file}", "--", name)
        assert (code, err) == (0, "")
        assert (tmp_path / file).exists()


READERS = [["plan"], ["plan", "nearby", "--swimmer"], ["run"], ["validate"], ["verify", "t.csv"], ["view"], ["plot"]]
READERS += [["batch"], ["batch", "nearby", "--baseline"], ["gait", "y", "--gaits"], ["controllability", "--shape"]]
WRITERS = [["gait", "y", "--out"], ["plot", "y", "--out"], ["batch", "nearby", "--out"], ["init"], ["design", "--out"]]


@pytest.mark.parametrize("name", ["n" * 256, "n" * 5000, "é" * 128, f"{'n' * 256}/x", "no/x"])
@pytest.mark.parametrize("command", [*READERS, *WRITERS])
def test_a_name_that_no_file_can_have_is_refused(run: Run, tmp_path: Path, command: list[str], name: str) -> None:
    if command in (["init"], ["batch", "nearby", "--out"]) and name == "no/x":
        return  # a folder that is made
    code, out, err = run(*command, name)
    assert code == 2
    assert "Traceback" not in err
    assert (err or out).count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "command",
    [["plan"], ["run"], ["view"], ["verify", "x"], ["validate"], ["gait", "y", "--gaits"], ["batch", "roll", "--out"]],
)
def test_links_that_lead_round_are_refused(run: Run, tmp_path: Path, command: list[str]) -> None:
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    for name in ("a", "a/below.yaml"):
        code, out, err = run(*command, name)
        assert code == 2
        assert (err or out).count("\n") == 1


def test_warnings_of_the_package_are_lines_on_stderr_each_once(capsys: pytest.CaptureFixture[str]) -> None:
    with warnings_on_stderr("plan"):
        for text in ("a", "b", "a"):
            warnings.warn(text, PurcellWarning, stacklevel=1)
        with pytest.raises(DeprecationWarning):  # another's, of which the tests make an error
            warnings.warn("c", DeprecationWarning, stacklevel=1)
    shown = capsys.readouterr()
    assert (shown.out, shown.err) == ("", "purcell plan: warning: a\npurcell plan: warning: b\n")


def test_suggestions_know_names_without_their_case() -> None:
    assert nearest("X-Motoin", ["y-motion", "x-motion"]) == "x-motion"
    assert nearest("slenderness", ["Slenderness"]) == "Slenderness"
    assert nearest("psi", ["PSI", "psi"]) == "PSI"
    assert nearest("q", ["x-motion"]) is None


@pytest.mark.parametrize(("angle", "name"), [("psi", "yaw"), ("theta", "pitch"), ("phi", "roll")])
def test_suggestions_know_the_papers_angles(angle: str, name: str) -> None:
    """By its letters alone psi is like pitch: the foil."""
    assert nearest(f"limb1 {angle}", ["limb1 roll", "limb1 pitch", "limb1 yaw"]) == f"limb1 {name}"
    assert nearest(angle.upper(), ["x", "roll", "pitch", "yaw"]) == name
    assert nearest(name, ["psi", "theta", "phi"]) == angle
    assert nearest(angle.upper(), ["yaw", "pitch", "roll", angle]) == angle


def test_misspelt_words_are_met_with_the_nearest_whatever_their_case(run: Run, tmp_path: Path) -> None:
    (tmp_path / "w.yaml").write_text("SLENDERNESS: 0.01")
    for arguments, hint in (
        (["gait", "Y-MOTION"], "did you mean 'y-motion'?"),
        (["plan", "NEARBY"], "did you mean 'nearby'?"),
        (["plan", "nearby", "--SWIMMER", "x"], "(nearest: --swimmer)"),
        (["PLAN", "nearby"], "(nearest: plan)"),
        (["plan", "nearby", "--effort", "QUICK"], "--effort: one of quick, standard, thorough (nearest: quick)"),
        (["gait", "y", "--format", "CSV"], "(nearest: csv)"),
        (["plan", "nearby", "--swimmer", "w.yaml"], "(nearest: slenderness)"),
        (["schema", "GAIT"], "(nearest: gait)"),
    ):
        code, _, err = run(*arguments)
        assert code == 2
        assert hint in err


@pytest.mark.slow
def test_help_answers_to_h_and_shows_no_type_and_no_cut_word(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    for command in built().commands:
        code, out, _ = run(command, "-h")
        assert (code, out) == run(command, "--help")[:2]
        assert code == 0
        assert not re.search(r"<\w|\[\[|…", out), command
        assert "...}" not in out
        shown = [str(param.metavar) for param in built().commands[command].params if param.metavar]
        assert all(word in out for word in shown), command  # none goes on in a second line
        assert max(map(len, out.splitlines())) <= 80
        assert "--json" in out
    assert run("-h")[1] == run("--help")[1]


@pytest.mark.parametrize("command", ["verify", "track"])
def test_help_shows_the_units_in_brackets(run: Run, command: str) -> None:
    _, out, _ = run(command, "-h")
    shown = "".join(out.replace("│", " ").split())
    units = {
        unit for param in built(command).commands[command].params for unit in re.findall(r"\[\w+\]", param.help or "")
    }
    assert units
    assert {unit for unit in units if unit not in shown} == set()


@pytest.mark.parametrize(
    "arguments", [["gait", "--list"], ["gait", "--all"], ["gait", "psi"], ["gait", "x-loop"], ["controllability"]]
)
def test_tables_fit_eighty_columns_and_more_and_cut_no_cell(
    run: Run, monkeypatch: pytest.MonkeyPatch, arguments: list[str]
) -> None:
    for width in (80, 120, 128, 160):
        monkeypatch.setenv("COLUMNS", str(width))
        code, out, _ = run(*arguments)
        assert code == 0
        assert max(map(len, out.splitlines())) <= width
        assert "…" not in out


@pytest.mark.parametrize("width", [120, 100, 80, 72, 66, 60])
def test_a_plans_table_leaves_out_columns_before_names_are_broken(
    run: Run, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, width: int
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", str(width))
    code, out, _ = run("plan", "nearby")
    assert code == 0
    assert max(map(len, out.partition("joint travel")[0].splitlines())) <= width
    assert "…" not in out
    names = (
        "1 limbs to collinear",
        "2 base displacement",
        "refined strokes",
        "3 limbs to the goal shape",
        "re-integrated",
    )
    assert [sum(name in line for line in out.splitlines()) for name in names] == [1] * len(names)
    headings = {"amplitude": 120, "psi, theta, phi": 100, "x, y, z": 66}
    assert {name for name in headings if name in out} == {name for name, least in headings.items() if width >= least}


def test_displacements_of_many_metres_are_shown_without_exponents() -> None:
    for digits, shown in ((3, "1447, 999, -12.3"), (4, "1447, 999.4, -12.34")):
        moved = displacement_document(pose(np.eye(3), np.array([1.44725, 0.99942, -0.0123449])))
        assert displacement_cells(moved, 0.1, digits)[0] == shown
    assert (
        displacement_cells(displacement_document(pose(np.eye(3), np.array([20.5, 0.0, 0.0]))), 0.1, 4)[0]
        == "20500, 0, 0"
    )


def test_a_table_takes_its_cells_as_they_are(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    show({"schema": "x"}, False, lambda console, _: console.print(f"{console.width} [red]a[/] :x:"))
    assert capsys.readouterr().out == "40 [red]a[/] :x:\n"


NAMED = {
    "x": "x-motion",
    "y": "y-motion",
    "z": "z-motion",
    "psi": "z-rotation",
    "theta": "y-rotation",
    "phi": "x-rotation",
}


@pytest.mark.parametrize("name", NAMED)
def test_the_papers_names_are_gaits(run: Run, name: str) -> None:
    """The foil is the displacement: psi turns about z."""
    code, out, _ = run("gait", name, "--json")
    document = json.loads(out)
    assert (code, document["gait"]) == (0, NAMED[name])
    key = {"psi": "yaw_rad", "theta": "pitch_rad", "phi": "roll_rad"}.get(name, f"{name}_m")
    moved = document["displacement"]
    assert [k for k, v in moved.items() if abs(v) > 1e-9] == [key]
    shown = run("gait", name)[1]
    row = next(line for line in shown.splitlines()[::-1] if line.startswith("  ") and line.strip("0 ."))
    wanted = moved[key] * (1e3 if key.endswith("_m") else 180.0 / 3.141592653589793)
    cells = dict(zip(("x", "y", "z", "psi", "theta", "phi"), row.split(), strict=True))
    assert abs(float(cells[name]) - wanted) < 1e-5 * abs(wanted)
    assert {v for k, v in cells.items() if k != name} == {"0"}
