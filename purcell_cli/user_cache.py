"""What takes long to compute and depends on little is kept in the user's cache folder.

A file that is missing, cut short or otherwise damaged is computed again. Processes that want the same at once wait for
the one that computes it. Where nothing can be written, nothing is kept.
"""

from __future__ import annotations

import contextlib
import hashlib
import io
import os
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_DIGEST_BYTES = hashlib.sha256().digest_size
"""A file begins with the digest of the rest."""


def folder() -> Path:
    """Return the user's cache folder for this program; the environment's XDG_CACHE_HOME moves it where that counts."""
    from platformdirs import user_cache_path

    return user_cache_path("purcell", appauthor=False)


def kept(name: str, key: str, make: Callable[[], Array]) -> Array:
    """Return an array that is kept in the user's cache folder, and made where it is not there.

    Args:
        name: What it is, as a part of the file's name.
        key: All that it depends on.
        make: Makes it.
    """
    file = folder() / f"{name}-{hashlib.sha256(key.encode()).hexdigest()[:24]}.bin"
    found = _read(file)
    if found is not None:
        return found
    with _alone(file):
        found = _read(file)  # another process may have made it meanwhile
        if found is None:
            found = make()
            _write(file, found)
    return found


def _read(file: Path) -> Array | None:
    """Return the array in a file, or None where there is none that is whole."""
    try:
        content = file.read_bytes()
    except OSError:
        return None
    digest, rest = content[:_DIGEST_BYTES], content[_DIGEST_BYTES:]
    if hashlib.sha256(rest).digest() != digest:
        return None
    return np.asarray(np.load(io.BytesIO(rest), allow_pickle=False), dtype=np.float64)


def _write(file: Path, array: Array) -> None:
    """Write a file whole or not at all; where that cannot be, leave it."""
    rest = io.BytesIO()
    np.save(rest, array, allow_pickle=False)
    with contextlib.suppress(OSError):
        handle, part = tempfile.mkstemp(dir=file.parent, prefix=file.stem, suffix=".part")
        try:
            with os.fdopen(handle, "wb") as stream:
                stream.write(hashlib.sha256(rest.getvalue()).digest() + rest.getvalue())
            Path(part).replace(file)
        except BaseException:
            Path(part).unlink(missing_ok=True)
            raise


@contextlib.contextmanager
def _alone(file: Path) -> Iterator[None]:
    """Hold the lock of a file, where its folder can be written to."""
    from filelock import FileLock

    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        lock = FileLock(file.with_suffix(".lock"))
        lock.acquire()
    except OSError:
        yield
        return
    try:
        yield
    finally:
        lock.release()
