"""The command line answers at once: what is slow to import waits until a command needs it."""

from __future__ import annotations

import subprocess
import sys

import pytest

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


def test_the_package_itself_imports_nothing_slow() -> None:
    program = f"import sys, purcell_cli; print(sorted({SLOW!r} & set(sys.modules)), purcell_cli.__version__)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, encoding="utf-8", check=True)
    assert done.stdout.startswith("[] ")
