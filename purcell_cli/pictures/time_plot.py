"""Pictures of a motion against time, and what all pictures share.

They need matplotlib, the package's extra `plot`. Colours are those of Okabe and Ito, which people who
see few colours tell apart. The same picture is the same bytes. Conventions: `rotations`.
"""

from __future__ import annotations

import math
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np

from purcell_cli.errors import InputError, MissingPackageError
from purcell_cli.files.trajectory_csv import whole_file
from purcell_cli.geometry.rotations import Array
from purcell_cli.motion.blocks import PHASES
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.wording import length_unit

try:
    import matplotlib as mpl
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
except ImportError:
    raise MissingPackageError(
        "pictures need matplotlib, found none; install it: python -m pip install 'matplotlib>=3.8'"
    ) from None

FORMATS = ("png", "svg", "pdf")
"""The formats of a picture, by the file's ending."""

BLUE, ORANGE, GREEN, PINK, BLACK, GREY = "#0072B2", "#D55E00", "#009E73", "#CC79A7", "#222222", "#666666"
_STYLE: Any = {
    "axes.edgecolor": GREY,
    "axes.grid": True,
    "axes.labelsize": 9,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 10,
    "figure.constrained_layout.use": True,
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "lines.linewidth": 1.4,
    "path.simplify_threshold": 0.5,
    "savefig.dpi": 150,
    "svg.hashsalt": "purcell",
}

_TINTS = {1: "#E69F00", 2: "#56B4E9", 3: "#009E73"}
_VECTOR_ROWS = 5000
"""Longer lines are drawn as pixels in a picture of lines."""


def picture_format(path: Path) -> str:
    """Return the format that a picture's file ends in.

    Raises:
        InputError: The ending is none of `FORMATS`.
    """
    ending = path.suffix.removeprefix(".").lower()
    if ending not in FORMATS:
        raise InputError(f"{path}: wanted a picture's ending ({', '.join(FORMATS)}), found {path.suffix or 'none'}")
    return ending


def styled() -> AbstractContextManager[None]:
    """Return the context in which figures are drawn and written, which gives them their style."""
    return mpl.rc_context(_STYLE)


def save_figure(figure: Figure, path: Path) -> None:
    """Write a picture in the format of its file's ending, without a date.

    Raises:
        InputError: The ending is none of `FORMATS`, or the file cannot be written.
    """
    form = picture_format(path)
    undated: dict[str, dict[str, None]] = {
        "png": {"Software": None},
        "svg": {"Date": None, "Creator": None},
        "pdf": {"CreationDate": None, "Creator": None, "Producer": None},
    }
    with styled(), whole_file(path) as stream:
        figure.savefig(stream, format=form, metadata=undated[form])


def make_folder(path: Path) -> None:
    """Make a folder for pictures where there is none.

    Raises:
        InputError: It cannot be made.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(
            f"{path}: wanted a folder to write to, found none that can be made ({error.strerror})"
        ) from None


def control_legs(rate: Array) -> list[tuple[int, int]]:
    """Return the first row of each stretch of the same controls, and the row that ends it."""
    switch = np.flatnonzero(np.any(rate[1:] != rate[:-1], axis=1)) + 1
    return list(zip([0, *switch[:-1]], switch, strict=True)) if len(switch) else []


def time_figure(table: Table, title: str) -> Figure:
    """Return the angles of both limbs, and the base's position and angles, against time.

    Args:
        table: The motion.
        title: What it is.
    """
    scale, unit = length_unit(float(np.max(np.abs(table.position_m))))
    degrees = np.degrees(table.euler_rad)
    panels = [
        ("limb 1 [°]", degrees[:, 1], ("yaw", "pitch", "roll")),
        ("limb 2 [°]", degrees[:, 2], ("yaw", "pitch", "roll")),
        (f"base position [{unit}]", table.position_m * scale, ("x", "y", "z")),
        ("base angles [°]", degrees[:, 0], ("yaw ψ", "pitch θ", "roll φ")),
    ]
    phases = _stretches(table.time_s, table.phase)
    with styled():
        figure = Figure(figsize=(8.0, 7.2))
        rows = figure.subplots(len(panels), 1, sharex=True)
        for axes, (label, values, names) in zip(rows, panels, strict=True):
            for k, (name, colour) in enumerate(zip(names, (BLUE, ORANGE, GREEN), strict=True)):
                jumps = 360.0 if "°" in label else math.inf
                time, line = _broken(table.time_s, values[:, k], 0.5 * jumps)
                axes.plot(time, line, color=colour, label=name, rasterized=len(time) > _VECTOR_ROWS, zorder=3 - 0.1 * k)
            axes.set_ylabel(label)
            axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5), handlelength=1.2)
            axes.axhline(0.0, color=GREY, linewidth=0.5, zorder=1)
            _least_range(axes)
            for phase, begin, end in phases:
                axes.axvspan(begin, end, color=_TINTS.get(int(phase), GREY), alpha=0.14, linewidth=0)
        _name_phases(rows[0], phases)
        rows[-1].set_xlabel("time [s]")
        rows[-1].set_xlim(float(table.time_s[0]), float(max(table.time_s[-1], table.time_s[0] + 1e-9)))
        figure.suptitle(title, fontsize=11)
        figure.align_ylabels(rows)
    return figure


def _least_range(axes: Axes) -> None:
    """Keep round-off from filling a panel in which nothing moves."""
    low, high = axes.get_ylim()
    if high - low < 1e-6:
        axes.set_ylim(-1.0, 1.0)


def _broken(time: Array, values: Array, jump: float) -> tuple[Array, Array]:
    """Return a line with gaps where an angle jumps by a whole turn."""
    where = np.flatnonzero(np.abs(np.diff(values)) > jump) + 1
    return np.insert(time, where, np.nan), np.insert(values, where, np.nan)


def _stretches(time: Array, value: Array) -> list[tuple[float, float, float]]:
    """Return each stretch of rows with the same value: value, begin and end [s]; none where there is one alone."""
    first = np.flatnonzero(np.append(True, value[1:] != value[:-1]))
    last = [*first[1:], len(value) - 1]
    found = [(float(value[a]), float(time[a]), float(time[b])) for a, b in zip(first, last, strict=True)]
    return found if len(found) > 1 else []


def _name_phases(axes: Axes, phases: list[tuple[float, float, float]]) -> None:
    """Name the phases over a panel, those that are short by their number alone."""
    whole = sum(end - begin for _, begin, end in phases)
    for phase, begin, end in phases:
        name = f"{phase:g} {PHASES.get(int(phase), '')}"
        wide = end - begin > 0.011 * len(name) * whole
        where = axes.get_xaxis_transform()
        axes.text(0.5 * (begin + end), 1.03, name if wide else f"{phase:g}", transform=where, ha="center", fontsize=8)
