"""Whether joints can follow a trajectory in time, where their rates may not jump.

The rates of a trajectory's rows are stairs. From one change of the controls to the next, a joint with an acceleration
limit turns by what they say if some rate without jumps does, in one sense and within the joint's greatest rate. Which
rates are possible at each change is an interval: it is carried from the first row to the last, and must not be empty.
"""

from __future__ import annotations

import math

import numpy as np

from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.joint_motion import joint_rates
from purcell_cli.mechanics.joints import ANGLES
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer

_SLACK = 1e-6
"""By which part of itself a limit may be exceeded: above the rounding of the times of a file of hours."""
_ROUNDING = 1e-12
"""Rates below this part of a joint's greatest are rounding errors."""

Span = tuple[float, float]
"""The least and the greatest rate that a joint may have at a time [rad/s]."""

_AXES = ("roll", "pitch", "yaw")
"""What turns about a limb's own x, y, z are called."""


class TimeLaw:
    """The rates that joints may have where the controls change, from a trajectory's rows.

    Args:
        swimmer: The swimmer.
    """

    def __init__(self, swimmer: Swimmer) -> None:
        self._swimmer = swimmer
        self._acceleration = (swimmer.joint_acceleration_rad_s2 or math.inf) * (1.0 + _SLACK)
        self._most = [swimmer.rate_of(n // 3) * (1.0 + _SLACK) for n in range(6)]
        self._spans: list[Span] = [(0.0, 0.0)] * 6
        self._controls, self._rates = np.zeros(6), [0.0] * 6
        self._lasted, self._when = 0.0, (2, 0.0)

    def fault(self, row: int, time_s: Array, pieces: Pieces) -> str | None:
        """Return the first controls that a joint cannot follow, in words, where some more rows have some.

        Args:
            row: The number of the first.
            time_s: Their times [s]. Shape (n,).
            pieces: The motion from each to the next; the last may last no time. There are n.
        """
        if self._swimmer.joint_acceleration_rad_s2 is None:
            return None
        before = np.concatenate([self._controls[None], pieces.rates[:-1]])
        changes = np.flatnonzero(np.any(pieces.rates != before, axis=1))
        elapsed = np.concatenate([[0.0], np.cumsum(pieces.durations)])
        rates, begun = joint_rates(self._swimmer, pieces.shapes[changes], pieces.rates[changes]).tolist(), 0.0
        for n, new in zip(changes.tolist(), rates, strict=True):
            self._lasted += float(elapsed[n]) - begun
            found = self._over()
            if found is not None:
                return found
            begun, self._lasted, self._rates = float(elapsed[n]), 0.0, new
            self._when = (row + n + 2, float(time_s[n]))
        self._lasted += float(elapsed[-1]) - begun
        self._controls = pieces.rates[-1]
        # Joints rest where the file ends.
        return self._over() if not np.any(self._controls) else None

    def _over(self) -> str | None:
        """Carry what is possible over the controls that end now."""
        for k, rate in enumerate(self._rates):
            span = _after(self._spans[k], rate, self._lasted, self._acceleration, self._most[k])
            if span is None:
                joint = self._swimmer.joints[k // 3]
                what = _AXES[k % 3] if joint.ball else ANGLES[k % 3]
                turned = f"{rate * self._lasted:.6g} rad in {self._lasted:.6g} s"
                limit = (
                    f"{self._swimmer.joint_acceleration_rad_s2:g} rad/s^2 and {self._swimmer.rate_of(k // 3):g} rad/s"
                )
                return (
                    f"line {self._when[0]} (t = {self._when[1]:.6g} s): limb {k // 3 + 1}'s {what} "
                    f"cannot turn by {turned} after the rows before: its limits are {limit}"
                )
            self._spans[k] = span
        return None


def _after(span: Span, rate: float, lasts: float, acceleration: float, most: float) -> Span | None:
    """Return the rates possible after a time of a mean rate, from some before; None where there is none.

    Args:
        span: The rates possible before [rad/s].
        rate: The mean rate [rad/s].
        lasts: The time [s].
        acceleration: The greatest acceleration [rad/s^2].
        most: The greatest rate [rad/s].
    """
    if abs(rate) < _ROUNDING * most:
        return (0.0, 0.0) if span[0] <= _SLACK * most and span[1] >= -_SLACK * most else None
    if lasts == 0.0:
        return span
    if rate < 0.0:
        found = _after((-span[1], -span[0]), -rate, lasts, acceleration, most)
        return None if found is None else (-found[1], -found[0])
    low, high = max(span[0], 0.0), max(span[1], 0.0)
    if span[1] < -_SLACK * most or rate > most:
        return None
    greatest = _greatest(low, high, rate, lasts, acceleration)
    # Seen from the greatest rate downward, the least is the greatest.
    least_below = _greatest(most - high, most - low, most - rate, lasts, acceleration)
    if greatest is None or least_below is None:
        return None
    out = max(most - least_below, 0.0), min(greatest, most)
    return out if out[0] <= out[1] else None


def _greatest(low: float, high: float, mean: float, lasts: float, acceleration: float) -> float | None:
    """Return the greatest rate that a joint may end at, its rate never below 0: it falls first, and rises then."""
    half = 0.5 * acceleration * lasts
    if mean >= low + half:  # it rises all the time
        return mean + half if mean - half <= high else None
    square = (mean - low) * lasts / acceleration + 0.5 * lasts * lasts
    if square < 0.0:
        return None
    rising = math.sqrt(square)
    if low < acceleration * (lasts - rising):  # it rests between
        square = 2.0 * acceleration * mean * lasts - low * low
        return None if square < 0.0 else math.sqrt(square)
    return low + acceleration * (2.0 * rising - lasts)
