"""The command export: a trajectory for the programs of others."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from purcell_cli.cli.options import MaxMemory, checked_memory
from purcell_cli.cli.terminal import Json, SwimmerFile, busy, fitting_swimmer, show
from purcell_cli.motion.memory import DEFAULT_GB

if TYPE_CHECKING:
    from typing import IO

    from rich.console import Console

    from purcell_cli.cli.documents.export import ExportDocument
    from purcell_cli.files.servo_map_file import ServoMap
    from purcell_cli.mechanics.swimmer import Swimmer
    from purcell_cli.motion.trajectory_table import Table

_TARGETS = ("servo", "mcap", "rerun", "urdf")
"""Their names, for the help; `exports.targets` knows them."""
_MEMORY_A_BYTE = 3.2
"""Memory that an export takes for each byte of its trajectory's file: 3.1 to mcap, which takes most."""


def register(app: typer.Typer) -> None:
    """Add the command to the command line."""
    app.command(epilog="Example: purcell export swim.csv --to servo --map servos.yaml --out servos.csv")(export)


def _targets(begun: str) -> list[str]:
    """Return the targets that a word begins."""
    return [name for name in _TARGETS if name.startswith(begun)]


def export(
    trajectory: Annotated[Path, typer.Argument(metavar="TRAJECTORY", help="A trajectory's CSV file.")],
    to: Annotated[
        str,
        typer.Option(
            "--to",
            metavar="|".join(_TARGETS),
            autocompletion=_targets,
            help="A servo table, ROS 2 messages, a Rerun recording, or the swimmer as URDF.",
        ),
    ],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="The file; default: NAME.mcap, .rrd or .urdf, NAME-servo.csv."),
    ] = None,
    servo_map: Annotated[
        Path | None,
        typer.Option("--map", metavar="FILE", help="The servo map's YAML file, with hinges and channels."),
    ] = None,
    rate: Annotated[
        float | None, typer.Option("--rate", metavar="HZ", help="Ticks in a second, for servo; default: 50.")
    ] = None,
    swimmer: SwimmerFile = None,
    max_memory: MaxMemory = DEFAULT_GB,
    json: Json = False,
) -> None:
    """Write a trajectory for servos, ROS 2 or Rerun, or the swimmer as a robot description."""
    from purcell_cli.errors import ParameterError
    from purcell_cli.exports.targets import target
    from purcell_cli.files.atomic_file import whole_file, writable
    from purcell_cli.files.servo_map_file import ServoMap, load_servo_map
    from purcell_cli.files.trajectory_reader import read_csv

    chosen = target(to)
    if rate is not None and to != "servo":
        raise ParameterError(
            f"--rate: no rate is wanted for {to}, which has the trajectory's own times, found {rate!r}"
        )
    if servo_map is not None and not chosen.uses_map:
        raise ParameterError(f"--map: no map is wanted for {to}, which has no hinges, found {servo_map}")
    file = out or Path(f"{trajectory.stem}-servo.csv" if to == "servo" else f"{trajectory.stem}.{chosen.endings[0]}")
    writable(file, "--out", chosen.endings)
    given = None if servo_map is None else load_servo_map(servo_map)
    table = read_csv(trajectory, checked_memory(max_memory), _MEMORY_A_BYTE)
    body = fitting_swimmer(swimmer, table, trajectory)
    hinges = ServoMap.of_swimmer(body) if given is None else given
    with busy("exporting"), whole_file(file) as stream:
        count = _write(to, table, body, hinges, rate, trajectory, stream)
        size = stream.tell()
    document: ExportDocument = {
        "schema": "purcell/export/1",
        "verdict": "done",
        "trajectory": str(trajectory),
        "to": to,  # type: ignore[typeddict-item]  # one of the targets
        "file": str(file),
        "holds": chosen.holds,
        "count": count,
        "joints": list(hinges.channels) if chosen.uses_map else [],
        "duration_s": float(table.time_s[-1] - table.time_s[0]),
        "bytes": size,
    }
    show(document, json, _show_export)


def _write(
    to: str, table: Table, body: Swimmer, hinges: ServoMap, rate: float | None, trajectory: Path, stream: IO[bytes]
) -> int:
    """Write what is asked for, and return how many things it has."""
    if to == "servo":
        from purcell_cli.exports.servo_table import RATE_HZ, write_servo_table

        return write_servo_table(table, hinges, RATE_HZ if rate is None else rate, trajectory, stream)
    if to == "mcap":
        from purcell_cli.exports.mcap_file import write_mcap

        return write_mcap(table, body, hinges, trajectory, stream)
    if to == "rerun":
        from purcell_cli.exports.rerun_file import write_rerun
        from purcell_cli.files.place import shortened

        return write_rerun(table, body, shortened(trajectory.name), stream)
    from purcell_cli.exports.urdf import write_urdf

    return len(write_urdf(body, hinges, stream))


def _show_export(console: Console, document: ExportDocument) -> None:
    size = f"{document['bytes'] / 1e6:.2f} MB" if document["bytes"] >= 10_000 else f"{document['bytes']} bytes"
    console.print(f"{document['file']}: {document['count']} {document['holds']}, {size}", soft_wrap=True, markup=False)
