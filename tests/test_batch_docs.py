"""The page on batches, the workflows and the templates cannot lie: what they show parses, and every option exists."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
import yaml

from purcell_cli.batch.cases import find_cases
from purcell_cli.batch.summary import COLUMNS
from purcell_cli.cli.app import app
from purcell_cli.files.scenario_file import EXPECT

ROOT = Path(__file__).resolve().parent.parent
PAGE = (ROOT / "docs" / "batch.md").read_text(encoding="utf-8")
WORKFLOW = (ROOT / ".github" / "workflows" / "ci.yml").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```yaml\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)


def options(command: str) -> set[str]:
    """Return the options of a command."""
    import typer

    known = typer.main.get_command(app).commands[command]
    return {"--help"} | {
        option for parameter in known.params for option in (*parameter.opts, *parameter.secondary_opts)
    }


@pytest.mark.slow
def test_every_command_and_option_that_is_shown_exists() -> None:
    shown = re.findall(r"purcell (batch|validate|schema|init|plan|run) ?([^`|\n]*)", PAGE + WORKFLOW)
    assert {command for command, _ in shown} >= {"batch", "validate", "schema", "init"}
    for command, rest in shown:
        assert set(re.findall(r"(?<!\S)--[a-z-]+", rest)) <= options(command), (command, rest)
    for option in re.findall(r"`(--[a-z-]+)[^`]*`", PAGE):
        assert option in options("batch") | options("schema") | {"--install-completion", "--nthreads"}, option


def test_scenarios_that_are_shown_can_be_read(tmp_path: Path) -> None:
    scenarios = [block for block in BLOCKS if "name:" in block and "jobs:" not in block]
    assert len(scenarios) == 2
    for k, text in enumerate(scenarios):
        (tmp_path / f"{k}.yaml").write_text(text)
    cases = find_cases([str(tmp_path)])
    assert cases.count == 34
    assert all(case.scenario is not None for case in cases)


@pytest.mark.parametrize("text", [WORKFLOW, next(block for block in BLOCKS if "jobs:" in block)])
def test_workflows_are_yaml_and_every_job_has_steps(text: str) -> None:
    workflow = yaml.safe_load(text)
    for job in workflow["jobs"].values():
        assert job["runs-on"]
        assert all(("uses" in step) != ("run" in step) for step in job["steps"])


def test_the_page_names_every_expectation_and_no_other() -> None:
    table = PAGE.partition("| key of `expect` |")[2].partition("\n\n")[0]
    assert re.findall(r"^\| `(\w+)`", table, re.MULTILINE) == [
        "verdict",
        "error",
        "position_tolerance",
        "angle_tolerance_rad",
        "max_joint_travel_rad",
        "max_duration_s",
        "min_clearance_m",
    ]
    properties = EXPECT.json_schema()["properties"]
    assert isinstance(properties, dict)
    assert set(re.findall(r"^\| `(\w+)`", table, re.MULTILINE)) == set(properties)
    assert [column for column in COLUMNS if "wall" in column] == ["wall_time_s"]
