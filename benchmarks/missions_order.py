"""How near the best of all orders the order is that `order: free` chooses, on what plans really take.

All orders of random waypoints are priced as the choice prices them, and planned whole in the order of their price, each
with headings of its own, until by the least part of their price that plans take no other could be better.

    python -m benchmarks.missions_order --seeds 5 --out order.jsonl --write

`--out` gains a line a seed, so that a run may be done in pieces. Of more than seven waypoints only the time of the
choice and of the plan is told; their rows go into the same file.
"""

from __future__ import annotations

import argparse
import functools
import statistics
import time
from pathlib import Path

import numpy as np

from benchmarks import pages
from benchmarks.resumed import Row, outcomes, printed
from purcell_cli import Configuration, Mission, Order, PlanOptions, Swimmer, Waypoint, plan_mission
from purcell_cli.planner.missions.leg_price import LegPrice
from purcell_cli.planner.missions.waypoint_order import cheapest_orders, leg_prices
from purcell_cli.planner.missions.waypoint_poses import Touring

SIDE_L = 6.0
"""Side of the cube that positions are in [L]."""
MOST_ENUMERATED = 7
"""Of more waypoints not all orders are priced."""
LEAST = 0.88
"""About the least part of their price that plans take: of 49 orders one took 0.872, all others 0.905 or more."""
COARSE = PlanOptions(dt_s=1.0)
"""Plans are not looked at row by row."""


def outcome(waypoints: int, most: int, number: int) -> Row:
    """Let the planner choose the order of a mission's waypoints, and plan other orders beside it."""
    places = 0.1 * SIDE_L * (np.random.default_rng(number % 1000).random((waypoints + 1, 3)) - 0.5)
    via, goal = tuple(Waypoint(place) for place in places[1:]), Configuration.from_angles(places[0])
    touring = Touring(Swimmer(), LegPrice(Swimmer()))
    begun = time.process_time()
    prices = leg_prices(touring, np.eye(4), via, goal.pose)
    priced = cheapest_orders(*prices, most + 1 if waypoints <= MOST_ENUMERATED else 1)
    row: Row = {"seed": number, "waypoints": waypoints, "ordered_s": time.process_time() - begun}
    begun = time.process_time()
    found = plan_mission(Mission(Configuration(), goal, via, Order.FREE), options=COARSE)
    row |= {"verdict": str(found.verdict), "travel": found.joint_travel_rad, "seconds": time.process_time() - begun}
    if waypoints > MOST_ENUMERATED:
        return row
    spent: list[float] = []
    for order, price in priced[:most]:
        if spent and price * LEAST > min(spent):
            break
        mission = Mission(Configuration(), goal, tuple(via[k] for k in order))
        spent.append(plan_mission(mission, options=COARSE).joint_travel_rad)
    return {**row, "prices": [price for _, price in priced[: len(spent) + 1]], "spent": spent}


def table(rows: list[Row]) -> list[str]:
    """Return what came of missions of few waypoints, a line each, and of more in a sentence."""
    lines = [
        "| mission | travel [rad] | best of the orders planned [rad] | above it | orders planned of 720 "
        "| part of its price another must take to be better |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for row in rows:
        if "spent" in row:
            best = min(row["spent"])
            lines.append(
                f"| {row['seed']} | {row['travel']:.1f} | {best:.1f} | {100.0 * (row['travel'] / best - 1.0):.1f} % "
                f"| {len(row['spent'])} | {best / row['prices'][-1]:.2f} |"
            )
    for count in sorted({row["waypoints"] for row in rows if "spent" not in row}):
        some = [row for row in rows if row["waypoints"] == count]
        ordered, whole = ([row[key] for row in some] for key in ("ordered_s", "seconds"))
        lines += [
            "",
            f"{len(some)} missions of {count} waypoints: the choice of the order takes {max(ordered):.1f} s at most, "
            f"and the whole plan {statistics.median(whole):.1f} s in the median and {max(whole):.1f} s at most.",
        ]
    return lines


def main() -> None:
    """Go on with the missions that are not in the file yet, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--waypoints", type=int, default=6)
    parser.add_argument("--orders", type=int, default=24, help="how many orders are planned at most")
    parser.add_argument("--out", type=Path, required=True, help="gains a line a mission")
    parser.add_argument("--write", action="store_true", help="put the table into the documentation")
    asked = parser.parse_args()
    apart = 0 if asked.waypoints <= MOST_ENUMERATED else 1000 * asked.waypoints
    seeds = range(apart + asked.first, apart + asked.first + asked.seeds)
    lines = table(outcomes(asked.out, seeds, functools.partial(outcome, asked.waypoints, asked.orders), printed))
    print("\n".join(lines))
    if asked.write:
        pages.put("how-to/missions.md", "missions order", "\n".join(lines))


if __name__ == "__main__":
    main()
