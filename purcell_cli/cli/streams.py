"""Standard output and error that no disk, pipe or encoding ends in a traceback.

What stdout cannot encode is escaped; a reader that closes its pipe has what it wanted, so the command goes on to its
own end; a disk that is full is told once. stderr, and a stream that was closed before the command began, swallow
everything.
"""

from __future__ import annotations

import contextlib
import io
import os
import sys
from collections.abc import Iterator
from typing import TextIO


class _Sink(io.RawIOBase):
    """The file of a standard stream; once it fails it takes everything and writes nothing.

    Args:
        number: The file's number.
        tells: Whether a fault other than a closed pipe is raised, once.
    """

    def __init__(self, number: int, tells: bool) -> None:
        super().__init__()
        self._number, self._tells, self._broken = number, tells, False

    def writable(self) -> bool:
        """Return that it can be written to."""
        return True

    def fileno(self) -> int:
        """Return the file's number."""
        return self._number

    def isatty(self) -> bool:
        """Return whether it is a terminal."""
        return os.isatty(self._number)

    def write(self, data: object) -> int:
        """Write bytes, and return how many."""
        view = memoryview(data)  # type: ignore[arg-type]  # whatever has bytes
        if not self._broken:
            try:
                return os.write(self._number, view)
            except OSError as error:
                self._broken = True
                if self._tells and not isinstance(error, BrokenPipeError):
                    raise
        return view.nbytes


def _stream(number: int, before: TextIO | None, *, tells: bool) -> TextIO:
    """Return a stream of text to a file's number, with the encoding of the one before."""
    encoding = getattr(before, "encoding", None) or "utf-8"
    buffer = io.BufferedWriter(_Sink(number, tells))
    line_buffering = number == 2 or os.isatty(number)
    return io.TextIOWrapper(buffer, encoding, "backslashreplace", line_buffering=line_buffering)


def _open_all() -> None:
    """Open the null device in place of standard streams that are closed, so that no other file gets their numbers."""
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # gets the lowest number that is free, which is this one


@contextlib.contextmanager
def robust_streams() -> Iterator[None]:
    """Run a command with streams that do not fail, and flush them at its end.

    Raises:
        OSError: Standard output cannot be written: the disk is full.
    """
    _open_all()
    if sys.platform == "win32" and sys.stdout is not None and sys.stdout.isatty():
        yield  # a console there is no file
        return
    out, err = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = _stream(1, out, tells=True), _stream(2, err, tells=False)
    yield
    sys.stdout.flush()
    sys.stderr.flush()
