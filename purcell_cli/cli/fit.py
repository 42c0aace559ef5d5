"""The command fit."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from purcell_cli.cli.terminal import DONE, NOT_REACHED, Json, SwimmerFile, busy, show, swimmer_of

_WHAT = ("ratio", "kinds", "links")
"""Which factors may be fitted."""


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command(epilog="Example: purcell fit monday.csv tuesday.csv --out fitted.yaml")(fit)


def _factors(begun: str) -> list[str]:
    """Return the choices of factors that a word begins."""
    return [name for name in _WHAT if name.startswith(begun)]


def fit(
    measured: Annotated[
        list[Path], typer.Argument(metavar="MEASURED", help="Measured trajectories' CSV files; gaps are allowed.")
    ],
    out: Annotated[Path, typer.Option("--out", metavar="FILE", help="Write the fitted swimmer's YAML file.")],
    swimmer: SwimmerFile = None,
    what: Annotated[
        str,
        typer.Option(
            "--what",
            metavar="|".join(_WHAT),
            help="The drag ratio of all links, drags of base and limbs, or of each link.",
            autocompletion=_factors,
        ),
    ] = "kinds",
    json: Json = False,
) -> int:
    """Estimate links' drag from measured motion, with standard errors and what the data cannot tell."""
    from purcell_cli.cli.reports.fit import fit_document, remarks, show_fit
    from purcell_cli.errors import ParameterError, UnknownNameError
    from purcell_cli.feedback.drag_factors import What
    from purcell_cli.feedback.fit import Left
    from purcell_cli.feedback.fit import fit as fitted
    from purcell_cli.files.atomic_file import writable
    from purcell_cli.files.measured_reader import read_measured
    from purcell_cli.files.swimmer_file import write_swimmer
    from purcell_cli.wording import nearest_hint

    if what not in _WHAT:
        known = f"one of {', '.join(_WHAT)}{nearest_hint(what, _WHAT)}"
        raise UnknownNameError(f"--what: {known} is wanted, found {what!r}")
    places = [path.resolve() for path in measured]
    for path, place in zip(measured, places, strict=True):
        if (times := places.count(place)) > 1:
            raise ParameterError(f"{path}: each measured trajectory once is wanted, found it {times} times")
    writable(out, "--out", ("yaml", "yml"))
    guess = swimmer_of(swimmer)
    trajectories = [read_measured(path) for path in measured]
    with busy("fitting") as news:

        def told(step: int, left: Left) -> None:
            news(f"step {step + 1}, {left.position_l:.2g} L left")

        found = fitted(trajectories, guess, what, told)
    file = str(out) if found.settled else None
    document = fit_document(found, What(what), [str(path) for path in measured], file)
    if found.settled:
        write_swimmer(found.swimmer, out, remarks(document))
    show(document, json, show_fit)
    return DONE if found.settled else NOT_REACHED
