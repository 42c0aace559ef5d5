"""A plan as a JSON document and as a table."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import PHASES
from purcell_cli.motion.limits import LimitsReport
from purcell_cli.solution import Solution, phase_displacement, stroke_cycles
from purcell_cli.wording import counted

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

from purcell_cli.cli.documents.common import as_part
from purcell_cli.cli.documents.plan import (
    BlockedPart,
    CurvePart,
    EncounterPart,
    LimitsPart,
    PhasePart,
    PlanDocument,
    RestPart,
    StrokePart,
    ViolationPart,
    WaypointPart,
    WorkspacePart,
)
from purcell_cli.cli.reports.common import (
    _checked,
    _verdict,
    certificate_document,
    deviation_document,
    displacement_cells,
    displacement_document,
    fits,
    plain_table,
    swimmer_document,
    turned_from_curve,
)


def _limits(found: LimitsReport, swimmer: Swimmer) -> LimitsPart:
    """Return the limits of a plan, and what of it breaks them most."""
    workspace, excess = found.limits.workspace, found.workspace
    return {
        "clearance_m": found.limits.clearance_m,
        "max_bend_rad": swimmer.max_bend_rad,
        "workspace_m": None if workspace is None else as_part(workspace, WorkspacePart),
        "workspace_violation_m": None if excess is None else excess.distance_m,
        "obstacle": None if found.obstacle is None else as_part(found.obstacle, EncounterPart),
        "kept": found.kept,
        "violations": [as_part(v, ViolationPart) for v in found.violations],
    }


def plan_document(
    solution: Solution, file: str | None, saved: str | None = None, command: Literal["plan", "run", "replan"] = "plan"
) -> PlanDocument:
    """Return what is known of a plan.

    Args:
        solution: The plan, carried out.
        file: The trajectory's file.
        saved: The plan document's file, written or read.
        command: The command that asks.
    """
    plan, swimmer = solution.plan, solution.plan.swimmer
    strokes: dict[int, list[StrokePart]] = {1: [], 2: [], 3: []}
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
                "duration_s": sum(solution.durations_s[part]),
                "energy_j": float(np.sum(solution.energy_j[part])),
                "displacement": displacement_document(se3.prefix_products(solution.displacement[part])[-1]),
            }
        )
    phases: list[PhasePart] = [
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
    document: PlanDocument = {
        "schema": _SCHEMAS[command],
        "verdict": solution.verdict,
        "swimmer": swimmer_document(swimmer),
        "controls": solution.controls,
        "joint_travel_rad": plan.joint_travel_rad,
        "duration_s": solution.duration_s,
        "energy_j": float(np.sum(solution.energy_j)),
        "primitives": plan.primitives,
        "cycles": sum(s["cycles"] for s in strokes[2]),
        "phases": phases,
        "planned_error": deviation_document(solution.deviation, swimmer.length_m),
        "verified_error": deviation_document(found.deviation, swimmer.length_m),
        "rows_error": deviation_document(solution.rows_off, swimmer.length_m),
        "tolerance": {"position_m": found.tolerance_m, "angle_rad": found.tolerance_rad},
        "certificate": certificate_document(found),
        "clearance_m": solution.limits.clearance.distance_m,
        "largest_bend_rad": solution.limits.largest_bend_rad[1],
        "limits": _limits(solution.limits, swimmer),
        "blocked": None if plan.blocked is None else as_part(plan.blocked, BlockedPart),
        "waypoints": _waypoints(solution),
        "follow": _curve(solution),
        "rows": len(solution.trajectory),
        "trajectory": file,
        "plan_document": saved,
    }
    if swimmer.fluid == "beads":
        document["table_error"] = _table_error(solution)
    return document


_LOOKED_AT = 16
"""At so many rows of a trajectory a table is held against the beads: a tenth of a second's work at 0.01."""


