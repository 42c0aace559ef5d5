"""Pictures of a motion in space, among obstacles, waypoints and the curve that it follows.

It is seen from afar, from the side and above. Conventions: `rotations`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Circle, Patch
from matplotlib.patheffects import withStroke
from matplotlib.text import Annotation
from matplotlib.transforms import BboxBase

from purcell_cli.geometry.rotations import Array, from_quaternion
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.pictures.colours import AMBER, BLACK, GREEN, GREY
from purcell_cli.pictures.html_view import origin_told
from purcell_cli.pictures.poses_plot import LINKS, NAMES, draw_links
from purcell_cli.pictures.style import styled
from purcell_cli.pictures.surroundings import Surroundings
from purcell_cli.wording import length_unit

_AZIMUTH, _ELEVATION = np.radians(-68.0), np.radians(38.0)
"""Where it is seen from [rad]: from where the usual plane of a mission, x-y, is seen wide, and heights are, too."""
_RIGHT = np.array([-np.sin(_AZIMUTH), np.cos(_AZIMUTH), 0.0])
"""Where the picture's right is in the world. Shape (3,)."""
_NEAR = np.array([np.cos(_ELEVATION) * np.cos(_AZIMUTH), np.cos(_ELEVATION) * np.sin(_AZIMUTH), np.sin(_ELEVATION)])
"""Where the eye is, from what it sees. Shape (3,)."""
_VIEW = np.stack([_RIGHT, np.cross(_NEAR, _RIGHT)])
"""Onto the picture. Shape (2, 3)."""
_TINTS = {"obstacle": (0.62, 0.70, 0.82), "tolerance": (0.90, 0.62, 0.0)}
"""Colours of surfaces that face the eye; those that do not are darker."""
_APART_L = 3.6
"""Swimmers on the way are drawn at least so far apart [L]: no more than their tips meet."""
_AXIS_L = 0.6
"""Length of the axes at a waypoint that names an orientation [L]."""
_BEYOND = 0.4
"""How much of the motion's size is shown of what is around it, on each side."""


_ELSEWHERE = ((6, 6), (6, -13), (-34, 6), (-34, -13), (6, 19), (6, -26), (-34, 19), (-34, -26), (6, 32), (6, -39))
"""Where a label is tried that would lie on another, from what it names [points]."""


def space_figure(table: Table, swimmer: Swimmer, title: str, around: Surroundings) -> Figure:
    """Return a motion in space: the base's path, the swimmer at its start, on its way and at its goal.

    Args:
        table: The motion.
        swimmer: The swimmer.
        title: What it is.
        around: What is drawn around it.
    """
    marks, curve, skins = around.marks(table), around.curve_m, around.skins(table)
    rows = _shown_rows(table.position_m, _APART_L * swimmer.length_m)
    swimmers = _link_points(table, swimmer, rows)
    seen = [table.position_m, swimmers.reshape(-1, 3), curve, np.array([one.place_m for one in marks]).reshape(-1, 3)]
    bodies = table.position_m[rows] if swimmer.body_radius_m else np.zeros((0, 3))
    seen += [bodies + side * swimmer.body_radius_m * axis for axis in _VIEW for side in (-1.0, 1.0)]
    low, high = _bounds(np.concatenate(seen), [one.triangles.reshape(-1, 3) for one in skins])
    size = high - low
    with styled():
        wide = 8.0
        figure = Figure(figsize=(wide, float(np.clip(wide * size[1] / size[0], 2.5, 8.0)) + 0.9))
        axes = figure.add_subplot()
        axes.axis("off")
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        for one in skins:
            _draw_skin(axes, one.triangles, _TINTS[one.of], one.alpha)
        axes.plot(*(curve @ _VIEW.T).T, color=AMBER, linewidth=1.8, zorder=3)
        axes.plot(*(table.position_m @ _VIEW.T).T, color=GREEN, linewidth=1.1, zorder=4)
        for k, points in enumerate(swimmers):
            at_end = k in {0, len(swimmers) - 1}
            draw_links(axes, points @ _VIEW.T, 1.0 if at_end else 0.45, width=3.0, level=6)
        for middle in bodies @ _VIEW.T:
            axes.add_patch(Circle(middle.tolist(), swimmer.body_radius_m, color=BLACK, alpha=0.4, zorder=5))
        ends = (("start", swimmers[0]), ("goal", swimmers[-1]))
        labels = [_label(axes, points[3], name, (6, 5)) for name, points in ends]
        for mark in marks:
            if mark.orientation is not None:
                for axis, letter in zip(mark.orientation.T, "xyz", strict=True):
                    tip = mark.place_m + _AXIS_L * swimmer.length_m * axis
                    axes.plot(*(np.stack([mark.place_m, tip]) @ _VIEW.T).T, color=BLACK, linewidth=1.2, zorder=8)
                    _label(axes, tip, letter, (2, 2), 7)
            axes.plot(*(_VIEW @ mark.place_m), **_dot(mark.placed), zorder=9)
            below = mark.orientation is not None or not mark.placed
            labels.append(_label(axes, mark.place_m, mark.name, (6, -13 if below else 6)))
        _draw_scale(axes, low, size)
        links = list(zip(LINKS, NAMES, strict=True))[::-1]
        handles: list[Artist] = [Line2D([], [], color=colour, linewidth=2.6, label=name) for colour, name in links]
        handles.append(Line2D([], [], color=GREEN, linewidth=1.1, label="base's path"))
        if around.obstacles is not None:
            handles.append(Patch(color=_TINTS["obstacle"], label="obstacle"))
        for placed in sorted({mark.placed for mark in marks}, reverse=True):
            name = "waypoint" if placed else "its place free"
            handles += [Line2D([], [], **_dot(placed), linestyle="none", label=name)]
        if len(curve):
            handles.append(Line2D([], [], color=AMBER, linewidth=1.8, label="curve"))
            handles.append(Patch(color=_TINTS["tolerance"], alpha=0.3, label="its tolerance"))
        figure.legend(handles=handles, loc="outside lower center", ncols=len(handles), columnspacing=1.2)
        figure.suptitle(f"{title}{origin_told(table)}", fontsize=10)
        draw_apart(figure, labels)
    return figure


