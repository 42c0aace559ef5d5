"""The sizes of noise: read from a text, and checked."""

from __future__ import annotations

import math
from collections.abc import Mapping

from purcell_cli.errors import ParameterError
from purcell_cli.wording import nearest_hint


def sizes_of(text: str, most: Mapping[str, float]) -> dict[str, float]:
    """Return the sizes in a text such as "angle_deg=0.5,rate=0.02" by name; none in an empty one.

    Args:
        text: The text.
        most: The names that there are, and the most that each may be.

    Raises:
        ParameterError: A text that says something else, or says it twice.
    """
    sizes: dict[str, float] = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, _, value = (one.strip() for one in part.partition("="))
        if name not in most or name in sizes:
            wanted = f"each once, as NAME=SIZE, of {', '.join(most)}{nearest_hint(name, most)}"
            raise ParameterError(f"noise: {wanted} is wanted, found {part!r}")
        try:
            sizes[name] = float(value)
        except ValueError:
            sizes[name] = math.nan
        if not math.isfinite(sizes[name]):
            raise ParameterError(f"noise: a finite number for {name} is wanted, found {value!r}")
    return sizes


def refuse_sizes(sizes: Mapping[str, float], most: Mapping[str, float], seed: int) -> None:
    """Refuse sizes that are negative or too large, and a seed that is none.

    Raises:
        ParameterError: There is one.
    """
    for name, value in sizes.items():
        if not 0.0 <= value <= most[name]:
            raise ParameterError(f"noise: {name} of at least 0 and at most {most[name]:g} is wanted, found {value!r}")
    if not 0 <= seed < 2**63:
        raise ParameterError(f"seed: a whole number at least 0 and below 2^63 is wanted, found {seed!r}")
