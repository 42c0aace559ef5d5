"""YAML from a file or standard input to nodes, refused where it is malformed, too large or too deep.

Whatever is wrong is an `InputError`, raised quickly and in little memory.
"""

from __future__ import annotations

import os
import stat
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import yaml
from yaml.composer import Composer
from yaml.reader import Reader

from purcell_cli.errors import InputError
from purcell_cli.files.core_schema import TAG, core_kind
from purcell_cli.files.documents import Document
from purcell_cli.files.elements import ValueT
from purcell_cli.files.paths import UnreadableError, readable
from purcell_cli.files.place import Place, input_error, key_path, kind, shortened
from purcell_cli.files.used_files import note_input

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""libyaml's parser is twenty times quicker; PyYAML's own is for where it is missing."""

MOST_BYTES = 1 << 20
"""Bytes of a YAML file at most: the longest stored one has 2 kB, `MOST_NODES` numbers to full precision 400 kB."""

MOST_LEVELS = 20
"""Levels of nesting at most: the stored ones have up to 6, and each takes several of Python's 1000 stack frames."""

MOST_NODES = 20_000
"""Values of a document at most, aliases expanded: the stored ones have up to 200, and a curve of
1500 way points as many as this. They are composed in 0.15 s; ten times as many take ten times as long."""

_LONG_PLAN = 8
"""How many times as many bytes and values a plan document may have: the plan of a long mission has hundreds of strokes.
It is then composed in some 1.5 s."""

_PLAN_BEGINS, _PLAN_FORM = 256, b'"purcell/plan-document/'
"""Bytes at a plan document's beginning in which the name of its form stands, and how that begins."""

_CORE = {
    yaml.ScalarEvent: {TAG + name for name in ("str", "int", "float", "bool", "null")},
    yaml.SequenceStartEvent: {TAG + "seq"},
    yaml.MappingStartEvent: {TAG + "map"},
}


def file_bytes(path: Path, most: int = _LONG_PLAN * MOST_BYTES) -> bytes:
    """Return what a regular file holds, at most one byte more than is allowed.

    Args:
        path: The file.
        most: How many bytes are allowed.

    Raises:
        UnreadableError: There is no such file, or it cannot be read.
        InputError: The command writes it, too.
    """
    readable(path)
    note_input(path)
    try:
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        with os.fdopen(descriptor, "rb") as stream:
            if not stat.S_ISREG(os.fstat(descriptor).st_mode):
                raise UnreadableError("something that is no regular file")
            return stream.read(most + 1) or b""
    except OSError as error:
        raise UnreadableError(f"none ({error.strerror or error})") from error


def _room(data: bytes) -> int:
    """Return how many times as large as others the document in some bytes may be."""
    begun = data[:_PLAN_BEGINS]
    return _LONG_PLAN if begun.lstrip().startswith(b"{") and _PLAN_FORM in begun else 1


def _standard_input() -> bytes:
    """Return what standard input holds, at most one byte more than is allowed."""
    note_input(0)
    try:
        return sys.stdin.buffer.read(_LONG_PLAN * MOST_BYTES + 1)
    except (OSError, ValueError, AttributeError) as error:
        raise UnreadableError(f"standard input that cannot be read ({error})") from error


def _decoded(data: bytes, file: str) -> str:
    """Return the text of a file's bytes.

    Raises:
        InputError: Too many bytes, not UTF-8, or control characters.
    """
    most = _room(data) * MOST_BYTES
    if len(data) > most:
        raise input_error(file, 1, "", f"at most {most} bytes", "more")
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise input_error(file, line, "", "UTF-8", f"the byte 0x{data[error.start]:02x}") from error
    bad = Reader.NON_PRINTABLE.search(text)
    if bad:
        line = text.count("\n", 0, bad.start()) + 1
        raise input_error(file, line, "", "printable characters", f"the character U+{ord(bad.group()):04X}")
    return text


