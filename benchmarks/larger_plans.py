"""Adds larger plans to the motion library: from a short plan on, each for a displacement larger than the last.

    python -m benchmarks.larger_plans --directions 40 --write

In every direction of a displacement, translations and rotations mixed, the search begins where plans take some 6 rad.
It begins with library plans, the last plan found, twice the plan for half as much, and stored gaits. Each is brought
there, shortened, and freed of primitives that turn little. About a minute a direction.
"""

from __future__ import annotations

import argparse
import contextlib
import itertools
import json
from collections.abc import Iterable, Iterator

import numpy as np

from benchmarks.motion_library import LIBRARY
from purcell_cli import Swimmer, stored_gaits
from purcell_cli.errors import GaitError
from purcell_cli.geometry import se3
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.primitives import PrimitiveSequence, joined
from purcell_cli.planner.gait_sequence import split, stroke_book
from purcell_cli.planner.library.plan_library import PRICES, library_for
from purcell_cli.planner.library.random_plans import brought, free_segment
from purcell_cli.planner.refine.exact_arrival import CLOSE, MARGIN_RAD, approach
from purcell_cli.planner.refine.minimum_travel import Pace, merged, minimise_travel, offered, tightened
from purcell_cli.planner.refine.shooting import Equations

BODY = Swimmer(max_bend_rad=1.0).scaled()
BEND = BODY.max_bend_rad - MARGIN_RAD
LOOK, LONG, TIGHT = Pace(1, 10, longest=40), Pace(2, 20, price=300.0, longest=40), Pace(1, 15, price=300.0)
FIRST_RAD, LAST_RAD, LARGER = 6.0, 19.0, 1.35
MOST_PRIMITIVES, KEPT_PRIMITIVES = 110, 60
"""The most primitives that a search begins with, and that a plan of the library has."""
SLIGHT_RAD, DEARER = (0.1, 0.05, 0.02, 0.005), 1.01
"""Primitives of less than these are dropped in turn, if that makes a plan so many times as long at the most."""
NAMED = ((0, 1, 0, 0, 0, 0), (0, 1, 1, 0, 0, 0), (1, 1, 0, 0, 0, 0), (1, 1, 1, 0, 0, 0), (1, 0, 0, 0, 0, 0),
         (0, 0, 0, 0, 0, 1), (0, 0, 0, 0, 1, 1), (0, 0, 0, 1, 1, 0), (0, 0, 0, 1, 1, 1))  # fmt: skip


def directions(count: int) -> Iterator[np.ndarray]:
    """Yield axes and diagonals, then random twists of unit translation and less rotation."""
    named = [np.array(v) / np.linalg.norm(v) for v in NAMED]

    def mixed() -> Iterator[np.ndarray]:
        for seed in itertools.count(1000):
            rng = np.random.default_rng(seed)
            way, turn = rng.normal(size=(2, 3))
            yield np.concatenate([way / np.linalg.norm(way), rng.random() * turn / np.linalg.norm(turn)])

    return itertools.islice(itertools.chain(named, mixed()), count)


def shorter(begun: PrimitiveSequence, goal: np.ndarray, pace: Pace) -> PrimitiveSequence | None:
    """Return a plan shortened, or nothing where it does not arrive."""
    empty = Equations(BODY, (), COLLINEAR, COLLINEAR, goal, SEARCHING)
    for start in (merged(begun), offered(merged(begun), 1)):
        near, off = brought(empty.of([free_segment(start)]), BEND)
        if off < CLOSE:
            break
    else:
        return None
    short, _, off = approach(minimise_travel(near, BEND, pace), BEND)
    if off >= CLOSE:
        return None
    found = short.sequence
    for least in SLIGHT_RAD:
        fewer = merged(found[np.flatnonzero(np.abs(found.angle) > least)])
        if len(fewer) == len(found):
            continue
        near, off = brought(empty.of([free_segment(fewer)]), BEND)
        if off < CLOSE:
            near, _, off = approach(tightened(near, BEND, TIGHT), BEND)
            if off < CLOSE and near.joint_travel_rad < DEARER * short.joint_travel_rad:
                found = near.sequence
    return found


def best(goal: np.ndarray, starts: Iterable[PrimitiveSequence]) -> PrimitiveSequence | None:
    """Return the shortest plan that any of some plans leads to."""
    looked = [shorter(start, goal, LOOK) for start in starts if len(start) <= MOST_PRIMITIVES]
    found = sorted((p for p in looked if p is not None), key=lambda p: p.joint_travel_rad)
    longer = [shorter(plan, goal, LONG) for plan in found[:2]]
    found = [*found[:1], *(p for p in longer if p is not None)]
    return min(found, key=lambda p: p.joint_travel_rad, default=None)


def grown(direction: np.ndarray) -> Iterator[PrimitiveSequence]:
    """Yield plans for ever more of a twist."""
    library, book = library_for(BODY), stroke_book(tuple(stored_gaits().values()), BODY)
    amount, known = FIRST_RAD**2 / float(np.linalg.norm(direction * PRICES)), dict[float, PrimitiveSequence]()
    while amount < 1.0 and (not known or next(reversed(known.values())).joint_travel_rad < LAST_RAD):
        goal = se3.exp(amount * direction)
        starts = [e.lap.times(e.laps) for e in library.nearest(goal[None], np.zeros(1), 2)]
        if known:
            last = next(reversed(known.values()))
            starts = [last.with_angles(1.08 * last.angle), last, *starts[:1]]
        starts += [known[half].times(2) for half in list(known)[::-1] if half < 0.62 * amount][:1]
        with contextlib.suppress(GaitError):
            blocks = [b for motion in split(book, goal) for b in book.blocks(motion)]
            starts.append(joined([b.sequence.times(b.cycles) for b in blocks]))
        if (found := best(goal, starts)) is not None:
            known[amount] = found
            yield found
        amount *= LARGER


def main() -> None:
    """Find plans, and add them to the library if asked."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--directions", type=int, default=40, help="how many directions")
    parser.add_argument("--write", action="store_true", help=f"write {LIBRARY.name}")
    asked = parser.parse_args()
    plans = json.loads(LIBRARY.read_text(encoding="ascii"))["plans"]
    for direction in directions(asked.directions):
        for plan in grown(direction):
            print(
                np.round(direction, 3).tolist(), f"{plan.joint_travel_rad:.3f} rad, {len(plan)} primitives", flush=True
            )
            if len(plan) <= KEPT_PRIMITIVES:
                plans.append({"control": plan.control.tolist(), "angle": np.round(plan.angle, 6).tolist()})
    if asked.write:
        LIBRARY.write_text('{"plans": [\n' + ",\n".join(json.dumps(w) for w in plans) + "\n]}\n", encoding="ascii")


if __name__ == "__main__":
    main()
