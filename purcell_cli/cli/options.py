"""Options and arguments that several commands share."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from purcell_cli.cli.terminal import swimmer_of as _swimmer

if TYPE_CHECKING:
    from purcell_cli.files.scenario_file import Scenario

Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="FILE", help="The trajectory's file; default: trajectory.csv, or another ending."),
]


Format = Annotated[
    str | None,
    typer.Option(
        "--format", metavar="NAME", help="csv, parquet, npz or tum; default: by the ending of --out, else csv."
    ),
]


Dt = Annotated[float, typer.Option("--dt", metavar="SECONDS", help="Longest time between rows.")]


def query_of(start: str, goal: str | None, swimmer: Path | None) -> Scenario:
    """Return what is asked for: two files as a scenario, or a scenario, with the swimmer of the option."""
    from purcell_cli.files.builtin import find_scenario
    from purcell_cli.files.configuration_file import load_configuration, load_goal
    from purcell_cli.files.scenario_file import Scenario

    if goal is not None:
        begin, end = load_configuration(start), load_goal(goal)
        return Scenario("query", begin, end.configuration, _swimmer(swimmer), workspace=end.workspace)
    scenario = find_scenario(start)
    return scenario if swimmer is None else dataclasses.replace(scenario, swimmer=_swimmer(swimmer))
