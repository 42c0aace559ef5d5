"""The command line: parse, load, call the core, show."""

from __future__ import annotations

import copy
import functools
import re
import signal
import sys
from typing import Annotated, Any, NoReturn

import typer
from typer.core import TyperArgument, TyperCommand, TyperGroup

from purcell_cli import __version__
from purcell_cli.cli import (
    batch,
    controllability,
    design,
    export,
    files,
    fit,
    gait,
    pictures,
    plan,
    replan,
    simulate,
    track,
    verify,
)
from purcell_cli.cli.plain_values import plainly
from purcell_cli.cli.streams import robust_streams
from purcell_cli.cli.terminal import DONE, INTERRUPTED, MISUSE, NOT_REACHED
from purcell_cli.cli.usage_errors import usage_hint, usage_message, with_flag
from purcell_cli.cli.warnings import warnings_on_stderr


def _no_type(ctx: Any) -> None:
    """Show no type."""


class _Bare:
    """A command whose help shows units, and no type of an argument or of an option that takes no value."""

    def get_params(self, context: Any) -> list[Any]:
        """Return the options and arguments."""
        params = super().get_params(context)  # type: ignore[misc]  # it stands before a command of typer's
        for param in params:
            if getattr(param, "is_flag", False):
                param.metavar = ""
            if isinstance(param, TyperArgument):  # "<list[Path]>" says nothing to who types a command
                param.display_type_rich = _no_type  # type: ignore[method-assign]
        return [plainly(param) for param in params]

    def format_help(self, context: Any, formatter: Any) -> None:
        """Write the help. Units in square brackets are no markup."""
        for param in self.get_params(context):
            param.help = re.sub(r"(?<!\\)\[", r"\\[", param.help or "")
        super().format_help(context, formatter)  # type: ignore[misc]


class _Group(_Bare, TyperGroup):
    pass


class _Command(_Bare, TyperCommand):
    pass


_HELP = {"help_option_names": ["-h", "--help"]}

app = typer.Typer(
    name="purcell",
    cls=_Group,
    context_settings=_HELP,
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    help="Motion planner for the 3D generalized Purcell swimmer: three slender links, two ball joints, no inertia.",
    epilog="Start with [bold]purcell plan nearby[/], a stored scenario, or [bold]purcell gait --list[/].",
)


def _name(command: typer.models.CommandInfo) -> str:
    return str(getattr(command.callback, "__name__", ""))


def _version(wanted: bool) -> None:
    if wanted:
        print(f"purcell {__version__}")
        raise typer.Exit


@app.callback()
def root(
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Every command takes --help, and --json for machines."""


COMMANDS = (
    plan,
    gait,
    verify,
    simulate,
    replan,
    track,
    fit,
    pictures,
    export,
    design,
    batch,
    files,
    controllability,
)
"""The modules of commands, in the order in which the help lists them."""

for commands in COMMANDS:
    commands.register(app)
for registered in app.registered_commands:
    registered.cls, registered.context_settings = _Command, _HELP
_COMMANDS = {_name(registered) for registered in app.registered_commands}


@functools.cache
def built(command: str = "") -> Any:
    """Return the program with one of its commands, or with all: to build those that are not called takes 70 ms."""
    made = copy.copy(app)
    if command:
        made.registered_commands = [c for c in app.registered_commands if _name(c) == command]
    return typer.main.get_command(made)


def main() -> None:
    """Run the command line; exit with 0 done, 1 not reached, 2 misuse or bad input."""
    code = MISUSE
    signal.signal(signal.SIGTERM, _terminated)
    try:
        with robust_streams():
            code = _run(sys.argv[1:])
    except OSError as error:
        _fail("", f"standard output: {error.strerror or error}", json=False)
        code = MISUSE
    sys.exit(code)


def _terminated(number: int, _: object) -> NoReturn:
    """End by a signal as by an error: half-written files are removed, and other processes of the command ended."""
    sys.exit(128 + number)


def _run(arguments: list[str]) -> int:
    from purcell_cli.errors import GaitError, ParameterError, PurcellError, ResultsError, StoppedError, UnknownNameError
    from purcell_cli.files.used_files import one_command

    command = next((a for a in arguments if not a.startswith("-")), "")
    command = command if command in _COMMANDS else ""
    json = "--json" in arguments
    program = built(command if command in arguments[:1] else "")
    written: list[str] = []
    try:
        with one_command() as written, warnings_on_stderr(command):
            result = program(arguments, prog_name="purcell", standalone_mode=False)
        if result == INTERRUPTED:
            raise KeyboardInterrupt
        return result if isinstance(result, int) else DONE
    except typer.TyperException as error:
        if not arguments:
            print(error.format_message(), file=sys.stderr)  # the help
            return MISUSE
        if not json:
            print(usage_hint(error), file=sys.stderr)
        _fail(command, usage_message(error, arguments), json=json)
        return MISUSE
    except PurcellError as error:
        plain = isinstance(error, ParameterError | UnknownNameError)
        _fail(command, with_flag(str(error), command, program) if plain else str(error), json=json)
        if isinstance(error, StoppedError):
            return INTERRUPTED
        return NOT_REACHED if isinstance(error, GaitError | ResultsError) else MISUSE
    except OSError as error:
        where = "standard output" if error.filename is None else str(error.filename)
        _fail(command, f"{where}: {error.strerror or error}", json=json)
        return MISUSE
    except MemoryError:
        _fail(command, "more memory is needed than there is; ask for fewer rows or cycles", json=json)
        return MISUSE
    except (KeyboardInterrupt, typer.Abort):
        _fail(command, f"interrupted; {_told(written)}", json=json)
        return INTERRUPTED


def _told(written: list[str]) -> str:
    """Return which files a command has written that did not come to its end."""
    if len(written) < 2:
        return f"{written[0]} was written" if written else "nothing was written"
    return f"{len(written)} files were written, {written[-1]} the last"


def _fail(command: str, message: str, *, json: bool) -> None:
    print(f"purcell {command}: {message}" if command else f"purcell: {message}", file=sys.stderr)
    if json:
        from purcell_cli.cli.reports.common import as_json, error_document

        print(as_json(error_document(command or "purcell", message)))
