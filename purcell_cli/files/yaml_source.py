"""The YAML files that users write: configurations, swimmers, gaits and scenarios.

Each document is described once, in `SCHEMAS`; that description reads it and prints itself as JSON
Schema. Whatever is wrong with a file is an `InputError`, raised quickly and in little memory.
"""

from __future__ import annotations

import dataclasses
import itertools
import os
import re
import stat
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np
import yaml
from yaml.composer import Composer
from yaml.reader import Reader

from purcell_cli.errors import InputError
from purcell_cli.files import elements
from purcell_cli.files.elements import (
    Choice,
    Document,
    Either,
    Field,
    Flag,
    ListOf,
    Made,
    MapOf,
    Number,
    Place,
    Record,
    Schema,
    Text,
    Whole,
)
from purcell_cli.files.sweep import SWEEP
from purcell_cli.gaits.gait import MOTIONS, Gait, Guess, Turn
from purcell_cli.gaits.shape_curves import MOST_STEPS, Curve, Fourier, WayPoints, size_rad
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, from_euler, from_matrix, from_quaternion
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.primitives import CONTROL_NAMES, control_index
from purcell_cli.mechanics.swimmer import LIMITS, Swimmer
from purcell_cli.motion.workspace import Workspace

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""libyaml's parser is twenty times quicker; PyYAML's own is for where it is missing."""

T = TypeVar("T")

MOST_BYTES = 1 << 20
MOST_LEVELS = 20
MOST_NODES = 20_000

_CORE = {
    yaml.ScalarEvent: {f"tag:yaml.org,2002:{name}" for name in ("str", "int", "float", "bool", "null")},
    yaml.SequenceStartEvent: {"tag:yaml.org,2002:seq"},
    yaml.MappingStartEvent: {"tag:yaml.org,2002:map"},
}
_EXPONENT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)[eE][-+]?[0-9]+$")
_TERM = re.compile(
    r"\s*(?P<sign>[-+])?\s*(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)?"
    r"\s*(?P<times>\*)?\s*(?P<symbol>[a-z][0-9]*)?\s*"
)
_LONGEST_EXPRESSION = 200
_FARTHEST_M = 1e15
"""Coordinates go no farther than this, so that none can overflow."""
_SYMBOL = Text(r"[a-z][0-9]*", "a symbol (one lower-case letter, digits may follow)")
NAME = Text(
    r"[A-Za-z0-9_-][A-Za-z0-9._-]{0,99}",
    "a name (at most 100 letters, digits, '-', '_' and '.', not starting with '.')",
)


class _UnreadableError(Exception):
    """A file that cannot be read; the message says why."""


# Reading and composing -----------------------------------------------------------------------


def _bytes(path: Path) -> bytes:
    """Return what a regular file holds, at most one byte more than is allowed."""
    try:
        mode = path.stat().st_mode
        if not stat.S_ISREG(mode):
            raise _UnreadableError("a directory" if stat.S_ISDIR(mode) else "something that is no regular file")
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        with os.fdopen(descriptor, "rb") as stream:
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                raise _UnreadableError("something that is no regular file")
            return stream.read(MOST_BYTES + 1) or b""
    except OSError as error:
        raise _UnreadableError(f"none ({error.strerror or error})") from error
    except ValueError as error:
        raise _UnreadableError(f"none ({error})") from error


def _standard_input() -> bytes:
    """Return what standard input holds, at most one byte more than is allowed."""
    try:
        return sys.stdin.buffer.read(MOST_BYTES + 1)
    except (OSError, ValueError, AttributeError) as error:
        raise _UnreadableError(f"standard input that cannot be read ({error})") from error


def _decoded(data: bytes, file: str) -> str:
    """Return the text of a file's bytes.

    Raises:
        InputError: Too many bytes, not UTF-8, or control characters.
    """
    if len(data) > MOST_BYTES:
        raise elements.message(file, 1, "", f"at most {MOST_BYTES} bytes", "more")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise elements.message(file, line, "", "UTF-8", f"the byte 0x{data[error.start]:02x}") from error
    bad = Reader.NON_PRINTABLE.search(text)
    if bad:
        line = text.count("\n", 0, bad.start()) + 1
        raise elements.message(file, line, "", "printable characters", f"the character U+{ord(bad.group()):04X}")
    return text


class _Guard(Composer):
    """Composes nodes from events and refuses tags, depths and sizes that no document needs.

    Attributes:
        file: The document's name, as messages show it.
        keys: The key path of the node at hand, below those of its parents.
        count: Nodes so far, aliases expanded.
        sizes: How many nodes each finished node expands to.
    """

    peek_event: Callable[[], Any]

    def __init__(self, file: str) -> None:
        Composer.__init__(self)
        self.file = file
        self.keys: list[str] = [""]
        self.count = 0
        self.sizes: dict[yaml.Node, int] = {}

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Return the next node; the key path stays where it is if that fails."""
        self.keys.append(self._key(parent, index))
        before = self.count
        self._admit(self.peek_event())
        node = super().compose_node(parent, index)
        if node is not None:
            self.sizes.setdefault(node, self.count - before)
        self.keys.pop()
        return node

    def _key(self, parent: yaml.Node | None, index: Any) -> str:
        if isinstance(parent, yaml.SequenceNode):
            return elements.joined(self.keys[-1], index)
        return elements.joined(self.keys[-1], index.value) if isinstance(index, yaml.ScalarNode) else self.keys[-1]

    def _admit(self, event: Any) -> None:
        self.count += self._alias_size(event) if isinstance(event, yaml.AliasEvent) else 1
        if self.count > MOST_NODES:
            raise self._error(event, f"at most {MOST_NODES} values, aliases expanded", "more")
        if len(self.keys) - 1 > MOST_LEVELS:
            raise self._error(event, f"at most {MOST_LEVELS} levels of nesting", "more")
        tag = getattr(event, "tag", None)
        if tag not in {None, "!"} and tag not in _CORE[type(event)]:
            raise self._error(event, "plain YAML", f"the tag {elements.shortened(tag)}")

    def _alias_size(self, event: Any) -> int:
        target = self.anchors.get(event.anchor)
        if target is not None and target not in self.sizes:
            raise self._error(event, "a finite value", f"the alias *{elements.shortened(event.anchor)} inside itself")
        return self.sizes[target] if target is not None else 0

    def _error(self, event: Any, wanted: str, found: str) -> InputError:
        return elements.message(self.file, event.start_mark.line + 1, self.keys[-1], wanted, found)


