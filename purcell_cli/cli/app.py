"""The command line: parse, load, call the core, show."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from purcell_cli import __version__
from purcell_cli.cli import batch, controllability, design, files, gait, pictures, plan, verify
from purcell_cli.cli.terminal import DONE, INTERRUPTED, MISUSE, NOT_REACHED

app = typer.Typer(
    name="purcell",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    help="Motion planner for the 3D generalized Purcell swimmer: three slender links, two ball joints, no inertia.",
    epilog="Start with [bold]purcell plan nearby[/], a stored scenario, or [bold]purcell gait --list[/].",
)


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


for commands in (plan, gait, verify, pictures, design, batch, files, controllability):
    commands.register(app)


def main() -> None:
    """Run the command line; exit with 0 done, 1 not reached, 2 misuse or bad input."""
    sys.exit(_run(sys.argv[1:]))


def _run(arguments: list[str]) -> int:
    from purcell_cli.errors import GaitError, PurcellError, ResultsError, StoppedError

    command = next((a for a in arguments if not a.startswith("-")), "purcell")
    try:
        result = app(arguments, standalone_mode=False)
        if result == INTERRUPTED:
            raise KeyboardInterrupt
        return result if isinstance(result, int) else DONE
    except typer.TyperException as error:
        if "--json" in arguments:
            _fail(command, error.format_message(), json=True)
        else:
            show = getattr(error, "show", None)
            show() if show else _fail(command, str(error), json=False)
        return MISUSE
    except PurcellError as error:
        _fail(command, str(error), json="--json" in arguments)
        if isinstance(error, StoppedError):
            return INTERRUPTED
        return NOT_REACHED if isinstance(error, GaitError | ResultsError) else MISUSE
    except MemoryError:
        _fail(command, "more memory is needed than there is; ask for fewer rows or cycles", json="--json" in arguments)
        return MISUSE
    except (KeyboardInterrupt, typer.Abort):
        _fail(command, "interrupted; nothing was written", json="--json" in arguments)
        return INTERRUPTED


def _fail(command: str, message: str, *, json: bool) -> None:
    print(f"purcell {command}: {message}" if command != "purcell" else f"purcell: {message}", file=sys.stderr)
    if json:
        from purcell_cli.cli.reports.common import as_json, error_document

        print(as_json(error_document(command, message)))
