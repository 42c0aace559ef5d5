"""How much memory a motion takes, and the budget that it must keep to."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from purcell_cli.errors import ParameterError

_ROW_BYTES, _PRIMITIVE_BYTES, _REST_BYTES = 400, 800, 200 << 20
"""Memory that a row of a trajectory and a primitive take, and the program besides; measured of motions of up to 2.7
million rows and 550,000 primitives, and rounded up."""
DEFAULT_GB = 4.0
"""The budget where none is given [GB]; half of what is free, if that is less."""


_KNOWN_TO_LINUX = Path("/proc/meminfo")
"""Where Linux says what is available: what is free, and what holds copies of files that are let go when needed."""


def free_bytes() -> int | None:
    """Return how much memory a program can have now, where the system says that."""
    with contextlib.suppress(OSError, ValueError, StopIteration):
        lines = _KNOWN_TO_LINUX.read_text("ascii").splitlines()
        return next(int(line.split()[1]) << 10 for line in lines if line.startswith("MemAvailable:"))
    try:
        return os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    except (AttributeError, OSError, ValueError):
        return None


def budget_gb(most_gb: float) -> float:
    """Return the memory that a motion may take; half of what is free, if that is less than the default [GB]."""
    free = free_bytes() if most_gb == DEFAULT_GB else None
    return most_gb if free is None else min(most_gb, 0.5e-9 * free)


def most_primitives(found_gb: float) -> int:
    """Return how many primitives or moves a budget has room for, with a row for each and no other rows."""
    return int((1e9 * found_gb - _REST_BYTES) / (_PRIMITIVE_BYTES + _ROW_BYTES))


def too_huge(primitives: int, rows: float, found_gb: float) -> ParameterError:
    """Return the refusal of a motion that takes more memory than a budget [GB]."""
    more = f" and {rows:.2g} rows (fewer with a larger --dt)" if rows >= 1.0 else ""
    return ParameterError(
        f"max-memory: a budget of at least {_wanted_gb(primitives, rows):.2g} GB for {primitives} primitives{more} "
        f"is wanted, found {found_gb:.2g} GB"
    )


def refuse_huge(primitives: int, rows: float, most_gb: float) -> None:
    """Refuse a motion that takes more memory than the budget.

    Args:
        primitives: How many primitives or moves are played.
        rows: How many rows its trajectory has, besides one for each of them.
        most_gb: The budget; where it is `DEFAULT_GB`, half of what is free, if that is less [GB].

    Raises:
        ParameterError: The motion takes more.
    """
    found_gb = budget_gb(most_gb)
    if _wanted_gb(primitives, rows) > found_gb:
        raise too_huge(primitives, rows, found_gb)


def _wanted_gb(primitives: int, rows: float) -> float:
    return (_REST_BYTES + _PRIMITIVE_BYTES * primitives + _ROW_BYTES * (primitives + rows)) / 1e9
