"""The package polars, which reads and writes tables: imported only where it is used, since that takes long."""

from __future__ import annotations

import signal
import threading
from types import FrameType
from typing import Any


def polars() -> Any:
    """Return the polars package: slow to import, and fast at reading tables.

    An interrupt waits until it is imported, which would end in a panic otherwise.
    """
    held: list[tuple[int, FrameType | None]] = []
    before = signal.getsignal(signal.SIGINT)
    ours = callable(before) and threading.current_thread() is threading.main_thread()
    if ours:
        signal.signal(signal.SIGINT, lambda number, frame: held.append((number, frame)))
    try:
        import polars as pl
    finally:
        if ours:
            signal.signal(signal.SIGINT, before)
    if held and callable(before):
        before(*held[0])
    return pl
