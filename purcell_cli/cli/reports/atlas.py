"""The atlas of strokes as documents, tables and CSV."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal, cast

from purcell_cli.cli.documents.common import Moves, keys
from purcell_cli.cli.documents.gait import AtlasDocument, EntryPart, LinkRatioDocument, MotionPart, SweepDocument
from purcell_cli.cli.reports.common import swimmer_document
from purcell_cli.gaits.atlas import Entry, RatioRow, Sweep
from purcell_cli.gaits.gait import MOTIONS, Gait
from purcell_cli.mechanics.swimmer import Swimmer

if TYPE_CHECKING:
    from rich.console import Console


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


def _cell(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}" if abs(value) > 1e-11 else "0"


def show_atlas(console: Console, document: AtlasDocument) -> None:
    """Show the atlas as a table, one line for each gait."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(title="One cycle of each stored gait, seen from the collinear shape", title_justify="left")
    table.box = SIMPLE_HEAD
    table.add_column("gait", no_wrap=True)
    for heading in ("a\n[rad]", "x, y, z\n[L]", "roll, pitch, yaw\n[rad]", "cross-\ntalk", "travel\n[rad]"):
        table.add_column(heading, justify="right")
    for heading in ("time\n[s]", "energy\n[J]", "speed\n[L/rad]", "effic.\n[%]"):
        table.add_column(heading, justify="right", no_wrap=True)
    for g in document["gaits"]:
        moved = [_cell(cast(Mapping[str, float], g)[name]) for name in keys(MotionPart)]
        cross = "" if g["cross_talk"] is None else f"{g['cross_talk']:.0e}"
        cells = [f"{g['joint_travel_rad']:.4g}", f"{g['duration_s']:.4g}", f"{g['energy_j']:.3g}"]
        last = [f"{g['L_per_rad']:.4f}", f"{100.0 * g['efficiency']:.3f}"]
        table.add_row(
            g["gait"], f"{g['amplitude_rad']:.3g}", ", ".join(moved[:3]), ", ".join(moved[3:]), cross, *cells, *last
        )
    console.print(table)
    for gone in document["left_out"]:
        console.print(f"left out: {gone['why']}", soft_wrap=True)
    if document["atlas"]:
        console.print(f"atlas in {document['atlas']}", soft_wrap=True)


def show_sweep(console: Console, document: SweepDocument) -> None:
    """Show a gait at many amplitudes."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    table = Table(title=f"{document['gait']}: one cycle along {document['along']}", title_justify="left")
    table.box = SIMPLE_HEAD
    unit = document["unit"]
    for heading in ("amplitude [rad]", f"exact [{unit}]", f"leading order [{unit}]", "order"):
        table.add_column(heading, justify="right")
    table.add_column("")
    for row in document["rows"]:
        if row["displacement"] is None:
            table.add_row(f"{row['amplitude_rad']:.6g}", "", "", "", "no pure stroke")
            continue
        cells = (f"{row['displacement']:+.9f}", f"{row['prediction']:+.9f}", str(row["order"] or ""))
        table.add_row(f"{row['amplitude_rad']:.6g}", *cells, "reversed" if row["reversed"] else "")
    console.print(table)
    if document["sweep"]:
        console.print(f"sweep in {document['sweep']}", soft_wrap=True)


def show_ratios(console: Console, document: LinkRatioDocument) -> None:
    """Show a gait for swimmers of many link ratios."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    title = f"{document['gait']}: one cycle along {document['along']}, at the same full length"
    table = Table(title=title, title_justify="left", box=SIMPLE_HEAD)
    table.add_column("middle / outer link", justify="right")
    table.add_column(f"displacement [{document['unit']}]", justify="right")
    table.add_column("")
    for row in document["rows"]:
        best = "most" if row["ratio"] == document["best_ratio"] else ""
        table.add_row(f"{row['ratio']:.6g}", f"{row['displacement']:+.9g}", best)
    console.print(table)
    if document["sweep"]:
        console.print(f"sweep in {document['sweep']}", soft_wrap=True)
