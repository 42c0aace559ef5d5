"""The joints that limbs hang on: which angles they have, in which ranges, and at which rates.

The paper's ball joints turn about three axes. A universal joint has no roll: A = Rz(psi) Ry(theta). A hinge has one of
these angles, and a fixed limb keeps the shape it starts with. Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal, get_args

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import arccos, arctan2, cos, sin
from purcell_cli.geometry.rotations import Array, as_euler, from_euler

Kind = Literal["ball", "universal", "hinge", "fixed"]
"""The kinds of joints."""
AT_ONCE: tuple[str, ...] = ("ball", "hinge")
"""The kinds whose limbs turn at constant rates about axes of their own, so that all may turn at once."""
Axis = Literal["yaw", "pitch"]
"""The axes of hinges: psi is the angle of a yaw hinge, theta of a pitch hinge."""
KINDS: tuple[str, ...] = get_args(Kind)
AXES: tuple[str, ...] = get_args(Axis)

ANGLES = ("psi", "theta")
"""The angles that joints other than ball joints have: yaw about the base's z, then pitch about the limb's own y."""

RATE_LIMITS: tuple[float, float] = (1e-9, 1e6)
"""What a joint's rate is above, and at most [rad/s]."""
ACCELERATION_LIMITS: tuple[float, float] = (1e-9, 1e9)
"""What a joint's acceleration is above, and at most [rad/s^2]."""
FARTHEST_DEG = 180.0
"""Ranges lie within this of 0 [deg]."""
HOME_ROOM_RAD = 0.3
"""How far from the ends of its range an angle is between the phases, where there is so much room [rad]."""
MISFIT_RAD = 1e-11
"""By how much a shape may miss what its joint can do: a hundredth of what plans may miss [rad]."""
RANGE_SLACK_RAD = 1e-10
"""By how much an angle may be out of its range: a tenth of what plans may miss [rad]."""

_ANGLES_OF: Mapping[tuple[str, str | None], tuple[str, ...]] = MappingProxyType(
    {("universal", None): ANGLES, ("hinge", "yaw"): ("psi",), ("hinge", "pitch"): ("theta",)}
)


