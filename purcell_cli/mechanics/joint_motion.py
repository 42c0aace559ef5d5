"""What joints make of shapes and rates: the shape phases end at, the angles along a path, and what no joint can do."""

from __future__ import annotations

import math

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import arccos, matmul
from purcell_cli.geometry.rotations import Array, about_axis, angle_between, as_vector
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.joints import ANGLES, MISFIT_RAD, RANGE_SLACK_RAD, limb_at
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer

PLANE_SLACK = 5e-10
"""By how much a goal may be out of the plane that hinges keep the base in: half of what plans may miss [L, rad]."""

_NORMALS = {"yaw": 2, "pitch": 1}
"""The base's axis across the plane that two hinges of an axis move it in."""


def home_shape(swimmer: Swimmer, start: Array) -> Array:
    """Return the shape that phases 1 and 2 end at: the collinear one, or the nearest to it that the joints allow.

    Args:
        swimmer: The swimmer.
        start: The shape at the start, which fixed limbs keep. Shape (2, 3, 3).

    Returns:
        The shape. Shape (2, 3, 3).
    """
    if swimmer.ball_joints:
        return COLLINEAR
    out = COLLINEAR.copy()
    for limb, joint in enumerate(swimmer.joints):
        if joint.kind == "fixed":
            out[limb] = start[limb]
        elif not joint.ball and (home := joint.home_rad(swimmer.max_bend_rad)) != (0.0, 0.0):
            out[limb] = limb_at(*home)
    return out


def bend_limits(swimmer: Swimmer, start: Array) -> Array:
    """Return how far each limb may bend in phase 2: the swimmer's limit, or as far as it must [rad]. Shape (2,)."""
    limit = np.full(2, swimmer.max_bend_rad)
    if not swimmer.ball_joints:
        limit = np.maximum(limit, arccos(np.clip(home_shape(swimmer, start)[:, 0, 0], -1.0, 1.0)))
    return limit


def plane_axis(swimmer: Swimmer) -> str | None:
    """Return the axis of the hinges of a swimmer that stays in a plane, "yaw" or "pitch"; None for others."""
    first, second = swimmer.joints
    return first.axis if first.kind == second.kind == "hinge" and first.axis == second.axis else None


def in_plane(axis: str) -> tuple[int, ...]:
    """Return which components of a twist hinges of an axis can make."""
    return (0, 1, 5) if axis == "yaw" else (0, 2, 4)


def flattened(swimmer: Swimmer, displacement: Array) -> Array:
    """Return a displacement without what two parallel hinges cannot make of it, rounding errors and the like.

    Args:
        swimmer: The swimmer.
        displacement: The displacement, which `refuse_displacement` lets pass. Shape (4, 4).
    """
    axis = plane_axis(swimmer)
    if axis is None:
        return displacement
    k, out = _NORMALS[axis], displacement.copy()
    angle = float(as_vector(displacement[:3, :3])[k])
    out[:3, :3] = about_axis(k, angle)
    out[k, 3] = 0.0
    return out


def angle_rates(swimmer: Swimmer, shapes: Array, rates: Array) -> tuple[Array, Array]:
    """Return how fast psi and theta of both limbs change, and the rest of the rates, which no such joint makes.

    On a ball joint nothing is left, and its angles are none of this.

    Args:
        swimmer: The swimmer.
        shapes: Shapes. Shape (n, 2, 3, 3).
        rates: Limb rates in the limbs' frames [rad/s]. Shape (n, 6).

    Returns:
        Rates of (psi, theta), (n, 2, 2), and the size of the rest, (n, 2) [rad/s].
    """
    about = rates.reshape(-1, 2, 3)
    out, rest = np.zeros((len(about), 2, 2)), np.zeros((len(about), 2))
    for limb, joint in enumerate(swimmer.joints):
        if joint.ball:
            continue
        w, up = about[:, limb], shapes[:, limb, 2]
        left = w.copy()
        if "psi" in joint.angles:
            out[:, limb, 0] = np.sum(w * up, axis=1)
            left -= out[:, limb, 0, None] * up
        if "theta" in joint.angles:
            out[:, limb, 1] = left[:, 1]
            left[:, 1] = 0.0
        rest[:, limb] = np.sqrt(np.sum(left * left, axis=1))
    return out, rest


def angle_changes(swimmer: Swimmer, pieces: Pieces) -> tuple[Array, Array]:
    """Return by how much psi and theta change on pieces, and how far limbs turn otherwise, as no such joint lets them.

    A limb may turn about an axis that its joint has where a piece begins, and no longer where it ends: turned about
    both at once, the axes of a universal joint move.

    Args:
        swimmer: The swimmer.
        pieces: The pieces.

    Returns:
        Changes of (psi, theta), (n, 2, 2), and the rest, (n, 2) [rad].
    """
    lasting = pieces.durations[:, None, None]
    rates, begun = angle_rates(swimmer, pieces.shapes, pieces.rates)
    ends = matmul(pieces.shapes, se3.rotation(pieces.rates.reshape(-1, 2, 3) * lasting))
    _, ended = angle_rates(swimmer, ends, pieces.rates)
    return rates * lasting, np.maximum(begun, ended) * pieces.durations[:, None]


