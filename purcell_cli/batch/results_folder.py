"""The folder of results: one batch at a time, and a journal from which a batch that was killed goes on.

Each finished scenario is one line of the journal, written after its files, with their digests. So a line
vouches for whole files, even where the power failed before all of them were on the disk. Numbers stay in
the journal and not in memory, which holds a few bytes a scenario.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from types import TracebackType
from typing import IO, Any

from filelock import BaseFileLock, FileLock, Timeout

from purcell_cli.errors import InputError, ResultsError
from purcell_cli.files.atomic_file import whole_file
from purcell_cli.frozen_dataclass import frozen_dataclass

JOURNAL, LOCK = ".purcell-batch.jsonl", ".purcell-batch.lock"
ENDINGS = (".csv", ".json")
_PART = re.compile(r"\..+\.[0-9a-f]{12}\.part")


@contextlib.contextmanager
def kept_file(path: Path) -> Iterator[IO[bytes]]:
    """Open a file of results, which appears only when all is written.

    Raises:
        ResultsError: It cannot be written.
    """
    try:
        with whole_file(path) as stream:
            yield stream
    except InputError as error:
        raise ResultsError(str(error)) from error


def write_files(folder: Path, name: str, files: Mapping[str, bytes]) -> dict[str, str]:
    """Write a scenario's files, each whole or not at all, and return their digests; files of old that it has not go.

    Raises:
        ResultsError: They cannot be written.
    """
    try:
        for ending in ENDINGS:
            if ending not in files:
                (folder / f"{name}{ending}").unlink(missing_ok=True)
        for ending, data in files.items():
            with kept_file(folder / f"{name}{ending}") as stream:
                stream.write(data)
    except ResultsError:
        raise
    except OSError as error:
        raise ResultsError(f"{folder / name}: cannot be written ({error.strerror or error})") from error
    return {ending: hashlib.sha256(data).hexdigest() for ending, data in files.items()}


@frozen_dataclass
class _Line:
    """Where a finished scenario stands in the journal."""

    key: bytes
    offset: int


class ResultsFolder:
    """The folder of a batch's results while the batch runs.

    Args:
        path: The folder; it is made where there is none.
        resume: Whether to go on from what an earlier batch finished there.

    Raises:
        InputError: Another batch is at work in the folder.
        ResultsError: The folder cannot be made or written to.
    """

    def __init__(self, path: Path, resume: bool = False) -> None:
        self.path = path
        self._lines: dict[str, _Line] = {}
        try:
            path.mkdir(parents=True, exist_ok=True)
            self._lock = _locked(path)
        except OSError as error:
            raise ResultsError(f"{path}: cannot be written ({error.strerror or error})") from error
        try:
            self._clean()
            self._journal = self._begun(resume)
        except OSError as error:
            self._lock.release()
            raise ResultsError(f"{path / JOURNAL}: cannot be written ({error.strerror or error})") from error

    def __enter__(self) -> ResultsFolder:
        """Return the folder itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Close the journal and let other batches in."""
        self._clean()
        with contextlib.suppress(OSError):
            self._journal.close()
        self._lock.release()

    def _clean(self) -> None:
        """Remove what writers that were killed left half done."""
        with contextlib.suppress(OSError):
            for entry in os.scandir(self.path):
                if _PART.fullmatch(entry.name):
                    Path(entry.path).unlink(missing_ok=True)

    def _begun(self, resume: bool) -> IO[bytes]:
        """Open the journal, with the lines in it that hold good."""
        file = self.path / JOURNAL
        kept = [line for line in _lines(file) if self._intact(line)] if resume else []
        with file.with_suffix(".new").open("wb") as stream:
            for line in kept:
                self._lines[line["name"]] = _Line(bytes.fromhex(line["key"]), stream.tell())
                stream.write(_encoded(line))
        file.with_suffix(".new").replace(file)
        return file.open("r+b")

    def _intact(self, line: Mapping[str, Any]) -> bool:
        """Return whether a scenario's files are as they were when it was finished."""
        for ending in ENDINGS:
            file, wanted = self.path / f"{line['name']}{ending}", line["files"].get(ending)
            try:
                with file.open("rb") as stream:
                    found: str | None = hashlib.file_digest(stream, "sha256").hexdigest()
            except FileNotFoundError:
                found = None
            except OSError:
                return False
            if found != wanted:
                return False
        return True

    def has(self, name: str, key: str) -> bool:
        """Return whether a scenario is finished, with just this key."""
        line = self._lines.get(name)
        return line is not None and line.key.hex() == key

    def keep(self, name: str, key: str, row: Mapping[str, Any], digests: Mapping[str, str]) -> None:
        """Note that a scenario is finished and its files are written.

        Raises:
            ResultsError: The journal cannot be written to.
        """
        try:
            offset = self._journal.seek(0, os.SEEK_END)
            self._journal.write(_encoded({"name": name, "key": key, "files": dict(digests), "row": dict(row)}))
            self._journal.flush()
        except OSError as error:
            raise ResultsError(f"{self.path / JOURNAL}: cannot be written ({error.strerror or error})") from error
        self._lines[name] = _Line(bytes.fromhex(key), offset)

    def row(self, name: str) -> dict[str, Any] | None:
        """Return the row of a finished scenario, None if it is not finished."""
        line = self._lines.get(name)
        if line is None:
            return None
        self._journal.seek(line.offset)
        row: dict[str, Any] = json.loads(self._journal.readline())["row"]
        return row

    def settle(self, order: Iterable[str]) -> None:
        """Bring the journal into the batch's order, so that it tells nothing of who was finished first."""
        with kept_file(self.path / JOURNAL) as stream:
            for name in order:
                if name in self._lines:
                    self._journal.seek(self._lines[name].offset)
                    stream.write(self._journal.readline())


def _encoded(line: Mapping[str, Any]) -> bytes:
    return json.dumps(line, allow_nan=False).encode() + b"\n"


def _lines(file: Path) -> Iterator[dict[str, Any]]:
    """Return the lines of a journal that are whole: the last one may be torn."""
    try:
        stream = file.open("rb")
    except OSError:
        return
    with stream:
        for text in stream:
            try:
                line = json.loads(text)
                whole = (
                    text.endswith(b"\n")
                    and re.fullmatch(r"[0-9a-f]{64}", line["key"])
                    and isinstance(line["row"], dict)
                    and isinstance(line["files"], dict)
                    and Path(line["name"]).name == line["name"]
                )
            except (ValueError, LookupError, TypeError):
                continue
            if whole:
                yield line


def _locked(folder: Path) -> BaseFileLock:
    """Return the lock that keeps other batches out; the system frees it however the process ends.

    Raises:
        InputError: Another batch has it.
        OSError: The lock's file cannot be made.
    """
    lock = FileLock(folder / LOCK, blocking=False)
    try:
        lock.acquire()
    except Timeout:
        raise InputError(f"{folder}: wanted a folder of its own, found another batch at work in it") from None
    return lock
