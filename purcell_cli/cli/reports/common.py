"""What the commands say: one document for each result, printed as JSON or shown as tables."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from purcell_cli.gaits.gait import MOTIONS, Gait, Stroke
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, as_euler
from purcell_cli.mechanics.configuration import Deviation
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import work
from purcell_cli.mechanics.moves import ControlSequence
from purcell_cli.mechanics.primitives import CONTROL_NAMES, PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import PHASES
from purcell_cli.motion.limits import LimitsReport
from purcell_cli.solution import Solution, phase_displacement, stroke_cycles
from purcell_cli.wording import counted

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from purcell_cli.verification.verify import Verification

Document = dict[str, Any]


def as_json(document: Mapping[str, Any]) -> str:
    """Return a document as one line of JSON; NaN has no place in it."""
    return json.dumps(document, allow_nan=False, ensure_ascii=False)


def error_document(command: str, message: str) -> Document:
    """Return the document of a command that could not be carried out."""
    return {"schema": f"purcell/{command}/1", "verdict": "error", "error": message}


def displacement_document(g: Array) -> Document:
    """Return a body displacement."""
    psi, theta, phi = as_euler(g[:3, :3]).tolist()
    return {"position_m": g[:3, 3].tolist(), "psi_rad": psi, "theta_rad": theta, "phi_rad": phi}


def _deviation(deviation: Deviation, length_m: float) -> Document:
    return {
        "position_m": deviation.position_m,
        "position_over_L": deviation.position_m / length_m,
        "base_rad": deviation.base_rad,
        "limb1_rad": deviation.limb1_rad,
        "limb2_rad": deviation.limb2_rad,
    }


def swimmer_document(swimmer: Swimmer) -> Document:
    """Return a swimmer's parameters."""
    return {**dataclasses.asdict(swimmer), "L_m": swimmer.length_m}


def _limits(found: LimitsReport, swimmer: Swimmer) -> Document:
    """Return the limits of a plan, and what of it breaks them most."""
    workspace, excess = found.limits.workspace, found.workspace
    return {
        "clearance_m": found.limits.clearance_m,
        "max_bend_rad": swimmer.max_bend_rad,
        "workspace_m": None if workspace is None else dataclasses.asdict(workspace),
        "workspace_violation_m": None if excess is None else excess.distance_m,
        "kept": found.kept,
        "violations": [dataclasses.asdict(v) for v in found.violations],
    }


def plan_document(solution: Solution, file: str | None, saved: str | None = None, command: str = "plan") -> Document:
    """Return what is known of a plan.

    Args:
        solution: The plan, carried out.
        file: The trajectory's file.
        saved: The plan document's file, written or read.
        command: The command that asks: plan or run.
    """
    plan, swimmer = solution.plan, solution.plan.swimmer
    rate = swimmer.joint_rate_rad_s
    strokes: dict[int, list[Document]] = {1: [], 2: [], 3: []}
    for part in solution.strokes:
        blocks = plan.blocks[part]
        travel = sum(b.joint_travel_rad for b in blocks)
        amplitude = blocks[0].amplitude_rad
        strokes[blocks[0].phase].append(
            {
                "gait": blocks[0].gait,
                "amplitude_rad": None if math.isnan(amplitude) else amplitude,
                "cycles": stroke_cycles(blocks),
                "primitives": sum(b.cycles * len(b.sequence) for b in blocks),
                "joint_travel_rad": travel,
                "duration_s": sum(b.duration for b in blocks) / rate,
                "energy_j": float(np.sum(solution.energy_j[part])),
                "displacement": displacement_document(se3.prefix_products(solution.displacement[part])[-1]),
            }
        )
    phases = [
        {
            "phase": phase,
            "name": name,
            "primitives": sum(s["primitives"] for s in strokes[phase]),
            "joint_travel_rad": sum(s["joint_travel_rad"] for s in strokes[phase]),
            "duration_s": sum(s["duration_s"] for s in strokes[phase]),
            "energy_j": sum(s["energy_j"] for s in strokes[phase]),
            "largest_bend_rad": solution.limits.largest_bend_rad[phase - 1],
            "displacement": displacement_document(phase_displacement(solution, phase)),
            "strokes": strokes[phase],
        }
        for phase, name in PHASES.items()
    ]
    found = solution.certificate
    return {
        "schema": f"purcell/{command}/1",
        "verdict": solution.verdict,
        "swimmer": swimmer_document(swimmer),
        "controls": solution.controls,
        "joint_travel_rad": plan.joint_travel_rad,
        "duration_s": solution.duration_s,
        "energy_j": float(np.sum(solution.energy_j)),
        "primitives": plan.primitives,
        "cycles": sum(s["cycles"] for s in strokes[2]),
        "phases": phases,
        "planned_error": _deviation(solution.deviation, swimmer.length_m),
        "verified_error": _deviation(found.deviation, swimmer.length_m),
        "tolerance": {"position_m": found.tolerance_m, "angle_rad": found.tolerance_rad},
        "certificate": {"method": "DOP853", "stretches": found.stretches, "integrated": found.integrated},
        "clearance_m": solution.limits.clearance.distance_m,
        "largest_bend_rad": solution.limits.largest_bend_rad[1],
        "limits": _limits(solution.limits, swimmer),
        "rows": len(solution.trajectory),
        "trajectory": file,
        "plan_document": saved,
    }


