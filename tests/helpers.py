"""What the tests share: a strict comparison, convergence slopes, random swimmers and an independent integrator."""

from __future__ import annotations

import csv
import functools
import math
import sys
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from types import FrameType
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from random_swimmers import of_its_own
from scipy.integrate import solve_ivp

from purcell_cli.cli.app import _run
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, about_axis, from_quaternion, hat
from purcell_cli.mechanics.connection import COLLINEAR, connection, resistance_and_coupling
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block, block_displacements
from purcell_cli.motion.clearance import limb_distance
from purcell_cli.motion.limb_circles import LimbCircles

Run = Callable[..., tuple[int, str, str]]
"""Runs a command in this process: exit code, stdout, stderr."""

DATA = Path(__file__).parent / "data"

UNIT = Swimmer(base_half_length_m=1.0, limb_half_length_m=1.0)
"""The paper's swimmer with L = 1 m, so that metres are units of L."""

ROLL_1, PITCH_1, YAW_1, ROLL_2, PITCH_2, YAW_2 = range(6)


def runner(capsys: pytest.CaptureFixture[str], *first: str) -> Run:
    """Return a function that runs a command in this process, in the working folder, its first arguments given."""

    def command(*arguments: str) -> tuple[int, str, str]:
        capsys.readouterr()
        code = _run([*first, *arguments])
        shown = capsys.readouterr()
        return code, shown.out, shown.err

    return command


def resistance(swimmer: Swimmer, shape: ArrayLike) -> Array:
    """Return P (section III-C) [N s/m, N s, N s m]. Shape (..., 6, 6)."""
    return resistance_and_coupling(swimmer, shape)[0]


def assert_close(found: ArrayLike, wanted: ArrayLike, tolerance: float, scale: float = 1.0) -> None:
    """Assert that two arrays agree to tolerance * scale everywhere; refuse NaN, infinity and broadcasting."""
    a, b = np.asarray(found, dtype=np.float64), np.asarray(wanted, dtype=np.float64)
    assert a.shape == b.shape, f"shapes differ: found {a.shape}, wanted {b.shape}"
    assert np.all(np.isfinite(a)), "found a number that is not finite"
    assert np.all(np.isfinite(b)), "wanted a number that is not finite"
    assert math.isfinite(tolerance * scale)
    worst = float(np.max(np.abs(a - b), initial=0.0))
    assert worst <= tolerance * scale, f"off by {worst:.3g}, wanted at most {tolerance * scale:.3g}"


def is_close(found: ArrayLike, wanted: ArrayLike, tolerance: float, scale: float = 1.0) -> bool:
    """Return whether `assert_close` would pass; for foils, which must differ in value and not in shape."""
    assert np.shape(found) == np.shape(wanted)
    assert np.all(np.isfinite(np.asarray(found, dtype=np.float64)))
    return bool(np.max(np.abs(np.subtract(found, wanted)), initial=0.0) <= tolerance * scale)


def slope(sizes: ArrayLike, errors: ArrayLike) -> float:
    """Return the slope of a straight line through (log size, log error): the order of convergence."""
    return float(np.polyfit(np.log(sizes), np.log(errors), 1)[0])


