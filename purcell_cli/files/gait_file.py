"""Gaits as YAML."""

from __future__ import annotations

import itertools
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from purcell_cli.files.configuration_file import only
from purcell_cli.files.containers import Field, ListOf, MapOf, Record
from purcell_cli.files.documents import Document, Either, Made
from purcell_cli.files.elements import Schema
from purcell_cli.files.place import Place, kind, number
from purcell_cli.files.scalars import NAME, Choice, Flag, Number, Text, Whole
from purcell_cli.files.yaml_source import load
from purcell_cli.gaits.gait import MOTIONS, Gait, Guess, Turn
from purcell_cli.gaits.shape_curves import MOST_STEPS, Curve, Fourier, WayPoints, size_rad
from purcell_cli.mechanics.primitives import CONTROL_NAMES, control_index

_TERM = re.compile(
    r"\s*(?P<sign>[-+])?\s*(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)?"
    r"\s*(?P<times>\*)?\s*(?P<symbol>[a-z][0-9]*)?\s*"
)


_LONGEST_EXPRESSION = 200


_SYMBOL = Text(r"[a-z][0-9]*", "a symbol (one lower-case letter, digits may follow)")


class _Angle(Schema[Mapping[str, float]]):
    """An angle linear in symbols, such as ``2 a - b + 0.1``; the value is {symbol: coefficient}."""

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return "an angle [rad] linear in symbols, such as -a, 2 a - b or 0.5"

    def read(self, place: Place) -> dict[str, float]:
        """Return the coefficients of the expression at a place."""
        constant = number(place.node)
        if constant is not None:
            return {"": constant}
        if kind(place.node) != "str" or len(place.node.value) > _LONGEST_EXPRESSION:
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
    only,
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
        MapOf(_SYMBOL, Made(Record({"guess": Field(_GUESS, "where to start", required=True)}), only)),
        "symbols to solve for",
    ),
    "curve": Field(_CURVE, "a closed curve of shapes, in place of amplitude, approach, cycle and free"),
}


GAIT = Document("A stored gait", Made(Record(_GAIT_FIELDS), _gait))


def load_gait(path: Path | str) -> Gait:
    """Return the gait of a file; the path - is standard input.

    Raises:
        InputError: The file says no gait.
    """
    return load(path, GAIT)
