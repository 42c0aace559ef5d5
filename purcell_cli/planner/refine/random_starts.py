"""Random motions to begin from: all joints swing together from the start's shape to the goal's.

Plans by primitives are made of loops round the collinear shape. Where limbs may bend far, other motions are much
quicker, and some of those that swing at random end near enough to the goal for Newton's method. Each component of the
limbs' rotation vectors swings at one frequency, with an amplitude and a phase of its own.
"""

from __future__ import annotations

import math

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul, norm, sin
from purcell_cli.geometry.rotations import Array, as_vector
from purcell_cli.mechanics.lift import ROUGH, flow
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.planner.refine.segments import Segment
from purcell_cli.planner.refine.shooting import Equations

_PERIOD_S = (3.0, 8.0)
"""The shortest and the longest period of a swing, at a joint rate of 1 rad/s [s]."""
_MOVE_S = 0.45
"""How long a move lasts, about [s]."""
_SWING_RAD = 2.0
"""The largest amplitude of a component [rad], and no more than the bend limit."""


def random_starts(motion: Equations, gait: str, duration: float, tried: int, kept: int, seed: int) -> list[Equations]:
    """Return the random motions, of some, that end nearest to the goal, best first.

    Args:
        motion: The motion to be made, by limbs on ball joints.
        gait: What they are called.
        duration: How long they last at a joint rate of 1 rad/s, about [s].
        tried: How many are made.
        kept: How many are returned.
        seed: Of the random numbers.
    """
    rng, made = np.random.default_rng(seed), list[tuple[float, int, Array]]()
    moves = max(math.ceil(duration / _MOVE_S), 8)
    time = np.linspace(0.0, 1.0, moves + 1)[:, None]
    ends = [as_vector(shape).reshape(6) for shape in (motion.start, motion.goal)]
    largest = min(_SWING_RAD, motion.swimmer.max_bend_rad)
    for _ in range(tried):
        cycles = max(duration / rng.uniform(*_PERIOD_S), 1.0)
        amplitude, phase = largest * rng.uniform(0.0, 1.0, 6), rng.uniform(0.0, 2.0 * math.pi, 6)
        swing = amplitude * sin(2.0 * math.pi * cycles * time + phase)
        grown = np.minimum(np.minimum(time, 1.0 - time) * cycles * 2.0, 1.0)
        path = se3.rotation(((1.0 - time) * ends[0] + time * ends[1] + grown * swing).reshape(-1, 2, 3))
        turn = as_vector(matmul(np.swapaxes(path[:-1], -1, -2), path[1:])).reshape(-1, 6)
        went = flow(motion.swimmer, MoveSequence.of_turns(turn), motion.start, ROUGH)
        off = se3.log(se3.normalised(matmul(se3.inverse(motion.displacement), went)))
        made.append((round(float(norm(off)), 9), len(made), turn))
    made.sort(key=lambda one: one[:2])
    return [motion.of([Segment.by_moves(2, gait, turn)]) for _, _, turn in made[:kept]]
