"""Motions as blocks of controls, and the trajectory they make, row by row.

A block is a stroke played a number of times. Left invariance makes every repetition the same
displacement, so a block costs one cycle and its powers. Conventions: `rotations`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import inner, matmul
from purcell_cli.geometry.rotations import Array, as_euler, as_quaternion, orthonormalised
from purcell_cli.kernel.flow import played, with_twice_the_digits
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.lift import piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import EMPTY
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block, BlockPieces
from purcell_cli.motion.clock import clock_step
from purcell_cli.motion.memory import too_many_rows
from purcell_cli.motion.trajectory_table import Table


@frozen_dataclass(eq=False)
class Trajectory:
    """A motion sampled in time; the rates of a row hold until the next row's time.

    Attributes:
        time_s: Times, from 0 [s]. Shape (n,).
        phase: Phase of the reconfiguration. Shape (n,).
        gait: Index into `gaits` of the stroke a row belongs to. Shape (n,).
        gaits: Names of the strokes.
        pose: The base's poses in the world [m]. Shape (n, 4, 4).
        shape: Limb orientations. Shape (n, 2, 3, 3).
        rate_rad_s: The six controls; 0 in the last row [rad/s]. Shape (n, 6).
    """

    time_s: Array
    phase: NDArray[np.int64]
    gait: NDArray[np.int64]
    gaits: tuple[str, ...]
    pose: Array
    shape: Array
    rate_rad_s: Array

    def __repr__(self) -> str:
        return f"<Trajectory: {len(self)} rows, {self.time_s[-1]:.6g} s, {', '.join(self.gaits)[:60] or 'no strokes'}>"

    def __post_init__(self) -> None:
        for field in ("time_s", "phase", "gait", "pose", "shape", "rate_rad_s"):
            getattr(self, field).setflags(write=False)

    def __len__(self) -> int:
        return len(self.time_s)

    @property
    def end(self) -> Configuration:
        """The last row's configuration."""
        return Configuration(self.pose[-1], self.shape[-1])

    def until(self, time_s: float) -> Trajectory:
        """Return its rows up to the first at or after a time [s], where the joints then rest."""
        rows = slice(min(int(np.searchsorted(self.time_s, time_s)), len(self) - 1) + 1)
        rates = self.rate_rad_s[rows].copy()
        rates[-1] = 0.0
        time, phase, gait = self.time_s[rows], self.phase[rows], self.gait[rows]
        return Trajectory(time, phase, gait, self.gaits, self.pose[rows], self.shape[rows], rates)

    @property
    def base_quaternion(self) -> Array:
        """The base's quaternions (w, x, y, z), signs continuous along the rows. Shape (n, 4)."""
        return continuous_quaternions(self.pose[:, :3, :3])

    @property
    def limb_quaternion(self) -> Array:
        """The limbs' quaternions (w, x, y, z), signs continuous along the rows. Shape (n, 2, 4)."""
        return np.stack([continuous_quaternions(self.shape[:, i]) for i in (0, 1)], axis=1)

    @property
    def base_euler_rad(self) -> Array:
        """The base's Euler angles (psi, theta, phi) [rad]. Shape (n, 3)."""
        return as_euler(self.pose[:, :3, :3])


def continuous_quaternions(rotation: Array, before: Array | None = None) -> Array:
    """Return the quaternions (w, x, y, z) of rotations, signs continuous along the rows. Shape (n, 4).

    Args:
        rotation: Rotations. Shape (n, 3, 3).
        before: The quaternion before the first; w >= 0 in the first row if there is none. Shape (4,).
    """
    quaternion = as_quaternion(rotation)
    turn = inner(quaternion[1:], quaternion[:-1]) < 0
    first = -1.0 if before is not None and matmul(before, quaternion[0]) < 0.0 else 1.0
    sign = np.concatenate([[first], np.where(turn, -1.0, 1.0)]).cumprod()
    return np.asarray(quaternion * sign[:, None])


@frozen_dataclass(eq=False)
class _Rows:
    """The rows of one cycle of each block.

    Attributes:
        piece: The piece each row is on. Shape (m,).
        since: Time since that piece began, at a joint rate of 1 rad/s [s]. Shape (m,).
        length: Time to the next row, at that rate [s]. Shape (m,).
        time_s: Time since its block began [s]. Shape (m,).
        stops: The row after the last of each block, from 0 on.
        lasts_s: How long a cycle of each block lasts [s]. Shape (k,).
    """

    piece: NDArray[np.int64]
    since: Array
    length: Array
    time_s: Array
    stops: list[int]
    lasts_s: Array

    @classmethod
    def of(cls, pieces: BlockPieces, rate_rad_s: float, dt_s: float, step: float) -> _Rows:
        """Return rows at every switch and at least every dt, on a clock of some step: sums of times are exact."""
        used = np.flatnonzero(pieces.sequence.duration)
        duration, block = pieces.sequence.duration[used] / rate_rad_s, pieces.block[used]
        count = np.maximum(np.ceil(duration / dt_s - 1e-9), 1).astype(np.int64)
        index = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        part = np.round(np.repeat(duration / count, count) * index / step) * step
        rows = np.bincount(np.repeat(block, count), minlength=len(pieces.counts))
        stops = np.cumsum([0, *rows])
        ends = np.concatenate([[0.0], np.cumsum(duration)])
        edges = ends[np.searchsorted(block, np.arange(len(pieces.counts) + 1))]
        time = np.repeat(ends[:-1], count) + part
        length = np.diff(np.append(time, ends[-1])) * rate_rad_s
        time -= np.repeat(edges[:-1], rows)
        return cls(np.repeat(used, count), part * rate_rad_s, length, time, stops.tolist(), np.diff(edges))


