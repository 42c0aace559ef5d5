"""A binary clock: times whose sums and differences are exact."""

from __future__ import annotations

import math

import numpy as np

from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.moves import ControlSequence
from purcell_cli.mechanics.swimmer import Swimmer


def clock_step(duration_s: float) -> float:
    """Return the tick that times of a motion are whole multiples of [s].

    It is a power of two, the spacing of floating-point numbers at the motion's end, so that every
    time and every difference of times is exact, and the written times replay the motion exactly.
    """
    return math.ldexp(1.0, math.frexp(duration_s)[1] - 53)


def rounded(angle: Array, rate_rad_s: float, step: float) -> Array:
    """Return angles rounded to what a joint turns in a whole number of clock steps [rad].

    Args:
        angle: Angles [rad]. Shape (n,).
        rate_rad_s: The joints' rate [rad/s].
        step: The clock step [s].
    """
    return np.asarray(np.rint(angle / rate_rad_s / step) * step * rate_rad_s)


def on_the_clock(sequence: ControlSequence, swimmer: Swimmer, step: float) -> ControlSequence:
    """Return controls whose durations are whole numbers of clock steps."""
    duration = rounded(sequence.duration, swimmer.joint_rate_rad_s, step)
    return sequence.lasting(np.arange(len(sequence)), duration)
