"""What a trajectory's controls make of another swimmer, as a JSON document and as tables."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, cast

from purcell_cli.cli.documents.common import as_part
from purcell_cli.cli.documents.simulate import CoordinatesPart, LossPart, NoisePart, SimulateDocument
from purcell_cli.cli.reports.common import deviation_document, plain_table, swimmer_document
from purcell_cli.feedback.simulate import Simulation, off_by_coordinate
from purcell_cli.mechanics.swimmer import Swimmer

if TYPE_CHECKING:
    from rich.console import Console

_THERE = 1e-8
"""Distances [mm] and angles [deg] below this are not worth a person's while."""
_MOST_STROKES = 12
"""How many strokes are shown, those that lost most: as many as a screen has room for beside the rest."""


def simulate_document(found: Simulation, trajectory: str, model: Swimmer | None, out: str | None) -> SimulateDocument:
    """Return what a trajectory's controls make of another swimmer.

    Args:
        found: What they make of it.
        trajectory: The trajectory's file.
        model: Whose trajectory it is, where that is known.
        out: The file of what really happened, if there is one.
    """
    size = found.swimmer.length_m
    strokes: list[LossPart] = [
        {
            "phase": loss.phase,
            "gait": loss.gait,
            "begins_s": loss.begins_s,
            "ends_s": loss.ends_s,
            "position_m": loss.position_m,
            "position_over_L": loss.position_m / size,
            "angle_rad": loss.angle_rad,
        }
        for loss in found.losses
    ]
    return {
        "schema": "purcell/simulate/1",
        "verdict": "done",
        "trajectory": trajectory,
        "model": None if model is None else swimmer_document(model),
        "swimmer": swimmer_document(found.swimmer),
        "noise": as_part(found.noise, NoisePart),
        "slower_s": found.slower_s,
        "off": deviation_document(found.off, size),
        "coordinates": cast(CoordinatesPart, off_by_coordinate(found.end, found.planned)),
        "strokes": strokes,
        "worst_stroke": found.worst,
        "out": out,
    }


def show_simulate(console: Console, document: SimulateDocument) -> None:
    """Show what a trajectory's controls make of another swimmer."""
    table = plain_table("The end against the trajectory's")
    for heading in ("", "x [mm]", "y [mm]", "z [mm]", "psi [deg]", "theta [deg]", "phi [deg]"):
        table.add_column(heading, justify="right" if heading else "left", no_wrap=True)
    c = document["coordinates"]
    away = [_shown(1e3 * v) for v in c["position_m"]]
    for link, angles in (
        ("base", c["base_euler_rad"]),
        ("limb 1", c["limb1_euler_rad"]),
        ("limb 2", c["limb2_euler_rad"]),
    ):
        table.add_row(link, *(away if link == "base" else ["", "", ""]), *(_shown(math.degrees(v)) for v in angles))
    console.print(table)
    off = document["off"]
    angle = math.degrees(off["base_rad"])
    console.print(f"it ends {off['position_over_L']:.4g} L ({1e3 * off['position_m']:.4g} mm) and {angle:.4g} deg off")
    if document["slower_s"] > 0.0:
        console.print(f"its joints cannot follow the file in time: they take {document['slower_s']:.4g} s longer")
    if document["worst_stroke"] is not None:
        _show_strokes(console, document)
    if document["out"] is not None:
        console.print(f"what really happened is in {document['out']}", soft_wrap=True)


def _shown(value: float) -> str:
    return f"{value:+.4g}" if abs(value) > _THERE else "0"


def _show_strokes(console: Console, document: SimulateDocument) -> None:
    strokes = document["strokes"]
    order = sorted(range(len(strokes)), key=lambda k: -(strokes[k]["position_over_L"] + strokes[k]["angle_rad"]))
    table = plain_table("What strokes lost, those that lost most first")
    for heading in ("phase", "stroke", "from [s]", "to [s]", "moves the end by [L]", "turns it by [deg]"):
        table.add_column(heading, justify="left" if heading == "stroke" else "right")
    for k in order[:_MOST_STROKES]:
        s = strokes[k]
        lost = f"{s['position_over_L']:.3g}", f"{math.degrees(s['angle_rad']):.3g}"
        table.add_row(str(s["phase"]), s["gait"], f"{s['begins_s']:.4g}", f"{s['ends_s']:.4g}", *lost)
    console.print(table)
    if len(strokes) > _MOST_STROKES:
        console.print(f"and {len(strokes) - _MOST_STROKES} more")
