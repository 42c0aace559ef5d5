"""The atlas of strokes as documents, tables and CSV."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, cast

from purcell_cli.cli.documents.common import Moves, keys
from purcell_cli.cli.documents.gait import AtlasDocument, EntryPart, LinkRatioDocument, MotionPart, SweepDocument
from purcell_cli.cli.reports.common import angles_deg, fits, plain_table, swimmer_document
from purcell_cli.gaits.atlas import Entry, RatioRow, Sweep
from purcell_cli.gaits.gait import MOTIONS, Gait
from purcell_cli.mechanics.swimmer import Swimmer

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table


def _unit(along: str) -> Literal["L", "rad"]:
    return "L" if MOTIONS.index(along) < 3 else "rad"


def entry_document(found: Entry) -> EntryPart:
    """Return a gait's entry in the atlas."""
    return {
        "gait": found.gait.name,
        "moves": cast(Moves, found.gait.moves),
        "amplitude_rad": found.amplitude_rad,
        **cast(MotionPart, dict(zip(keys(MotionPart), found.displacement.tolist(), strict=True))),
        "cross_talk": found.cross_talk,
        "joint_travel_rad": found.joint_travel_rad,
        "duration_s": found.duration_s,
        "energy_j": found.energy_j,
        "L_per_rad": found.speed,
        "turn_per_rad": found.turning,
        "efficiency": found.efficiency,
    }


def atlas_document(
    entries: Sequence[Entry], left_out: Mapping[str, str], swimmer: Swimmer, file: str | None
) -> AtlasDocument:
    """Return the atlas.

    Args:
        entries: One for each gait.
        left_out: Gaits without a stroke for this swimmer, and why.
        swimmer: The swimmer.
        file: The atlas's CSV file, if it is written.
    """
    return {
        "schema": "purcell/atlas/1",
        "verdict": "done",
        "swimmer": swimmer_document(swimmer),
        "gaits": [entry_document(e) for e in entries],
        "left_out": [{"gait": name, "why": why} for name, why in left_out.items()],
        "atlas": file,
    }


def sweep_document(found: Sweep, swimmer: Swimmer, file: str | None) -> SweepDocument:
    """Return a gait at many amplitudes."""
    return {
        "schema": "purcell/sweep/1",
        "verdict": "done",
        "gait": found.gait.name,
        "swimmer": swimmer_document(swimmer),
        "along": cast(Moves, found.along),
        "unit": _unit(found.along),
        "rows": [
            {
                "amplitude_rad": row.amplitude_rad,
                "displacement": row.displacement,
                "prediction": row.prediction,
                "order": row.order,
                "reversed": row.reversed,
            }
            for row in found.rows
        ],
        "sweep": file,
    }


def ratio_document(
    gait: Gait, along: str, rows: Sequence[RatioRow], swimmer: Swimmer, file: str | None
) -> LinkRatioDocument:
    """Return a gait for swimmers of many link ratios."""
    best = max(rows, key=lambda row: abs(row.displacement))
    return {
        "schema": "purcell/link-ratio/1",
        "verdict": "done",
        "gait": gait.name,
        "swimmer": swimmer_document(swimmer),
        "along": cast(Moves, along),
        "unit": "full lengths" if _unit(along) == "L" else "rad",
        "best_ratio": best.ratio,
        "rows": [{"ratio": row.ratio, "displacement": row.displacement} for row in rows],
        "sweep": file,
    }


