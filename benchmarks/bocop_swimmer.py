"""The planar swimmer of control-toolbox's bocop: how far it gets in 25 s, by the planner's programs and trust region.

    python -m benchmarks.bocop_swimmer

Base half length 1, limb half lengths 0.5, drag ratio 2; both joints turn at most at 1 rad/s and keep within 1.5 rad;
heading and shapes are free at both ends, and y is 0 at the end. The heading being free, the largest x is the largest
distance. The angles at the ends of equal intervals are the unknowns, the joints' rates being constant in each. bocop's
repository keeps 0.984273.
"""

from __future__ import annotations

import argparse
import dataclasses
import itertools

import numpy as np
from scipy.integrate import solve_ivp

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.kernel.convex import Blocks, least
from purcell_cli.mechanics.connection import COLLINEAR, connection
from purcell_cli.mechanics.lift import EXACT, flow
from purcell_cli.mechanics.lift_derivatives import flow_and_jacobian_of_moves
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.planner.refine.octagonal_loops import yaws
from purcell_cli.planner.refine.trust_region import descended

SWIMMER = Swimmer(base_half_length_m=1.0, limb_half_length_m=0.5, drag_ratio=2.0)
DURATION_S, LARGEST_RAD = 25.0, 1.5
KNOWN, BETTER = 0.984273, 1.0190
"""What bocop's repository keeps, and what a direct solution of 100 constant pieces reached."""
SHRUNK = 1e-4
"""By what part a motion is shrunk to begin a program strictly within its bounds."""


@dataclasses.dataclass(frozen=True, eq=False)
class Point:
    """A motion: the limbs' angles, how far it goes [m], and how that changes with the angles. Shapes (n + 1, 2)."""

    angle: np.ndarray
    distance: float
    slope: np.ndarray

    @property
    def merit(self) -> float:
        """What is to be least."""
        return -self.distance


def point(angle: np.ndarray) -> Point:
    """Return a motion with its derivative; it is seen from the collinear shape by a move to its first shape."""
    turn = yaws(np.concatenate([angle[:1], np.diff(angle, axis=0)]))
    whole, by_turn = flow_and_jacobian_of_moves(SWIMMER, MoveSequence.of_turns(turn), COLLINEAR, EXACT)
    first, by_first = flow_and_jacobian_of_moves(SWIMMER, MoveSequence.of_turns(turn[:1]), COLLINEAR, EXACT)
    swum = se3.inverse(first) @ whole
    by_turn[:, 0] -= se3.adjoint(se3.inverse(swum)) @ by_first[:, 0]
    distance = float(np.linalg.norm(swum[:3, 3]))
    along = swum[:3, 3] / distance @ swum[:3, :3]
    by = np.tensordot(along, by_turn[:3][..., [2, 5]], axes=1)  # by each turn
    slope = by.copy()
    slope[:-1] -= by[1:]  # an angle ends a turn and begins the next
    return Point(angle, distance, slope)


class Search:
    """Linear programs for the furthest motion near a motion: all angles are one block, whose walls are the bounds."""

    def __init__(self, intervals: int) -> None:
        n = 2 * (intervals + 1)
        turn = (np.eye(n, k=2) - np.eye(n))[:-2]
        walls = np.concatenate([np.eye(n), -np.eye(n), turn, -turn])
        self.blocks = Blocks.of([walls], [0], np.zeros(n))
        self.most = np.full(2 * len(turn), DURATION_S / intervals)

    def step(self, here: Point, reach: float) -> tuple[np.ndarray, float] | None:
        """Return the angles of the best linear prediction within reach, and its merit."""
        angle = here.angle.ravel()
        high = np.minimum(angle + reach, LARGEST_RAD)
        low = np.maximum(angle - reach, -LARGEST_RAD)
        blocks = dataclasses.replace(self.blocks, cost=-here.slope.ravel())
        bound, begun = np.concatenate([high, -low, self.most]), (1.0 - SHRUNK) * angle
        found = least(blocks, bound, np.empty((0, 0)), [], 0, 1.0, begun, 1e-9)
        if found is None:
            return None
        return found.reshape(-1, 2), here.merit - float(here.slope.ravel() @ (found - angle))


def furthest(begun: np.ndarray, steps: int) -> Point:
    """Return the motion that linear programs lead to."""
    search = Search(len(begun) - 1)
    return descended(point(begun), search.step, lambda _, angle, *__: point(angle), steps, lambda _: 1e-9)[0]


def beginning(intervals: int, strokes: int, sense: float) -> np.ndarray:
    """Return circles of both limbs' angles, so many in the time, as large as rates and angles allow."""
    phase = 2.0 * np.pi * strokes * np.linspace(0.0, 1.0, intervals + 1)
    size = 0.98 * min(LARGEST_RAD, DURATION_S / (2.0 * np.pi * strokes))
    return size * np.column_stack([np.cos(phase), sense * np.sin(phase)])


def replayed(angle: np.ndarray) -> np.ndarray:
    """Return where another integrator (DOP853 on A(r)) ends: x, y [m] and heading [rad], from heading 0."""
    each = DURATION_S / (len(angle) - 1)
    here = np.zeros(3)
    for begin, end in itertools.pairwise(angle):
        rate = (end - begin) / each

        def moves(time: float, state: np.ndarray, begin: np.ndarray = begin, rate: np.ndarray = rate) -> np.ndarray:
            bent = begin + time * rate
            shape = se3.rotation(np.array([[0.0, 0.0, bent[0]], [0.0, 0.0, bent[1]]]))
            controls = np.array([0.0, 0.0, rate[0], 0.0, 0.0, rate[1]])
            twist = -connection(SWIMMER, shape) @ controls
            c, s = np.cos(state[2]), np.sin(state[2])
            return np.array([c * twist[0] - s * twist[1], s * twist[0] + c * twist[1], twist[5]])

        here = solve_ivp(moves, (0.0, each), here, "DOP853", rtol=1e-10, atol=1e-12).y[:, -1]
    return here


def main() -> None:
    """Search from circles of several sizes, and replay the best."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--intervals", type=int, default=100)
    parser.add_argument("--steps", type=int, default=150, help="linear programs from each beginning")
    asked = parser.parse_args()
    best = None
    for strokes in (2, 3, 4, 5, 6):
        for sense in (1.0, -1.0):
            found = furthest(beginning(asked.intervals, strokes, sense), asked.steps)
            print(f"{strokes} circles, sense {sense:+.0f}: {found.distance:.6f}", flush=True)
            if best is None or found.distance > best.distance:
                best = found
    if best is None:
        return
    x, y, turned = replayed(best.angle)
    shape = se3.rotation(yaws(best.angle[:1]).reshape(2, 3))
    swum = float(np.linalg.norm(flow(SWIMMER, MoveSequence.of_turns(yaws(np.diff(best.angle, axis=0))), shape)[:3, 3]))
    heading, bend = -np.arctan2(y, x), np.max(np.abs(best.angle))
    rate = np.max(np.abs(np.diff(best.angle, axis=0))) * asked.intervals / DURATION_S
    print(f"x = {np.hypot(x, y):.6f} by DOP853, {swum:.6f} by the package's flow")
    print(
        f"heading {heading:.4f} to {heading + turned:.4f}, largest rate {rate:.9f} rad/s, largest angle {bend:.9f} rad"
    )
    print(f"bocop keeps {KNOWN}; a direct solution reached {BETTER}")


if __name__ == "__main__":
    main()
