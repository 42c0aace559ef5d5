"""The command `purcell batch`: many scenarios at once."""

from __future__ import annotations

import contextlib
import os
import sys
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from purcell_cli.cli.options import takes_plan_options
from purcell_cli.cli.terminal import DONE, NOT_REACHED, GaitFolder, Json, show
from purcell_cli.errors import PurcellWarning
from purcell_cli.motion.options import PlanOptions
from purcell_cli.wording import counted

if TYPE_CHECKING:
    from rich.console import Console

    from purcell_cli.batch.runner import Options, Outcome
    from purcell_cli.cli.documents.batch import BatchDocument
    from purcell_cli.gaits.gait import Gait

_SECONDS_BETWEEN_LINES = 10.0
"""How often a batch says on a pipe how far it is [s]: a night's log has some three thousand such lines."""


_MOST_TOLD = 10
"""How many names of scenarios that vanished are listed on stderr; the document has all."""


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command(epilog="Example: purcell batch scenarios/ --jobs 4 --junit report.xml")(batch)


@takes_plan_options
def batch(
    paths: Annotated[
        list[str],
        typer.Argument(
            metavar="PATH", help="Scenarios: YAML files, folders, patterns in quotes, or stored scenarios' names."
        ),
    ],
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="The folder of results.")] = Path("purcell-results"),
    jobs: Annotated[
        int | None, typer.Option("--jobs", metavar="N", min=1, max=1024, help="Worker processes; default: the cores.")
    ] = None,
    resume: Annotated[bool, typer.Option("--resume", help="Redo only what is not finished in the folder.")] = False,
    name_filter: Annotated[
        str | None,
        typer.Option("--filter", metavar="TEXT", help="Only scenarios with this in their name; or a pattern with *."),
    ] = None,
    no_trajectories: Annotated[bool, typer.Option("--no-trajectories", help="Write no NAME.csv for each.")] = False,
    junit: Annotated[Path | None, typer.Option("--junit", metavar="FILE", help="Write a JUnit report.")] = None,
    parquet: Annotated[bool, typer.Option("--parquet", help="Write summary.parquet too.")] = False,
    baseline: Annotated[
        Path | None,
        typer.Option("--baseline", metavar="FILE", help="Compare with the summary.json of an earlier run."),
    ] = None,
    max_regress: Annotated[
        str,
        typer.Option(
            "--max-regress", metavar="PART", help="How much more travel or error may be than then: 5% or 0.05."
        ),
    ] = "5%",
    dask: Annotated[
        str | None,
        typer.Option("--dask", metavar="ADDRESS", help="Send scenarios to a Dask scheduler, such as tcp://host:8786."),
    ] = None,
    gaits: GaitFolder = None,
    options: PlanOptions = PlanOptions(),
    json: Json = False,
) -> int:
    """Plan many scenarios with several workers, and judge each by what it expects."""
    from purcell_cli.batch.cases import find_cases
    from purcell_cli.batch.claims import claim_report
    from purcell_cli.batch.expectations import fraction, load_baseline
    from purcell_cli.batch.runner import Options, run_batch
    from purcell_cli.batch.solve_one import Settings
    from purcell_cli.files.paths import followed

    settings = Settings(
        options,
        not no_trajectories,
        None if gaits is None else _own_gaits(gaits),
        followed(out, "a folder to write to"),
    )
    most = fraction(max_regress)
    earlier = None if baseline is None else load_baseline(baseline, most)
    cases = find_cases(paths, name_filter, out)
    if junit is not None:
        claim_report(junit)
    vanished = None if earlier is None else earlier.vanished(cases.names(), cases.asked_for)
    if vanished:
        told = ", ".join([*vanished[:_MOST_TOLD], *["..."][: len(vanished) - _MOST_TOLD]])
        many = counted(len(vanished), "scenario")
        warnings.warn(f"{many} of the baseline not in this batch: {told}", PurcellWarning, stacklevel=2)
    task = Options(out, jobs or _cores(), dask, resume, junit, parquet, earlier)
    with _progress(cases.count) as progress:
        outcome = run_batch(cases, settings, task, progress, lambda line: print(line, file=sys.stderr))
    show(_document(outcome, task, cases.passed_over, vanished), json, _show)
    return NOT_REACHED if outcome.failed else DONE


