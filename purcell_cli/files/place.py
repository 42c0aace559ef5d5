"""A place in a YAML document: what stands there, and the messages about it."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from pathlib import Path

import yaml

from purcell_cli.errors import InputError
from purcell_cli.files.core_schema import OTHERWISE, TAG, core_kind, core_number, read_otherwise
from purcell_cli.frozen_dataclass import frozen_dataclass

SCALAR_NAMES = {"bool": "the truth value", "int": "the number", "float": "the number"}
"""What messages call a scalar that YAML reads as other than text, by its kind."""


def shortened(text: str, most: int = 60) -> str:
    """Return a text on one line, safe to print and cut to a number of characters."""
    line = "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text[: most + 1])
    return line if len(line) <= most else line[: most - 3] + "..."


def key_path(key: str, step: str | int) -> str:
    """Return the path of an entry or item below the key path of its parent."""
    if isinstance(step, int):
        return f"{key}[{step}]"
    return f"{key}.{shortened(step, 40)}" if key else shortened(step, 40)


def input_error(file: str, line: int, key: str, wanted: str, found: str) -> InputError:
    """Return the error that every fault in a document is reported with."""
    return InputError(f"{file}:{line}: {key or 'the document'}: wanted {wanted}, found {found}")


def kind(node: yaml.Node) -> str:
    """Return the short name of a node's tag, such as 'str' or 'int'."""
    return str(node.tag).removeprefix(TAG)


def described(node: yaml.Node) -> str:
    """Return what a node is, in words."""
    if isinstance(node, yaml.SequenceNode):
        return f"a list of {len(node.value)}"
    if isinstance(node, yaml.MappingNode):
        return "a mapping"
    if kind(node) == "null":
        return "nothing"
    if kind(node) in {OTHERWISE, "int", "float"} and core_kind(node.value) == OTHERWISE:
        return read_otherwise(node.value, shortened(node.value))
    if kind(node) in SCALAR_NAMES:
        return f"{SCALAR_NAMES[kind(node)]} {shortened(node.value) or repr('')}"
    return f"the text '{shortened(node.value)}'"


def finite_number(node: yaml.Node) -> float | None:
    """Return the finite number that a node is, or None."""
    if not isinstance(node, yaml.ScalarNode) or kind(node) not in {"int", "float"}:
        return None
    value = None if core_kind(node.value) == OTHERWISE else core_number(node.value, kind(node))
    return value if value is not None and math.isfinite(value) else None


@frozen_dataclass
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
        return input_error(self.file, self.line, self.key, wanted, found or described(self.node))

    def below(self, step: str | int, node: yaml.Node | None = None) -> Place:
        """Return the place of an entry or item; without a node it keeps the parent's line."""
        return dataclasses.replace(self, key=key_path(self.key, step), node=node or self.node)

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
