"""The joints of a swimmer in documents: elements that read them, and values that are written."""

from __future__ import annotations

import dataclasses
from typing import Any

import yaml

from purcell_cli.files.containers import Either, Field, ListOf, Record
from purcell_cli.files.documents import Made
from purcell_cli.files.elements import Element
from purcell_cli.files.place import Place
from purcell_cli.files.scalars import Choice, Number
from purcell_cli.mechanics.joints import ACCELERATION_LIMITS, ANGLES, AXES, FARTHEST_DEG, KINDS, RATE_LIMITS, Joint
from purcell_cli.mechanics.swimmer import Swimmer

_RANGE = ListOf(Number(at_least=-FARTHEST_DEG, at_most=FARTHEST_DEG), length=2)
"""The least and the greatest angle [deg]."""


class _Ranges(Element[dict[str, list[float]] | list[float]]):
    """A range of the one angle of a hinge, or ranges of angles by name."""

    _by_name = Record({name: Field(_RANGE, f"the least and the greatest {name} [deg]") for name in ANGLES})

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return f"{_RANGE.wanted}, or {self._by_name.wanted}"

    def read(self, place: Place) -> dict[str, list[float]] | list[float]:
        """Return the range, or the ranges by angle."""
        if isinstance(place.node, yaml.SequenceNode):
            return _RANGE.read(place)
        if isinstance(place.node, yaml.MappingNode):
            return self._by_name.read(place)
        raise place.error(self.wanted)

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"anyOf": [_RANGE.json_schema(), self._by_name.json_schema()]}


def _joint(value: dict[str, Any], place: Place) -> Joint:
    bare = _bare(value.get("kind", "ball"), value.get("axis"))
    given = value.get("range_deg", {})
    if isinstance(given, list):
        if len(bare.angles) != 1:
            wanted = f"ranges by angle ({', '.join(bare.angles)})" if bare.angles else f"none for a {bare.name}"
            raise place.at("range_deg").error(wanted)
        given = {bare.angles[0]: given}
    ranges: dict[str, Any] = {f"{name}_deg": tuple(pair) for name, pair in given.items()}
    return dataclasses.replace(bare, **ranges, rate_rad_s=value.get("rate_rad_s"))


def _bare(kind: str, axis: str | None = None) -> Joint:
    """Return a joint without ranges; a hinge whose axis is not said turns by yaw."""
    return Joint(kind, AXES[0] if kind == "hinge" and axis is None else axis)


_RATE = Number(above=RATE_LIMITS[0], at_most=RATE_LIMITS[1])

_JOINT: Element[Joint] = Either(
    Made(Choice(KINDS), lambda kind, _: _bare(kind)),
    Made(
        Record(
            {
                "kind": Field(Choice(KINDS), "which joint", default="ball"),
                "axis": Field(Choice(AXES), "of a hinge: the axis that it turns about; left out, yaw"),
                "range_deg": Field(
                    _Ranges(), "of a hinge: [least, greatest]; of a universal joint: {psi: ..., theta: ...}"
                ),
                "rate_rad_s": Field(_RATE, "the rate at which it turns; left out, joint_rate_rad_s"),
            }
        ),
        _joint,
    ),
)


def _joints(value: dict[str, Joint], _: Place) -> tuple[Joint, Joint]:
    return value.get("limb1", Joint()), value.get("limb2", Joint())


_MEANING = "its joint: ball, universal, hinge or fixed, or a mapping; left out, ball"

JOINT_FIELDS = {
    "joints": Field(
        Made(Record({"limb1": Field(_JOINT, _MEANING), "limb2": Field(_JOINT, _MEANING)}), _joints),
        "the joints that the limbs hang on",
    ),
    "joint_acceleration_rad_s2": Field(
        Number(above=ACCELERATION_LIMITS[0], at_most=ACCELERATION_LIMITS[1]),
        "how fast joints' rates change; left out, rates may jump",
    ),
}
"""The keys of a swimmer's document that are about joints."""


def joint_written(joint: Joint) -> dict[str, Any] | str:
    """Return a joint as a document's value."""
    ranges = {name: list(found) for name in ANGLES if (found := joint.range_deg(name)) is not None}
    out: dict[str, Any] = {"kind": joint.kind}
    out |= {} if joint.axis is None else {"axis": joint.axis}
    out |= {} if not ranges else {"range_deg": ranges if joint.kind == "universal" else next(iter(ranges.values()))}
    return out | ({} if joint.rate_rad_s is None else {"rate_rad_s": joint.rate_rad_s})


def joints_written(swimmer: Swimmer) -> dict[str, Any]:
    """Return what a document says of a swimmer's joints: nothing of ball joints whose rates may jump."""
    out: dict[str, Any] = {}
    if swimmer.joints != Swimmer().joints:
        out["joints"] = {f"limb{k}": joint_written(joint) for k, joint in enumerate(swimmer.joints, 1)}
    if swimmer.joint_acceleration_rad_s2 is not None:
        out["joint_acceleration_rad_s2"] = swimmer.joint_acceleration_rad_s2
    return out
