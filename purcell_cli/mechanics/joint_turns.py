"""Turns of joints, and the rotation vectors of the limbs that they are.

A turn has three components a limb. On a ball joint they are the limb's rotation vector; on a hinge or a universal joint
they are 0, the change of theta and the change of psi. Theta turns a limb about its own y, psi about the base's z, which
in the frame of a limb at theta is (-sin theta, 0, cos theta), constant while theta rests. So a universal joint changes
one angle on a move, and joints of both limbs may turn at once. Conventions: `rotations`.
"""

from __future__ import annotations

import numpy as np

from purcell_cli.geometry.reproducible import cos, sin
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.primitives import AXIS_OF, LIMB_OF, PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer

_PITCH, _YAW = 1, 2
"""Components of a limb's turn: theta and psi."""


def columns(swimmer: Swimmer) -> tuple[int, ...]:
    """Return the components of a turn, of six, that a swimmer's joints have."""
    return tuple(3 * int(LIMB_OF[c]) + int(AXIS_OF[c]) for c in swimmer.controls)


def choices(swimmer: Swimmer) -> list[tuple[int, ...]]:
    """Return which components may change at once: of a universal joint one angle or the other."""
    out: list[tuple[int, ...]] = [()]
    for limb, joint in enumerate(swimmer.joints):
        mine = tuple(c for c in columns(swimmer) if c // 3 == limb)
        parts = [(c,) for c in mine] if joint.kind == "universal" else [mine]
        out = [(*one, *part) for one in out for part in parts]
    return out


def turns_of(sequence: PrimitiveSequence) -> Array:
    """Return primitives as turns of joints [rad]. Shape (n, 6)."""
    out = np.zeros((len(sequence), 6))
    out[np.arange(len(sequence)), 3 * sequence.limb + sequence.axis] = sequence.angle
    return out


def _pitches(swimmer: Swimmer, start: Array, turn: Array) -> list[tuple[int, Array]]:
    """Return the limbs on universal joints and their theta before each move, one cycle of loops [rad]. Shape (n,)."""
    out = []
    for limb, joint in enumerate(swimmer.joints):
        if joint.kind == "universal":
            changes = turn[:, 3 * limb + _PITCH]
            out.append((limb, joint.read(start[limb])[1] + np.cumsum(changes) - changes))
    return out


def frames(swimmer: Swimmer, start: Array, turn: Array) -> Array:
    """Return the directions, in the limbs' frames, about which each component turns them, as columns.

    Args:
        swimmer: The swimmer.
        start: Shape before the first move. Shape (2, 3, 3).
        turn: Turns of joints [rad]. Shape (n, 6).

    Returns:
        Directions. Shape (n, 6, 6).
    """
    out = np.zeros((len(turn), 6, 6))
    out[:, range(6), range(6)] = 1.0
    for limb, pitch in _pitches(swimmer, start, turn):
        out[:, 3 * limb, 3 * limb + _YAW], out[:, 3 * limb + 2, 3 * limb + _YAW] = -sin(pitch), cos(pitch)
    return out


def rotation_vectors(swimmer: Swimmer, start: Array, turn: Array) -> Array:
    """Return turns of joints as rotation vectors in the limbs' frames; see `frames`. Shape (n, 6)."""
    if not has_universal(swimmer):
        return turn
    out = turn.copy()
    for limb, pitch in _pitches(swimmer, start, turn):
        yaw = turn[:, 3 * limb + _YAW]
        out[:, 3 * limb], out[:, 3 * limb + 2] = -sin(pitch) * yaw, cos(pitch) * yaw
    return out


def by_turns(swimmer: Swimmer, start: Array, turn: Array, by_vector: Array) -> Array:
    """Return derivatives by turns of joints from those by rotation vectors. Shape (m, 6 n) to (m, 6 n).

    A change of theta also tilts the direction about which every later change of psi turns the limb.
    """
    if not has_universal(swimmer):
        return by_vector
    given = by_vector.reshape(len(by_vector), len(turn), 2, 3)
    out = given.copy()
    for limb, pitch in _pitches(swimmer, start, turn):
        across, up = given[:, :, limb, 0], given[:, :, limb, 2]
        out[:, :, limb, _YAW] = cos(pitch) * up - sin(pitch) * across
        tilted = -(cos(pitch) * across + sin(pitch) * up) * turn[:, 3 * limb + _YAW]
        out[:, :, limb, _PITCH] += np.cumsum(tilted[:, ::-1], axis=1)[:, ::-1] - tilted
    return out.reshape(by_vector.shape)


def has_universal(swimmer: Swimmer) -> bool:
    """Return whether a limb hangs on a universal joint."""
    return any(joint.kind == "universal" for joint in swimmer.joints)
