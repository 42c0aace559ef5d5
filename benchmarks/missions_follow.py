"""What it costs to follow a curve, against the tolerance: joint travel per length, and over that of a straight way.

    python -m benchmarks.missions_follow [--plot docs/pictures/follow.svg]

Curves in units of L: a straight line of 6, a circle of radius 3, one turn of a helix of radius 3 that rises by 3, the
letter Z, 3 high, and the circle 20 times.
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np

from purcell_cli import Configuration, Curve, Follow, Mission, PlanOptions, PurcellError, plan, plan_mission

L_M = 0.1
TOLERANCES = {
    "line": (1.0, 0.5, 0.3, 0.2, 0.1),
    "circle": (1.0, 0.7, 0.5, 0.3),
    "helix": (1.0, 0.7),
    "Z": (1.0, 0.7, 0.3),
    "loop": (1.0, 0.5),
}
"""The tolerances that each curve is followed within [L]."""


def circle(turns: float, rise_l: float = 0.0) -> Curve:
    """Return turns of a circle of radius 3 L, or of a helix."""
    angle = 2.0 * math.pi * np.linspace(0.0, turns, round(100 * turns) + 1)
    rise = rise_l * angle / (2.0 * math.pi)
    return Curve(L_M * np.stack([3.0 * np.sin(angle), 3.0 - 3.0 * np.cos(angle), rise], axis=1))


def curves() -> dict[str, Curve]:
    """Return the curves by name."""
    return {
        "line": Curve(L_M * np.array([[0.0, 0.0, 0.0], [6.0, 0.0, 0.0]])),
        "circle": circle(1.0),
        "helix": circle(1.0, 3.0),
        "Z": Curve(L_M * np.array([[0.0, 3.0, 0.0], [2.0, 3.0, 0.0], [0.0, 0.0, 0.0], [2.0, 0.0, 0.0]])),
        "loop": circle(20.0),
    }


def main() -> None:
    """Follow each curve within each tolerance, and print a row of a table for each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--plot", metavar="FILE", help="draw the travel against the tolerance")
    parser.add_argument("--only", metavar="NAME", nargs="*", help="the curves to follow")
    asked = parser.parse_args()
    straight = plan(Configuration(), Configuration.from_angles((6.0 * L_M, 0.0, 0.0))).joint_travel_rad / 6.0
    print(
        "| curve | length [L] | tolerance [L] | largest distance [L] | travel [rad / L] | over straight | verdict | s |"
    )
    print("| --- | --- | --- | --- | --- | --- | --- | --- |")
    drawn: dict[str, list[tuple[float, float]]] = {}
    for name, curve in curves().items():
        if asked.only and name not in asked.only:
            continue
        for tolerance in TOLERANCES[name]:
            begun = time.process_time()
            follow = Follow(curve, tolerance * L_M)
            start = Configuration.from_angles(curve.point_m[0])
            length = curve.length_m / L_M
            try:
                mission = Mission(start, follow.goal(start), follow=follow)
                found = plan_mission(mission, options=PlanOptions(effort="quick"))
            except PurcellError as error:
                print(f"| {name} | {length:.1f} | {tolerance} | {error} |", flush=True)
                continue
            off = found.limits.off_curve
            most = math.nan if off is None else off.most_m / L_M
            each = found.joint_travel_rad / length
            print(
                f"| {name} | {length:.1f} | {tolerance} | {most:.3f} | {each:.1f} | {each / straight:.2f} | "
                f"{found.verdict} | {time.process_time() - begun:.0f} |",
                flush=True,
            )
            if found.verdict == "reached":
                drawn.setdefault(name, []).append((tolerance, each))
    if asked.plot:
        draw(drawn, straight, asked.plot)


def draw(drawn: dict[str, list[tuple[float, float]]], straight: float, file: str) -> None:
    """Draw joint travel per length against the tolerance."""
    import matplotlib as mpl

    mpl.use("svg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(6.0, 3.6), layout="constrained")
    for name, rows in drawn.items():
        axes.loglog(*zip(*rows, strict=True), "o-", label=name)
    axes.axhline(straight, color="0.5", linestyle="--", label="straight, no tolerance")
    axes.set_xlabel("tolerance [L]")
    axes.set_ylabel("joint travel [rad / L]")
    axes.legend()
    figure.savefig(file, metadata={"Date": None})


if __name__ == "__main__":
    main()