class _Nodes(_Guard, _Loader):  # type: ignore[misc]  # the base is known only when it runs
    """The guarded loader.

    Args:
        text: The document.
        file: Its name, as messages show it.
    """

    def __init__(self, text: str, file: str) -> None:
        _Loader.__init__(self, text)
        _Guard.__init__(self, file)


_Nodes.add_implicit_resolver("tag:yaml.org,2002:float", _EXPONENT, list("-+.0123456789"))


def _composed(text: str, file: str) -> yaml.Node | None:
    """Return the one document of a text, None if it is empty.

    Raises:
        InputError: The text is malformed, or more than one document, or breaks a limit.
    """
    keys = [""]
    try:
        nodes = _Nodes(text, file)
        keys = nodes.keys
        root = nodes.get_single_node()
    except InputError:
        raise
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        fault = elements.shortened(", ".join(filter(None, (error.context, error.problem))), 120)
        line = mark.line + 1 if mark else 1
        if "nesting depth" in str(error.problem):  # a limit of PyYAML's own, from 6.0.4 on, met before ours
            raise elements.message(file, line, keys[-1], f"at most {MOST_LEVELS} levels of nesting", "more") from error
        raise elements.message(file, line, keys[-1], "one YAML document", f"a fault ({fault})") from error
    except (yaml.YAMLError, ValueError, OverflowError, RecursionError) as error:
        raise elements.message(file, 1, keys[-1], "one YAML document", "one that cannot be read") from error
    return None if root is None or (elements.kind(root) == "null" and not root.value) else root


def _read(document: Document[T], data: bytes, name: str, folder: Path) -> T:
    """Return what the bytes of a file say."""
    defaults = "" if "required" in document.json_schema() else " ({} for the defaults)"
    return document.read(_top(data, name, folder, document.wanted + defaults))


