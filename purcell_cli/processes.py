"""Other processes of this program: started so that they run no code from the working folder, and calls made in one.

Python puts the working folder first among the places where it looks for modules, so that a file `types.py` beside
somebody's scenarios would be run in place of the standard module.
"""

from __future__ import annotations

import contextlib
import functools
import os
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

from purcell_cli.errors import PurcellError, ResultsError

P = ParamSpec("P")
T = TypeVar("T")

_ROOT = str(Path(__file__).resolve().parent.parent)
"""The folder that the package lies in."""

_forked_from_threads = False


def module_path() -> list[str]:
    """Return `sys.path` without the working folder; if the package was found only there, with the package's folder."""
    path = [place for place in sys.path if place]
    return path if len(path) == len(sys.path) or _ROOT in path else [*path, _ROOT]


def command(program: str) -> list[str]:
    """Return the command line of a Python that runs a program's text, with this Python's places for modules."""
    return [sys.executable, "-P", "-c", f"import sys; sys.path[:] = {module_path()!r}; {program}"]


@contextlib.contextmanager
def starting(surroundings: Mapping[str, str] | None = None) -> Iterator[None]:
    """Have what `multiprocessing` starts inside look for modules as `command` does.

    Args:
        surroundings: Environment variables that it gets besides.
    """
    wanted = {"PYTHONSAFEPATH": "1", **(surroundings or {})}
    variables, path = {name: os.environ.get(name) for name in wanted}, sys.path[:]
    os.environ.update(wanted)
    sys.path[:] = module_path()
    try:
        yield
    finally:
        sys.path[:] = path
        for name, value in variables.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def outside_forks(function: Callable[P, T]) -> Callable[P, T]:
    """Have a function that uses polars called in a process of its own where this one is a fork that cannot.

    A fork has none of its parent's threads, and waits for ever for those of polars if the parent has used it.
    """

    @functools.wraps(function)
    def called(*arguments: P.args, **named: P.kwargs) -> T:
        if not _forked_from_threads:
            return function(*arguments, **named)
        return _elsewhere(called, *arguments, **named)

    return called


def _elsewhere(function: Callable[P, T], *arguments: P.args, **named: P.kwargs) -> T:
    """Return what a function returns, or raise what it raises, in a process of its own."""
    done = subprocess.run(  # noqa: S603  # this very program
        command("from purcell_cli.processes import serve; serve()"),
        input=pickle.dumps((function, arguments, named)),
        stdout=subprocess.PIPE,
        check=False,
    )
    if done.returncode:
        raise ResultsError(f"a process for {function.__name__} ended with code {done.returncode}")
    error, result = pickle.loads(done.stdout)  # noqa: S301  # from a process of this program
    if error is not None:
        raise error
    return result  # type: ignore[no-any-return]  # pickle knows no types


def serve() -> None:
    """Make the one call that is asked for on stdin, and answer with its error and its result."""
    function, arguments, named = pickle.load(sys.stdin.buffer)  # noqa: S301  # from the process that started this one
    error: PurcellError | None = None
    result: Any = None
    try:
        result = function(*arguments, **named)
    except PurcellError as found:
        error = found
    pickle.dump((error, result), sys.stdout.buffer)


def _note_fork() -> None:
    global _forked_from_threads  # it is a property of the process
    _forked_from_threads = _forked_from_threads or "polars" in sys.modules


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_note_fork)
