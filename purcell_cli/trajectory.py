"""Motions as blocks of controls, and the trajectory they make, row by row.

A block is a stroke played a number of times. Left invariance makes every repetition the same
displacement, so a block costs one cycle and its powers. Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from purcell_cli import se3
from purcell_cli.configuration import Configuration
from purcell_cli.errors import ParameterError
from purcell_cli.gaits import Stroke
from purcell_cli.lift import EXACT, Accuracy, piece_displacements, piece_work
from purcell_cli.moves import ControlSequence
from purcell_cli.primitives import EMPTY
from purcell_cli.rotations import Array, as_euler, as_quaternion
from purcell_cli.swimmer import Swimmer

MOST_ROWS = 3e6
"""How many rows a trajectory may have."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Block:
    """A stroke played a number of times; one that repeats brings the limbs back to where they were.

    Attributes:
        phase: 1, 2 or 3 of the reconfiguration.
        gait: Name of the stroke.
        sequence: Primitives or moves of one cycle.
        cycles: How often they are played.
        amplitude_rad: Amplitude of the stroke, where it has one [rad].
    """

    phase: int
    gait: str
    sequence: ControlSequence
    cycles: int = 1
    amplitude_rad: float = math.nan

    @property
    def joint_travel_rad(self) -> float:
        """The sum over all its pieces and joints of |angle| [rad]."""
        return self.cycles * self.sequence.joint_travel_rad

    @property
    def duration(self) -> float:
        """How long it lasts at a joint rate of 1 rad/s [s]."""
        return self.cycles * float(np.sum(self.sequence.duration))


def starting_shapes(blocks: Sequence[Block], start: ArrayLike) -> list[Array]:
    """Return the shape before each block, and after the last. Each of shape (2, 3, 3)."""
    shapes = [np.array(start, dtype=np.float64)]
    for block in blocks:
        shapes.append(block.sequence.shapes(shapes[-1])[-1])
    return shapes


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Pieces:
    """The pieces of all blocks, one cycle each, to be computed in one batch.

    Attributes:
        shapes: Shapes before them. Shape (n, 2, 3, 3).
        rates: Limb rates at a joint rate of 1 rad/s [rad/s]. Shape (n, 6).
        duration: How long they last at that joint rate [s]. Shape (n,).
        stops: The piece after the last of each block.
    """

    shapes: Array
    rates: Array
    duration: Array
    stops: list[int]

    @classmethod
    def of(cls, sequences: Sequence[ControlSequence], shapes: Sequence[Array]) -> Pieces:
        """Return the pieces of sequences, each from a shape of its own."""
        begun = [np.empty((0, 2, 3, 3))] + [q.shapes(s)[:-1] for q, s in zip(sequences, shapes, strict=False)]
        rates = [np.empty((0, 6))] + [q.rates() for q in sequences]
        duration = [np.empty(0)] + [q.duration for q in sequences]
        stops = np.cumsum([len(q) for q in sequences], dtype=np.int64).tolist()
        return cls(np.concatenate(begun), np.concatenate(rates), np.concatenate(duration), stops)

    def split(self, values: Array) -> list[Array]:
        """Return what belongs to each block, of values for every piece."""
        return np.split(values, self.stops[:-1]) if self.stops else []


def block_displacements(
    swimmer: Swimmer, blocks: Sequence[Block], start: ArrayLike, accuracy: Accuracy = EXACT
) -> Array:
    """Return the body displacement made by each block [m]. Shape (n, 4, 4).

    Args:
        swimmer: The swimmer.
        blocks: The motion.
        start: Shape before it. Shape (2, 3, 3).
        accuracy: Of the flow.
    """
    pieces = Pieces.of([b.sequence for b in blocks], starting_shapes(blocks, start))
    moves = pieces.split(piece_displacements(swimmer, pieces.shapes, pieces.rates, pieces.duration, accuracy))
    out = np.empty((len(blocks), 4, 4))
    for k, (block, cycle) in enumerate(zip(blocks, moves, strict=True)):
        out[k] = se3.power(se3.prefix_products(cycle)[-1], block.cycles)
    return out


