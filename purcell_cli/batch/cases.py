"""Which scenarios a batch has: the files that paths mean, and each scenario in them, read one at a time."""

from __future__ import annotations

import dataclasses
import glob
import hashlib
import os
import re
import warnings
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from purcell_cli.batch.claims import claim_results, note_parts
from purcell_cli.errors import InputError, PurcellWarning
from purcell_cli.files.builtin import stored_scenarios
from purcell_cli.files.paths import is_folder
from purcell_cli.files.place import Place, shortened
from purcell_cli.files.scalars import NAME
from purcell_cli.files.scenario_file import EXPECT, SCHEMAS, Expect, Scenario, warn_if_far
from purcell_cli.files.sweep import variants
from purcell_cli.files.used_files import note_input
from purcell_cli.files.yaml_source import compose_file
from purcell_cli.frozen_dataclass import frozen_dataclass

_ENDINGS = {".yaml", ".yml"}
_PARTS = ("start", "goal", "swimmer")
_RESERVED = {"summary"}


@frozen_dataclass
class Case:
    """One scenario of a batch.

    Attributes:
        name: Its name, which its files bear.
        file: The file that it stands in.
        sweep: What each swept key is.
        expect: What it must come to.
        scenario: The scenario; None where the file says none.
        error: Why the file says none.
    """

    name: str
    file: str
    sweep: dict[str, Any]
    expect: Expect
    scenario: Scenario | None
    error: str = ""

    def fingerprint(self) -> str:
        """Return a text that changes with anything that the result depends on."""
        scenario = self.scenario
        parts: list[object] = [self.name, self.file, self.sweep, self.expect, self.error]
        if scenario is not None:
            for end in (scenario.start, scenario.goal):
                parts += [end.pose.tobytes(), end.shape.tobytes()]
            parts += [scenario.swimmer, scenario.workspace, scenario.obstacles, scenario.mission.fingerprint()]
        return hashlib.sha256(repr(parts).encode()).hexdigest()


@frozen_dataclass
class _Draft:
    """A scenario that is known by name, but not read yet."""

    name: str
    file: str
    place: Place | None
    sweep: dict[str, Any] = dataclasses.field(default_factory=dict)
    error: str = ""
    own: bool = True
    """Whether the document gives itself the name."""

    def read(self) -> Case:
        """Return the case; a scenario that is refused keeps what it was to come to."""
        if self.place is None:
            return Case(self.name, self.file, self.sweep, Expect(), None, self.error)
        try:
            if self.error:
                raise InputError(self.error)
            scenario: Scenario = SCHEMAS["scenario"].read(self.place)
            warn_if_far(scenario, f"{self.name}: ")
            return Case(self.name, self.file, self.sweep, scenario.expect, scenario)
        except InputError as error:
            return Case(self.name, self.file, self.sweep, _expect(self.place), None, str(error))


def _expect(place: Place) -> Expect:
    """Return what a scenario that cannot be read was to come to."""
    wanted = place.at("expect")
    try:
        return Expect() if wanted.node is place.node else EXPECT.read(wanted)
    except InputError:
        return Expect()


def _name(place: Place, fallback: str) -> tuple[str, bool]:
    """Return the name that a document gives itself, or the fallback made into one, and whether it is its own."""
    try:
        return NAME.read(place.at("name")), True
    except InputError:
        return _made_name(fallback), False


def _made_name(text: str) -> str:
    """Return a text made into a name."""
    return re.sub(r"[^A-Za-z0-9_-]", "_", text)[:100] or "_"


def _drafts(file: str) -> Iterator[_Draft]:
    stem, shown = Path(file).stem, shortened(file, 1000)
    try:
        place = compose_file(file, SCHEMAS["scenario"].wanted)
    except InputError as error:
        yield _Draft(_made_name(stem), shown, None, error=str(error), own=False)
        return
    try:
        for variant in variants(place):
            name, own = _name(variant.place, stem + variant.suffix)
            yield _Draft(name, shown, variant.place, variant.values, own=own)
    except InputError as error:
        name, own = _name(place, stem)
        yield _Draft(name, shown, place, error=str(error), own=own)


@frozen_dataclass
class Cases:
    """The scenarios of a batch, in their order; each is read when its turn comes.

    Attributes:
        files: The files that they stand in.
        passed_over: How many files in folders are no scenarios but parts of them.
        count: How many scenarios there are.
        wanted: Which names are taken, as a pattern; None takes all.
        renamed: Names of those that have none of their own, where the name made for them is another's: by file and
            place in it.
    """

    files: tuple[str, ...]
    passed_over: int
    count: int
    wanted: str | None
    renamed: Mapping[tuple[str, int], str] = dataclasses.field(default_factory=dict)

    def __iter__(self) -> Iterator[Case]:
        """Return the scenarios one after the other."""
        return (draft.read() for draft in self._drafts())

    def asked_for(self, name: str) -> bool:
        """Return whether a name is among those that are wanted."""
        return _fits(name, self.wanted)

    def names(self) -> set[str]:
        """Return the names of the scenarios."""
        return {draft.name for draft in self._drafts()}

    def _drafts(self) -> Iterator[_Draft]:
        for file in self.files:
            for k, draft in enumerate(_drafts(file)):
                if _fits(draft.name, self.wanted):
                    yield dataclasses.replace(draft, name=self.renamed.get((file, k), draft.name))


