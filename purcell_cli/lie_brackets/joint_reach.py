"""Whether joints can move the base in every direction, and well enough for a plan to be of use."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.geometry.rotations import Array
from purcell_cli.lie_brackets.controllability import DIRECTIONS, controllability
from purcell_cli.mechanics.joints import ANGLES, limb_at, named
from purcell_cli.mechanics.swimmer import Swimmer

_HOPELESS = 1e-3
"""A direction whose brackets are below this is out of reach of any plan [L, rad per rad^depth].

A yaw and a pitch hinge have 0.025 and plans of hundreds of rad; one universal joint alone has 1e-4, and 0.1 L would
take thousands of rad."""
_HOPELESS_BALL = 0.03
"""The same for a ball joint beside a fixed limb, whose loops a roll must close [L, rad per rad^depth].

Beside a limb at 30 degrees it has 0.065 or more and 0.1 L takes 1,000 rad; at 15 degrees the paper's swimmer has 0.015
to 0.027, and no plan was found."""
_DEPTHS = {1: 6, 2: 6, 3: 5, 4: 4, 5: 3, 6: 3}
"""The deepest brackets that are looked at, by the number of controls."""
_USUAL_DEPTH = 4
"""The deepest brackets of ball joints, which reach all at 3: one more shows how weak they are."""
_BENT_RAD = ((0.6, 0.4), (0.4, -0.6), (-0.6, 0.4), (0.4, 0.6))
"""The psi and theta of the shapes looked at until nothing is weak: without symmetry, but beside a limb that is fixed to
some side, brackets may vanish at one of them by chance [rad]."""
_SHARE = 0.05
"""A direction with more than this share in what is weak is named."""


def usual_depth(swimmer: Swimmer) -> int:
    """Return the depth of brackets that shows what a swimmer's joints reach: the fewer turn, the deeper it is."""
    if swimmer.ball_joints:
        return _USUAL_DEPTH
    return max(_USUAL_DEPTH, _DEPTHS.get(len(swimmer.controls), _USUAL_DEPTH))


@functools.lru_cache(maxsize=64)
def weak_directions(swimmer: Swimmer, fixed: bytes) -> tuple[str, ...]:
    """Return the directions in which joints do not move the base, or hardly; none where all is well.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        fixed: The limbs' orientations that fixed limbs keep, as bytes of an array of shape (2, 3, 3).
    """
    if not swimmer.controls:
        return DIRECTIONS
    shape = np.frombuffer(fixed).reshape(2, 3, 3)
    least: tuple[str, ...] = DIRECTIONS
    for bent in _BENT_RAD:
        weak = _weak_at(swimmer, shape, bent)
        if len(weak) < len(least):
            least = weak
        if not least:
            break
    return least


def _weak_at(swimmer: Swimmer, fixed: Array, bent: tuple[float, float]) -> tuple[str, ...]:
    """Return the directions in which joints hardly move the base where those that turn are at a psi and theta [rad]."""
    shape = fixed.copy()
    for limb, joint in enumerate(swimmer.joints):
        if joint.kind != "fixed":
            given = zip(ANGLES, bent, strict=True)
            psi, theta = [angle if joint.ball or name in joint.angles else 0.0 for name, angle in given]
            shape[limb] = limb_at(psi, theta)
    found = controllability(_unlimited(swimmer), shape, _DEPTHS[len(swimmer.controls)])
    rows = np.array(found.rows)
    twists = np.array([b.twist for b in found.brackets] or np.zeros((1, 6)))[:, rows]
    padded = np.concatenate([twists, np.zeros((len(rows), len(rows)))])
    _, values, directions = np.linalg.svd(padded, full_matrices=False)
    alone = {joint.kind for joint in swimmer.joints} == {"ball", "fixed"}
    weak = directions[values < (_HOPELESS_BALL if alone else _HOPELESS)]
    shares = np.sum(weak**2, axis=0)
    return tuple(DIRECTIONS[row] for row, share in zip(rows, shares, strict=True) if share > _SHARE)


def _unlimited(swimmer: Swimmer) -> Swimmer:
    """Return the swimmer without its joints' ranges, each link alone in the fluid."""
    first, second = (dataclasses.replace(j, psi_deg=None, theta_deg=None) for j in swimmer.joints)
    return dataclasses.replace(swimmer, joints=(first, second), fluid="local")


def refuse_weak_joints(swimmer: Swimmer, start: Array) -> None:
    """Refuse joints that cannot move the base in every direction, or only hopelessly slowly.

    Args:
        swimmer: The swimmer.
        start: The shape at the start. Shape (2, 3, 3).

    Raises:
        ParameterError: There is a direction that they do not move it in.
    """
    if swimmer.ball_joints:
        return
    weak = weak_directions(swimmer.scaled(), np.ascontiguousarray(start, dtype=np.float64).tobytes())
    if weak:
        joints = named(swimmer.joints)
        raise ParameterError(
            "swimmer: joints that can move the base in every direction are wanted, "
            f"found {joints}, which do not move it, or hardly, in: {', '.join(weak)}"
        )
