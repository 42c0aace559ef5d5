"""Checks of any document of the project: what kind it is by its keys, and whether it reads."""

from __future__ import annotations

import itertools
from pathlib import Path

from purcell_cli.errors import InputError
from purcell_cli.files.elements import Element
from purcell_cli.files.place import Place
from purcell_cli.files.plan_file import PLAN
from purcell_cli.files.scenario_file import SCHEMAS
from purcell_cli.files.servo_map_file import SERVO_MAP
from purcell_cli.files.sweep import combinations, variants
from purcell_cli.files.yaml_source import compose_file
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.wording import nearest

KINDS: dict[str, Element[object]] = {**SCHEMAS, "plan": PLAN, "servo-map": SERVO_MAP}
"""Every kind of document by name."""

MOST_CHECKED = 500
"""How many combinations of a sweep are checked: a check is to be done at once."""


@frozen_dataclass
class Checked:
    """What the check of a file found.

    Attributes:
        file: The file.
        kind: One of `KINDS`, the one that its keys fit best; None where it cannot be told.
        error: What is wrong; None where nothing is.
        scenarios: How many scenarios the file stands for, if it is a scenario.
    """

    file: str
    kind: str | None
    error: str | None = None
    scenarios: int | None = None


def check_file(path: Path | str, kind: str | None = None) -> Checked:
    """Check one file; the path - is standard input.

    Args:
        path: The file.
        kind: One of `KINDS`; where none is given, the one that its keys fit best.
    """
    try:
        place = compose_file(path, f"a document ({', '.join(KINDS)})")
        kind = kind or likely_kind(place)
        if kind != "scenario":
            KINDS[kind].read(place)
            return Checked(str(path), kind)
        count = combinations(place)
        for variant in itertools.islice(variants(place), MOST_CHECKED):
            KINDS[kind].read(variant.place)
        return Checked(str(path), kind, None, count)
    except InputError as error:
        return Checked(str(path), kind, str(error))


def likely_kind(place: Place) -> str:
    """Return the kind of document that has most of the keys at a place; a near miss counts for half."""
    pairs = place.node.value if isinstance(place.node.value, list) else []
    keys = [str(pair[0].value)[:100] for pair in pairs if isinstance(pair, tuple)]

    def likeness(kind: str) -> float:
        properties = KINDS[kind].json_schema()["properties"]
        known = list(properties) if isinstance(properties, dict) else []
        near = (nearest(key, known) for key in keys)
        return sum(1.0 if key in known else 0.5 * bool(close) for key, close in zip(keys, near, strict=True))

    return max(KINDS, key=likeness)
