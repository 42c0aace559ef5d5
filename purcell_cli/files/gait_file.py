"""Gaits as YAML: what a gait file may say, and a gait written as one."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from purcell_cli.files.atomic_file import whole_file
from purcell_cli.files.containers import Either, Field, ListOf, MapOf, Record, only_value
from purcell_cli.files.documents import Document, Made
from purcell_cli.files.elements import Element
from purcell_cli.files.linear_expression import LinearExpression
from purcell_cli.files.place import Place
from purcell_cli.files.scalars import NAME, Choice, Flag, Number, Text, Whole
from purcell_cli.files.yaml_source import load
from purcell_cli.gaits.gait import MOTIONS, Gait, Guess, Turn
from purcell_cli.gaits.shape_curves import MOST_STEPS, Curve, Fourier, WayPoints, size_rad
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.primitives import CONTROL_NAMES, control_index

_SYMBOL = Text(r"[a-z][0-9]*", "a symbol (one lower-case letter, digits may follow)")


def _turn(value: dict[str, Mapping[str, float]], _: Place) -> Turn:
    ((control, coefficients),) = value.items()
    return Turn(control_index(control), coefficients)


_TURNS = Made(Record({name: Field(LinearExpression()) for name in CONTROL_NAMES}, exactly_one=True), _turn)


def _guess(value: dict[str, Any], place: Place) -> Guess:
    amplitudes, values = value["amplitude_rad"], value["value"]
    if any(low >= high for low, high in itertools.pairwise(amplitudes)):
        raise place.at("amplitude_rad").error("amplitudes in ascending order", "others")
    if len(values) != len(amplitudes):
        raise place.at("value").error(f"one value an amplitude, {len(amplitudes)} in all", str(len(values)))
    if min(values) < 0.0 < max(values):
        raise place.at("value").error("values of one sign", "both signs")
    return Guess(tuple(amplitudes), tuple(values), value.get("sharpness_power", 0.0))


_GUESS: Element[Guess] = Either(
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
"""A limb's rotation vector: roll, pitch and yaw [rad]."""


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

_CURVE: Element[Curve] = Made(
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
    only_value,
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
            raise place.below(key).error(_GAIT_FIELDS[key].element.wanted, "no such key")
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
        MapOf(_SYMBOL, Made(Record({"guess": Field(_GUESS, "where to start", required=True)}), only_value)),
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


def gait_text(gait: Gait) -> str:
    """Return a gait as YAML, to full double precision."""
    about: dict[str, Any] = {"name": gait.name}
    if gait.also:
        about["also"] = list(gait.also)
    about |= {"summary": gait.summary, "moves": gait.moves}
    if gait.source:
        about["source"] = gait.source
    out = yaml.safe_dump(about, sort_keys=False, width=1000, allow_unicode=True)
    if gait.curve is not None:
        return out + _flow_yaml({"curve": _curve_entry(gait.curve)})
    amplitude = {"symbol": gait.symbol, "means": gait.means, "default_rad": gait.default_rad}
    if gait.amplitude_is_displacement:
        amplitude["is_displacement"] = True
    parts: dict[str, Any] = {"amplitude": amplitude}
    if gait.approach:
        parts["approach"] = [_turn_entry(turn) for turn in gait.approach]
    parts["cycle"] = [_turn_entry(turn) for turn in gait.cycle]
    if gait.free:
        parts["free"] = {symbol: {"guess": _guess_entry(guess)} for symbol, guess in gait.free.items()}
    return out + _flow_yaml(parts)


def write_gait(gait: Gait, path: Path | str) -> None:
    """Write a gait as YAML; the file appears under its name when it is complete."""
    with whole_file(Path(path)) as file:
        file.write(gait_text(gait).encode())


def _flow_yaml(parts: dict[str, Any]) -> str:
    """Return YAML whose innermost lists and mappings stand on one line each."""
    return yaml.safe_dump(parts, sort_keys=False, width=1000, default_flow_style=None)


def _curve_entry(curve: Curve) -> dict[str, Any]:
    if isinstance(curve, WayPoints):
        return {"way_points": curve.vectors.reshape(-1, 2, 3).tolist()}
    constant = {name: value for name, value in zip(CONTROL_NAMES, curve.constant.tolist(), strict=True) if value}
    parts = {"constant": constant, "cosine": _harmonics_entry(curve.cosine), "sine": _harmonics_entry(curve.sine)}
    return {"fourier": {**{k: v for k, v in parts.items() if v}, "steps": curve.steps}}


def _harmonics_entry(coefficients: Array) -> dict[str, list[float]]:
    return {name: column.tolist() for name, column in zip(CONTROL_NAMES, coefficients.T, strict=True) if np.any(column)}


def _turn_entry(turn: Turn) -> dict[str, Any]:
    terms = [f"{value!r} {symbol}".strip() for symbol, value in turn.coefficients.items()]
    text = terms[0] + "".join(f" - {t[1:]}" if t.startswith("-") else f" + {t}" for t in terms[1:])
    return {CONTROL_NAMES[turn.control]: text if any(turn.coefficients) else turn.coefficients[""]}


def _guess_entry(guess: Guess) -> Any:
    if guess.amplitude_rad == (1.0,) and not guess.sharpness_power:
        return guess.value[0]
    table = {"amplitude_rad": list(guess.amplitude_rad), "value": list(guess.value)}
    return {**table, "sharpness_power": guess.sharpness_power}