def _table_error(solution: Solution) -> float:
    """Return what the end on the beads themselves may be off for the table, by its error at rows of the motion."""
    from purcell_cli.mechanics.bead_table import table_error

    shapes = solution.trajectory.shape
    rows = np.unique(np.linspace(0, len(shapes) - 1, min(_LOOKED_AT, len(shapes))).astype(np.int64))
    return solution.plan.joint_travel_rad * table_error(solution.plan.swimmer, shapes[rows, :, :, 0])


_SCHEMAS: Mapping[str, Literal["purcell/plan/1", "purcell/run/1", "purcell/replan/1"]] = MappingProxyType(
    {"plan": "purcell/plan/1", "run": "purcell/run/1", "replan": "purcell/replan/1"}
)
"""The form of each command's document."""


def _waypoints(solution: Solution) -> list[WaypointPart]:
    """Return the waypoints that a plan passes."""
    begun = np.cumsum([0.0, *solution.durations_s])
    length_m = solution.plan.swimmer.length_m
    return [
        {
            "index": passage.index,
            "names": list(passage.waypoint.names),
            "time_s": float(begun[passage.block]),
            "error": deviation_document(found.deviation, length_m),
        }
        for passage, found in zip(solution.plan.passages, solution.passed, strict=True)
    ]


def _curve(solution: Solution) -> CurvePart | None:
    """Return the curve that a plan follows, if there is one."""
    follow, off = solution.plan.follow, solution.limits.off_curve
    if follow is None or off is None:
        return None
    return {
        "length_m": follow.curve.length_m,
        "tolerance_m": follow.tolerance_m,
        "distance_m": off.most_m,
        "turned_rad": off.turned_rad,
    }


_COLUMNS = ("amplitude [rad]", "cycles", "travel [rad]", "time [s]", "x, y, z [mm]", "psi, theta, phi [deg]")
_LEFT_OUT = ((), (0, 3), (0, 3, 5), (0, 3, 4, 5))
"""Which of `_COLUMNS` are left out of a plan's table: as many as a terminal has no room for."""


def _strokes(document: PlanDocument, left_out: Sequence[int]) -> Table:
    """Return a table of a plan's phases, and of the strokes of phase 2, without some columns."""
    table = plain_table("Reconfiguration")
    table.add_column("stroke", overflow="fold")
    shown = [k for k in range(len(_COLUMNS)) if k not in left_out]
    for k in shown:
        table.add_column(_COLUMNS[k].replace(" [", "\n["), justify="right", no_wrap=True)
    length_m = document["swimmer"]["L_m"]

    def row(label: str, amplitude: str, cycles: str, part: PhasePart | StrokePart, style: str) -> None:
        travel, time = f"{part['joint_travel_rad']:.4f}", f"{part['duration_s']:.2f}"
        moved = (
            displacement_cells(part["displacement"], length_m, 3 if left_out else 4)
            if part["joint_travel_rad"]
            else ["", ""]
        )
        cells = (amplitude, cycles, travel, time, *moved)
        table.add_row(label, *(cells[k] for k in shown), style=style)

    for phase in document["phases"]:
        row(f"{phase['phase']} {phase['name']}", "", "", phase, "bold")
        for s in phase["strokes"] if phase["phase"] == 2 else []:
            amplitude = "" if s["amplitude_rad"] is None else f"{s['amplitude_rad']:.5f}"
            row(f"  {s['gait']}", amplitude, str(s["cycles"]), s, "")
    return table


