"""The command track."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from purcell_cli.cli.options import Clearance, Format
from purcell_cli.cli.terminal import DONE, NOT_REACHED, Json, SwimmerFile, bar, ready, show, swimmer_of

if TYPE_CHECKING:
    from purcell_cli.motion.trajectory import Trajectory


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command(epilog="Example: purcell track start.yaml goal.yaml --truth beads.yaml --out real.csv")(track)


def track(
    start: Annotated[
        str,
        typer.Argument(
            metavar="START", help="The start's YAML file; or, without GOAL, a scenario's file or stored name."
        ),
    ],
    truth: Annotated[
        Path, typer.Option("--truth", metavar="FILE", help="The swimmer that really swims: its YAML file.")
    ],
    goal: Annotated[str | None, typer.Argument(metavar="GOAL", help="The goal's YAML file.")] = None,
    swimmer: SwimmerFile = None,
    replans: Annotated[
        int, typer.Option("--replans", metavar="N", help="Plan again so often at most, in each leg of a mission.")
    ] = 10,
    noise: Annotated[
        str,
        typer.Option(
            "--noise",
            metavar="NAME=SIZE,...",
            help="Standard deviations of measurements: position_l of the base's position [L], base_deg. "
            "at_rest: how often it is measured where it rests (4).",
        ),
    ] = "",
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Seed of the noise.")] = 0,
    tolerance: Annotated[
        float, typer.Option("--tolerance", metavar="X", help="Largest error of the position where it stops [L].")
    ] = 1e-3,
    tolerance_deg: Annotated[
        float, typer.Option("--tolerance-deg", metavar="X", help="Largest error of angles where it stops [deg].")
    ] = 0.1,
    clearance: Clearance = 0.0,
    learn: Annotated[
        bool, typer.Option("--learn", help="Fit links' drag to what was measured, and plan the rest with it.")
    ] = False,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="Write what really happened, as a trajectory.")
    ] = None,
    form: Format = None,
    json: Json = False,
) -> int:
    """Plan on a model, swim on the truth, measure, plan again, until the goal, or each leg of a mission, is reached."""
    from purcell_cli.cli.options import in_files, query_files, query_of, trajectory_file
    from purcell_cli.cli.reports.track import show_track, track_document
    from purcell_cli.errors import ParameterError
    from purcell_cli.feedback.learn import Learning
    from purcell_cli.feedback.measured import Measuring
    from purcell_cli.feedback.track import Tracking
    from purcell_cli.feedback.track_mission import track_mission
    from purcell_cli.files.scenario_file import warn_if_far
    from purcell_cli.files.trajectory_csv import goes_on
    from purcell_cli.files.trajectory_formats import write_trajectory
    from purcell_cli.motion.options import PlanOptions

    for name, value, most in (("--tolerance", tolerance, 1.0), ("--tolerance-deg", tolerance_deg, 45.0)):
        if not 0.0 < value < most:
            raise ParameterError(f"{name}: a number above 0 and below {most:g} is wanted, found {value!r}")
    query, measuring = query_of(start, goal, swimmer), Measuring.of_text(noise, seed)
    named = None if out is None else trajectory_file(out, form, "")
    body = ready(swimmer_of(truth), walled=True)
    warn_if_far(query)
    ready(query.swimmer)

    def further(swum: Trajectory) -> bool:
        """Return whether the same command has written more already, before it was broken off."""
        return named is not None and named[0] == "csv" and goes_on(named[1], swum)

    with bar("swimming") as progress, in_files(**query_files(start, goal, swimmer)):

        def told(found: Tracking) -> None:
            progress(found.replans, replans, f"off by {found.off.position_m / query.swimmer.length_m:.2g} L")
            if named is not None and found.trajectory is not None and not further(found.trajectory):
                write_trajectory(found.trajectory, named[1], named[0], body)

        found = track_mission(
            query.mission,
            body,
            model=query.swimmer,
            options=PlanOptions(workspace=query.workspace, obstacles=query.obstacles, clearance_m=clearance),
            replans=replans,
            measuring=measuring,
            tolerance_l=tolerance,
            tolerance_rad=math.radians(tolerance_deg),
            told=told,
            **({"fitted": Learning(query.swimmer, measuring)} if learn else {}),
        )
    file = None
    if named is not None and found.trajectory is not None:
        file = str(named[1])
        if further(found.trajectory):  # of a longer way that begins alike
            write_trajectory(found.trajectory, named[1], named[0], body)
    document = track_document(found, query.swimmer, measuring, tolerance, tolerance_deg, file)
    show(document, json, show_track)
    return DONE if found.arrived else NOT_REACHED
