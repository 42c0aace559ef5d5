"""Pictures of a stroke: over the curvature of its plane, or as the paths of the limbs' axes on the sphere.

A planar stroke is a closed line in the plane of both joint angles; a spatial one moves the axes of
the limbs over the unit sphere. Conventions: `rotations`.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, as_euler
from purcell_cli.lie_brackets.planar_curvature import Plane, angles_in, planar_curvature, plane_of
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.trajectory import Trajectory
from purcell_cli.pictures.colours import BLACK, BLUE, GREY, ORANGE
from purcell_cli.pictures.style import control_legs, styled

_GRID = 111
"""Points of the curvature along each axis: the colours show no steps at the size of the picture."""

_STRAIGHT = 1e-9
"""A bend that is none [rad]."""
_MOST_NUMBERS = 16
"""Moves that are numbered at most: the numbers of more cover one another."""

_TOWARDS: Array = np.array([0.80, -0.42, 0.43]) / np.linalg.norm([0.80, -0.42, 0.43])
"""Where the sphere is looked at from, in base coordinates: from ahead, the limbs' axes towards the reader."""
_RIGHT: Array = np.array([0.42, 0.80, 0.0]) / np.hypot(0.42, 0.80)
"""What is to the right in the picture of the sphere, in base coordinates: across `_TOWARDS` and level."""

_VIEW: Array = np.stack([_RIGHT, np.cross(_TOWARDS, _RIGHT)])
_HALO = [withStroke(linewidth=3.2, foreground="white")]
"""White along a path's sides [points], so that it stands out of the colours below it."""

_LIMBS = ((BLUE, "limb 1"), (ORANGE, "limb 2"))


def stroke_figure(swimmer: Swimmer, trajectory: Trajectory, title: str) -> Figure:
    """Return the picture of one cycle of a stroke.

    Args:
        swimmer: The swimmer.
        trajectory: The cycle, sampled finely.
        title: What it is.
    """
    plane = plane_of(trajectory.shape)
    with styled():
        figure = _on_the_sphere(trajectory) if plane is None else _over_curvature(swimmer, plane, trajectory)
        figure.suptitle(f"{title}\n{net_displacement(swimmer, trajectory)}", fontsize=10)
    return figure


def net_displacement(swimmer: Swimmer, trajectory: Trajectory) -> str:
    """Return in words what a motion does, as its base saw it when it began."""
    g = se3.inverse(trajectory.pose[0]) @ trajectory.pose[-1]
    psi, theta, phi = np.degrees(as_euler(g[:3, :3]))
    named = dict(zip("xyz", g[:3, 3] / swimmer.length_m, strict=True))
    parts = [f"{name} {value:+.4f} L" for name, value in named.items() if abs(value) >= 5e-5]
    turns = (("yaw", psi), ("pitch", theta), ("roll", phi))
    parts += [f"{name} {value:+.2f}°" for name, value in turns if abs(value) >= 5e-3]
    return f"one cycle: {', '.join(parts) or 'no displacement'}"


def _over_curvature(swimmer: Swimmer, plane: Plane, trajectory: Trajectory) -> Figure:
    path = angles_in(plane, trajectory.shape)
    reach = min(max(1.35 * float(np.max(np.abs(path))), 0.5), 3.0)
    grid = np.linspace(-reach, reach, _GRID)
    angles = np.stack(np.meshgrid(grid, grid, indexing="ij"), axis=-1)
    heights = planar_curvature(swimmer, plane, angles) / [swimmer.length_m, swimmer.length_m, np.radians(1.0)]
    figure = Figure(figsize=(10.5, 4.4))
    panels = figure.subplots(1, 3, sharey=True)
    units = ("L/rad²", "L/rad²", "°/rad²")
    for k, (axes, name, unit) in enumerate(zip(panels, plane.names, units, strict=True)):
        height = heights[..., k].T
        top = float(np.percentile(np.abs(height), 98.0)) or 1.0
        extent = (-reach, reach, -reach, reach)
        shown = axes.imshow(
            height, origin="lower", extent=extent, cmap="PuOr", norm=Normalize(-top, top), interpolation="none"
        )
        axes.contour(grid, grid, height, [0.0], colors=GREY, linewidths=1.0, linestyles="--")
        _draw_path(axes, path, trajectory.rate_rad_s)
        axes.grid(False)
        axes.set_xlabel(f"limb 1 {plane.joint} [rad]")
        axes.set_title(name)
        bar = figure.colorbar(shown, ax=axes, location="bottom", extend="both", shrink=0.9, pad=0.02)
        bar.set_label(f"curvature of {name} [{unit}]")
        bar.locator = MaxNLocator(nbins=4, symmetric=True)
        bar.update_ticks()
    panels[0].set_ylabel(f"limb 2 {plane.joint} [rad]")
    return figure


def _draw_path(axes: Axes, path: Array, rate: Array) -> None:
    """Draw a stroke with arrows, its legs numbered in the order in which they are played, unless it is a smooth one."""
    axes.plot(path[:, 0], path[:, 1], color=BLACK, linewidth=1.8, path_effects=_HALO, zorder=4)
    legs = control_legs(rate)
    numbered = len(legs) <= _MOST_NUMBERS
    if not numbered:
        legs = [(row, row + 1) for row in np.linspace(0, len(path) - 1, 8, endpoint=False).astype(int).tolist()]
    span = float(np.ptp(np.asarray(axes.get_xlim())))
    seen: set[tuple[float, ...]] = set()
    for number, (low, high) in enumerate(legs, start=1):
        step = path[high] - path[low]
        size = float(np.hypot(*step))
        if not size:
            continue
        leg = tuple(np.round([*path[low], *path[high]], 6) + 0.0)
        again, along = leg in seen, step / size
        seen.add(leg)
        where = path[low] + 0.4 * step
        _arrow(axes, where, along, BLACK)
        if numbered:
            x, y = where + 0.045 * span * (-1.0 if again else 1.0) * np.array([along[1], -along[0]])
            axes.text(x, y, str(number), ha="center", va="center", fontsize=8, path_effects=_HALO, zorder=6)
    axes.plot(*path[0], marker="o", markersize=6, color="white", markeredgecolor=BLACK, zorder=5)


