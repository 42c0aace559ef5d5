"""Tables that come with the package: those that every plan of the paper's swimmer would compute.

A table is kept under the key of all numbers that it follows from, so that another swimmer's is never taken for it;
the kernel makes the same bits on every machine. `tools/prepare_tables.py` makes the files.
"""

from __future__ import annotations

import contextlib
import dataclasses
import zlib
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.gaits.gait import Gait
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.base_velocity import kernel_numbers
from purcell_cli.mechanics.collocation import Accuracy
from purcell_cli.mechanics.lift import run_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer

FOLDER = Path(__file__).resolve().parent / "tables"
"""Where the files are."""

_recorded: list[dict[str, Array]] = []


def kept(table: str, swimmer: Swimmer, key: Iterable[ArrayLike | str], compute: Callable[[], Array]) -> Array:
    """Return a table, from its file where there is one.

    Args:
        table: What it is called.
        swimmer: The swimmer, scaled to L = 1, of which the flow's numbers count.
        key: All else that it follows from, as numbers or words.
        compute: Makes it.
    """
    crc = 0
    for part in (kernel_numbers(swimmer), *key):
        crc = zlib.crc32(part.encode() if isinstance(part, str) else np.asarray(part, dtype="<f8").tobytes(), crc)
    file = FOLDER / f"{table}-{crc:08x}.npy"
    if file.is_file() and not _recorded:
        return np.asarray(np.load(file, allow_pickle=False))
    made = compute()
    for record in _recorded:
        record[file.name] = made
    return made


@contextlib.contextmanager
def recorded() -> Iterator[dict[str, Array]]:
    """Compute all tables anew, and give them by the names of their files."""
    _recorded.append({})
    try:
        yield _recorded[-1]
    finally:
        _recorded.pop()


def words_of(gait: Gait) -> str:
    """Return all of a gait of primitives that its strokes follow from, as words for a key."""
    return repr((gait.moves, gait.symbol, gait.amplitude_is_displacement, gait.approach, gait.cycle, dict(gait.free)))


def run_displacements_kept(
    table: str, swimmer: Swimmer, pieces: Pieces, counts: ArrayLike, accuracy: Accuracy
) -> Array:
    """Return the base's body displacement along runs of pieces, from a file where there is one.

    Args:
        table: What the table is called.
        swimmer: The swimmer, scaled to L = 1.
        pieces: The pieces of each run.
        counts: How many pieces each run has, in order. Shape (k,).
        accuracy: Order and step of the method.

    Returns:
        Poses relative to each run's beginning. Shape (k, 4, 4).
    """
    key = repr(dataclasses.astuple(accuracy)), pieces.shapes, pieces.rates, pieces.durations, counts
    return kept(table, swimmer, key, lambda: run_displacements(swimmer, pieces, counts, np.ones_like(counts), accuracy))
