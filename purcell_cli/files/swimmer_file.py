"""Swimmers as YAML."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import yaml

from purcell_cli.errors import refuse_types
from purcell_cli.files.atomic_file import whole_file
from purcell_cli.files.containers import Either, Field, ListOf, Record
from purcell_cli.files.documents import Document, Made
from purcell_cli.files.elements import Element
from purcell_cli.files.joint_elements import JOINT_FIELDS, joints_written
from purcell_cli.files.place import Place
from purcell_cli.files.scalars import Choice, Number
from purcell_cli.files.yaml_source import load
from purcell_cli.mechanics.drag import COX, LAWS, LINKS, LinkDrag, LinkDrags, LinkSize, LinkSizes
from purcell_cli.mechanics.fluid import FLUIDS
from purcell_cli.mechanics.swimmer import LARGEST_BODY_RADIUS_M, LIMITS, Swimmer
from purcell_cli.mechanics.wall import FARTHEST_M, Wall


def _swimmer(value: dict[str, Any], _: Place) -> Swimmer:
    return Swimmer(**value)


def _each_link(number: type[LinkDrag | LinkSize], fields: dict[str, Field], all_links: type[Any]) -> Element[Any]:
    """Return the element for a mapping of some links to some numbers of theirs."""
    own = Made(Record(fields), lambda value, _: number(**value))
    record = Record({link: Field(own, "of the base" if link == "base" else f"of limb {link[-1]}") for link in LINKS})
    return Made(record, lambda value, _: all_links(**value))


_DRAGS = _each_link(
    LinkDrag,
    {
        "along_n_s_per_m": Field(Number(above=0.0, at_most=1e12), "force per speed along the axis [N s/m]"),
        "across_n_s_per_m": Field(Number(above=0.0, at_most=1e12), "force per speed across it [N s/m]"),
        "turn_n_m_s": Field(Number(above=0.0, at_most=1e12), "torque per rate of turning about the middle [N m s]"),
        "spin_n_m_s": Field(Number(above=0.0, at_most=1e12), "torque per rate of spinning about the axis [N m s]"),
    },
    LinkDrags,
)

_SIZES = _each_link(
    LinkSize,
    {
        name: Field(Number(above=LIMITS[like][0], at_most=LIMITS[like][1]), meaning)
        for name, like, meaning in (
            ("half_length_m", "limb_half_length_m", "half its length [m]"),
            ("slenderness", "slenderness", "its radius over its full length"),
        )
    },
    LinkSizes,
)

_VECTOR = ListOf(Number(at_least=-FARTHEST_M, at_most=FARTHEST_M), 3)
"""A point [m] or a direction."""

_WALL = Made(
    Record(
        {
            "point_m": Field(_VECTOR, "a point of it in the world [m]", required=True),
            "normal": Field(_VECTOR, "its normal, into the fluid, of any length", required=True),
        }
    ),
    lambda value, _: Wall(**value),
)

_OWN = {
    "fluid": Field(Choice(FLUIDS), "each link alone, or links that feel each other's flow", default="local"),
    "wall": Field(
        _WALL, "a plane wall without slip, with fluid: beads; simulate, track --truth and controllability know it"
    ),
    "drag": Field(
        Either(Choice(LAWS), _DRAGS),
        "the law of a link's drag, or the whole drag of links in numbers; what is left out of them is as cox",
        default=COX,
    ),
    "links": Field(_SIZES, "the sizes of links that differ from those of the three keys above"),
    "body_radius_m": Field(
        Number(at_least=0.0, at_most=LARGEST_BODY_RADIUS_M),
        "radius of a sphere at the base's middle that drags too [m]",
        default=0.0,
    ),
}
"""The keys of the fluid, drag, sizes of links and body."""

SWIMMER = Document(
    "A swimmer and its fluid",
    Made(
        Record(
            {
                **{
                    field.name: Field(Number(above=above, at_most=at_most), default=field.default)
                    for field in dataclasses.fields(Swimmer)
                    if field.name in LIMITS
                    for above, at_most in (LIMITS[field.name],)
                },
                **_OWN,
            }
            | JOINT_FIELDS
        ),
        _swimmer,
    ),
)


def swimmer_written(swimmer: Swimmer) -> dict[str, Any]:
    """Return a swimmer as a document's values: its numbers, and what else it has that the paper's has not."""
    out: dict[str, Any] = {name: getattr(swimmer, name) for name in LIMITS}
    drag = swimmer.drag if isinstance(swimmer.drag, str) else _given(dataclasses.asdict(swimmer.drag))
    own = {
        "fluid": swimmer.fluid,
        "wall": None if swimmer.wall is None else {k: list(v) for k, v in dataclasses.asdict(swimmer.wall).items()},
        "drag": drag,
        "links": _given(dataclasses.asdict(swimmer.links)),
        "body_radius_m": swimmer.body_radius_m,
    }
    return (
        out
        | {name: value for name, value in own.items() if value and value not in ("local", COX)}
        | joints_written(swimmer)
    )


def _given(value: dict[str, Any]) -> dict[str, Any]:
    """Return a mapping without what is None or empty, all the way down."""
    inner = {k: _given(v) if isinstance(v, dict) else v for k, v in value.items()}
    return {k: v for k, v in inner.items() if v is not None and v != {}}


def write_swimmer(swimmer: Swimmer, path: Path | str, remarks: Sequence[str] = ()) -> None:
    """Write a swimmer as YAML.

    Args:
        swimmer: The swimmer.
        path: The file; it is replaced only when all is written.
        remarks: Lines that stand as comments at the top.

    Raises:
        InputError: The file cannot be written.
        ParameterError: What is no swimmer.
    """
    refuse_types(swimmer=(swimmer, Swimmer))
    head = "".join(f"# {remark}".rstrip() + "\n" for remark in remarks)
    text = yaml.safe_dump(swimmer_written(swimmer), sort_keys=False, width=1000, default_flow_style=None)
    with whole_file(path) as stream:
        stream.write((head + text).encode())


def load_swimmer(path: Path | str) -> Swimmer:
    """Return the swimmer of a file; the path - is standard input.

    Raises:
        InputError: The file says no swimmer.
    """
    return load(path, SWIMMER)