def _arrow(axes: Axes, where: Array, along: Array, colour: str) -> None:
    style: dict[str, Any] = {"arrowstyle": "-|>", "color": colour, "mutation_scale": 14, "linewidth": 0}
    tip, tail = where + 1e-3 * along, where - 1e-3 * along
    axes.annotate("", (tip[0], tip[1]), (tail[0], tail[1]), arrowprops=style, zorder=5)


def _on_the_sphere(trajectory: Trajectory) -> Figure:
    """Return the paths of the limbs' axes A_i e_x on the sphere, and the same as a map of bends."""
    figure = Figure(figsize=(9.5, 4.8))
    sphere, chart = figure.subplots(1, 2)
    _draw_sphere(sphere)
    places: list[tuple[int, Array, Array, str]] = []
    for limb, (colour, name) in enumerate(_LIMBS):
        axis = trajectory.shape[:, limb, :, 0]
        flat, seen = _bend_map(axis), axis @ _VIEW.T
        bends = float(np.max(np.abs(flat))) > _STRAIGHT
        label = name if bends else f"{name} does not bend"
        sphere.plot(seen[:, 0], seen[:, 1], color=colour, path_effects=_HALO)
        chart.plot(flat[:, 0], flat[:, 1], color=colour, label=label, path_effects=_HALO)
        legs = control_legs(trajectory.rate_rad_s)
        for number, (low, high) in enumerate(legs, start=1):
            middle = (low + high) // 2
            step = flat[min(middle + 1, high)] - flat[max(middle - 1, low)]
            if np.hypot(*step) > _STRAIGHT:
                along = step / np.hypot(*step)
                _arrow(chart, flat[middle], 1e-2 * along, colour)
                if len(legs) <= _MOST_NUMBERS:
                    places.append((number, flat[middle], along, colour))
    shown = {number for number, *_ in places}
    rolls = [str(k) for k in range(1, len(control_legs(trajectory.rate_rad_s)) + 1) if k not in shown]
    if places and rolls:
        words = f"{', '.join(rolls)}: a limb rolls, and its axis stays"
        chart.text(0.02, 0.02, words, transform=chart.transAxes, fontsize=8, color=GREY)
    span = max((float(np.max(np.abs(line.get_xydata()))) for line in chart.get_lines()), default=1.0)
    for number, where, along, colour in places:
        x, y = where + 0.09 * span * np.array([along[1], -along[0]])
        chart.text(x, y, str(number), color=colour, ha="center", va="center", fontsize=8, path_effects=_HALO, zorder=6)
    chart.plot(0.0, 0.0, marker="o", markersize=6, color="white", markeredgecolor=BLACK, zorder=5)
    for k, name in enumerate("xyz"):
        x, y = _VIEW[:, k]
        sphere.plot(x, y, marker=".", color=GREY, markersize=4)
        sphere.annotate(name, (x, y), textcoords="offset points", xytext=(6, 6) if k else (9, -12), color=GREY)
    sphere.set_title("limb axes on the unit sphere of the base")
    chart.set_title("the same, unrolled: distance from the middle is bend")
    chart.set_xlabel("bend towards y [rad]")
    chart.set_ylabel("bend towards z [rad]")
    chart.axhline(0.0, color=GREY, linewidth=0.5)
    chart.axvline(0.0, color=GREY, linewidth=0.5)
    chart.margins(0.15)
    straight = np.allclose(trajectory.shape[..., 0, 0], 1.0, rtol=0.0, atol=1e-15)
    chart.set_aspect("equal", "box" if straight else "datalim")
    if straight:
        ends = (-0.1, 0.1)
        chart.set(xlim=ends, ylim=ends, xticks=(*ends, 0.0), yticks=(*ends, 0.0))
    chart.legend(loc="best")
    return figure


def _bend_map(axis: Array) -> Array:
    """Return limb axes as plane points, as far from the middle as they are bent from x [rad]. Shape (n, 2)."""
    side = np.hypot(axis[:, 1], axis[:, 2])
    bend = np.arctan2(side, axis[:, 0])
    return np.asarray(axis[:, 1:] * (bend / np.where(side > 0.0, side, 1.0))[:, None])


def _draw_sphere(axes: Axes) -> None:
    """Draw circles of equal bend, 30 degrees apart, and their meridians; what is behind is left out."""
    turn, flat_turn = np.linspace(0.0, 2.0 * np.pi, 181), np.ones(181)
    c, s = np.cos(turn), np.sin(turn)
    parallels = [(np.cos(b) * flat_turn, np.sin(b) * c, np.sin(b) * s) for b in np.radians(range(30, 180, 30))]
    meridians = [(c, s * np.cos(b), s * np.sin(b)) for b in np.radians(range(0, 180, 30))]
    for line in parallels + meridians:
        points = np.stack(line, axis=1)
        flat = points @ _VIEW.T
        flat[points @ _TOWARDS < 0.0] = np.nan
        axes.plot(flat[:, 0], flat[:, 1], color="#cccccc", linewidth=0.6, zorder=1)
    axes.plot(c, s, color=GREY, linewidth=0.8)
    axes.set_aspect("equal")
    axes.axis("off")
