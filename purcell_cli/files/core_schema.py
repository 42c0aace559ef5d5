"""What a plain scalar is by the core schema of YAML 1.2 (section 10.3.2), as editors with our JSON Schema read it.

PyYAML reads YAML 1.1, where 017 is 15, 1:30 is 90 and 1_000 is 1000. What YAML 1.1 takes for a number, a truth value
or a date, and YAML 1.2 not for the same, has the tag `OTHERWISE` and is refused with a hint.
"""

from __future__ import annotations

import math
import re

import yaml
from yaml.constructor import SafeConstructor

TAG = "tag:yaml.org,2002:"
"""What the tags of YAML's own types begin with."""

OTHERWISE = "otherwise"
"""The kind of what the two versions of YAML read otherwise."""

_WHOLE = [(re.compile("[-+]?[0-9]+"), 10), (re.compile("0o[0-7]+"), 8), (re.compile("0x[0-9a-fA-F]+"), 16)]
"""Whole numbers of the core schema: their form and base."""
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_TRUTH = {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}
_NULL = {"", "~", "null", "Null", "NULL"}

_LONGEST_NUMBER = 100
"""Characters of a number at most: a double needs 24, and the time to read a whole number grows with their square."""

_OLD = {
    tag.removeprefix(TAG): pattern
    for pairs in yaml.SafeLoader.yaml_implicit_resolvers.values()
    for tag, pattern in pairs
    if tag.removeprefix(TAG) in {"int", "float", "bool", "timestamp"}
}
"""What YAML 1.1 takes for other than text, by kind."""

_OLD_NAMES = {"bool": "the truth value", "timestamp": "the date", "int": "the number", "float": "the number"}
_CONSTRUCTOR = SafeConstructor()


def core_kind(text: str) -> str:
    """Return the kind of a plain scalar: null, bool, int, float, str or `OTHERWISE`."""
    new, old = _new_kind(text), _old_kind(text)
    if old is None or (new == old == "bool"):
        return new
    if new in {"int", "float"} and len(text) <= _LONGEST_NUMBER:
        return new if _alike(core_number(text, new), _old_number(text, old)) else OTHERWISE
    return OTHERWISE if new == "str" else new


def _new_kind(text: str) -> str:
    if text in _NULL:
        return "null"
    if text in _TRUTH:
        return "bool"
    if any(pattern.fullmatch(text) for pattern, _ in _WHOLE):
        return "int"
    return "float" if _FLOAT.fullmatch(text) or _NOT_FINITE.fullmatch(text) else "str"


def _old_kind(text: str) -> str | None:
    """Return what YAML 1.1 takes a scalar for; None for text and for nothing."""
    return next((kind for kind, pattern in _OLD.items() if pattern.match(text)), None)


def _old_number(text: str, kind: str) -> float | None:
    """Return the number that YAML 1.1 takes a scalar for; None where it is none."""
    if kind not in {"int", "float"} or len(text) > _LONGEST_NUMBER:
        return None
    read = _CONSTRUCTOR.construct_yaml_int if kind == "int" else _CONSTRUCTOR.construct_yaml_float
    try:
        return float(read(yaml.ScalarNode(TAG + kind, text)))
    except (ValueError, OverflowError, IndexError):
        return None


def _alike(a: float | None, b: float | None) -> bool:
    return a == b or (a is not None and b is not None and math.isnan(a) and math.isnan(b))


def core_number(text: str, kind: str) -> float | None:
    """Return the number that a scalar of the kind int or float is; None if it is none, or too large for a double."""
    if len(text) > _LONGEST_NUMBER:
        return None
    if kind == "float":
        return float(text.replace(".", "", 1) if _NOT_FINITE.fullmatch(text) else text) if _is_float(text) else None
    for pattern, base in _WHOLE:
        if pattern.fullmatch(text):
            try:
                return float(int(text if base == 10 else text[2:], base))
            except OverflowError:
                return None
    return None


def _is_float(text: str) -> bool:
    return bool(_FLOAT.fullmatch(text) or _NOT_FINITE.fullmatch(text))


def core_truth(text: str) -> bool | None:
    """Return the truth value that a scalar is; None if it is none."""
    return _TRUTH.get(text)


def read_otherwise(text: str, shown: str) -> str:
    """Return what a scalar is that the two versions of YAML read otherwise, and what to write instead.

    Args:
        text: The scalar.
        shown: The same, as messages show it.
    """
    old, new = _old_kind(text) or "str", _new_kind(text)
    number = _old_number(text, old)
    value = None if number is None or not math.isfinite(number) else f"{number:.15g}"
    if new in {"int", "float"} and value is not None:
        now = f"{core_number(text, new):.15g}"
        return f"the number {shown}, {value} in YAML 1.1 and {now} in YAML 1.2 (write {now} or {value})"
    if old == "bool":
        value = "true" if SafeConstructor.bool_values.get(text.lower()) else "false"
    instead = "" if value is None else f"write {value}; "
    return f"{_OLD_NAMES[old]} {shown} of YAML 1.1, a text in YAML 1.2 ({instead}in quotes it is a text)"