def energies(swimmer: Swimmer, blocks: Sequence[Block], start: ArrayLike) -> Array:
    """Return the energy dissipated in each block at the swimmer's joint rate [J]. Shape (n,)."""
    pieces = Pieces.of([b.sequence for b in blocks], starting_shapes(blocks, start))
    once = pieces.split(piece_work(swimmer, pieces.shapes, pieces.rates, pieces.duration))
    return np.array([b.cycles * float(np.sum(w)) for b, w in zip(blocks, once, strict=True)])


def clock_step(duration_s: float) -> float:
    """Return the tick that times of a motion are whole multiples of [s].

    It is a power of two, the spacing of floating-point numbers at the motion's end, so that every
    time and every difference of times is exact, and the written times replay the motion exactly.
    """
    return math.ldexp(1.0, math.frexp(max(duration_s, 1.0))[1] - 53)


def rounded(angle: Array, rate_rad_s: float, step: float) -> Array:
    """Return angles rounded to what a joint turns in a whole number of clock steps [rad].

    Args:
        angle: Angles [rad]. Shape (n,).
        rate_rad_s: The joints' rate [rad/s].
        step: The clock step [s].
    """
    return np.asarray(np.round(angle / rate_rad_s / step) * step * rate_rad_s)


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Trajectory:
    """A motion sampled in time; the rates of a row hold until the next row's time.

    Attributes:
        time_s: Times, from 0. Shape (n,).
        phase: Phase of the reconfiguration. Shape (n,).
        gait: Index into `gaits` of the stroke a row belongs to. Shape (n,).
        gaits: Names of the strokes.
        pose: The base's poses in the world [m]. Shape (n, 4, 4).
        shape: Limb orientations. Shape (n, 2, 3, 3).
        rate_rad_s: The six controls; 0 in the last row. Shape (n, 6).
    """

    time_s: Array
    phase: NDArray[np.int64]
    gait: NDArray[np.int64]
    gaits: tuple[str, ...]
    pose: Array
    shape: Array
    rate_rad_s: Array

    def __post_init__(self) -> None:
        for field in ("time_s", "phase", "gait", "pose", "shape", "rate_rad_s"):
            getattr(self, field).setflags(write=False)

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def end(self) -> Configuration:
        """The last row's configuration."""
        return Configuration(self.pose[-1], self.shape[-1])

    @property
    def base_quaternion(self) -> Array:
        """The base's quaternions (w, x, y, z), signs continuous along the rows. Shape (n, 4)."""
        return _continuous(as_quaternion(self.pose[:, :3, :3]))

    @property
    def limb_quaternion(self) -> Array:
        """The limbs' quaternions (w, x, y, z), signs continuous along the rows. Shape (n, 2, 4)."""
        return np.stack([_continuous(as_quaternion(self.shape[:, i])) for i in (0, 1)], axis=1)

    @property
    def base_euler_rad(self) -> Array:
        """The base's Euler angles (psi, theta, phi) [rad]. Shape (n, 3)."""
        return as_euler(self.pose[:, :3, :3])


def _continuous(quaternion: Array) -> Array:
    turn = np.einsum("ni,ni->n", quaternion[1:], quaternion[:-1]) < 0
    sign = np.concatenate([[1.0], np.where(turn, -1.0, 1.0)]).cumprod()
    return np.asarray(quaternion * sign[:, None])