def gait_document(gait: Gait, stroke: Stroke, swimmer: Swimmer, cycles: int, file: str | None) -> Document:
    """Return what a stroke does in a number of cycles."""
    inner = stroke.approach.shapes(COLLINEAR)[-1]
    travel = 2.0 * stroke.approach.joint_travel_rad + cycles * stroke.cycle.joint_travel_rad
    approach_j, cycle_j = (
        float(np.sum(work(swimmer, sequence, shape)))
        for sequence, shape in ((stroke.approach, COLLINEAR), (stroke.cycle, inner))
    )
    g = stroke.displacement(swimmer, cycles)
    moved = np.concatenate([g[:3, 3] / swimmer.length_m, as_euler(g[:3, :3])[::-1]])
    own = MOTIONS.index(gait.moves) if gait.moves in MOTIONS else None
    scale = [swimmer.length_m] * 3 + [1.0] * 3
    units = ["m"] * 3 + ["rad"] * 3
    turned = se3.log(g) / np.array([swimmer.length_m] * 3 + [1.0] * 3)
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
        "duration_s": sum(n * float(np.sum(s.duration)) for s, n in stroke.parts(cycles)) / swimmer.joint_rate_rad_s,
        "displacement": {f"{m}_{u}": float(v * s) for m, u, v, s in zip(MOTIONS, units, moved, scale, strict=True)},
        "moves": gait.moves,
        "cross_talk": None if own is None else float(np.max(np.abs(np.delete(turned, own)))),
        "closure_rad": stroke.closure_rad(),
        "energy_j": 2.0 * approach_j + cycles * cycle_j,
        "trajectory": file,
    }


def _pieces(sequence: ControlSequence) -> list[Document]:
    """Return primitives by control and angle, moves by how they turn each joint."""
    if isinstance(sequence, PrimitiveSequence):
        return [{"control": c, "angle_rad": a} for c, a in sequence]
    turns = np.asarray(sequence.rates() * sequence.duration[:, None]).tolist()
    return [{"turn_rad": dict(zip(CONTROL_NAMES, turn, strict=True))} for turn in turns]


def gait_list_document(gaits: Sequence[Gait]) -> Document:
    """Return one line on each gait."""
    return {
        "schema": "purcell/gait-list/1",
        "verdict": "done",
        "gaits": [
            {
                "name": g.name,
                "also": list(g.also),
                "moves": g.moves,
                "amplitude_means": g.means,
                "default_amplitude_rad": g.default_rad,
                "summary": g.summary,
            }
            for g in gaits
        ],
    }


def verify_document(found: Verification, swimmer: Swimmer) -> Document:
    """Return what the check of a trajectory file found."""
    return {
        "schema": "purcell/verify/1",
        "verdict": "reached" if found.holds else "not reached",
        "swimmer": swimmer_document(swimmer),
        "start_error": _deviation(found.start, swimmer.length_m),
        "verified_error": _deviation(found.certificate.deviation, swimmer.length_m),
        "tolerance": {"position_m": found.certificate.tolerance_m, "angle_rad": found.certificate.tolerance_rad},
        "certificate": {
            "method": "DOP853",
            "stretches": found.certificate.stretches,
            "integrated": found.certificate.integrated,
        },
        "clearance_m": None if found.clearance is None else found.clearance.distance_m,
        "faults": list(found.faults),
    }


