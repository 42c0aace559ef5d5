"""The command purcell controllability: what a shape lets the swimmer reach, and where it is weak."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from purcell_cli.cli.terminal import DONE, NOT_REACHED, Json, SwimmerFile, busy, ready, show, swimmer_of

if TYPE_CHECKING:
    from purcell_cli.mechanics.swimmer import Swimmer

_BENDS_DEG = (0, 2, 5, 15, 30, 45, 60, 75, 90, 105, 120)
"""Bends of both limbs that the map shows [deg]: close together near 0, where the weakest direction changes most."""

_ROLLS_DEG = (0, 45, 90, 135, 180)
"""Rolls of limb 2's bend about the base against limb 1's that the map shows [deg]; beyond 180 they repeat."""

_MAP_DEPTH = 3
"""Depth of the map's brackets where none is asked for: at 2 the collinear shape
reaches 4 of the 6 directions, at 3 every shape of the map reaches all."""


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command(epilog="Example: purcell controllability, or purcell controllability --map --plot weak.svg")(
        controllability
    )


def controllability(
    shape: Annotated[
        Path | None,
        typer.Option(
            "--shape",
            metavar="FILE",
            help="A YAML file with limb1 and limb2 as in a start's, and beside a wall with base; default: collinear.",
        ),
    ] = None,
    swimmer: SwimmerFile = None,
    depth: Annotated[
        int | None,
        typer.Option(
            "--depth",
            metavar="K",
            help="The deepest brackets, 2 to 6; default: 4, 5 or 6 where three controls or fewer turn, of --map 3.",
        ),
    ] = None,
    planar: Annotated[
        bool, typer.Option("--planar", help="Let the yaw joints alone turn: the planar swimmer.")
    ] = False,
    over: Annotated[
        bool, typer.Option("--map", help="Show how weak the weakest direction is over bends and rolls.")
    ] = False,
    plot: Annotated[
        Path | None, typer.Option("--plot", metavar="FILE", help="Draw the map too: png, svg or pdf.")
    ] = None,
    json: Json = False,
) -> int:
    """Show what the swimmer can reach near a shape, by Lie brackets of its controls."""
    from purcell_cli.cli.reports import controllability as report
    from purcell_cli.errors import InputError
    from purcell_cli.files.configuration_file import load_configuration
    from purcell_cli.lie_brackets.controllability import checked_depth
    from purcell_cli.lie_brackets.controllability import controllability as analysed
    from purcell_cli.lie_brackets.joint_reach import usual_depth
    from purcell_cli.mechanics.configuration import Configuration

    body = swimmer_of(swimmer)
    if over:
        if shape is not None or planar:
            raise InputError("--map: wanted without --shape and --planar, found with one of them")
        return _map(body, checked_depth(_MAP_DEPTH if depth is None else depth), plot, json)
    if plot is not None:
        raise InputError("--plot: wanted with --map, found without")
    at = Configuration() if shape is None else load_configuration(shape)
    deepest = checked_depth(usual_depth(body) if depth is None else depth)
    ready(body, walled=True)
    with busy("taking brackets"):
        found = analysed(body, at.shape, deepest, planar, at.pose)
        document = report.controllability_document(found, planar, deepest)
    show(document, json, report.show_controllability)
    return DONE if found.verdict in {"controllable", "weakly controllable"} else NOT_REACHED


def _map(body: Swimmer, depth: int, picture: Path | None, json: bool) -> int:
    import math

    from purcell_cli.cli.reports import controllability as report
    from purcell_cli.files.atomic_file import writable
    from purcell_cli.lie_brackets.weak_shapes import strengths
    from purcell_cli.mechanics.bead_table import REACH_RAD

    if picture is not None:
        from purcell_cli.pictures.style import picture_format
        from purcell_cli.pictures.weakness_map import draw_map

        writable(picture, "--plot")
        picture_format(picture)
    known = body.fluid != "beads"
    bends = [bend for b in _BENDS_DEG if (bend := math.radians(b)) <= REACH_RAD or known]
    with busy("taking brackets"):
        found = strengths(body, bends, [math.radians(r) for r in _ROLLS_DEG], depth)
        document = report.map_document(found, body, depth, None if picture is None else str(picture))
        if picture is not None:
            draw_map(found, depth, picture)
    show(document, json, report.show_map)
    return DONE