def _top(data: bytes, name: str, folder: Path, wanted: str) -> Place:
    """Return the top of the document in the bytes of a file."""
    file = elements.shortened(name, 1000)
    root = _composed(_decoded(data, file), file)
    if root is None:
        raise elements.message(file, 1, "", wanted, "an empty file")
    return Place(file, root, "", folder)


def load(path: Path | str, document: Document[T]) -> T:
    """Return what a file says of one kind of document; the path - is standard input.

    Raises:
        InputError: The file cannot be read, or does not say what is wanted.
    """
    return _read(document, *_contents(path))


def top(path: Path | str, wanted: str = "a mapping") -> Place:
    """Return the top of a YAML file, unread but composed and found harmless; the path - is standard input.

    Args:
        path: The file.
        wanted: What it is to hold, for the message about an empty file.

    Raises:
        InputError: The file cannot be read, or is no YAML document.
    """
    return _top(*_contents(path), wanted)


def _contents(path: Path | str) -> tuple[bytes, str, Path]:
    """Return what a file holds, its name and the folder that paths in it start from."""
    stdin = str(path) == "-"
    name = "standard input" if stdin else str(path)
    try:
        data = _standard_input() if stdin else _bytes(Path(path))
    except _UnreadableError as error:
        raise InputError(f"{elements.shortened(name, 1000)}: wanted a readable file, found {error}") from error
    return data, name, Path(path).parent


def _or_path(document: Document[T]) -> Schema[T]:
    """Return the element for a document that stands inline or in a file of its own."""

    def load(name: str, place: Place) -> T:
        path = place.folder / name
        try:
            data = _bytes(path)
        except _UnreadableError as error:
            raise place.error("the path of a readable file", f"{error} at '{elements.shortened(str(path))}'") from error
        return _read(document, data, str(path), path.parent)

    return Either(Made(Text(meaning="the path of a file"), load), document.schema)


# Configurations and swimmers -----------------------------------------------------------------


def _rotation(length: int, item: Schema[Any], make: Callable[[Any], Array]) -> Schema[Array]:
    """Return the element for a rotation made from a list of items."""

    def made(value: list[Any], _: Place) -> Array:
        with np.errstate(all="ignore"):
            return make(np.array(value, dtype=np.float64))

    return Made(ListOf(item, length), made)


def _only(value: dict[str, T], _: Place) -> T:
    """Return the value of the only key."""
    return next(iter(value.values()))


_ORIENTATION: Schema[Array] = Made(
    Record(
        {
            "euler_deg": Field(_rotation(3, Number(), lambda e: from_euler(np.radians(e))), "[psi, theta, phi] [deg]"),
            "euler_rad": Field(_rotation(3, Number(), from_euler), "[psi, theta, phi] [rad]"),
            "quaternion_wxyz": Field(_rotation(4, Number(), from_quaternion), "unit quaternion"),
            "matrix": Field(_rotation(3, ListOf(Number(), 3), from_matrix), "rotation matrix, rows first"),
        },
        exactly_one=True,
    ),
    _only,
)

_COORDINATE = Number(at_least=-_FARTHEST_M, at_most=_FARTHEST_M)

_BASE = Record(
    {
        "position_m": Field(ListOf(_COORDINATE, 3), "position in the world [m]", default=[0.0, 0.0, 0.0]),
        "orientation": Field(_ORIENTATION, "orientation in the world; left out, the world's"),
    }
)


def _configuration(value: dict[str, Any], _: Place) -> Configuration:
    level = np.eye(3)
    base = value.get("base", {})
    pose = se3.pose(base.get("orientation", level), base.get("position_m", np.zeros(3)))
    return Configuration(pose, np.stack([value.get("limb1", level), value.get("limb2", level)]))


def _within(above: float, at_most: float) -> Number:
    """Return the element for a number within a pair of `LIMITS`."""
    return Number(above=above, at_most=at_most)


def _swimmer(value: dict[str, float], _: Place) -> Swimmer:
    return Swimmer(**value)


