"""Servo maps as YAML: which hinges a limb's joint is made of, and what each of its servos is told."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np

from purcell_cli.files.containers import Field, Pair, Record
from purcell_cli.files.documents import Document, Made
from purcell_cli.files.elements import Element
from purcell_cli.files.place import Place, finite_number
from purcell_cli.files.scalars import Choice, Number, Text
from purcell_cli.files.yaml_source import load
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.hinge_chain import TURNS, HingeChain
from purcell_cli.mechanics.swimmer import Swimmer

JOINTS = tuple(f"limb{limb}_{turn}" for limb in (1, 2) for turn in ("yaw", "pitch", "roll"))
"""All joints that a channel may be for."""

UNITS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "deg": {"zero": 0.0, "scale": 1.0, "range": (-180.0, 180.0)},
        "us": {"zero": 1500.0, "scale": 1000.0 / 90.0, "range": (500.0, 2500.0)},
    }
)
"""The units of a channel, and what its other keys are where they are left out.

Degrees from the collinear shape; or the microseconds of a hobby servo's pulse, 1500 in the middle and 90 degrees to
either side of it in 1000.
"""

_LARGEST = 1e6
"""No zero, end of a range or scale is larger, in whatever unit: a servo's pulse has thousands of microseconds."""


@frozen_dataclass(slots=False)
class Sign(Element[float]):
    """1 or -1."""

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return "1 or -1"

    def read(self, place: Place) -> float:
        """Return the sign at a place."""
        value = finite_number(place.node)
        if value not in {1.0, -1.0}:
            raise place.error(self.wanted)
        return float(value or 0.0)

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"enum": [1, -1]}


@frozen_dataclass
class Channel:
    """What a servo is told: zero + sign * scale * angle in degrees.

    Attributes:
        unit: "deg" or "us", microseconds.
        zero: What it is told at the angle 0, in its unit.
        sign: 1, or -1 for a servo that turns the other way.
        scale: How many units there are to a degree of the joint.
        low: The least that it may be told.
        high: The most that it may be told.
    """

    unit: str = "deg"
    zero: float = UNITS["deg"]["zero"]
    sign: float = 1.0
    scale: float = UNITS["deg"]["scale"]
    low: float = UNITS["deg"]["range"][0]
    high: float = UNITS["deg"]["range"][1]

    def told(self, angle_rad: Array) -> Array:
        """Return what the servo is told for angles of its joint [rad]. Shape (...)."""
        return np.asarray(self.zero + self.sign * self.scale * np.degrees(angle_rad))

    @property
    def limits_rad(self) -> tuple[float, float]:
        """The joint's least and largest angle [rad]."""
        ends = sorted(math.radians((end - self.zero) / (self.sign * self.scale)) for end in (self.low, self.high))
        return ends[0], ends[1]


_ORDER_DEFAULT = "zyx"
"""The order of hinges where none is named: their angles are the Euler angles psi, theta and phi."""

_AXES = {"psi": "z", "theta": "y"}
"""The axis about which each angle of a joint turns."""

_MARGIN_DEG = 5.0
"""How far the middle hinge stays from +-90 degrees where nothing else is said: there the outer two turn at most 11
times as fast as the limb."""


