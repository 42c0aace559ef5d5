"""Workers of a Dask cluster. They send results back, so they need no disk in common with the batch."""

from __future__ import annotations

import itertools
from collections.abc import Generator, Iterator
from pathlib import Path
from typing import Any

from purcell_cli.batch.cases import Case
from purcell_cli.batch.local_workers import Finished
from purcell_cli.batch.results_folder import write_files
from purcell_cli.batch.rows import CRASHED
from purcell_cli.batch.solve_one import Settings, Solved, solve, without_plan
from purcell_cli.errors import InputError, ResultsError
from purcell_cli.files.place import shortened
from purcell_cli.motion.verdict import Verdict

_WAITING_EACH = 3
"""Scenarios at the scheduler for each of its threads: one is solved, and two wait so that no thread idles."""

_SECONDS_TO_CONNECT = 10
"""How long a scheduler has to answer [s]: Dask's own default is 30, long to wait for an address with a slip in it."""


def solve_there(
    cases: Iterator[Case], settings: Settings, folder: Path, address: str
) -> Generator[Finished, None, None]:
    """Solve scenarios on the workers of a Dask scheduler, and return each when it is finished.

    What a worker that dies was at, the scheduler gives to another.

    Args:
        cases: The scenarios; they are asked for as workers become free.
        settings: How to solve them.
        folder: The folder on this machine that files are written into.
        address: The scheduler's address, such as tcp://host:8786.

    Raises:
        InputError: Dask is not installed, or no scheduler answers at the address.
        ResultsError: A file cannot be written, or the scheduler is lost.
    """
    client, as_completed = _connected(address)
    with client:
        pending: dict[Any, Case] = {}
        futures = as_completed(loop=client.loop)

        def submit(case: Case) -> None:
            future = client.submit(_solved, case, settings, key=f"purcell-{case.name}", pure=False)
            pending[future] = case
            futures.add(future)

        most = _WAITING_EACH * max(1, sum(client.nthreads().values()))
        for case in itertools.islice(cases, most):
            submit(case)
        for future in futures:
            yield _finished(pending.pop(future), future, folder, address)
            future.release()
            following = next(cases, None)
            if following is not None:
                submit(following)


def _connected(address: str) -> tuple[Any, Any]:
    """Return a client of the scheduler, and what makes an iterator of finished futures."""
    try:
        import distributed
    except ImportError as error:
        raise InputError("--dask: wanted the extra dask (pip install 'purcell-cli[dask]'), found none") from error
    dask: Any = distributed
    try:
        return dask.Client(address, timeout=_SECONDS_TO_CONNECT, set_as_default=False), dask.as_completed
    except (OSError, ValueError, ImportError) as error:
        raise InputError(f"--dask: wanted a Dask scheduler at {address}, found none ({error})") from error


def _finished(case: Case, future: Any, folder: Path, address: str) -> Finished:
    """Return what came of a scenario, its files written."""
    if future.status in {"cancelled", "lost"}:
        raise ResultsError(f"the Dask scheduler at {address} is lost")
    try:
        solved: Solved = future.result()
    except OSError as error:
        raise ResultsError(f"the Dask scheduler at {address} is lost ({error})") from error
    except Exception as error:  # a worker without the package, or a scenario that kills every worker
        reason = shortened(f"on the cluster: {type(error).__name__}: {error}", 1000)
        return Finished(case, without_plan(CRASHED, reason).row, None)
    return Finished(case, solved.row, write_files(folder, case.name, solved.files))


def _solved(case: Case, settings: Settings) -> Solved:
    """Solve one scenario: this runs on the cluster."""
    return without_plan(Verdict.ERROR, case.error) if case.scenario is None else solve(case.scenario, settings)
