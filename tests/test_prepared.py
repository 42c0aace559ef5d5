"""What the package keeps ready is what it would compute."""

from __future__ import annotations

import dataclasses
import shutil
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from purcell_cli.files.builtin import data_folder, own_gaits, stored_gaits
from purcell_cli.files.gaits_as_json import NAME, gaits_in_json, json_text
from purcell_cli.mechanics.lift import run_displacements
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.planner import prepared
from purcell_cli.planner.library.plan_library import MotionLibrary, stored_plans


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


def test_the_planner_s_tables_are_what_it_computes() -> None:
    sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tools"))
    try:
        from prepare_tables import tables
    finally:
        sys.path.pop(0)
    computed = tables()
    kept = {file.name: np.load(file) for file in prepared.FOLDER.glob("*.npy")}
    assert sorted(kept) == sorted(computed), "python tools/prepare_tables.py makes them anew"
    assert all(kept[name].tobytes() == table.tobytes() for name, table in computed.items())


def test_a_table_is_that_of_its_own_swimmer(monkeypatch: pytest.MonkeyPatch) -> None:
    computed = []

    def counted(*given: Any) -> np.ndarray:
        computed.append(given[0])
        return run_displacements(*given)

    monkeypatch.setattr(prepared, "run_displacements", counted)
    unit, other = Swimmer().scaled(), Swimmer(base_half_length_m=0.04).scaled()
    plans = stored_plans()[:5]
    MotionLibrary(stored_plans(), unit)
    assert computed == []
    MotionLibrary(stored_plans(), other)  # another swimmer
    MotionLibrary(plans, unit)  # another library
    assert computed == [other, unit]
