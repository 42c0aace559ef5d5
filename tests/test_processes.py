"""No process of the program runs code from the working folder, and forks of a process that has used polars go on."""

from __future__ import annotations

import json
import multiprocessing
import subprocess
import sys
from pathlib import Path

import pytest
from batches import roll

from purcell_cli import processes

_OTHERS = ("numpy", "scipy", "polars", "rich", "typer", "click", "yaml", "filelock", "sitecustomize", "usercustomize")
_SCRIPT = "from purcell_cli.cli.app import main\nif __name__ == '__main__':\n    main()\n"


def shadowed(folder: Path, spared: frozenset[str] = frozenset()) -> Path:
    """Fill a folder with a scenario and a file of each module's name that says that it was run, and return it."""
    folder.mkdir()
    (folder / "case.yaml").write_text(roll("a", 5))
    for name in {*sys.stdlib_module_names, *_OTHERS} - spared:
        (folder / f"{name}.py").write_text(f"open('RUN-{name}', 'w').close()\nraise RuntimeError('picked up {name}')\n")
    return folder


def done(folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments], cwd=folder, capture_output=True, encoding="utf-8", check=False, timeout=120
    )


def picked_up(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.glob("RUN-*"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments",
    [
        ("batch", "case.yaml", "--jobs", "2", "--effort", "quick", "--parquet"),
        ("plan", "case.yaml", "--effort", "quick", "--out", "t.csv"),
    ],
)
def test_a_command_runs_nothing_of_its_working_folder(tmp_path: Path, arguments: tuple[str, ...]) -> None:
    folder = shadowed(tmp_path / "strangers")
    (tmp_path / "purcell").write_text(_SCRIPT)  # as the installed command is: a script in a folder of its own
    for command in ([str(tmp_path / "purcell")], ["-P", "-m", "purcell_cli"]):
        ended = done(folder, *command, *arguments)
        assert ended.returncode == 0, ended.stderr
        assert picked_up(folder) == []
    foil = done(folder, "-c", "import json")
    assert foil.returncode == 1
    assert picked_up(folder) != []


@pytest.mark.slow
def test_python_m_runs_nothing_that_python_itself_does_not_look_for_there(tmp_path: Path) -> None:
    loaded = done(tmp_path, "-P", "-c", "import sys, runpy, importlib.util; print(*sys.modules)").stdout.split()
    folder = shadowed(tmp_path / "strangers", frozenset(name.partition(".")[0] for name in loaded))
    assert (folder / "json.py").exists()
    assert (folder / "typing.py").exists()
    ended = done(folder, "-m", "purcell_cli", "batch", "case.yaml", "--effort", "quick")
    assert ended.returncode == 0, ended.stderr
    assert picked_up(folder) == []


@pytest.mark.slow
def test_workers_of_a_notebook_run_nothing_of_its_folder(tmp_path: Path) -> None:
    """There the working folder is among the places of the process itself, as an empty text."""
    folder = shadowed(tmp_path / "strangers")
    program = (
        "import sys; from purcell_cli.cli.app import main; from purcell_cli.batch import local_workers, runner, junit; "
        "import numpy, scipy.integrate, polars, yaml, rich.console, rich.table, json; sys.path.insert(0, ''); main()"
    )
    ended = done(folder, "-P", "-c", program, "batch", "case.yaml", "--effort", "quick", "--jobs", "2")
    assert ended.returncode == 0, ended.stderr
    assert picked_up(folder) == []


def test_the_places_for_modules_are_as_before_once_a_process_has_started(monkeypatch: pytest.MonkeyPatch) -> None:
    import os

    monkeypatch.setattr(sys, "path", ["", "here"])
    monkeypatch.delenv("PYTHONSAFEPATH", raising=False)
    monkeypatch.setenv("OMP_NUM_THREADS", "7")
    with processes.starting({"OMP_NUM_THREADS": "1"}):
        assert sys.path == ["here", processes._ROOT]
        assert (os.environ["PYTHONSAFEPATH"], os.environ["OMP_NUM_THREADS"]) == ("1", "1")
    assert sys.path == ["", "here"]
    assert "PYTHONSAFEPATH" not in os.environ
    assert os.environ["OMP_NUM_THREADS"] == "7"


_FORK = """
import json, multiprocessing, sys
from purcell_cli import Configuration, PurcellError, plan, read_csv, write_csv
from purcell_cli.files.trajectory_formats import write_trajectory

swim = plan(Configuration(), Configuration.from_angles((0, 0, 0), (0, 0, 5))).trajectory
for ending in ("csv", "parquet", "tum"):
    write_trajectory(swim, f"parent.{ending}", ending)

def child():
    for ending in ("csv", "parquet", "tum"):
        write_trajectory(swim, f"child.{ending}", ending)
    write_csv(swim, "again.csv")
    try:
        read_csv("nothing.csv")
    except PurcellError as error:
        json.dump([len(read_csv("child.csv").time_s), type(error).__name__, str(error)], open("said.json", "w"))

fork = multiprocessing.get_context("fork").Process(target=child)
fork.start()
fork.join(60)
fork.kill()
sys.exit(fork.exitcode)
"""


@pytest.mark.slow
@pytest.mark.skipif("fork" not in multiprocessing.get_all_start_methods(), reason="no forks on this system")
def test_a_fork_of_a_process_that_has_written_a_table_reads_and_writes_the_same(tmp_path: Path) -> None:
    ended = done(tmp_path, "-W", "ignore", "-c", _FORK)
    assert ended.returncode == 0, ended.stderr
    for ending in ("csv", "parquet", "tum"):
        assert (tmp_path / f"child.{ending}").read_bytes() == (tmp_path / f"parent.{ending}").read_bytes()
    assert (tmp_path / "again.csv").read_bytes() == (tmp_path / "parent.csv").read_bytes()
    rows = len((tmp_path / "parent.csv").read_text().splitlines()) - 1
    assert json.loads((tmp_path / "said.json").read_text()) == [
        rows,
        "InputError",
        "nothing.csv: wanted a trajectory file, found none",
    ]
