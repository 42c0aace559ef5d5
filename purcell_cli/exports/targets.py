"""What a trajectory can be exported to, and what it takes."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from purcell_cli.errors import UnknownNameError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.wording import nearest_hint


@frozen_dataclass
class Target:
    """What a trajectory can be exported to.

    Attributes:
        meaning: What it is for.
        endings: Endings that its file may have, the first where none is named.
        holds: What its file has many of.
        uses_map: Whether it has to do with hinges.
    """

    meaning: str
    endings: tuple[str, ...]
    holds: str
    uses_map: bool = True


TARGETS: Mapping[str, Target] = MappingProxyType(
    {
        "servo": Target("a table of angles or pulses at a fixed tick", ("csv",), "ticks"),
        "mcap": Target("ROS 2 messages, for rosbag2 and Foxglove", ("mcap",), "messages"),
        "rerun": Target("a recording for the Rerun viewer", ("rrd",), "rows", uses_map=False),
        "urdf": Target("the swimmer as a robot description", ("urdf", "xml"), "joints"),
    }
)
"""The targets by name."""


def target(name: str) -> Target:
    """Return a target by its name.

    Raises:
        UnknownNameError: No target has this name.
    """
    if name not in TARGETS:
        known = f"{', '.join(TARGETS)}{nearest_hint(name, TARGETS)}"
        raise UnknownNameError(f"--to: one of {known} is wanted, found {name!r}")
    return TARGETS[name]
