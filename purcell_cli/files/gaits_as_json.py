"""The stored gaits as one JSON file beside their YAML files, which is read in a tenth of the time.

It counts only while the YAML files are those that it was made of; `tools/prepare_tables.py` makes it.
"""

from __future__ import annotations

import dataclasses
import json
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from purcell_cli.files.paths import is_file
from purcell_cli.files.yaml_source import file_bytes
from purcell_cli.gaits.gait import Gait, Guess, Turn
from purcell_cli.gaits.shape_curves import Curve, Fourier, WayPoints

NAME = "all.json"
"""What the file is called."""


def gaits_in_json(folder: Path) -> dict[str, Gait] | None:
    """Return the gaits of a folder by name, or None where its JSON file is missing or older than a YAML file."""
    if not is_file(folder / NAME):
        return None
    document = json.loads(file_bytes(folder / NAME))
    if document["key"] != key(folder):
        return None
    return {gait.name: gait for gait in map(_gait, document["gaits"])}


def json_text(gaits: Mapping[str, Gait], folder: Path) -> str:
    """Return the text of the JSON file of a folder's gaits."""
    parts = ",\n".join(json.dumps(_entry(gait), ensure_ascii=False) for gait in gaits.values())
    return f'{{"key": {json.dumps(key(folder))}, "gaits": [\n{parts}\n]}}\n'


def key(folder: Path) -> str:
    """Return what stands for the YAML files of a folder, whatever their line ends."""
    crc = 0
    for path in sorted(path for path in folder.iterdir() if path.suffix == ".yaml"):
        crc = zlib.crc32(path.name.encode() + file_bytes(path).replace(b"\r\n", b"\n"), crc)
    return f"{crc:08x}"


def _entry(gait: Gait) -> dict[str, Any]:
    """Return a gait as JSON has it: the fields that say more than their defaults."""
    entry = {f.name: getattr(gait, f.name) for f in dataclasses.fields(gait)}
    for part in ("approach", "cycle"):
        entry[part] = [[turn.control, dict(turn.coefficients)] for turn in entry[part]]
    entry["free"] = {symbol: dataclasses.astuple(guess) for symbol, guess in gait.free.items()}
    if gait.curve is not None:
        fields = {f.name: getattr(gait.curve, f.name) for f in dataclasses.fields(gait.curve)}
        entry["curve"] = {name: np.asarray(value).tolist() for name, value in fields.items()}
    return {name: value for name, value in entry.items() if value or name in ("approach", "cycle", "free")}


def _gait(entry: dict[str, Any]) -> Gait:
    """Return the gait of an entry."""
    made = dict(entry, also=tuple(entry.get("also", ())))
    for part in ("approach", "cycle"):
        made[part] = tuple(Turn(control, coefficients) for control, coefficients in entry[part])
    made["free"] = {symbol: Guess(tuple(a), tuple(v), power) for symbol, (a, v, power) in entry["free"].items()}
    if "curve" in entry:
        made["curve"] = _curve(entry["curve"])
    return Gait(**made)


def _curve(fields: dict[str, Any]) -> Curve:
    values = {name: np.array(value, dtype=np.float64) for name, value in fields.items() if name != "steps"}
    return Fourier(**values, steps=fields["steps"]) if "steps" in fields else WayPoints(**values)