def joint_rates(swimmer: Swimmer, shapes: Array, rates: Array) -> Array:
    """Return how fast joints turn: a ball joint about its limb's axes, others by (psi, theta) and 0.

    Args:
        swimmer: The swimmer.
        shapes: Shapes. Shape (n, 2, 3, 3).
        rates: Limb rates in the limbs' frames [rad/s]. Shape (n, 6).

    Returns:
        Rates [rad/s]. Shape (n, 6).
    """
    if swimmer.ball_joints:
        return rates
    out, of_angles = rates.copy(), angle_rates(swimmer, shapes, rates)[0]
    for limb, joint in enumerate(swimmer.joints):
        if not joint.ball:
            out[:, 3 * limb : 3 * limb + 2] = of_angles[:, limb]
            out[:, 3 * limb + 2] = 0.0
    return out


def angles_along(swimmer: Swimmer, start: Array, changes: Array) -> Array:
    """Return psi and theta of both limbs along a path, nan for limbs on ball joints and fixed ones.

    Args:
        swimmer: The swimmer.
        start: Shape at the beginning. Shape (2, 3, 3).
        changes: What each piece adds to them [rad]. Shape (n, 2, 2).

    Returns:
        Angles before, between and after the pieces [rad]. Shape (n + 1, 2, 2).
    """
    out = np.full((len(changes) + 1, 2, 2), math.nan)
    for limb, joint in enumerate(swimmer.joints):
        if joint.angles:
            begun = np.array([joint.read(start[limb])])
            out[:, limb] = np.cumsum(np.concatenate([begun, changes[:, limb]]), axis=0)
    return out


def excess_of_ranges(swimmer: Swimmer, angles: Array) -> Array:
    """Return by how much angles are out of their ranges, 0 where they are not [rad]. Shape (n, 2, 2)."""
    out = np.zeros(angles.shape)
    for limb, joint in enumerate(swimmer.joints):
        for k, name in enumerate(ANGLES):
            if name in joint.angles and joint.range_deg(name) is not None:
                low, high = joint.range_rad(name)
                out[:, limb, k] = np.maximum(np.maximum(low - angles[:, limb, k], angles[:, limb, k] - high), 0.0)
    return out


def refuse_shape(swimmer: Swimmer, name: str, configuration: Configuration) -> None:
    """Refuse a shape that the joints cannot make.

    Args:
        swimmer: The swimmer.
        name: What the configuration is, for the message.
        configuration: The configuration.

    Raises:
        ParameterError: A limb turned about an axis that its joint has not, or an angle out of its range.
    """
    for limb, joint in enumerate(swimmer.joints):
        wrong, off = joint.misfit(configuration.shape[limb])
        if abs(off) > MISFIT_RAD:
            wanted = f"a {wrong} of 0, since its joint is a {joint.name},"
            raise ParameterError(f"{name}: limb {limb + 1}: {wanted} is wanted, found {math.degrees(off):.6g} degrees")
        for angle, value in zip(ANGLES, joint.read(configuration.shape[limb]), strict=True):
            beyond = joint.beyond(angle, value) if angle in joint.angles else 0.0
            if beyond > RANGE_SLACK_RAD:
                low, high = joint.range_deg(angle) or (0.0, 0.0)
                found = f"{math.degrees(value):.6g} degrees, {math.degrees(beyond):.6g} degrees out of its range"
                raise ParameterError(
                    f"{name}: limb {limb + 1}: a {angle} from {low:g} to {high:g} degrees is wanted, found {found}"
                )


def refuse_displacement(swimmer: Swimmer, start: Configuration, goal: Configuration, called: str = "goal") -> None:
    """Refuse a goal that the joints cannot reach from a start, whatever they do.

    Args:
        swimmer: The swimmer.
        start: The start.
        goal: The goal.
        called: What the goal is called.

    Raises:
        ParameterError: A fixed limb that is to turn, or a base that is to leave the plane of two parallel hinges.
    """
    for limb, joint in enumerate(swimmer.joints):
        turned = float(angle_between(start.shape[limb], goal.shape[limb]))
        if joint.kind == "fixed" and turned > MISFIT_RAD:
            raise ParameterError(
                f"{called}: limb {limb + 1}: the start's orientation, since its joint is fixed, is wanted, "
                f"found one {math.degrees(turned):.6g} degrees from it"
            )
    axis = plane_axis(swimmer)
    if axis is None:
        return
    k = _NORMALS[axis]
    wanted = matmul(se3.inverse(start.pose), goal.pose)
    away, tilt = float(wanted[k, 3]), as_vector(wanted[:3, :3])
    others = [(("roll", "pitch", "yaw")[j], float(tilt[j])) for j in range(3) if j != k]
    plane = "the start's x-y plane" if axis == "yaw" else "the start's x-z plane"
    found = [f"{'xyz'[k]} off by {away:.6g} m"] if abs(away) > PLANE_SLACK * swimmer.length_m else []
    found += [f"{what} off by {math.degrees(off):.6g} degrees" for what, off in others if abs(off) > PLANE_SLACK]
    if found:
        raise ParameterError(
            f"{called}: base: a pose in {plane}, since both limbs hang on {axis} hinges, is wanted, "
            f"found its {' and its '.join(found)}"
        )
