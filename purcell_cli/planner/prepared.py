"""Displacements that come with the package: those of tables that every plan of the paper's swimmer would compute.

A table is kept under the key of all numbers that it follows from, so that another swimmer's is never taken for it;
the kernel makes the same bits on every machine. `tools/prepare_tables.py` makes the files.
"""

from __future__ import annotations

import dataclasses
import zlib
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.base_velocity import kernel_numbers
from purcell_cli.mechanics.collocation import Accuracy
from purcell_cli.mechanics.lift import run_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer

FOLDER = Path(__file__).resolve().parent / "tables"
"""Where the files are."""


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
    file = file_of(table, swimmer, pieces, counts, accuracy)
    if file.is_file():
        return np.asarray(np.load(file, allow_pickle=False))
    return run_displacements(swimmer, pieces, counts, np.ones_like(counts), accuracy)


def file_of(table: str, swimmer: Swimmer, pieces: Pieces, counts: ArrayLike, accuracy: Accuracy) -> Path:
    """Return the file of a table; see `run_displacements_kept`."""
    key = zlib.crc32(repr(dataclasses.astuple(accuracy)).encode())
    for part in (kernel_numbers(swimmer), pieces.shapes, pieces.rates, pieces.durations, counts):
        key = zlib.crc32(np.asarray(part, dtype="<f8").tobytes(), key)
    return FOLDER / f"{table}-{key:08x}.npy"
