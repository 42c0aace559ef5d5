"""Finds the plans of the motion library: short plans for small displacements, offline.

    python -m benchmarks.motion_library --targets 200 --keep 40 --write

Displacements are drawn at random, collinear to collinear. The first few begin with random plans, all others with
those found until then; each is brought there by Newton's method and shortened by linear programs for long. In the
end a greedy choice keeps those plans by which the estimates for all targets come nearest to what was found for them.
About half an hour for 100 targets on one core. The stored library is the best of several such searches, by the joint
travel of plans that begin with it.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.planner.library import plan_library
from purcell_cli.planner.library.random_plans import brought, free_segment, random_plans
from purcell_cli.planner.refine.exact_arrival import CLOSE, MARGIN_RAD, approach
from purcell_cli.planner.refine.minimum_travel import Pace, minimise_travel, offered, tightened
from purcell_cli.planner.refine.shooting import Equations

LIBRARY = Path(plan_library.__file__).parent / "plans.json"
WIDE, NARROW = (1.5, 40.0), (1.0, 18.0)
"""Bend limits [rad], and sizes of displacements, as the library prices them, that take about one lap within them."""
FIRST, PACE = Pace(rounds=1, steps=12), Pace(rounds=4, steps=30, price=300.0)
FROM_NOTHING, RANDOM, TRIED, SHORTENED, LONGEST = 6, 48, 10, 3, 40


def target(seed: int) -> tuple[Swimmer, np.ndarray]:
    """Return a swimmer and a displacement: within a wide bend limit for plans from nothing, a narrow one for others."""
    limit, size = WIDE if seed < FROM_NOTHING else NARROW
    rng = np.random.default_rng(seed)
    twist = rng.standard_normal(6)
    twist[3] = 0.0
    twist *= size / np.linalg.norm(twist) / plan_library.PRICES
    twist[3] = rng.uniform(-0.2, 0.2) * np.sqrt(size / WIDE[1])
    return Swimmer(max_bend_rad=limit).scaled(), se3.exp(twist)


def best_plan(seed: int, found: list[PrimitiveSequence]) -> PrimitiveSequence | None:
    """Return the shortest plan found for a target, or none."""
    swimmer, wanted = target(seed)
    bend = swimmer.max_bend_rad - MARGIN_RAD
    empty = Equations(swimmer, (), COLLINEAR, COLLINEAR, wanted, SEARCHING)
    if seed < FROM_NOTHING:
        plans = random_plans(RANDOM)
    else:
        entries = plan_library.MotionLibrary(tuple(found), swimmer).nearest(wanted[None], np.zeros(1), TRIED)
        plans = (free_segment(offered(e.lap.times(e.laps), 1)) for e in entries)
    near = [tightened(m, bend, FIRST) for m, off in (brought(empty.of([p]), bend) for p in plans) if off < CLOSE]
    near.sort(key=lambda m: m.joint_travel_rad)
    short = (minimise_travel(m, bend, PACE) for m in near[:SHORTENED])
    exact = [m for m, _, off in (approach(m, bend) for m in short) if off < CLOSE]
    return min((m.sequence for m in exact), key=lambda w: w.joint_travel_rad, default=None)


def chosen(found: dict[int, PrimitiveSequence], keep: int) -> list[PrimitiveSequence]:
    """Return the plans that serve all targets best, one after the other."""
    plans = [w for w in found.values() if len(w) <= LONGEST]
    costs = []
    for seed, own in found.items():
        swimmer, wanted = target(seed)
        by_plan = plan_library.MotionLibrary(tuple(plans), swimmer).estimates(wanted[None])[0].min(axis=(0, 1))
        costs.append(by_plan / own.joint_travel_rad)
    table, best, out = np.array(costs), np.full(len(costs), np.inf), []
    for _ in range(min(keep, len(plans))):
        k = int(np.argmin(np.minimum(best[:, None], table).mean(axis=0)))
        best = np.minimum(best, table[:, k])
        out.append(plans[k])
    print(
        f"{len(out)} plans; the best estimate is {best.mean():.3f} times what was found, at most {best.max():.2f} times"
    )
    return out


def main() -> None:
    """Find plans, and write them if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--targets", type=int, default=200, help="how many displacements")
    parser.add_argument("--keep", type=int, default=40, help="how many plans to keep")
    parser.add_argument("--write", action="store_true", help=f"write {LIBRARY.name}")
    asked = parser.parse_args()
    found: dict[int, PrimitiveSequence] = {}
    for seed in range(asked.targets):
        plan = best_plan(seed, list(found.values()))
        if plan is not None:
            found[seed] = plan
        told = "nothing" if plan is None else f"{plan.joint_travel_rad:.3f} rad, {len(plan)} primitives"
        print(f"target {seed}: {told}", flush=True)
    plans = [{"control": w.control.tolist(), "angle": np.round(w.angle, 6).tolist()} for w in chosen(found, asked.keep)]
    if asked.write:
        LIBRARY.write_text('{"plans": [\n' + ",\n".join(json.dumps(w) for w in plans) + "\n]}\n", encoding="ascii")


if __name__ == "__main__":
    main()
