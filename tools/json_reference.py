"""Write the reference of the JSON documents from their types: ``python tools/json_reference.py``."""

from __future__ import annotations

import types
from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, Literal, NotRequired, Union, get_args, get_origin, get_type_hints, is_typeddict

from purcell_cli.cli.documents.catalogue import DOCUMENTS
from purcell_cli.cli.documents.common import Failure

PAGE = Path(__file__).resolve().parent.parent / "docs" / "reference" / "json.md"

_HEAD = """# The JSON documents

Every command that has `--json` prints one document, on one line, and nothing else on standard output. Its key `schema`
names its form, `verdict` says how the command ended, and the exit code says whether that is success. This page is made
from the types of the documents by `tools/json_reference.py`. Units stand in brackets; L is the mean half length of the
swimmer's links. A sum over nothing is the whole number 0.

A plan document, which `purcell plan --plan-out` writes, is an input too: `purcell schema plan` prints its JSON Schema.
"""

_PLAIN = {float: "number", int: "whole number", str: "text", bool: "true or false", type(None): "null", Any: "anything"}


def page() -> str:
    """Return the text of the page."""
    documents = [Failure, *dict.fromkeys(DOCUMENTS.values())]
    parts = dict.fromkeys(part for document in documents for part in _parts(document))
    sections = [_HEAD]
    for document in documents:
        names = [name for name, kind in DOCUMENTS.items() if kind is document]
        heading = ", ".join(f"`{name}`" for name in names) or "A failure"
        sections.append(f"## {heading}\n\n{document.__doc__}\n\n{_table(document)}")
    sections.append("## Parts of documents\n")
    sections += [f"### {_title(part)}\n\n{part.__doc__}\n\n{_table(part)}" for part in parts]
    return "\n".join(sections)


def _parts(kind: Any) -> Iterator[Any]:
    """Return the types that are keys' values in a document, and in those, in the order of the page."""
    for inner in get_type_hints(kind).values():
        for part in _inside(inner):
            yield part
            yield from _parts(part)


def _inside(kind: Any) -> Iterator[Any]:
    if is_typeddict(kind):
        yield kind
    else:
        for inner in get_args(kind):
            yield from _inside(inner)


def _title(part: Any) -> str:
    return str(part.__name__).removesuffix("Part")


def _table(kind: Any) -> str:
    lines = ["| key | value | meaning |", "| --- | --- | --- |"]
    for key, hint in get_type_hints(kind, include_extras=True).items():
        inner = get_args(hint)[0] if get_origin(hint) is NotRequired else hint
        value, meaning = get_args(inner) if get_origin(inner) is Annotated else (inner, "")
        left_out = "" if inner is hint else " (may be left out)"
        lines.append(f"| `{key}` | {_said(value)} | {meaning}{left_out} |".replace("|angle|", r"\|angle\|"))
    return "\n".join(lines) + "\n"


def _said(kind: Any) -> str:
    """Return a type in words."""
    origin, inner = get_origin(kind), get_args(kind)
    if is_typeddict(kind):
        return f"[{_title(kind)}](#{_title(kind).lower()})"
    if isinstance(kind, type) and issubclass(kind, Enum):
        return " or ".join(f"`{member.value}`" for member in kind)
    if origin is Literal:
        return " or ".join(f"`{getattr(value, 'value', value)}`" for value in inner)
    if origin in {Union, types.UnionType}:
        return " or ".join(_said(one) for one in inner)
    if origin is list:
        return f"list of: {_said(inner[0])}"
    if origin is dict:
        return f"mapping of names to: {_said(inner[1])}"
    return _PLAIN[kind]


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
