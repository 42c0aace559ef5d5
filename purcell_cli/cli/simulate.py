"""The command simulate."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from purcell_cli.cli.options import Format, MaxMemory, checked_memory, in_files, trajectory_file
from purcell_cli.cli.terminal import Json, busy, ready, show, swimmer_of
from purcell_cli.motion.memory import DEFAULT_GB

if TYPE_CHECKING:
    from purcell_cli.mechanics.swimmer import Swimmer
    from purcell_cli.motion.trajectory_table import Table


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command(epilog="Example: purcell simulate trajectory.csv --swimmer truth.yaml --noise rate=0.02")(simulate)


def simulate(
    trajectory: Annotated[
        Path, typer.Argument(metavar="TRAJECTORY", help="A trajectory's CSV file, or a plan document.")
    ],
    swimmer: Annotated[
        Path,
        typer.Option("--swimmer", metavar="FILE", help="The swimmer that really swims: its YAML file."),
    ],
    model: Annotated[
        Path | None,
        typer.Option(
            "--model",
            metavar="FILE",
            help="Whose trajectory it is: a swimmer's YAML file or a plan document; default: the plan document's.",
        ),
    ] = None,
    noise: Annotated[
        str,
        typer.Option(
            "--noise",
            metavar="NAME=SIZE,...",
            help="Standard deviations: angle_deg of the joints' zeros, rate (a part of it), drift_m_s of a stream.",
        ),
    ] = "",
    seed: Annotated[int, typer.Option("--seed", metavar="N", help="Seed of the noise.")] = 0,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="Write what really happened, as a trajectory.")
    ] = None,
    form: Format = None,
    max_memory: MaxMemory = DEFAULT_GB,
    json: Json = False,
) -> None:
    """Play a trajectory's controls on another swimmer: where it ends, and which stroke lost most."""
    from purcell_cli.cli.reports.simulate import show_simulate, simulate_document
    from purcell_cli.feedback.noise import Noise
    from purcell_cli.feedback.simulate import refuse_other_joints
    from purcell_cli.feedback.simulate import simulate as simulated
    from purcell_cli.files.trajectory_formats import write_trajectory

    disturbance = Noise.of(noise, seed)
    named = None if out is None else trajectory_file(out, form, "")
    truth = ready(swimmer_of(swimmer), walled=True)
    table, body = _planned(trajectory, model, checked_memory(max_memory))
    if body is not None:
        refuse_other_joints(body, truth)
    with busy("integrating"), in_files(line=trajectory):
        found = simulated(table, truth, disturbance)
    if named is not None:
        write_trajectory(found.trajectory, named[1], named[0], truth)
    written = None if named is None else str(named[1])
    show(simulate_document(found, str(trajectory), body, written), json, show_simulate)


def _planned(trajectory: Path, model: Path | None, memory_gb: float) -> tuple[Table, Swimmer | None]:
    """Return the trajectory, and whose it is, where that is known."""
    from purcell_cli.files.plan_file import is_plan, load_plan
    from purcell_cli.files.trajectory_reader import read_csv
    from purcell_cli.motion.trajectory import as_table
    from purcell_cli.solution import carried_out

    if not is_plan(trajectory):
        return read_csv(trajectory, memory_gb), None if model is None else swimmer_of(model)
    saved = load_plan(trajectory)
    plan = saved.plan if model is None else dataclasses.replace(saved.plan, swimmer=swimmer_of(model))
    options = dataclasses.replace(saved.options, max_memory_gb=memory_gb)
    return as_table(carried_out(plan, options).trajectory), plan.swimmer
