"""Draw a plan of three phases, ``docs/planner.svg``: ``python docs/planner_picture.py``.

The swimmer cruises along wide arcs and turns along tight ones, like a needle, with a roll between
arcs that chooses the plane of the next. The plan is made anew, and must arrive.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from purcell_cli import Configuration, PlanOptions, plan
from purcell_cli.pictures.poses_plot import draw_links, link_points
from purcell_cli.pictures.style import BLACK, BLUE, GREEN, GREY, ORANGE, PINK, save_figure, styled
from purcell_cli.solution import Solution, stroke_cycles

PICTURE = Path(__file__).resolve().parent / "planner.svg"
START = Configuration.from_angles(limb1_euler_deg=(45, 20, 0), limb2_euler_deg=(30, -20, 0))
GOAL = Configuration.from_angles((1.5, 1.0, 0.4), (90, -20, 30), (50, 0, 0), (0, -40, 0))

_ARCS = (BLUE, GREEN, ORANGE)
_AZIMUTH, _ELEVATION = np.radians(-62.0), np.radians(24.0)
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


def draw_way(axes: Axes, solution: Solution) -> None:
    """Draw the base's path stroke by stroke over its shadow, and the swimmer between strokes."""
    trajectory, swimmer = solution.trajectory, solution.plan.swimmer
    path = trajectory.pose[:, :3, 3] / swimmer.length_m
    way = path @ _VIEW.T
    shadow = np.column_stack([path[:, :2], np.full(len(path), np.min(path[:, 2]) - 2.5)]) @ _VIEW.T
    axes.plot(*shadow.T, color="#e4e4e4", linewidth=1.0, zorder=1)
    arcs = 0
    for part, low, high in stroke_rows(solution):
        block, cycles = solution.plan.blocks[part][0], stroke_cycles(solution.plan.blocks[part])
        if cycles > 1:
            colour, text, away = _ARCS[arcs % len(_ARCS)], f"{block.gait}, {cycles} cycles", (26, -50)
            arcs += 1
        elif block.phase == 2:
            turn = np.degrees(block.amplitude_rad)
            colour, text, away = PINK, f"roll by {turn:.0f}°" if abs(turn) > 2.0 else "", (-40, 44)
        else:
            colour, text, away = GREY, "", (0, 0)
        axes.plot(*way[low : high + 1].T, color=colour, linewidth=1.0 if cycles > 1 else 1.8, zorder=3)
        if text:
            style = {"arrowstyle": "-", "color": colour, "linewidth": 0.6}
            axes.annotate(
                text, way[(low + high) // 2], away, textcoords="offset points", color=colour, arrowprops=style, zorder=6
            )
        if block.phase == 2 and high < len(trajectory) - 1:
            draw_links(axes, link_points(swimmer, trajectory, high) @ _VIEW.T, 0.4)
    for row, name, away in ((0, "start", (-14, -22)), (-1, "goal", (-34, 0))):
        points = link_points(swimmer, trajectory, row)
        draw_links(axes, points @ _VIEW.T)
        axes.annotate(name, (points @ _VIEW.T)[0 if row == 0 else 3], away, textcoords="offset points", weight="bold")
    left, low_down = way[0, 0] - 2.5, np.min(shadow[:, 1]) - 0.4
    axes.plot([left, left + 1.0], [low_down, low_down], color=BLACK, linewidth=1.5)
    axes.annotate("L", (left + 0.5, low_down), (-3, 4), textcoords="offset points")
    axes.set_aspect("equal", "datalim")
    axes.axis("off")


def draw_phase(axes: Axes, solution: Solution, phase: int, title: str) -> None:
    """Draw the swimmer at a few times of a phase, darker as it goes."""
    trajectory = solution.trajectory
    rows = np.flatnonzero(trajectory.phase == phase)
    low, high = int(rows[0]), min(int(rows[-1]) + 1, len(trajectory) - 1)
    for k, row in enumerate(np.linspace(low, high, 5).round().astype(int)):
        draw_links(axes, link_points(solution.plan.swimmer, trajectory, row) @ _VIEW.T, 0.15 + 0.85 * k / 4.0)
    axes.set_title(title)
    axes.set_aspect("equal", "datalim")
    axes.margins(0.1)
    axes.axis("off")


def draw_loops(axes: Axes, solution: Solution) -> None:
    """Draw one loop of each arc in the plane of both yaw angles."""
    arcs = [rows for rows in stroke_rows(solution) if stroke_cycles(solution.plan.blocks[rows[0]]) > 1]
    for colour, (_, low, high) in zip(_ARCS, arcs, strict=False):
        shape = solution.trajectory.shape[low:high]
        yaw = np.arctan2(shape[:, :, 1, 0], shape[:, :, 0, 0])
        axes.plot(*yaw.T, color=colour)
    axes.set(xlabel="limb 1 yaw [rad]", ylabel="limb 2 yaw [rad]", title="2  rolls and arcs: the loops", aspect="equal")


def main() -> None:
    """Make the plan and its picture."""
    solution = plan(START, GOAL, options=PlanOptions(dt_s=0.25))
    if solution.verdict != "reached":
        raise RuntimeError(f"the plan of the picture is {solution.verdict}")
    with styled():
        figure = Figure(figsize=(8.5, 6.6))
        grid = figure.add_gridspec(2, 3, height_ratios=(1.7, 1.0))
        draw_way(figure.add_subplot(grid[0, :]), solution)
        draw_phase(figure.add_subplot(grid[1, 0]), solution, 1, "1  limbs to collinear")
        draw_loops(figure.add_subplot(grid[1, 1]), solution)
        draw_phase(figure.add_subplot(grid[1, 2]), solution, 3, "3  limbs to the goal shape")
    save_figure(figure, PICTURE)


if __name__ == "__main__":
    main()
