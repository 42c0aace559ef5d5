"""The command replan."""

from __future__ import annotations

import contextlib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from purcell_cli.cli.options import Format, Out, in_files, trajectory_file
from purcell_cli.cli.plan import show_solution
from purcell_cli.cli.terminal import Json, bar, ready

if TYPE_CHECKING:
    from purcell_cli.cli.documents.plan import PlanDocument


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command(epilog="Example: purcell replan --from measured.yaml plan.json --out rest.csv")(replan)


def replan(
    document: Annotated[
        Path, typer.Argument(metavar="PLAN", help="A plan document, as purcell plan --plan-out writes it.")
    ],
    measured: Annotated[
        str,
        typer.Option("--from", metavar="FILE", help="Where the swimmer was measured to be: the YAML file of a start."),
    ],
    after: Annotated[
        float, typer.Option("--after", metavar="SECONDS", help="The plan was swum up to this time at least.")
    ] = 0.0,
    out: Out = None,
    form: Format = None,
    plan_out: Annotated[
        Path | None, typer.Option("--plan-out", metavar="FILE", help="Write the rest as a plan document too.")
    ] = None,
    json: Json = False,
) -> int:
    """Plan the rest of a plan from where the swimmer was measured to be."""
    from purcell_cli.cli.reports.plan import plan_document
    from purcell_cli.feedback.replan import done_by, refuse_time
    from purcell_cli.feedback.replan_mission import replan_once
    from purcell_cli.files.atomic_file import whole_file, writable
    from purcell_cli.files.configuration_file import load_configuration
    from purcell_cli.files.plan_file import PlanDocument as Saved
    from purcell_cli.files.plan_file import load_plan
    from purcell_cli.files.trajectory_formats import write_trajectory

    here, saved = load_configuration(measured), load_plan(document)
    form, file = trajectory_file(out, form, "trajectory")
    if plan_out is not None:
        writable(plan_out, "--plan-out", ("json",))
    refuse_time(saved.plan, after)
    ready(saved.plan.swimmer)
    with bar("planning") as progress:
        with in_files(measured=measured, goal=document):
            found = replan_once(
                saved.plan, here, saved.options, after_rad=done_by(saved.plan, after), progress=progress
            )
        solution = found.solution
        told: PlanDocument = {
            **plan_document(solution, str(file), None if plan_out is None else str(plan_out), "replan"),
            "rest": {
                "kept": found.kept,
                "off_way": found.off,
                "done_rad": found.done_rad,
                "left_rad": found.left_rad,
            },
        }
        with contextlib.ExitStack() as both:
            if plan_out is not None:  # it appears only when the trajectory has
                both.enter_context(whole_file(plan_out)).write(
                    Saved(solution.plan, saved.options).as_text(plan_out.parent).encode()
                )
            write_trajectory(solution.trajectory, file, form, solution.plan.swimmer)
    return show_solution(solution, told, json, explain=False)
