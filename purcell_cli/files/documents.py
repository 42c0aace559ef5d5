"""Whole documents, and the values that are made of what their elements read."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Generic

from purcell_cli.errors import InputError, ParameterError
from purcell_cli.files.elements import Element, OtherT, ValueT
from purcell_cli.files.place import Place
from purcell_cli.frozen_dataclass import frozen_dataclass

DIALECT = "https://json-schema.org/draft/2020-12/schema"
"""The JSON Schema dialect that `Document.json_schema` is written in."""


@frozen_dataclass(slots=False)
class Made(Element[ValueT], Generic[OtherT, ValueT]):
    """An element whose value is made into another; a `ParameterError` gets the place.

    Attributes:
        element: The element that is read.
        make: Takes its value and its place to the value wanted.
    """

    element: Element[OtherT]
    make: Callable[[OtherT, Place], ValueT]

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return self.element.wanted

    def read(self, place: Place) -> ValueT:
        """Return the value made from what is at a place."""
        value = self.element.read(place)
        try:
            return self.make(value, place)
        except ParameterError as error:
            raise placed(error, place) from error

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return self.element.json_schema()


def placed(error: ParameterError, place: Place) -> InputError:
    """Return a `ParameterError` as the fault of a place, or of the key in it that the message names."""
    parts = re.fullmatch(r"(?:([\w.]+): )?(.*?),? (?:is|are) wanted, found (.*)", str(error), re.DOTALL)
    if parts is None:
        return place.error("a value that can be", str(error))
    name, wanted, found = parts.groups()
    steps = [int(step) if step.isdigit() else step for step in name.split(".")] if name else []
    return place.at(*steps).error(wanted, found)


@frozen_dataclass(slots=False)
class Document(Element[ValueT]):
    """A whole document.

    Attributes:
        title: What it is.
        element: The element at its top.
    """

    title: str
    element: Element[ValueT]

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return self.element.wanted

    def read(self, place: Place) -> ValueT:
        """Return the value of the document."""
        return self.element.read(place)

    def json_schema(self) -> dict[str, object]:
        """Return the document as JSON Schema."""
        return {"$schema": DIALECT, "title": self.title, **self.element.json_schema()}
