"""What a trajectory's controls ask of the joints, row by row: their axes, ranges, rates and accelerations."""

from __future__ import annotations

import math

import numpy as np

from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.joint_motion import angle_changes, angles_along, excess_of_ranges, joint_rates
from purcell_cli.mechanics.joints import ANGLES
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.verification.time_law import TimeLaw

_STRAY_RAD = 1e-9
"""A row may turn a limb by less than this about an axis that its joint has not, and leave a range by less [rad]."""
RATE_SLACK = 1e-9
"""By which part of itself a joint's rate may be exceeded: above the rounding of a rate that is written and read,
and below what anybody would call faster."""


def too_fast(swimmer: Swimmer, shapes: Array, rates: Array) -> tuple[int, float, float] | None:
    """Return the first row at which a joint turns too fast, its rate, and the most that it may be [rad/s].

    Args:
        swimmer: The swimmer.
        shapes: The rows' shapes. Shape (n, 2, 3, 3).
        rates: Their controls [rad/s]. Shape (n, 6).
    """
    most = np.array([swimmer.rate_of(0), swimmer.rate_of(1)])
    found = np.max(np.abs(joint_rates(swimmer, shapes, rates)).reshape(-1, 2, 3), axis=2)
    over = found > most * (1.0 + RATE_SLACK)
    if not np.any(over):
        return None
    n, limb = np.argwhere(over)[0]
    return int(n), float(found[n, limb]), float(most[limb])


def follow(swimmer: Swimmer, time_s: Array, pieces: Pieces) -> bool:
    """Return whether joints can turn at some controls, from rest to rest, by their rates and their acceleration.

    Args:
        swimmer: The swimmer.
        time_s: Times at which the controls begin [s]. Shape (n,).
        pieces: The motion from each to the next. There are n.
    """
    too_late = TimeLaw(swimmer).fault(0, time_s, pieces) is not None
    return not too_late and too_fast(swimmer, pieces.shapes, pieces.rates) is None


class JointsKept:
    """The joints' angles and rates along a trajectory, from its controls.

    Args:
        swimmer: The swimmer.
        start: The start configuration.
    """

    def __init__(self, swimmer: Swimmer, start: Configuration) -> None:
        self._swimmer = swimmer
        self._angles = angles_along(swimmer, start.shape, np.empty((0, 2, 2)))[0]
        self._time_law = TimeLaw(swimmer)

    def faults(self, row: int, time_s: Array, pieces: Pieces) -> dict[str, str]:
        """Return what some more rows ask of the joints that they cannot do, in words, by kind.

        Args:
            row: The number of the first.
            time_s: Their times [s]. Shape (n,).
            pieces: The motion from each to the next; the last may last no time. There are n.
        """
        swimmer, out = self._swimmer, dict[str, str]()
        late = self._time_law.fault(row, time_s, pieces)
        if late is not None:
            out["acceleration"] = late
        if swimmer.ball_joints:
            return out
        changed, turned = angle_changes(swimmer, pieces)
        if np.any(turned > _STRAY_RAD):
            n, limb = np.argwhere(turned > _STRAY_RAD)[0]
            joint = swimmer.joints[limb].name
            rate = turned[n, limb] / pieces.durations[n]
            what = f"limb {limb + 1} turns at {rate:.6g} rad/s about an axis that its {joint} has not"
            out["joint"] = f"line {row + n + 2} (t = {time_s[n]:.6g} s): {what}"
        changes = np.cumsum(changed, axis=0)
        angles = self._angles + np.concatenate([np.zeros((1, 2, 2)), changes])
        over = excess_of_ranges(swimmer, angles)
        if np.any(over > _STRAY_RAD):
            n, limb, k = np.argwhere(over > _STRAY_RAD)[0]
            name = ANGLES[k]
            low, high = swimmer.joints[limb].range_deg(name) or (0.0, 0.0)
            last = min(int(n), len(time_s) - 1)
            what = f"limb {limb + 1}'s {name} is {math.degrees(angles[n, limb, k]):.6g} degrees"
            out["range"] = f"line {row + last + 2} (t = {time_s[last]:.6g} s): {what}, out of {low:g} to {high:g}"
        self._angles = angles[-1]
        return out
