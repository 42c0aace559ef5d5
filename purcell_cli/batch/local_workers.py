"""Worker processes on this machine. Each has one scenario at a time, so it is known what a worker died of.

Not pebble or a Dask LocalCluster: most of what stands here (threads limited before numpy is imported, workers that end
with the batch, an installation in which no worker starts) would stand beside them too.
"""

from __future__ import annotations

import contextlib
import dataclasses
import multiprocessing
import os
import signal
import threading
from collections.abc import Generator, Iterator
from multiprocessing import resource_tracker
from multiprocessing.connection import Connection, wait
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Any

from purcell_cli.batch.cases import Case
from purcell_cli.batch.results_folder import write_files
from purcell_cli.batch.rows import CRASHED, Result
from purcell_cli.batch.solve_one import Settings, solve, without_plan
from purcell_cli.errors import ResultsError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.motion.verdict import Verdict
from purcell_cli.processes import starting

_THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "POLARS_MAX_THREADS")
"""Environment variables by which the libraries of a worker use one thread each."""

_MOST_FALSE_STARTS = 3
"""Workers that die before their first answer, one after the other, until the batch gives up.

One such death may be the scenario's doing; with three of them, what is wrong is the installation."""

_CONTEXT = multiprocessing.get_context("spawn")  # a fork would copy locks that other threads hold


@frozen_dataclass
class Finished:
    """A scenario that a worker is done with.

    Attributes:
        case: The scenario.
        row: Its row of the summary.
        digests: The digests of its files; None where the worker died, and there are none.
    """

    case: Case
    row: Result
    digests: dict[str, str] | None


@dataclasses.dataclass(slots=True)
class _Worker:
    process: SpawnProcess
    pipe: Connection
    case: Case | None = None
    started: bool = False


def solve_here(cases: Iterator[Case], settings: Settings, folder: Path, jobs: int) -> Generator[Finished, None, None]:
    """Solve scenarios with worker processes, and return each when it is finished.

    A worker that dies costs the scenario it was at; another takes its place.

    Args:
        cases: The scenarios; they are asked for as workers become free.
        settings: How to solve them.
        folder: The folder that the workers write files into.
        jobs: How many workers.

    Raises:
        ResultsError: A file cannot be written, or no worker can be started.
    """
    busy: dict[Any, _Worker] = {}
    idle: list[_Worker] = []
    false_starts = 0
    try:
        while True:
            while len(busy) < jobs and (case := next(cases, None)) is not None:
                worker = idle.pop() if idle and idle[-1].process.is_alive() else _started(settings, folder)
                busy[worker.pipe] = worker
                _send(worker, case)
            if not busy:
                return
            for pipe in wait(list(busy)):
                worker = busy.pop(pipe)
                finished = _answer(worker)
                if finished.digests is not None:
                    worker.started, false_starts = True, 0
                    idle.append(worker)
                elif not worker.started:
                    false_starts += 1
                    if false_starts == _MOST_FALSE_STARTS:
                        raise ResultsError(f"no worker starts: {finished.row['error']}")
                yield finished
    finally:
        for worker in (*busy.values(), *idle):
            worker.process.kill()
            worker.process.join()
            worker.pipe.close()


def _answer(worker: _Worker) -> Finished:
    """Return what a worker did with its scenario, which may be that it died of it."""
    case, worker.case = worker.case, None
    if case is None:
        raise RuntimeError("a worker that has no scenario has no answer")
    try:
        answer = worker.pipe.recv()
    except (EOFError, OSError):
        return Finished(case, without_plan(CRASHED, _death(worker)).row, None)
    if isinstance(answer, str):
        raise ResultsError(answer)
    return Finished(case, *answer)


def _send(worker: _Worker, case: Case) -> None:
    """Give a worker a scenario; that it is dead is seen when its answer is waited for."""
    worker.case = case
    with contextlib.suppress(OSError):
        worker.pipe.send((case.name, case.error if case.scenario is None else case.scenario))


def _death(worker: _Worker) -> str:
    worker.process.join(10)
    code = worker.process.exitcode
    if code is not None and code < 0:
        name = signal.Signals(-code).name if -code in set(signal.Signals) else str(-code)
        reason = f"killed by {name}" + (" (perhaps for want of memory)" if name == "SIGKILL" else "")
    else:
        reason = f"ended with code {code}"
    return f"its worker process died, {reason}"


@contextlib.contextmanager
def _interrupts_held() -> Iterator[None]:
    """Hold Ctrl-C back: from this process meanwhile, and from what is started inside, which then never hears of it.

    Until a worker ignores it, as it soon does, it would end with a traceback; so it would where this process were
    interrupted while it tells a worker what to do. Threads of libraries may hear the signal in this one's place, so
    that it is blocked is not enough. multiprocessing unblocks it where it starts its resource tracker, as it does with
    the first worker: so that one is started before.
    """
    mask = getattr(signal, "pthread_sigmask", None)  # Windows has none
    if mask is None:
        yield
        return
    resource_tracker.ensure_running()
    heard: list[int] = []
    handling = threading.current_thread() is threading.main_thread()  # only there can handlers be set
    own = signal.signal(signal.SIGINT, lambda number, _: heard.append(number)) if handling else None
    before = mask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        if handling:
            signal.signal(signal.SIGINT, signal.SIG_DFL if own is None else own)
        mask(signal.SIG_SETMASK, before)
        if heard:
            signal.raise_signal(signal.SIGINT)


def _started(settings: Settings, folder: Path) -> _Worker:
    """Start a worker; its libraries use one thread each, since there is a worker for each core."""
    here, there = _CONTEXT.Pipe()
    process = _CONTEXT.Process(target=_serve, args=(there, settings, str(folder)), daemon=True)
    try:
        with starting(dict.fromkeys(_THREADS, "1")), _interrupts_held():
            process.start()
    except OSError as error:
        raise ResultsError(f"a worker process cannot be started ({error.strerror or error})") from error
    finally:
        there.close()
    return _Worker(process, here)


def _serve(pipe: Connection, settings: Settings, folder: str) -> None:
    """Solve scenarios until the pipe is closed: answer with row and digests, or with why files cannot be written."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the batch decides when to stop
    threading.Thread(target=_end_with_the_batch, daemon=True).start()
    with contextlib.suppress(EOFError, OSError):
        while True:
            name, scenario = pipe.recv()
            solved = without_plan(Verdict.ERROR, scenario) if isinstance(scenario, str) else solve(scenario, settings)
            try:
                digests = write_files(Path(folder), name, solved.files)
            except ResultsError as error:
                pipe.send(str(error))
            else:
                pipe.send((solved.row, digests))


def _end_with_the_batch() -> None:
    """Wait for the batch's own process to end, however it does, and end too."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        wait([parent.sentinel])
        os._exit(1)
