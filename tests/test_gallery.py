"""The gallery of gaits cannot lie: it is what its script would write, and its pictures are there."""

from __future__ import annotations

import csv
import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

import pytest

DOCS = Path(__file__).resolve().parent.parent / "docs"
TEXT = (DOCS / "gaits.md").read_text(encoding="utf-8")


def gallery() -> ModuleType:
    spec = importlib.util.spec_from_file_location("gait_gallery", DOCS / "gait_gallery.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses look for it
    spec.loader.exec_module(module)
    return module


def test_the_page_is_what_its_script_writes() -> None:
    assert gallery().page() == TEXT, "python docs/gait_gallery.py brings the page up to date"


def test_printed_sequences_do_what_the_reference_says() -> None:
    """The table of the page against the reference numbers, which another program made."""
    with (Path(__file__).parent / "data" / "printed_sequences.csv").open(encoding="utf-8", newline="") as file:
        wanted = {row["printed_sequence"]: row for row in csv.DictReader(file) if float(row["amplitude_rad"]) == 1.0}
    rows = re.findall(r"^\| `printed-(\w+)` \| (.*) \|$", TEXT, re.MULTILINE)
    assert {name for name, _ in rows} == set(wanted)
    for name, cells in rows:
        values = [float(cell) for cell in cells.split(" | ")[1:7]]
        for value, key in zip(values[:3], ("dx_over_L", "dy_over_L", "dz_over_L"), strict=True):
            assert abs(value - float(wanted[name][key])) <= 5.01e-5
        for value, key in zip(values[3:], ("psi_rad", "theta_rad", "phi_rad"), strict=True):
            assert abs(value - float(wanted[name][key]) * 57.29577951308232) <= 5.01e-3


@pytest.mark.parametrize("page", ["gaits.md", "planner.md"])
def test_pictures_of_a_page_are_there_small_and_undated(page: str) -> None:
    shown = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", (DOCS / page).read_text(encoding="utf-8"))
    assert shown
    for name in shown:
        data = (DOCS / name).read_bytes()
        assert data.startswith(b"<?xml")
        assert len(data) < 200_000, name
        assert b"dc:date" not in data


def test_every_picture_is_shown() -> None:
    assert {f"pictures/{path.name}" for path in (DOCS / "pictures").iterdir()} == set(
        re.findall(r"pictures/[\w.-]+", TEXT)
    )