@frozen_dataclass
class Joint:
    """The joint of one limb.

    Attributes:
        kind: One of `KINDS`.
        axis: The axis of a hinge; None for the others.
        psi_deg: The least and the greatest psi, where there is a range [deg].
        theta_deg: The least and the greatest theta, where there is a range [deg].
        rate_rad_s: The rate at which it turns; None for the swimmer's [rad/s].

    Raises:
        ParameterError: A joint that there is not.
    """

    kind: str = "ball"
    axis: str | None = None
    psi_deg: tuple[float, float] | None = None
    theta_deg: tuple[float, float] | None = None
    rate_rad_s: float | None = None

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ParameterError(f"kind: one of {', '.join(KINDS)} is wanted, found {self.kind!r}")
        if (self.kind == "hinge") != (self.axis is not None) or self.axis not in {None, *AXES}:
            wanted = f"one of {', '.join(AXES)}" if self.kind == "hinge" else f"none for a {self.kind} joint"
            raise ParameterError(f"axis: {wanted} is wanted, found {self.axis!r}")
        for name in ANGLES:
            given = self.range_deg(name)
            if given is None:
                continue
            if name not in self.angles:
                raise ParameterError(f"range_deg: no range of {name} is wanted, found {list(given)}")
            low, high = (float(value) for value in given)
            if not -FARTHEST_DEG <= low < high <= FARTHEST_DEG:
                wanted = f"two angles of {name} from -{FARTHEST_DEG:g} to {FARTHEST_DEG:g}, the least first,"
                key = f"range_deg.{name}" if len(self.angles) > 1 else "range_deg"
                raise ParameterError(f"{key}: {wanted} are wanted, found {list(given)}")
            object.__setattr__(self, f"{name}_deg", (low, high))
        if self.rate_rad_s is not None:
            if self.kind == "fixed":
                raise ParameterError(f"rate_rad_s: none for a fixed joint is wanted, found {self.rate_rad_s!r}")
            low, high = RATE_LIMITS
            if not low < self.rate_rad_s <= high:
                text = f"a number above {low:g} and at most {high:g} is wanted, found {self.rate_rad_s!r}"
                raise ParameterError(f"rate_rad_s: {text}")

    @property
    def ball(self) -> bool:
        """Whether it turns about all three axes."""
        return self.kind == "ball"

    @property
    def angles(self) -> tuple[str, ...]:
        """The angles it has: of "psi" and "theta" some; none for ball joints, whose primitives are the limb's turns."""
        return _ANGLES_OF.get((self.kind, self.axis), ())

    @property
    def name(self) -> str:
        """What it is called in messages."""
        return f"{self.axis} hinge" if self.kind == "hinge" else f"{self.kind} joint"

    def range_deg(self, angle: str) -> tuple[float, float] | None:
        """Return the range of psi or theta, if it has one [deg]."""
        return self.psi_deg if angle == "psi" else self.theta_deg

    def range_rad(self, angle: str) -> tuple[float, float]:
        """Return the range of psi or theta, infinite where there is none [rad]."""
        found = self.range_deg(angle)
        return (-math.inf, math.inf) if found is None else (math.radians(found[0]), math.radians(found[1]))

    def controls(self, limb: int) -> tuple[int, ...]:
        """Return the primitives of a limb, 0 or 1, on this joint: numbers in the order of `PRIMITIVE_NAMES`."""
        if self.ball:
            return (3 * limb, 3 * limb + 1, 3 * limb + 2)
        if self.kind == "universal":
            return (3 * limb + 1, 6 + limb)
        return tuple(3 * limb + (2 if name == "psi" else 1) for name in self.angles)

    def at_rate(self, rate_rad_s: float | None) -> Joint:
        """Return the joint with another rate [rad/s]; None for the swimmer's."""
        return self if self.rate_rad_s == rate_rad_s else dataclasses.replace(self, rate_rad_s=rate_rad_s)

    def home_rad(self, max_bend_rad: float) -> tuple[float, float]:
        """Return the psi and theta between the phases: nearest to collinear, with room to both sides [rad].

        Args:
            max_bend_rad: How far the limb bends in phase 2, if its ranges let it [rad].
        """
        ends = [self.range_rad(name) for name in ANGLES]
        near = [min(max(0.0, low), high) for low, high in ends]
        bend = float(arccos(cos(near[0]) * cos(near[1])))
        room = max(max_bend_rad - bend, 0.0) / (1.0 + len(self.angles))
        out = []
        for low, high in ends:
            inside = min(HOME_ROOM_RAD, 0.5 * (high - low), room)
            out.append(min(max(0.0, low + inside), high - inside))
        return out[0], out[1]

    def read(self, limb: Array) -> tuple[float, float]:
        """Return the psi and theta of a limb's orientation, in their ranges where a whole turn brings them there [rad].

        Args:
            limb: The limb's orientation, which the joint can make. Shape (3, 3).
        """
        return self._ranged("psi", _psi(limb)), self._ranged("theta", _theta(limb))

    def _ranged(self, name: str, angle: float) -> float:
        low, high = self.range_rad(name)
        turned = (angle, angle + 2.0 * math.pi, angle - 2.0 * math.pi)
        return min(turned, key=lambda a: (round(max(low - a, a - high, 0.0), 12), abs(a)))

    def beyond(self, name: str, angle: float) -> float:
        """Return by how much psi or theta is out of its range, 0 where it is not [rad]."""
        low, high = self.range_rad(name)
        return max(low - angle, angle - high, 0.0)

    def misfit(self, limb: Array) -> tuple[str, float]:
        """Return the angle of a limb's orientation that the joint has not, and how far it is from 0 [rad].

        Args:
            limb: The orientation. Shape (3, 3).
        """
        if self.ball or self.kind == "fixed":
            return "", 0.0
        psi, theta = _psi(limb), _theta(limb)
        roll = float(arctan2(limb[2, 1], limb[1, 1] * cos(psi) - limb[0, 1] * sin(psi)))
        # With psi and theta both beyond 90 degrees it is a limb rolled over.
        over = self.kind == "universal" and limb[1, 1] < 0.0 and limb[2, 2] < 0.0
        if not over and max(abs(angle) for _, angle in self._missing(psi, theta, roll)) <= MISFIT_RAD:
            return "", 0.0
        return max(self._missing(*as_euler(limb).tolist()), key=lambda one: abs(one[1]))

    def _missing(self, psi: float, theta: float, roll: float) -> list[tuple[str, float]]:
        """Return those of three angles that the joint has not, by name [rad]."""
        angles = ("psi", psi), ("theta", theta), ("roll", roll)
        return [(name, angle) for name, angle in angles if name not in self.angles]


BALL = Joint()
"""The paper's joint."""

Joints = tuple[Joint, Joint]
"""The joints of limb 1 and limb 2."""


def named(joints: Joints) -> str:
    """Return what the joints of both limbs are, in words."""
    return " and ".join(f"a {joint.name}" for joint in joints)


def _psi(limb: Array) -> float:
    return float(arctan2(-limb[0, 1], limb[1, 1]))


def _theta(limb: Array) -> float:
    return float(arctan2(-limb[2, 0], limb[2, 2]))


def limb_at(psi: float, theta: float) -> Array:
    """Return the orientation of a limb at two angles [rad]. Shape (3, 3)."""
    return from_euler([psi, theta, 0.0])
