"""Pictures of a stroke as a row of poses: the swimmer where each of its controls begins and ends.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle

from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.primitives import CONTROL_NAMES
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.trajectory import Trajectory
from purcell_cli.pictures.colours import BLACK, BLUE, GREY, ORANGE
from purcell_cli.pictures.style import control_legs, styled

_IN_A_ROW = 5
"""Poses side by side: on a page's width their labels of 8 points still stand apart."""

_MOST = 20
"""Where controls switch more often, poses are drawn at even times."""
LINKS = (ORANGE, BLACK, BLUE)
"""Colours of limb 2, base and limb 1."""

NAMES = ("limb 2", "base", "limb 1")
_MARK_L = 0.35
"""Length of the marks that show how far a link has rolled [L]: they stand out of the links and do not meet."""


def link_points(swimmer: Swimmer, trajectory: Trajectory, row: int) -> Array:
    """Return limb 2's tip, its joint, limb 1's joint and its tip in the world, in units of L. Shape (4, 3)."""
    pose, shape = trajectory.pose[row], trajectory.shape[row]
    x = np.array([1.0, 0.0, 0.0])
    base, one, two = (half * x for half in swimmer.halves_m)
    points = np.stack([-base - shape[1] @ (2.0 * two), -base, base, base + shape[0] @ (2.0 * one)])
    return np.asarray((points @ pose[:3, :3].T + pose[:3, 3]) / swimmer.length_m)


def roll_marks(swimmer: Swimmer, trajectory: Trajectory, row: int, side: int) -> Array:
    """Return the links' middles and the ends of marks there along their own axes of an index, in units of L.

    Limb 2, base, limb 1, as the links are drawn. Shape (3, 2, 3).
    """
    points, pose, shape = link_points(swimmer, trajectory, row), trajectory.pose[row, :3, :3], trajectory.shape[row]
    middles = 0.5 * (points[1:] + points[:-1])
    along = np.stack([pose @ shape[1][:, side], pose[:, side], pose @ shape[0][:, side]])
    return np.stack([middles, middles + _MARK_L * along], axis=1)


def draw_links(axes: Axes, flat: Array, alpha: float = 1.0, width: float = 2.2, level: int = 2) -> None:
    """Draw the three links between four points of a picture. Shape (4, 2)."""
    style: dict[str, Any] = {"linewidth": width, "alpha": alpha, "zorder": level, "solid_capstyle": "round"}
    for k, colour in enumerate(LINKS):
        axes.plot(flat[k : k + 2, 0], flat[k : k + 2, 1], color=colour, **style)


def poses_figure(swimmer: Swimmer, trajectory: Trajectory, title: str) -> Figure:
    """Return the swimmer at every switch of its controls, or at even times where these are many.

    It is seen from above, or from the side if it moves more there. Where it began is drawn in grey.

    Args:
        swimmer: The swimmer.
        trajectory: One cycle of the stroke.
        title: What it is.
    """
    legs = control_legs(trajectory.rate_rad_s)
    rows = [0, *(high for _, high in legs)]
    names = ["start", *(_leg_name(trajectory, low, high) for low, high in legs)]
    if len(rows) > _MOST:
        rows = np.linspace(0, len(trajectory) - 1, 2 * _IN_A_ROW).astype(int).tolist()
        names = [f"{time:.3g} s" for time in trajectory.time_s[rows]]
    points = np.stack([link_points(swimmer, trajectory, row) for row in rows])
    up = 1 if np.ptp(points[..., 1]) >= np.ptp(points[..., 2]) else 2
    flat = points[..., [0, up]]
    lines = -(-len(rows) // _IN_A_ROW)
    low, high = flat.min(axis=(0, 1)) - 0.5, flat.max(axis=(0, 1)) + 0.5
    with styled():
        figure = Figure(figsize=(9.5, 0.9 + lines * (0.5 + 1.75 * float(high[1] - low[1]) / float(high[0] - low[0]))))
        cells = figure.subplots(lines, _IN_A_ROW, squeeze=False).ravel()
        for k, axes in enumerate(cells):
            axes.axis("off")
            if k >= len(rows):
                continue
            axes.plot(flat[0, :, 0], flat[0, :, 1], color="#cccccc", linewidth=1.2)
            draw_links(axes, flat[k])
            if swimmer.body_radius_m:
                middle = 0.5 * (flat[k, 1] + flat[k, 2])
                axes.add_patch(Circle(middle, swimmer.body_radius_m / swimmer.length_m, color=BLACK, alpha=0.4))
            for mark, colour in zip(roll_marks(swimmer, trajectory, rows[k], up), LINKS, strict=True):
                axes.plot(mark[:, 0], mark[:, up], color=colour, linewidth=1.2, solid_capstyle="butt")
                axes.plot(*mark[1, [0, up]], marker=".", markersize=4, color=colour)
            axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
            axes.set_title(names[k], fontsize=8, color=GREY)
        figure.suptitle(f"{title}, seen in the plane x-{'xyz'[up]}", fontsize=10)
        handles = [
            Line2D([], [], color=colour, linewidth=2.2, label=name) for colour, name in zip(LINKS, NAMES, strict=True)
        ]
        mark = f"marks: each link's own {'xyz'[up]}, which a roll turns out of the picture"
        handles.append(Line2D([], [], color=GREY, linewidth=1.2, marker=".", markersize=4, label=mark))
        figure.legend(handles=handles[2::-1] + handles[3:], loc="outside lower center", ncols=4)
    return figure


def _leg_name(trajectory: Trajectory, low: int, high: int) -> str:
    """Return which control turned on a leg, and by how much."""
    turn = trajectory.rate_rad_s[low] * (trajectory.time_s[high] - trajectory.time_s[low])
    acting = np.flatnonzero(turn)
    if len(acting) != 1:
        return f"{len(acting)} controls at once"
    return f"{CONTROL_NAMES[acting[0]]} {turn[acting[0]]:+.2f} rad"
