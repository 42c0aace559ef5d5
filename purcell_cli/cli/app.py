"""The command line: parse, load, call the core, show."""

from __future__ import annotations

import contextlib
import dataclasses
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from purcell_cli import __version__
from purcell_cli.cli import batch, controllability, design, files, pictures
from purcell_cli.cli.terminal import GaitFolder, Json, SwimmerFile
from purcell_cli.cli.terminal import bar as _bar
from purcell_cli.cli.terminal import busy as _busy
from purcell_cli.cli.terminal import show as _show
from purcell_cli.cli.terminal import swimmer_of as _swimmer
from purcell_cli.verification.certifier_process import witness

if TYPE_CHECKING:
    from purcell_cli.files.yaml_source import Scenario
    from purcell_cli.solution import Solution

app = typer.Typer(
    name="purcell",
    no_args_is_help=True,
    rich_markup_mode="rich",
    pretty_exceptions_enable=False,
    help="Motion planner for the 3D generalized Purcell swimmer: three slender links, two ball joints, no inertia.",
    epilog="Start with [bold]purcell plan nearby[/], a stored scenario, or [bold]purcell gait --list[/].",
)

DONE, NOT_REACHED, MISUSE, INTERRUPTED = 0, 1, 2, 130

Effort = Annotated[
    str,
    typer.Option(
        "--effort",
        metavar="HOW",
        help="quick; standard; or thorough, for a shorter plan in minutes: Ctrl-C takes the best so far.",
    ),
]
Minimize = Annotated[
    str,
    typer.Option("--minimize", metavar="WHAT", help="What to spend least of: travel, energy or switches."),
]
Controls = Annotated[
    str, typer.Option("--controls", metavar="HOW", help="primitive: one joint at a time; or simultaneous: all at once.")
]
Out = Annotated[
    Path | None,
    typer.Option("--out", metavar="FILE", help="The trajectory's file; default: trajectory.csv, or another ending."),
]
Format = Annotated[
    str | None,
    typer.Option(
        "--format", metavar="NAME", help="csv, parquet, npz or tum; default: by the ending of --out, else csv."
    ),
]
Explain = Annotated[
    bool, typer.Option("--explain", help="Say what each stroke is for, what limits it and what would upset the plan.")
]
Clearance = Annotated[
    float,
    typer.Option(
        "--clearance",
        metavar="METRES",
        help="How far the two limbs stay apart over the whole path, from 0 (may touch).",
    ),
]
Dt = Annotated[float, typer.Option("--dt", metavar="SECONDS", help="Longest time between rows.")]


class _UnsuccessfulError(Exception):
    """A command that ends without success; the document says why."""

    def __init__(self, code: int) -> None:
        self.code = code


def _show_solution(solution: Solution, document: dict[str, Any], json: bool, explain: bool) -> None:
    """Show a plan that was carried out, and why it is as it is; without success where it did not arrive."""
    from purcell_cli.cli.reports.common import show_plan

    if not explain:
        _show(document, json, show_plan)
    else:
        from purcell_cli.cli.reports.explanation import explanation_document, show_explanation
        from purcell_cli.explanation import explain as explained

        def show(console: Any, told: dict[str, Any]) -> None:
            show_plan(console, told)
            show_explanation(console, told)

        reasons = explanation_document(explained(solution), solution.plan.swimmer)
        _show({**document, "explanation": reasons}, json, show)
    if solution.verdict != "reached":
        raise _UnsuccessfulError(NOT_REACHED)


def _query(start: str, goal: str | None, swimmer: Path | None) -> Scenario:
    """Return what is asked for: two files as a scenario, or a scenario, with the swimmer of the option."""
    from purcell_cli.files.builtin import find_scenario
    from purcell_cli.files.yaml_source import Scenario, load_configuration, load_goal

    if goal is not None:
        begin, end = load_configuration(start), load_goal(goal)
        return Scenario("query", begin, end.configuration, _swimmer(swimmer), workspace=end.workspace)
    scenario = find_scenario(start)
    return scenario if swimmer is None else dataclasses.replace(scenario, swimmer=_swimmer(swimmer))


def _two_files(option: str, file: Path, other: Path) -> None:
    """Refuse to write a file over one that is written or read beside it."""
    from purcell_cli.errors import InputError

    if file.resolve() == other.resolve():
        raise InputError(f"{option}: wanted a file other than {other}, found the same")


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


