"""The bend limit as inequalities and least steps under them, in numpy: what the kernel's are compared with."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.lift_derivatives import turning_axes
from purcell_cli.mechanics.primitives import PrimitiveSequence


def bend_rows(
    sequence: PrimitiveSequence, shapes: Array, least: Array, fixed: Array, near: float
) -> tuple[Array, Array]:
    """Return the room left below the bend limit where it is small, and its derivative by all angles."""
    return numbered_bend_rows(sequence, shapes, least, fixed, near)[1:]


def numbered_bend_rows(
    sequence: PrimitiveSequence, shapes: Array, least: Array, fixed: Array, near: float
) -> tuple[NDArray[np.int64], Array, Array]:
    """Return on which primitives that room is small, it, and its derivative by all angles."""
    row, limb, axis = np.arange(len(sequence)), sequence.limb, sequence.axis
    begin, place = shapes[row, limb, :, 0], shapes[row + 1, limb, :, 0].copy()
    about = turning_axes(sequence, shapes, row)
    across = np.where(sequence.angle < 0.0, -1.0, 1.0)[:, None] * np.cross(about, begin)
    far = np.remainder(np.arctan2(-across[:, 0], -begin[:, 0]), 2.0 * np.pi)
    passed = (far < sequence.duration) & (axis != 0) & (sequence.control < 6)
    place[passed] = (np.cos(far)[:, None] * begin + np.sin(far)[:, None] * across)[passed]
    room = place[:, 0] - least[row, limb]
    active = np.flatnonzero((room < near) & (axis != 0) & (fixed == 0))
    lever = about[None, :, 1] * place[active, None, 2] - about[None, :, 2] * place[active, None, 1]
    based = sequence.control >= 6
    pitched = ~based & np.isin(limb, limb[based])
    own_y = shapes[active + 1, limb[active], :, 1]
    own = own_y[:, 1] * place[active, 2] - own_y[:, 2] * place[active, 1]
    lever = np.where(pitched, own[:, None], lever)
    acts = (limb[None, :] == limb[active, None]) & (row[None, :] <= (row - passed)[active, None])
    return active, room[active], np.where(acts, lever, 0.0)


def bounded_step(arrival: Array, missing: Array, room: Array, slope: Array, reach: float) -> Array:
    """Return the least step to the arrival under inequalities, by primal-dual active sets."""
    weight = 1.0 / np.sqrt(1.0 + np.linalg.norm(arrival[:6], axis=0))
    rows, wanted = np.concatenate([arrival, slope]) * weight, -np.concatenate([missing, room])
    gram, equal = rows @ rows.T, np.arange(len(wanted)) < len(missing)
    gram[np.diag_indices(len(gram))] += 1e-13 * np.trace(gram) + 1e-30
    active = kept = equal
    least, tried = np.inf, set[bytes]()
    for _ in range(12):
        multipliers = np.zeros(len(wanted))
        multipliers[active] = np.linalg.solve(gram[np.ix_(active, active)], wanted[active])
        excess = np.where(equal, 0.0, wanted - gram @ multipliers)
        broken = excess > 1e-9
        if (worst := float(np.max(excess, initial=0.0))) < least:
            kept, least = active, worst
        if not np.any(broken):
            break
        tried.add(active.tobytes())
        renewed = equal | (multipliers > 0.0) | broken
        active = active | broken if renewed.tobytes() in tried else renewed
    step = weight * np.linalg.lstsq(rows[kept], wanted[kept], rcond=1e-9)[0]
    return np.asarray(step * min(1.0, reach / max(float(np.max(np.abs(step), initial=0.0)), 1e-300)))
