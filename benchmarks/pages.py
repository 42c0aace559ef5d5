"""Tables that a benchmark writes into a page of the documentation, between two comments that name it."""

from __future__ import annotations

from pathlib import Path

DOCS = Path(__file__).resolve().parent.parent / "docs"


def put(page: str, name: str, text: str) -> None:
    """Put a text into a page, a path below docs/, between <!-- name --> and <!-- end of name -->.

    Raises:
        SystemExit: the page has no such two comments.
    """
    path, first, last = DOCS / page, f"<!-- {name} -->", f"<!-- end of {name} -->"
    before, begun, rest = path.read_text(encoding="utf-8").partition(first)
    _, ended, after = rest.partition(last)
    if not (begun and ended):
        raise SystemExit(f"{page}: wanted {first} and {last}, found none")
    path.write_text(f"{before}{first}\n\n{text}\n\n{last}{after}", encoding="utf-8")
