"""Warnings of the package as lines on stderr, each once: stdout is for results."""

from __future__ import annotations

import contextlib
import sys
import warnings
from collections.abc import Iterator
from typing import Any

from purcell_cli.errors import PurcellWarning


@contextlib.contextmanager
def warnings_on_stderr(command: str) -> Iterator[None]:
    """Print warnings of the package as they come, whatever filters are set; all others are left as they are.

    Args:
        command: The command, whose name stands before them.
    """
    told: set[str] = set()

    def show(message: Any, category: type[Warning], *where: Any, **more: Any) -> None:
        if not issubclass(category, PurcellWarning):
            before(message, category, *where, **more)
        elif str(message) not in told:
            told.add(str(message))
            print(f"purcell {command}: warning: {message}", file=sys.stderr)

    with warnings.catch_warnings():
        warnings.simplefilter("always", PurcellWarning)
        before = warnings.showwarning
        warnings.showwarning = show
        yield
