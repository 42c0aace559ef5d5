"""Whether a swimmer can play a gait, or one that is to be designed.

Strokes turn limbs about axes that some joints have not, and bend them further than links that feel each other do.
"""

from __future__ import annotations

import numpy as np

from purcell_cli.errors import GaitError, ParameterError
from purcell_cli.gaits.gait import Stroke
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.fluid import refuse_far_bends
from purcell_cli.mechanics.joint_motion import angle_changes, angles_along, excess_of_ranges
from purcell_cli.mechanics.joints import ANGLES, MISFIT_RAD, RANGE_SLACK_RAD, named
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import LimbCircles

_AXES = ("roll", "pitch", "yaw")
"""What a limb's turns about its own x, y, z are called."""


def refuse_joints(swimmer: Swimmer, stroke: Stroke, cycles: int = 1) -> None:
    """Refuse a stroke that the joints cannot play.

    Args:
        swimmer: The swimmer.
        stroke: The stroke, from the collinear shape.
        cycles: How often it is played.

    Raises:
        ParameterError: It turns a limb about an axis that its joint has not, or leaves a range.
    """
    if swimmer.ball_joints:
        return
    pieces = Pieces.of(stroke.without_repeats(cycles), COLLINEAR)
    changes, turned = angle_changes(swimmer, pieces)
    wrong = np.argwhere(turned > MISFIT_RAD)
    if len(wrong):
        k, limb = wrong[0]
        joint = swimmer.joints[limb]
        lacking = [0 if name == joint.axis else 1 for name in _AXES]
        axis = _AXES[int(np.argmax(lacking * np.abs(pieces.rates[k].reshape(2, 3)[limb])))]
        bent = " while it is bent the other way" if joint.kind == "universal" and axis != "roll" else ""
        raise ParameterError(
            f"gait {stroke.gait!r}: joints that can play it are wanted, found limb {limb + 1} on a {joint.name}, "
            f"which does not {axis}{bent}"
        )
    angles = angles_along(swimmer, COLLINEAR, changes)
    over = excess_of_ranges(swimmer, angles)
    if np.any(over > RANGE_SLACK_RAD):
        k, limb, angle = np.unravel_index(int(np.argmax(over)), over.shape)
        far, name = np.degrees(over[k, limb, angle]), ANGLES[angle]
        raise ParameterError(
            f"gait {stroke.gait!r}: ranges that it stays in are wanted, found limb {limb + 1}'s {name}, "
            f"{far:.4g} degrees out of its own"
        )


def refuse_far_stroke(swimmer: Swimmer, stroke: Stroke, cycles: int = 1) -> None:
    """Refuse a stroke that bends a limb further than links that feel each other do.

    Args:
        swimmer: The swimmer.
        stroke: The stroke, from the collinear shape.
        cycles: How often it is played.

    Raises:
        GaitError: A limb is bent too far.
    """
    if swimmer.fluid != "beads":
        return
    circles = LimbCircles.of(Pieces.of(stroke.without_repeats(cycles), COLLINEAR))
    try:
        refuse_far_bends(float(np.max(circles.largest_bends()[0], initial=0.0)))
    except ParameterError as error:
        raise GaitError(f"gait {stroke.gait!r}: {error}") from error


def bend_room_rad(swimmer: Swimmer, axis: int | None) -> float:
    """Return how far both limbs bend to both sides in a plane, infinite where there are no ranges [rad].

    Args:
        swimmer: The swimmer.
        axis: The limbs' own axis that a stroke in a plane turns them about, 1 for pitch and 2 for yaw; None in space.

    Raises:
        ParameterError: Joints that have not this axis, or a range that leaves nothing to one side of collinear.
    """
    if swimmer.ball_joints:
        return np.inf
    if axis is None:
        wanted = "ball joints, since strokes in space turn limbs about all axes,"
        raise ParameterError(f"swimmer: {wanted} are wanted, found {named(swimmer.joints)}; design a planar stroke")
    room, angle = np.inf, ANGLES[2 - axis]
    for limb, joint in enumerate(swimmer.joints, 1):
        if not joint.ball and angle not in joint.angles:
            wanted = f"joints that {_AXES[axis]}, as strokes this way do,"
            raise ParameterError(f"swimmer: {wanted} are wanted, found limb {limb} on a {joint.name}")
        low, high = joint.range_rad(angle)
        if not low < 0.0 < high:
            wanted = f"a range of limb {limb}'s {angle} to both sides of 0, where strokes begin,"
            raise ParameterError(f"swimmer: {wanted} is wanted, found {list(joint.range_deg(angle) or ())} degrees")
        room = min(room, -low, high)
    return room


def refuse_bends(swimmer: Swimmer, axis: int | None, max_bend_rad: float) -> None:
    """Refuse to design a stroke that the swimmer could not play.

    Args:
        swimmer: The swimmer.
        axis: See `bend_room_rad`.
        max_bend_rad: How far the stroke may bend limbs [rad].

    Raises:
        ParameterError: The joints have not the axis or the room, or links that feel each other do not bend so far.
    """
    if swimmer.fluid == "beads":
        refuse_far_bends(max_bend_rad, "max_bend")
    room = bend_room_rad(swimmer, axis)
    if max_bend_rad > room + RANGE_SLACK_RAD:
        wanted = f"at most {room:.6g} rad, the room in the joints' ranges,"
        raise ParameterError(f"max_bend: {wanted} is wanted, found {max_bend_rad!r}")
