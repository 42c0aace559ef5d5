"""What a scenario says of the way: waypoints to pass, their order, and a curve to follow."""

from __future__ import annotations

from typing import Any

from purcell_cli.files.configuration_file import COORDINATE, ORIENTATION
from purcell_cli.files.containers import Field, ListOf, Record
from purcell_cli.files.curve_file import curve_of
from purcell_cli.files.documents import Made
from purcell_cli.files.elements import Element
from purcell_cli.files.option_elements import choice
from purcell_cli.files.paths import UnreadableError
from purcell_cli.files.place import Place, shortened
from purcell_cli.files.scalars import Number, Text
from purcell_cli.files.yaml_source import file_bytes
from purcell_cli.motion.curve import Curve
from purcell_cli.motion.mission import Follow, Order, Waypoint

WAYPOINT_FIELDS = {
    "base": Field(
        Record(
            {
                "position_m": Field(ListOf(COORDINATE, 3), "position in the world [m]; left out, free"),
                "orientation": Field(ORIENTATION, "orientation in the world; left out, free"),
            }
        ),
        "the base link",
    ),
    "limb1": Field(ORIENTATION, "limb 1 in the base; left out, free"),
    "limb2": Field(ORIENTATION, "limb 2 in the base; left out, free"),
}


def waypoint_read(value: dict[str, Any], _: Place) -> Waypoint:
    """Return the waypoint that the values of a mapping say."""
    return Waypoint(**{**value.pop("base", {}), **value})


WAYPOINT: Element[Waypoint] = Made(Record(WAYPOINT_FIELDS), waypoint_read)
"""The element for a waypoint: a configuration whose parts may all be left out but one."""


def _curve(name: str, place: Place) -> Curve:
    path = place.folder / name
    try:
        data = file_bytes(path)
    except UnreadableError as error:
        raise place.error("the path of a readable file", f"{error} at '{shortened(str(path))}'") from error
    return curve_of(data, str(path))


FOLLOW: Element[Follow] = Made(
    Record(
        {
            "path": Field(
                Made(Text(meaning="the path of a CSV file"), _curve),
                "a CSV file with the columns x_m,y_m,z_m and, if wanted, qw,qx,qy,qz",
                required=True,
            ),
            "tolerance_m": Field(Number(above=0.0), "how far from it the base's middle may be [m]", required=True),
        }
    ),
    lambda value, _: Follow(value["path"], value["tolerance_m"]),
)
"""The element for a curve to follow."""

MISSION_FIELDS = {
    "via": Field(ListOf(WAYPOINT, at_least=1), "configurations to pass exactly in what they name; the rest is free"),
    "order": Field(choice(Order), "the order of the waypoints, as given or as it costs least", default="given"),
    "follow": Field(FOLLOW, "a curve that the base's middle follows to its end"),
}
"""The keys of a scenario that say what is to be done on the way."""
