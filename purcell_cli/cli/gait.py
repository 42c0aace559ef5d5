"""The command gait."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from purcell_cli.cli.options import DT_DEFAULT_S, Dt, Format, MaxMemory, checked_memory, trajectory_file
from purcell_cli.cli.terminal import GaitFolder, Json, SwimmerFile, ready
from purcell_cli.cli.terminal import busy as _busy
from purcell_cli.cli.terminal import show as _show
from purcell_cli.cli.terminal import swimmer_of as _swimmer
from purcell_cli.motion.memory import DEFAULT_GB


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command(epilog="Example: purcell gait z-motion --amplitude 0.5 --cycles 3")(gait)


def gait(
    name: Annotated[
        str | None,
        typer.Argument(metavar="NAME", help="A stored gait: x, y, z, psi, theta, phi, ...; --list shows all."),
    ] = None,
    amplitude: Annotated[
        float | None,
        typer.Option(
            "--amplitude", metavar="RAD", help="Its amplitude; negative runs it backwards. Default: the gait's own."
        ),
    ] = None,
    cycles: Annotated[int, typer.Option("--cycles", metavar="N", min=1, max=1000000, help="How often to play it.")] = 1,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="The trajectory's file; default: NAME.csv.")
    ] = None,
    form: Format = None,
    swimmer: SwimmerFile = None,
    gaits: GaitFolder = None,
    dt: Dt = DT_DEFAULT_S,
    max_memory: MaxMemory = DEFAULT_GB,
    show_all: Annotated[bool, typer.Option("--list", help="Show all stored gaits, one line each.")] = False,
    atlas: Annotated[bool, typer.Option("--all", help="Show what one cycle of every stored gait does.")] = False,
    sweep: Annotated[
        str | None,
        typer.Option("--sweep", metavar="A:B:STEP", help="Show displacement against amplitude, exact and predicted."),
    ] = None,
    link_ratio: Annotated[
        str | None,
        typer.Option("--link-ratio", metavar="A:B:STEP", help="The same against the ratio of middle to outer link."),
    ] = None,
    json: Json = False,
) -> None:
    """Play a stored gait from the collinear shape, show what it does, and write it as CSV."""
    from purcell_cli.cli import atlas as many_strokes
    from purcell_cli.cli.reports import atlas as many_reports
    from purcell_cli.cli.reports import gait as report
    from purcell_cli.errors import InputError
    from purcell_cli.files.atomic_file import writable
    from purcell_cli.files.builtin import stored_gaits
    from purcell_cli.files.trajectory_formats import write_trajectory
    from purcell_cli.gaits.gait import find
    from purcell_cli.gaits.joint_fit import refuse_joints
    from purcell_cli.gaits.pure_stroke import fault, realise
    from purcell_cli.gaits.sampling import sample_stroke
    from purcell_cli.mechanics.configuration import Configuration

    stored = stored_gaits(gaits)
    if show_all:
        _show(report.gait_list_document(list(stored.values())), json, report.show_gait_list)
        return
    if sum((atlas, sweep is not None, link_ratio is not None)) > 1:
        raise InputError("one of --all, --sweep and --link-ratio is wanted, found more")
    if out is not None and (atlas or sweep is not None or link_ratio is not None):
        writable(out, "--out", ("csv",))
    if atlas:
        with _busy("swimming"):
            every = many_strokes.atlas(stored, _swimmer(swimmer), out)
        _show(every, json, many_reports.show_atlas)
        return
    if name is None:
        raise InputError("a gait's name is wanted; purcell gait --list shows all")
    body = ready(_swimmer(swimmer))
    chosen = find(stored, name)
    if sweep is not None:
        with _busy("swimming"):
            swept = many_strokes.amplitudes(chosen, body, sweep, out)
        _show(swept, json, many_reports.show_sweep)
        return
    if link_ratio is not None:
        with _busy("swimming"):
            compared = many_strokes.ratios(chosen, body, amplitude, link_ratio, out)
        _show(compared, json, many_reports.show_ratios)
        return
    stroke = realise(chosen, body, amplitude)
    refuse_joints(body, stroke, cycles)
    if why := fault(stroke, chosen.moves, body):
        print(f"gait {chosen.name} is said to move {chosen.moves}, but {why}", file=sys.stderr)
    form, file = trajectory_file(out, form, chosen.name)
    with _busy("swimming"):
        document = report.gait_document(chosen, stroke, body, cycles, str(file))
        rows = sample_stroke(body, Configuration(), stroke, cycles, dt, checked_memory(max_memory))
        write_trajectory(rows, file, form, body)
    _show(document, json, report.show_gait)