_CONFIGURATION_FIELDS = {
    "base": Field(_BASE, "the base link"),
    "limb1": Field(_ORIENTATION, "limb 1 in the base; left out, collinear"),
    "limb2": Field(_ORIENTATION, "limb 2 in the base; left out, collinear"),
}

_CONFIGURATION = Document(
    "A configuration of the swimmer (start.yaml)", Made(Record(_CONFIGURATION_FIELDS), _configuration)
)

_CORNER = ListOf(_COORDINATE, 3)
WORKSPACE: Schema[Workspace] = Made(
    Record(
        {
            "min": Field(_CORNER, "the corner of least x, y and z [m]", required=True),
            "max": Field(_CORNER, "the opposite corner [m]", required=True),
        }
    ),
    lambda value, _: Workspace(**value),
)
"""The element for a box that the links stay in."""

_WORKSPACE_FIELD = {"workspace_m": Field(WORKSPACE, "a box that all three links stay in; left out, there is none")}


@dataclasses.dataclass(frozen=True, slots=True)
class Goal:
    """What a goal file says.

    Attributes:
        configuration: Where to end.
        workspace: The box to stay in on the way, if there is one.
    """

    configuration: Configuration
    workspace: Workspace | None = None


def _goal(value: dict[str, Any], place: Place) -> Goal:
    return Goal(_configuration(value, place), value.get("workspace_m"))


_GOAL = Document(
    "A goal: a configuration of the swimmer (goal.yaml)", Made(Record(_CONFIGURATION_FIELDS | _WORKSPACE_FIELD), _goal)
)

_SWIMMER = Document(
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


# Gaits ---------------------------------------------------------------------------------------


class _Angle(Schema[Mapping[str, float]]):
    """An angle linear in symbols, such as ``2 a - b + 0.1``; the value is {symbol: coefficient}."""

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return "an angle [rad] linear in symbols, such as -a, 2 a - b or 0.5"

    def read(self, place: Place) -> dict[str, float]:
        """Return the coefficients of the expression at a place."""
        constant = elements.number(place.node)
        if constant is not None:
            return {"": constant}
        if elements.kind(place.node) != "str" or len(place.node.value) > _LONGEST_EXPRESSION:
            raise place.error(self.wanted)
        out = linear_terms(place.node.value)
        if out is None:
            raise place.error(self.wanted)
        return out

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"anyOf": [{"type": "number"}, {"type": "string", "pattern": r"^[-+*.0-9a-zE ]+$"}]}


def linear_terms(expression: str) -> dict[str, float] | None:
    """Return a linear expression as {symbol: coefficient}, '' for the constant; None if it is not linear."""
    out: dict[str, float] = {}
    position = 0
    while position < len(expression) or not out:
        term = _TERM.match(expression, position)
        if term is None or not _is_term(term, first=position == 0):
            return None
        value = float(term["number"] or 1.0) * (-1.0 if term["sign"] == "-" else 1.0)
        symbol = term["symbol"] or ""
        out[symbol] = out.get(symbol, 0.0) + value
        position = term.end()
    return out if all(np.isfinite(value) for value in out.values()) else None


def _is_term(term: re.Match[str], *, first: bool) -> bool:
    """Return whether a match of `_TERM` says something, and a sign parts it from the term before."""
    something = term["number"] or term["symbol"]
    both = term["number"] and term["symbol"]
    return bool(something and (first or term["sign"]) and (both or not term["times"]))


def _turn(value: dict[str, Mapping[str, float]], _: Place) -> Turn:
    ((control, coefficients),) = value.items()
    return Turn(control_index(control), coefficients)


_ANGLE = _Angle()
_TURNS = Made(Record({name: Field(_ANGLE) for name in CONTROL_NAMES}, exactly_one=True), _turn)


def _guess(value: dict[str, Any], place: Place) -> Guess:
    amplitudes, values = value["amplitude_rad"], value["value"]
    if any(low >= high for low, high in itertools.pairwise(amplitudes)):
        raise place.at("amplitude_rad").error("amplitudes in ascending order", "others")
    if len(values) != len(amplitudes):
        raise place.at("value").error(f"one value an amplitude, {len(amplitudes)} in all", str(len(values)))
    if min(values) < 0.0 < max(values):
        raise place.at("value").error("values of one sign", "both signs")
    return Guess(tuple(amplitudes), tuple(values), value.get("sharpness_power", 0.0))


