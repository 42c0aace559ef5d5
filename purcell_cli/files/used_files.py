"""Which files a command reads and writes: what it writes is never what it reads, nor what it writes as something else.

Every reader of the package notes what it opens, and every writer claims what it is going to replace. While a command
runs (`one_command`) the two are compared, by the files' identity: links and another case of the letters do not matter.
Outside a command, in the library, nothing is noted.
"""

from __future__ import annotations

import contextlib
import dataclasses
import os
import secrets
import stat
import unicodedata
from collections.abc import Iterator
from contextvars import ContextVar
from pathlib import Path

from purcell_cli.errors import InputError
from purcell_cli.files.paths import UnreadableError, is_folder, readable, status
from purcell_cli.frozen_dataclass import frozen_dataclass

Identity = tuple[int, int]
"""A file's device and its number there."""


@frozen_dataclass
class _Output:
    """A file that is going to be written.

    Attributes:
        option: The option that names it; empty for a file that is only about to be written.
        shown: Its path as it was given.
        target: Where that leads.
        identity: Which file is there now, if there is one.
    """

    option: str
    shown: str
    target: Path
    identity: Identity | None


@dataclasses.dataclass(slots=True)
class _Used:
    inputs: dict[Identity, str] = dataclasses.field(default_factory=dict)
    outputs: list[_Output] = dataclasses.field(default_factory=list)
    written: list[str] = dataclasses.field(default_factory=list)


_used: ContextVar[_Used | None] = ContextVar("_used", default=None)


@contextlib.contextmanager
def one_command() -> Iterator[list[str]]:
    """Keep what is read and what is written apart while a command runs; yield the files that it has written so far."""
    used = _Used()
    token = _used.set(used)
    try:
        yield used.written
    finally:
        _used.reset(token)


def note_input(path: Path | str | int) -> None:
    """Note that a file, a folder or an open file's number is read.

    Raises:
        InputError: It is claimed as an output.
    """
    used = _used.get()
    if used is None:
        return
    found = _open_file(path) if isinstance(path, int) else status(path)
    if found is None:
        return
    identity, shown = (found.st_dev, found.st_ino), "standard input" if isinstance(path, int) else str(path)
    used.inputs.setdefault(identity, shown)
    for output in used.outputs:
        if output.identity == identity:
            raise _refused(output.option, output.shown, shown, "which is read")


def claim_output(path: Path | str, target: Path, option: str) -> None:
    """Claim a file or a folder that is going to be written.

    Args:
        path: Its path as it was given.
        target: Where that leads, links followed.
        option: The option that names it; without one it is compared with what is read alone.

    Raises:
        InputError: It is read, or it is an output of another option, or what the command prints goes there.
    """
    used = _used.get()
    if used is None:
        return
    found = status(target)
    identity = None if found is None else (found.st_dev, found.st_ino)
    output = _Output(option, str(path), target, identity)
    if identity in used.inputs:
        raise _refused(option, output.shown, used.inputs[identity], "which is read")
    for number, name in ((1, "standard output"), (2, "standard error")):
        stream = _open_file(number)
        if stream is not None and identity == (stream.st_dev, stream.st_ino):
            raise _refused(option, output.shown, name, "which goes there")
    for other in used.outputs if option else ():
        if other.option not in {option, ""} and _same(output, other):
            raise _refused(option, output.shown, other.shown, f"which {other.option} names")
    if output not in used.outputs:
        used.outputs.append(output)


def note_written(path: Path | str) -> None:
    """Note that a file has been written."""
    used = _used.get()
    if used is not None and str(path) not in used.written:
        used.written.append(str(path))


def _refused(option: str, shown: str, other: str, what: str) -> InputError:
    return InputError(f"{option or shown}: wanted a file other than {other}, {what}, found the same")


def _open_file(number: int) -> os.stat_result | None:
    """Return what the system knows of a regular file that is open, by its number; None for anything else."""
    try:
        found = os.fstat(number)
    except OSError:
        return None
    return found if stat.S_ISREG(found.st_mode) else None


def _same(a: _Output, b: _Output) -> bool:
    """Return whether two outputs are one file, or will be once one of them is there."""
    if a.identity is not None or b.identity is not None:
        return a.identity == b.identity
    if a.target == b.target:
        return True
    if _folded(a.target.name) != _folded(b.target.name):
        return False
    folders = status(a.target.parent), status(b.target.parent)
    if None in folders or not os.path.samestat(*folders):  # type: ignore[arg-type]  # None is ruled out
        return False
    return _alike(a.target.parent, a.target.name, b.target.name)


def _folded(name: str) -> str:
    return unicodedata.normalize("NFC", unicodedata.normalize("NFC", name).casefold())


def _alike(folder: Path, name: str, other: str) -> bool:
    """Return whether a folder takes two names for one that differ in case or in accents: by a file that is tried."""
    mark = secrets.token_hex(6)
    first, second = (folder / f".{text[:40]}.{mark}.part" for text in (name, other))
    try:
        first.touch(exist_ok=False)
        return status(second) is not None
    except OSError:
        return False  # a folder that cannot be written to is refused elsewhere
    finally:
        with contextlib.suppress(OSError):
            first.unlink(missing_ok=True)


def note_large_input(path: Path, wanted: str, most_bytes: int) -> int:
    """Note a file that a command is about to read row by row, and return its size in bytes; refuse what cannot be read.

    Args:
        path: The file.
        wanted: What it is to be.
        most_bytes: How large it may be.

    Raises:
        InputError: There is no such file, it is too large, or the command writes it, too.
    """
    try:
        size = readable(path).st_size
    except UnreadableError as error:
        found = "a folder" if is_folder(path) else error
        raise InputError(f"{path}: wanted {wanted}, found {found}") from None
    if size > most_bytes:
        raise InputError(f"{path}: wanted at most {most_bytes >> 30} GiB, found more")
    note_input(path)
    return size
