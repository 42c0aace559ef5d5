"""What a YAML document of the project may say: elements that read it and print themselves as JSON Schema.

An element reads one node of a YAML document at a `Place` and returns a checked value. Whatever is
wrong is an `InputError` that reads ``FILE:LINE: KEY: wanted ..., found ...``. Nodes are kept until
the value is made, so that a later check (a matrix that is no rotation) still knows its line.
"""

from __future__ import annotations

import abc
import dataclasses
import difflib
import math
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Generic, TypeVar

import yaml
from yaml.constructor import SafeConstructor

from purcell_cli.errors import InputError, ParameterError

T = TypeVar("T")
T_co = TypeVar("T_co", covariant=True)
V = TypeVar("V")

DIALECT = "https://json-schema.org/draft/2020-12/schema"
"""The JSON Schema dialect that `Document.json_schema` is written in."""

_TAG = "tag:yaml.org,2002:"
_LONGEST_NUMBER = 100
_KINDS = {"bool": "the truth value", "int": "the number", "float": "the number", "timestamp": "the date"}
_UNPRINTABLE = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff]")
_CONSTRUCTOR = SafeConstructor()


def shortened(text: str, most: int = 60) -> str:
    """Return a text on one line, safe to print and cut to a number of characters."""
    line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text[: most + 1])
    return line if len(line) <= most else line[: most - 3] + "..."


def joined(key: str, step: str | int) -> str:
    """Return the path of an entry or item below the key path of its parent."""
    if isinstance(step, int):
        return f"{key}[{step}]"
    return f"{key}.{shortened(step, 40)}" if key else shortened(step, 40)


def message(file: str, line: int, key: str, wanted: str, found: str) -> InputError:
    """Return the error that every fault in a document is reported with."""
    return InputError(f"{file}:{line}: {key or 'the document'}: wanted {wanted}, found {found}")


def nearest(name: str, choices: Sequence[str]) -> str:
    """Return " (nearest: ...)" for the choice most like a name, or nothing if none is."""
    close = difflib.get_close_matches(name[:100], choices, n=1)
    return f" (nearest: {close[0]})" if close else ""


def kind(node: yaml.Node) -> str:
    """Return the short name of a node's tag, such as 'str' or 'int'."""
    return str(node.tag).removeprefix(_TAG)


def described(node: yaml.Node) -> str:
    """Return what a node is, in words."""
    if isinstance(node, yaml.SequenceNode):
        return f"a list of {len(node.value)}"
    if isinstance(node, yaml.MappingNode):
        return "a mapping"
    if kind(node) == "null":
        return "nothing"
    if kind(node) in _KINDS:
        return f"{_KINDS[kind(node)]} {shortened(node.value) or repr('')}"
    return f"the text '{shortened(node.value)}'"


def number(node: yaml.Node) -> float | None:
    """Return the finite number that a node is, or None."""
    if not isinstance(node, yaml.ScalarNode) or kind(node) not in {"int", "float"} or len(node.value) > _LONGEST_NUMBER:
        return None
    read = _CONSTRUCTOR.construct_yaml_int if kind(node) == "int" else _CONSTRUCTOR.construct_yaml_float
    try:
        value = float(read(node))
    except (ValueError, OverflowError, IndexError):
        return None
    return value if math.isfinite(value) else None


@dataclasses.dataclass(frozen=True, slots=True)
class Place:
    """A node of a document and where it stands.

    Attributes:
        file: The document's name, as messages show it.
        node: The node.
        key: Path of keys from the document's top; empty at the top.
        folder: The folder that relative paths in the document start from.
    """

    file: str
    node: yaml.Node
    key: str = ""
    folder: Path = Path()

    @property
    def line(self) -> int:
        """The line that the node starts on, from 1."""
        return int(self.node.start_mark.line) + 1

    def error(self, wanted: str, found: str | None = None) -> InputError:
        """Return the error of a node that is not what is wanted."""
        return message(self.file, self.line, self.key, wanted, found or described(self.node))

    def below(self, step: str | int, node: yaml.Node | None = None) -> Place:
        """Return the place of an entry or item; without a node it keeps the parent's line."""
        return dataclasses.replace(self, key=joined(self.key, step), node=node or self.node)

    def at(self, *steps: str | int) -> Place:
        """Return the place that keys and indices lead to; what is not there keeps the parent's line."""
        place = self
        for step in steps:
            place = place.below(step, _child(place.node, step))
        return place

    def items(self) -> list[Place]:
        """Return the places of a list's items."""
        return [self.below(k, node) for k, node in enumerate(self.node.value)]

    def entries(self) -> Iterator[tuple[str, Place]]:
        """Return the keys of a mapping and the places of their values.

        Raises:
            InputError: A key that is no text, or stands twice.
        """
        seen: dict[str, int] = {}
        for key, value in self.node.value:
            if kind(key) != "str" or not isinstance(key, yaml.ScalarNode):
                place = dataclasses.replace(self, node=key)
                merge = kind(key) == "merge"
                raise place.error("a key that is a plain name", "the merge key <<" if merge else described(key))
            if key.value in seen:
                raise self.below(key.value, key).error("each key once", f"it again (first on line {seen[key.value]})")
            place = self.below(key.value, key)
            seen[key.value] = place.line
            yield key.value, dataclasses.replace(place, node=value)


