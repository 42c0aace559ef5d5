"""The command verify."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from purcell_cli.cli.options import query_of
from purcell_cli.cli.terminal import DONE, NOT_REACHED, Json, SwimmerFile
from purcell_cli.cli.terminal import busy as _busy
from purcell_cli.cli.terminal import show as _show


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command(epilog="Example: purcell verify trajectory.csv start.yaml goal.yaml")(verify)


def verify(
    trajectory: Annotated[Path, typer.Argument(metavar="TRAJECTORY", help="A trajectory's CSV file.")],
    start: Annotated[
        str,
        typer.Argument(
            metavar="START", help="The start's YAML file; or, without GOAL, a scenario's file or stored name."
        ),
    ],
    goal: Annotated[str | None, typer.Argument(metavar="[GOAL]", help="The goal's YAML file.")] = None,
    swimmer: SwimmerFile = None,
    tolerance: Annotated[
        float, typer.Option("--tolerance", metavar="X", help="Largest error of position [L] and angles [rad].")
    ] = 1e-9,
    clearance: Annotated[
        float, typer.Option("--clearance", metavar="M", help="How far the limbs must stay apart [m].")
    ] = 0.0,
    json: Json = False,
) -> int:
    """Check a trajectory: replay its controls by an independent method from start to goal."""
    from purcell_cli.cli.reports.verify import show_verify, verify_document
    from purcell_cli.errors import ParameterError
    from purcell_cli.files.trajectory_csv import read_csv
    from purcell_cli.motion.options import OPTIONS
    from purcell_cli.verification.limits_kept import Wanted
    from purcell_cli.verification.verify import verify as check

    if not 0.0 < tolerance < 1.0:
        raise ParameterError(f"--tolerance: a number above 0 and below 1 is wanted, found {tolerance!r}")
    query = query_of(start, goal, swimmer)
    wanted = Wanted(OPTIONS["clearance_m"].checked(clearance, "--clearance"), query.workspace)
    parts = [read_csv(trajectory)]
    with _busy("re-integrating"):
        found = check(parts, query.start, query.goal, query.swimmer, tolerance, tolerance, wanted)
    _show(verify_document(found, query.swimmer), json, show_verify)
    return DONE if found.holds else NOT_REACHED
