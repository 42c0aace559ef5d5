"""Whole documents: what is made of the elements that were read, and either of two."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Callable
from typing import Generic

import yaml

from purcell_cli.errors import InputError, ParameterError
from purcell_cli.files.elements import Schema, T, V
from purcell_cli.files.place import Place, kind

DIALECT = "https://json-schema.org/draft/2020-12/schema"
"""The JSON Schema dialect that `Document.json_schema` is written in."""


@dataclasses.dataclass(frozen=True)
class Either(Schema[T]):
    """A scalar or a mapping, each with a meaning of its own."""

    scalar: Schema[T]
    mapping: Schema[T]

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return f"{self.scalar.wanted} or {self.mapping.wanted}"

    def read(self, place: Place) -> T:
        """Return what the scalar or the mapping at a place means."""
        if isinstance(place.node, yaml.MappingNode):
            return self.mapping.read(place)
        if isinstance(place.node, yaml.SequenceNode) or kind(place.node) == "null":
            raise place.error(self.wanted)
        return self.scalar.read(place)

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"anyOf": [self.scalar.json_schema(), self.mapping.json_schema()]}


@dataclasses.dataclass(frozen=True)
class Made(Schema[T], Generic[V, T]):
    """An element whose value is made into another; a `ParameterError` gets the place.

    Attributes:
        schema: The element that is read.
        make: Takes its value and its place to the value wanted.
    """

    schema: Schema[V]
    make: Callable[[V, Place], T]

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return self.schema.wanted

    def read(self, place: Place) -> T:
        """Return the value made from what is at a place."""
        value = self.schema.read(place)
        try:
            return self.make(value, place)
        except ParameterError as error:
            raise placed(error, place) from error

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return self.schema.json_schema()


def placed(error: ParameterError, place: Place) -> InputError:
    """Return a `ParameterError` as the fault of a place, or of the key in it that the message names."""
    parts = re.fullmatch(r"(?:(\w+): )?(.*) (?:is|are) wanted, found (.*)", str(error), re.DOTALL)
    if parts is None:
        return place.error("a value that can be", str(error))
    name, wanted, found = parts.groups()
    return (place.at(name) if name else place).error(wanted, found)


@dataclasses.dataclass(frozen=True)
class Document(Schema[T]):
    """A whole document.

    Attributes:
        title: What it is.
        schema: The element at its top.
    """

    title: str
    schema: Schema[T]

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return self.schema.wanted

    def read(self, place: Place) -> T:
        """Return the value of the document."""
        return self.schema.read(place)

    def json_schema(self) -> dict[str, object]:
        """Return the document as JSON Schema."""
        return {"$schema": DIALECT, "title": self.title, **self.schema.json_schema()}
