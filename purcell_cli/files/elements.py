"""What a YAML document of the project may say: elements that read it and print themselves as JSON Schema.

An element reads one node of a YAML document at a `Place` and returns a checked value. Whatever is
wrong is an `InputError` that reads ``FILE:LINE: KEY: wanted ..., found ...``. Nodes are kept until
the value is made, so that a later check (a matrix that is no rotation) still knows its line. Why this is
not pydantic: docs/explanation/decisions.md.
"""

from __future__ import annotations

import abc
from typing import Generic, TypeVar

from purcell_cli.files.place import Place

ValueT = TypeVar("ValueT")
ValueT_co = TypeVar("ValueT_co", covariant=True)
OtherT = TypeVar("OtherT")


class Element(abc.ABC, Generic[ValueT_co]):
    """One element of a document."""

    @property
    @abc.abstractmethod
    def wanted(self) -> str:
        """What the element wants to find, in words."""

    @abc.abstractmethod
    def read(self, place: Place) -> ValueT_co:
        """Return the value at a place.

        Raises:
            InputError: The value is not what is wanted.
        """

    @abc.abstractmethod
    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema (draft 2020-12)."""