def _own_gaits(folder: Path) -> Mapping[str, Gait]:
    """Return the user's gaits, those named that plans will leave out, as they are for the paper's swimmer."""
    from purcell_cli.files.builtin import own_gaits
    from purcell_cli.mechanics.swimmer import Swimmer
    from purcell_cli.planner.gait_sequence import unfit_gaits

    own = own_gaits(folder)
    for name, why in unfit_gaits(own.values(), Swimmer()).items():
        print(f"gait {name} is left out: {why}", file=sys.stderr)
    return own


def _cores() -> int:
    """Return how many cores this process may use."""
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity else os.cpu_count() or 1


@contextlib.contextmanager
def _progress(count: int) -> Iterator[Callable[[Outcome, dict[str, Any]], None]]:
    """Show on stderr how far the batch is: a bar on a terminal, plain lines in a log."""
    if not sys.stderr.isatty():
        yield _lines(count)
        return
    from rich import progress as rich
    from rich.console import Console

    columns = (
        rich.TextColumn("{task.description}", markup=False),
        rich.BarColumn(),
        rich.MofNCompleteColumn(),
        rich.TextColumn("{task.fields[rate]}"),
        rich.TimeRemainingColumn(),
        rich.TextColumn("{task.fields[failed]}"),
    )
    begun, failed = time.monotonic(), 0
    with rich.Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("planning", total=count, rate="", failed="")

        def tell(outcome: Outcome, row: dict[str, Any]) -> None:
            nonlocal failed
            failed += bool(row["reasons"])
            rate = outcome.solved / max(time.monotonic() - begun, 1e-9)
            bad = f"[red]{failed} failed[/]" if failed else ""
            bar.update(task, completed=outcome.scenarios, rate=_pace(rate), failed=bad)

        yield tell


def _pace(rate: float) -> str:
    """Return how many scenarios are solved in a second, in words."""
    return f"{rate:.3g} a second" if rate else "all finished before"


def _lines(count: int) -> Callable[[Outcome, dict[str, Any]], None]:
    """Return what prints a line for each failure, and one every few seconds."""
    begun = last = time.monotonic()

    def tell(outcome: Outcome, row: dict[str, Any]) -> None:
        nonlocal last
        now, finished = time.monotonic(), outcome.scenarios
        for reason in row["reasons"]:
            print(f"{row['name']}: {reason}", file=sys.stderr)
        if now - last >= _SECONDS_BETWEEN_LINES or finished == count:
            last = now
            rate = outcome.solved / max(now - begun, 1e-9)
            left = f", {(count - finished) / rate:.0f} s left" if rate and finished < count else ""
            print(f"{finished} of {count} scenarios, {_pace(rate)}{left}", file=sys.stderr)

    return tell


def _document(outcome: Outcome, options: Options, passed_over: int, vanished: list[str] | None) -> BatchDocument:
    return {
        "schema": "purcell/batch/1",
        "verdict": outcome.verdict,
        "scenarios": outcome.scenarios,
        "solved": outcome.solved,
        "failed": outcome.failed,
        "crashed": outcome.crashed,
        "compared": outcome.compared if options.baseline is not None else None,
        "vanished": vanished,
        "failures": [
            {"name": row["name"], "file": row["file"], "verdict": row["verdict"], "reasons": row["reasons"]}
            for row in outcome.failures
        ],
        "wall_time_s": outcome.wall_time_s,
        "folder": str(options.folder),
        "junit": None if options.junit is None else str(options.junit),
        "passed_over": passed_over,
    }


def _show(console: Console, document: BatchDocument) -> None:
    from rich.table import Table

    if document["failures"]:
        table = Table(title="Failures", title_justify="left")
        for heading in ("scenario", "verdict", "why"):
            table.add_column(heading, overflow="fold")
        for row in document["failures"]:
            table.add_row(row["name"], row["verdict"], "\n".join(row["reasons"]))
        console.print(table)
        if document["failed"] > len(document["failures"]):
            console.print(f"and {document['failed'] - len(document['failures'])} more; the summary has all")
    told = "" if document["compared"] is None else f", {document['compared']} of them in the baseline"
    before = document["scenarios"] - document["solved"]
    told += f", {before} finished before" if before else ""
    console.print(f"{counted(document['scenarios'], 'scenario')}{told}, {document['failed']} failed")
    if document["passed_over"]:
        others = counted(document["passed_over"], "file")
        console.print(f"passed over {others} of a configuration or a swimmer")
    colour = "green" if document["verdict"] == "passed" else "red"
    console.print(document["verdict"], style=colour)
    console.print(f"results in {document['folder']}", soft_wrap=True)
