"""One vocabulary: the glossary is in order and has its sources, and no user reads an inner word."""

from __future__ import annotations

import importlib.util
import re

import pytest
from pages import DOCS, PAGES, ROOT, known_options, tool

INNER = (
    "word ?books?", "needle alone", "cranks?", "haste", "detours?", "witness(es)?", "(?<!of )courses?",
)  # fmt: skip
"""Words of the programmers that have a word of the field in the glossary."""
_INNER = re.compile(rf"\b({'|'.join(INNER)})\b", re.IGNORECASE)
_ROW = re.compile(r"^\| \*\*(.+?)\*\* \| (.+?) \| (.+?) \|$", re.MULTILINE)
TERMS = _ROW.findall(PAGES["docs/glossary.md"])


def test_the_glossary_is_alphabetical_and_has_no_duplicates() -> None:
    names = [term.lower() for term, _, _ in TERMS]
    assert len(names) >= 40
    assert names == sorted(set(names))
    assert PAGES["docs/glossary.md"].count("\n| ") == len(names) + 2


@pytest.mark.parametrize(("term", "meaning", "source"), TERMS, ids=[term for term, _, _ in TERMS])
def test_a_term_has_one_sentence_and_a_source(term: str, meaning: str, source: str) -> None:
    assert re.fullmatch(r"[A-Z][^|]*\.", meaning), term
    assert ". " not in meaning, term
    links = re.findall(r"\]\(([^)#]+)", source)
    modules = re.findall(r"`(purcell_cli[\w.]*)`", source)
    assert re.search(r"(section [IV]+(-[A-D])?|appendix [AB]|\b(19|20)\d\d\b|gait `|Betts)", source) or links or modules
    assert all((DOCS / link).exists() or link == "reference/commands.md" for link in links)
    assert all(importlib.util.find_spec(module) for module in modules)


def test_pages_have_no_inner_word() -> None:
    beside = {name: (ROOT / name).read_text(encoding="utf-8") for name in ("CHANGELOG.md", "CONTRIBUTING.md")}
    found = {page: hits for page, text in (PAGES | beside).items() if (hits := [m[0] for m in _INNER.finditer(text)])}
    assert found == {}


def test_help_has_no_inner_word() -> None:
    text = tool("site_hooks").commands_page()
    assert all(f"\n## {command}\n" in text for command in known_options())
    assert _INNER.findall(text) == []


@pytest.mark.parametrize(
    "text", ["a word book", "the wordbook", "the needle alone", "two cranks", "a detour", "witness", "the course"]
)
def test_inner_words_are_found(text: str) -> None:
    assert _INNER.search(text)
    assert not _INNER.search("of course, needle steering")
