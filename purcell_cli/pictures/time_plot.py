"""Pictures of a motion against time.

They need matplotlib, the package's extra `plot`. Colours are those of Okabe and Ito, which people who
see few colours tell apart. The same picture is the same bytes. Conventions: `rotations`.
"""

from __future__ import annotations

import math

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from purcell_cli.geometry.rotations import Array
from purcell_cli.motion.blocks import PHASES
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.pictures.colours import BLUE, GREEN, GREY, ORANGE
from purcell_cli.pictures.html_view import origin_told
from purcell_cli.pictures.style import styled
from purcell_cli.wording import length_unit

_TINTS = {1: "#E69F00", 2: "#56B4E9", 3: "#009E73"}
_VECTOR_ROWS = 5000
"""Longer lines are drawn as pixels in a picture of lines."""


def time_figure(table: Table, title: str) -> Figure:
    """Return the angles of both limbs, and the base's position and angles, against time.

    Args:
        table: The motion.
        title: What it is.
    """
    place = table.position_m - table.origin_m
    scale, unit = length_unit(float(np.max(np.abs(place))))
    degrees = np.degrees(table.euler_rad)
    panels = [
        ("limb 1 [°]", degrees[:, 1], ("yaw", "pitch", "roll")),
        ("limb 2 [°]", degrees[:, 2], ("yaw", "pitch", "roll")),
        (f"base position [{unit}]", place * scale, ("x", "y", "z")),
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
        figure.suptitle(f"{title}{origin_told(table)}", fontsize=11)
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
