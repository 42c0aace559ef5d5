"""What the package keeps ready is what it would compute."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path
from typing import Any

import numpy as np

from purcell_cli.files.builtin import data_folder, own_gaits, stored_gaits
from purcell_cli.files.gaits_as_json import NAME, gaits_in_json, json_text


def parts(value: Any) -> Any:
    """A value as plain parts that can be compared, with the types of its numbers."""
    if dataclasses.is_dataclass(value):
        return type(value).__name__, {f.name: parts(getattr(value, f.name)) for f in dataclasses.fields(value)}
    if isinstance(value, np.ndarray):
        return value.dtype.str, value.tolist()
    if isinstance(value, dict):
        return {k: parts(v) for k, v in value.items()}
    if isinstance(value, (tuple, list)):
        return type(value).__name__, [parts(v) for v in value]
    return type(value).__name__, value


def test_the_gaits_in_json_are_those_of_the_yaml_files() -> None:
    folder = data_folder("gaits")
    found, told = gaits_in_json(folder), own_gaits(folder)
    assert found is not None, "python tools/prepare_tables.py makes it anew"
    assert parts(found) == parts(told)
    assert list(found) == list(told) == list(stored_gaits())
    assert (folder / NAME).read_text(encoding="utf-8") == json_text(told, folder)


def test_gaits_in_json_do_not_count_when_a_yaml_file_has_changed(tmp_path: Path) -> None:
    folder = tmp_path / "gaits"
    shutil.copytree(data_folder("gaits"), folder)
    assert gaits_in_json(folder) is not None
    gait = folder / "x-motion.yaml"
    gait.write_bytes(gait.read_bytes().replace(b"\n", b"\r\n"))  # line ends say nothing
    assert gaits_in_json(folder) is not None
    gait.write_text(gait.read_text(encoding="utf-8").replace("default_rad: 1.0", "default_rad: 0.5"), encoding="utf-8")
    assert gaits_in_json(folder) is None
    (folder / NAME).unlink()
    assert gaits_in_json(folder) is None
