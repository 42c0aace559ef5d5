"""Plan options in documents: elements and values made from how each option is declared."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Callable, Mapping
from enum import StrEnum
from pathlib import Path
from typing import Any

from purcell_cli.files.configuration_file import WORKSPACE
from purcell_cli.files.containers import Field
from purcell_cli.files.documents import Made
from purcell_cli.files.elements import Element
from purcell_cli.files.obstacle_elements import OBSTACLES, obstacles_written
from purcell_cli.files.scalars import Choice, Number, Whole
from purcell_cli.motion.options import MOST_SEED, OPTIONS, E, Option, PlanOptions

_ELEMENTS: Mapping[str, Element[Any]] = {"workspace": WORKSPACE, "obstacles": OBSTACLES}
"""The elements of options that are neither a name nor a number."""


def choice(choices: type[E]) -> Element[E]:
    """Return the element for a member of an enumeration."""
    return Made(Choice(tuple(str(one) for one in choices)), lambda name, _: choices(name))


def _element(name: str, option: Option) -> Element[Any]:
    if option.kind is None:
        return _ELEMENTS[name]
    if issubclass(option.kind, StrEnum):
        return choice(option.kind)
    if option.kind is int:
        return Whole(0, MOST_SEED)
    return Number(above=option.above, at_least=option.at_least)


def _field(name: str, option: Option) -> Field:
    meaning = f"{option.meaning} [{option.unit}]" if option.unit else option.meaning
    return Field(_element(name, option), meaning, default=option.default)


_SAVED = {name: option for name, option in OPTIONS.items() if option.saved}

OPTION_FIELDS: Mapping[str, Field] = {option.key: _field(name, option) for name, option in _SAVED.items()}
"""The keys of a document that say what was asked of a plan."""


def options_read(value: Mapping[str, Any]) -> PlanOptions:
    """Return the options that a document's values say; those left out are the default."""
    given = {name: value[option.key] for name, option in _SAVED.items() if option.key in value}
    return PlanOptions(**given)


def options_written(options: PlanOptions, folder: Path | None = None) -> dict[str, Any]:
    """Return options as a document's values: those that are always written, and those that are not the default.

    Args:
        options: The options.
        folder: Where the document will be, from which files are then named.
    """
    written: Mapping[str, Callable[[Any], Any]] = {
        "workspace": dataclasses.asdict,
        "obstacles": functools.partial(obstacles_written, folder=folder),
    }
    out: dict[str, Any] = {}
    for name, option in _SAVED.items():
        value = getattr(options, name)
        if option.always or value != options.left_out(name):
            out[option.key] = written[name](value) if name in written else value
    return out
