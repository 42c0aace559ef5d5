"""The README and the site cannot lie: transcripts are played, files read, programs run, names looked up."""

from __future__ import annotations

import difflib
import importlib.util
import re
import shlex
import tomllib
from pathlib import Path

import pytest
from pages import DOCS, PAGES, README, ROOT, known_options, only, shown_commands, tool, update

from purcell_cli.batch.cases import find_cases
from purcell_cli.cli.app import _run
from purcell_cli.files import builtin, trajectory_csv, trajectory_reader
from purcell_cli.files.configuration_file import load_configuration
from purcell_cli.files.gait_file import load_gait
from purcell_cli.files.scenario_file import load_scenario
from purcell_cli.files.servo_map_file import load_servo_map
from purcell_cli.files.swimmer_file import load_swimmer
from purcell_cli.mechanics.swimmer import Swimmer

BLOCKS = {page: update.blocks(text) for page, text in PAGES.items()}
MARKS = {"setup", "transcript", "file", "columns", "library"}
TABLES = {
    "classes",
    "long search",
    "planar",
    "planners",
    "all at once",
    "numerics",
    "times",
    "speed",
    "figures",
    "missions",
    "missions by OMPL",
    "missions follow",
    "missions order",
    "missions via",
    "missions past obstacles",
}
"""What a comment may mark besides a block: tables that scripts write."""


def _differences(wanted: str, found: str, page: str = "page") -> list[str]:
    """Return the lines in which an output is not the one that is shown."""
    lines = [update.without_round_off(text).splitlines() for text in (wanted, found)]
    return list(difflib.unified_diff(*lines, page, "played", lineterm=""))


def test_every_mark_has_its_block() -> None:
    for page, text in PAGES.items():
        marks = re.findall(r"^<!-- ([\w ]+).*-->$", text, re.MULTILINE)
        tables = [m.strip() for m in marks if m.strip().removeprefix("end of ") in TABLES]
        assert [m.split()[0] for m in marks if m.strip() not in tables] == [b.kind for b in BLOCKS[page]], page
        assert tables == [word for name in tables[::2] for word in (name, f"end of {name}")], page
        assert {b.kind for b in BLOCKS[page]} <= MARKS, page
    assert {b.kind for b in BLOCKS["README.md"]} == {"setup", "transcript", "file", "library"}
    assert {b.kind for found in BLOCKS.values() for b in found} == MARKS


def test_no_command_is_shown_unplayed() -> None:
    for page, text in PAGES.items():
        shown = re.findall(r"^\$ (.*)$", text, re.MULTILINE)
        assert shown == [c for b in BLOCKS[page] if b.kind == "transcript" for c in b.commands], page
    readme = {c.split()[1] for b in BLOCKS["README.md"] for c in b.commands}
    assert readme == {"plan", "gait", "batch"}
    assert {c.split()[1] for found in BLOCKS.values() for b in found for c in b.commands} >= {
        *readme, "verify", "plot", "design", "controllability",
    }  # fmt: skip


def test_every_command_and_option_that_is_shown_exists() -> None:
    known = known_options()
    shown = [(page, *found) for page, text in PAGES.items() for found in shown_commands(text)]
    assert {command for _, command, _ in shown} == set(known)
    for page, command, options in shown:
        assert set(options) <= known[command], (page, command, options)
    assert shown_commands("`purcell plan nearby --clearence 1`") == [("plan", ["--clearence"])]
    assert "--clearence" not in known["plan"]


@pytest.mark.slow
def test_transcripts_are_true() -> None:
    wrong = [
        line
        for page, transcripts in zip(PAGES, update.all_played(PAGES.values()), strict=True)
        for block, true in transcripts
        for line in _differences(block.body, true, page)
    ]
    assert not wrong, "\n".join([*wrong, "python tools/update_docs.py brings the pages up to date"])


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


def test_round_off_changes_no_transcript() -> None:
    """A line that has changed by more is renewed, and its neighbours stay to the letter."""
    page = "<!-- transcript -->\n```console\n$ purcell x\nplanned 1.0e-14\ntravel 2.5\nfound 0.0e+00\n```\n"
    (block,) = update.blocks(page)
    played = block.body.replace("1.0e-14", "9.9e-15").replace("0.0e+00", "3.1e-16")
    assert update.renewed(page, [(block, played)]) == page
    moved = played.replace("2.5", "2.6") + "more\n"
    assert update.renewed(page, [(block, moved)]) == page.replace("2.5", "2.6").replace("```\n", "more\n```\n")


