"""Adds plans of small displacements to the motion library, at two bend limits.

    python -m benchmarks.small_plans --seconds 1500 --write

Displacements along the axes and between them come first, then random ones of 0.005 to 0.3 L. Each begins with what the
library has, brought there by Newton's method and shortened for long. A plan is kept where the library's own
estimate is 3 % longer. Some four seconds a displacement.
"""

from __future__ import annotations

import argparse
import itertools
import json
import time
from collections.abc import Iterator

import numpy as np

from benchmarks.motion_library import LIBRARY
from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.planner.library.plan_library import MotionLibrary, stored_plans
from purcell_cli.planner.library.random_plans import free_segment
from purcell_cli.planner.refine.exact_arrival import CLOSE, MARGIN_RAD, Patience, approach
from purcell_cli.planner.refine.minimum_travel import Pace, merged, minimise_travel, offered, tightened
from purcell_cli.planner.refine.shooting import Equations

LIMITS_RAD, NEAREST_L, FARTHEST_L = (1.0, 1.0, 1.5), 0.005, 0.3
NAMED = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0], [0, 1, 1], [1, 1, 0], [1, 1, 1]], dtype=float)
TRIED, ARRIVED, SHORTENED, LONGEST, WORTH, MOST_RAD = 14, 7, 3, 60, 1.03, 26.9
"""Library plans that are tried, that arrive, and that are shortened; the most primitives of one that is kept, by how
much longer the estimate is then, and the most joint travel [rad]."""
LOOK, LONG = Pace(1, 10), Pace(3, 25, price=300.0, longest=60)
SLIGHT_RAD, DEARER = (0.05, 0.02, 0.005), 1.005


def targets() -> Iterator[tuple[float, np.ndarray]]:
    """Yield bend limits [rad] and twists of displacements."""
    for limit, distance, axis in itertools.product((1.5, 1.0), (0.05, 0.1, 0.02), NAMED):
        yield limit, np.concatenate([distance * axis / np.linalg.norm(axis), np.zeros(3)])
    for seed in itertools.count():
        rng = np.random.default_rng([77, seed])
        distance = NEAREST_L * (FARTHEST_L / NEAREST_L) ** rng.random()
        way, turn = (v / np.linalg.norm(v) for v in rng.normal(size=(2, 3)))
        yield LIMITS_RAD[seed % 3], np.concatenate([distance * way, distance * rng.random() * turn])


def found(limit: float, twist: np.ndarray, plans: list[PrimitiveSequence]) -> tuple[PrimitiveSequence | None, float]:
    """Return the shortest plan found for a displacement, or none, and the library's estimate [rad]."""
    swimmer, bend, wanted = Swimmer(max_bend_rad=limit).scaled(), limit - MARGIN_RAD, se3.exp(twist)
    entries = MotionLibrary(tuple(plans), swimmer).nearest(wanted[None], np.zeros(1), TRIED)
    empty, near = Equations(swimmer, (), COLLINEAR, COLLINEAR, wanted, SEARCHING), []
    for entry in entries:
        lap = entry.lap.times(entry.laps)
        for begun in (lap, offered(merged(lap), 1)):
            motion, _, off = approach(empty.of([free_segment(begun)]), bend, Patience(0.6, rounds=4))
            if off < CLOSE:
                near.append(tightened(motion, bend, LOOK))
                break
        if len(near) == ARRIVED:
            break
    near.sort(key=lambda m: m.joint_travel_rad)
    shorter = [approach(minimise_travel(m, bend, LONG), bend) for m in near[:SHORTENED]]
    best = min((m for m, _, off in shorter if off < CLOSE), key=lambda m: m.joint_travel_rad, default=None)
    if best is None:
        return None, entries[0].estimate_rad
    plan = merged(best.sequence)
    for least in SLIGHT_RAD:
        fewer = merged(plan[np.flatnonzero(np.abs(plan.angle) > least)])
        motion, _, off = approach(empty.of([free_segment(fewer)]), bend)
        if len(fewer) < len(plan) and off < CLOSE:
            motion, _, off = approach(tightened(motion, bend, Pace(1, 15, price=300.0)), bend)
            if off < CLOSE and motion.joint_travel_rad < DEARER * best.joint_travel_rad:
                return motion.sequence, entries[0].estimate_rad
    return plan, entries[0].estimate_rad


def main() -> None:
    """Find plans, and add them to the library if asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=300.0, help="how long to search")
    parser.add_argument("--write", action="store_true", help=f"write {LIBRARY.name}")
    asked = parser.parse_args()
    began, plans = time.monotonic(), list(stored_plans())
    for limit, twist in targets():
        if time.monotonic() - began > asked.seconds:
            break
        plan, estimate = found(limit, twist, plans)
        told = "nothing" if plan is None else f"{plan.joint_travel_rad:.3f} rad, {len(plan)} primitives"
        print(f"{limit:g} rad, {np.round(twist, 3).tolist()}: {told}, estimated {estimate:.2f}", flush=True)
        if plan is not None and len(plan) <= LONGEST and plan.joint_travel_rad < min(MOST_RAD, estimate / WORTH):
            plans.append(plan)
    if asked.write:
        texts = [json.dumps({"control": p.control.tolist(), "angle": np.round(p.angle, 6).tolist()}) for p in plans]
        LIBRARY.write_text('{"plans": [\n' + ",\n".join(texts) + "\n]}\n", encoding="ascii")


if __name__ == "__main__":
    main()
