"""A stroke as it is played: at the pace of the joints, and sampled as a trajectory for plots and files."""

from __future__ import annotations

import dataclasses
import math

from purcell_cli.gaits.gait import Stroke
from purcell_cli.gaits.joint_fit import refuse_far_stroke
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.clock import clock_step, on_the_clock
from purcell_cli.motion.memory import refuse_huge, too_many_rows
from purcell_cli.motion.pace import paced
from purcell_cli.motion.trajectory import Trajectory, sample


def paced_stroke(swimmer: Swimmer, stroke: Stroke, cycles: int) -> tuple[Swimmer, tuple[Block, ...]]:
    """Return a stroke played a number of times at the joints' pace, and the swimmer whose joint rate it is for.

    Args:
        swimmer: The swimmer.
        stroke: The stroke, from the collinear shape.
        cycles: How often it is played.
    """
    parts = [Block(2, stroke.gait, s, n, stroke.amplitude_rad) for s, n in stroke.parts(cycles) if len(s)]
    return paced(swimmer, COLLINEAR, parts)


def sample_stroke(
    swimmer: Swimmer,
    start: Configuration,
    stroke: Stroke,
    cycles: int,
    dt_s: float = 0.05,
    max_memory_gb: float = math.inf,
) -> Trajectory:
    """Return the trajectory of a stroke played a number of times from a collinear configuration.

    Args:
        swimmer: The swimmer.
        start: The configuration at time 0.
        stroke: The stroke.
        cycles: How often it is played.
        dt_s: Longest time between rows [s].
        max_memory_gb: The memory that it may take; see `budget_gb` [GB].

    Raises:
        ParameterError: It takes too many rows, or more memory.
        GaitError: It bends a limb further than links that feel each other do.
    """
    refuse_far_stroke(swimmer, stroke, cycles)
    pace, parts = paced_stroke(swimmer, stroke, cycles)
    duration_s = sum(b.duration for b in parts) / pace.joint_rate_rad_s
    if (found := too_many_rows(duration_s, dt_s)) is not None:
        raise found
    refuse_huge(sum(b.cycles * len(b.sequence) for b in parts), duration_s / dt_s, max_memory_gb)
    step = clock_step(duration_s)
    blocks = [dataclasses.replace(b, sequence=on_the_clock(b.sequence, pace, step)) for b in parts]
    return sample(pace, start, blocks, dt_s)
