"""Whether joints can play a gait: its strokes turn limbs about axes that some joints have not."""

from __future__ import annotations

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.gaits.gait import Stroke
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.joint_motion import angle_rates, angles_along, excess_of_ranges
from purcell_cli.mechanics.joints import ANGLES, MISFIT_RAD, RANGE_SLACK_RAD
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer

_AXES = ("roll", "pitch", "yaw")
"""What a limb's turns about its own x, y, z are called."""


def refuse_joints(swimmer: Swimmer, stroke: Stroke) -> None:
    """Refuse a stroke that the joints cannot play.

    Args:
        swimmer: The swimmer.
        stroke: The stroke, from the collinear shape.

    Raises:
        ParameterError: It turns a limb about an axis that its joint has not, or leaves a range.
    """
    if swimmer.ball_joints:
        return
    pieces = Pieces.of(stroke.played(1), COLLINEAR)
    rates, stray = angle_rates(swimmer, pieces.shapes, pieces.rates)
    wrong = np.argwhere(stray * pieces.durations[:, None] > MISFIT_RAD)
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
    angles = angles_along(swimmer, COLLINEAR, rates * pieces.durations[:, None, None])
    over = excess_of_ranges(swimmer, angles)
    if np.any(over > RANGE_SLACK_RAD):
        k, limb, angle = np.unravel_index(int(np.argmax(over)), over.shape)
        far, name = np.degrees(over[k, limb, angle]), ANGLES[angle]
        raise ParameterError(
            f"gait {stroke.gait!r}: ranges that it stays in are wanted, found limb {limb + 1}'s {name}, "
            f"{far:.4g} degrees out of its own"
        )