class _GuardedComposer(Composer):
    """Composes nodes from events and refuses tags, depths and sizes that no document needs.

    Attributes:
        file: The document's name, as messages show it.
        keys: The key path of the node at hand, below those of its parents.
        count: Nodes so far, aliases expanded.
        sizes: How many nodes each finished node expands to.
        most: How many nodes there may be.
    """

    peek_event: Callable[[], Any]

    def __init__(self, file: str, most: int) -> None:
        Composer.__init__(self)
        self.most = most
        self.file = file
        self.keys: list[str] = [""]
        self.count = 0
        self.sizes: dict[yaml.Node, int] = {}

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Return the next node; the key path stays where it is if that fails."""
        self.keys.append(self._key(parent, index))
        before = self.count
        self._admit(self.peek_event())
        node = super().compose_node(parent, index)
        if node is not None:
            self.sizes.setdefault(node, self.count - before)
        self.keys.pop()
        return node

    def _key(self, parent: yaml.Node | None, index: Any) -> str:
        if isinstance(parent, yaml.SequenceNode):
            return key_path(self.keys[-1], index)
        return key_path(self.keys[-1], index.value) if isinstance(index, yaml.ScalarNode) else self.keys[-1]

    def _admit(self, event: Any) -> None:
        self.count += self._alias_size(event) if isinstance(event, yaml.AliasEvent) else 1
        if self.count > self.most:
            raise self._error(event, f"at most {self.most} values, aliases expanded", "more")
        if len(self.keys) - 1 > MOST_LEVELS:
            raise self._error(event, f"at most {MOST_LEVELS} levels of nesting", "more")
        tag = getattr(event, "tag", None)
        if tag not in {None, "!"} and tag not in _CORE[type(event)]:
            raise self._error(event, "plain YAML", f"the tag {shortened(tag)}")

    def _alias_size(self, event: Any) -> int:
        target = self.anchors.get(event.anchor)
        if target is not None and target not in self.sizes:
            raise self._error(event, "a finite value", f"the alias *{shortened(event.anchor)} inside itself")
        return self.sizes[target] if target is not None else 0

    def _error(self, event: Any, wanted: str, found: str) -> InputError:
        return input_error(self.file, event.start_mark.line + 1, self.keys[-1], wanted, found)


class _GuardedLoader(_GuardedComposer, _Loader):  # type: ignore[misc]  # the base is known only when it runs
    """The guarded loader.

    Args:
        text: The document.
        file: Its name, as messages show it.
        most: How many nodes it may have.
    """

    def __init__(self, text: str, file: str, most: int) -> None:
        _Loader.__init__(self, text)
        _GuardedComposer.__init__(self, file, most)

    def resolve(self, kind: type[yaml.Node], value: Any, implicit: Any) -> str:
        """Return the tag of a node that has none of its own."""
        if kind is yaml.ScalarNode and implicit[0]:
            return TAG + ("merge" if value == "<<" else core_kind(value))
        return str(super().resolve(kind, value, implicit))


def _at_tab(text: str, mark: Any) -> bool:
    """Return whether a tab stands where a fault is, or indents its line or the one before."""
    if mark is None:
        return False
    lines = text.splitlines()[max(mark.line - 1, 0) : mark.line + 1]
    at = lines[-1][mark.column : mark.column + 1] if lines else ""
    return at == "\t" or any("\t" in line[: len(line) - len(line.lstrip())] for line in lines)


def _composed(text: str, file: str, most: int) -> yaml.Node | None:
    """Return the one document of a text, of so many nodes at most, None if it is empty.

    Raises:
        InputError: The text is malformed, or more than one document, or breaks a limit.
    """
    keys = [""]
    try:
        nodes = _GuardedLoader(text, file, most)
        keys = nodes.keys
        root = nodes.get_single_node()
    except InputError:
        raise
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        fault = shortened(", ".join(filter(None, (error.context, error.problem))), 120)
        line = mark.line + 1 if mark else 1
        if "nesting depth" in str(error.problem):  # a limit of PyYAML's own, from 6.0.4 on, met before ours
            raise input_error(file, line, keys[-1], f"at most {MOST_LEVELS} levels of nesting", "more") from error
        found = f"{'a tab, where only spaces may stand' if _at_tab(text, mark) else 'a fault'} ({fault})"
        raise input_error(file, line, keys[-1], "one YAML document", found) from error
    except (yaml.YAMLError, ValueError, OverflowError, RecursionError) as error:
        raise input_error(file, 1, keys[-1], "one YAML document", "one that cannot be read") from error
    return None if root is None or (kind(root) == "null" and not root.value) else root


def read_document(document: Document[ValueT], data: bytes, name: str, folder: Path) -> ValueT:
    """Return what the bytes of a file say."""
    defaults = "" if "required" in document.json_schema() else " ({} for the defaults)"
    return document.read(_composed_place(data, name, folder, document.wanted + defaults))


def _composed_place(data: bytes, name: str, folder: Path, wanted: str) -> Place:
    """Return the place of the whole document in the bytes of a file."""
    file = shortened(name, 1000)
    root = _composed(_decoded(data, file), file, _room(data) * MOST_NODES)
    if root is None:
        raise input_error(file, 1, "", wanted, "an empty file")
    return Place(file, root, "", folder)


def load(path: Path | str, document: Document[ValueT]) -> ValueT:
    """Return what a file says of one kind of document; the path - is standard input.

    Raises:
        InputError: The file cannot be read, or does not say what is wanted.
    """
    return read_document(document, *_source(path))


def compose_file(path: Path | str, wanted: str = "a mapping") -> Place:
    """Return the place of the whole document in a YAML file, not yet checked; the path - is standard input.

    Args:
        path: The file.
        wanted: What it is to hold, for the message about an empty file.

    Raises:
        InputError: The file cannot be read, or is no YAML document.
    """
    return _composed_place(*_source(path), wanted)


def _source(path: Path | str) -> tuple[bytes, str, Path]:
    """Return what a file holds, its name and the folder that paths in it start from."""
    stdin = str(path) == "-"
    name = "standard input" if stdin else str(path)
    try:
        data = _standard_input() if stdin else file_bytes(Path(path))
    except UnreadableError as error:
        raise InputError(f"{shortened(name, 1000)}: wanted a readable file, found {error}") from error
    return data, name, Path(path).parent