def as_csv(rows: Sequence[Mapping[str, Any]]) -> bytes:
    """Return rows of the same keys as CSV with full double precision; None is an empty cell."""
    out = io.StringIO()
    writer = csv.DictWriter(out, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows({k: repr(v) if isinstance(v, float) else v for k, v in row.items()} for row in rows)
    return out.getvalue().encode()


_ANGLES = {"yaw": "psi", "pitch": "theta", "roll": "phi"}


def _shown(along: str) -> str:
    """Return the name that screens have for a motion: that of the Euler angle, where it turns."""
    return _ANGLES.get(along, along)


def _shown_unit(unit: str) -> tuple[str, float]:
    """Return the unit that screens show a displacement in, and how many there are in one of the document's."""
    return ("deg", math.degrees(1.0)) if unit == "rad" else (unit, 1.0)


def _cell(value: float, digits: int) -> str:
    return f"{value:.{digits}g}" if abs(value) > 1e-9 else "0"


def _tables(document: AtlasDocument, *, roomy: bool) -> list[Table]:
    """Return the atlas as one table, or as two with fewer digits: what gaits do, and what that costs."""
    done = plain_table("One cycle of each stored gait; psi, theta, phi are yaw, pitch, roll")
    cost = done if roomy else plain_table("What that costs")
    tables = [done] if roomy else [done, cost]
    for table in tables:
        table.add_column("gait", no_wrap=True)
    for heading in ("a\n[rad]", "x, y, z\n[L]", "psi, theta, phi\n[deg]"):
        done.add_column(heading, justify="right", no_wrap=True)
    for heading in ("cross-\ntalk", "travel\n[rad]", "time\n[s]", "energy\n[J]", "speed\n[L/rad]", "effic.\n[%]"):
        cost.add_column(heading, justify="right", no_wrap=True)
    for g in document["gaits"]:
        angles = angles_deg(g["roll_rad"], g["pitch_rad"], g["yaw_rad"])
        digits = 4 if roomy else 3
        moved = [", ".join(_cell(v, digits) for v in part) for part in ((g["x_L"], g["y_L"], g["z_L"]), angles)]
        did = (g["gait"], f"{g['amplitude_rad']:.3g}", *moved)
        cross = "" if g["cross_talk"] is None else f"{g['cross_talk']:.0e}"
        cells = [cross, f"{g['joint_travel_rad']:.4g}", f"{g['duration_s']:.4g}", f"{g['energy_j']:.3g}"]
        cells += [f"{g['L_per_rad']:.4f}", f"{100.0 * g['efficiency']:.3f}"]
        if roomy:
            done.add_row(*did, *cells)
        else:
            done.add_row(*did)
            cost.add_row(g["gait"], *cells)
    return tables


def show_atlas(console: Console, document: AtlasDocument) -> None:
    """Show the atlas as one table, or as two where there is no room for that."""
    whole = _tables(document, roomy=True)
    for table in whole if fits(console, whole[0]) else _tables(document, roomy=False):
        console.print(table)
    for gone in document["left_out"]:
        console.print(f"left out: {gone['why']}", soft_wrap=True)
    if document["atlas"]:
        console.print(f"atlas in {document['atlas']}", soft_wrap=True)


def show_sweep(console: Console, document: SweepDocument) -> None:
    """Show a gait at many amplitudes."""
    unit, scale = _shown_unit(document["unit"])
    table = plain_table(f"{document['gait']}: one cycle along {_shown(document['along'])}")
    for heading in ("amplitude [rad]", f"exact [{unit}]", f"leading order [{unit}]", "order"):
        table.add_column(heading, justify="right")
    table.add_column("")
    for row in document["rows"]:
        if row["displacement"] is None:
            table.add_row(f"{row['amplitude_rad']:.6g}", "", "", "", "no pure stroke")
            continue
        predicted = "" if row["prediction"] is None else f"{scale * row['prediction']:+.9f}"
        cells = (f"{scale * row['displacement']:+.9f}", predicted, str(row["order"] or ""))
        table.add_row(f"{row['amplitude_rad']:.6g}", *cells, "reversed" if row["reversed"] else "")
    console.print(table)
    if document["sweep"]:
        console.print(f"sweep in {document['sweep']}", soft_wrap=True)


def show_ratios(console: Console, document: LinkRatioDocument) -> None:
    """Show a gait for swimmers of many link ratios."""
    unit, scale = _shown_unit(document["unit"])
    table = plain_table(f"{document['gait']}: one cycle along {_shown(document['along'])}, at the same full length")
    table.add_column("middle / outer link", justify="right")
    table.add_column(f"displacement [{unit}]", justify="right")
    table.add_column("")
    for row in document["rows"]:
        best = "most" if row["ratio"] == document["best_ratio"] else ""
        table.add_row(f"{row['ratio']:.6g}", f"{scale * row['displacement']:+.9g}", best)
    console.print(table)
    if document["sweep"]:
        console.print(f"sweep in {document['sweep']}", soft_wrap=True)