@frozen_dataclass
class ServoMap:
    """Which hinges each limb's joint is made of, and what their servos are told.

    Attributes:
        chains: The hinges of limb 1 and of limb 2.
        channels: A channel of each joint by name, limb 1's first, each limb's from the base outwards.
        lock_margin_rad: How far the middle one of three hinges must stay from +-pi/2 [rad].
    """

    chains: tuple[HingeChain, HingeChain]
    channels: Mapping[str, Channel]
    lock_margin_rad: float

    @classmethod
    def of(
        cls, orders: Mapping[str, str], channels: Mapping[str, Channel], margin_deg: float = _MARGIN_DEG
    ) -> ServoMap:
        """Return the map with some orders of limbs and some channels of joints; the others are as by default."""
        chains = tuple(HingeChain(limb, orders.get(f"limb{limb}", _ORDER_DEFAULT)) for limb in (1, 2))
        all_channels = {name: channels.get(name, Channel()) for chain in chains for name in chain.names}
        return cls((chains[0], chains[1]), MappingProxyType(all_channels), math.radians(margin_deg))

    @classmethod
    def of_swimmer(cls, swimmer: Swimmer) -> ServoMap:
        """Return the map of a swimmer's own joints, in degrees, with their ranges; a fixed one has hinges that rest."""
        orders: dict[str, str] = {}
        channels: dict[str, Channel] = {}
        for limb, joint in enumerate(swimmer.joints, 1):
            for angle in joint.angles:
                axis, own = _AXES[angle], joint.range_deg(angle)
                orders[f"limb{limb}"] = orders.get(f"limb{limb}", "") + axis
                if own is not None:
                    channels[f"limb{limb}_{TURNS[axis]}"] = Channel(low=own[0], high=own[1])
        return cls.of(orders, channels)


def _channel(value: dict[str, Any], place: Place) -> Channel:
    unit = value.get("unit", "deg")
    given = {**UNITS[unit], **value}
    low, high = given.pop("range")
    if low >= high:
        raise place.at("range").error("the least before the most", f"{low:g} and {high:g}")
    return Channel(**{"unit": unit, **given, "low": low, "high": high})


_VALUE = Number(at_least=-_LARGEST, at_most=_LARGEST)

_CHANNEL: Element[Channel] = Made(
    Record(
        {
            "unit": Field(Choice(tuple(UNITS)), "degrees, or microseconds of a pulse", default="deg"),
            "zero": Field(_VALUE, "what the servo is told at the angle 0; default: 0 deg, 1500 us"),
            "sign": Field(Sign(), "-1 for a servo that turns the other way", default=1),
            "scale": Field(Number(above=0.0, at_most=_LARGEST), "units to a degree; default: 1 deg, 11.111 us"),
            "range": Field(
                Pair(_VALUE, _VALUE), "the least and the most it may be told; default: +-180 deg, 500 to 2500 us"
            ),
        }
    ),
    _channel,
)

_ORDER = Text(r"(?!.*(.).*\1)[xyz]{1,3}", "one to three different letters of x, y and z, from the base outwards")


def _servo_map(value: dict[str, Any], place: Place) -> ServoMap:
    channels = value.get("channels", {})
    out = ServoMap.of(value.get("hinge_order", {}), channels, value.get("lock_margin_deg", _MARGIN_DEG))
    for name in channels:
        if name not in out.channels:
            raise place.at("channels", name).error(f"a joint of the hinge_order ({', '.join(out.channels)})", name)
    return out


SERVO_MAP = Document(
    "A servo map",
    Made(
        Record(
            {
                "hinge_order": Field(
                    Record(
                        {limb: Field(_ORDER, "its hinges' axes", default=_ORDER_DEFAULT) for limb in ("limb1", "limb2")}
                    ),
                    f"the axes of each limb's hinges ({', '.join(f'{a}: {t}' for a, t in TURNS.items())})",
                ),
                "lock_margin_deg": Field(
                    Number(above=0.0, at_most=45.0),
                    "how far the middle one of three hinges must stay from +-90 degrees",
                    default=_MARGIN_DEG,
                ),
                "channels": Field(
                    Record({name: Field(_CHANNEL, "what its servo is told") for name in JOINTS}),
                    "a channel of each joint; one left out is told degrees",
                ),
            }
        ),
        _servo_map,
    ),
)


def load_servo_map(path: Path | str) -> ServoMap:
    """Return the servo map of a file; the path - is standard input.

    Raises:
        InputError: The file says no servo map.
    """
    return load(path, SERVO_MAP)