def read_table(name: str) -> list[dict[str, str]]:
    """Return the rows of a reference table; lines that begin with # name its source."""
    with (DATA / name).open(newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def random_rotations(rng: np.random.Generator, *count: int) -> Array:
    """Return uniformly distributed rotations. Shape (*count, 3, 3)."""
    q = rng.normal(size=(*count, 4))
    return from_quaternion(q / np.linalg.norm(q, axis=-1, keepdims=True))


def random_shapes(rng: np.random.Generator, *count: int) -> Array:
    """Return uniformly distributed shapes. Shape (*count, 2, 3, 3)."""
    return random_rotations(rng, *count, 2)


def random_swimmer(rng: np.random.Generator) -> Swimmer:
    """Return a swimmer with limbs 0.3 to 3 times as long as the base and slenderness 0.002 to 0.05."""
    base = math.exp(rng.uniform(-2.0, 2.0))
    return Swimmer(
        base_half_length_m=base,
        limb_half_length_m=base * math.exp(rng.uniform(math.log(0.3), math.log(3.0))),
        slenderness=math.exp(rng.uniform(math.log(0.002), math.log(0.05))),
        viscosity_pa_s=math.exp(rng.uniform(-3.0, 3.0)),
        drag_ratio=rng.uniform(1.3, 2.5),
    )


def unequal_swimmer(rng: np.random.Generator) -> Swimmer:
    """Return a random swimmer with limbs of their own sizes, a law of drag or numbers, and maybe a body."""
    return of_its_own(rng, random_swimmer(rng))


def random_sequence(rng: np.random.Generator, count: int, largest: float = 1.0) -> PrimitiveSequence:
    """Return a sequence of random controls with angles up to `largest` [rad]."""
    return PrimitiveSequence(rng.integers(0, 6, count), rng.uniform(-largest, largest, count))


def bent(pitch: float, yaw: float, limb: int = 1) -> Array:
    """Return the shape with one limb pitched, then yawed about its own axis. Shape (2, 3, 3)."""
    shape = COLLINEAR.copy()
    shape[limb - 1] = about_axis(1, pitch) @ about_axis(2, yaw)
    return shape


def in_lengths(swimmer: Swimmer, pose: Array) -> Array:
    """Return poses with positions in units of L."""
    out = pose.copy()
    out[..., :3, 3] /= swimmer.length_m
    return out


def missed(wanted: Array, found: Array) -> float:
    """Return the largest component of the twist between displacements [L, rad]. Shapes (..., 4, 4)."""
    return float(np.max(np.abs(se3.log(se3.normalised(se3.inverse(wanted) @ found)))))


def flown(swimmer: Swimmer, blocks: Sequence[Block], start: Array = COLLINEAR) -> Array:
    """Return what strokes do on the exact flow, from a shape. Shape (4, 4)."""
    return functools.reduce(np.matmul, block_displacements(swimmer, blocks, start), np.eye(4))


def largest_bends(sequence: PrimitiveSequence, start: Array = COLLINEAR) -> Array:
    """Return the largest bend of each limb on a way [rad]. Shape (2,)."""
    sweeps = LimbCircles.of(Pieces.of(sequence, start))
    return np.asarray(sweeps.largest_bends()[0].max(axis=0))


def nearest(swimmer: Swimmer, sequence: PrimitiveSequence, start: Array) -> float:
    """Return how near the limbs come on a way, by samples every 0.02 rad and so a little too far [m]."""
    parts = np.maximum(np.ceil(sequence.duration / 0.02), 1.0).astype(np.int64)
    fine = PrimitiveSequence(np.repeat(sequence.control, parts), np.repeat(sequence.angle / parts, parts))
    return float(np.min(limb_distance(swimmer, fine.shapes(start)[..., 0])))


NIGHTLY = [pytest.mark.slow, pytest.mark.nightly]
"""The marks of a sample more, which no run has that does not ask for it."""


def mostly_slow(values: Iterable[Any], quick: int, most: int | None = None) -> list[Any]:
    """Return parameters of a test: the first few plain, then slow ones, and those after the first `most` nightly."""
    out = []
    for k, v in enumerate(values):
        more = most is not None and k >= most
        out.append(pytest.param(v, marks=NIGHTLY if more else [pytest.mark.slow] if k >= quick else []))
    return out


def calls(action: Callable[[], object]) -> int:
    """Return how many Python functions an action calls: its work, whatever else the machine does."""
    count = 0

    def counted(_frame: FrameType, event: str, _argument: object) -> None:
        nonlocal count
        count += event == "call"

    before = sys.getprofile()
    sys.setprofile(counted)
    try:
        action()
    finally:
        sys.setprofile(before)
    return count


def assert_slope(rows: Callable[[Array], tuple[Array, Array]], at: Array, tolerance: float, step: float = 1e-6) -> None:
    """Assert that rows have the derivative they say, by central differences.

    Args:
        rows: Returns values, shape (m,), and derivatives, shape (m, n).
        at: Where. Shape (n,).
        tolerance: Of each derivative.
        step: Of the differences.
    """
    differences = [(rows(at + d)[0] - rows(at - d)[0]) / (2.0 * step) for d in step * np.eye(len(at))]
    assert_close(rows(at)[1], np.transpose(differences), tolerance)


def dop853_rates(
    swimmer: Swimmer, rate: ArrayLike, duration: ArrayLike, start: ArrayLike, pose: ArrayLike | None = None
) -> Array:
    """Return the pose after pieces of constant rates, by DOP853 on the plain equations of motion.

    State: base rotation and position in the world, and both limbs' orientations, all integrated. It shares only
    `connection` (itself tested against tables) with `lift`. Positions are integrated in units of L.
    """
    size = swimmer.length_m
    first = np.eye(4) if pose is None else np.asarray(pose, dtype=np.float64)
    y = np.concatenate([first[:3, :3].ravel(), first[:3, 3] / size, np.asarray(start, dtype=np.float64).ravel()])
    for omega, seconds in zip(np.reshape(rate, (-1, 6)), np.reshape(duration, -1), strict=True):
        spin = hat(omega.reshape(2, 3))

        def motion(_: float, state: Array, omega: Array = omega, spin: Array = spin) -> Array:
            rotation, shape = state[:9].reshape(3, 3), state[12:].reshape(2, 3, 3)
            xi = -connection(swimmer, shape) @ omega
            return np.concatenate([(rotation @ hat(xi[3:])).ravel(), rotation @ xi[:3] / size, (shape @ spin).ravel()])

        solved = solve_ivp(motion, (0.0, float(seconds)), y, method="DOP853", rtol=1e-13, atol=1e-14)
        assert solved.success, solved.message
        y = solved.y[:, -1]
    out = np.eye(4)
    out[:3, :3] = y[:9].reshape(3, 3)
    out[:3, 3] = y[9:12] * size
    return out


def dop853_flow(
    swimmer: Swimmer, sequence: PrimitiveSequence, start: ArrayLike = COLLINEAR, pose: ArrayLike | None = None
) -> Array:
    """Return the pose after a sequence of primitives, by `dop853_rates`."""
    return dop853_rates(swimmer, sequence.rates(), np.abs(sequence.angle), start, pose)
