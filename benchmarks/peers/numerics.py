"""The flow of primitives (`purcell_cli.mechanics.lift`) against scipy's DOP853, at equal accuracy.

Both get the same pieces of constant control, all at once: DOP853 solves them as one system of 12 equations each, which
serves it far better than one after the other, with the turning of the limbs in closed form. The reference is the
certificate's extrapolation (`purcell_cli.verification.replay`).
Of DOP853's tolerances the loosest is shown whose error is no larger than the flow's, or the most exact one.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np
from scipy.integrate import solve_ivp

from purcell_cli import Configuration, Swimmer
from purcell_cli.geometry.rotations import about_axis
from purcell_cli.mechanics.connection import COLLINEAR, base_twist_rows
from purcell_cli.mechanics.lift import EXACT, SEARCHING, piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.verification.replay import replay

TOLERANCES = 10.0 ** -np.arange(3.0, 14.0)
REFERENCE_ERROR = 1e-12
REPEATS = 7


def dop853(swimmer: Swimmer, shapes: np.ndarray, rates: np.ndarray, seconds: np.ndarray, rtol: float) -> np.ndarray:
    """Return the base's displacements on pieces of constant control (n, 4, 4), for a swimmer with L = 1."""
    n = len(seconds)
    spin = np.einsum("nlij,nlj->lin", shapes, rates.reshape(n, 2, 3))
    axis = np.ascontiguousarray(shapes[..., 0].transpose(1, 2, 0))
    speed = np.linalg.norm(spin, axis=1, keepdims=True)
    about = spin / np.where(speed > 0.0, speed, 1.0)
    across, along = np.cross(about, axis, axis=1), about * np.sum(about * axis, axis=1, keepdims=True)

    def motion(part: float, state: np.ndarray) -> np.ndarray:
        angle = speed * (part * seconds)
        limbs = along + np.cos(angle) * (axis - along) + np.sin(angle) * across
        xi = base_twist_rows(swimmer, limbs, spin) * seconds
        rotation, out = state.reshape(4, 3, n)[:3], np.empty((4, 3, n))  # columns of the rotation, then the position
        for i in range(3):
            j, k = (i + 1) % 3, (i + 2) % 3
            out[i] = xi[3 + k] * rotation[j] - xi[3 + j] * rotation[k]
        out[3] = xi[0] * rotation[0] + xi[1] * rotation[1] + xi[2] * rotation[2]
        return out.ravel()

    rest = np.zeros((4, 3, n))
    for i in range(3):
        rest[i, i] = 1.0
    solved = solve_ivp(motion, (0.0, 1.0), rest.ravel(), method="DOP853", rtol=rtol, atol=0.1 * rtol)
    out = np.tile(np.eye(4), (n, 1, 1))
    out[:, :3] = solved.y[:, -1].reshape(4, 3, n).transpose(2, 1, 0)
    return out


def cases() -> dict[str, tuple[np.ndarray, PrimitiveSequence]]:
    """Return what is integrated: a start shape and a sequence for each name."""
    rng = np.random.default_rng(0)
    beside, stroke = (
        COLLINEAR.copy(),
        [("limb1 yaw", 1.0), ("limb2 yaw", 1.0), ("limb1 yaw", -1.0), ("limb2 yaw", -1.0)],
    )
    beside[0] = about_axis(1, 0.05) @ about_axis(2, -0.5)
    many = PrimitiveSequence(rng.integers(0, 6, 200), rng.uniform(-1.0, 1.0, 200))
    return {
        "1 rad of yaw, 0.05 rad beside the straight line": (beside, PrimitiveSequence.of(stroke[:1])),
        "one rectangle of four primitives, from the straight line": (COLLINEAR, PrimitiveSequence.of(stroke)),
        "200 random primitives of up to 1 rad": (COLLINEAR, many),
    }


def timed(work: Callable[..., np.ndarray], *given: object) -> tuple[np.ndarray, float]:
    """Return a result and the shortest time it took [s]."""
    out, times = work(*given), []
    for _ in range(REPEATS):
        began = time.perf_counter()
        work(*given)
        times.append(time.perf_counter() - began)
    return out, min(times)


def rows() -> list[list[str]]:
    """Return the table: case, accuracy of the flow, its error and time, DOP853's tolerance, error and time, ratio."""
    swimmer, out = Swimmer().scaled(), []
    for name, (start, sequence) in cases().items():
        pieces = (sequence.shapes(start)[:-1], sequence.rates(), sequence.duration)
        exact = reference(swimmer, pieces)
        peers = [(rtol, *timed(dop853, swimmer, *pieces, rtol)) for rtol in TOLERANCES]
        errors = [float(np.max(np.abs(found - exact))) for _, found, _ in peers]
        for label, accuracy in (("searching", SEARCHING), ("exact", EXACT)):
            found, took = timed(piece_displacements, swimmer, Pieces(*pieces), accuracy)
            error = float(np.max(np.abs(found - exact)))
            enough = [k for k, e in enumerate(errors) if e <= max(error, REFERENCE_ERROR)]
            k = min(enough, key=lambda k: peers[k][2]) if enough else int(np.argmin(errors))
            rtol, _, peer_took = peers[k]
            ours = [name, label, told(error), f"{1e3 * took:.2f}"]
            out.append([*ours, f"{rtol:.0e}", told(errors[k]), f"{1e3 * peer_took:.2f}", f"{peer_took / took:.1f}"])
    return out


def reference(swimmer: Swimmer, pieces: tuple[np.ndarray, ...]) -> np.ndarray:
    """Return displacements on pieces by the certificate's replay, one piece after the other (n, 4, 4)."""
    ends = []
    for shape, rate, seconds in zip(*pieces, strict=True):
        start = Configuration(np.eye(4), shape)
        found = replay(swimmer, start, np.array([0.0, seconds]), np.stack([rate, np.zeros(6)]))
        ends.append(found.pose[-1])
    return np.stack(ends)


def told(error: float) -> str:
    """Return an error as text; below the reference's own it says only that."""
    return f"{error:.0e}" if error > REFERENCE_ERROR else f"< {REFERENCE_ERROR:.0e}"