_ROOMY = 116
"""Columns a terminal needs to show a plan with amplitudes and times."""


def displacement_cells(displacement: Mapping[str, Any], length_m: float, digits: int) -> list[str]:
    """Return a displacement's x, y, z in mm and psi, theta, phi in degrees, for a table."""

    def shown(value: float, unit: float, scale: float) -> str:
        places = digits - 2 - math.floor(math.log10(scale * unit / 50.0))
        return f"{round(scale * value, places) + 0.0:.{digits}g}"

    angles = [displacement[f"{a}_rad"] for a in ("psi", "theta", "phi")]
    return [
        ", ".join(shown(v, length_m, 1e3) for v in displacement["position_m"]),
        ", ".join(shown(v, 1.0, math.degrees(1.0)) for v in angles),
    ]


def show_plan(console: Console, document: Document) -> None:
    """Show a plan's document as tables."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(title="Reconfiguration", title_justify="left", box=SIMPLE_HEAD)
    narrow = console.width < _ROOMY
    table.add_column("stroke", no_wrap=not narrow)
    headings = ("cycles", "travel [rad]", "x, y, z [mm]", "psi, theta, phi [deg]")
    for heading in headings if narrow else ("amplitude [rad]", *headings[:2], "time [s]", *headings[2:]):
        table.add_column(heading.replace(" [", "\n\\["), justify="right", no_wrap=True)
    length_m = document["swimmer"]["L_m"]

    def row(label: str, amplitude: str, cycles: str, part: Mapping[str, Any], style: str) -> None:
        travel, time = f"{part['joint_travel_rad']:.4f}", f"{part['duration_s']:.2f}"
        moved = (
            displacement_cells(part["displacement"], length_m, 3 if narrow else 4)
            if part["joint_travel_rad"]
            else ["", ""]
        )
        cells = (cycles, travel) if narrow else (amplitude, cycles, travel, time)
        table.add_row(label, *cells, *moved, style=style)

    for phase in document["phases"]:
        row(f"{phase['phase']} {phase['name']}", "", "", phase, "bold")
        for s in phase["strokes"] if phase["phase"] == 2 else []:
            amplitude = "" if s["amplitude_rad"] is None else f"{s['amplitude_rad']:.5f}"
            row(f"  {s['gait']}", amplitude, str(s["cycles"]), s, "")
    console.print(table)
    errors = Table(title="Distance from the goal", title_justify="left", box=SIMPLE_HEAD)
    errors.add_column("")
    for heading in ("position [L]", "base [rad]", "limb 1 [rad]", "limb 2 [rad]"):
        errors.add_column(heading.replace("[", "\\["), justify="right")
    for label, key in (("planned", "planned_error"), ("re-integrated", "verified_error")):
        e = document[key]
        errors.add_row(label, *(f"{e[k]:.1e}" for k in ("position_over_L", "base_rad", "limb1_rad", "limb2_rad")))
    console.print(errors)
    piece = "primitive" if document["controls"] == "primitive" else "move"
    console.print(
        f"joint travel {document['joint_travel_rad']:.4f} rad, {document['duration_s']:.3f} s, "
        f"{counted(document['primitives'], piece)}, {counted(document['cycles'], 'cycle')}, "
        f"energy {document['energy_j']:.4g} J"
    )
    _checked(console, document["certificate"])
    _show_limits(console, document)
    _verdict(console, document["verdict"])
    if document["trajectory"]:
        console.print(f"{document['rows']} rows in {document['trajectory']}", soft_wrap=True)
    if document["plan_document"] and document["schema"] == "purcell/plan/1":
        console.print(f"plan in {document['plan_document']}", soft_wrap=True)


def _show_limits(console: Console, document: Document) -> None:
    """Show how near a plan comes to its limits on one line, and one more for each that it breaks."""
    limits, bend = document["limits"], document["largest_bend_rad"]
    told = [f"limbs {1e3 * document['clearance_m']:.4g} mm apart or more"]
    told += [] if bend is None else [f"bent {bend:.4g} rad at most in phase 2"]
    if limits["workspace_m"] is not None:
        inside = not any(v["limit"] == "workspace" for v in limits["violations"])
        told.append("inside the workspace" if inside else "not inside the workspace")
    console.print(", ".join(told))
    for v in limits["violations"]:
        excess = f"{1e3 * v['excess']:.4g} mm" if v["unit"] == "m" else f"{v['excess']:.4g} rad"
        when = f"at {v['time_s']:.3f} s in phase {v['phase']}"
        console.print(f"[red]-[/] {v['limit']}: {v['what']}, {excess} outside the limit {when}", soft_wrap=True)


def _checked(console: Console, certificate: Mapping[str, Any]) -> None:
    counts = (
        f"{certificate['stretches']} stretches of control, {certificate['integrated']} of them distinct and integrated"
    )
    console.print(f"checked by {certificate['method']}: {counts}")


def _verdict(console: Console, verdict: str) -> None:
    console.print(f"[bold {'green' if verdict == 'reached' else 'red'}]{verdict}[/]")


def _primitives_table(document: Document) -> Table:
    from rich.table import Table

    table = Table(title="One cycle, as primitives", title_justify="left")
    table.add_column("")
    table.add_column("control")
    table.add_column("angle \\[rad]", justify="right")
    parts = [("approach, once", document["approach"]), ("cycle", document["cycle"])]
    parts.append(("back, once", [{**p, "angle_rad": -p["angle_rad"]} for p in reversed(document["approach"])]))
    for label, primitives in parts:
        for k, p in enumerate(primitives):
            table.add_row(label if k == 0 else "", p["control"], f"{p['angle_rad']:+.9f}")
    return table


def show_gait(console: Console, document: Document) -> None:
    """Show what a stroke does as tables."""
    from rich.table import Table

    console.print(f"[bold]{document['gait']}[/]: {document['summary']}")
    console.print(
        f"amplitude {document['amplitude_rad']:.6g} rad ({document['amplitude_means']}), cycles {document['cycles']}"
    )
    if "control" in document["cycle"][0]:
        console.print(_primitives_table(document))
    else:
        console.print(f"one cycle: {len(document['cycle'])} straight moves, all joints at once")
    d = document["displacement"]
    moved = Table(title="Net displacement", title_justify="left")
    for name in d:
        motion, unit = name.split("_")
        moved.add_column(f"{motion} \\[{unit}]", justify="right")
    moved.add_row(*(f"{v:.9g}" if abs(v) > 1e-12 else "0" for v in d.values()))
    console.print(moved)
    cross = document["cross_talk"]
    told = "" if cross is None else f"cross-talk {cross:.1e} (L, rad), "
    console.print(
        f"joint travel {document['joint_travel_rad']:.6g} rad, {document['duration_s']:.6g} s, {told}"
        f"closure {document['closure_rad']:.1e} rad, energy {document['energy_j']:.4g} J"
    )
    if document["trajectory"]:
        console.print(f"trajectory in {document['trajectory']}", soft_wrap=True)


def show_gait_list(console: Console, document: Document) -> None:
    """Show one line on each gait."""
    from rich.table import Table

    table = Table(title="Stored gaits", title_justify="left")
    for heading in ("name", "also", "amplitude is", "default \\[rad]", "what it does"):
        table.add_column(heading, overflow="fold")
    for g in document["gaits"]:
        table.add_row(
            g["name"], ", ".join(g["also"]), g["amplitude_means"], f"{g['default_amplitude_rad']:g}", g["summary"]
        )
    console.print(table)


def show_verify(console: Console, document: Document) -> None:
    """Show what the check of a trajectory file found."""
    e = document["verified_error"]
    console.print(
        f"re-integrated end: position off by {e['position_over_L']:.1e} L, base {e['base_rad']:.1e} rad, "
        f"limb 1 {e['limb1_rad']:.1e} rad, limb 2 {e['limb2_rad']:.1e} rad"
    )
    _checked(console, document["certificate"])
    if document["clearance_m"] is not None:
        console.print(f"limbs {1e3 * document['clearance_m']:.4g} mm apart or more")
    for fault in document["faults"]:
        console.print(f"[red]-[/] {fault}", soft_wrap=True)
    _verdict(console, document["verdict"])