def show_plan(console: Console, document: PlanDocument) -> None:
    """Show a plan's document as tables."""
    tables = [_strokes(document, left_out) for left_out in _LEFT_OUT]
    console.print(next((table for table in tables if fits(console, table)), tables[-1]))
    errors = plain_table("Distance from the goal")
    errors.add_column("", no_wrap=True)
    for heading in ("position [L]", "base [rad]", "limb 1 [rad]", "limb 2 [rad]"):
        errors.add_column(heading, justify="right")
    for label, e in (("planned", document["planned_error"]), ("re-integrated", document["verified_error"])):
        found = (e["position_over_L"], e["base_rad"], e["limb1_rad"], e["limb2_rad"])
        errors.add_row(label, *(f"{value:.1e}" for value in found))
    console.print(errors)
    _show_way(console, document)
    piece = "primitive" if document["controls"] == "primitive" else "move"
    console.print(
        f"joint travel {document['joint_travel_rad']:.4f} rad, {document['duration_s']:.3f} s, "
        f"{counted(document['primitives'], piece)}, {counted(document['cycles'], 'cycle')}, "
        f"energy {document['energy_j']:.4g} J"
    )
    _checked(console, document["certificate"])
    _show_table(console, document)
    _show_limits(console, document)
    if "rest" in document:
        _show_rest(console, document["rest"])
    _verdict(console, document["verdict"])
    if document["trajectory"]:
        console.print(f"{document['rows']} rows in {document['trajectory']}", soft_wrap=True)
    if document["plan_document"] and document["schema"] != "purcell/run/1":
        console.print(f"plan in {document['plan_document']}", soft_wrap=True)


def _show_table(console: Console, document: PlanDocument) -> None:
    """Show what the table of links that feel each other is off, where one is used."""
    if "table_error" in document:
        off = document["table_error"]
        console.print(f"drag of links that feel each other from a table: about {off:.0e} L and rad off at the end")


def _show_rest(console: Console, rest: RestPart) -> None:
    """Show on one line where on a plan's way its rest begins, and what it is made of."""
    whole = rest["done_rad"] + rest["left_rad"]
    made = "the rest of its own strokes" if rest["kept"] else "planned anew"
    done = f"{rest['done_rad']:.4g} of {whole:.4g} rad of the plan are done"
    off = "" if rest["off_way"] is None else f", {rest['off_way']:.2g} L off its way"
    console.print(f"{done}{off}: {made}", soft_wrap=True)


def _show_way(console: Console, document: PlanDocument) -> None:
    """Show the waypoints that are passed, a line each, and how far the base is from the curve that it follows."""
    names = {"position_m": "position", "orientation": "orientation", "limb1": "limb 1", "limb2": "limb 2"}
    for one in document["waypoints"]:
        e = one["error"]
        off = f"{e['position_over_L']:.1e} L, {max(e['base_rad'], e['limb1_rad'], e['limb2_rad']):.1e} rad"
        what = ", ".join(names[name] for name in one["names"])
        console.print(
            f"waypoint via[{one['index']}] at {one['time_s']:.3f} s: {what} met, off by {off}", soft_wrap=True
        )
    if (curve := document["follow"]) is not None:
        console.print(
            f"{1e3 * curve['distance_m']:.4g} mm from the curve of {curve['length_m']:.4g} m at most "
            f"({1e3 * curve['tolerance_m']:.4g} mm allowed){turned_from_curve(curve['turned_rad'])}",
            soft_wrap=True,
        )


def _show_limits(console: Console, document: PlanDocument) -> None:
    """Show how near a plan comes to its limits on one line, and one more for each that it breaks."""
    limits, bend = document["limits"], document["largest_bend_rad"]
    told = [f"limbs {1e3 * document['clearance_m']:.4g} mm apart or more"]
    told += [] if bend is None else [f"bent {bend:.4g} rad at most in phase 2"]
    if limits["workspace_m"] is not None:
        inside = not any(v["limit"] == "workspace" for v in limits["violations"])
        told.append("inside the workspace" if inside else "not inside the workspace")
    if (near := limits["obstacle"]) is not None and near["distance_m"] >= 0.0:
        when = f"at {near['time_s']:.3f} s in phase {near['phase']}"
        told.append(f"{near['between']} {1e3 * near['distance_m']:.4g} mm apart or more, nearest {when}")
    console.print(", ".join(told), soft_wrap=True)
    for v in limits["violations"]:
        excess = f"{1e3 * v['excess']:.4g} mm" if v["unit"] == "m" else f"{v['excess']:.4g} rad"
        when = f"at {v['time_s']:.3f} s in phase {v['phase']}"
        console.print(f"- {v['limit']}: {v['what']}, {excess} outside the limit {when}", soft_wrap=True)
