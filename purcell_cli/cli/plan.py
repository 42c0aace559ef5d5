"""The commands plan and run."""

from __future__ import annotations

import contextlib
import dataclasses
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from purcell_cli.cli.options import Format, Out, in_files, query_files, query_of, takes_plan_options, trajectory_file
from purcell_cli.cli.terminal import DONE, NOT_REACHED, GaitFolder, Json, SwimmerFile, ready
from purcell_cli.cli.terminal import bar as _bar
from purcell_cli.cli.terminal import busy as _busy
from purcell_cli.cli.terminal import show as _show
from purcell_cli.motion.options import PlanOptions
from purcell_cli.motion.verdict import Verdict

if TYPE_CHECKING:
    from rich.console import Console

    from purcell_cli.cli.documents.plan import PlanDocument
    from purcell_cli.solution import Solution

Explain = Annotated[
    bool, typer.Option("--explain", help="Say what each stroke is for, what limits it and what would upset the plan.")
]


def register(app: typer.Typer) -> None:
    """Add the commands to the command line."""
    app.command(epilog="Example: purcell plan start.yaml goal.yaml --out swim.csv")(plan)
    app.command(epilog="Example: purcell plan nearby --plan-out plan.json, then purcell run plan.json --out again.csv")(
        run
    )


def show_solution(solution: Solution, document: PlanDocument, json: bool, explain: bool) -> int:
    """Show a plan that was carried out, and why it is as it is; return the exit code."""
    from purcell_cli.cli.reports.plan import show_plan

    if not explain:
        _show(document, json, show_plan)
    else:
        from purcell_cli.cli.reports.explanation import explanation_document, show_explanation
        from purcell_cli.explanation import explain as explained

        def show(console: Console, told: PlanDocument) -> None:
            show_plan(console, told)
            show_explanation(console, told)

        reasons = explanation_document(explained(solution), solution.plan.swimmer)
        explained_document: PlanDocument = {**document, "explanation": reasons}
        _show(explained_document, json, show)
    return DONE if solution.verdict == Verdict.REACHED else NOT_REACHED


@takes_plan_options
def plan(
    start: Annotated[
        str,
        typer.Argument(
            metavar="START", help="The start's YAML file; or, without GOAL, a scenario's file or stored name."
        ),
    ],
    goal: Annotated[str | None, typer.Argument(metavar="GOAL", help="The goal's YAML file.")] = None,
    out: Out = None,
    form: Format = None,
    swimmer: SwimmerFile = None,
    gaits: GaitFolder = None,
    options: PlanOptions = PlanOptions(),
    plan_out: Annotated[
        Path | None,
        typer.Option("--plan-out", metavar="FILE", help="Write the plan itself too, as JSON for purcell run."),
    ] = None,
    explain: Explain = False,
    json: Json = False,
) -> int:
    """Plan a motion from a start to a goal configuration and write it as CSV."""
    with _bar("planning") as progress:
        from purcell_cli.cli.reports.plan import plan_document
        from purcell_cli.files.atomic_file import whole_file, writable
        from purcell_cli.files.builtin import stored_gaits
        from purcell_cli.files.plan_file import PlanDocument as Saved
        from purcell_cli.files.scenario_file import warn_if_far
        from purcell_cli.files.trajectory_formats import write_trajectory
        from purcell_cli.missions import plan_mission

        query = query_of(start, goal, swimmer)
        form, file = trajectory_file(out, form, "trajectory")
        if plan_out is not None:
            writable(plan_out, "--plan-out", ("json",))
        with in_files(**query_files(start, goal, swimmer)):
            solution = plan_mission(
                query.mission,
                swimmer=query.swimmer,
                options=dataclasses.replace(options, workspace=query.workspace, obstacles=query.obstacles),
                gaits=stored_gaits(gaits),
                progress=progress,
            )
        for name, why in solution.plan.left_out.items():
            print(f"gait {name} is left out: {why}", file=sys.stderr)
        if (blocked := solution.plan.blocked) is not None:
            of = f" on leg {blocked.leg + 1}" if solution.plan.passages else ""
            print(f"no way round obstacles{of}: {blocked.words}", file=sys.stderr)
        warn_if_far(query)
        document = plan_document(solution, str(file), None if plan_out is None else str(plan_out))
        with contextlib.ExitStack() as both:
            if plan_out is not None:  # it appears only when the trajectory has
                text = Saved(solution.plan, solution.options).as_text(plan_out.parent)
                both.enter_context(whole_file(plan_out)).write(text.encode())
            write_trajectory(solution.trajectory, file, form, solution.plan.swimmer)
    return show_solution(solution, document, json, explain)


def run(
    document: Annotated[
        Path, typer.Argument(metavar="PLAN", help="A plan document, as purcell plan --plan-out writes it.")
    ],
    out: Out = None,
    form: Format = None,
    explain: Explain = False,
    json: Json = False,
) -> int:
    """Play a plan again from its document: the same trajectory, checked anew."""
    from purcell_cli.cli.reports.plan import plan_document
    from purcell_cli.files.plan_file import load_plan
    from purcell_cli.files.trajectory_formats import write_trajectory
    from purcell_cli.solution import carried_out

    saved = load_plan(document)
    form, file = trajectory_file(out, form, "trajectory")
    ready(saved.plan.swimmer)
    with _busy("swimming"):
        solution = carried_out(saved.plan, saved.options)
        told = plan_document(solution, str(file), str(document), "run")
        write_trajectory(solution.trajectory, file, form, solution.plan.swimmer)
    return show_solution(solution, told, json, explain)