PROGRAMS = [(page, block.body) for page, found in BLOCKS.items() for block in found if block.kind == "library"]


@pytest.mark.slow
@pytest.mark.parametrize(("page", "program"), PROGRAMS)
def test_programs_print_what_their_comments_say(page: str, program: str, tmp_path: Path) -> None:
    done = update.python(["-W", "error", "-c", program], tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    said = re.findall(r"^print\(.*\)  # (.*)$", program, re.MULTILINE)
    assert said
    assert done.stdout.splitlines() == said
    if page == "README.md":
        assert len(trajectory_reader.read_csv(tmp_path / "swim.csv").time_s) > 2


def test_set_up_is_one_line_each() -> None:
    run, test = only("README.md", "setup", "run"), only("README.md", "setup", "test")
    assert run == "python -m pip install . && purcell plan nearby\n"
    assert test == "python -m pip install -e '.[test]' && python -m pytest -n auto\n"
    assert "nearby" in builtin.stored_scenarios()
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert "purcell" in project["scripts"]
    assert any(name.startswith("pytest") for name in project["optional-dependencies"]["test"])


@pytest.mark.slow
@pytest.mark.parametrize("page", ["plans", "simulate", "track"])
def test_commands_of_a_guide_work_in_their_order_with_the_files_that_it_shows(
    page: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    text = PAGES[f"docs/how-to/{page}.md"]
    update.write_files(tmp_path, text)
    monkeypatch.chdir(tmp_path)
    commands = [line for block in re.findall(r"```sh\n(.*?)```", text, re.DOTALL) for line in block.splitlines()]
    assert len(commands) >= 2
    for command in commands:
        assert command.startswith("purcell ")
        assert _run(shlex.split(command)[1:]) == 0, command


def test_the_readme_is_short() -> None:
    assert len(README.splitlines()) <= 250


def test_files_that_are_shown_can_be_read(tmp_path: Path) -> None:
    readers = {
        "start.yaml": load_configuration, "goal.yaml": load_configuration, "u.yaml": load_configuration,
        "measured.yaml": load_configuration, "truth.yaml": load_swimmer, "beads.yaml": load_swimmer,
        "swimmer.yaml": load_swimmer, "thin.yaml": load_swimmer, "robot.yaml": load_swimmer,
        "across.yaml": load_scenario, "scenario.yaml": load_scenario, "ahead.yaml": load_scenario,
        "tour.yaml": load_scenario,
        "my-gaits/pitch-cruise.yaml": load_gait, "my-gaits/twist.yaml": load_gait,
        "servos.yaml": load_servo_map, "pulses.yaml": load_servo_map,
        "rolls.yaml": lambda path: find_cases([str(path)]).count == 4 or pytest.fail("wanted 4 scenarios"),
    }  # fmt: skip
    shown = set()
    for k, (page, text) in enumerate(PAGES.items()):
        folder = tmp_path / str(k)
        update.write_files(folder, text)
        for block in BLOCKS[page]:
            if block.kind == "file":
                readers[block.detail](folder / block.detail)
                shown.add(block.detail)
    assert shown == set(readers)
    gaits = PAGES["docs/how-to/gaits.md"]
    update.write_files(tmp_path, gaits)
    assert load_gait(tmp_path / "my-gaits" / "pitch-cruise.yaml").free
    assert load_gait(tmp_path / "my-gaits" / "twist.yaml").curve is not None


FILES_PAGE = "docs/reference/files.md"


def test_swimmer_file_shows_every_parameter_and_its_default(tmp_path: Path) -> None:
    update.write_files(tmp_path, PAGES[FILES_PAGE])
    assert load_swimmer(tmp_path / "swimmer.yaml") == Swimmer()
    keys = re.findall(r"^(\w+):", only(FILES_PAGE, "file", "swimmer.yaml"), re.MULTILINE)
    assert keys == [name for name, field in Swimmer.__dataclass_fields__.items() if field.default is not None]


def test_columns_are_those_of_the_file() -> None:
    columns = only("docs/reference/trajectory.md", "columns")
    assert "".join(columns.split()) == ",".join(trajectory_csv.COLUMNS)


def test_stored_scenarios_are_named() -> None:
    text = PAGES["docs/tutorials/first-plan.md"]
    sentence = re.search(r"Stored scenarios go by their names: (.*?)\n\n", text, re.DOTALL)
    assert set(re.findall(r"`([\w-]+)`", sentence[1])) == set(builtin.stored_scenarios())


def _unknown_modules(text: str) -> list[str]:
    names = re.findall(r"`(purcell_cli[\w.]*)`", text)
    return [name for name in names if importlib.util.find_spec(name) is None]


def test_modules_that_are_named_exist() -> None:
    table = re.search(
        r"^\| paper \| what \| module \|\n(?:\|.*\n)+", PAGES["docs/explanation/paper-to-code.md"], re.MULTILINE
    )[0]
    rows = table.splitlines()[2:]
    assert len(rows) >= 10
    assert all("`purcell_cli." in row.split("|")[3] for row in rows)
    assert {page: _unknown_modules(text) for page, text in PAGES.items() if _unknown_modules(text)} == {}
    assert _unknown_modules("| V-A | a flow | `purcell_cli.nowhere` |") == ["purcell_cli.nowhere"]


def test_links_lead_somewhere() -> None:
    """The README's; the site's own links are checked when it is built."""
    targets = re.findall(r"\]\(([^)#]+)", README)
    assert targets
    assert [t for t in targets if "://" not in t and not (ROOT / t).exists()] == []


def test_the_readme_leads_to_every_page() -> None:
    """But for those that exist on the site alone, and what stands beside the README."""
    linked = set(re.findall(r"\]\((docs/[^)#]+\.md)", README))
    assert set(PAGES) - linked == {
        "README.md", "docs/changelog.md", "docs/contributing.md", "docs/reference/library.md",
    }  # fmt: skip


def test_times_are_those_of_the_transcripts() -> None:
    """The table of the simultaneous controls against plans that are shown in full elsewhere."""
    page = PAGES["docs/how-to/simultaneous.md"]
    rows = {
        (r[0], r[1]): (r[2], r[3])
        for r in re.findall(r"^\| (.*?) \| ([\d.]+) \| ([\d.]+) \| ([\d.]+) \|$", page, re.MULTILINE)
    }
    assert len(rows) == 6
    assert all(float(quick) < float(slow) for slow, quick in rows.values())
    duration = r"^joint travel .* rad, ([\d.]+) s,"
    nearby = re.search(duration, README, re.MULTILINE)[1]
    ahead = re.search(duration, page, re.MULTILINE)[1]
    assert rows["`nearby`", "1"][0] == f"{float(nearby):.1f}"
    assert rows["20 L along x", "1"][1] == f"{float(ahead):.1f}"


def test_the_page_of_commands_names_every_command_and_option() -> None:
    text = tool("site_hooks").commands_page()
    sections = {part.partition("\n")[0]: part for part in text.split("\n## ")[1:]}
    known = known_options()
    assert set(sections) == set(known)
    for command, options in known.items():
        shown = re.findall(
            r"(?<!\S)`?(--[a-z][a-z-]*)", "\n".join(re.findall(r"^\| (.*?) \|", sections[command], re.MULTILINE))
        )
        assert set(shown) == {option for option in options if option.startswith("--")}, command


def test_the_library_page_has_every_public_name() -> None:
    import purcell_cli

    text = PAGES["docs/reference/library.md"]
    shown = set(re.findall(r"^::: purcell_cli\.(\w+)$", text, re.MULTILINE)) - {"errors"}
    assert shown == set(purcell_cli.__all__) - {"PurcellError"}
    assert "::: purcell_cli.errors" in text


def test_every_page_is_in_the_navigation() -> None:
    navigation = (ROOT / "mkdocs.yml").read_text(encoding="utf-8").partition("\nnav:\n")[2]
    listed = re.findall(r"([\w/-]+\.md)$", navigation, re.MULTILINE)
    pages = {path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md")} | {"reference/commands.md"}
    assert sorted(listed) == sorted(pages)
