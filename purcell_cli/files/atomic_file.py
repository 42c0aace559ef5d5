"""Files that are replaced whole, or not at all."""

from __future__ import annotations

import contextlib
import os
import secrets
from collections.abc import Iterator
from pathlib import Path
from typing import IO

from purcell_cli.errors import InputError


def writable(path: Path | str) -> None:
    """Refuse a file that cannot be written to, before the work for it is done.

    Raises:
        InputError: Its folder does not exist or cannot be written to, or it is a folder, a device or a pipe.
    """
    target = Path(path)
    if target.is_dir():
        raise InputError(f"{target}: wanted a file to write, found a folder")
    if target.exists() and not target.is_file():  # a device or a pipe must not give way to a file
        raise InputError(f"{target}: wanted a file to write, found something that is no regular file")
    if not target.parent.is_dir():
        raise InputError(f"{target}: wanted a file in a folder that exists, found no folder {target.parent}")
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise InputError(f"{target}: cannot be written (no permission in {target.parent})")


@contextlib.contextmanager
def whole_file(path: Path | str) -> Iterator[IO[bytes]]:
    """Open a file that appears under its name only when all is written.

    Raises:
        InputError: The folder does not exist or cannot be written to, or the disk is full.
    """
    target = Path(path)
    # Named before it is made: an interrupt at any moment finds it, and removes it.
    temporary = target.with_name(f".{target.name[:80]}.{secrets.token_hex(6)}.part")
    try:
        writable(target)
        with temporary.open("xb") as stream:
            yield stream
        temporary.replace(target)
    except OSError as error:
        raise InputError(f"{target}: cannot be written ({error.strerror or error})") from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)
