"""Words of messages: units that suit the size of what is shown, numbers of things, and the nearest known name."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

_LONGEST_NAME = 100
"""Characters of a name that are compared: no known name is longer, and the time to compare grows with them."""

ANGLES = {"psi": "yaw", "theta": "pitch", "phi": "roll"}
"""What the paper's angles are called where a document names an axis or what a gait moves."""
_OTHER_NAMES = ANGLES | {name: angle for angle, name in ANGLES.items()}


def length_unit(largest_m: float) -> tuple[float, str]:
    """Return the factor from metres to a unit that suits a length, and the unit."""
    for factor, unit in ((1.0, "m"), (1e3, "mm"), (1e6, "µm"), (1e9, "nm")):
        if largest_m * factor >= 1.0:
            return factor, unit
    return (1e9, "nm") if largest_m > 0.0 else (1e3, "mm")


def counted(number: int, thing: str) -> str:
    """Return a number of things in words, one of them without the plural's s."""
    return f"{number} {thing}{'s' * (number != 1)}"


def nearest(name: str, choices: Iterable[str]) -> str | None:
    """Return the choice that a name means or is most like, case aside; None if none is like it.

    Who writes psi for yaw, or yaw for psi, means the other.

    Args:
        name: The name that is not among the choices.
        choices: The names that are known.
    """
    folded = {choice.casefold(): choice for choice in reversed(list(choices))}  # the first of two that are alike
    name = name[:_LONGEST_NAME].casefold()
    for meant in (name, " ".join(_OTHER_NAMES.get(word, word) for word in name.split(" "))):
        if meant in folded:
            return folded[meant]
    close = difflib.get_close_matches(name, list(folded)[::-1], n=1)
    return folded[close[0]] if close else None


def nearest_hint(name: str, choices: Iterable[str]) -> str:
    """Return " (nearest: ...)" for the choice most like a name, or nothing if none is."""
    found = nearest(name, choices)
    return f" (nearest: {found})" if found else ""
