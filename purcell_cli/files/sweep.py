"""Sweeps: a scenario whose `sweep` gives keys several values stands for one scenario a combination."""

from __future__ import annotations

import dataclasses
import itertools
import math
import re
from collections.abc import Iterator
from typing import Any

import numpy as np
import yaml

from purcell_cli.files.containers import Field, MapOf, Record
from purcell_cli.files.core_schema import TAG
from purcell_cli.files.elements import Element
from purcell_cli.files.place import Place, finite_number, shortened
from purcell_cli.files.scalars import Number, Text, Whole
from purcell_cli.frozen_dataclass import frozen_dataclass

MOST_VARIANTS = 1_000_000
"""Scenarios of a sweep at most: a slip in a count is refused at once, where to solve so many takes days."""

_MOST_VALUES = 100_000
"""Values of one key at most, where only their number stands in the file: their nodes take 20 MB."""

_LONGEST_LABEL = 24
"""Characters that a value adds to a scenario's name at most: four swept keys fit into a name, which has 100."""

_STR, _FLOAT, _MAP = (TAG + name for name in ("str", "float", "map"))

_KEY = r"[a-z][a-z0-9_]*"
_PATH = Text(
    rf"(start|goal|swimmer|workspace_m|obstacles|via|order|follow|expect)(\.{_KEY}|\[[0-9]{{1,4}}\])*",
    "a key path of the scenario, such as swimmer.slenderness or goal.base.position_m[0]",
)

_RANGE = Record(
    {
        "start": Field(Number(), "the first value", required=True),
        "stop": Field(Number(), "the last value", required=True),
        "num": Field(Whole(1, _MOST_VALUES), "how many values, evenly spaced", required=True),
    }
)


@frozen_dataclass
class _Axis:
    """The values of one key; evenly spaced numbers are made only when it is known that they are not too many."""

    node: yaml.Node
    span: dict[str, Any] | None = None

    @property
    def count(self) -> int:
        """How many values there are."""
        return len(self.node.value) if self.span is None else int(self.span["num"])

    def nodes(self) -> list[yaml.Node]:
        """Return the nodes that take the key's place."""
        if self.span is None:
            return list(self.node.value)
        spaced = np.linspace(self.span["start"], self.span["stop"], self.span["num"]).tolist()
        return [yaml.ScalarNode(_FLOAT, repr(x), self.node.start_mark, self.node.end_mark) for x in spaced]


class _Values(Element[_Axis]):
    """The values of one key: a list of anything, or evenly spaced numbers."""

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return "a list of one value or more, or a mapping with the keys start, stop and num"

    def read(self, place: Place) -> _Axis:
        """Return the values at a place."""
        if isinstance(place.node, yaml.SequenceNode) and place.node.value:
            return _Axis(place.node)
        if not isinstance(place.node, yaml.MappingNode):
            raise place.error(self.wanted)
        return _Axis(place.node, _RANGE.read(place))

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"anyOf": [{"type": "array", "minItems": 1}, _RANGE.json_schema()]}


SWEEP = MapOf(_PATH, _Values())
"""The element for a scenario's sweep."""


@frozen_dataclass
class Variant:
    """One scenario that a document stands for.

    Attributes:
        place: The top of the document, the sweep's values put in.
        suffix: What its name has besides the document's own; empty without a sweep.
        values: What each swept key is.
    """

    place: Place
    suffix: str = ""
    values: dict[str, Any] = dataclasses.field(default_factory=dict)


