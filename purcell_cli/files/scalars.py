"""Elements of a document's description that are one scalar: numbers, texts, choices."""

from __future__ import annotations

import re

from purcell_cli.files.core_schema import core_truth
from purcell_cli.files.elements import Element
from purcell_cli.files.number_units import unit_hint
from purcell_cli.files.place import SCALAR_NAMES, Place, described, finite_number, kind
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.wording import nearest_hint

_UNPRINTABLE = re.compile(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff]")
"""Control characters and halves of characters, which no text of a document has."""


@frozen_dataclass(slots=False)
class Number(Element[float]):
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
        value = finite_number(place.node)
        if value is None or not self._allows(value):
            raise place.error(self.wanted, described(place.node) + unit_hint(place))
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


@frozen_dataclass(slots=False)
class Whole(Element[int]):
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
        value = finite_number(place.node)
        if value is None or not value.is_integer() or not self.at_least <= value <= self.at_most:
            raise place.error(self.wanted)
        return int(value)

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"type": "integer", "minimum": self.at_least, "maximum": self.at_most}


@frozen_dataclass(slots=False)
class Flag(Element[bool]):
    """true or false."""

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return "true or false"

    def read(self, place: Place) -> bool:
        """Return the truth value at a place."""
        value = core_truth(str(place.node.value)) if kind(place.node) == "bool" else None
        if value is None:
            raise place.error(self.wanted)
        return value

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"type": "boolean"}


@frozen_dataclass(slots=False)
class Text(Element[str]):
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
            quote = " (in quotes it is a text)" if kind(place.node) in SCALAR_NAMES else ""
            raise place.error(self.wanted, described(place.node) + quote)
        text = str(place.node.value)
        if _UNPRINTABLE.search(text) or not re.fullmatch(self.pattern, text):
            raise place.error(self.wanted)
        return text

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"type": "string", "pattern": f"^{self.pattern}$"}


@frozen_dataclass(slots=False)
class Choice(Element[str]):
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
            raise place.error(self.wanted + nearest_hint(place.node.value, self.options))
        return str(place.node.value)

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"enum": list(self.options)}


NAME = Text(
    r"[A-Za-z0-9_-][A-Za-z0-9._-]{0,99}",
    "a name (at most 100 letters, digits, '-', '_' and '.', not starting with '.')",
)
"""A name that is a file's too: of characters that every file system takes, and short enough for an ending."""
