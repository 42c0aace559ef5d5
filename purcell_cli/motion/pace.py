"""The pace of a motion: joints' own rates, and ramps under their acceleration.

In Stokes flow the path does not depend on how fast it is run, so any pace along each primitive or move gives the same
motion. Each begins and ends at rest: its rates rise and fall in steps, each at the mean rate of the ramp it stands for,
so that rows whose controls hold until the next replay the path exactly.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import cast

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.joint_motion import joint_rates
from purcell_cli.mechanics.moves import ControlSequence, MoveSequence
from purcell_cli.mechanics.pieces import Pieces
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
    out = []
    for block, law in zip(blocks, laws, strict=True):
        seconds = _on_the_clock(law.seconds, total)
        rate = law.turn / (seconds * max(rates))[:, None]
        sequence = MoveSequence(np.clip(rate, -1.0, 1.0), seconds * max(rates))
        out.append(dataclasses.replace(block, sequence=sequence))
    return reference, tuple(out)


def _on_the_clock(seconds: Array, total_s: float) -> Array:
    """Return times that are whole numbers of clock steps, none shorter, for a motion that takes a time [s]."""
    step = clock_step(1.01 * total_s) if total_s > 0.0 else 1.0
    return np.asarray(np.maximum(np.ceil(seconds / step), 1.0) * step)


@frozen_dataclass(eq=False)
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
        parts, times = _ramped(way, *_fastest(swimmer, sequence, k))
        turns.append(parts[:, None] * units[k])
        seconds.append(times)
    return _Laws(np.concatenate(turns), np.concatenate(seconds))


def _fastest(swimmer: Swimmer, sequence: ControlSequence, k: int) -> tuple[float, float]:
    """Return the greatest rate and acceleration of a piece's duration as it is run: no joint is faster then."""
    if isinstance(sequence, MoveSequence):
        return _factors(swimmer, sequence.joint_rate[k])
    primitives = cast(PrimitiveSequence, sequence)
    return swimmer.rate_of(int(primitives.limb[k])), swimmer.joint_acceleration_rad_s2 or math.inf


def _factors(swimmer: Swimmer, rates: Array) -> tuple[float, float]:
    """Return by which factor joints may be faster than at some rates, not all 0, and how fast it may change [1/s]."""
    sizes = np.max(np.abs(rates).reshape(2, 3), axis=1)
    rate = min(swimmer.rate_of(limb) / float(sizes[limb]) for limb in (0, 1) if sizes[limb] > 0.0)
    return rate, (swimmer.joint_acceleration_rad_s2 or math.inf) / float(np.max(sizes))


@frozen_dataclass(eq=False)
class Slowed:
    """Controls at the pace of joints that cannot follow them as they are.

    Attributes:
        row: The row that each piece begins in. Shape (m,).
        rates: The pieces' controls [rad/s]. Shape (m, 6).
        seconds: How long they last [s]. Shape (m,).
    """

    row: NDArray[np.int64]
    rates: Array
    seconds: Array


_SAME_WAY = 1e-12
"""Directions of controls, as unit vectors, that differ by less are one: the steps of a ramp are one turn."""


def slowed(swimmer: Swimmer, pieces: Pieces, stops: NDArray[np.int64]) -> Slowed:
    """Return controls as fast as joints can follow them, from rest to rest where other joints turn, on the same path.

    Args:
        swimmer: The swimmer.
        pieces: The motion, row by row. There are n.
        stops: Rows at which joints rest, whether or not the controls change there. Shape (k,).
    """
    pace = np.sqrt(np.sum(pieces.rates**2, axis=1))
    ways = pieces.rates / np.where(pace > 0.0, pace, 1.0)[:, None]
    changes = np.append(True, np.any(np.abs(ways[1:] - ways[:-1]) > _SAME_WAY, axis=1))
    changes[stops] = True
    begins = np.flatnonzero(changes)
    first = np.repeat(pace[begins], np.diff(np.append(begins, len(pace))))
    lengths = pieces.durations * np.divide(pace, first, out=np.ones_like(pace), where=first > 0.0)
    sizes = joint_rates(swimmer, pieces.shapes[begins], pieces.rates[begins])
    row, rates, seconds = list[int](), [np.empty((0, 6))], [np.empty(0)]
    for k, size, way in zip(begins.tolist(), sizes, np.add.reduceat(lengths, begins).tolist(), strict=True):
        if way == 0.0:
            continue
        parts, times = _ramped(way, *(_factors(swimmer, size) if np.any(size) else (1.0, math.inf)))
        row += [k] * len(parts)
        rates.append((parts / times)[:, None] * pieces.rates[k])
        seconds.append(times)
    lasts = np.concatenate(seconds)
    on_clock = _on_the_clock(lasts, float(np.sum(lasts)))
    return Slowed(np.array(row, dtype=np.int64), np.concatenate(rates) * (lasts / on_clock)[:, None], on_clock)


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