def _fits(name: str, wanted: str | None) -> bool:
    """Return whether a name has a text in it, or fits a pattern with *, ? or [."""
    if wanted is None:
        return True
    import fnmatch

    return fnmatch.fnmatchcase(name, wanted) if glob.has_magic(wanted) else wanted in name


def find_cases(paths: Iterable[str], wanted: str | None = None, results: Path | None = None) -> Cases:
    """Return the scenarios that files, folders, patterns and stored names mean.

    Args:
        paths: The paths. In folders and those below them, all YAML files but configurations and swimmers count.
        wanted: Only scenarios with this in their name, or whose name fits it if it has *, ? or [.
        results: The folder that results will be written into, if it is known.

    Raises:
        InputError: Nothing is there, two scenarios would write the same files, or a result would take the place of
            what a scenario is made of.
    """
    files, passed_over = _files(paths)
    taken: dict[str, str] = {}
    nameless: list[tuple[str, int, str]] = []
    count = 0
    for file in files:
        for k, draft in enumerate(_drafts(file)):
            count += _fits(draft.name, wanted)
            if draft.place is not None:
                note_parts(draft.place)
            name = draft.name.casefold()
            if not draft.own:
                nameless.append((file, k, draft.name))
                continue
            if name in _RESERVED:
                raise InputError(f"{file}: name: wanted a name other than {draft.name}, which the summary has")
            if name in taken:
                raise InputError(
                    f"{file}: name: wanted a name of its own, found '{draft.name}', which {taken[name]} has too "
                    "(their results would be the same files)"
                )
            taken[name] = file
    renamed = _named(nameless, taken)
    if not count:
        why = f"whose name has {wanted!r}" if taken else "in the paths given"
        raise InputError(f"wanted at least one scenario {why}, found none")
    if results is not None:
        claim_results(results, taken)
    return Cases(tuple(files), passed_over, count, wanted, renamed)


def _named(nameless: list[tuple[str, int, str]], taken: dict[str, str]) -> dict[tuple[str, int], str]:
    """Return names for scenarios whose document says none, where the one that is made of the file's is taken."""
    out = {}
    counts: dict[str, int] = {}
    for file, k, made in nameless:
        name = made
        while name.casefold() in taken or name.casefold() in _RESERVED:
            counts[made] = counts.get(made, 1) + 1
            name = f"{made[:90]}-{counts[made]}"
        taken[name.casefold()] = file
        if name != made:
            out[file, k] = name
    return out


def _files(paths: Iterable[str]) -> tuple[list[str], int]:
    """Return the files of scenarios, each once, and how many others were passed over."""
    found: dict[str, str] = {}
    passed_over = 0
    stored = stored_scenarios()
    for path in paths:
        for file, named in _meant(path, stored):
            if not named and _is_part(file):
                passed_over += 1
            else:
                found.setdefault(os.path.realpath(file), file)
    return list(found.values()), passed_over


def _meant(path: str, stored: dict[str, Path]) -> Iterator[tuple[str, bool]]:
    """Return the files that a path means, and whether it names them one by one."""
    if is_folder(path):
        note_input(path)
        yield from ((file, False) for file in _walk(path))
    elif os.path.lexists(path):
        yield path, True
    elif path in stored:
        yield str(stored[path]), True
    elif glob.has_magic(path):
        matches = sorted(glob.glob(path, recursive=True))  # noqa: PTH207  # a pattern may be absolute
        if not matches:
            raise InputError(f"{path}: wanted a pattern that files fit, found none that do")
        for match in matches:
            if is_folder(match):
                note_input(match)
                yield from ((file, False) for file in _walk(match))
            elif Path(match).suffix.lower() in _ENDINGS:
                yield match, False
    else:
        raise InputError(f"{path}: wanted a file, a folder, a pattern or a stored scenario's name, found none")


def _walk(folder: str) -> Iterator[str]:
    """Return the YAML files in a folder and those below it, hidden ones left out; links to folders are not followed."""
    for parent, folders, names in os.walk(folder):
        folders[:] = sorted(name for name in folders if not name.startswith("."))
        for name in sorted(names):
            if Path(name).suffix.lower() in _ENDINGS and not name.startswith("."):
                yield str(Path(parent) / name)


def _is_part(file: str) -> bool:
    """Return whether a file is a good configuration, goal or swimmer: a part of scenarios and none itself."""
    try:
        place = compose_file(file)
    except InputError:
        return False
    keys = {str(key.value) for key, _ in place.node.value} if isinstance(place.node.value, list) else set()
    return not keys & {"name", "start", "goal", "expect", "sweep"} and any(_reads(kind, place) for kind in _PARTS)


def _reads(kind: str, place: Place) -> bool:
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PurcellWarning)  # it is read again where it is used
            SCHEMAS[kind].read(place)
    except InputError:
        return False
    return True
