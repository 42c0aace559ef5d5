"""Expressions linear in symbols, such as ``2 a - b + 0.1``: the angles of a gait's turns."""

from __future__ import annotations

import re
from collections.abc import Mapping

import numpy as np

from purcell_cli.files.elements import Element
from purcell_cli.files.place import Place, finite_number, kind

_TERM = re.compile(
    r"\s*(?P<sign>[-+])?\s*(?P<number>(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?)?"
    r"\s*(?P<times>\*)?\s*(?P<symbol>[a-z][0-9]*)?\s*"
)
"""A term: a sign, a number, a sign of multiplication and a symbol, each of which may be missing."""

_LONGEST_EXPRESSION = 200
"""Characters of an expression at most: those of the stored gaits have up to 9, a fitted one 20 for each symbol."""


class LinearExpression(Element[Mapping[str, float]]):
    """An angle linear in symbols; the value is {symbol: coefficient}, the empty symbol being the constant."""

    @property
    def wanted(self) -> str:
        """What the element wants to find, in words."""
        return "an angle [rad] linear in symbols, such as -a, 2 a - b or 0.5"

    def read(self, place: Place) -> dict[str, float]:
        """Return the coefficients of the expression at a place."""
        constant = finite_number(place.node)
        if constant is not None:
            return {"": constant}
        if kind(place.node) != "str" or len(place.node.value) > _LONGEST_EXPRESSION:
            raise place.error(self.wanted)
        out = linear_terms(place.node.value)
        if out is None:
            raise place.error(self.wanted)
        return out

    def json_schema(self) -> dict[str, object]:
        """Return the element as JSON Schema."""
        return {"anyOf": [{"type": "number"}, {"type": "string", "pattern": r"^[-+*.0-9a-zE ]+$"}]}


def linear_terms(expression: str) -> dict[str, float] | None:
    """Return a linear expression as {symbol: coefficient}, '' for the constant; None if it is not linear."""
    out: dict[str, float] = {}
    position = 0
    while position < len(expression) or not out:
        term = _TERM.match(expression, position)
        if term is None or not _is_term(term, first=position == 0):
            return None
        value = float(term["number"] or 1.0) * (-1.0 if term["sign"] == "-" else 1.0)
        symbol = term["symbol"] or ""
        out[symbol] = out.get(symbol, 0.0) + value
        position = term.end()
    return out if all(np.isfinite(value) for value in out.values()) else None


def _is_term(term: re.Match[str], *, first: bool) -> bool:
    """Return whether a match of `_TERM` says something, and a sign parts it from the term before."""
    something = term["number"] or term["symbol"]
    both = term["number"] and term["symbol"]
    return bool(something and (first or term["sign"]) and (both or not term["times"]))
