"""Gaits as the YAML files that `files` reads."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from purcell_cli.files.atomic_file import whole_file
from purcell_cli.gaits.gait import Gait, Guess, Turn
from purcell_cli.gaits.shape_curves import Curve, WayPoints
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.primitives import CONTROL_NAMES


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
        return out + _block({"curve": _curve(gait.curve)})
    amplitude = {"symbol": gait.symbol, "means": gait.means, "default_rad": gait.default_rad}
    if gait.amplitude_is_displacement:
        amplitude["is_displacement"] = True
    parts: dict[str, Any] = {"amplitude": amplitude}
    if gait.approach:
        parts["approach"] = [_turn(turn) for turn in gait.approach]
    parts["cycle"] = [_turn(turn) for turn in gait.cycle]
    if gait.free:
        parts["free"] = {symbol: {"guess": _guess(guess)} for symbol, guess in gait.free.items()}
    return out + _block(parts)


def write_gait(gait: Gait, path: Path | str) -> None:
    """Write a gait as YAML; the file appears under its name when it is complete."""
    with whole_file(Path(path)) as file:
        file.write(gait_text(gait).encode())


def _block(parts: dict[str, Any]) -> str:
    """Return YAML whose innermost lists and mappings stand on one line each."""
    return yaml.safe_dump(parts, sort_keys=False, width=1000, default_flow_style=None)


def _curve(curve: Curve) -> dict[str, Any]:
    if isinstance(curve, WayPoints):
        return {"way_points": curve.vectors.reshape(-1, 2, 3).tolist()}
    constant = {name: value for name, value in zip(CONTROL_NAMES, curve.constant.tolist(), strict=True) if value}
    parts = {"constant": constant, "cosine": _harmonics(curve.cosine), "sine": _harmonics(curve.sine)}
    return {"fourier": {**{k: v for k, v in parts.items() if v}, "steps": curve.steps}}


def _harmonics(coefficients: Array) -> dict[str, list[float]]:
    return {name: column.tolist() for name, column in zip(CONTROL_NAMES, coefficients.T, strict=True) if np.any(column)}


def _turn(turn: Turn) -> dict[str, Any]:
    terms = [f"{value!r} {symbol}".strip() for symbol, value in turn.coefficients.items()]
    text = terms[0] + "".join(f" - {t[1:]}" if t.startswith("-") else f" + {t}" for t in terms[1:])
    return {CONTROL_NAMES[turn.control]: text if any(turn.coefficients) else turn.coefficients[""]}


def _guess(guess: Guess) -> Any:
    if guess.amplitude_rad == (1.0,) and not guess.sharpness_power:
        return guess.value[0]
    table = {"amplitude_rad": list(guess.amplitude_rad), "value": list(guess.value)}
    return {**table, "sharpness_power": guess.sharpness_power}
