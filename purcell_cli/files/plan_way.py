"""The way of a plan in its document: the waypoints that it passes, and the curve that it follows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from purcell_cli.files.configuration_file import COORDINATE, ORIENTATION
from purcell_cli.files.containers import Field, ListOf, Record
from purcell_cli.files.documents import Made
from purcell_cli.files.elements import Element
from purcell_cli.files.mission_elements import WAYPOINT_FIELDS, waypoint_read
from purcell_cli.files.place import Place
from purcell_cli.files.scalars import Number, Whole
from purcell_cli.motion.curve import Curve
from purcell_cli.motion.mission import Follow, Passage

_MOST = 10_000_000
"""Blocks and waypoints of a plan are fewer than this."""


def _passage(value: dict[str, Any], place: Place) -> Passage:
    return Passage(index=value.pop("index"), block=value.pop("block"), waypoint=waypoint_read(value, place))


_PASSAGE: Element[Passage] = Made(
    Record(
        {
            "index": Field(Whole(0, _MOST), "its place in the mission's list, from 0", required=True),
            "block": Field(Whole(0, _MOST), "how many blocks come before it", required=True),
            **WAYPOINT_FIELDS,
        }
    ),
    _passage,
)


def _follow(value: dict[str, Any], _: Place) -> Follow:
    turns = value.get("orientation")
    return Follow(Curve(np.array(value["points_m"]), None if turns is None else np.stack(turns)), value["tolerance_m"])


_FOLLOW: Element[Follow] = Made(
    Record(
        {
            "tolerance_m": Field(Number(above=0.0), "how far from the curve the base's middle may be", required=True),
            "points_m": Field(ListOf(ListOf(COORDINATE, 3), at_least=2), "the curve's points [m]", required=True),
            "orientation": Field(ListOf(ORIENTATION), "the base's orientation at each, where it is wanted"),
        }
    ),
    _follow,
)

WAY_FIELDS = {
    "via": Field(ListOf(_PASSAGE), "the waypoints that are passed, in order"),
    "follow": Field(_FOLLOW, "the curve that is followed"),
}
"""The keys of a plan document that say its way; left out where there is nothing between start and goal."""


def way_written(passages: Sequence[Passage], follow: Follow | None) -> dict[str, Any]:
    """Return the way as a document's values."""
    out: dict[str, Any] = {}
    if passages:
        out["via"] = [_passage_written(one) for one in passages]
    if follow is not None:
        turns = follow.curve.orientation
        out["follow"] = {"tolerance_m": follow.tolerance_m, "points_m": follow.curve.point_m.tolist()}
        out["follow"] |= {} if turns is None else {"orientation": [{"matrix": turn.tolist()} for turn in turns]}
    return out


def _passage_written(passage: Passage) -> dict[str, Any]:
    one = passage.waypoint
    base: dict[str, Any] = {} if one.position_m is None else {"position_m": one.position_m.tolist()}
    base |= {} if one.orientation is None else {"orientation": {"matrix": one.orientation.tolist()}}
    limbs = {name: getattr(one, name) for name in ("limb1", "limb2") if getattr(one, name) is not None}
    out: dict[str, Any] = {"index": passage.index, "block": passage.block}
    out |= {"base": base} if base else {}
    return out | {name: {"matrix": limb.tolist()} for name, limb in limbs.items()}
