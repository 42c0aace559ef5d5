"""How much memory a motion takes, and the budget that it must keep to."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

from purcell_cli.errors import ParameterError

_ROW_BYTES, _PRIMITIVE_BYTES, _REST_BYTES = 400, 800, 200 << 20
"""Memory that a row of a trajectory and a primitive take, and the program besides; measured of motions of up to 2.7
million rows and 550,000 primitives, and rounded up."""
MOST_ROWS = 3e6
"""How many rows a trajectory may have."""
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


def too_many_rows(duration_s: float, dt_s: float) -> ParameterError | None:
    """Return the refusal of a time between rows [s] that is not positive, or asks for more than `MOST_ROWS` rows.

    Args:
        duration_s: How long the motion lasts [s].
        dt_s: The longest time between its rows [s].
    """
    if dt_s > 0.0 and duration_s / dt_s <= MOST_ROWS:
        return None
    return ParameterError(
        f"dt: a time above {duration_s / MOST_ROWS:.2g} s is wanted (at most {MOST_ROWS:.0e} rows), found {dt_s!r}"
    )


def too_huge(primitives: int, rows: float, found_gb: float) -> ParameterError | None:
    """Return the refusal of a motion that takes more memory than there is for it.

    Args:
        primitives: How many primitives or moves are played.
        rows: How many rows its trajectory has, besides one for each of them.
        found_gb: The memory that it may take [GB].
    """
    wanted_gb = _wanted_gb(primitives, rows)
    if wanted_gb <= found_gb:
        return None
    more = f" and {rows:.2g} rows (fewer with a larger --dt)" if rows >= 1.0 else ""
    return ParameterError(
        f"max-memory: a budget of at least {wanted_gb:.2g} GB for {primitives} primitives{more} "
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
    if (found := too_huge(primitives, rows, budget_gb(most_gb))) is not None:
        raise found


def _wanted_gb(primitives: int, rows: float) -> float:
    return (_REST_BYTES + _PRIMITIVE_BYTES * primitives + _ROW_BYTES * (primitives + rows)) / 1e9
