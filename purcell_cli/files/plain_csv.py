"""CSV without polars, for processes that are forked from one that has used it: its threads are not there, and it waits.

Slower by far; the bytes are the same.
"""

from __future__ import annotations

import csv
import os
import sys
from collections.abc import Iterable, Mapping, Sequence
from typing import IO, Any

import numpy as np

from purcell_cli.errors import ResultsError

_forked = False


def _note_fork() -> None:
    global _forked  # what a process is, is one for all its modules
    _forked = "polars" in sys.modules


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_note_fork)


def without_polars() -> bool:
    """Return whether this process was forked from one that had polars, which would wait for ever in it."""
    return _forked


def refuse_fork() -> None:
    """Refuse what only polars does in a process that cannot use it.

    Raises:
        ResultsError: It cannot.
    """
    if _forked:
        raise ResultsError(
            "this needs polars, which waits for ever in a process that is forked from one that has loaded it; "
            "start processes by spawn: multiprocessing.get_context('spawn')"
        )


def write_columns(
    columns: Mapping[str, Any], stream: IO[bytes], separator: str = ",", *, include_header: bool = True
) -> None:
    """Write columns of numbers and texts as CSV.

    Args:
        columns: Arrays of one length by name.
        stream: Where to.
        separator: What stands between values.
        include_header: Whether the first line names the columns.
    """
    if include_header:
        stream.write((separator.join(columns) + "\n").encode())
    texts = [_texts(np.asarray(column).tolist()) for column in columns.values()]
    for row in zip(*texts, strict=True):
        stream.write((separator.join(row) + "\n").encode())


def _texts(values: Iterable[Any]) -> list[str]:
    return [_number(v) if isinstance(v, float) else str(v) for v in values]


def _number(value: float) -> str:
    """Return a double as polars writes it: as Python does, but for small numbers' exponents."""
    text = repr(value)
    mantissa, small, exponent = text.partition("e-")
    if not small:
        return text
    if int(exponent) > 5:
        return f"{mantissa}e-{int(exponent)}"
    return f"{'-' * mantissa.startswith('-')}0.0000{mantissa.lstrip('-').replace('.', '')}"


def read_rows(stream: IO[str], names: Sequence[str]) -> tuple[np.ndarray[Any, np.dtype[np.float64]], list[str]]:
    """Read the rows of a trajectory below its header.

    Args:
        stream: The file, its header read.
        names: The columns, of which `gait` is text.

    Returns:
        The other columns' numbers, shape (n, columns - 1), and the texts.

    Raises:
        ValueError: A row with other values.
    """
    at = list(names).index("gait")
    numbers: list[list[float]] = []
    texts: list[str] = []
    for row in csv.reader(stream):
        if not row:
            break
        if len(row) != len(names):
            raise ValueError("a row of another length")
        texts.append(row.pop(at))
        numbers.append([float(cell) for cell in row])
    return np.array(numbers, dtype=np.float64).reshape(-1, len(names) - 1), texts
