"""Results as Markdown tables."""

from __future__ import annotations

from typing import Any

import numpy as np


def middle(some: list[dict[str, Any]], key: str, form: str) -> str:
    """Return a median as text."""
    return format(float(np.median([r[key] for r in some])), form) if some else "-"


def line(cells: list[str]) -> str:
    """Return a row of a table."""
    return "| " + " | ".join(cells) + " |"


def table(head: list[str], body: list[list[str]]) -> str:
    """Return a table."""
    return "\n".join(line(row) for row in [head, ["---"] * len(head), *body])


def written(page: str, mark: str, text: str) -> str:
    """Return a page with what stands between the marks of a name replaced."""
    first, last = f"<!-- {mark} -->\n", f"\n<!-- end of {mark} -->"
    low, high = page.index(first) + len(first), page.index(last)
    return page[:low] + text + page[high:]
