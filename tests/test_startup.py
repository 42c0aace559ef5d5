"""The command line answers at once: what is slow to import waits until a command needs it."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable

import pytest
from typer import TyperException

from purcell_cli.cli.app import built
from purcell_cli.cli.plain_values import _plain
from purcell_cli.errors import ParameterError, PurcellError

SLOW = {"numpy", "scipy", "polars", "yaml", "matplotlib"}

_RUN = """
import sys
from purcell_cli.cli.app import main
sys.argv = ["purcell", *sys.argv[1:]]
try:
    main()
except SystemExit as end:
    code = end.code
print("code", code, "loaded", *sorted({name.partition(".")[0] for name in sys.modules}), file=sys.stderr)
"""


def _loaded(*arguments: str) -> set[str]:
    """Return the packages that a command has imported when it ends well."""
    done = subprocess.run([sys.executable, "-c", _RUN, *arguments], capture_output=True, encoding="utf-8", check=True)
    code, _, names = done.stderr.splitlines()[-1].removeprefix("code ").partition(" loaded ")
    assert code in {"0", "None"}
    assert done.stdout
    return set(names.split())


@pytest.mark.slow
@pytest.mark.parametrize(
    "arguments",
    [
        ["--version"],
        ["--help"],
        ["plan", "--help"],
        ["gait", "--help"],
        ["run", "--help"],
        ["plot", "--help"],
        ["batch", "--help"],
        ["export", "--help"],
        ["init", "--help"],
        ["controllability", "--help"],
    ],
)
def test_help_and_version_import_nothing_slow(arguments: list[str]) -> None:
    assert _loaded(*arguments) & SLOW == set()


@pytest.mark.slow
def test_a_command_that_reads_gaits_is_seen_to_import_them() -> None:
    assert _loaded("gait", "--list") >= {"numpy", "yaml"}


@pytest.mark.slow
def test_plain_values_need_no_pydantic() -> None:
    """A whole number is left to typer, which asks pydantic."""
    assert "pydantic" not in _loaded("gait", "--list", "--amplitude", "-0.3")
    assert "pydantic" in _loaded("gait", "--list", "--cycles", "3")


VALUES = {
    "start": ["nearby", "", "\u00fc"],
    "goal": [None, "a.yaml"],
    "out": [None, "nowhere/trajectory.csv", "."],
    "dt_s": ["0.045", "5e-2", "1", " 1.0 ", "1_0", "+2", "1e400", "nan", "x", "", "0x1", "-3"],
    "effort": ["quick", "slow"],
    "seed": ["7", "7.0", "x"],
    "max_bend_rad": [None, "0.5"],
}


PYTHONS = {" 1.0 ", "1_0"}
"""Numbers for typer, as for Python, that are none in documents, nor on the command line."""


def test_plain_values_are_what_typer_makes_of_them() -> None:
    """But for the words in which numbers are refused, and for what only Python takes for a number."""
    command = built("plan").commands["plan"]
    context = command.make_context("plan", ["nearby"])
    params = {param.name: param for param in command.get_params(context)}

    def outcome(take: Callable[[], object]) -> tuple[type, str]:
        try:
            value = take()
        except (TyperException, PurcellError) as error:
            return type(error), str(error)
        return type(value), repr(value)

    known, refused = 0, []
    for name, given in ((name, one) for name, values in VALUES.items() if name in params for one in values):
        param = params[name]
        known += _plain(param, given)[0]
        wanted = outcome(lambda p=param, g=given: p.get_runtime_param().coerce(g, param=p, ctx=context))
        found = outcome(lambda p=param, g=given: p.process_value(context, g))
        if found[0] is ParameterError and "number is wanted" in found[1]:
            refused.append(given)
            assert issubclass(wanted[0], TyperException) or given in PYTHONS
            assert (
                found[1] == f"{param.opts[0]}: {'a' if name == 'dt_s' else 'a whole'} number is wanted, found {given!r}"
            )
        else:
            assert found == wanted
    assert known >= 10
    assert set(refused) > PYTHONS


_INTERRUPTED = """
import atexit, signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)
during = sys.argv[1]

class Interrupting:
    def find_spec(self, name, *_):
        if name == during:
            signal.raise_signal(signal.SIGINT)

sys.meta_path.insert(0, Interrupting())
if during == "atexit":
    atexit.register(signal.raise_signal, signal.SIGINT)
from purcell_cli.__main__ import main
sys.argv[1:] = ["--version"]
main()
"""


@pytest.mark.parametrize(
    ("during", "code", "err"),
    [
        ("purcell_cli.cli.app", 130, "purcell: interrupted\n"),
        ("typer", 130, "purcell: interrupted\n"),
        ("atexit", 0, ""),
    ],
)
def test_an_interrupt_while_python_begins_or_ends_is_no_traceback(during: str, code: int, err: str) -> None:
    done = subprocess.run([sys.executable, "-c", _INTERRUPTED, during], capture_output=True, encoding="utf-8")
    assert (done.returncode, done.stderr) == (code, err)
    assert done.stdout.startswith("purcell ") == (code == 0)


def test_the_package_itself_imports_nothing_slow() -> None:
    program = f"import sys, purcell_cli; print(sorted({SLOW!r} & set(sys.modules)), purcell_cli.__version__)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, encoding="utf-8", check=True)
    assert done.stdout.startswith("[] ")
