"""What the commands say: one document for each result, printed as JSON or shown as tables."""

from __future__ import annotations

import codecs
import json
import math
import sys
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, cast

from purcell_cli.cli.documents.common import (
    CertificatePart,
    DeviationPart,
    DisplacementPart,
    Failure,
    SwimmerPart,
)
from purcell_cli.files.swimmer_file import swimmer_written
from purcell_cli.geometry.rotations import Array, as_euler
from purcell_cli.mechanics.configuration import Deviation
from purcell_cli.mechanics.swimmer import Swimmer

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from purcell_cli.verification.certificate import Certificate


def as_json(document: Mapping[str, Any], indent: int | None = None) -> str:
    """Return a document as JSON that stdout can encode, on one line where no indent is asked for.

    NaN has no place in it. JSON is UTF-8; where stdout is not, and in a file's name that is no text, characters are
    escaped.
    """
    text = json.dumps(document, allow_nan=False, ensure_ascii=False, indent=indent)
    encoding = getattr(sys.stdout, "encoding", None) or "utf-8"
    if text.isascii() or (codecs.lookup(encoding).name == "utf-8" and _is_text(text)):
        return text
    return json.dumps(document, allow_nan=False, indent=indent)


def _is_text(text: str) -> bool:
    """Return whether a text has no halves of characters, which bytes of a name that are no UTF-8 become."""
    return not any("\ud800" <= character <= "\udfff" for character in text)


def error_document(command: str, message: str) -> Failure:
    """Return the document of a command that could not be carried out."""
    return {"schema": f"purcell/{command}/1", "verdict": "error", "error": message}


def displacement_document(g: Array) -> DisplacementPart:
    """Return a body displacement."""
    psi, theta, phi = as_euler(g[:3, :3]).tolist()
    return {"position_m": g[:3, 3].tolist(), "psi_rad": psi, "theta_rad": theta, "phi_rad": phi}


def deviation_document(deviation: Deviation, length_m: float) -> DeviationPart:
    """Return how far one configuration is from another, for a length L [m]."""
    return {
        "position_m": deviation.position_m,
        "position_over_L": deviation.position_m / length_m,
        "base_rad": deviation.base_rad,
        "limb1_rad": deviation.limb1_rad,
        "limb2_rad": deviation.limb2_rad,
    }


def certificate_document(found: Certificate) -> CertificatePart:
    """Return how controls were re-integrated."""
    return {
        "method": "extrapolation",
        "segments": found.segments,
        "integrated": found.integrated,
        "bound": {"position_m": found.bound.position_m, "angle_rad": found.bound.base_rad},
    }


def swimmer_document(swimmer: Swimmer) -> SwimmerPart:
    """Return a swimmer's parameters."""
    return cast(SwimmerPart, {**swimmer_written(swimmer), "L_m": swimmer.length_m})


def displacement_cells(displacement: DisplacementPart, length_m: float, digits: int) -> list[str]:
    """Return a displacement's x, y, z in mm and psi, theta, phi in degrees, for a table."""

    def shown(value: float, unit: float, scale: float) -> str:
        places = digits - 2 - math.floor(math.log10(scale * unit / 50.0))
        told = round(scale * value, places) + 0.0
        return f"{told:.{digits}g}" if abs(told) < 10.0 ** (digits - 1) else f"{told:.0f}"

    angles = displacement["psi_rad"], displacement["theta_rad"], displacement["phi_rad"]
    return [
        ", ".join(shown(v, length_m, 1e3) for v in displacement["position_m"]),
        ", ".join(shown(v, 1.0, math.degrees(1.0)) for v in angles),
    ]


def angles_deg(roll: float, pitch: float, yaw: float) -> tuple[float, float, float]:
    """Return psi, theta and phi, which are yaw, pitch and roll, in degrees from radians."""
    return math.degrees(yaw), math.degrees(pitch), math.degrees(roll)


def turned_from_curve(turned_rad: float | None) -> str:
    """Return how far the base is turned from a curve's orientation, in words; nothing where that is free."""
    return "" if turned_rad is None else f", turned from its orientation by {math.degrees(turned_rad):.3g} deg at most"


def plain_table(title: str) -> Table:
    """Return a table with a title, and lines under its headings alone."""
    from rich.box import SIMPLE_HEAD
    from rich.table import Table

    return Table(title=title, title_justify="left", box=SIMPLE_HEAD)


_WIDEST = 10_000
"""Columns in which any table has room."""


def fits(console: Console, table: Table) -> bool:
    """Return whether there is room for a table with no cell broken or cut."""
    return console.measure(table, options=console.options.update(width=_WIDEST)).maximum <= console.width


def _checked(console: Console, certificate: CertificatePart) -> None:
    counts = f"{certificate['segments']} segments of constant control, {certificate['integrated']} of them distinct"
    console.print(f"checked by {certificate['method']}: {counts}")


def _verdict(console: Console, verdict: str) -> None:
    console.print(verdict, style=f"bold {'green' if verdict == 'reached' else 'red'}")