def sample(swimmer: Swimmer, start: Configuration, blocks: Sequence[Block], dt_s: float = 0.05) -> Trajectory:
    """Return the trajectory of blocks: a row at every control switch and at least every dt between.

    Args:
        swimmer: The swimmer; its joint rate sets the pace.
        start: The configuration at time 0.
        blocks: The motion, its durations whole numbers of clock steps (`rounded`).
        dt_s: Longest time between rows [s].

    Raises:
        ParameterError: A time between rows that is not positive, or that asks for too many rows.
    """
    duration = sum(b.duration for b in blocks) / swimmer.joint_rate_rad_s
    if not dt_s > 0 or duration / dt_s > MOST_ROWS:
        raise ParameterError(
            f"dt: a time above {duration / MOST_ROWS:.2g} s is wanted (at most {MOST_ROWS:.0e} rows), found {dt_s!r}"
        )
    step = clock_step(duration)
    shapes = starting_shapes(blocks, start.shape)
    names = tuple(dict.fromkeys(b.gait for b in blocks))
    parts: list[tuple[Array, ...]] = []
    pose, time = start.pose, 0.0
    for block, rows in zip(blocks, _rows(swimmer, blocks, shapes, dt_s, step), strict=True):
        if not len(rows.time_s):
            continue
        counts = np.arange(block.cycles)
        origins = pose if block.cycles == 1 else se3.normalised(pose @ se3.power(rows.end, counts))
        n = len(rows.time_s)
        parts.append(
            (
                (time + counts[:, None] * rows.duration_s + rows.time_s).ravel(),
                np.full(block.cycles * n, block.phase),
                np.full(block.cycles * n, names.index(block.gait)),
                (np.reshape(origins, (-1, 1, 4, 4)) @ rows.pose).reshape(-1, 4, 4),
                np.tile(rows.shape, (block.cycles, 1, 1, 1)),
                np.tile(rows.rate_rad_s, (block.cycles, 1)),
            )
        )
        time += block.cycles * rows.duration_s
        pose = se3.normalised(pose @ se3.power(rows.end, block.cycles))
    last = blocks[-1] if blocks else Block(3, "none", EMPTY)
    parts.append(
        (
            np.array([time]),
            np.array([last.phase]),
            np.array([names.index(last.gait) if names else 0]),
            pose[None],
            shapes[-1][None],
            np.zeros((1, 6)),
        )
    )
    columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
    return Trajectory(columns[0], columns[1], columns[2], names or ("none",), *columns[3:])


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class _CycleRows:
    """The rows of one cycle, relative to its beginning."""

    time_s: Array
    duration_s: float
    pose: Array
    shape: Array
    rate_rad_s: Array
    end: Array


def _rows(
    swimmer: Swimmer, blocks: Sequence[Block], shapes: Sequence[Array], dt_s: float, step: float
) -> list[_CycleRows]:
    """Return the rows of one cycle of each block."""
    rate = swimmer.joint_rate_rad_s
    timed = [_cut(block.sequence, rate, dt_s, step) for block in blocks]
    pieces = Pieces.of([sequence for sequence, _, _ in timed], shapes)
    moves = pieces.split(piece_displacements(swimmer, pieces.shapes, pieces.rates, pieces.duration))
    begun, rates = pieces.split(pieces.shapes), pieces.split(pieces.rates)
    out = []
    for k, (_, time, total) in enumerate(timed):
        poses = se3.prefix_products(moves[k])
        out.append(_CycleRows(time, total, poses[:-1], begun[k], rates[k] * rate, poses[-1]))
    return out


def _cut(
    sequence: ControlSequence, rate_rad_s: float, dt_s: float, step: float
) -> tuple[ControlSequence, Array, float]:
    """Return a sequence cut into rows, their times, and how long it lasts [s]."""
    used = np.flatnonzero(sequence.duration)
    duration = sequence.duration[used] / rate_rad_s
    count = np.maximum(np.ceil(duration / dt_s - 1e-9), 1).astype(np.int64)
    index = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    part = np.round(np.repeat(duration / count, count) * index / step) * step
    time = np.repeat(np.cumsum(duration) - duration, count) + part
    total = float(duration.sum())
    length = np.diff(np.append(time, total)) * rate_rad_s
    return sequence.lasting(np.repeat(used, count), length), time, total


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
    parts = [(stroke.approach, 1), (stroke.cycle, cycles), (stroke.approach.inverse(), 1)]
    step = clock_step(stroke.played(1).joint_travel_rad * cycles / swimmer.joint_rate_rad_s)
    blocks = [
        Block(2, stroke.gait, s.with_angles(rounded(s.angle, swimmer.joint_rate_rad_s, step)), n, stroke.amplitude_rad)
        for s, n in parts
        if len(s)
    ]
    return sample(swimmer, start, blocks, dt_s)
