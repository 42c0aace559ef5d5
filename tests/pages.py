"""What the tests of the README and the site share: their texts, their marked blocks, and what writes them."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path
from types import ModuleType

ROOT = Path(__file__).resolve().parent.parent
DOCS = ROOT / "docs"


def tool(name: str) -> ModuleType:
    """Return a script of the folder `tools` as a module."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "tools" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # where dataclasses look for it
    spec.loader.exec_module(module)
    return module


update = tool("update_docs")
PAGES = {path.relative_to(ROOT).as_posix(): path.read_text(encoding="utf-8") for path in update.pages()}
"""The text of the README and of every page of the site, by path."""
README = PAGES["README.md"]


def only(page: str, kind: str, detail: str = "") -> str:
    """Return the body of the one block of a page with a mark."""
    (block,) = [b for b in update.blocks(PAGES[page]) if b.kind == kind and (not detail or b.detail == detail)]
    return block.body


def known_options() -> dict[str, set[str]]:
    """Return the options of every command."""
    from purcell_cli.cli.app import built

    return {
        name: {"--help"} | {option for p in command.params for option in (*p.opts, *p.secondary_opts)}
        for name, command in built().commands.items()
    }


def shown_commands(text: str) -> list[tuple[str, list[str]]]:
    """Return the commands that a text shows in code, with the options given to each."""
    code = re.findall(r"`(purcell [^`]*)`", text)
    for fenced in re.findall(r"^```\w*\n(.*?)^```$", text, re.MULTILINE | re.DOTALL):
        code += re.findall(r"^ *(?:\$ |- run: )?(?:.*&& )?(purcell .*)$", fenced, re.MULTILINE)
    out = []
    for line in code:
        words = line.split()
        if words[1][0] != "-" and words[1].islower():
            out.append((words[1], [word.rstrip(",.;:") for word in words[2:] if word.startswith("--")]))
    return out
