"""Options and arguments that several commands share."""

from __future__ import annotations

import contextlib
import dataclasses
import functools
import inspect
import re
from collections.abc import Callable, Iterator
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar, get_type_hints

import typer

from purcell_cli.cli.terminal import swimmer_of as _swimmer
from purcell_cli.motion.options import OPTIONS, Option, PlanOptions

R = TypeVar("R")

if TYPE_CHECKING:
    from purcell_cli.files.scenario_file import Scenario

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


DT_DEFAULT_S: float = OPTIONS["dt_s"].default
"""Longest time between rows where none is given [s]."""


_WIDEST_CHOICES = 24
"""Characters of choices that stand beside a flag at most: more would break within a word at 80 columns."""


def _shown(option: Option) -> Any:
    """Return how typer reads an option of a plan and shows it in the help."""
    meaning = f"{option.meaning[0].upper()}{option.meaning[1:]}."
    if option.kind is None or not issubclass(option.kind, StrEnum):
        told = "default:" not in meaning
        return typer.Option(option.flag, metavar=option.metavar, help=meaning, show_default=told)
    names, place = [str(choice) for choice in option.kind], str(option.flag).lstrip("-")
    choices = "|".join(names)
    if len(choices) > _WIDEST_CHOICES:
        choices, meaning = "WHAT", f"{meaning} One of {', '.join(names)}."

    def completions(begun: str) -> list[str]:
        return [name for name in names if name.startswith(begun)]

    return typer.Option(
        option.flag,
        metavar=choices,
        help=meaning,
        parser=lambda name: option.checked(str(name), place),
        autocompletion=completions,
    )


def _taken(option: Option) -> Any:
    """Return the type of what a flag gives."""
    return option.kind if option.kind is None or option.default is not None else option.kind | None


Dt = Annotated[float, _shown(OPTIONS["dt_s"])]
Clearance = Annotated[float, _shown(OPTIONS["clearance_m"])]
MaxMemory = Annotated[
    float,
    typer.Option(
        "--max-memory",
        metavar="GB",
        help="The memory that rows may take; default: 4, or half of what is free if that is less [GB].",
        show_default=False,
    ),
]


def checked_memory(given: float) -> float:
    """Return what --max-memory gives [GB]; what is no budget is refused."""
    return float(OPTIONS["max_memory_gb"].checked(given, "--max-memory"))


def takes_plan_options(command: Callable[..., R]) -> Callable[..., R]:
    """Return a command that takes an option for each of `PlanOptions` with a flag, where this one takes `options`.

    Args:
        command: The command; it gets what was given as one `PlanOptions`, its argument `options`.
    """
    flags = {name: option for name, option in OPTIONS.items() if option.flag is not None}
    hints = get_type_hints(command, include_extras=True)
    parameters = []
    for name, parameter in inspect.signature(command).parameters.items():
        if name == "options":
            parameters += [
                parameter.replace(
                    name=flag, annotation=Annotated[_taken(option), _shown(option)], default=option.default
                )
                for flag, option in flags.items()
            ]
        else:
            parameters.append(parameter.replace(annotation=hints[name]))

    @functools.wraps(command)
    def taking(**given: Any) -> R:
        options = PlanOptions(**{name: given.pop(name) for name in flags})
        return command(options=options, **given)

    taking.__signature__ = inspect.Signature(parameters, return_annotation=hints["return"])  # type: ignore[attr-defined]
    taking.__annotations__ = {p.name: p.annotation for p in parameters} | {"return": hints["return"]}
    return taking


def trajectory_file(out: Path | None, form: str | None, name: str) -> tuple[str, Path]:
    """Return the format and the file of a trajectory that --out and --format ask for; it can be written.

    Args:
        out: The file, if one is named.
        form: The format, if one is named.
        name: What the file is called where none is named, without its ending.
    """
    from purcell_cli.files.atomic_file import writable
    from purcell_cli.files.trajectory_formats import chosen_format

    if out is not None:
        writable(out, "--out")
    form = chosen_format(form, out)
    file = out or Path(f"{name}.{form}")
    writable(file, "--out")
    return form, file


@contextlib.contextmanager
def in_files(**files: str | Path | None) -> Iterator[None]:
    """Name the file of what is refused: "goal: ..." is "goal.yaml: goal: ..." to who gave that file.

    Args:
        files: The file of what a message may begin with, where there is one.
    """
    from purcell_cli.errors import ParameterError

    try:
        yield
    except ParameterError as error:
        begins = re.match(r"[a-z]+", str(error))
        if begins and (file := files.get(begins[0])) is not None:
            error.args = (f"{file}: {error}",)
        raise


def query_files(start: str, goal: str | None, swimmer: Path | None) -> dict[str, str | Path | None]:
    """Return the files of a query, see `query_of`, by what refusals of its parts begin with, for `in_files`."""
    scenario = None if goal is not None else start
    parts = dict.fromkeys(("via", "follow", "obstacles", "wall"), scenario)
    return {**parts, "start": start, "goal": goal or start, "swimmer": swimmer or scenario}


def query_of(start: str, goal: str | None, swimmer: Path | None) -> Scenario:
    """Return what is asked for: two files as a scenario, or a scenario, with the swimmer of the option."""
    from purcell_cli.errors import InputError
    from purcell_cli.files.builtin import find_scenario, refuse_lone_part, refuse_whole_scenario
    from purcell_cli.files.configuration_file import load_configuration, load_goal
    from purcell_cli.files.plan_file import is_plan
    from purcell_cli.files.scenario_file import Scenario

    if goal is not None:
        try:
            begin, end = load_configuration(start), load_goal(goal)
        except InputError:
            refuse_whole_scenario(start)
            refuse_whole_scenario(goal)
            raise
        return Scenario("query", begin, end.configuration, _swimmer(swimmer), workspace=end.workspace)
    if is_plan(start):
        does = "purcell run plays it again, purcell replan plans the rest of it"
        raise InputError(f"{start}: wanted a scenario, found a plan document; {does}")
    refuse_lone_part(start)
    scenario = find_scenario(start)
    return scenario if swimmer is None else dataclasses.replace(scenario, swimmer=_swimmer(swimmer))
