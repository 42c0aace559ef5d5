"""Units that suit the size of what is shown, numbers of things, and the name most like another."""

from __future__ import annotations

from collections.abc import Sequence


def length_unit(largest_m: float) -> tuple[float, str]:
    """Return the factor from metres to a unit that suits a length, and the unit."""
    for factor, unit in ((1.0, "m"), (1e3, "mm"), (1e6, "µm"), (1e9, "nm")):
        if largest_m * factor >= 1.0:
            return factor, unit
    return (1e9, "nm") if largest_m > 0.0 else (1e3, "mm")


def counted(number: int, thing: str) -> str:
    """Return a number of things in words, one of them without the plural's s."""
    return f"{number} {thing}{'s' * (number != 1)}"


def nearest(name: str, choices: Sequence[str]) -> str:
    """Return " (nearest: ...)" for the choice most like a name, or nothing if none is."""
    import difflib  # help and version do without it

    close = difflib.get_close_matches(name[:100], choices, n=1)
    return f" (nearest: {close[0]})" if close else ""
