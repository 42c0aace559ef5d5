"""A batch from end to end: what is finished already, the rest solved, everything judged, the summary written."""

from __future__ import annotations

import contextlib
import dataclasses
import hashlib
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, Literal, cast

from purcell_cli.batch import dask_workers, junit, local_workers, summary
from purcell_cli.batch.cases import Case, Cases
from purcell_cli.batch.expectations import Baseline, shortfalls
from purcell_cli.batch.results_folder import ResultsFolder, write_files
from purcell_cli.batch.rows import CRASHED, Row
from purcell_cli.batch.solve_one import Settings
from purcell_cli.errors import ResultsError, StoppedError
from purcell_cli.files.atomic_file import writable
from purcell_cli.frozen_dataclass import frozen_dataclass

MOST_FAILURES_KEPT = 1000
"""How many failures are listed one by one; the summary has all. More than a person reads, in 1 MB."""


@frozen_dataclass
class Options:
    """What a batch is to do besides solving.

    Attributes:
        folder: The folder of results.
        jobs: How many worker processes.
        dask: The address of a Dask scheduler to use instead.
        resume: Whether to go on from what is finished in the folder.
        junit: The JUnit report's file, if one is wanted.
        parquet: Whether the summary is written as Parquet too.
        baseline: An earlier run to compare with.
    """

    folder: Path
    jobs: int = 1
    dask: str | None = None
    resume: bool = False
    junit: Path | None = None
    parquet: bool = False
    baseline: Baseline | None = None


@dataclasses.dataclass(slots=True)
class Outcome:
    """What a batch came to.

    Attributes:
        scenarios: How many there are.
        solved: How many were solved now, the others being finished before.
        failed: How many are not what they must be.
        crashed: How many of those crashed.
        compared: How many are in the baseline.
        failures: The rows of the failed, at most `MOST_FAILURES_KEPT`.
        wall_time_s: How long the batch took [s].
    """

    scenarios: int = 0
    solved: int = 0
    failed: int = 0
    crashed: int = 0
    compared: int = 0
    failures: list[Row] = dataclasses.field(default_factory=list)
    wall_time_s: float = 0.0

    @property
    def verdict(self) -> Literal["passed", "failed"]:
        """'passed' where all scenarios are what they must be, else 'failed'."""
        return "failed" if self.failed else "passed"


Progress = Callable[[Outcome, dict[str, Any]], None]
"""Takes how far a batch is, and the row of the scenario that was finished last."""


class _Batch:
    """The state of a batch while it runs."""

    def __init__(self, cases: Cases, settings: Settings, options: Options, folder: ResultsFolder) -> None:
        self.cases, self.settings, self.options, self.folder = cases, settings, options, folder
        self.outcome = Outcome()
        self.order: list[str] = []
        self.keys: dict[str, str] = {}
        self.crashes: dict[str, dict[str, Any]] = {}

    def solve(self, progress: Progress, say: dask_workers.Say) -> None:
        """Solve what is not finished, and keep it."""
        options = self.options
        todo = self._todo(progress)
        if options.dask is not None:
            stream = dask_workers.solve_there(todo, self.settings, options.folder, options.dask, say)
        else:
            stream = local_workers.solve_here(todo, self.settings, options.folder, options.jobs)
        with contextlib.closing(stream):
            for finished in stream:
                case = finished.case
                row = {"name": case.name, "file": case.file, "sweep": case.sweep, **finished.row}
                row["reasons"] = shortfalls(case.expect, finished.row)
                key = self.keys.pop(case.name)
                if finished.digests is None or row["verdict"] == CRASHED:  # it is not finished: --resume tries again
                    write_files(options.folder, case.name, {})
                    self.crashes[case.name] = row
                else:
                    self.folder.keep(case.name, key, row, finished.digests)
                self.outcome.solved += 1
                self._report(progress, row)

    def _todo(self, progress: Progress) -> Iterator[Case]:
        """Return the scenarios that are not finished, and note the order of all."""
        for case in self.cases:
            self.order.append(case.name)
            key = hashlib.sha256((case.fingerprint() + self.settings.fingerprint()).encode()).hexdigest()
            row = self.folder.row(case.name) if self.folder.has(case.name, key) else None
            if row is None:
                self.keys[case.name] = key
                yield case
            else:
                self._report(progress, row)

    def _report(self, progress: Progress, row: dict[str, Any]) -> None:
        self.outcome.scenarios += 1
        progress(self.outcome, row)

    def rows(self) -> Iterator[Row]:
        """Return all rows in order, judged."""
        baseline = self.options.baseline
        for name in self.order:
            row = self.crashes.get(name) or self.folder.row(name)
            if row is not None:
                reasons = row["reasons"] + ([] if baseline is None else baseline.regressions(name, row))
                yield cast(Row, {**row, "passed": not reasons, "reasons": reasons})

    def write(self) -> None:
        """Count the failures and write the summaries and the report."""
        outcome, options = self.outcome, self.options
        for row in self.rows():
            outcome.compared += options.baseline is not None and row["name"] in options.baseline.rows
            if not row["passed"]:
                outcome.failed += 1
                outcome.crashed += row["verdict"] == CRASHED
                if len(outcome.failures) < MOST_FAILURES_KEPT:
                    outcome.failures.append(row)
        totals = {"scenarios": outcome.scenarios, "failed": outcome.failed, "crashed": outcome.crashed}
        table = options.folder / "summary.csv"
        summary.write_json(self.rows(), {"verdict": outcome.verdict, **totals}, options.folder / "summary.json")
        summary.write_csv(self.rows(), table)
        if options.parquet:
            summary.write_parquet(table, options.folder / "summary.parquet")
        if options.junit is not None:
            junit.write_report(self.rows(), totals, options.junit, outcome.wall_time_s)
        self.folder.settle(self.order)

    def standing(self) -> str:
        """Return how many scenarios are finished and kept, and how to go on."""
        kept = self.outcome.scenarios - len(self.crashes)
        return f"{kept} of {self.cases.count} scenarios are finished and kept; --resume goes on from there"


def run_batch(
    cases: Cases,
    settings: Settings,
    options: Options,
    progress: Progress = lambda *_: None,
    say: dask_workers.Say = lambda _: None,
) -> Outcome:
    """Run a batch.

    Args:
        cases: The scenarios.
        settings: How to solve them.
        options: What else to do.
        progress: Is called for each that is finished.
        say: Is told how many workers a cluster has, whenever nothing has been finished for a while.

    Raises:
        InputError: Another batch is at work in the folder, or there is no such scheduler.
        ResultsError: Results cannot be written.
        StoppedError: The batch was interrupted.
    """
    begun = time.perf_counter()
    with ResultsFolder(options.folder, options.resume) as folder:
        if options.junit is not None:
            writable(options.junit, "--junit", ("xml",))
        batch = _Batch(cases, settings, options, folder)
        try:
            batch.solve(progress, say)
            batch.outcome.wall_time_s = time.perf_counter() - begun
            batch.write()
        except ResultsError as error:
            raise ResultsError(f"{error}; {batch.standing()}") from error
        except KeyboardInterrupt:
            raise StoppedError(f"interrupted; {batch.standing()}") from None
    return batch.outcome
