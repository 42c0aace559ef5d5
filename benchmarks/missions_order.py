"""How near the best of all orders the order is that `order: free` chooses, on what plans really take.

All orders of random waypoints are priced as the choice prices them; those of least price are planned whole, each with
headings of its own, and the best of them counts as the best of all: prices are within some 10 % of what plans take.
Run: python benchmarks/missions_order.py [--seeds 3] [--waypoints 6] [--orders 10]; with --waypoints 12 only the time of
the choice and of the plan is told.
"""

from __future__ import annotations

import argparse
import itertools
import time

import numpy as np

from purcell_cli import Configuration, Mission, Order, PlanOptions, Swimmer, Waypoint, plan_mission
from purcell_cli.planner.missions.leg_price import LegPrice
from purcell_cli.planner.missions.waypoint_order import best_order, leg_prices, price_of_order
from purcell_cli.planner.missions.waypoint_poses import Touring

SIDE_L = 6.0
"""Side of the cube that positions are in [L]."""
MOST_ENUMERATED = 7
"""Of more waypoints not all orders are priced."""
COARSE = PlanOptions(dt_s=1.0)
"""Plans are not looked at row by row."""


def main() -> None:
    """Measure, and print a line for each seed."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--waypoints", type=int, default=6)
    parser.add_argument("--orders", type=int, default=10, help="how many orders of least price are planned")
    asked = parser.parse_args()
    touring = Touring(Swimmer(), LegPrice(Swimmer()))
    for seed in range(asked.seeds):
        places = 0.1 * SIDE_L * (np.random.default_rng(seed).random((asked.waypoints + 1, 3)) - 0.5)
        via, goal = tuple(Waypoint(place) for place in places[1:]), Configuration.from_angles(places[0])
        begun = time.process_time()
        prices = leg_prices(touring, np.eye(4), via, goal.pose)
        chosen, price = best_order(*prices)
        ordered = time.process_time() - begun
        begun = time.process_time()
        found = plan_mission(Mission(Configuration(), goal, via, Order.FREE), options=COARSE)
        whole = time.process_time() - begun
        told = f"{seed}: order {chosen} in {ordered:.2f} s, {found.verdict}, {found.joint_travel_rad:.1f} rad, "
        told += f"priced {price:.1f}, in {whole:.2f} s"
        if asked.waypoints <= MOST_ENUMERATED:
            every = list(itertools.permutations(range(asked.waypoints)))
            priced = sorted(every, key=lambda order: price_of_order(order, *prices))
            spent = []
            for order in priced[: asked.orders]:
                mission = Mission(Configuration(), goal, tuple(via[k] for k in order))
                spent.append(plan_mission(mission, options=COARSE).joint_travel_rad)
            best = int(np.argmin(spent))
            told += f"; best of {len(spent)} orders planned {spent[best]:.1f} rad (the {best + 1}. by price), "
            told += f"so {100.0 * (found.joint_travel_rad / spent[best] - 1.0):.1f} % above it"
        print(told, flush=True)


if __name__ == "__main__":
    main()
