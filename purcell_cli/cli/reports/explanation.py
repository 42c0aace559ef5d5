"""How the explanation of a plan is told: as part of its document, and as tables."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from purcell_cli.cli.documents.plan import (
    ExplanationPart,
    OnBeadsPart,
    PlanDocument,
    SensitivityPart,
    StrokeReasonPart,
    StructurePart,
)
from purcell_cli.cli.reports.common import displacement_cells, displacement_document
from purcell_cli.explanation import Explanation, figure
from purcell_cli.geometry.rotations import angle_between
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.sensitivity import CHANGE, parameter_name

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

_ROOMY = 108
"""Columns a terminal needs to show coordinates where it else shows a distance and an angle."""

_ANGLES = "psi, theta, phi\n[deg]"

_THERE = 1e-8
"""Distances (L, mm) and angles (rad, deg) below this are not worth a person's while."""

_MOST_STRUCTURES = 5
"""How many structures are shown."""


def explanation_document(explanation: Explanation, swimmer: Swimmer) -> ExplanationPart:
    """Return why a plan is as it is."""
    strokes: list[StrokeReasonPart] = [
        {
            "phase": s.phase,
            "gait": s.gait,
            "description": s.words,
            "cycles": s.cycles,
            "joint_travel_rad": s.joint_travel_rad,
            "energy_j": s.energy_j,
            "missing": {
                **displacement_document(s.missing),
                "position_over_L": float(np.linalg.norm(s.missing[:3, 3])) / swimmer.length_m,
                "angle_rad": float(angle_between(np.eye(3), s.missing[:3, :3])),
            },
            "largest_bend_rad": s.largest_bend_rad,
            "limits": list(s.limits),
        }
        for s in explanation.strokes
    ]
    sensitivity: list[SensitivityPart] = [
        {
            "parameter": s.parameter,
            "change": s.change,
            "position_m": s.position_m,
            "position_over_L": s.position_m / swimmer.length_m,
            "angle_rad": s.angle_rad,
            "largest_part": None if c is None else {"stroke": c.stroke, "share": c.share, "description": c.words},
        }
        for s, c in zip(explanation.sensitivities, explanation.culprits, strict=True)
    ]
    structures: list[StructurePart] = [
        {"description": s.words, "joint_travel_rad": s.joint_travel_rad, "why_not": s.why_not}
        for s in explanation.structures
    ]
    off, why_not = explanation.on_beads.off, explanation.on_beads.why_not
    on_beads: OnBeadsPart = {
        "position_m": None if off is None else off.position_m,
        "position_over_L": None if off is None else off.position_m / swimmer.length_m,
        "angle_rad": None if off is None else off.base_rad,
        "why_not": why_not,
    }
    return {"strokes": strokes, "structures": structures, "sensitivity": sensitivity, "on_beads": on_beads}


def show_explanation(console: Console, document: PlanDocument) -> None:
    """Show the explanation in a plan's document."""
    explanation = document["explanation"]
    console.print()
    if not explanation["strokes"]:
        console.print("nothing to explain: the goal is the start")
        return
    _show_strokes(console, explanation["strokes"], document["swimmer"]["L_m"])
    if explanation["structures"]:
        _show_structures(console, explanation["structures"])
    _show_sensitivity(console, explanation)
    _show_on_beads(console, explanation["on_beads"])


def _show_on_beads(console: Console, found: OnBeadsPart) -> None:
    over, angle = found["position_over_L"], found["angle_rad"]
    if over is None or angle is None:
        console.print(f"where it would end on beads is not known: {found['why_not']}")
    else:
        ends = f"{figure(over)} L and {figure(math.degrees(angle))} deg off"
        console.print(f"on beads (links that feel each other) it would end {ends}")


def _table(title: str) -> Table:
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    return Table(title=title, title_justify="left", box=SIMPLE_HEAD)


def _show_strokes(console: Console, strokes: list[StrokeReasonPart], length_m: float) -> None:
    narrow = console.width < _ROOMY
    table = _table("Stroke by stroke")
    table.add_column("stroke")
    table.add_column("what it does")
    table.add_column("travel\n[rad]", justify="right", no_wrap=True)
    for heading in ("then missing\n[mm]", "\n[deg]") if narrow else ("then missing: x, y, z\n[mm]", _ANGLES):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("limited\nby")
    for k, s in enumerate(strokes):
        missing = s["missing"]
        if narrow:
            way, turn = missing["position_over_L"], missing["angle_rad"]
            cells = [
                "0" if way < _THERE else figure(1e3 * length_m * way),
                "0" if turn < _THERE else figure(math.degrees(turn)),
            ]
        else:
            cells = displacement_cells(missing, length_m, 4)
        table.add_row(
            _name(k, s), s["description"], f"{s['joint_travel_rad']:.4f}", *cells, ", ".join(s["limits"]) or "-"
        )
    console.print(table)


def _name(k: int, stroke: StrokeReasonPart) -> str:
    """Return what a stroke is called in tables: its number, its name and how often it is played."""
    return f"{k + 1} {stroke['gait']}" + (f" x {stroke['cycles']}" if stroke["cycles"] > 1 else "")


def _show_structures(console: Console, structures: list[StructurePart]) -> None:
    table = _table("Candidates that were weighed, by estimated joint travel")
    table.add_column("")
    table.add_column("structure")
    table.add_column("travel\n[rad]", justify="right", no_wrap=True)
    table.add_column("more by", justify="right", no_wrap=True)
    taken = structures[0]["joint_travel_rad"]
    for k, s in enumerate(structures[:_MOST_STRUCTURES]):
        more = s["joint_travel_rad"] - taken
        words = s["description"] + (f"; not taken: it {s['why_not']}" if s["why_not"] else "")
        share = f" ({100.0 * more / taken:.3g} %)" if taken else ""
        label = ("taken", "runner-up")[k] if k < 2 else ""
        table.add_row(label, words, f"{s['joint_travel_rad']:.4f}", f"{more:.4f}{share}" if k else "")
    console.print(table)
    if len(structures) > _MOST_STRUCTURES:
        console.print(f"and {len(structures) - _MOST_STRUCTURES} more")


def _show_sensitivity(console: Console, explanation: ExplanationPart) -> None:
    table = _table(f"If the swimmer were {100.0 * CHANGE:g} % off, the same controls would end off by")
    table.add_column("parameter")
    for heading in ("position\n[L]", "\n[mm]", "angle\n[deg]"):
        table.add_column(heading, justify="right", no_wrap=True)
    table.add_column("largest part from")
    strokes, sensitive = explanation["strokes"], {}
    for s in explanation["sensitivity"]:
        source = s["largest_part"]
        told = (
            "-"
            if source is None
            else f"{_name(source['stroke'], strokes[source['stroke']])} ({100.0 * source['share']:.0f} %)"
        )
        if source is not None and source["description"]:
            sensitive[source["stroke"]] = source["description"]
        figures = (s["position_over_L"], 1e3 * s["position_m"], math.degrees(s["angle_rad"]))
        table.add_row(parameter_name(s["parameter"]), *(figure(v) if v > _THERE else "0" for v in figures), told)
    console.print(table)
    for stroke, words in sorted(sensitive.items()):
        console.print(f"{_name(stroke, strokes[stroke])} is sensitive: {words}")
    if all(s["parameter"] != "viscosity_pa_s" for s in explanation["sensitivity"]):
        console.print("viscosity: none; it scales forces and energy, never the path")
