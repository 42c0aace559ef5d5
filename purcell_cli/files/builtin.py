"""The gaits and scenarios that come with the package, and the user's own."""

from __future__ import annotations

import functools
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import yaml

from purcell_cli.errors import InputError, UnknownNameError
from purcell_cli.files.configuration_file import CONFIGURATION_FIELDS
from purcell_cli.files.gait_file import load_gait
from purcell_cli.files.gaits_as_json import gaits_in_json
from purcell_cli.files.paths import is_file, is_folder, is_link, status
from purcell_cli.files.place import shortened
from purcell_cli.files.scenario_file import Scenario, load_scenario
from purcell_cli.files.swimmer_file import load_swimmer
from purcell_cli.files.used_files import note_input
from purcell_cli.files.yaml_source import compose_file
from purcell_cli.gaits.gait import Gait, Gaits
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.wording import nearest

_PACKAGE = Path(__file__).resolve().parent.parent


def data_folder(name: str) -> Path:
    """Return a folder of data: inside the installed package, or beside it in a checkout."""
    installed = _PACKAGE / "data" / name
    return installed if installed.is_dir() else _PACKAGE.parent / name


def stored_gaits(own: Path | str | None = None) -> Gaits:
    """Return the stored gaits by name, the user's own folder added; they are found by their other names too.

    Args:
        own: A folder of gait files; one with the name of a stored gait takes its place.

    Raises:
        InputError: No such folder, none in it, a file that is no gait, or two gaits of one name.
    """
    return Gaits({**_packaged_gaits(), **({} if own is None else own_gaits(own))})


def own_gaits(folder: Path | str) -> dict[str, Gait]:
    """Return the gaits in a folder of the user's own.

    Raises:
        InputError: No such folder, none in it, a file that is no gait, or two gaits of one name.
    """
    return _gaits_in(Path(folder))


@functools.cache
def _packaged_gaits() -> Mapping[str, Gait]:
    folder = data_folder("gaits")
    gaits = gaits_in_json(folder)
    return MappingProxyType(_gaits_in(folder) if gaits is None else gaits)


def _gaits_in(folder: Path) -> dict[str, Gait]:
    if not is_folder(folder):
        raise InputError(f"{folder}: wanted a folder of gait files, found none")
    note_input(folder)
    gaits: dict[str, Gait] = {}
    taken: dict[str, Path] = {}
    files = sorted(path for path in folder.iterdir() if path.suffix in {".yaml", ".yml"})
    if not files:
        raise InputError(f"{folder}: wanted a folder of gait files, found no .yaml or .yml file there")
    for path in files:
        try:
            gait = load_gait(path)
        except InputError as error:
            if {"cycle", "curve"} & (_keys(str(path)) or {"cycle"}):
                raise
            raise InputError(f"{error} (gaits want a folder of their own: each file of it is read as one)") from error
        for name in (gait.name, *gait.also):
            if name in taken:
                raise InputError(f"{path}: wanted a name of its own, found {name!r}, which {taken[name]} has")
            taken[name] = path
        gaits[gait.name] = gait
    return gaits


def stored_scenarios() -> dict[str, Path]:
    """Return the files of the stored scenarios by name."""
    return {path.stem: path for path in sorted(data_folder("scenarios").glob("*.yaml"))}


def stored_swimmers() -> dict[str, Path]:
    """Return the files of the stored swimmers by name."""
    return {path.stem: path for path in sorted(data_folder("swimmers").glob("*.yaml"))}


def _file_or_stored(name: str, kind: str, stored: Mapping[str, Path]) -> str | Path:
    """Return the file that a name is of, or that of what is stored under it.

    Raises:
        UnknownNameError: Neither a file nor anything stored has the name.
    """
    if name in stored and not is_file(name):
        return stored[name]
    if status(name) is None and not is_link(name) and name != "-":
        near = nearest(name, stored)
        hint = f"; did you mean {near!r}?" if near else ""
        raise UnknownNameError(
            f"{shortened(name, 1000)}: wanted a file, or a stored {kind} ({', '.join(stored)}), "
            f"found no such file, and no such {kind}{hint}"
        )
    return name


def find_swimmer(name: str) -> Swimmer:
    """Return the swimmer in a file, or the stored one of that name.

    Raises:
        InputError: The file says no swimmer.
        UnknownNameError: Neither a file nor a stored swimmer has the name.
    """
    return load_swimmer(_file_or_stored(name, "swimmer", stored_swimmers()))


def refuse_lone_part(name: str) -> None:
    """Refuse a file that is a configuration or a goal where a scenario is wanted: the goal is missing beside it.

    Raises:
        InputError: It is one, by its keys.
    """
    keys = _keys(name)
    if keys is not None and keys <= CONFIGURATION_FIELDS.keys():
        shown = shortened(name, 1000)
        raise InputError(f"the goal is missing: {shown} is a configuration; wanted a goal's file after it, found none")


def refuse_whole_scenario(name: str) -> None:
    """Refuse a file that is a scenario where a start or a goal is wanted.

    Raises:
        InputError: It is one, by its keys.
    """
    keys = _keys(name)
    if keys is not None and {"start", "goal"} & keys:
        shown = shortened(name, 1000)
        raise InputError(f"{shown} is a scenario, with a start and a goal of its own: wanted it alone, found two files")


def _keys(name: str) -> set[str] | None:
    """Return the keys of a file's document; None where that is told by who reads it."""
    if name == "-" or not is_file(name):
        return None
    try:
        node = compose_file(name).node
    except InputError:
        return None
    return {str(key.value) for key, _ in node.value} if isinstance(node, yaml.MappingNode) else None


def find_scenario(name: str) -> Scenario:
    """Return the scenario in a file, or the stored one of that name.

    Raises:
        InputError: The file says no scenario.
        UnknownNameError: Neither a file nor a stored scenario has the name.
    """
    return load_scenario(_file_or_stored(name, "scenario", stored_scenarios()))
