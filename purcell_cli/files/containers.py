"""Elements of a document's description that are made of others: lists, records, maps, and either of two."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping
from typing import Any, Generic

import yaml

from purcell_cli.files.elements import Element, OtherT, ValueT
from purcell_cli.files.place import Place, kind, shortened
from purcell_cli.files.scalars import Text
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.wording import nearest_hint


@frozen_dataclass(slots=False)
class ListOf(Element[list[ValueT]]):
    """A list.

    Attributes:
        item: What each item is.
        length: How many items, if that is fixed.
        at_least: How many items at least.
    """

    item: Element[ValueT]
    length: int | None = None
    at_least: int = 0

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        least = f" of {self.at_least} or more" if self.at_least else ""
        count = f" of {self.length}" if self.length is not None else least
        return f"a list{count}, each {self.item.wanted}"

    def read(self, place: Place) -> list[ValueT]:
        """Return the list at a place."""
        if not isinstance(place.node, yaml.SequenceNode):
            raise place.error(self.wanted)
        count = len(place.node.value)
        if count < self.at_least or (self.length is not None and count != self.length):
            raise place.error(self.wanted)
        return [self.item.read(item) for item in place.items()]

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        out: dict[str, object] = {"type": "array", "items": self.item.json_schema()}
        if self.length is not None:
            return {**out, "minItems": self.length, "maxItems": self.length}
        return {**out, "minItems": self.at_least} if self.at_least else out


@frozen_dataclass(slots=False)
class Pair(Element[tuple[ValueT, OtherT]], Generic[ValueT, OtherT]):
    """A list of two, each with a meaning of its own.

    Attributes:
        first: What the first is.
        second: What the second is.
    """

    first: Element[ValueT]
    second: Element[OtherT]

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        first, second = self.first.wanted, self.second.wanted
        return f"a list of 2, each {first}" if first == second else f"a list of {first}, and {second}"

    def read(self, place: Place) -> tuple[ValueT, OtherT]:
        """Return the two values at a place."""
        if not isinstance(place.node, yaml.SequenceNode) or len(place.node.value) != 2:
            raise place.error(self.wanted)
        first, second = place.items()
        return self.first.read(first), self.second.read(second)

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        items = [self.first.json_schema(), self.second.json_schema()]
        return {"type": "array", "prefixItems": items, "minItems": 2, "maxItems": 2}


@frozen_dataclass(slots=False)
class Field:
    """One key of a record.

    Attributes:
        element: What its value is.
        meaning: What it is for, in words.
        required: Whether it must be there.
        default: The value where it is left out, for the reader of the JSON Schema.
    """

    element: Element[Any]
    meaning: str = ""
    required: bool = False
    default: object = None

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        about = {"description": self.meaning or None, "default": self.default}
        return {**self.element.json_schema(), **{k: v for k, v in about.items() if v is not None}}


@frozen_dataclass(slots=False)
class Record(Element[dict[str, Any]]):
    """A mapping with known keys; keys left out are left out of the value.

    Attributes:
        fields: The keys.
        exactly_one: Whether exactly one of them must be there.
        one_at_least: Keys of which one at least must be there.
    """

    fields: Mapping[str, Field]
    exactly_one: bool = False
    one_at_least: tuple[str, ...] = ()

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return f"a mapping with {'exactly one' if self.exactly_one else 'some'} of the keys {', '.join(self.fields)}"

    def read(self, place: Place) -> dict[str, Any]:
        """Return the values of the keys that are there."""
        if not isinstance(place.node, yaml.MappingNode):
            raise place.error(self.wanted)
        places = dict(self._known(place))
        if self.exactly_one and len(places) != 1:
            raise place.error(self.wanted, " and ".join(places) or "none of them")
        for name, field in self.fields.items():
            if field.required and name not in places:
                raise place.below(name).error(field.element.wanted, "no such key")
        if self.one_at_least and not places.keys() & set(self.one_at_least):
            first = self.one_at_least[0]
            raise place.below(first).error(self.fields[first].element.wanted, "no such key")
        return {name: self.fields[name].element.read(entry) for name, entry in places.items()}

    def _known(self, place: Place) -> Iterator[tuple[str, Place]]:
        for (name, entry), (key, _) in zip(place.entries(), place.node.value, strict=True):
            if name not in self.fields:
                wanted = f"one of the keys {', '.join(self.fields)}{nearest_hint(name, self.fields)}"
                raise dataclasses.replace(entry, node=key).error(wanted, f"the unknown key '{shortened(name)}'")
            yield name, entry

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        out: dict[str, object] = {
            "type": "object",
            "properties": {name: field.json_schema() for name, field in self.fields.items()},
            "additionalProperties": False,
        }
        required = [name for name, field in self.fields.items() if field.required]
        out |= {"required": required} if required else {}
        out |= {"anyOf": [{"required": [name]} for name in self.one_at_least]} if self.one_at_least else {}
        return {**out, "minProperties": 1, "maxProperties": 1} if self.exactly_one else out


def only_value(value: Mapping[str, ValueT], _: Place) -> ValueT:
    """Return the value of the one key that a record of `exactly_one` has."""
    return next(iter(value.values()))


@frozen_dataclass(slots=False)
class MapOf(Element[dict[str, ValueT]]):
    """A mapping with free keys.

    Attributes:
        key: What each key is.
        value: What each value is.
    """

    key: Text
    value: Element[ValueT]

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return f"a mapping whose keys are each {self.key.wanted}"

    def read(self, place: Place) -> dict[str, ValueT]:
        """Return the mapping at a place."""
        if not isinstance(place.node, yaml.MappingNode):
            raise place.error(self.wanted)
        out = {}
        for (name, entry), (key, _) in zip(place.entries(), place.node.value, strict=True):
            self.key.read(dataclasses.replace(entry, node=key))
            out[name] = self.value.read(entry)
        return out

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {
            "type": "object",
            "propertyNames": {"pattern": f"^{self.key.pattern}$"},
            "additionalProperties": self.value.json_schema(),
        }


@frozen_dataclass(slots=False)
class OrNull(Element[ValueT | None]):
    """Something, or null for none of it.

    Attributes:
        element: What it is where it is not null.
    """

    element: Element[ValueT]

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return f"{self.element.wanted} or null"

    def read(self, place: Place) -> ValueT | None:
        """Return the value at a place, None for null."""
        return None if kind(place.node) == "null" else self.element.read(place)

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"anyOf": [self.element.json_schema(), {"type": "null"}]}


@frozen_dataclass(slots=False)
class Either(Element[ValueT]):
    """A scalar or a mapping, each with a meaning of its own."""

    scalar: Element[ValueT]
    mapping: Element[ValueT]

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return f"{self.scalar.wanted} or {self.mapping.wanted}"

    def read(self, place: Place) -> ValueT:
        """Return what the scalar or the mapping at a place means."""
        if isinstance(place.node, yaml.MappingNode):
            return self.mapping.read(place)
        if isinstance(place.node, yaml.SequenceNode) or kind(place.node) == "null":
            raise place.error(self.wanted)
        return self.scalar.read(place)

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"anyOf": [self.scalar.json_schema(), self.mapping.json_schema()]}
