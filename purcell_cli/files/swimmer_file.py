"""Swimmers as YAML."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

from purcell_cli.files.containers import Field, Record
from purcell_cli.files.documents import Document, Made
from purcell_cli.files.joint_elements import JOINT_FIELDS, joints_written
from purcell_cli.files.place import Place
from purcell_cli.files.scalars import Choice, Number
from purcell_cli.files.yaml_source import load
from purcell_cli.mechanics.swimmer import FLUIDS, LIMITS, Swimmer


def _swimmer(value: dict[str, Any], _: Place) -> Swimmer:
    return Swimmer(**value)


_NAMED = {"fluid": Field(Choice(FLUIDS), "each link alone, or links that feel each other's flow", default="local")}
"""The keys that are no numbers."""


SWIMMER = Document(
    "A swimmer and its fluid",
    Made(
        Record(
            {
                field.name: Field(Number(above=above, at_most=at_most), default=field.default)
                for field in dataclasses.fields(Swimmer)
                if field.name in LIMITS
                for above, at_most in (LIMITS[field.name],)
            }
            | _NAMED
            | JOINT_FIELDS
        ),
        _swimmer,
    ),
)


def load_swimmer(path: Path | str) -> Swimmer:
    """Return the swimmer of a file; the path - is standard input.

    Raises:
        InputError: The file says no swimmer.
    """
    return load(path, SWIMMER)


def swimmer_written(swimmer: Swimmer) -> dict[str, Any]:
    """Return a swimmer as a document's values: its numbers, and its joints where they are no ball joints."""
    return {name: getattr(swimmer, name) for name in (*LIMITS, *_NAMED)} | joints_written(swimmer)
