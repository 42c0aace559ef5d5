"""The certifier process: it certifies the plan of this one, and imports what that needs while the plan is made.

scipy's integrators take about as long to import as a plan takes to make. So a command that ends in a
certificate first of all starts another process, which imports them on another core.
"""

from __future__ import annotations

import contextlib
import functools
import pickle
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import IO, TYPE_CHECKING, Any, cast

from purcell_cli.processes import command

if TYPE_CHECKING:
    from purcell_cli.verification.certificate import Certificate

_SERVE = "from purcell_cli.verification.certifier_process import serve; serve()"


@contextlib.contextmanager
def certifier() -> Iterator[Callable[..., Certificate]]:
    """Start a process that certifies, and end it.

    Yields:
        What does as `certificate.certify` does, once: there, or here where there is nothing left to import.
    """
    process = None if "scipy.integrate" in sys.modules else _started()
    if process is None:
        yield _here
        return
    try:
        yield functools.partial(_there, process)
    finally:
        process.kill()
        process.communicate()


def serve() -> None:
    """Certify the one motion that is asked for on stdin."""
    import scipy.integrate  # noqa: F401  # this is what takes so long

    motion = pickle.load(sys.stdin.buffer)  # noqa: S301  # from the process that started this one
    pickle.dump(_here(*motion), sys.stdout.buffer)


def _started() -> subprocess.Popen[bytes] | None:
    try:  # in a session of its own, since Ctrl-C is for who plans
        return subprocess.Popen(  # noqa: S603  # this very program
            command(_SERVE),
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
    except OSError:
        return None


def _here(*motion: Any) -> Certificate:
    from purcell_cli.verification.certificate import certify

    return certify(*motion)


def _there(process: subprocess.Popen[bytes], *motion: Any) -> Certificate:
    """Have a motion certified by a process; if that fails it is done here, where a fault is reported in full."""
    try:
        to, answer = cast(IO[bytes], process.stdin), cast(IO[bytes], process.stdout)
        pickle.dump(motion, to)
        to.flush()
        return cast("Certificate", pickle.load(answer))  # noqa: S301  # from a process of this program
    except (OSError, EOFError, pickle.PickleError):
        return _here(*motion)
