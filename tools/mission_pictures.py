"""Draw two missions, ``vessel.svg`` and ``curve.svg`` in ``docs/pictures``: ``python tools/mission_pictures.py``.

The stored scenario `vessel`, and a curve followed round two sharp corners. Both are planned anew, and must arrive.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from purcell_cli import (
    Configuration,
    Curve,
    Follow,
    Mission,
    PlanOptions,
    load_scenario,
    plan_mission,
    stored_scenarios,
)
from purcell_cli.motion.trajectory import as_table
from purcell_cli.pictures.space_plot import space_figure
from purcell_cli.pictures.style import save_figure
from purcell_cli.pictures.surroundings import Surroundings

PICTURES = Path(__file__).resolve().parent.parent / "docs" / "pictures"
_DPI = 100.0
"""Dots per inch of obstacles and tolerance: pages open fast, and edges are sharp enough where nothing is thin."""
CURVE = Follow(Curve(np.array([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.3, 0.0], [0.3, 0.3, 0.0]])), 0.1)


def draw(name: str, title: str, mission: Mission, options: PlanOptions) -> None:
    """Plan a mission and write its picture."""
    solution = plan_mission(mission, options=options)
    if solution.verdict != "reached":
        raise RuntimeError(f"the plan of {name} is {solution.verdict}")
    around = Surroundings(options.obstacles, tuple(enumerate(mission.via)), mission.follow)
    figure = space_figure(as_table(solution.trajectory), solution.plan.swimmer, title, around)
    save_figure(figure, PICTURES / f"{name}.svg", _DPI)


def main() -> None:
    """Make both plans and their pictures."""
    vessel = load_scenario(stored_scenarios()["vessel"])
    draw(
        "vessel",
        "vessel: through three waypoints into a branch",
        vessel.mission,
        PlanOptions(obstacles=vessel.obstacles),
    )
    mission = Mission(Configuration(), CURVE.goal(Configuration()), follow=CURVE)
    draw("curve", "a curve, followed within 1 L", mission, PlanOptions(effort="quick"))


if __name__ == "__main__":
    main()
