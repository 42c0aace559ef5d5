"""The command `purcell design`."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated

import typer

from purcell_cli.cli.terminal import Json, SwimmerFile, bar, ready, show, swimmer_of
from purcell_cli.wording import ANGLES

_EPILOG = "Example: purcell design --direction x --max-bend 2.5 --out my-gait.yaml; Ctrl-C takes the best so far."


def register(app: typer.Typer) -> None:
    """Add the command to an app."""
    app.command(epilog=_EPILOG)(design)


def design(
    direction: Annotated[
        str,
        typer.Option("--direction", metavar="WHAT", help="x, y, z, psi, theta or phi; turns may advance."),
    ] = "x",
    maximize: Annotated[
        str,
        typer.Option("--maximize", metavar="WHAT", help="speed, by joint travel; or efficiency, by dissipation."),
    ] = "speed",
    max_bend: Annotated[
        float | None,
        typer.Option(
            "--max-bend", metavar="RAD", help="Limit of the bends; default: the swimmer's, and in its ranges."
        ),
    ] = None,
    planar: Annotated[bool, typer.Option("--planar/--spatial", help="Bend in one plane, or anyhow.")] = True,
    controls: Annotated[
        str,
        typer.Option("--controls", metavar="HOW", help="simultaneous: all joints in a move; or primitive: one."),
    ] = "simultaneous",
    moves: Annotated[int, typer.Option("--moves", metavar="N", help="Moves in a cycle, 3 to 64.")] = 12,
    starts: Annotated[int, typer.Option("--starts", metavar="N", help="Random starts.")] = 4,
    seed: Annotated[int, typer.Option("--seed", metavar="N", min=0, help="Seed of the starts.")] = 0,
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="The gait's YAML file.")] = Path("my-gait.yaml"),
    swimmer: SwimmerFile = None,
    json: Json = False,
) -> None:
    """Design a closed stroke that does most for its cost, and write it as a gait that purcell gait plays."""
    import dataclasses

    from purcell_cli.cli.reports import design
    from purcell_cli.files.atomic_file import writable
    from purcell_cli.files.gait_file import write_gait
    from purcell_cli.gaits.design import design as search
    from purcell_cli.gaits.design_problem import DesignTask
    from purcell_cli.gaits.joint_fit import bend_room_rad

    body = ready(swimmer_of(swimmer))
    task = DesignTask(ANGLES.get(direction, direction), maximize, 1.0, planar, controls, moves)
    limit = min(body.max_bend_rad, bend_room_rad(body, task.axis)) if max_bend is None else max_bend
    task = dataclasses.replace(task, max_bend_rad=limit)
    writable(out, "--out", ("yaml", "yml"))
    name = re.sub(r"[^A-Za-z0-9._-]", "-", out.stem).lstrip(".")[:100] or "designed"
    with bar("designing") as report:
        found = search(body, task, name, starts, seed, lambda done, news: report(done, starts, f"best: {news}"))
    write_gait(found.gait, out)
    document = design.design_document(found, body, str(out), interrupted=found.starts < starts)
    show(document, json, design.show_design)
