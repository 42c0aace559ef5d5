"""Pictures of a stroke as a row of poses: the swimmer where each of its controls begins and ends.

Conventions: `rotations`; lengths in units of L.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.primitives import CONTROL_NAMES
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.trajectory import Trajectory
from purcell_cli.pictures.style import BLACK, BLUE, GREY, ORANGE, control_legs, styled

_IN_A_ROW = 5
"""Poses side by side: on a page's width their labels of 8 points still stand apart."""

_MOST = 20
"""Where controls switch more often, poses are drawn at even times."""
_LINKS = (ORANGE, BLACK, BLUE)
"""Colours of limb 2, base and limb 1."""


def link_points(swimmer: Swimmer, trajectory: Trajectory, row: int) -> Array:
    """Return limb 2's tip, its joint, limb 1's joint and its tip in the world, in units of L. Shape (4, 3)."""
    pose, shape = trajectory.pose[row], trajectory.shape[row]
    x = np.array([1.0, 0.0, 0.0])
    base, limb = swimmer.base_half_length_m * x, 2.0 * swimmer.limb_half_length_m * x
    points = np.stack([-base - shape[1] @ limb, -base, base, base + shape[0] @ limb])
    return np.asarray((points @ pose[:3, :3].T + pose[:3, 3]) / swimmer.length_m)


def draw_links(axes: Axes, flat: Array, alpha: float = 1.0) -> None:
    """Draw the three links between four points of a picture. Shape (4, 2)."""
    for k, colour in enumerate(_LINKS):
        axes.plot(
            flat[k : k + 2, 0], flat[k : k + 2, 1], color=colour, linewidth=2.2, alpha=alpha, solid_capstyle="round"
        )


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
    low, high = flat.min(axis=(0, 1)) - 0.3, flat.max(axis=(0, 1)) + 0.3
    with styled():
        figure = Figure(figsize=(9.5, 0.6 + lines * (0.5 + 1.75 * float(high[1] - low[1]) / float(high[0] - low[0]))))
        cells = figure.subplots(lines, _IN_A_ROW, squeeze=False).ravel()
        for k, axes in enumerate(cells):
            axes.axis("off")
            if k >= len(rows):
                continue
            axes.plot(flat[0, :, 0], flat[0, :, 1], color="#cccccc", linewidth=1.2)
            draw_links(axes, flat[k])
            axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
            axes.set_title(names[k], fontsize=8, color=GREY)
        figure.suptitle(f"{title}, seen in the plane x-{'xyz'[up]}", fontsize=10)
    return figure


def _leg_name(trajectory: Trajectory, low: int, high: int) -> str:
    """Return which control turned on a leg, and by how much."""
    turn = trajectory.rate_rad_s[low] * (trajectory.time_s[high] - trajectory.time_s[low])
    acting = np.flatnonzero(turn)
    if len(acting) != 1:
        return f"{len(acting)} controls at once"
    return f"{CONTROL_NAMES[acting[0]]} {turn[acting[0]]:+.2f} rad"
