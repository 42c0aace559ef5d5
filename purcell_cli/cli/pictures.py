"""The commands that draw: plot, figures and view."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from purcell_cli.cli.options import MaxMemory, checked_memory
from purcell_cli.cli.terminal import GaitFolder, Json, SwimmerFile, bar, busy, fitting_swimmer, ready, show, swimmer_of
from purcell_cli.motion.memory import DEFAULT_GB

if TYPE_CHECKING:
    from rich.console import Console

    from purcell_cli.cli.documents.files import FiguresDocument, FilmDocument, PlotDocument, ViewDocument
    from purcell_cli.mechanics.swimmer import Swimmer
    from purcell_cli.motion.trajectory_table import Table
    from purcell_cli.pictures.film import FilmOptions
    from purcell_cli.pictures.surroundings import Surroundings

PAPER_MOTIONS = ("x-motion", "y-motion", "z-motion", "z-rotation", "y-rotation", "x-rotation")
"""The gaits of the six motions that the paper draws, in its order: x, y, z, psi, theta, phi."""
PRINTED = tuple(f"printed-{name}" for name in ("x", "y", "z", "psi", "theta", "phi"))
"""The same motions by the sequences as printed."""

_KINDS = ("stroke", "poses", "time")
"""What is drawn of each motion."""

_LONGEST_TITLE = 300
"""Characters of a page's title at most: as many as a file's name has."""

_AROUND = "The scenario, or plan document, whose obstacles, waypoints and curve are shown."

_SMOOTH = 0.01
"""Longest time between rows of a stroke that is drawn, for a joint rate of 1 rad/s [s]."""


def register(app: typer.Typer) -> None:
    """Add the commands of this module to the command line."""
    app.command(epilog="Example: purcell plot swim.csv --out swim.svg, or purcell plot x-motion")(plot)
    app.command(epilog="Example: purcell figures --out figures")(figures)
    app.command(epilog="Example: purcell view swim.csv --out swim.html")(view)


def plot(
    what: Annotated[str, typer.Argument(metavar="WHAT", help="A trajectory's CSV file, or the name of a stored gait.")],
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="The picture: png, svg or pdf; default: NAME.png.")
    ] = None,
    amplitude: Annotated[
        float | None, typer.Option("--amplitude", metavar="RAD", help="The gait's amplitude; default: its own.")
    ] = None,
    scenario: Annotated[
        str | None,
        typer.Option("--scenario", metavar="FILE", help=f"{_AROUND} The trajectory is then drawn in space."),
    ] = None,
    swimmer: SwimmerFile = None,
    gaits: GaitFolder = None,
    max_memory: MaxMemory = DEFAULT_GB,
    json: Json = False,
) -> None:
    """Draw a trajectory against time or among what is around it, or a gait over the curvature of its shapes."""
    from purcell_cli.errors import ParameterError
    from purcell_cli.files.atomic_file import writable
    from purcell_cli.files.paths import is_file as is_regular
    from purcell_cli.files.place import shortened
    from purcell_cli.files.trajectory_reader import read_csv
    from purcell_cli.pictures.style import picture_format, save_figure
    from purcell_cli.pictures.time_plot import time_figure

    path = Path(what)
    is_file = path.suffix == ".csv" or is_regular(path)
    if scenario is not None and not is_file:
        raise ParameterError(
            f"--scenario: nothing around a gait, which is drawn by itself, is wanted, found {scenario!r}"
        )
    if amplitude is not None and is_file:
        raise ParameterError(
            f"--amplitude: none is wanted for a trajectory, which is drawn as it is, found {amplitude!r}"
        )
    if gaits is not None and is_file:
        raise ParameterError(f"--gaits: no folder is wanted for a trajectory, which names no gait file, found {gaits}")
    file = out or Path(f"{path.stem if is_file else what}.png")
    writable(file, "--out")
    picture_format(file)
    with busy("drawing"):
        if is_file:
            title = shortened(path.name).replace("$", r"\$")  # two of them would begin and end a formula
            table = read_csv(path, checked_memory(max_memory))
            if swimmer is not None or scenario is not None:
                body = fitting_swimmer(swimmer, table, path, scenario)
            if scenario is None:
                figure = time_figure(table, title)
            else:
                from purcell_cli.pictures.space_plot import space_figure

                figure = space_figure(table, body, title, surroundings_of(scenario))
            save_figure(figure, file)
        else:
            save_figure(_stroke_figures(what, amplitude, swimmer, gaits)["stroke"], file)
    document: PlotDocument = {
        "schema": "purcell/plot/1",
        "verdict": "done",
        "of": what,
        "kind": "trajectory" if is_file else "gait",
        "picture": str(file),
    }
    show(document, json, _show_plot)


def figures(
    out: Annotated[Path, typer.Option("--out", metavar="DIR", help="The folder; it is made if need be.")] = Path(
        "figures"
    ),
    form: Annotated[str, typer.Option("--format", metavar="NAME", help="svg, png or pdf.")] = "svg",
    swimmer: SwimmerFile = None,
    json: Json = False,
) -> None:
    """Draw the paper's figures anew: its six motions, and what its printed sequences do."""
    from purcell_cli.errors import UnknownNameError
    from purcell_cli.files.atomic_file import writable, writable_folder
    from purcell_cli.pictures.style import FORMATS, make_folder, save_figure

    if form.lower() not in FORMATS:
        raise UnknownNameError(f"--format: one of {', '.join(FORMATS)} is wanted, found {form!r}")
    swimmer_of(swimmer)
    writable_folder(out, "--out")
    make_folder(out)
    files = {(n, kind): out / f"{n}-{kind}.{form}" for n in (*PAPER_MOTIONS, *PRINTED) for kind in _KINDS}
    for file in files.values():
        writable(file, "--out")
    with busy("drawing") as progress:
        for name in (*PAPER_MOTIONS, *PRINTED):
            progress(name)
            for kind, figure in _stroke_figures(name, None, swimmer, None).items():
                save_figure(figure, files[name, kind])
    document: FiguresDocument = {
        "schema": "purcell/figures/1",
        "verdict": "done",
        "pictures": [str(f) for f in files.values()],
    }
    show(document, json, _show_figures)


