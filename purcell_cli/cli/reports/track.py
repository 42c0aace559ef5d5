"""A way that was swum in parts, as a JSON document and as a table."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from purcell_cli.cli.documents.common import as_part
from purcell_cli.cli.documents.track import MeasuringPart, TrackDocument, TrackPart
from purcell_cli.cli.reports.common import deviation_document, plain_table, swimmer_document
from purcell_cli.feedback.measured import Measuring
from purcell_cli.feedback.track import Tracking
from purcell_cli.mechanics.swimmer import Swimmer

if TYPE_CHECKING:
    from rich.console import Console


def track_document(
    found: Tracking, model: Swimmer, measuring: Measuring, tolerance_l: float, tolerance_deg: float, out: str | None
) -> TrackDocument:
    """Return a way that was swum in parts.

    Args:
        found: The way.
        model: The swimmer that was planned for.
        measuring: How exactly it was measured.
        tolerance_l: Position tolerance, in units of L.
        tolerance_deg: Angle tolerance [deg].
        out: The file of what really happened, if there is one.
    """
    size = model.length_m
    parts: list[TrackPart] = [
        {
            "leg": part.leg + 1,
            "joint_travel_rad": part.joint_travel_rad,
            "duration_s": float(part.trajectory.time_s[-1]),
            "measured_off": deviation_document(part.aim.off(part.measured), size),
            "off": deviation_document(part.aim.off(part.end), size),
        }
        for part in found.parts
    ]
    return {
        "schema": "purcell/track/1",
        "verdict": "reached" if found.arrived else "not reached",
        "model": swimmer_document(model),
        "truth": swimmer_document(found.truth),
        "noise": as_part(measuring, MeasuringPart),
        "tolerance_l": tolerance_l,
        "tolerance_deg": tolerance_deg,
        "replans": found.replans,
        "joint_travel_rad": found.joint_travel_rad,
        "off": deviation_document(found.off, size),
        "off_curve_m": found.off_curve_m,
        "obstacle_m": found.obstacle_m,
        "parts": parts,
        "out": out,
    }


def show_track(console: Console, document: TrackDocument) -> None:
    """Show a way that was swum in parts."""
    table = plain_table("Plan, swim, measure")
    many_legs = len({part["leg"] for part in document["parts"]}) > 1
    for heading in (
        *(["leg"] if many_legs else []),
        "part",
        "joint travel [rad]",
        "time [s]",
        "then off by [L]",
        "[deg]",
    ):
        table.add_column(heading, justify="right")
    for k, part in enumerate(document["parts"], 1):
        off = part["measured_off"]
        figures = f"{part['joint_travel_rad']:.4g}", f"{part['duration_s']:.4g}"
        numbers = ([str(part["leg"])] if many_legs else []) + [str(k)]
        table.add_row(*numbers, *figures, f"{off['position_over_L']:.3g}", f"{math.degrees(off['base_rad']):.3g}")
    console.print(table)
    off, many = document["off"], document["replans"]
    console.print(
        f"it ends {off['position_over_L']:.3g} L and {math.degrees(off['base_rad']):.3g} deg off after {many} "
        f"replan{'' if many == 1 else 's'}, joint travel {document['joint_travel_rad']:.4g} rad"
    )
    if document["off_curve_m"] is not None:
        console.print(f"it was {1000.0 * document['off_curve_m']:.4g} mm from the curve at most")
    if document["obstacle_m"] is not None:
        near = f"{1000.0 * abs(document['obstacle_m']):.4g} mm"
        clear = document["obstacle_m"] >= 0.0
        console.print(f"links were {near} from obstacles or more" if clear else f"a link was {near} inside an obstacle")
    console.print(document["verdict"])
    if document["out"] is not None:
        console.print(f"what really happened is in {document['out']}", soft_wrap=True)
