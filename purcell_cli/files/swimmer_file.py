"""Swimmers as YAML."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from purcell_cli.files.configuration_file import _within
from purcell_cli.files.containers import Field, Record
from purcell_cli.files.documents import Document, Made
from purcell_cli.files.place import Place
from purcell_cli.files.yaml_source import load
from purcell_cli.mechanics.swimmer import LIMITS, Swimmer


def _swimmer(value: dict[str, float], _: Place) -> Swimmer:
    return Swimmer(**value)


SWIMMER = Document(
    "A swimmer and its fluid",
    Made(
        Record(
            {
                field.name: Field(_within(*LIMITS[field.name]), default=field.default)
                for field in dataclasses.fields(Swimmer)
            }
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
