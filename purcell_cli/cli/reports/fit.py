"""A fitted swimmer as a JSON document, as a table, and as remarks in its file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, cast

from purcell_cli.cli.documents.fit import FactorPart, FitDocument, LeftPart
from purcell_cli.cli.reports.common import plain_table, swimmer_document
from purcell_cli.feedback.drag_factors import What
from purcell_cli.feedback.fit import Fit, Left
from purcell_cli.mechanics.drag import LINKS
from purcell_cli.wording import counted

if TYPE_CHECKING:
    from rich.console import Console

_UNITS = {"along": " N s/m", "across": " N s/m", "turn": " N m s", "spin": " N m s", "ratio": ""}
"""The units of drags."""


def fit_document(found: Fit, what: What, measured: Sequence[str], out: str | None) -> FitDocument:
    """Return a fitted swimmer.

    Args:
        found: The fit.
        what: Which factors were fitted.
        measured: The measured trajectories' files.
        out: The file of the fitted swimmer, if there is one.
    """
    factors: list[FactorPart] = [
        {
            "name": f.factor.name,
            "links": cast(Any, [LINKS[k] for k in f.factor.links]),
            "drag": cast(Any, f.factor.direction),
            "value": f.value,
            "standard_error": f.standard_error,
            "told": f.told,
            "only_with": list(f.only_with),
            "guess": [f.factor.value(found.guess.rod(k)) for k in f.factor.links],
            "fitted": [f.factor.value(found.swimmer.rod(k)) for k in f.factor.links],
        }
        for f in found.factors
    ]
    return {
        "schema": "purcell/fit/1",
        "verdict": "fitted" if found.settled else "not settled",
        "measured": list(measured),
        "what": cast(Any, str(what)),
        "guess": swimmer_document(found.guess),
        "swimmer": swimmer_document(found.swimmer),
        "factors": factors,
        "untold": [f["name"] for f in factors if not f["told"]],
        "rows": found.rows,
        "windows": found.windows,
        "left_by_guess": _left(found.before),
        "left": _left(found.after),
        "out": out,
    }


def _left(left: Left) -> LeftPart:
    return {"position_l": left.position_l, "angle_deg": math.degrees(left.angle_rad)}


def show_fit(console: Console, document: FitDocument) -> None:
    """Show a fitted swimmer."""
    table = plain_table("Drag from measured motion")
    for heading in ("drag", "guess", "fitted", "factor", "+-", "told by the data"):
        table.add_column(heading, justify="left" if heading in {"drag", "told by the data"} else "right")
    for f in document["factors"]:
        numbers = (_numbers(f[which], _UNITS[f["drag"]]) for which in ("guess", "fitted"))
        error = "" if f["standard_error"] is None else f"{f['standard_error']:.2g}"
        table.add_row(f["name"], *numbers, f"{f['value']:.5g}", error, _told(f))
    console.print(table)
    before, after = document["left_by_guess"], document["left"]
    console.print(
        f"of {counted(document['rows'], 'row')} in {counted(document['windows'], 'window')} the guess leaves "
        f"{before['position_l']:.2g} L and {before['angle_deg']:.2g} deg, the fit {after['position_l']:.2g} L and "
        f"{after['angle_deg']:.2g} deg"
    )
    console.print("motion tells no forces: the base's drag across, which the viscosity sets, is the unit of the others")
    if document["verdict"] != "fitted":
        console.print("not settled: what the data ask for is no drag that links can have", style="bold red")
    if document["out"] is not None:
        console.print(f"the fitted swimmer is in {document['out']}", soft_wrap=True)


def _numbers(values: Sequence[float], unit: str) -> str:
    return ", ".join(f"{value:.5g}" for value in dict.fromkeys(values)) + unit


def _told(factor: FactorPart) -> str:
    if factor["told"]:
        return "yes"
    together = f", only together with {' and '.join(factor['only_with'])}" if factor["only_with"] else ""
    return f"no{together}: as in the guess"


def remarks(document: FitDocument) -> list[str]:
    """Return what the fitted swimmer's file says of the fit at its top."""
    lines = [f"drag fitted to {len(document['measured'])} measured trajectories: factors on the guess"]
    for f in document["factors"]:
        error = "" if f["standard_error"] is None else f" +- {f['standard_error']:.2g}"
        lines.append(f"  {f['name']}: {f['value']:.5g}{error}{'' if f['told'] else f' ({_told(f)})'}")
    return [*lines, "  base across: 1, by the viscosity (motion tells no forces)"]
