"""The README cannot lie: its transcripts are played, its files read, its program run, its names looked up."""

from __future__ import annotations

import difflib
import importlib.util
import re
import sys
import tomllib
from pathlib import Path
from types import ModuleType

import pytest

from purcell_cli.batch.cases import find_cases
from purcell_cli.files import builtin, trajectory_csv
from purcell_cli.files.configuration_file import load_configuration
from purcell_cli.files.gait_file import load_gait
from purcell_cli.files.scenario_file import load_scenario
from purcell_cli.files.swimmer_file import load_swimmer
from purcell_cli.mechanics.swimmer import Swimmer

ROOT = Path(__file__).resolve().parent.parent
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def _update_readme() -> ModuleType:
    spec = importlib.util.spec_from_file_location("update_readme", ROOT / "docs" / "update_readme.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses look for it
    spec.loader.exec_module(module)
    return module


readme = _update_readme()
BLOCKS = readme.blocks(TEXT)

_ROUND_OFF = re.compile(r"(?<![\d.])(?:\d(?:\.\d+)?e-(?:1[1-9]|[2-9]\d|\d{3})|0\.0e\+00)")


def _without_round_off(text: str) -> str:
    """Return an output with figures of 1e-11 and less made alike: another processor rounds otherwise."""
    return _ROUND_OFF.sub("~", text)


def _differences(wanted: str, found: str) -> list[str]:
    """Return the lines in which an output is not the one that is shown."""
    lines = [_without_round_off(text).splitlines() for text in (wanted, found)]
    return list(difflib.unified_diff(*lines, "README.md", "played", lineterm=""))


def _only(kind: str, detail: str = "") -> str:
    """Return the body of the one block with a mark."""
    (block,) = [b for b in BLOCKS if b.kind == kind and (not detail or b.detail == detail)]
    return block.body


def test_every_mark_has_its_block() -> None:
    marks = re.findall(r"^<!-- (\w+).*-->$", TEXT, re.MULTILINE)
    assert marks == [b.kind for b in BLOCKS]
    assert set(marks) == {"setup", "transcript", "file", "columns", "library"}


def test_no_command_is_shown_unplayed() -> None:
    shown = re.findall(r"^\$ (.*)$", TEXT, re.MULTILINE)
    assert shown == [c for b in BLOCKS if b.kind == "transcript" for c in b.commands]
    assert {c.split()[1] for c in shown} >= {"plan", "gait", "verify"}


@pytest.mark.slow
def test_transcripts_are_true() -> None:
    played = [pair for page in readme.PAGES for pair in readme.all_played(page.read_text(encoding="utf-8"))]
    wrong = [line for block, true in played for line in _differences(block.body, true)]
    assert not wrong, "\n".join([*wrong, "python docs/update_readme.py brings the README up to date"])


@pytest.mark.parametrize(
    ("found", "alike"),
    [
        ("x 0.0114, off by 3.4e-14 L", True),
        ("x 0.0114, off by 0.0e+00 L", True),
        ("x 0.0115, off by 3.4e-14 L", False),
        ("x 0.0114, off by 3.4e-10 L", False),
        ("x 0.0114,  off by 3.4e-14 L", False),
        ("x 0.0114, off by 3.4e-14 L\nreached", False),
    ],
)
def test_a_transcript_differs_by_more_than_round_off(found: str, alike: bool) -> None:
    assert (not _differences("x 0.0114, off by 5.1e-12 L", found)) == alike


@pytest.mark.slow
def test_the_program_prints_what_its_comments_say(tmp_path: Path) -> None:
    program = _only("library")
    done = readme.python(["-c", program], tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.splitlines() == re.findall(r"print\(.*\)  # (.*)$", program, re.MULTILINE)
    assert len(done.stdout.splitlines()) == 1
    assert len(trajectory_csv.read_csv(tmp_path / "swim.csv").time_s) > 2


def test_set_up_is_one_line_each() -> None:
    run, test = _only("setup", "run"), _only("setup", "test")
    assert run == "python -m pip install . && purcell plan nearby\n"
    assert test == "python -m pip install -e '.[test]' && python -m pytest\n"
    assert "nearby" in builtin.stored_scenarios()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert "purcell" in project["scripts"]
    assert any(name.startswith("pytest") for name in project["optional-dependencies"]["test"])


def test_files_that_are_shown_can_be_read(tmp_path: Path) -> None:
    readme.write_files(tmp_path, TEXT)
    load_configuration(tmp_path / "start.yaml")
    load_configuration(tmp_path / "goal.yaml")
    assert load_scenario(tmp_path / "across.yaml").expect.verdict == "reached"
    assert find_cases([str(tmp_path / "rolls.yaml")]).count == 4
    assert load_gait(tmp_path / "my-gaits" / "pitch-cruise.yaml").free
    assert load_gait(tmp_path / "my-gaits" / "twist.yaml").curve is not None
    load_swimmer(tmp_path / "swimmer.yaml")
    shown = [b.detail for b in BLOCKS if b.kind == "file"]
    assert len(shown) == 7


def test_swimmer_file_shows_every_parameter_and_its_default(tmp_path: Path) -> None:
    readme.write_files(tmp_path, TEXT)
    assert load_swimmer(tmp_path / "swimmer.yaml") == Swimmer()
    keys = re.findall(r"^(\w+):", _only("file", "swimmer.yaml"), re.MULTILINE)
    assert keys == list(Swimmer.__dataclass_fields__)


def test_columns_are_those_of_the_file() -> None:
    assert "".join(_only("columns").split()) == ",".join(trajectory_csv.COLUMNS)


def test_stored_scenarios_are_named() -> None:
    sentence = re.search(r"Stored scenarios go by their names: (.*?)\n\n", TEXT, re.DOTALL)
    assert set(re.findall(r"`([\w-]+)`", sentence[1])) == set(builtin.stored_scenarios())


def _unknown_modules(text: str) -> list[str]:
    names = re.findall(r"`(purcell_cli[\w.]*)`", text)
    return [name for name in names if importlib.util.find_spec(name) is None]


def test_table_from_paper_to_code_names_modules_that_exist() -> None:
    table = re.search(r"^\| paper \| what \| module \|\n(?:\|.*\n)+", TEXT, re.MULTILINE)[0]
    rows = table.splitlines()[2:]
    assert len(rows) >= 10
    assert all("`purcell_cli." in row.split("|")[3] for row in rows)
    assert _unknown_modules(table) == []
    assert _unknown_modules("| V-A | a flow | `purcell_cli.nowhere` |") == ["purcell_cli.nowhere"]


def test_links_lead_somewhere() -> None:
    targets = re.findall(r"\]\(([^)#]+)", TEXT)
    assert targets
    assert [t for t in targets if "://" not in t and not (ROOT / t).exists()] == []