@app.command(epilog="Example: purcell plan start.yaml goal.yaml --out swim.csv")
def plan(
    start: Annotated[
        str,
        typer.Argument(
            metavar="START", help="The start's YAML file; or, without GOAL, a scenario's file or stored name."
        ),
    ],
    goal: Annotated[str | None, typer.Argument(metavar="[GOAL]", help="The goal's YAML file.")] = None,
    out: Out = None,
    form: Format = None,
    swimmer: SwimmerFile = None,
    gaits: GaitFolder = None,
    dt: Dt = 0.05,
    effort: Effort = "standard",
    controls: Controls = "primitive",
    minimize: Minimize = "travel",
    clearance: Clearance = 0.0,
    plan_out: Annotated[
        Path | None,
        typer.Option("--plan-out", metavar="FILE", help="Write the plan itself too, as JSON for purcell run."),
    ] = None,
    explain: Explain = False,
    json: Json = False,
) -> None:
    """Plan a motion from a start to a goal configuration and write it as CSV."""
    with witness() as certifying, _bar("planning") as progress:
        from purcell_cli.cli.reports import common
        from purcell_cli.files.builtin import stored_gaits
        from purcell_cli.files.plan_file import PlanDocument
        from purcell_cli.files.trajectory_csv import whole_file, writable
        from purcell_cli.files.trajectory_formats import chosen_format, write_trajectory
        from purcell_cli.solution import plan as solve

        query = _query(start, goal, swimmer)
        form = chosen_format(form, out)
        file = out or Path(f"trajectory.{form}")
        writable(file)
        if plan_out is not None:
            writable(plan_out)
            _two_files("--plan-out", plan_out, file)
        solution = solve(
            query.start,
            query.goal,
            query.swimmer,
            stored_gaits(gaits),
            dt,
            effort,
            controls,
            minimize,
            clearance,
            query.workspace,
            progress,
            certifying,
        )
        document = common.plan_document(solution, str(file), None if plan_out is None else str(plan_out))
        with contextlib.ExitStack() as both:
            if plan_out is not None:  # it appears only when the trajectory has
                text = PlanDocument(solution.plan, dt, solution.limits.limits).as_text()
                both.enter_context(whole_file(plan_out)).write(text.encode())
            write_trajectory(solution.trajectory, file, form)
    _show_solution(solution, document, json, explain)


@app.command(epilog="Example: purcell plan nearby --plan-out plan.json, then purcell run plan.json --out again.csv")
def run(
    document: Annotated[
        Path, typer.Argument(metavar="PLAN", help="A plan document, as purcell plan --plan-out writes it.")
    ],
    out: Out = None,
    form: Format = None,
    explain: Explain = False,
    json: Json = False,
) -> None:
    """Play a plan again from its document: the same trajectory, checked anew."""
    with witness() as certifying:
        from purcell_cli.cli.reports import common
        from purcell_cli.files.plan_file import load_plan
        from purcell_cli.files.trajectory_csv import writable
        from purcell_cli.files.trajectory_formats import chosen_format, write_trajectory
        from purcell_cli.solution import carried_out

        saved = load_plan(document)
        form = chosen_format(form, out)
        file = out or Path(f"trajectory.{form}")
        writable(file)
        _two_files("--out", file, document)
        with _busy("swimming"):
            solution = carried_out(saved.plan, saved.dt_s, saved.limits, certifying)
            told = common.plan_document(solution, str(file), str(document), "run")
            write_trajectory(solution.trajectory, file, form)
    _show_solution(solution, told, json, explain)