_GUESS: Schema[Guess] = Either(
    Made(Number(nonzero=True), lambda value, _: Guess((1.0,), (value,))),
    Made(
        Record(
            {
                "amplitude_rad": Field(ListOf(Number(above=0.0), at_least=1), "ascending [rad]", required=True),
                "value": Field(ListOf(Number(nonzero=True), at_least=1), "the symbol there [rad]", required=True),
                "sharpness_power": Field(Number(), "how it grows with the swimmer's roll sharpness", default=0.0),
            }
        ),
        _guess,
    ),
)

_AMPLITUDE = Record(
    {
        "symbol": Field(_SYMBOL, "the symbol of the amplitude", required=True),
        "means": Field(Text(), "what the amplitude is", required=True),
        "default_rad": Field(Number(above=0.0), "the amplitude where none is asked for [rad]", required=True),
        "is_displacement": Field(Flag(), "whether the displacement along the own axis is the amplitude", default=False),
    }
)


_AXES = ListOf(Number(), 3)


def _series(value: dict[str, Any], place: Place) -> Fourier:
    """Return the Fourier series whose coefficients stand under the joints' names."""
    constant = np.array([value.get("constant", {}).get(name, 0.0) for name in CONTROL_NAMES])
    parts = [value.get(part, {}) for part in ("cosine", "sine")]
    count = max((len(c) for part in parts for c in part.values()), default=0)
    if count == 0:
        raise place.error("a coefficient of cosine or sine", "none")
    cosine, sine = np.zeros((2, count, 6))
    for out, part in zip((cosine, sine), parts, strict=True):
        for name, coefficients in part.items():
            out[: len(coefficients), CONTROL_NAMES.index(name)] = coefficients
    return Fourier(constant, cosine, sine, **{k: value[k] for k in ("steps",) if k in value})


_HARMONICS = Record({name: Field(ListOf(Number(), at_least=1)) for name in CONTROL_NAMES})
_CURVE: Schema[Curve] = Made(
    Record(
        {
            "way_points": Field(
                Made(ListOf(ListOf(_AXES, 2), at_least=2), lambda v, _: WayPoints(np.reshape(v, (-1, 6)))),
                "rotation vectors [roll, pitch, yaw] of limb 1 and limb 2 from the collinear shape [rad]",
            ),
            "fourier": Field(
                Made(
                    Record(
                        {
                            "constant": Field(Record({n: Field(Number()) for n in CONTROL_NAMES}), "mean angles [rad]"),
                            "cosine": Field(_HARMONICS, "coefficients of cos s, cos 2 s, ... of joints [rad]"),
                            "sine": Field(_HARMONICS, "coefficients of sin s, sin 2 s, ... of joints [rad]"),
                            "steps": Field(Whole(8, MOST_STEPS), "straight moves that it is played as", default=256),
                        }
                    ),
                    _series,
                ),
                "a truncated Fourier series of the rotation vectors",
            ),
        },
        exactly_one=True,
    ),
    _only,
)


def _curve_gait(value: dict[str, Any], place: Place) -> Gait:
    """Return a gait that is a closed curve of shapes; its amplitude is how far a limb turns on it."""
    for key in ("amplitude", "approach", "cycle", "free"):
        if key in value:
            raise place.at(key).error("no such key beside a curve", "one")
    if value["moves"] != "none":
        raise place.at("moves").error("none, since a curve is only played", f"'{value['moves']}'")
    size = size_rad(value["curve"])
    if not 0.0 < size <= np.pi:
        raise place.at("curve").error("limbs that turn from the collinear shape by at most pi", f"{size:.6g} rad")
    means = "largest turn of a limb from the collinear shape"
    texts = (value["name"], value["summary"], "none", "a", means)
    return Gait(
        *texts, size, (), also=tuple(value.get("also", ())), source=value.get("source", ""), curve=value["curve"]
    )


