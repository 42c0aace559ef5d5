"""The pace of a motion: joints' own rates, and ramps under their acceleration.

In Stokes flow the path does not depend on how fast it is run, so any pace along each primitive or move gives the same
motion. Each begins and ends at rest: its rates rise and fall in steps, each at the mean rate of the ramp it stands for,
so that rows whose controls hold until the next replay the path exactly.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.moves import ControlSequence, MoveSequence
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block, starting_shapes
from purcell_cli.motion.clock import clock_step

_STEPS = 10
"""Steps of a ramp: the rate is then within a twentieth of the greatest of what a smooth ramp would have."""


def paced(swimmer: Swimmer, start: Array, blocks: Sequence[Block]) -> tuple[Swimmer, tuple[Block, ...]]:
    """Return the strokes at the pace of the joints, and the swimmer whose joint rate their durations are for.

    They are as they are where joints turn at the swimmer's rate, and rates may jump.

    Args:
        swimmer: The swimmer.
        start: Shape before the motion. Shape (2, 3, 3).
        blocks: The motion.
    """
    rates = swimmer.rate_of(0), swimmer.rate_of(1)
    if swimmer.joint_acceleration_rad_s2 is None and rates[0] == rates[1] == swimmer.joint_rate_rad_s:
        return swimmer, tuple(blocks)
    reference = dataclasses.replace(swimmer, joint_rate_rad_s=max(rates))
    shapes = starting_shapes(blocks, start)
    laws = [_laws(swimmer, block.sequence, shape) for block, shape in zip(blocks, shapes[:-1], strict=True)]
    total = sum(b.cycles * float(np.sum(law.seconds)) for b, law in zip(blocks, laws, strict=True))
    step = clock_step(1.01 * total) if total > 0.0 else 1.0
    out = []
    for block, law in zip(blocks, laws, strict=True):
        seconds = np.maximum(np.ceil(law.seconds / step), 1.0) * step
        rate = law.turn / (seconds * max(rates))[:, None]
        sequence = MoveSequence(np.clip(rate, -1.0, 1.0), seconds * max(rates))
        out.append(dataclasses.replace(block, sequence=sequence))
    return reference, tuple(out)


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class _Laws:
    """Pieces of constant rates: the rotation vectors of both limbs [rad], (n, 6), and how long they last [s], (n,)."""

    turn: Array
    seconds: Array


def _laws(swimmer: Swimmer, sequence: ControlSequence, start: Array) -> _Laws:
    """Return the pieces by which a sequence is run as fast as its joints can, from rest to rest on each."""
    units = sequence.rates(sequence.shapes(start)[:-1])
    turns: list[Array] = [np.empty((0, 6))]
    seconds: list[Array] = [np.empty(0)]
    for k, way in enumerate(sequence.duration.tolist()):
        if way == 0.0:
            continue
        parts, times = _ramped(way, *_fastest(swimmer, sequence, units, k))
        turns.append(parts[:, None] * units[k])
        seconds.append(times)
    return _Laws(np.concatenate(turns), np.concatenate(seconds))


def _fastest(swimmer: Swimmer, sequence: ControlSequence, units: Array, k: int) -> tuple[float, float]:
    """Return the greatest rate and acceleration of a piece's duration as it is run: no joint is faster then."""
    acceleration = swimmer.joint_acceleration_rad_s2 or math.inf
    if isinstance(sequence, PrimitiveSequence):
        return swimmer.rate_of(int(sequence.limb[k])), acceleration
    sizes = np.max(np.abs(units[k]).reshape(2, 3), axis=1)
    rate = min(swimmer.rate_of(limb) / float(sizes[limb]) for limb in (0, 1) if sizes[limb] > 0.0)
    return rate, acceleration / float(np.max(sizes))


def _ramped(way: float, rate: float, acceleration: float) -> tuple[Array, Array]:
    """Return the parts of a way that are gone at one rate each, and how long each takes: up, along and down."""
    if math.isinf(acceleration):
        return np.array([way]), np.array([way / rate])
    top = min(rate, math.sqrt(way * acceleration))
    ramp = top / acceleration
    if way < top * ramp * (1.0 + 2.0 / _STEPS):  # no room for a level part as long as a step: a gentler ramp
        ramp = way / top
    step = ramp / _STEPS
    up = (np.arange(_STEPS) + 0.5) / _STEPS * top * step
    level = way - 2.0 * float(np.sum(up))
    along = [level] if level > step * top else []
    parts = np.concatenate([up, along, up[::-1]])
    times = np.concatenate([np.full(_STEPS, step), np.array(along) / top, np.full(_STEPS, step)])
    return parts * (way / float(np.sum(parts))), times
