"""What a batch reads and writes, told before it starts: no result takes the place of what a scenario is made of."""

from __future__ import annotations

import os
from collections.abc import Collection
from pathlib import Path

import yaml

from purcell_cli.batch.results_folder import ENDINGS, JOURNAL, LOCK
from purcell_cli.files.atomic_file import writable_folder
from purcell_cli.files.paths import followed
from purcell_cli.files.place import Place
from purcell_cli.files.used_files import claim_output, note_input

SUMMARIES = ("summary.json", "summary.csv", "summary.parquet")
"""The files of a batch's summary."""

_PARTS = (("start",), ("goal",), ("swimmer",), ("follow", "path"))
"""Keys of a scenario that may name a file."""


def note_parts(place: Place) -> None:
    """Note the files that a scenario names, which are read when its turn comes.

    Raises:
        InputError: One of them is an output, too.
    """
    for keys in _PARTS:
        node = place.at(*keys).node
        if node is not place.node and isinstance(node, yaml.ScalarNode) and node.value:
            note_input(place.folder / node.value)


def claim_report(path: Path) -> None:
    """Claim the JUnit report, whose folder need not be there yet.

    Raises:
        InputError: It is read, or it is one of the results.
    """
    claim_output(path, followed(path), "--junit")


def claim_results(folder: Path, names: Collection[str]) -> None:
    """Claim the folder of results, and the files in it that the batch is going to replace.

    Args:
        folder: The folder; it need not be there yet.
        names: The scenarios' names, case folded.

    Raises:
        InputError: The folder cannot be written into, or one of the files is read.
    """
    writable_folder(folder, "--out")
    try:
        there = [entry.name for entry in os.scandir(folder)]
    except OSError:
        there = []
    replaced = [n for n in there if Path(n).suffix.lower() in ENDINGS and Path(n).stem.casefold() in names]
    for name in (*SUMMARIES, JOURNAL, LOCK, *replaced):
        claim_output(folder / name, followed(folder / name), "--out")