def _gait(value: dict[str, Any], place: Place) -> Gait:
    if "curve" in value:
        return _curve_gait(value, place)
    for key in ("amplitude", "cycle"):
        if key not in value:
            raise place.below(key).error(_GAIT_FIELDS[key].schema.wanted, "no such key")
    amplitude = value["amplitude"]
    free = value.get("free", {})
    if amplitude["symbol"] in free:
        found = f"'{amplitude['symbol']}', the amplitude's"
        raise place.at("free", amplitude["symbol"]).error("a symbol of its own", found)
    _check_symbols(value, {amplitude["symbol"], *free}, place)
    return Gait(
        name=value["name"],
        summary=value["summary"],
        moves=value["moves"],
        symbol=amplitude["symbol"],
        means=amplitude["means"],
        default_rad=amplitude["default_rad"],
        cycle=tuple(value["cycle"]),
        approach=tuple(value.get("approach", ())),
        free=free,
        also=tuple(value.get("also", ())),
        source=value.get("source", ""),
        amplitude_is_displacement=amplitude.get("is_displacement", False),
    )


def _check_symbols(value: dict[str, Any], known: set[str], place: Place) -> None:
    """Refuse a turn with an unknown symbol, and a free symbol that no turn uses."""
    used: set[str] = set()
    for part in ("approach", "cycle"):
        for k, turn in enumerate(value.get(part, ())):
            unknown = sorted(set(turn.coefficients) - known - {""})
            if unknown:
                wanted = f"symbols that are the amplitude's or free ({', '.join(sorted(known))})"
                raise place.at(part, k, CONTROL_NAMES[turn.control]).error(wanted, f"'{unknown[0]}'")
            used |= set(turn.coefficients)
    for symbol in value.get("free", {}):
        if symbol not in used:
            raise place.at("free", symbol).error("a symbol that a turn uses", f"'{symbol}', which none does")


_GAIT_FIELDS = {
    "name": Field(NAME, "its name", required=True),
    "also": Field(ListOf(NAME), "other names"),
    "summary": Field(Text(r"[^\n]+", "one line of text"), "one line on what it does", required=True),
    "moves": Field(Choice((*MOTIONS, "none")), "what it is made to do", required=True),
    "amplitude": Field(_AMPLITUDE, "what scales it; wanted with a cycle"),
    "source": Field(Text(), "where it comes from"),
    "approach": Field(ListOf(_TURNS), "turns played once before the cycles and undone once after"),
    "cycle": Field(ListOf(_TURNS, at_least=1), "turns of one cycle; wanted where there is no curve"),
    "free": Field(
        MapOf(_SYMBOL, Made(Record({"guess": Field(_GUESS, "where to start", required=True)}), _only)),
        "symbols to solve for",
    ),
    "curve": Field(_CURVE, "a closed curve of shapes, in place of amplitude, approach, cycle and free"),
}
_GAIT = Document("A stored gait", Made(Record(_GAIT_FIELDS), _gait))


# Scenarios -----------------------------------------------------------------------------------

VERDICTS = ("reached", "not reached", "not found within limits", "error")
"""How a scenario can end."""


@dataclasses.dataclass(frozen=True, slots=True)
class Expect:
    """What a scenario must come to; None asks for nothing beyond the planner's own.

    Attributes:
        verdict: The one of `VERDICTS` it must end with.
        position_tolerance: How far from the goal the base may end, in units of L.
        angle_tolerance_rad: How far from the goal an orientation may end [rad].
        max_joint_travel_rad: How far the joints may turn in sum [rad].
        max_duration_s: How long the motion may take [s].
        min_clearance_m: How far apart the limbs must stay [m].
        error: A part of the message that it must be refused with; the verdict wanted is then "error".
    """

    verdict: str = "reached"
    position_tolerance: float | None = None
    angle_tolerance_rad: float | None = None
    max_joint_travel_rad: float | None = None
    max_duration_s: float | None = None
    min_clearance_m: float | None = None
    error: str | None = None


