"""The gallery of gaits cannot lie: it is what its script would write, and its pictures are there."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import pytest
from pages import DOCS, PAGES, ROOT, tool

TEXT = PAGES["docs/explanation/gaits.md"]
SHOWN = {page: re.findall(r"!\[[^\]]+\]\(([^)]+)\)", text) for page, text in PAGES.items()}


def test_the_page_is_what_its_script_writes() -> None:
    assert tool("gait_gallery").page() == TEXT, "python tools/gait_gallery.py brings the page up to date"


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


@pytest.mark.parametrize("page", [page for page, pictures in SHOWN.items() if pictures])
def test_pictures_of_a_page_are_there_small_and_undated(page: str) -> None:
    for name in SHOWN[page]:
        data = (ROOT / page).parent.joinpath(name).read_bytes()
        film = name.endswith(".gif")
        assert data.startswith(b"GIF89a" if film else b"<?xml")
        assert len(data) < (500_000 if film else 200_000), name
        assert b"dc:date" not in data


def test_every_picture_is_shown() -> None:
    shown = {(ROOT / page).parent.joinpath(name).resolve() for page, names in SHOWN.items() for name in names}
    assert shown == set((DOCS / "pictures").iterdir())
