"""Paths as the user means them: what stands there, without exceptions, and where links lead."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from purcell_cli.errors import InputError

_MOST_LINKS = 40
"""Links that are followed one after the other: as many as Linux follows."""

_SYSTEM_FOLDERS = ("/dev", "/proc", "/sys")
"""Where devices stand, and links to what a process has open."""

_MEMORY_FOLDERS = ("/dev/shm", "/dev/mqueue")  # noqa: S108  # named, not written to
"""Folders among the devices that hold files all the same."""


class UnreadableError(Exception):
    """A file that cannot be read; the message says why."""


def status(path: Path | str) -> os.stat_result | None:
    """Return what the system knows of a file, links followed; None where there is no such file, or no such name."""
    try:
        return Path(path).stat()
    except (OSError, ValueError):
        return None


def is_file(path: Path | str) -> bool:
    """Return whether a path leads to a regular file; a name that no file can have leads to none."""
    found = status(path)
    return found is not None and stat.S_ISREG(found.st_mode)


def is_folder(path: Path | str) -> bool:
    """Return whether a path leads to a folder; a name that no folder can have leads to none."""
    found = status(path)
    return found is not None and stat.S_ISDIR(found.st_mode)


def is_link(path: Path | str) -> bool:
    """Return whether a path is a link itself, wherever it leads."""
    try:
        return stat.S_ISLNK(Path(path).lstat().st_mode)
    except (OSError, ValueError):
        return False


def readable(path: Path | str) -> os.stat_result:
    """Return what the system knows of a regular file.

    Raises:
        UnreadableError: There is none, or it is a folder or a device; the message says what was found.
    """
    try:
        found = Path(path).stat()
    except FileNotFoundError:
        raise UnreadableError("none: no such file") from None
    except OSError as error:
        raise UnreadableError(f"none ({error.strerror or error})") from error
    except ValueError as error:
        raise UnreadableError(f"none ({error})") from error
    if not stat.S_ISREG(found.st_mode):
        raise UnreadableError("a directory" if stat.S_ISDIR(found.st_mode) else "something that is no regular file")
    return found


def followed(path: Path | str, wanted: str = "a file to write") -> Path:
    """Return where a path leads, which need not be there yet: all links followed.

    Args:
        path: The path.
        wanted: What it is to be, for messages.

    Raises:
        InputError: The links lead round, or to a device, or to what a process has open.
    """
    shown, here = Path(path), Path(path)
    for _ in range(_MOST_LINKS):
        here = Path(os.path.realpath(here.parent)) / here.name
        if _is_systems(here):
            raise InputError(f"{shown}: wanted {wanted}, found a way to a device or to an open file")
        try:
            here = here.parent / here.readlink()
        except (OSError, ValueError):  # no link
            return here
    raise InputError(f"{shown}: wanted {wanted}, found links that lead round")


def _is_systems(path: Path) -> bool:
    """Return whether a path stands where devices do."""
    if any(path.is_relative_to(folder) for folder in _MEMORY_FOLDERS):
        return False
    return any(path.is_relative_to(folder) for folder in _SYSTEM_FOLDERS)
