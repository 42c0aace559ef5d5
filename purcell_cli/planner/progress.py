"""What a search tells of its progress."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[int, int, str], None]
"""Is told how many motions are refined, of how many, and in words what was found."""


def silent(_done: int, _of: int, _news: str) -> None:
    """Tell nobody."""
