"""How often `purcell track` plans again: plans of the local model, swum by links that feel each other.

    python -m benchmarks.track --random 10 --learn --seconds 280

All stored scenarios of the paper's swimmer, then random queries under 30 L, limbs bent by no more than gaits bend them;
of each a line, and the medians at the end.
"""

from __future__ import annotations

import argparse
import dataclasses
import math
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from benchmarks.random_queries import random_rotations, shape
from purcell_cli import Configuration, Swimmer
from purcell_cli.errors import PurcellError
from purcell_cli.feedback.learn import Learning
from purcell_cli.feedback.measured import Measuring
from purcell_cli.feedback.track import track
from purcell_cli.files.builtin import find_scenario
from purcell_cli.geometry import se3
from purcell_cli.planning import plan

SCENARIOS = Path(__file__).resolve().parent.parent / "scenarios"


def moderate_shape(rng: np.random.Generator, swimmer: Swimmer) -> np.ndarray:
    """Return limb orientations, uniform among those bent by no more than gaits bend them. Shape (2, 3, 3)."""
    while True:
        limbs = shape(rng, swimmer)
        if np.min(limbs[:, 0, 0]) > math.cos(swimmer.max_bend_rad):
            return limbs


def queries(count: int) -> Iterator[tuple[str, Configuration, Configuration]]:
    """Return the stored scenarios of the paper's swimmer and random queries, by name."""
    for file in sorted(SCENARIOS.glob("*.yaml")):
        scenario = find_scenario(file.stem)
        if scenario.swimmer == Swimmer():
            yield file.stem, scenario.start, scenario.goal
    for seed in range(count):
        rng = np.random.default_rng([2, seed])
        away = rng.normal(size=3)
        place = away / np.linalg.norm(away) * 0.05 * 600.0 ** rng.random() * Swimmer().length_m
        first, last = (moderate_shape(rng, Swimmer()) for _ in range(2))
        end = se3.pose(random_rotations(rng, 1)[0], place)
        yield f"random {seed}", Configuration(np.eye(4), first), Configuration(end, last)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--random", type=int, default=0, help="random queries besides the stored scenarios")
    parser.add_argument("--learn", action="store_true", help="fit links' drag between parts")
    parser.add_argument(
        "--knowing", action="store_true", help="travel of plans in the swimmer's own model, and no loop"
    )
    parser.add_argument("--noise", default="", help="of measurements, as of `purcell track`")
    parser.add_argument("--seconds", type=float, default=math.inf, help="begin no query later than this")
    asked = parser.parse_args()
    truth, begun = dataclasses.replace(Swimmer(), fluid="beads"), time.monotonic()
    measuring = Measuring.of_text(asked.noise, 0)
    rows = []
    for name, start, goal in queries(asked.random):
        if time.monotonic() - begun > asked.seconds:
            break
        model = Swimmer()
        if asked.knowing:
            knowing, plain = (plan(start, goal, swimmer=body).joint_travel_rad for body in (truth, model))
            rows.append((True, 0, knowing / plain))
            print(f"{name}: travel {knowing / plain:.2f}", flush=True)
            continue
        learning = {"fitted": Learning(model, measuring)} if asked.learn else {}
        try:
            found = track(start, goal, truth, model=model, measuring=measuring, **learning)
        except PurcellError as error:
            print(f"{name}: {error}", flush=True)
            continue
        ratio = found.joint_travel_rad / found.parts[0].solution.joint_travel_rad
        rows.append((found.arrived, found.replans, ratio))
        off = f"{found.off.position_m / model.length_m:.1e} L, {math.degrees(found.off.base_rad):.2g} degrees"
        told = "arrived" if found.arrived else "did not arrive"
        print(f"{name}: {told} after {found.replans} replans, travel {ratio:.2f}, off by {off}", flush=True)
    arrived, replans, ratios = (np.array(column) for column in zip(*rows, strict=True))
    soon = np.count_nonzero(arrived & (replans <= 6))
    print(
        f"{np.count_nonzero(arrived)} of {len(rows)} arrived, {soon} within 6 replans; "
        f"medians: {np.median(replans):g} replans, travel {np.median(ratios):.2f}"
    )


if __name__ == "__main__":
    main()
