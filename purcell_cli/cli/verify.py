"""The command verify."""

from __future__ import annotations

import dataclasses
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from purcell_cli.cli.options import in_files, query_files, query_of
from purcell_cli.cli.terminal import DONE, NOT_REACHED, Json, SwimmerFile, bar, ready, swimmer_of
from purcell_cli.cli.terminal import show as _show

if TYPE_CHECKING:
    from purcell_cli.files.scenario_file import Scenario

_PATIENCE_S, _MB = 2.0, 1_000_000
"""How long a check, but for --full, lasts before a bar is shown [s], which counts these parts of the file [bytes]."""


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command(epilog="Example: purcell verify trajectory.csv start.yaml goal.yaml")(verify)


def verify(
    trajectory: Annotated[Path, typer.Argument(metavar="TRAJECTORY", help="A trajectory's CSV file.")],
    start: Annotated[
        str,
        typer.Argument(
            metavar="START",
            help="The start's YAML file; or, without GOAL, a scenario's file or stored name, or a plan document.",
        ),
    ],
    goal: Annotated[str | None, typer.Argument(metavar="GOAL", help="The goal's YAML file.")] = None,
    swimmer: SwimmerFile = None,
    tolerance: Annotated[
        float, typer.Option("--tolerance", metavar="X", help="Largest error of position [L] and angles [rad].")
    ] = 1e-9,
    clearance: Annotated[
        float | None,
        typer.Option(
            "--clearance",
            metavar="METRES",
            help="How far limbs must stay apart, and links from obstacles [m]; default: 0, or the plan document's.",
        ),
    ] = None,
    full: Annotated[
        bool,
        typer.Option(
            "--full", help="Of links that feel each other: solve the beads anew at each step; takes minutes, 1e-7 off."
        ),
    ] = False,
    json: Json = False,
) -> int:
    """Check a trajectory: replay its controls by an independent method from start to goal."""
    from purcell_cli.cli.reports.verify import show_verify, verify_document
    from purcell_cli.errors import ParameterError, PurcellWarning
    from purcell_cli.files.trajectory_reader import read_parts
    from purcell_cli.mechanics.bead_table import tabulated
    from purcell_cli.mechanics.beads import solved_anew
    from purcell_cli.motion.options import OPTIONS
    from purcell_cli.verification.limits_kept import Wanted
    from purcell_cli.verification.verify import verify as check

    if not 0.0 < tolerance < 1.0:
        raise ParameterError(f"--tolerance: a number above 0 and below 1 is wanted, found {tolerance!r}")
    if start.lower().endswith(".csv"):
        raise ParameterError(
            f"START: a YAML file or a scenario's name is wanted, found {start}; the trajectory comes first"
        )
    query, apart_m = _query(start, goal, swimmer)
    if clearance is not None:
        apart_m = OPTIONS["clearance_m"].checked(clearance, "--clearance")
    if full and query.swimmer.fluid != "beads":
        text = "--full changes nothing: this swimmer's links are alone in the fluid, there are no beads to solve"
        warnings.warn(text, PurcellWarning, stacklevel=2)
    wanted = Wanted(apart_m, query.workspace, query.obstacles, query.follow, query.via, query.order)
    ready(query.swimmer)
    resistances = solved_anew if full else tabulated
    with bar("re-integrating", 0.0 if full else _PATIENCE_S) as told, in_files(**query_files(start, goal, swimmer)):
        rows = read_parts(trajectory, lambda done, size: told(done // _MB, size // _MB, "MB"))
        bounds = tolerance, tolerance, wanted
        found = check(rows, query.start, query.goal, query.swimmer, *bounds, resistances)
    _show(verify_document(found, query.swimmer), json, show_verify)
    return DONE if found.holds else NOT_REACHED


def _query(start: str, goal: str | None, swimmer: Path | None) -> tuple[Scenario, float]:
    """Return what the trajectory is to do, and the clearance that it must keep [m]; a plan document says both."""
    from purcell_cli.files.plan_file import is_plan, load_plan
    from purcell_cli.files.scenario_file import Scenario

    if goal is not None or not is_plan(start):
        return query_of(start, goal, swimmer), 0.0
    saved = load_plan(start)
    body = saved.plan.swimmer if swimmer is None else swimmer_of(swimmer)
    plan, asked = saved.plan, saved.options
    via = tuple(passage.waypoint for passage in plan.passages)
    query = Scenario("plan", plan.start, plan.goal, body, workspace=asked.workspace, via=via)
    query = dataclasses.replace(query, follow=plan.follow, obstacles=asked.obstacles)
    return query, asked.clearance_m
