"""Files that are replaced whole, or not at all."""

from __future__ import annotations

import contextlib
import os
import secrets
import stat
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO

from purcell_cli.errors import InputError
from purcell_cli.files.paths import followed
from purcell_cli.files.used_files import claim_output, note_written

_LONGEST_MARK = 40
"""Characters of a file's name that its temporary name repeats: of four bytes each, they still fit into 255 bytes."""


def writable(path: Path | str, option: str = "", endings: Sequence[str] = ()) -> None:
    """Refuse a file that cannot be written to, before the work for it is done.

    Args:
        path: The file.
        option: The option that names it; without one it is known by its path.
        endings: Endings that fit what will be in it, without the dot; none for any. A name without an ending may be.

    Raises:
        InputError: Its folder does not exist or cannot be written to, it is a folder, a device or a pipe, the command
            reads it, or writes it as something else, or its ending promises what will not be in it.
    """
    _target(path, option)
    ending = Path(path).suffix
    if endings and ending and ending[1:].lower() not in endings:
        known = ", ".join(f".{known}" for known in endings)
        raise InputError(f"{option or path}: wanted a name that ends in {known}, found {ending} in {path}")


def writable_folder(path: Path | str, option: str) -> None:
    """Refuse a folder that cannot be written into; one that is not there yet will be made.

    Raises:
        InputError: It is a file, or a name that no folder can have, or the command reads it.
    """
    _refuse_dash(path, "a folder", option)
    target = followed(path, "a folder to write to")
    found = _found(path, target)
    if found is not None and not stat.S_ISDIR(found.st_mode):
        raise InputError(f"{path}: wanted a folder to write to, found none that can be made (a file is there)")
    claim_output(path, target, option)


def _target(path: Path | str, option: str) -> Path:
    """Return the file that a path leads to, which can be written."""
    shown = Path(path)
    _refuse_dash(path, "a file", option or "an output")
    target = followed(shown)
    found = _found(shown, target)
    if found is not None and stat.S_ISDIR(found.st_mode):
        raise InputError(f"{shown}: wanted a file to write, found a folder")
    if found is not None and not stat.S_ISREG(found.st_mode):  # a device or a pipe must not give way to a file
        raise InputError(f"{shown}: wanted a file to write, found something that is no regular file")
    if not target.parent.is_dir():
        raise InputError(f"{shown}: wanted a file in a folder that exists, found no folder {shown.parent}")
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise InputError(f"{shown}: cannot be written (no permission in {target.parent})")
    claim_output(shown, target, option)
    return target


def _refuse_dash(path: Path | str, wanted: str, option: str) -> None:
    if str(path) == "-":
        raise InputError(f"{option}: wanted the name of {wanted}, found -, which would be standard output")


def _found(shown: Path | str, target: Path) -> os.stat_result | None:
    """Return what the system knows of an output that is there; None where it is to be made."""
    try:
        return target.stat()
    except (FileNotFoundError, NotADirectoryError):
        return None
    except (OSError, ValueError) as error:
        raise InputError(f"{shown}: cannot be written ({getattr(error, 'strerror', None) or error})") from error


@contextlib.contextmanager
def whole_file(path: Path | str) -> Iterator[IO[bytes]]:
    """Open a file that appears under its name only when all is written.

    A link stays a link: the file that it leads to is replaced. A file that is replaced keeps its mode.

    Raises:
        InputError: The folder does not exist or cannot be written to, or the disk is full.
    """
    temporary: Path | None = None
    try:
        target = _target(path, "")
        # Named before it is made: an interrupt at any moment finds it, and removes it.
        temporary = target.with_name(f".{target.name[:_LONGEST_MARK]}.{secrets.token_hex(6)}.part")
        with temporary.open("xb") as stream:
            yield stream
        _keep_mode(target, temporary)
        temporary.replace(target)
        note_written(path)
    except OSError as error:
        raise InputError(f"{path}: cannot be written ({error.strerror or error})") from error
    finally:
        if temporary is not None:
            with contextlib.suppress(OSError):
                temporary.unlink(missing_ok=True)


def _keep_mode(target: Path, temporary: Path) -> None:
    """Give a new file the owner, where that may be, and the mode of the file that it replaces."""
    try:
        found = target.stat()
    except OSError:
        return
    if hasattr(os, "chown"):
        with contextlib.suppress(OSError):
            os.chown(temporary, found.st_uid, found.st_gid)
    temporary.chmod(stat.S_IMODE(found.st_mode))