def draw_apart(figure: Figure, labels: Sequence[Annotation]) -> None:
    """Move labels of a figure so that none lies on one before it, as far as there is room near what it names."""
    figure.draw_without_rendering()
    taken: list[BboxBase] = []
    for label in labels:
        home = label.xyann
        for away in (home, *_ELSEWHERE):
            label.xyann = away
            if not any(label.get_window_extent().overlaps(one) for one in taken):
                break
        else:
            label.xyann = home
        taken.append(label.get_window_extent())


def _shown_rows(path: Array, apart_m: float) -> list[int]:
    """Return the first row, the last one, and rows between at which the swimmer is far enough from those before."""
    out = [0]
    for row in np.unique(np.linspace(0, len(path) - 1, 2000).astype(int)).tolist():
        others = path[[out[-1], len(path) - 1]]
        if np.min(np.sum((others - path[row]) ** 2, axis=1)) >= apart_m**2:
            out.append(row)
    return [*out, len(path) - 1]


def _link_points(table: Table, swimmer: Swimmer, rows: list[int]) -> Array:
    """Return limb 2's tip, its joint, limb 1's joint and its tip [m]. Shape (n, 4, 3)."""
    base, one, two = swimmer.halves_m
    turn = from_quaternion(table.base[rows])
    along, place = turn[:, :, 0], table.position_m[rows]
    tips = [(turn @ from_quaternion(table.limbs[rows, k])[:, :, :1])[:, :, 0] for k in (0, 1)]
    front, back = place + base * along, place - base * along
    return np.stack([back - 2.0 * two * tips[1], back, front, front + 2.0 * one * tips[0]], axis=1)


def _bounds(motion: Array, around: list[Array]) -> tuple[Array, Array]:
    """Return the corners of the picture: the motion, and what is around it as far as it is near. Shapes (2,)."""
    flat = motion @ _VIEW.T
    low, high = flat.min(axis=0), flat.max(axis=0)
    beyond = _BEYOND * float(np.max(high - low))
    for points in around:
        seen = points @ _VIEW.T
        near = np.clip([seen.min(axis=0), seen.max(axis=0)], low - beyond, high + beyond)
        flat = np.concatenate([flat, near])
    low, high = flat.min(axis=0), flat.max(axis=0)
    margin = 0.04 * float(np.max(high - low))
    return low - margin, high + margin


def _draw_skin(axes: Axes, triangles: Array, tint: tuple[float, float, float], alpha: float) -> None:
    """Draw triangles from the farthest to the nearest, darker where they are seen from the side."""
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    size = np.sqrt(np.sum(normal**2, axis=1))
    light = 0.55 + 0.45 * np.abs(normal @ _NEAR) / np.where(size > 0.0, size, 1.0)
    order = np.argsort(triangles.mean(axis=1) @ _NEAR, kind="stable")
    colours = np.column_stack([light[:, None] * np.array(tint), np.full(len(light), alpha)])
    skin = PolyCollection(list(triangles[order] @ _VIEW.T), facecolors=colours[order], edgecolors="none", zorder=1)
    skin.set_rasterized(True)  # in pictures of lines, too: there are thousands
    axes.add_collection(skin, autolim=False)


def _dot(placed: bool) -> dict[str, Any]:
    """Return how a waypoint is drawn: hollow where its place is free."""
    colour = AMBER if placed else "white"
    return {"marker": "o", "markersize": 6.0, "markerfacecolor": colour, "markeredgecolor": BLACK}


def _label(axes: Axes, place_m: Array, text: str, away: tuple[int, int], size: int = 9) -> Annotation:
    x, y = (_VIEW @ place_m).tolist()
    label = axes.annotate(text, (x, y), away, textcoords="offset points", color=BLACK, fontsize=size, zorder=10)
    label.set(path_effects=[withStroke(linewidth=2.5, foreground="white")])
    return label


def _draw_scale(axes: Axes, low: Array, size: Array) -> None:
    """Draw how long a round length is, and where the axes point."""
    decade = 10.0 ** float(np.floor(np.log10(0.25 * size[0])))
    length = decade * max(n for n in (1, 2, 5) if n * decade <= 0.25 * size[0])
    unit, name = length_unit(length)
    begin = (low + 0.02 * size).tolist()
    axes.plot([begin[0], begin[0] + length], [begin[1]] * 2, color=GREY, linewidth=1.6, zorder=8)
    axes.annotate(
        f"{length * unit:g} {name}", (begin[0], begin[1]), (0, 4), textcoords="offset points", color=GREY, fontsize=8
    )
    corner = np.array(begin) + np.array([0.02 * size[0], 0.02 * size[0] + 0.05 * size[1]])
    for axis, letter in zip(_VIEW.T, "xyz", strict=True):
        tip = (corner + 0.04 * size[0] * axis).tolist()
        axes.plot(*np.stack([corner, tip]).T, color=GREY, linewidth=1.0, zorder=8)
        axes.annotate(letter, (tip[0], tip[1]), (2, 1), textcoords="offset points", color=GREY, fontsize=8)
