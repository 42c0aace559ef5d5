"""A designed stroke as a document and as a table."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Literal, cast

from purcell_cli.cli.documents.common import Moves
from purcell_cli.cli.documents.gait import DesignDocument
from purcell_cli.cli.reports.atlas import entry_document
from purcell_cli.cli.reports.common import angles_deg, swimmer_document
from purcell_cli.gaits.design import Designed
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.options import Controls

if TYPE_CHECKING:
    from rich.console import Console


def design_document(found: Designed, swimmer: Swimmer, file: str, *, interrupted: bool) -> DesignDocument:
    """Return the best stroke found.

    Args:
        found: The stroke.
        swimmer: The swimmer.
        file: The gait's file.
        interrupted: Whether the search was ended before all starts were over.
    """
    task = found.task
    return {
        "schema": "purcell/design/1",
        "verdict": "done",
        "direction": cast(Moves, task.direction),
        "maximize": cast(Literal["speed", "efficiency"], task.maximize),
        "planar": task.planar,
        "controls": Controls(task.controls),
        "max_bend_rad": task.max_bend_rad,
        "moves": task.moves,
        "seed": found.seed,
        "starts": found.starts,
        "interrupted": interrupted,
        "swimmer": swimmer_document(swimmer),
        "per_joint_travel": found.ratio,
        "unit": "rad/rad" if task.turns else "L/rad",
        "largest_bend_rad": found.largest_bend_rad,
        "stroke": entry_document(found.entry),
        "gait": file,
    }


def show_design(console: Console, document: DesignDocument) -> None:
    """Show the best stroke found."""
    plane = "planar" if document["planar"] else "spatial"
    bend = f"bends within {document['max_bend_rad']:g} rad"
    console.print(f"{document['direction']}: {plane}, {document['controls']} controls, {bend}")
    value, stroke = document["per_joint_travel"], document["stroke"]
    turned = f", {math.degrees(value):.4f} deg/rad" if document["unit"] == "rad/rad" else ""
    console.print(f"{value:.6f} {document['unit']} of joint travel{turned}")
    console.print(
        f"one cycle: joint travel {stroke['joint_travel_rad']:.4f} rad, {stroke['duration_s']:.4f} s, "
        f"energy {stroke['energy_j']:.4g} J, efficiency {100.0 * stroke['efficiency']:.4f} %, "
        f"bent {document['largest_bend_rad']:.6g} rad at most"
    )
    turned_deg = angles_deg(stroke["roll_rad"], stroke["pitch_rad"], stroke["yaw_rad"])
    moved, angles = (
        ", ".join(f"{v:.6g}" if abs(v) > 1e-9 else "0" for v in part)
        for part in ((stroke["x_L"], stroke["y_L"], stroke["z_L"]), turned_deg)
    )
    console.print(f"x, y, z {moved} L; psi, theta, phi {angles} deg")
    ended = ", interrupted" if document["interrupted"] else ""
    console.print(f"the best of {document['starts']} starts, seed {document['seed']}{ended}")
    console.print(f"gait in {document['gait']}", soft_wrap=True)