@dataclasses.dataclass(frozen=True, slots=True)
class Scenario:
    """A reconfiguration to plan and what is expected of it.

    Attributes:
        name: Its name.
        start: Where it starts.
        goal: Where it is to end.
        swimmer: Who swims.
        expect: What it must come to.
        workspace: The box to stay in, if there is one.
    """

    name: str
    start: Configuration
    goal: Configuration
    swimmer: Swimmer = dataclasses.field(default_factory=Swimmer)
    expect: Expect = dataclasses.field(default_factory=Expect)
    workspace: Workspace | None = None


def _expect(value: dict[str, Any], place: Place) -> Expect:
    if "error" in value:
        if value.get("verdict", "error") != "error":
            raise place.at("verdict").error("error, which the key error asks for")
        value = {**value, "verdict": "error"}
    return Expect(**value)


EXPECT: Schema[Expect] = Made(
    Record(
        {
            "verdict": Field(Choice(VERDICTS), "how it must end", default="reached"),
            "position_tolerance": Field(Number(above=0.0), "how far from the goal the base may end, in units of L"),
            "angle_tolerance_rad": Field(Number(above=0.0), "how far from the goal an orientation may end [rad]"),
            "max_joint_travel_rad": Field(Number(at_least=0.0), "how far the joints may turn in sum [rad]"),
            "max_duration_s": Field(Number(at_least=0.0), "how long the motion may take [s]"),
            "min_clearance_m": Field(Number(at_least=0.0), "how far apart the limbs must stay [m]"),
            "error": Field(Text(), "a part of the message that it must be refused with"),
        }
    ),
    _expect,
)
"""The element for what a scenario must come to."""


def _scenario(value: dict[str, Any], place: Place) -> Scenario:
    if "sweep" in value:
        raise place.at("sweep").error("a scenario without a sweep here (purcell batch expands it)", "one")
    goal: Goal = value.pop("goal")
    workspace = value.pop("workspace_m", None)
    if workspace is not None and goal.workspace is not None:
        raise place.at("workspace_m").error("one workspace, the scenario's or its goal's", "both")
    return Scenario(goal=goal.configuration, workspace=workspace or goal.workspace, **value)


_SCENARIO = Document(
    "A scenario",
    Made(
        Record(
            {
                "name": Field(NAME, "its name", required=True),
                "start": Field(_or_path(_CONFIGURATION), "where it starts", required=True),
                "goal": Field(_or_path(_GOAL), "where it is to end", required=True),
                "swimmer": Field(_or_path(_SWIMMER), "who swims; left out, the paper's swimmer"),
                "expect": Field(EXPECT, "what it must come to"),
                **_WORKSPACE_FIELD,
                "sweep": Field(SWEEP, "values for keys; purcell batch makes a scenario of each combination"),
            }
        ),
        _scenario,
    ),
)

SCHEMAS: Mapping[str, Schema[Any]] = MappingProxyType(
    {"start": _CONFIGURATION, "goal": _GOAL, "swimmer": _SWIMMER, "scenario": _SCENARIO, "gait": _GAIT}
)
"""Every kind of document by name."""


def load_configuration(path: Path | str) -> Configuration:
    """Return the configuration of a file (start.yaml); the path - is standard input.

    Raises:
        InputError: The file says no configuration.
    """
    return load(path, _CONFIGURATION)


def load_goal(path: Path | str) -> Goal:
    """Return the goal of a file: its configuration, and its workspace if it has one. The path - is standard input.

    Raises:
        InputError: The file says no goal.
    """
    return load(path, _GOAL)


def load_swimmer(path: Path | str) -> Swimmer:
    """Return the swimmer of a file; the path - is standard input.

    Raises:
        InputError: The file says no swimmer.
    """
    return load(path, _SWIMMER)


def load_gait(path: Path | str) -> Gait:
    """Return the gait of a file; the path - is standard input.

    Raises:
        InputError: The file says no gait.
    """
    return load(path, _GAIT)


def load_scenario(path: Path | str) -> Scenario:
    """Return the scenario of a file; paths in it start from its folder. The path - is standard input.

    Raises:
        InputError: The file, or one that it names, does not say what is wanted.
    """
    return load(path, _SCENARIO)
