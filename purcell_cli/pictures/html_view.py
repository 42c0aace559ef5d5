"""A motion as one page of HTML: the swimmer in space, played, with a plot that follows.

The page holds all it needs and asks the network for nothing. It draws on two canvases; the links are
seen from afar, where a capsule is exactly a line with round ends. Conventions: `rotations`.
"""

from __future__ import annotations

import base64
import json
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from purcell_cli.errors import ParameterError
from purcell_cli.files.atomic_file import whole_file
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import PHASES
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.pictures.surroundings import NOTHING, Surroundings
from purcell_cli.wording import length_unit

MOST_FRAMES = 12000
"""How many rows of a motion a page shows; the times between are interpolated."""


def shown_rows(table: Table, most: int = MOST_FRAMES) -> NDArray[np.int64]:
    """Return the rows that a page shows, in order.

    Between two switches of the controls each limb turns about one axis at one rate, so rows at the
    switches show the limbs as they are. They come first, then as many others as there is room for,
    evenly in time; a motion with more switches than room is shown at even times alone.

    Args:
        table: The motion.
        most: How many rows there is room for.
    """
    n = len(table.time_s)
    if n <= most:
        return np.arange(n)
    switch = np.any(table.rate_rad_s[1:] != table.rate_rad_s[:-1], axis=1)
    switch |= (table.phase[1:] != table.phase[:-1]) | (table.gait[1:] != table.gait[:-1])
    kept = np.unique([0, *np.flatnonzero(switch) + 1, n - 1])
    if len(kept) > most:
        kept = np.array([0, n - 1])
    times = np.linspace(table.time_s[0], table.time_s[-1], max(most - len(kept), 0))
    return np.union1d(kept, np.searchsorted(table.time_s, times))


def page(
    table: Table, swimmer: Swimmer, title: str, beside: Table | None = None, around: Surroundings = NOTHING
) -> str:
    """Return the page of a motion.

    Args:
        table: The motion.
        swimmer: The swimmer, for the lengths and the thickness of its links.
        title: What it is.
        beside: Another motion of the same times that is played with it, if there is one.
        around: Obstacles, waypoints and the curve to follow, which are shown too.

    Raises:
        ParameterError: The other motion has other times.
    """
    if beside is not None and not np.array_equal(beside.time_s, table.time_s):
        raise ParameterError("beside: a trajectory of the same times, row by row, is wanted, found one of others")
    rows = shown_rows(table)
    place = table.position_m - table.origin_m
    frames = _frames(table, table.origin_m)[rows]
    names, gait = np.unique(table.gait[rows], return_inverse=True)
    size = float(max(np.max(np.abs(place)), swimmer.length_m))
    unit, unit_name = length_unit(size)
    data = {
        "title": f"{title}{origin_told(table)}",
        "time": _packed(table.time_s[rows], "<f8"),
        "frames": _packed(frames, "<f4"),
        "phase": _packed(np.clip(table.phase[rows], 0, 255), "u1"),
        "gait": _packed(gait, "<u4"),
        "gaits": names.tolist(),
        "phases": {str(phase): f"{phase} {name}" for phase, name in PHASES.items()},
        "halves": swimmer.halves_m,
        "radii": swimmer.radii_m,
        "body_radius": swimmer.body_radius_m,
        "beside": None if beside is None else _packed(_frames(beside, table.origin_m)[rows], "<f4"),
        **_shown(around, table),
        "unit": unit,
        "unit_name": unit_name,
    }
    text = json.dumps(data, ensure_ascii=False, allow_nan=False).replace("<", "\\u003c")
    template = (resources.files("purcell_cli.pictures") / "view.html").read_text(encoding="utf-8")
    return template.replace("@DATA@", text)


def _shown(around: Surroundings, table: Table) -> dict[str, Any]:
    """Return what a page draws around a motion."""
    away = table.origin_m
    return {
        "skins": [
            {"of": one.of, "triangles": _packed(one.triangles - away, "<f4"), "alpha": one.alpha}
            for one in around.skins(table)
        ],
        "curve": _packed(around.curve_m - away, "<f4"),
        "marks": [
            {
                "name": one.name,
                "place": (one.place_m - away).tolist(),
                "placed": one.placed,
                "axes": None if one.orientation is None else one.orientation.T.tolist(),
            }
            for one in around.marks(table)
        ],
    }


def _frames(table: Table, origin_m: Array) -> Array:
    """Return positions [m] and quaternions of base and limbs, row by row. Shape (n, 15)."""
    return np.concatenate([table.position_m - origin_m, table.base, table.limbs[:, 0], table.limbs[:, 1]], axis=1)


def origin_told(table: Table) -> str:
    """Return where positions are measured from, in words, where that is not the world's origin."""
    x, y, z = table.origin_m.tolist()
    return f", from ({x:.12g}, {y:.12g}, {z:.12g}) m" if np.any(table.origin_m) else ""


def write_page(
    table: Table,
    swimmer: Swimmer,
    title: str,
    path: Path,
    beside: Table | None = None,
    around: Surroundings = NOTHING,
) -> int:
    """Write the page of a motion, see `page`, and return how many bytes it has.

    Raises:
        InputError: The file cannot be written.
    """
    text = page(table, swimmer, title, beside, around).encode()
    with whole_file(path) as stream:
        stream.write(text)
    return len(text)


def _packed(values: NDArray[Any], kind: str) -> str:
    """Return numbers as base64 of their bytes."""
    return base64.b64encode(np.ascontiguousarray(values).astype(kind).tobytes()).decode()