def _played(blocks: Sequence[Block], rows: _Rows) -> Iterator[tuple[slice, slice, Array]]:
    """Return of each block its rows in one cycle, its rows in the motion, and when its cycles begin [s]."""
    at, time = 0, 0.0
    for k, block in enumerate(blocks):
        mine = slice(rows.stops[k], rows.stops[k + 1])
        count = block.cycles * (mine.stop - mine.start)
        yield mine, slice(at, at + count), time + np.arange(block.cycles) * rows.lasts_s[k]
        at, time = at + count, time + block.cycles * float(rows.lasts_s[k])


def schedule(swimmer: Swimmer, start: Array, blocks: Sequence[Block]) -> tuple[Array, Array]:
    """Return the times [s] at which the controls of blocks switch, from 0 to the end, and the controls from there on.

    Args:
        swimmer: The swimmer; its joint rate sets the pace.
        start: Shape before the motion. Shape (2, 3, 3).
        blocks: The motion, its durations whole numbers of clock steps (`rounded`).

    Returns:
        Times, shape (n,), and the six controls, 0 in the last row, shape (n, 6) [rad/s].
    """
    pieces = BlockPieces.of(blocks, start)
    rows = _Rows.of(pieces, swimmer.joint_rate_rad_s, math.inf, 1.0)
    rates = pieces.sequence.rates(pieces.shapes[:-1])[rows.piece] * swimmer.joint_rate_rad_s
    times, controls, end = [], [], 0.0
    for k, (mine, _, begins) in enumerate(_played(blocks, rows)):
        times.append((begins[:, None] + rows.time_s[mine]).ravel())
        controls.append(np.tile(rates[mine], (len(begins), 1)))
        end = float(begins[0] + len(begins) * rows.lasts_s[k])
    return np.concatenate([*times, [end]]), np.concatenate([*controls, np.zeros((1, 6))])


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
    rate = swimmer.joint_rate_rad_s
    if (found := too_many_rows(sum(b.duration for b in blocks) / rate, dt_s)) is not None:
        raise found
    pieces = BlockPieces.of(blocks, start.shape)
    rows = _Rows.of(pieces, rate, dt_s, clock_step(sum(b.duration for b in blocks) / rate))
    q = pieces.sequence
    begun = pieces.shapes[rows.piece]
    turned, rates = q.lasting(rows.piece, rows.since).turns(begun), q.rates(pieces.shapes[:-1])[rows.piece]
    shapes = orthonormalised(matmul(begun, turned))
    moves = piece_displacements(swimmer, Pieces(shapes, rates, rows.length))
    count = int(matmul(pieces.cycles, np.diff(rows.stops))) + 1
    time, phase, gait = np.empty(count), np.empty(count, dtype=np.int64), np.empty(count, dtype=np.int64)
    poses, limbs, controls = np.empty((count, 4, 4)), np.empty((count, 2, 3, 3)), np.empty((count, 6))
    names = tuple(dict.fromkeys(b.gait for b in blocks)) or ("none",)
    here, end = with_twice_the_digits(start.pose), 0.0
    for k, (mine, out, begins) in enumerate(_played(blocks, rows)):
        n, cycles = mine.stop - mine.start, len(begins)
        time[out] = (begins[:, None] + rows.time_s[mine]).ravel()
        phase[out], gait[out] = blocks[k].phase, names.index(blocks[k].gait)
        poses[out] = played(here, moves[mine], cycles).reshape(-1, 4, 4)
        limbs[out].reshape(cycles, n, 2, 3, 3)[:] = shapes[mine]
        controls[out].reshape(cycles, n, 6)[:] = rates[mine] * rate
        end = float(begins[0] + cycles * rows.lasts_s[k])
    last = blocks[-1] if blocks else Block(3, "none", EMPTY)
    time[-1], phase[-1], gait[-1] = end, last.phase, names.index(last.gait)
    poses[-1] = np.eye(4)
    poses[-1, :3] = here[..., 0]
    limbs[-1], controls[-1] = pieces.shapes[-1], 0.0
    return Trajectory(time, phase, gait, names, poses, limbs, controls)


def as_table(trajectory: Trajectory) -> Table:
    """Return what the file of a trajectory would say."""
    rotations = [trajectory.pose[:, :3, :3], trajectory.shape[:, 0], trajectory.shape[:, 1]]
    return Table(
        trajectory.time_s,
        trajectory.phase.astype(np.float64),
        np.array(trajectory.gaits)[trajectory.gait],
        trajectory.pose[:, :3, 3],
        trajectory.base_quaternion,
        trajectory.limb_quaternion,
        np.stack([as_euler(r) for r in rotations], axis=1),
        trajectory.rate_rad_s,
    )
