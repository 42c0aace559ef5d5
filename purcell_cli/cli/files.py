"""The commands for files: purcell init writes them, purcell validate checks them, purcell schema describes them."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast, get_args

import typer

from purcell_cli.cli.documents.files import Kind
from purcell_cli.cli.terminal import DONE, MISUSE, Json, show

if TYPE_CHECKING:
    from rich.console import Console

    from purcell_cli.cli.documents.files import InitDocument, SchemaDocument, ValidateDocument

_CALLED = {"start": "start or goal"}
"""What a kind of document is called that may be two: a configuration alone is either."""

_KINDS: tuple[str, ...] = get_args(Kind)


def register(app: typer.Typer) -> None:
    """Add the commands to the command line."""
    app.command(epilog="Example: purcell init swim, then purcell plan swim/scenario.yaml")(init)
    app.command(epilog="Example: purcell validate scenarios/*.yaml")(validate)
    app.command(epilog="Example: purcell schema scenario --out scenario.schema.json")(schema)


def _kinds(begun: str) -> list[str]:
    """Return the kinds of document that a word begins."""
    return [kind for kind in _KINDS if kind.startswith(begun)]


def _known(kind: str, place: str) -> Kind:
    from purcell_cli.errors import UnknownNameError

    if kind not in _KINDS:
        from purcell_cli.wording import nearest_hint

        raise UnknownNameError(
            f"{place}: a kind of document is wanted ({', '.join(_KINDS)}){nearest_hint(kind, _KINDS)}, found {kind!r}"
        )
    return cast(Kind, kind)


def init(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="The folder; it is made where there is none.")] = Path(),
    swimmer: Annotated[
        str | None,
        typer.Option("--swimmer", metavar="NAME", help="A stored swimmer for swimmer.yaml; default: the paper's."),
    ] = None,
    json: Json = False,
) -> None:
    """Write a start, a goal, a swimmer, a servo map, a mission and a scenario to begin with, every key explained."""
    from purcell_cli.errors import InputError
    from purcell_cli.files.atomic_file import whole_file, writable_folder
    from purcell_cli.files.paths import is_link, status
    from purcell_cli.files.templates import FILES, files_for

    written = FILES if swimmer is None else files_for(swimmer)
    writable_folder(folder, "DIR")
    taken = [name for name in FILES if status(folder / name) is not None or is_link(folder / name)]
    if taken:
        raise InputError(f"{folder / taken[0]}: wanted no such file yet, found one; nothing was written")
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InputError(f"{folder}: cannot be made ({error.strerror or error})") from error
    for name, text in written.items():
        with whole_file(folder / name) as stream:
            stream.write(text.encode())
    files = [str(folder / name) for name in FILES]

    def table(console: Console, document: InitDocument) -> None:
        for file in document["files"]:
            console.print(file, soft_wrap=True, markup=False)
        console.print(f"next: purcell plan {document['files'][-1]}", soft_wrap=True, markup=False)

    document: InitDocument = {"schema": "purcell/init/1", "verdict": "done", "files": files}
    show(document, json, table)


def validate(
    files: Annotated[
        list[str], typer.Argument(metavar="FILE", help="Files of the project, of any kind; - is standard input.")
    ],
    kind: Annotated[
        str | None,
        typer.Option(
            "--kind", metavar="KIND", autocompletion=_kinds, help=f"{', '.join(_KINDS)}; default: by the file's keys."
        ),
    ] = None,
    json: Json = False,
) -> int:
    """Check files without planning: each fault with its file, line and key, and what was meant."""
    from purcell_cli.cli.documents.common import as_part
    from purcell_cli.cli.documents.files import CheckedPart
    from purcell_cli.files.validate import check_file

    wanted = None if kind is None else _known(kind, "--kind")
    found = [check_file(file, wanted) for file in files]
    good = all(checked.error is None for checked in found)

    def table(console: Console, document: ValidateDocument) -> None:
        for checked in document["files"]:
            many = checked["scenarios"]
            text = f"good, a {_CALLED.get(checked['kind'] or '', checked['kind'])}" + (
                f" of {many} combinations" if many not in {None, 1} else ""
            )
            line = f"{checked['file']}: {text}" if checked["error"] is None else checked["error"]
            console.print(line, soft_wrap=True, markup=False)

    parts = [as_part(checked, CheckedPart) for checked in found]
    document: ValidateDocument = {
        "schema": "purcell/validate/1",
        "verdict": "good" if good else "bad",
        "files": parts,
    }
    show(document, json, table)
    return DONE if good else MISUSE


def schema(
    kind: Annotated[
        str, typer.Argument(metavar="KIND", autocompletion=_kinds, help=f"The kind of document: {', '.join(_KINDS)}.")
    ],
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE", help="Write it into a file instead.")] = None,
    json: Json = False,
) -> None:
    """Print the JSON Schema of a kind of document, by which an editor completes and checks it."""
    from purcell_cli.cli.reports.common import as_json
    from purcell_cli.files.atomic_file import whole_file, writable
    from purcell_cli.files.validate import KINDS

    if out is not None:
        writable(out, "--out", ("json",))
    known = _known(kind, "KIND")
    text = as_json(KINDS[known].json_schema(), None if json and out is None else 2)
    if out is None:
        print(text)
        return
    with whole_file(out) as stream:
        stream.write(f"{text}\n".encode())

    def table(console: Console, document: SchemaDocument) -> None:
        console.print(f"JSON Schema in {document['file']}", soft_wrap=True, markup=False)

    document: SchemaDocument = {"schema": "purcell/schema/1", "verdict": "done", "kind": known, "file": str(out)}
    show(document, json, table)
