"""A gait as a JSON document and as a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, cast

import numpy as np

from purcell_cli.gaits.gait import MOTIONS, Gait, Stroke
from purcell_cli.gaits.sampling import paced_stroke
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import as_euler
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.moves import ControlSequence
from purcell_cli.mechanics.primitives import CONTROL_NAMES, PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import energies

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

from purcell_cli.cli.documents.common import Moves, keys
from purcell_cli.cli.documents.gait import GaitDocument, GaitListDocument, MovePart, PrimitivePart, TwistPart
from purcell_cli.cli.reports.common import angles_deg, plain_table, swimmer_document

_NOTHING = 1e-9
"""Displacements below this are shown as 0 [mm, deg]."""

_ROOMY = 116
"""Columns a terminal needs to show what an amplitude is beside what a gait does."""


def gait_document(gait: Gait, stroke: Stroke, swimmer: Swimmer, cycles: int, file: str | None) -> GaitDocument:
    """Return what a stroke does in a number of cycles."""
    travel = 2.0 * stroke.approach.joint_travel_rad + cycles * stroke.cycle.joint_travel_rad
    pace, played = paced_stroke(swimmer, stroke, cycles)
    g = stroke.displacement(swimmer, cycles)
    moved = np.concatenate([g[:3, 3] / swimmer.length_m, as_euler(g[:3, :3])[::-1]])
    own = MOTIONS.index(gait.moves) if gait.moves in MOTIONS else None
    scale = np.repeat([swimmer.length_m, 1.0], 3)
    turned = se3.log(g) / scale
    return {
        "schema": "purcell/gait/1",
        "verdict": "done",
        "gait": gait.name,
        "summary": gait.summary,
        "amplitude_rad": stroke.amplitude_rad,
        "amplitude_means": gait.means,
        "cycles": cycles,
        "swimmer": swimmer_document(swimmer),
        "approach": _pieces(stroke.approach),
        "cycle": _pieces(stroke.cycle),
        "joint_travel_rad": travel,
        "duration_s": sum(b.duration for b in played) / pace.joint_rate_rad_s,
        "displacement": cast(TwistPart, dict(zip(keys(TwistPart), (moved * scale).tolist(), strict=True))),
        "moves": cast(Moves, gait.moves),
        "cross_talk": None if own is None else float(np.max(np.abs(np.delete(turned, own)))),
        "closure_rad": stroke.closure_rad(cycles),
        "energy_j": float(np.sum(energies(pace, played, COLLINEAR))),
        "trajectory": file,
    }


def _pieces(sequence: ControlSequence) -> list[PrimitivePart] | list[MovePart]:
    """Return primitives by control and angle, moves by how they turn each joint."""
    if isinstance(sequence, PrimitiveSequence):
        primitives: list[PrimitivePart] = [{"control": c, "angle_rad": a} for c, a in sequence]
        return primitives
    turns = np.asarray(sequence.rates() * sequence.duration[:, None]).tolist()
    moves: list[MovePart] = [{"turn_rad": dict(zip(CONTROL_NAMES, turn, strict=True))} for turn in turns]
    return moves


def gait_list_document(gaits: Sequence[Gait]) -> GaitListDocument:
    """Return one line on each gait."""
    return {
        "schema": "purcell/gait-list/1",
        "verdict": "done",
        "gaits": [
            {
                "name": g.name,
                "also": list(g.also),
                "moves": cast(Moves, g.moves),
                "amplitude_means": g.means,
                "default_amplitude_rad": g.default_rad,
                "summary": g.summary,
            }
            for g in gaits
        ],
    }


def _primitives_table(approach: list[PrimitivePart], cycle: list[PrimitivePart]) -> Table:
    from rich.table import Table

    table = Table(title="One cycle, as primitives", title_justify="left")
    table.add_column("")
    table.add_column("control")
    table.add_column("angle [rad]", justify="right")
    back: list[PrimitivePart] = [{"control": p["control"], "angle_rad": -p["angle_rad"]} for p in reversed(approach)]
    for label, primitives in (("approach, once", approach), ("cycle", cycle), ("back, once", back)):
        for k, p in enumerate(primitives):
            table.add_row(label if k == 0 else "", p["control"], f"{p['angle_rad']:+.9f}")
    return table


def show_gait(console: Console, document: GaitDocument) -> None:
    """Show what a stroke does as tables."""
    console.print(f"{document['gait']}: {document['summary']}")
    console.print(
        f"amplitude {document['amplitude_rad']:.6g} rad ({document['amplitude_means']}), cycles {document['cycles']}"
    )
    cycle = document["cycle"]
    if "control" in cycle[0]:
        primitives = cast(list[PrimitivePart], document["approach"]), cast(list[PrimitivePart], cycle)
        console.print(_primitives_table(*primitives))
    else:
        console.print(f"one cycle: {len(cycle)} straight moves, all joints at once")
    d = document["displacement"]
    moved = plain_table("Net displacement; psi, theta, phi are yaw, pitch, roll")
    for name, unit in (*((axis, "mm") for axis in "xyz"), *((angle, "deg") for angle in ("psi", "theta", "phi"))):
        moved.add_column(f"{name} [{unit}]", justify="right")
    values = (
        *(1e3 * v for v in (d["x_m"], d["y_m"], d["z_m"])),
        *angles_deg(d["roll_rad"], d["pitch_rad"], d["yaw_rad"]),
    )
    moved.add_row(*(f"{v:.7g}" if abs(v) > _NOTHING else "0" for v in values))
    console.print(moved)
    cross = document["cross_talk"]
    told = "" if cross is None else f"cross-talk {cross:.1e} (L, rad), "
    console.print(
        f"joint travel {document['joint_travel_rad']:.6g} rad, {document['duration_s']:.6g} s, {told}"
        f"closure {document['closure_rad']:.1e} rad, energy {document['energy_j']:.4g} J"
    )
    if document["trajectory"]:
        console.print(f"trajectory in {document['trajectory']}", soft_wrap=True)


def show_gait_list(console: Console, document: GaitListDocument) -> None:
    """Show some lines on each gait, by what fits: its amplitude in columns of its own, or below what it does."""
    table = plain_table("Stored gaits; psi, theta, phi are yaw, pitch, roll")
    roomy = console.width >= _ROOMY
    for heading in ("name", "also"):
        table.add_column(heading, no_wrap=True)
    for heading in ("amplitude is", "default [rad]") if roomy else ():
        table.add_column(heading)
    table.add_column("what it does")
    for g in document["gaits"]:
        means, default = g["amplitude_means"], f"{g['default_amplitude_rad']:g}"
        told = (means, default, g["summary"]) if roomy else (f"{g['summary']}\namplitude {default} rad: {means}",)
        table.add_row(g["name"], ", ".join(g["also"]), *told)
    console.print(table)
