"""Random plans: random pitches and yaws that Newton's method brings to the goal.

For a small displacement the best motions interleave bends of both limbs and small roll strokes in an
order without a pattern. Of a few dozen random plans, each brought to the goal and then refined for
minimum travel, some come close to the best known.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from purcell_cli.geometry.reproducible import normal_numbers
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.planner.refine.exact_arrival import Patience, approach
from purcell_cli.planner.refine.minimum_travel import NAME
from purcell_cli.planner.refine.segments import Segment
from purcell_cli.planner.refine.shooting import Equations

_BOLD = Patience(0.6, rounds=8)
"""How Newton's method goes from a random plan, which begins far from the goal."""
_BENDS = (1, 2, 4, 5)
"""Controls of random plans: the pitches and yaws of both limbs."""
_ROUNDS = (4, 5, 6)
"""How often a random plan uses each control; one of these is drawn."""
_SPREADS_RAD = (0.15, 0.3, 0.5)
"""Standard deviations of the angles of a random plan; one of these is drawn [rad]."""


def random_plans(count: int, seed: int = 0, bends: Sequence[int] = _BENDS) -> Iterator[Segment]:
    """Yield random plans of phase 2: each of the limbs' pitches and yaws, in a few rounds.

    Args:
        count: How many.
        seed: Seed of their orders and angles.
        bends: The controls that bend limbs; of fewer, there are more rounds.
    """
    rng = np.random.default_rng(seed)
    for _ in range(count):
        rounds = int(rng.choice(_ROUNDS)) * max(1, len(_BENDS) // len(bends))
        same = rng.permutation(bends)
        fresh = bool(rng.integers(2))
        control = np.concatenate([rng.permutation(bends) if fresh else same for _ in range(rounds)])
        angle = rng.choice(_SPREADS_RAD) * normal_numbers(rng, (len(control),))
        yield free_segment(PrimitiveSequence(control, angle))


def free_segment(sequence: PrimitiveSequence) -> Segment:
    """Return primitives as a phase 2 whose angles may all change."""
    return Segment(2, ((NAME, math.nan, len(sequence)),), sequence)


def brought(motion: Equations, max_bend_rad: float) -> tuple[Equations, float]:
    """Return a motion by such a plan brought to the goal, almost exactly, and what it misses by [L, rad].

    Args:
        motion: The motion.
        max_bend_rad: How far a limb may bend in phase 2 [rad].
    """
    near, _, off = approach(motion, max_bend_rad, _BOLD)
    return near, off
