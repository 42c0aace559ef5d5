"""What `purcell controllability` says: the documents, and the tables of them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, cast

import numpy as np

from purcell_cli.cli.documents.common import Direction
from purcell_cli.cli.documents.controllability import (
    BracketPart,
    ControllabilityDocument,
    LevelPart,
    MapDocument,
    RankPart,
    WeakestPart,
)
from purcell_cli.cli.reports.common import plain_table, swimmer_document
from purcell_cli.geometry.rotations import Array, as_euler
from purcell_cli.lie_brackets.bracket_gaits import TRUST, prediction
from purcell_cli.lie_brackets.control_fields import word_name
from purcell_cli.lie_brackets.controllability import DIRECTIONS, Bracket, Controllability, Level, makers
from purcell_cli.lie_brackets.ranks import WEAK, Rank
from purcell_cli.lie_brackets.weak_shapes import ShapeStrength, weakest
from purcell_cli.mechanics.swimmer import Swimmer

if TYPE_CHECKING:
    from rich.console import Console


_WHOLE = 24
"""Characters of a direction up to which none is broken: at bent shapes each has parts of all six."""


def _named(rows: Array, names: Sequence[str]) -> list[dict[str, float]]:
    """Return vectors as what they have of each name, zeros left out."""
    return [{name: float(x) for name, x in zip(names, row, strict=True) if x != 0.0} for row in rows]


def _rank(rank: Rank) -> RankPart:
    return {
        "dimension": rank.dimension,
        "not_weak": rank.clear_dimension,
        "singular_values": rank.singular_values.tolist(),
        "rounding": rank.floor,
        "gap": rank.gap if math.isfinite(rank.gap) else None,
        "decision": rank.robustness,
    }


def _level(level: Level, names: Sequence[str]) -> LevelPart:
    return {
        "level": level.number,
        "brackets": level.count,
        **_rank(level.rank),
        "new_directions": _named(level.added, names),
    }


def _bracket(found: Controllability, bracket: Bracket, direction: int) -> BracketPart:
    told = prediction(found.swimmer, found.shape, bracket, direction)
    limbs = [word_name((control,)) for control in range(6)]
    return {
        "bracket": word_name(bracket.word),
        "depth": told.depth,
        "rate": told.rate,
        "twist": _named(np.where(np.abs(bracket.twist) < 1e-12, 0.0, bracket.twist)[None], DIRECTIONS)[0],
        "limbs_to_bring_back": _named(bracket.limbs[None], limbs)[0],
        "trusted_rad": told.trusted_rad,
    }


def controllability_document(found: Controllability, planar: bool, depth: int) -> ControllabilityDocument:
    """Return what can be reached from a shape, by which brackets, and how safely that is known."""
    names = [DIRECTIONS[row] for row in found.rows]
    limbs = [word_name((control,)) for control in found.controls]
    euler = np.degrees(as_euler(found.shape)).tolist()
    out: ControllabilityDocument = {
        "schema": "purcell/controllability/1",
        "verdict": found.verdict,
        "swimmer": swimmer_document(found.swimmer),
        "shape": {"limb1_euler_deg": euler[0], "limb2_euler_deg": euler[1]},
        "planar": planar,
        "depth": depth,
        "dimension": found.dimension,
        "growth_vector": list(found.growth),
        "chow": found.chow,
        "weak_level": found.weak_level,
        "weak_below": WEAK,
        "direct": _rank(found.direct),
        "null_directions": _named(found.null, limbs),
        "depths": [_level(level, names) for level in found.depths],
        "filtration": [_level(level, names) for level in found.levels],
        "trusted_within": TRUST,
        "directions": [
            {
                "direction": cast(Direction, DIRECTIONS[row]),
                "brackets": [_bracket(found, b, row) for b in makers(found, row)],
            }
            for row in found.rows
        ],
    }
    if found.beside is not None:
        out["beside"] = {"height_m": float(found.beside[3]), "normal": found.beside[:3].tolist()}
    return out


def _weakest(rank: Rank) -> WeakestPart:
    value, direction = weakest(rank)
    return {**_rank(rank), "least": value, "weakest": cast(Direction, direction)}


def map_document(found: Sequence[ShapeStrength], swimmer: Swimmer, depth: int, picture: str | None) -> MapDocument:
    """Return how strong the weakest direction is over a grid of shapes."""
    return {
        "schema": "purcell/controllability-map/1",
        "verdict": "done",
        "swimmer": swimmer_document(swimmer),
        "depth": depth,
        "weak_below": WEAK,
        "shapes": [
            {
                "bend_deg": math.degrees(s.bend_rad),
                "roll_deg": math.degrees(s.roll_rad),
                "direct": _rank(s.direct),
                "filtration_2": _weakest(s.weak),
                "brackets": _weakest(s.strong),
            }
            for s in found
        ],
        "picture": picture,
    }


def sum_text(parts: Mapping[str, float]) -> str:
    """Return a vector in words, like 'roll 1 - roll 2'."""
    out = ""
    for name, x in parts.items():
        sign = ("-" if x < 0 else "") if not out else (" - " if x < 0 else " + ")
        size = abs(x)
        out += sign + (name if abs(size - 1.0) < 1e-9 else f"{size:.3g} {name}")
    return out


def _values(rank: RankPart) -> str:
    return " ".join(f"{v:.2g}" if k < rank["dimension"] else "0" for k, v in enumerate(rank["singular_values"]))


def show_controllability(console: Console, document: ControllabilityDocument) -> None:
    """Show what can be reached from a shape as tables and sentences."""
    shape, swimmer = document["shape"], "planar swimmer" if document["planar"] else "swimmer"
    limbs = shape["limb1_euler_deg"], shape["limb2_euler_deg"]
    angles = [", ".join(f"{round(x, 9) + 0.0:.6g}" for x in limb) for limb in limbs]
    console.print(f"{swimmer}, limb 1 at ({angles[0]}), limb 2 at ({angles[1]}): psi, theta, phi [deg]")
    if "beside" in document:
        normal = ", ".join(f"{x + 0.0:.4g}" for x in document["beside"]["normal"])
        height = document["beside"]["height_m"] / document["swimmer"]["L_m"]
        console.print(f"{height:.4g} L above a wall whose normal is ({normal}) in base coordinates")
    controls = document["growth_vector"][0]
    for title, levels, low in (
        ("Brackets of the control fields, the limbs brought back", document["depths"], controls),
        ("Spaces of appendix A, the shape left free", document["filtration"], 0),
    ):
        if not levels:
            continue
        table = plain_table(title)
        for heading in ("depth" if low else "space", "brack-\nets", "dimen-\nsion", "not\nweak"):
            table.add_column(heading, justify="right", no_wrap=True)
        directions = [sum_text(d) for level in levels for d in level["new_directions"]]
        whole = max(map(len, directions), default=0) <= _WHOLE
        for heading, unbroken in (("new\ndirections", whole), ("singular values\n[L, rad]", False)):
            table.add_column(heading, no_wrap=unbroken)
        for heading in ("gap", "rank\nis"):
            table.add_column(heading, no_wrap=True)
        if low:
            table.add_row("1", str(low), str(low), str(low), "the limbs", "", "", "clear")
        for level in levels:
            number = level["level"]
            table.add_row(
                str(number) if low else " + ".join(f"h{k}" for k in range(1, number + 1)),
                str(level["brackets"]),
                str(low + level["dimension"]),
                str(low + level["not_weak"]),
                ("\n" if whole else ";\n").join(sum_text(d) for d in level["new_directions"]),
                _values(level),
                "" if level["gap"] is None else f"{level['gap']:.0e}",
                level["decision"],
            )
        console.print(table)
    _show_brackets(console, document)
    still = [sum_text(d) for d in document["null_directions"]]
    console.print(
        f"A(r) has rank {document['direct']['dimension']}, {document['direct']['not_weak']} of it not weak: "
        f"{_values(document['direct'])}" + ("; the base stays still in " + ", ".join(still) if still else "")
    )
    for line in conclusions(document):
        console.print(line)
    good = document["verdict"] in {"controllable", "weakly controllable"}
    console.print(document["verdict"], style=f"bold {'green' if good else 'red'}")


def _show_brackets(console: Console, document: ControllabilityDocument) -> None:
    table = plain_table("Which bracket gives which motion, for turns of a [rad]")
    for heading in ("direction", "bracket", "motion", "beside it", "holds to\na [rad]", "limb to\nturn back"):
        table.add_column(heading, no_wrap=heading in {"direction", "motion"})
    for part in document["directions"]:
        for k, bracket in enumerate(part["brackets"]):
            unit = "L" if part["direction"] in DIRECTIONS[:3] else "rad"
            beside = {n: x for n, x in bracket["twist"].items() if n != part["direction"]}
            table.add_row(
                part["direction"] if k == 0 else "",
                bracket["bracket"],
                f"{bracket['rate']:.4g} {unit} a^{bracket['depth']}",
                sum_text({n: x for n, x in beside.items() if abs(x) > 1e-3 * abs(bracket["rate"])}),
                _trusted(bracket["trusted_rad"]),
                sum_text(bracket["limbs_to_bring_back"]),
            )
    console.print(table)


def _trusted(amplitude: float | None) -> str:
    return "" if amplitude is None else f"{amplitude:.3g}" if amplitude else "< 0.001"


def conclusions(document: ControllabilityDocument) -> list[str]:
    """Return the answers in sentences, with what they hang on."""
    full, low = document["dimension"], document["growth_vector"][0]
    growth = ", ".join(map(str, document["growth_vector"]))
    lines = [f"growth vector ({growth}) of {full}"]
    wanted = full - low
    for word, levels, what in (
        ("depth", document["depths"], "Chow's condition"),
        ("level", document["filtration"], "weak controllability"),
    ):
        there = [x for x in levels if x["dimension"] == wanted]
        if not levels:
            lines.append(f"{what} rests on left invariance, which a wall breaks")
            continue
        if not there:
            last = levels[-1]
            lines.append(
                f"{what} is not seen up to {word} {last['level']}: {wanted - last['dimension']} directions are missing"
            )
            continue
        first = there[0]
        line = f"{what} holds at {word} {first['level']}"
        least = first["singular_values"][wanted - 1]
        if first["decision"] == "undecided":
            line += (
                f", but rounding could be it: the least singular value is {least:.1e}, rounding {first['rounding']:.1e}"
            )
        elif first["not_weak"] < wanted:
            line += f", by directions as weak as {least:.1e}"
            clear = [x for x in there if x["not_weak"] == wanted]
            line += (
                f"; with none weak at {word} {clear[0]['level']}"
                if clear
                else f"; weak up to {word} {there[-1]['level']}"
            )
        else:
            line += f", with none weak: the least singular value is {least:.2g}"
        lines.append(line)
    return lines


def show_map(console: Console, document: MapDocument) -> None:
    """Show how strong the weakest direction is over a grid of shapes."""
    shapes = document["shapes"]
    rolls = list(dict.fromkeys(s["roll_deg"] for s in shapes))
    free, back = [s["filtration_2"] for s in shapes], [s["brackets"] for s in shapes]
    for title, found in (
        ("Least singular value of h1 + h2, the shape left free", free),
        (f"Least singular value of the brackets to depth {document['depth']}, the limbs brought back", back),
    ):
        table = plain_table(f"{title} [L, rad]")
        table.add_column("bend\n[deg]", justify="right")
        for roll in rolls:
            table.add_column(f"roll\n{roll:.4g}", justify="right")
        for bend in dict.fromkeys(s["bend_deg"] for s in shapes):
            mine = [m for s, m in zip(shapes, found, strict=True) if s["bend_deg"] == bend]
            table.add_row(f"{bend:.4g}", *(f"{m['least']:.1e} {m['weakest']}" for m in mine))
        console.print(table)
    weak = min(shapes, key=lambda s: s["brackets"]["least"])
    console.print(
        f"weakest: {weak['brackets']['weakest']} at bend {weak['bend_deg']:.4g} deg, roll {weak['roll_deg']:.4g} deg, "
        f"{weak['brackets']['least']:.2g} L or rad per rad^{document['depth']}"
    )
    if document["picture"]:
        console.print(f"picture in {document['picture']}", soft_wrap=True)
