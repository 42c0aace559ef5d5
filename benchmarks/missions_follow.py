"""What it costs to follow a curve, against the tolerance: joint travel per length, and over that of a straight way.

    python -m benchmarks.missions_follow [--write]

Curves in units of L: a straight line of 6, a circle of radius 3, one turn of a helix of radius 3 that rises by 3, the
letter Z, 3 high, and the circle 20 times.
"""

from __future__ import annotations

import argparse
import math
import time

import numpy as np

from benchmarks import pages
from benchmarks.resumed import Row, printed
from purcell_cli import Configuration, Curve, Follow, Mission, PlanOptions, plan, plan_mission

L_M = 0.1
TOLERANCES = {
    "line": (1.0, 0.5, 0.3, 0.2, 0.1),
    "circle": (1.0, 0.7, 0.5, 0.3),
    "helix": (1.0, 0.7),
    "Z": (1.0, 0.7, 0.3),
    "loop": (1.0, 0.5),
}
"""The tolerances that each curve is followed within [L]."""
WORDS = {
    "line": "a straight line",
    "circle": "a circle of radius 3 L",
    "helix": "a helix of radius 3 L that rises by 3 L",
    "Z": "the letter Z, 3 L high",
    "loop": "the circle 20 times",
}
"""What the table calls the curves."""


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


def outcome(name: str, curve: Curve, tolerance: float, straight: float) -> Row:
    """Follow a curve within a tolerance [L], and return the figures."""
    begun = time.process_time()
    follow, length = Follow(curve, tolerance * L_M), curve.length_m / L_M
    start = Configuration.from_angles(curve.point_m[0])
    mission = Mission(start, follow.goal(start), follow=follow)
    found = plan_mission(mission, options=PlanOptions(effort="quick"))
    off = found.limits.off_curve
    row: Row = {"curve": name, "length": length, "tolerance": tolerance, "verdict": str(found.verdict)}
    row |= {"off": math.nan if off is None else off.most_m / L_M, "each": found.joint_travel_rad / length}
    return {**row, "over": row["each"] / straight, "seconds": time.process_time() - begun}


def table(rows: list[Row]) -> list[str]:
    """Return what came of curves and tolerances, a line each."""
    lines = [
        "| curve | length [L] | tolerance [L] | distance [L] | travel [rad / L] | over straight | verdict "
        "| processor time [s] |",
        "| --- " * 8 + "|",
    ]
    for k, row in enumerate(rows):
        named = not k or rows[k - 1]["curve"] != row["curve"]
        which = f"{WORDS[row['curve']]} | {row['length']:.1f}" if named else " | "
        lines.append(
            f"| {which} | {row['tolerance']} | {row['off']:.3f} | {row['each']:.1f} | {row['over']:.2f} "
            f"| {row['verdict']} | {row['seconds']:.0f} |"
        )
    return lines


def main() -> None:
    """Follow each curve within each tolerance, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--only", metavar="NAME", nargs="*", help="the curves to follow")
    parser.add_argument("--write", action="store_true", help="put table and picture into the documentation")
    asked = parser.parse_args()
    straight = plan(Configuration(), Configuration.from_angles((6.0 * L_M, 0.0, 0.0))).joint_travel_rad / 6.0
    rows = []
    for name, curve in curves().items():
        for tolerance in TOLERANCES[name] if not asked.only or name in asked.only else ():
            rows.append(outcome(name, curve, tolerance, straight))
            printed(rows[-1])
    lines = table(rows)
    print("\n".join(lines))
    if asked.write:
        pages.put("how-to/missions.md", "missions follow", "\n".join(lines))
        drawn: dict[str, list[tuple[float, float]]] = {}
        for row in rows:
            drawn.setdefault(row["curve"], []).append((row["tolerance"], row["each"]))
        draw(drawn, straight, str(pages.DOCS / "pictures" / "follow.svg"))


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
