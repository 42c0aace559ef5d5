"""Values of arguments and options that are what they say: typer checks the others.

To check a value typer makes a model of its type, for which it imports pydantic: 0.15 s of a command that takes 0.8 s.
"""

from __future__ import annotations

import functools
import os
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import typer

from purcell_cli.errors import ParameterError, PurcellError

_DECIMAL = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?|[-+]?inf|nan", re.ASCII | re.IGNORECASE)
"""Numbers as documents have them; Python would read underscores and the digits of other scripts too."""

_NUMBERS: dict[Any, str] = {int: "a whole number", float: "a number"}
"""What an option of a type wants, in words."""

Process = Callable[[Any, Any], Any]
"""What makes the value of a parameter, in a context, of what was given."""


def plainly(param: Any) -> Any:
    """Return a parameter that takes plain values as they are; all others are left to typer, with its messages."""
    if "process_value" not in vars(param):
        param.process_value = functools.partial(_processed, param, param.process_value)
    return param


def _processed(param: Any, process: Process, context: Any, given: Any) -> Any:
    several = param.multiple or param.nargs != 1
    known, value = (False, None) if several or (given is None and param.required) else _plain(param, given)
    if not known:
        wanted = _number_wanted(param)
        if not wanted or not isinstance(given, str):
            return process(context, given)
        fault = ParameterError(f"{param.opts[0]}: {wanted} is wanted, found {given!r}")
        if not _DECIMAL.fullmatch(given):
            raise fault
        try:
            return process(context, given)
        except typer.BadParameter:
            raise fault from None
    return value if param.callback is None else param.callback(context, param, value)


def _number_wanted(param: Any) -> str:
    """Return what number a parameter wants, in words; nothing where it wants no number."""
    described = getattr(param, "type_descriptor", None)
    number, info = _NUMBERS.get(getattr(described, "annotation", None)), getattr(described, "parameter_info", None)
    if number is None or info is None or info.parser is not None:
        return ""
    if info.min is None:
        return number
    return f"{number} of at least {info.min}" if info.max is None else f"{number} from {info.min} to {info.max}"


def _plain(param: Any, given: Any) -> tuple[bool, Any]:
    """Return whether the value of what was given is plain, and the value."""
    described = getattr(param, "type_descriptor", None)
    kind, info = getattr(described, "annotation", None), getattr(described, "parameter_info", None)
    if given is None:
        return True, None
    if not isinstance(kind, type) or info is None:
        return False, None
    if given is param.default and isinstance(given, kind):
        return True, given
    if type(given) is not str:
        return False, None
    if info.parser is not None:
        try:
            return True, info.parser(given)
        except (ValueError, PurcellError):
            return False, None
    if kind is str:
        return True, given
    if kind is Path:
        return _any_path(info) and (not os.path.lexists(given) or os.access(given, os.R_OK)), Path(given)
    if kind is float and info.min is None and info.max is None and _DECIMAL.fullmatch(given):
        return True, float(given)
    return False, None


def _any_path(info: Any) -> bool:
    """Return whether a parameter takes any path, whatever is there."""
    special = info.exists or info.resolve_path or info.writable or info.allow_dash or info.path_type is not None
    return not special and info.file_okay and info.dir_okay
