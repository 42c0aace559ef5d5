"""What all commands share: options, how they show a result, and that work goes on."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, TypeVar

import typer

if TYPE_CHECKING:
    from rich.console import Console

    from purcell_cli.mechanics.swimmer import Swimmer
    from purcell_cli.motion.trajectory_table import Table

D = TypeVar("D", bound=Mapping[str, object])

DONE, NOT_REACHED, MISUSE, INTERRUPTED = 0, 1, 2, 130
"""Exit codes: success; another numerical outcome; wrong usage or bad input; ended by the user."""

_WIDTH = 128
"""Columns of a table that is not shown on a terminal, where the environment does not say how many."""

Json = Annotated[bool, typer.Option("--json", help="Print one JSON document on stdout and nothing else.")]
SwimmerFile = Annotated[
    Path | None,
    typer.Option(
        "--swimmer",
        metavar="FILE",
        help="The swimmer's YAML file, a stored swimmer's name, or a plan document; else the paper's.",
    ),
]
GaitFolder = Annotated[Path | None, typer.Option("--gaits", metavar="DIR", help="A folder of your own gait files.")]


def show(document: D, json: bool, table: Callable[[Console, D], None]) -> None:
    """Print a document as JSON, or show it as tables."""
    from purcell_cli.cli.reports.common import as_json

    if json:
        print(as_json(document))
        return
    from rich.console import Console

    console = Console(highlight=False, markup=False, emoji=False)  # a name may have [ ] or : : in it
    if not console.is_terminal and not os.environ.get("COLUMNS", "").isdigit():
        console.width = _WIDTH
    table(console, document)


@contextlib.contextmanager
def busy(message: str) -> Iterator[Callable[[str], None]]:
    """Show on a terminal's stderr that work goes on; what is yielded takes how far it is."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    from rich.console import Console
    from rich.text import Text

    with Console(stderr=True).status(message) as status:
        yield lambda news: status.update(Text(f"{message}: {news}"))


@contextlib.contextmanager
def bar(message: str, after_s: float = 0.0) -> Iterator[Callable[[int, int, str], None]]:
    """Show a bar on a terminal's stderr; what is yielded takes how many are done, of how many, and the news.

    Args:
        message: What is done.
        after_s: How long the work must last before the bar is shown [s].
    """
    if not sys.stderr.isatty():
        yield lambda _done, _total, _news: None
        return
    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

    news = TextColumn("{task.description}", markup=False)
    columns = (TextColumn(message), BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), news)
    progress, begun = Progress(*columns, console=Console(stderr=True), transient=True), time.monotonic()
    task = progress.add_task("", total=None)

    def told(done: int, total: int, news: str) -> None:
        progress.update(task, completed=done, total=total, description=news)
        if not progress.live.is_started and time.monotonic() - begun >= after_s:
            progress.start()

    if after_s <= 0.0:
        progress.start()
    try:
        yield told
    finally:
        progress.stop()


def ready(swimmer: Swimmer, walled: bool = False) -> Swimmer:
    """Return a swimmer; where its links feel each other and their table must be made, that is shown.

    Args:
        swimmer: The swimmer.
        walled: Whether it may swim beside a wall: then it needs no table.
    """
    if swimmer.fluid == "beads" and not (walled and swimmer.wall is not None):
        from purcell_cli.mechanics.bead_table import bead_tables

        with bar("table of the links' drag") as progress:
            bead_tables(swimmer, lambda done, of: progress(done, of, "once for this swimmer"))
    return swimmer


def swimmer_of(path: Path | None) -> Swimmer:
    """Return the swimmer in a file of its own, a stored one, or that of a plan document; else the paper's."""
    from purcell_cli.files.builtin import find_swimmer
    from purcell_cli.files.plan_file import is_plan, load_plan
    from purcell_cli.mechanics.swimmer import Swimmer

    if path is None:
        return Swimmer()
    return load_plan(path).plan.swimmer if is_plan(path) else find_swimmer(str(path))


def fitting_swimmer(path: Path | None, table: Table, trajectory: Path, scenario: str | None = None) -> Swimmer:
    """Return whose trajectory it is, with a warning where the rows are not that swimmer's motion.

    Args:
        path: What `swimmer_of` takes.
        table: The trajectory's rows.
        trajectory: Their file.
        scenario: A scenario, by file or stored name, or a plan document: its swimmer, where no other is named.
    """
    import warnings

    from purcell_cli.errors import PurcellWarning
    from purcell_cli.files.builtin import find_scenario
    from purcell_cli.files.plan_file import is_plan
    from purcell_cli.verification.verify import MISFIT, misfit

    if path is None and scenario is not None and is_plan(scenario):
        path = Path(scenario)
    body = ready(swimmer_of(path) if path is not None or scenario is None else find_scenario(scenario).swimmer)
    if (off := misfit(table, body)) > MISFIT:
        text = f"{trajectory}: its rows move otherwise than this swimmer does (off by {off:.2g} of the joints' rates)"
        warnings.warn(f"{text}; --swimmer takes the swimmer's file or the plan document", PurcellWarning, stacklevel=2)
    return body
