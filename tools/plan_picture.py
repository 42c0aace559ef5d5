"""Draw a plan of three phases, ``docs/pictures/plan.svg``, and a film of another: ``python tools/plan_picture.py``.

The swimmer straightens its limbs, swims along arcs with a roll between them that chooses the plane of the next, and
bends its limbs. The plan is made anew, and must arrive. The film, ``docs/pictures/swim.gif``, shows the stored scenario
`nearby` in its own time.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patheffects import withStroke

from purcell_cli import Configuration, PlanOptions, load_scenario, plan, stored_scenarios
from purcell_cli.files.atomic_file import whole_file
from purcell_cli.motion.trajectory import as_table
from purcell_cli.pictures.colours import BLACK, BLUE, GREEN, GREY, ORANGE, PINK
from purcell_cli.pictures.film import FilmOptions, write_film
from purcell_cli.pictures.poses_plot import link_points
from purcell_cli.pictures.style import save_figure, styled
from purcell_cli.solution import Solution, stroke_cycles

PICTURE = Path(__file__).resolve().parent.parent / "docs" / "pictures" / "plan.svg"
FILM = PICTURE.with_name("swim.gif")
START = Configuration.from_angles(limb1_euler_deg=(55, 25, 0), limb2_euler_deg=(50, -25, 0))
GOAL = Configuration.from_angles((1.05, 0.95, 0.45), (95, -35, 20), (60, 10, 0), (-10, -55, 0))

_ARCS = (GREEN, "#7A5195", "#B8860B")
_APART_L = 3.6
"""Swimmers on the way are drawn at least so far apart [L]: no more than their tips meet."""
_LABELLED = 8
"""Arcs of fewer cycles have no label."""
_LINKS = (ORANGE, BLACK, BLUE)
"""Colours of limb 2, base and limb 1."""
_AZIMUTH, _ELEVATION = np.radians(-68.0), np.radians(26.0)
_VIEW = np.array(
    [
        [-np.sin(_AZIMUTH), np.cos(_AZIMUTH), 0.0],
        [-np.sin(_ELEVATION) * np.cos(_AZIMUTH), -np.sin(_ELEVATION) * np.sin(_AZIMUTH), np.cos(_ELEVATION)],
    ]
)
"""Onto the picture, as seen from the side and above."""


def stroke_rows(solution: Solution) -> list[tuple[slice, int, int]]:
    """Return the blocks of each stroke, and its first and last row in the trajectory."""
    blocks, rate = solution.plan.blocks, solution.plan.swimmer.joint_rate_rad_s
    ends = np.cumsum([sum(b.duration for b in blocks[part]) for part in solution.strokes]) / rate
    rows = [0, *np.searchsorted(solution.trajectory.time_s, ends - 1e-9).tolist()]
    return list(zip(solution.strokes, rows[:-1], rows[1:], strict=True))


def draw_swimmer(axes: Axes, points: np.ndarray, ground: float, alpha: float, level: int = 4) -> None:
    """Draw the three links between four points in space over their shadow on the ground. Shape (4, 3)."""
    shadow = np.column_stack([points[:, :2], np.full(4, ground)]) @ _VIEW.T
    axes.plot(*shadow.T, color="#d8d8d8", linewidth=2.5, solid_capstyle="round", solid_joinstyle="round", zorder=1)
    flat = points @ _VIEW.T
    axes.plot(*flat.T, color="white", linewidth=5.6, solid_capstyle="round", solid_joinstyle="round", zorder=level)
    for k, colour in enumerate(_LINKS):
        axes.plot(
            *flat[k : k + 2].T, color=colour, linewidth=4.2, alpha=alpha, solid_capstyle="round", zorder=level + 1
        )
    joint = {"marker": "o", "markersize": 4.6, "markeredgecolor": "white", "color": BLACK}
    axes.plot(*flat[1:3].T, linestyle="none", zorder=level + 2, **joint)


def draw_ground(axes: Axes, low: np.ndarray, high: np.ndarray, ground: float) -> None:
    """Draw a grid of lines an L apart under the motion."""
    xs, ys = (np.arange(np.floor(low[k]), np.ceil(high[k]) + 0.5) for k in (0, 1))
    lines = [[(x, ys[0], ground), (x, ys[-1], ground)] for x in xs] + [
        [(xs[0], y, ground), (xs[-1], y, ground)] for y in ys
    ]
    for line in lines:
        axes.plot(*(np.array(line) @ _VIEW.T).T, color="#ececec", linewidth=0.7, zorder=0)


def shown_rows(path: np.ndarray) -> list[int]:
    """Return rows at which the swimmer is far enough from where it was shown before, and from start and goal."""
    out = [0]
    for row, place in enumerate(path):
        if np.linalg.norm(place - path[out[-1]]) >= _APART_L and np.linalg.norm(place - path[-1]) >= _APART_L:
            out.append(row)
    return out[1:]


def draw_way(axes: Axes, solution: Solution) -> None:
    """Draw the base's path stroke by stroke over its shadow, and the swimmer on its way."""
    trajectory, swimmer = solution.trajectory, solution.plan.swimmer
    path = trajectory.pose[:, :3, 3] / swimmer.length_m
    corners = np.concatenate([link_points(swimmer, trajectory, row) for row in (0, len(trajectory) - 1)] + [path])
    ground = float(corners[:, 2].min() - 1.2)
    draw_ground(axes, corners.min(axis=0) - 0.3, corners.max(axis=0) + 0.3, ground)
    shadow = np.column_stack([path[:, :2], np.full(len(path), ground)])
    axes.plot(*(shadow @ _VIEW.T).T, color="#d8d8d8", linewidth=1.2, zorder=1)
    arcs, way = 0, path @ _VIEW.T
    for part, low, high in stroke_rows(solution):
        block, cycles = solution.plan.blocks[part][0], stroke_cycles(solution.plan.blocks[part])
        if cycles > 1:
            colour = _ARCS[arcs % len(_ARCS)]
            arcs += 1
            if cycles >= _LABELLED:
                style = {"arrowstyle": "-", "color": colour, "linewidth": 0.7}
                place, text = way[(low + 2 * high) // 3], f"arc of {cycles} cycles"
                axes.annotate(text, place, (30, -46), textcoords="offset points", color=colour, arrowprops=style)
        else:
            colour = PINK if block.phase == 2 else GREY
        axes.plot(*way[low : high + 1].T, color=colour, linewidth=1.2, zorder=7)
    for row in shown_rows(path):
        draw_swimmer(axes, link_points(swimmer, trajectory, row), ground, 0.4)
    for row, name, away in ((0, "start", (6, -20)), (len(trajectory) - 1, "goal", (32, -6))):
        points = link_points(swimmer, trajectory, row)
        draw_swimmer(axes, points, ground, 1.0, level=8)
        middles = (points[:-1] + points[1:]) / 2.0 @ _VIEW.T
        for middle, text, colour in zip(middles, ("limb 2", name, "limb 1"), _LINKS, strict=True):
            bold = {"weight": "bold", "fontsize": 12} if text == name else {}
            label = axes.annotate(text, middle, away, textcoords="offset points", color=colour, ha="center", **bold)
            label.set(zorder=12, path_effects=[withStroke(linewidth=3.0, foreground="white")])
    axes.set_aspect("equal", "datalim")
    axes.axis("off")


def main() -> None:
    """Make the plan and its picture."""
    solution = plan(START, GOAL, options=PlanOptions(dt_s=0.25))
    if solution.verdict != "reached":
        raise RuntimeError(f"the plan of the picture is {solution.verdict}")
    with styled():
        figure = Figure(figsize=(8.0, 5.0))
        draw_way(figure.add_subplot(), solution)
    save_figure(figure, PICTURE)
    near = load_scenario(stored_scenarios()["nearby"])
    rows = as_table(plan(near.start, near.goal, swimmer=near.swimmer).trajectory)
    with whole_file(FILM) as stream:
        write_film(rows, near.swimmer, FilmOptions("gif", 12.5, size=(480, 320)), stream, lambda _done, _total: None)


if __name__ == "__main__":
    main()