def _child(node: yaml.Node, step: str | int) -> yaml.Node | None:
    """Return the node that a key or index leads to, if there is one."""
    if isinstance(step, int):
        return node.value[step] if isinstance(node, yaml.SequenceNode) and step < len(node.value) else None
    pairs = node.value if isinstance(node, yaml.MappingNode) else []
    return next((value for key, value in pairs if key.value == step), None)


class Schema(abc.ABC, Generic[T_co]):
    """One element of a document."""

    @property
    @abc.abstractmethod
    def wanted(self) -> str:
        """What the element wants to find, in words."""

    @abc.abstractmethod
    def read(self, place: Place) -> T_co:
        """Return the value at a place.

        Raises:
            InputError: The value is not what is wanted.
        """

    @abc.abstractmethod
    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema (draft 2020-12)."""


@dataclasses.dataclass(frozen=True)
class Number(Schema[float]):
    """A finite number.

    Attributes:
        above: It is more than this.
        at_least: It is this or more.
        at_most: It is this or less.
        nonzero: It is not 0.
    """

    above: float | None = None
    at_least: float | None = None
    at_most: float | None = None
    nonzero: bool = False

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        parts = [
            f"above {self.above:g}" if self.above is not None else "",
            f"at least {self.at_least:g}" if self.at_least is not None else "",
            f"at most {self.at_most:g}" if self.at_most is not None else "",
            "other than 0" if self.nonzero else "",
        ]
        return " ".join(["a finite number", " and ".join(p for p in parts if p)]).strip()

    def read(self, place: Place) -> float:
        """Return the number at a place."""
        value = number(place.node)
        if value is None or not self._allows(value):
            raise place.error(self.wanted)
        return value

    def _allows(self, value: float) -> bool:
        return (
            (self.above is None or value > self.above)
            and (self.at_least is None or value >= self.at_least)
            and (self.at_most is None or value <= self.at_most)
            and not (self.nonzero and value == 0.0)
        )

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        limits = {"exclusiveMinimum": self.above, "minimum": self.at_least, "maximum": self.at_most}
        out: dict[str, object] = {"type": "number", **{k: v for k, v in limits.items() if v is not None}}
        return {**out, "not": {"const": 0}} if self.nonzero else out


@dataclasses.dataclass(frozen=True)
class Whole(Schema[int]):
    """A whole number.

    Attributes:
        at_least: It is this or more.
        at_most: It is this or less.
    """

    at_least: int
    at_most: int

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return f"a whole number at least {self.at_least} and at most {self.at_most}"

    def read(self, place: Place) -> int:
        """Return the number at a place."""
        value = number(place.node)
        if value is None or not value.is_integer() or not self.at_least <= value <= self.at_most:
            raise place.error(self.wanted)
        return int(value)

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"type": "integer", "minimum": self.at_least, "maximum": self.at_most}


@dataclasses.dataclass(frozen=True)
class Flag(Schema[bool]):
    """true or false."""

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return "true or false"

    def read(self, place: Place) -> bool:
        """Return the truth value at a place."""
        value = SafeConstructor.bool_values.get(str(place.node.value).lower()) if kind(place.node) == "bool" else None
        if value is None:
            raise place.error(self.wanted)
        return bool(value)

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"type": "boolean"}


@dataclasses.dataclass(frozen=True)
class Text(Schema[str]):
    """A text that is not empty.

    Attributes:
        pattern: A regular expression for the whole of it.
        meaning: What the text is, in words.
    """

    pattern: str = r"[\s\S]+"
    meaning: str = "a text"

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return self.meaning

    def read(self, place: Place) -> str:
        """Return the text at a place."""
        if kind(place.node) != "str":
            quote = " (in quotes it is a text)" if kind(place.node) in _KINDS else ""
            raise place.error(self.wanted, described(place.node) + quote)
        text = str(place.node.value)
        if _UNPRINTABLE.search(text) or not re.fullmatch(self.pattern, text):
            raise place.error(self.wanted)
        return text

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"type": "string", "pattern": f"^{self.pattern}$"}


@dataclasses.dataclass(frozen=True)
class Choice(Schema[str]):
    """One of a few words."""

    options: tuple[str, ...]

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return f"one of {', '.join(self.options)}"

    def read(self, place: Place) -> str:
        """Return the word at a place."""
        if kind(place.node) != "str":
            raise place.error(self.wanted)
        if place.node.value not in self.options:
            raise place.error(self.wanted + nearest(place.node.value, self.options))
        return str(place.node.value)

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"enum": list(self.options)}


@dataclasses.dataclass(frozen=True)
class ListOf(Schema[list[T]]):
    """A list.

    Attributes:
        item: What each item is.
        length: How many items, if that is fixed.
        at_least: How many items at least.
    """

    item: Schema[T]
    length: int | None = None
    at_least: int = 0

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        least = f" of {self.at_least} or more" if self.at_least else ""
        count = f" of {self.length}" if self.length is not None else least
        return f"a list{count}, each {self.item.wanted}"

    def read(self, place: Place) -> list[T]:
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


@dataclasses.dataclass(frozen=True)
class Pair(Schema[tuple[T, V]], Generic[T, V]):
    """A list of two, each with a meaning of its own.

    Attributes:
        first: What the first is.
        second: What the second is.
    """

    first: Schema[T]
    second: Schema[V]

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return f"a list of {self.first.wanted}, and {self.second.wanted}"

    def read(self, place: Place) -> tuple[T, V]:
        """Return the two values at a place."""
        if not isinstance(place.node, yaml.SequenceNode) or len(place.node.value) != 2:
            raise place.error(self.wanted)
        first, second = place.items()
        return self.first.read(first), self.second.read(second)

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        items = [self.first.json_schema(), self.second.json_schema()]
        return {"type": "array", "prefixItems": items, "minItems": 2, "maxItems": 2}


@dataclasses.dataclass(frozen=True)
class Field:
    """One key of a record.

    Attributes:
        schema: What its value is.
        meaning: What it is for, in words.
        required: Whether it must be there.
        default: The value where it is left out, for the reader of the JSON Schema.
    """

    schema: Schema[Any]
    meaning: str = ""
    required: bool = False
    default: object = None

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        about = {"description": self.meaning or None, "default": self.default}
        return {**self.schema.json_schema(), **{k: v for k, v in about.items() if v is not None}}


@dataclasses.dataclass(frozen=True)
class Record(Schema[dict[str, Any]]):
    """A mapping with known keys; keys left out are left out of the value.

    Attributes:
        fields: The keys.
        exactly_one: Whether exactly one of them must be there.
    """

    fields: Mapping[str, Field]
    exactly_one: bool = False

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
                raise place.below(name).error(field.schema.wanted, "no such key")
        return {name: self.fields[name].schema.read(entry) for name, entry in places.items()}

    def _known(self, place: Place) -> Iterator[tuple[str, Place]]:
        for (name, entry), (key, _) in zip(place.entries(), place.node.value, strict=True):
            if name not in self.fields:
                wanted = f"one of the keys {', '.join(self.fields)}{nearest(name, list(self.fields))}"
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
        return {**out, "minProperties": 1, "maxProperties": 1} if self.exactly_one else out


@dataclasses.dataclass(frozen=True)
class MapOf(Schema[dict[str, T]]):
    """A mapping with free keys.

    Attributes:
        key: What each key is.
        value: What each value is.
    """

    key: Text
    value: Schema[T]

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return f"a mapping whose keys are each {self.key.wanted}"

    def read(self, place: Place) -> dict[str, T]:
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