def view(
    trajectory: Annotated[Path, typer.Argument(metavar="TRAJECTORY", help="A trajectory's CSV file.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="The page, or a film (.gif, .mp4); default: NAME.html."),
    ] = None,
    fps: Annotated[
        float | None, typer.Option("--fps", metavar="X", help="A film's frames in a second; default: 25.")
    ] = None,
    duration: Annotated[
        float | None,
        typer.Option(
            "--duration", metavar="SECONDS", help="Seconds that a film takes; default: the motion's time, 10 at most."
        ),
    ] = None,
    size: Annotated[
        str | None, typer.Option("--size", metavar="WxH", help="A film's width and height in pixels; default: 640x480.")
    ] = None,
    swimmer: SwimmerFile = None,
    beside: Annotated[
        Path | None,
        typer.Option(
            "--beside", metavar="FILE", help="A trajectory of the same times, played with it, such as the plan's."
        ),
    ] = None,
    scenario: Annotated[
        str | None,
        typer.Option("--scenario", metavar="FILE", help=_AROUND),
    ] = None,
    max_memory: MaxMemory = DEFAULT_GB,
    json: Json = False,
) -> None:
    """Make one page of HTML that plays a trajectory in any browser, without a network; or a film of it."""
    from purcell_cli.errors import ParameterError
    from purcell_cli.files.atomic_file import writable
    from purcell_cli.files.place import shortened

    file = out or Path(f"{trajectory.stem}.html")
    writable(file, "--out", ("html", "htm", "gif", "mp4"))
    ending = file.suffix.removeprefix(".").lower()
    film = _film_options(ending, fps, duration, size) if ending in {"gif", "mp4"} else None
    for name, value in (("fps", fps), ("duration", duration), ("size", size)):
        if film is None and value is not None:
            raise ParameterError(
                f"--{name}: no such option is wanted for a page, which plays at any size, found {value!r}"
            )
    if film is not None and beside is not None:
        raise ParameterError(f"--beside: no other trajectory is wanted for a film, found {beside}")
    memory_gb = checked_memory(max_memory) / (1 if beside is None else 2)
    with busy("reading"):
        from purcell_cli.files.trajectory_reader import read_csv
        from purcell_cli.pictures.html_view import shown_rows, write_page

        table = read_csv(trajectory, memory_gb)
        other = None if beside is None else read_csv(beside, memory_gb)
    body = fitting_swimmer(swimmer, table, trajectory, scenario)
    if film is not None:
        show(_film(table, body, film, (trajectory, file), surroundings_of(scenario)), json, _show_film)
        return
    with busy("drawing"):
        title = shortened(trajectory.name, _LONGEST_TITLE)
        written = write_page(table, body, title, file, other, surroundings_of(scenario))
    document: ViewDocument = {
        "schema": "purcell/view/1",
        "verdict": "done",
        "trajectory": str(trajectory),
        "page": str(file),
        "rows": len(table.time_s),
        "frames": len(shown_rows(table)),
        "bytes": written,
    }
    show(document, json, _show_view)


def surroundings_of(name: str | None) -> Surroundings:
    """Return what is around a motion by a scenario, by file or stored name, or a plan document; nothing without one."""
    from purcell_cli.files.builtin import find_scenario
    from purcell_cli.files.plan_file import is_plan, load_plan
    from purcell_cli.pictures.surroundings import NOTHING, Surroundings

    if name is None:
        return NOTHING
    if is_plan(name):
        document = load_plan(name)
        passed = tuple((one.index, one.waypoint) for one in document.plan.passages)
        return Surroundings(document.options.obstacles, passed, document.plan.follow)
    scenario = find_scenario(name)
    return Surroundings(scenario.obstacles, tuple(enumerate(scenario.via)), scenario.follow)


def _film_options(ending: str, fps: float | None, duration: float | None, size: str | None) -> FilmOptions:
    """Return how a film is made, by the options that are given."""
    from purcell_cli.pictures.film import FilmOptions, parsed_size

    given: dict[str, Any] = {"fps": fps, "duration_s": duration, "size": None if size is None else parsed_size(size)}
    return FilmOptions(ending, **{name: value for name, value in given.items() if value is not None})


def _film(
    table: Table, body: Swimmer, options: FilmOptions, files: tuple[Path, Path], around: Surroundings
) -> FilmDocument:
    """Write a film, of a trajectory's file and to another one, and return the document about it."""
    from purcell_cli.files.atomic_file import whole_file

    trajectory, file = files
    with bar("drawing") as told, whole_file(file) as stream:
        from purcell_cli.pictures.film import write_film

        frames = write_film(table, body, options, stream, lambda done, total: told(done, total, "frames"), around)
    return {
        "schema": "purcell/film/1",
        "verdict": "done",
        "trajectory": str(trajectory),
        "film": str(file),
        "rows": len(table.time_s),
        "frames": frames,
        "fps": options.fps,
        "width_px": options.size[0],
        "height_px": options.size[1],
        "bytes": file.stat().st_size,
    }


def _stroke_figures(name: str, amplitude: float | None, swimmer: Path | None, gaits: Path | None) -> dict[str, Any]:
    """Return a gait's pictures: its stroke in shape space, its poses, and one cycle against time."""
    from purcell_cli.files.builtin import stored_gaits
    from purcell_cli.gaits.gait import find
    from purcell_cli.gaits.pure_stroke import realise
    from purcell_cli.gaits.sampling import sample_stroke
    from purcell_cli.mechanics.configuration import Configuration
    from purcell_cli.motion.trajectory import as_table
    from purcell_cli.pictures.poses_plot import poses_figure
    from purcell_cli.pictures.stroke_plot import net_displacement, stroke_figure
    from purcell_cli.pictures.time_plot import time_figure

    body = ready(swimmer_of(swimmer))
    gait = find(stored_gaits(gaits), name)
    stroke = realise(gait, body, amplitude)
    trajectory = sample_stroke(body, Configuration(), stroke, 1, _SMOOTH / body.joint_rate_rad_s)
    title = f"{gait.name}, amplitude {stroke.amplitude_rad:g} rad"
    text = f"{title}; {net_displacement(body, trajectory)}"
    return {
        "stroke": stroke_figure(body, trajectory, title),
        "poses": poses_figure(body, trajectory, title),
        "time": time_figure(as_table(trajectory), text),
    }


def _show_plot(console: Console, document: PlotDocument) -> None:
    console.print(f"picture in {document['picture']}", soft_wrap=True)


def _show_figures(console: Console, document: FiguresDocument) -> None:
    for file in document["pictures"]:
        console.print(file, soft_wrap=True)


def _show_view(console: Console, document: ViewDocument) -> None:
    text = f"{document['frames']} of {document['rows']} rows" if document["frames"] < document["rows"] else "all rows"
    console.print(f"page in {document['page']}: {text}, {document['bytes'] / 1e6:.2f} MB", soft_wrap=True)


def _show_film(console: Console, document: FilmDocument) -> None:
    text = f"{document['frames']} frames of {document['width_px']} x {document['height_px']}"
    console.print(f"film in {document['film']}: {text}, {document['bytes'] / 1e6:.2f} MB", soft_wrap=True)
