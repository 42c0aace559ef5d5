"""Write what the README and the site show anew, all of it: ``python tools/update_docs.py``.

Transcripts are played, tables computed, and the picture of a plan is drawn. The pictures of the gaits show nothing that
a planner changes: ``python tools/gait_gallery.py`` draws them. The pages mark what is real by a comment before a
fenced block:

- ``<!-- file: PATH -->``: a file that the reader is to write; every transcript of the page finds it in its folder.
- ``<!-- transcript -->``: lines ``$ purcell ...``, each followed by its exact standard output. All
  transcripts begin in folders of their own, which hold the page's files and nothing else.
- ``<!-- transcript: exit N -->``: the same, where the last command ends with exit code N.
- ``<!-- library -->``: a Python program, whose ``print`` lines say in a comment what they print.

The tests read the pages by the functions here.
"""

from __future__ import annotations

import difflib
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
README = ROOT / "README.md"
DOCS = ROOT / "docs"
SIMULTANEOUS = DOCS / "how-to" / "simultaneous.md"

_BLOCK = re.compile(r"^<!-- (?P<mark>[^\n]*?) -->\n```\w*\n(?P<body>.*?)^```$", re.MULTILINE | re.DOTALL)
_TIMES = re.compile(r"(?<=<!-- times -->\n).*?(?=<!-- end of times -->)", re.DOTALL)
_ROUND_OFF = re.compile(r"(?<![\d.])(?:\d(?:\.\d+)?e-(?:1[1-9]|[2-9]\d|\d{3})|0\.0e\+00)")
_COMMAND = "from purcell_cli.cli.app import main; main()"
_STEERING = ("COLUMNS", "LINES", "NO_COLOR", "FORCE_COLOR", "TTY_COMPATIBLE", "TTY_INTERACTIVE", "TERM")


@dataclass(frozen=True)
class Block:
    """A marked block of a page.

    Attributes:
        kind: What it is: file, transcript, library, setup or another word.
        detail: What the mark says about it after a colon.
        body: The lines between the fences.
        span: Where the body is in the page.
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


def pages() -> list[Path]:
    """Return the README and every page of the site, in the order of their names."""
    return [README, *sorted(DOCS.rglob("*.md"))]


def blocks(text: str) -> list[Block]:
    """Return the marked blocks of a page's text."""
    out = []
    for match in _BLOCK.finditer(text):
        kind, _, detail = match["mark"].partition(":")
        out.append(Block(kind.strip(), detail.strip(), match["body"], match.span("body")))
    return out


def write_files(folder: Path, text: str) -> None:
    """Write the files that a page's text shows into a folder."""
    for block in blocks(text):
        if block.kind == "file":
            path = folder / block.detail
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(block.body, encoding="utf-8")


def python(arguments: list[str], folder: Path) -> subprocess.CompletedProcess[str]:
    """Run this Python in a folder, its output not on a terminal."""
    surroundings = {name: value for name, value in os.environ.items() if name not in _STEERING}
    return subprocess.run(  # noqa: S603  # the pages' own words
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
        text: The page's text, for its files.

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


def all_played(texts: Iterable[str]) -> list[list[tuple[Block, str]]]:
    """Return every transcript of every text with its true outputs, text by text."""
    found = [[(block, text) for block in blocks(text) if block.kind == "transcript"] for text in texts]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        futures = [[(block, pool.submit(played, block, text)) for block, text in page] for page in found]
        return [[(block, future.result()) for block, future in page] for page in futures]


def without_round_off(text: str) -> str:
    """Return an output with figures of 1e-11 and less made alike: another processor rounds otherwise."""
    return _ROUND_OFF.sub("~", text)


def renewed(text: str, transcripts: list[tuple[Block, str]]) -> str:
    """Return a page's text with the true outputs of its transcripts; lines that differ by round-off stay."""
    for block, true in reversed(transcripts):
        text = text[: block.span[0]] + _but_for_round_off(block.body, true) + text[block.span[1] :]
    return text


def _but_for_round_off(old: str, new: str) -> str:
    """Return a new output, with the old lines where the new ones differ from them by round-off alone."""
    before, after = old.splitlines(keepends=True), new.splitlines(keepends=True)
    alike = [[without_round_off(line) for line in lines] for lines in (before, after)]
    out = after[:]
    for same in difflib.SequenceMatcher(None, *alike, autojunk=False).get_matching_blocks():
        out[same.b : same.b + same.size] = before[same.a : same.a + same.size]
    return "".join(out)


def times_table() -> str:
    """Return how long motions take by primitives and with all joints at once, planned anew, as a table."""
    from purcell_cli import Configuration, PlanOptions, Swimmer, load_scenario, plan, stored_scenarios

    stored = [
        (f"`{name}`", load_scenario(stored_scenarios()[name]))
        for name in ("nearby", "along-y", "planar-manoeuvre", "far")
    ]
    asked = [(name, s.start, s.goal, s.swimmer) for name, s in stored]
    ahead = Configuration.from_angles(position_m=[2.0, 0.0, 0.0])
    asked += [("20 L along x", Configuration(), ahead, Swimmer(max_bend_rad=bend)) for bend in (1.0, 1.6)]
    rows = ["| motion | bend limit [rad] | primitive [s] | simultaneous [s] |", "| --- | --- | --- | --- |"]
    for name, start, goal, swimmer in asked:
        took = [
            plan(start, goal, swimmer=swimmer, options=PlanOptions(controls=c)).duration_s
            for c in ("primitive", "simultaneous")
        ]
        rows.append(f"| {name} | {swimmer.max_bend_rad:g} | {took[0]:.1f} | {took[1]:.1f} |")
    return "\n".join(rows) + "\n"


def main() -> None:
    """Bring everything up to date and say which files have changed."""
    import gait_gallery
    import mission_pictures
    import plan_picture

    before = {path: path.read_bytes() for path in [README, *DOCS.rglob("*.*")] if path.is_file()}
    gait_gallery.PAGE.write_text(gait_gallery.page(), encoding="utf-8")
    plan_picture.main()
    mission_pictures.main()
    table = times_table()
    SIMULTANEOUS.write_text(_TIMES.sub(lambda _: table, SIMULTANEOUS.read_text(encoding="utf-8")), encoding="utf-8")
    texts = [page.read_text(encoding="utf-8") for page in pages()]
    for page, text, transcripts in zip(pages(), texts, all_played(texts), strict=True):
        if (true := renewed(text, transcripts)) != text:
            page.write_text(true, encoding="utf-8")
    changed = [path for path in [README, *sorted(DOCS.rglob("*.*"))] if path.read_bytes() != before.get(path)]
    sys.stdout.write("".join(f"{path.relative_to(ROOT)}\n" for path in changed) + f"{len(changed)} files changed\n")


if __name__ == "__main__":
    main()