def variants(top: Place) -> Iterator[Variant]:
    """Return the scenarios that a document stands for, one after the other: the last key's values change first.

    Args:
        top: The top of a scenario's document.

    Raises:
        InputError: The sweep does not say what is wanted, or is too large.
    """
    axes = _axes(top)
    if not axes:
        yield Variant(top)
        return
    pairs = top.node.value
    bare = yaml.MappingNode(_MAP, [p for p in pairs if p[0].value != "sweep"], top.node.start_mark, top.node.end_mark)
    base = dataclasses.replace(top, node=bare)
    nodes = [axis.nodes() for axis in axes.values()]
    labelled = [list(zip(_labels(values), values, strict=True)) for values in nodes]
    for combination in itertools.product(*labelled):
        place = base
        for path, (_, node) in zip(axes, combination, strict=True):
            place = dataclasses.replace(base, node=_with(place, _steps(path), node, path))
        suffix = "".join(f"-{label}" for label, _ in combination)
        values = {path: _plain(node) for path, (_, node) in zip(axes, combination, strict=True)}
        name = place.at("name").node
        if isinstance(name, yaml.ScalarNode):
            text = yaml.ScalarNode(name.tag, name.value + suffix, name.start_mark, name.end_mark)
            place = dataclasses.replace(base, node=_with(place, ["name"], text, "name"))
        yield Variant(place, suffix, values)


def combinations(top: Place) -> int:
    """Return how many scenarios a document stands for.

    Raises:
        InputError: The sweep does not say what is wanted, or is too large.
    """
    return math.prod(axis.count for axis in _axes(top).values())


def _axes(top: Place) -> dict[str, _Axis]:
    """Return the values of each swept key; none where there is no sweep."""
    sweep = top.at("sweep")
    if sweep.node is top.node:
        return {}
    axes = SWEEP.read(sweep)
    count = math.prod(axis.count for axis in axes.values())
    if not axes or count > MOST_VARIANTS:
        found = "none" if not axes else str(count) if count < 10**15 else "many more"
        raise sweep.error(f"1 to {MOST_VARIANTS} combinations", found)
    return axes


def _steps(path: str) -> list[str | int]:
    """Return a key path as keys and indices."""
    return [int(index) if index else key for key, index in re.findall(rf"({_KEY})|\[([0-9]+)\]", path)]


def _with(place: Place, steps: list[str | int], value: yaml.Node, path: str) -> yaml.Node:
    """Return a node like that at a place, with a value where the steps lead; mappings on the way are made."""
    if not steps:
        return value
    node, (step, *rest) = place.node, steps
    if isinstance(step, int):
        if not isinstance(node, yaml.SequenceNode) or step >= len(node.value):
            raise place.error(f"a list of {step + 1} or more, for the sweep's key {path}")
        items = list(node.value)
        items[step] = _with(place.below(step, items[step]), rest, value, path)
        return yaml.SequenceNode(node.tag, items, node.start_mark, node.end_mark)
    if not isinstance(node, yaml.MappingNode):
        raise place.error(f"a mapping, for the sweep's key {path}")
    pairs = list(node.value)
    at = next((k for k, (key, _) in enumerate(pairs) if key.value == step), len(pairs))
    if at == len(pairs):
        empty = yaml.MappingNode(_MAP, [], value.start_mark, value.end_mark)
        pairs.append((yaml.ScalarNode(_STR, step, value.start_mark, value.end_mark), empty))
    key, old = pairs[at]
    pairs[at] = (key, _with(place.below(step, old), rest, value, path))
    return yaml.MappingNode(node.tag, pairs, node.start_mark, node.end_mark)


def _labels(nodes: list[yaml.Node]) -> list[str]:
    """Return a short text for each value of a key, all different: the value where that can be, else its number."""
    for read in (lambda x: f"{x:.6g}", repr):
        texts = [_label(node, read) for node in nodes]
        if len({text.casefold() for text in texts}) == len(texts) and all(0 < len(t) <= _LONGEST_LABEL for t in texts):
            return texts
    width = len(str(len(nodes) - 1))
    return [f"{k:0{width}d}" for k in range(len(nodes))]


def _label(node: yaml.Node, read: Any) -> str:
    if not isinstance(node, yaml.ScalarNode):
        return ""
    value = finite_number(node)
    return re.sub(r"[^A-Za-z0-9._-]", "_", str(node.value) if value is None else read(value))


def _plain(node: yaml.Node) -> Any:
    """Return a node's value as plain data, for reports: numbers, texts, lists and mappings."""
    if isinstance(node, yaml.SequenceNode):
        return [_plain(item) for item in node.value]
    if isinstance(node, yaml.MappingNode):
        return {shortened(str(key.value)): _plain(value) for key, value in node.value}
    value = finite_number(node)
    return shortened(node.value) if value is None else value
