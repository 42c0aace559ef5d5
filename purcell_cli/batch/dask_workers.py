"""Workers of a Dask cluster. They send results back, so they need no disk in common with the batch."""

from __future__ import annotations

import contextlib
import itertools
import logging
import threading
from collections.abc import Callable, Generator, Iterator
from pathlib import Path
from typing import Any

from purcell_cli import __version__
from purcell_cli.batch.cases import Case
from purcell_cli.batch.local_workers import Finished
from purcell_cli.batch.results_folder import write_files
from purcell_cli.batch.rows import CRASHED
from purcell_cli.batch.solve_one import Settings, Solved, solve, without_plan
from purcell_cli.errors import InputError, PurcellError, ResultsError
from purcell_cli.files.place import shortened
from purcell_cli.motion.verdict import Verdict
from purcell_cli.wording import counted

_WAITING_EACH = 3
"""Scenarios at the scheduler for each of its threads: one is solved, and two wait so that no thread idles."""

_SECONDS_TO_CONNECT = 10
"""How long a scheduler has to answer [s]: Dask's own default is 30, long to wait for an address with a slip in it."""

_SECONDS_OF_SILENCE = 10.0
"""After so long without a result it is said how many workers there are [s]: who watches learns why nothing happens."""

_ASKED = "__import__('purcell_cli.batch.solve_one').__version__"
"""What a worker is asked before it gets a scenario: its version of this package, which it must import for that."""

Say = Callable[[str], None]
"""Takes a line about the cluster."""


def solve_there(
    cases: Iterator[Case], settings: Settings, folder: Path, address: str, say: Say
) -> Generator[Finished, None, None]:
    """Solve scenarios on the workers of a Dask scheduler, and return each when it is finished.

    What a worker that dies was at, the scheduler gives to another.

    Args:
        cases: The scenarios; they are asked for as workers become free.
        settings: How to solve them.
        folder: The folder on this machine that files are written into.
        address: The scheduler's address, such as tcp://host:8786.
        say: Is told how many workers there are, whenever nothing has been finished for a while.

    Raises:
        InputError: Dask is not installed, no scheduler answers at the address, or it or its worker lacks this version
            of the package.
        ResultsError: A file cannot be written, or the scheduler is lost.
    """
    client, as_completed = _connected(address)
    with contextlib.closing(client), _Watch(client, address, say) as watch, _lost(address):
        _check_package(client, address)
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
            watch.finished()
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
    for part in ("client", "utils"):  # lost connections are told here, without tracebacks
        logging.getLogger(f"distributed.{part}").setLevel(logging.CRITICAL)
    client = dask.Client.__new__(dask.Client)
    try:
        client.__init__(address, timeout=_SECONDS_TO_CONNECT, set_as_default=False)
    except Exception as error:  # other versions of Dask and what is no scheduler end in errors of any kind
        client.status = "closed"  # or else it would try to take leave of the scheduler, in vain and with a traceback
        reason = shortened(_first_line(error), 300)
        raise InputError(f"--dask: wanted a Dask scheduler at {address}, found none ({reason})") from error
    return client, dask.as_completed


class _Watch:
    """Says how many workers there are whenever nothing has been finished for a while, until the end of the context."""

    def __init__(self, client: Any, address: str, say: Say) -> None:
        self._client, self._address, self._say = client, address, say
        self._woken, self._over = threading.Event(), False
        self._thread = threading.Thread(target=self._watch, daemon=True)

    def __enter__(self) -> _Watch:
        """Begin to watch."""
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """End it."""
        self._over = True
        self._woken.set()

    def finished(self) -> None:
        """Take note that a scenario was finished."""
        self._woken.set()

    def _watch(self) -> None:
        while not self._over:
            if self._woken.wait(_SECONDS_OF_SILENCE):
                self._woken.clear()
                continue
            try:
                count = len(self._client.nthreads())
            except Exception:  # a scheduler that is lost: who waits for results is told
                return
            self._say(f"{counted(count, 'worker')} at the Dask scheduler {self._address}")


@contextlib.contextmanager
def _lost(address: str) -> Iterator[None]:
    """Tell errors of the connection as what they mean."""
    try:
        yield
    except PurcellError:
        raise
    except (OSError, TimeoutError) as error:
        raise ResultsError(f"the Dask scheduler at {address} is lost ({_first_line(error)})") from error


def _check_package(client: Any, address: str) -> None:
    """Wait for a worker, and ask it and the scheduler for their version of the package.

    Raises:
        InputError: One of them cannot import it, or has another version.
    """
    _agree("scheduler", lambda: client.run_on_scheduler(eval, _ASKED))
    _agree("worker", lambda: _answer(client.submit(eval, _ASKED, pure=False), address))


def _agree(who: str, ask: Callable[[], str]) -> None:
    try:
        found = ask()
    except (OSError, PurcellError):  # the connection is lost
        raise
    except Exception as error:  # whatever an import may raise there
        found = f"one that cannot import it ({shortened(f'{type(error).__name__}: {_first_line(error)}', 300)})"
    if found != __version__:
        raise InputError(f"--dask: wanted a {who} with version {__version__} of purcell-cli, found {found}")


def _finished(case: Case, future: Any, folder: Path, address: str) -> Finished:
    """Return what came of a scenario, its files written."""
    try:
        solved: Solved = _answer(future, address)
    except PurcellError:
        raise
    except Exception as error:  # a worker without the package, or a scenario that kills every worker
        reason = shortened(f"on the cluster: {type(error).__name__}: {error}", 1000)
        return Finished(case, without_plan(CRASHED, reason).row, None)
    return Finished(case, solved.row, write_files(folder, case.name, solved.files))


def _answer(future: Any, address: str) -> Any:
    """Wait for what was computed on the cluster.

    Raises:
        ResultsError: The scheduler is lost.
    """
    try:
        return future.result()
    except Exception as error:
        if isinstance(error, OSError) or future.status in {"cancelled", "lost"}:
            raise ResultsError(f"the Dask scheduler at {address} is lost ({_first_line(error)})") from error
        raise


def _first_line(error: Exception) -> str:
    return next(iter(str(error).splitlines()), type(error).__name__)


def _solved(case: Case, settings: Settings) -> Solved:
    """Solve one scenario: this runs on the cluster."""
    return without_plan(Verdict.ERROR, case.error) if case.scenario is None else solve(case.scenario, settings)
