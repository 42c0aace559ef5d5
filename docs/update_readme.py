"""Write the true outputs of the README's transcripts into it: ``python docs/update_readme.py``.

The README marks what is real by a comment before a fenced block:

- ``<!-- file: PATH -->``: a file that the reader is to write; every transcript finds it in its folder.
- ``<!-- transcript -->``: lines ``$ purcell ...``, each followed by its exact standard output. All
  transcripts begin in folders of their own, which hold those files and nothing else.
- ``<!-- transcript: exit N -->``: the same, where the last command ends with exit code N.
- ``<!-- library -->``: a Python program.

``tests/test_readme.py`` reads the README by the functions here.
"""

from __future__ import annotations

import os
import re
import shlex
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

README = Path(__file__).resolve().parent.parent / "README.md"
PAGES = (README, README.parent / "docs" / "controllability.md")

_BLOCK = re.compile(r"^<!-- (?P<mark>[^\n]*?) -->\n```\w*\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL)
_COMMAND = "from purcell_cli.cli.app import main; main()"
_STEERING = ("COLUMNS", "LINES", "NO_COLOR", "FORCE_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE", "TERM")


@dataclass(frozen=True)
class Block:
    """A marked block of the README.

    Attributes:
        kind: What it is: file, transcript, library, setup or another word.
        detail: What the mark says about it after a colon.
        body: The lines between the fences.
        span: Where the body is in the README.
    """

    kind: str
    detail: str
    body: str
    span: tuple[int, int]

    @property
    def exit_code(self) -> int:
        """The exit code that a transcript's last command ends with."""
        return int(self.detail.removeprefix("exit ") or 0)

    @property
    def commands(self) -> list[str]:
        """The commands of a transcript, in order."""
        return [line[2:] for line in self.body.splitlines() if line.startswith("$ ")]


def blocks(text: str) -> list[Block]:
    """Return the marked blocks of a README's text."""
    out = []
    for match in _BLOCK.finditer(text):
        kind, _, detail = match["mark"].partition(":")
        out.append(Block(kind.strip(), detail.strip(), match["body"], match.span("body")))
    return out


def write_files(folder: Path, text: str) -> None:
    """Write the files that a README's text shows into a folder."""
    for block in blocks(text):
        if block.kind == "file":
            path = folder / block.detail
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.body, encoding="utf-8")


def python(arguments: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run this Python in a folder, its output not on a terminal."""
    surroundings = {name: value for name, value in os.environ.items() if name not in _STEERING}
    return subprocess.run(  # noqa: S603  # the README's own words
        [sys.executable, *arguments],
        cwd=folder,
        env={**surroundings, "PYTHONIOENCODING": "utf-8"},
        capture_output=True,
        encoding="utf-8",
        check=False,
    )


def played(block: Block, text: str) -> str:
    """Return a transcript with the true outputs of its commands.

    Args:
        block: The transcript.
        text: The README's text, for its files.

    Raises:
        RuntimeError: A command that is not `purcell`, or another exit code than the one the mark says.
    """
    lines = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_files(folder, text)
        wanted = [0] * (len(block.commands) - 1) + [block.exit_code]
        for command, code in zip(block.commands, wanted, strict=True):
            program, *arguments = shlex.split(command)
            if program != "purcell":
                raise RuntimeError(f"{command}: a transcript runs purcell and nothing else")
            done = python(["-c", _COMMAND, *arguments], folder)
            if done.returncode != code:
                raise RuntimeError(f"{command}: exit code {done.returncode}, not {code}\n{done.stdout}{done.stderr}")
            lines += [f"$ {command}", *done.stdout.rstrip().splitlines()]
    return "".join(f"{line.rstrip()}\n" for line in lines)


def all_played(text: str) -> list[tuple[Block, str]]:
    """Return every transcript of a README's text with its true outputs."""
    transcripts = [block for block in blocks(text) if block.kind == "transcript"]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        return list(zip(transcripts, pool.map(lambda block: played(block, text), transcripts), strict=True))


def main() -> None:
    """Bring the README and the pages with transcripts up to date."""
    changed = sum(renewed(page) for page in PAGES)
    sys.stdout.write(f"{changed} transcripts changed\n")


def renewed(page: Path) -> int:
    """Write the true outputs into a page and return how many have changed."""
    text = page.read_text(encoding="utf-8")
    changed = 0
    for block, true in reversed(all_played(text)):
        changed += block.body != true
        text = text[: block.span[0]] + true + text[block.span[1] :]
    page.write_text(text, encoding="utf-8")
    return changed


if __name__ == "__main__":
    main()
