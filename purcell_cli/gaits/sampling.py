"""A stroke sampled as a trajectory, for plots and files."""

from __future__ import annotations

import dataclasses

from purcell_cli.gaits.gait import Stroke
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.clock import clock_step, on_the_clock
from purcell_cli.motion.trajectory import Trajectory, sample


def sample_stroke(
    swimmer: Swimmer, start: Configuration, stroke: Stroke, cycles: int, dt_s: float = 0.05
) -> Trajectory:
    """Return the trajectory of a stroke played a number of times from a collinear configuration.

    Args:
        swimmer: The swimmer.
        start: The configuration at time 0.
        stroke: The stroke.
        cycles: How often it is played.
        dt_s: Longest time between rows [s].
    """
    parts = [Block(2, stroke.gait, s, n, stroke.amplitude_rad) for s, n in stroke.parts(cycles) if len(s)]
    step = clock_step(sum(b.duration for b in parts) / swimmer.joint_rate_rad_s)
    blocks = [dataclasses.replace(b, sequence=on_the_clock(b.sequence, swimmer, step)) for b in parts]
    return sample(swimmer, start, blocks, dt_s)
