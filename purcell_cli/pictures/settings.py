"""matplotlib imported as it comes, whatever settings the user has for pictures of their own."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path


@contextlib.contextmanager
def untouched_by_the_user() -> Iterator[None]:
    """Have matplotlib imported inside with its own settings, unless it is imported already.

    It reads `MPLBACKEND`, which notebooks set to what may not be installed here, and a file of settings, the one in
    the working folder before all others; either may keep it from being imported at all. For that time the working
    folder is the one with matplotlib's own file of settings.
    """
    found = None if "matplotlib" in sys.modules else find_spec("matplotlib")
    if found is None or found.origin is None:
        yield
        return
    backend = os.environ.pop("MPLBACKEND", None)
    try:
        with contextlib.chdir(Path(found.origin).parent / "mpl-data"):
            yield
    finally:
        if backend is not None:
            os.environ["MPLBACKEND"] = backend