@app.command(epilog="Example: purcell gait z-motion --amplitude 0.5 --cycles 3")
def gait(
    name: Annotated[
        str | None, typer.Argument(metavar="NAME", help="A stored gait; purcell gait --list shows them.")
    ] = None,
    amplitude: Annotated[
        float | None,
        typer.Option(
            "--amplitude", metavar="RAD", help="Its amplitude; negative runs it backwards. Default: the gait's own."
        ),
    ] = None,
    cycles: Annotated[int, typer.Option("--cycles", metavar="N", min=1, max=1000000, help="How often to play it.")] = 1,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="The trajectory's file; default: NAME.csv.")
    ] = None,
    form: Format = None,
    swimmer: SwimmerFile = None,
    gaits: GaitFolder = None,
    dt: Dt = 0.05,
    show_all: Annotated[bool, typer.Option("--list", help="Show all stored gaits, one line each.")] = False,
    atlas: Annotated[bool, typer.Option("--all", help="Show what one cycle of every stored gait does.")] = False,
    sweep: Annotated[
        str | None,
        typer.Option("--sweep", metavar="A:B:STEP", help="Show displacement against amplitude, exact and predicted."),
    ] = None,
    link_ratio: Annotated[
        str | None,
        typer.Option("--link-ratio", metavar="A:B:STEP", help="The same against the ratio of middle to outer link."),
    ] = None,
    json: Json = False,
) -> None:
    """Play a stored gait from the collinear shape, show what it does, and write it as CSV."""
    from purcell_cli.cli import atlas as many_strokes
    from purcell_cli.cli.reports import atlas as many_reports
    from purcell_cli.cli.reports import common
    from purcell_cli.errors import InputError
    from purcell_cli.files.builtin import stored_gaits
    from purcell_cli.files.trajectory_csv import writable
    from purcell_cli.files.trajectory_formats import chosen_format, write_trajectory
    from purcell_cli.gaits.gait import find, realise
    from purcell_cli.gaits.sampling import sample_stroke
    from purcell_cli.mechanics.configuration import Configuration

    stored = stored_gaits(gaits)
    if show_all:
        _show(common.gait_list_document(list(stored.values())), json, common.show_gait_list)
        return
    if sum((atlas, sweep is not None, link_ratio is not None)) > 1:
        raise InputError("one of --all, --sweep and --link-ratio is wanted, found more")
    if out is not None:
        writable(out)
    if atlas:
        with _busy("swimming"):
            document = many_strokes.atlas(stored, _swimmer(swimmer), out)
        _show(document, json, many_reports.show_atlas)
        return
    if name is None:
        raise InputError("a gait's name is wanted; purcell gait --list shows all")
    body = _swimmer(swimmer)
    chosen = find(stored, name)
    if sweep is not None:
        with _busy("swimming"):
            document = many_strokes.amplitudes(chosen, body, sweep, out)
        _show(document, json, many_reports.show_sweep)
        return
    if link_ratio is not None:
        with _busy("swimming"):
            document = many_strokes.ratios(chosen, body, amplitude, link_ratio, out)
        _show(document, json, many_reports.show_ratios)
        return
    stroke = realise(chosen, body, amplitude)
    form = chosen_format(form, out)
    file = out or Path(f"{chosen.name}.{form}")
    writable(file)
    with _busy("swimming"):
        document = common.gait_document(chosen, stroke, body, cycles, str(file))
        write_trajectory(sample_stroke(body, Configuration(), stroke, cycles, dt), file, form)
    _show(document, json, common.show_gait)


@app.command(epilog="Example: purcell verify trajectory.csv start.yaml goal.yaml")
def verify(
    trajectory: Annotated[Path, typer.Argument(metavar="TRAJECTORY", help="A trajectory's CSV file.")],
    start: Annotated[
        str,
        typer.Argument(
            metavar="START", help="The start's YAML file; or, without GOAL, a scenario's file or stored name."
        ),
    ],
    goal: Annotated[str | None, typer.Argument(metavar="[GOAL]", help="The goal's YAML file.")] = None,
    swimmer: SwimmerFile = None,
    tolerance: Annotated[
        float, typer.Option("--tolerance", metavar="X", help="Largest error of position [L] and angles [rad].")
    ] = 1e-9,
    json: Json = False,
) -> None:
    """Check a trajectory: replay its controls by an independent method from start to goal."""
    from purcell_cli.cli.reports import common
    from purcell_cli.errors import ParameterError
    from purcell_cli.files.trajectory_csv import read_csv
    from purcell_cli.verification.verify import verify as check

    if not 0.0 < tolerance < 1.0:
        raise ParameterError(f"--tolerance: a number above 0 and below 1 is wanted, found {tolerance!r}")
    query = _query(start, goal, swimmer)
    table = read_csv(trajectory)
    with _busy("re-integrating"):
        found = check(table, query.start, query.goal, query.swimmer, tolerance, tolerance)
    _show(common.verify_document(found, query.swimmer), json, common.show_verify)
    if not found.holds:
        raise _UnsuccessfulError(NOT_REACHED)


pictures.register(app)
design.register(app)
batch.register(app)
files.register(app)
controllability.register(app)


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
    except _UnsuccessfulError as failure:
        return failure.code
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
