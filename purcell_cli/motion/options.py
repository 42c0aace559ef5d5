"""What may be asked of a plan: one type, whose fields say how the command line and plan documents name them.

A field of `PlanOptions` is declared once, by `_option`: its default, its flag, its key in a plan document, what it
is for and which values it may have. The library, `purcell plan`, `purcell batch` and plan documents read that.
This module imports nothing slow: the command line needs it for its help.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from enum import StrEnum
from numbers import Integral, Real
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, TypeVar

from purcell_cli.errors import ParameterError, UnknownNameError, refuse_types
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.motion.memory import DEFAULT_GB
from purcell_cli.wording import nearest_hint

if TYPE_CHECKING:
    from purcell_cli.environment.scene import Scene
    from purcell_cli.motion.workspace import Workspace

E = TypeVar("E", bound=StrEnum)

MOST_SEED = 2**32 - 1
"""The largest seed: any number of 32 bits."""


class Effort(StrEnum):
    """How long to look for a plan that spends less."""

    QUICK = "quick"
    STANDARD = "standard"
    THOROUGH = "thorough"


class Controls(StrEnum):
    """How joints may turn: one after the other, or all six at once."""

    PRIMITIVE = "primitive"
    SIMULTANEOUS = "simultaneous"


class Objective(StrEnum):
    """What a plan is to spend least of: joint travel, time, energy, switches of control, or what drag may upset."""

    TRAVEL = "travel"
    TIME = "time"
    ENERGY = "energy"
    SWITCHES = "switches"
    SENSITIVITY = "sensitivity"


def member(choices: type[E], name: str, place: str) -> E:
    """Return the member of an enumeration that a name means.

    Args:
        choices: The enumeration.
        name: The name.
        place: What is named, for the message.

    Raises:
        UnknownNameError: No member has this name; the message proposes the nearest.
    """
    known = [str(choice) for choice in choices]
    if name not in known:
        close = nearest_hint(name, known) if isinstance(name, str) else ""
        raise UnknownNameError(f"{place}: one of {', '.join(known)}{close} is wanted, found {name!r}")
    return choices(name)


@frozen_dataclass(kw_only=True)
class Option:
    """How one option is named, what it is for and which values it may have.

    Attributes:
        kind: Its type: an enumeration, `float`, `int`, or None for one that neither flag nor number gives.
        default: Its value where none is given; None also for one whose default depends on others.
        meaning: What it is for, in words that begin small and end without a full stop.
        flag: Its flag on the command line; None for what is asked for by a file.
        key: Its key in a plan document.
        unit: The unit of a number; empty for others.
        metavar: What the help calls a number's value.
        above: A number is more than this.
        at_least: A number is this or more.
        wanted: Which numbers it may be, for messages.
        always: Whether a plan document has it even where it is the default.
        saved: Whether a plan document has it at all.
    """

    kind: type[StrEnum] | type[float] | type[int] | None
    default: Any
    meaning: str
    flag: str | None
    key: str
    unit: str = ""
    metavar: str = ""
    above: float | None = None
    at_least: float | None = None
    wanted: str = ""
    always: bool = False
    saved: bool = True

    def checked(self, value: Any, place: str) -> Any:
        """Return a value as the option's type.

        Args:
            value: The value.
            place: What a name that nothing answers to was given as; a number is called by its flag.

        Raises:
            UnknownNameError: A name that the enumeration has not.
            ParameterError: A number out of range, or none.
        """
        if self.kind is None:
            return value
        if issubclass(self.kind, StrEnum):
            return member(self.kind, value, place)
        if self.kind is int:
            if isinstance(value, bool) or not isinstance(value, Integral) or not 0 <= int(value) <= MOST_SEED:
                raise ParameterError(f"{(self.flag or place).lstrip('-')}: {self.wanted} is wanted, found {value!r}")
            return int(value)
        if isinstance(value, bool) or not isinstance(value, Real) or not self._allows(float(value)):
            raise ParameterError(f"{(self.flag or place).lstrip('-')}: {self.wanted} is wanted, found {value!r}")
        return float(value)

    def _allows(self, value: float) -> bool:
        above = self.above is None or value > self.above
        return math.isfinite(value) and above and (self.at_least is None or value >= self.at_least)


def _option(default: Any, meaning: str, **about: Any) -> Any:
    """Return a field of `PlanOptions`: its type is its default's, and the rest stands in its metadata."""
    about.setdefault("kind", None if default is None else type(default))
    return dataclasses.field(default=default, metadata={"option": Option(default=default, meaning=meaning, **about)})


@frozen_dataclass(kw_only=True)
class PlanOptions:
    """What is asked of a plan besides its start, its goal and its swimmer.

    Names may be given as text: ``PlanOptions(effort="quick")`` is ``PlanOptions(effort=Effort.QUICK)``.

    Attributes:
        dt_s: Longest time between rows of the trajectory [s].
        effort: How long to look for a plan that spends less.
        controls: Whether joints turn one after the other or at once.
        objective: What the plan is to spend least of; left out: joint travel with primitives, time where all joints
            turn at once.
        clearance_m: How far the surfaces of limb 1 and limb 2 stay apart over the whole path, and those of all links
            from obstacles, at least [m].
        max_memory_gb: The memory that the motion and its trajectory may take; where it is the default, 4, no more
            than half of what is free [GB].
        workspace: A box that all three links stay in over the whole path, if there is one.
        obstacles: What no link touches over the whole path, if there is anything; the clearance counts for it too.
        seed: Seed of the search for ways round obstacles.

    Raises:
        UnknownNameError: No effort, controls or objective have this name; the message proposes the nearest.
        ParameterError: A clearance that is negative, a time that is not positive, or a number that is not finite.
    """

    dt_s: float = _option(
        0.05,
        "longest time between rows of the trajectory",
        flag="--dt",
        key="dt_s",
        unit="s",
        metavar="SECONDS",
        above=0.0,
        wanted="a time above 0 s, and finite,",
        always=True,
    )
    effort: Effort = _option(
        Effort.STANDARD,
        "how long to look for a plan that spends less; thorough takes seconds or minutes, Ctrl-C takes the best so far",
        flag="--effort",
        key="effort",
    )
    controls: Controls = _option(
        Controls.PRIMITIVE,
        "how joints turn; primitive: one at a time, simultaneous: all at once",
        flag="--controls",
        key="controls",
    )
    objective: Objective = _option(
        None,
        "what the plan is to spend least of; left out: travel, and time where all joints turn at once; sensitivity: of"
        " plans made for travel, what uncertain drag upsets least, nearly always the one of least travel",
        kind=Objective,
        flag="--minimize",
        key="minimize",
    )
    clearance_m: float = _option(
        0.0,
        "how far the two limbs stay apart, and all links from obstacles, over the whole path, from 0 (may touch)",
        flag="--clearance",
        key="clearance_m",
        unit="m",
        metavar="METRES",
        at_least=0.0,
        wanted="a finite length of 0 m or more",
        always=True,
    )
    max_memory_gb: float = _option(
        DEFAULT_GB,
        "the memory that a plan may take; default: 4, or half of what is free if that is less",
        flag="--max-memory",
        key="max_memory_gb",
        unit="GB",
        metavar="GB",
        above=0.0,
        wanted="a finite number above 0",
        saved=False,
    )
    workspace: Workspace | None = _option(
        None, "a box that all three links stay in; left out, there is none", flag=None, key="workspace_m"
    )
    obstacles: Scene | None = _option(
        None, "what no link may touch; left out, there is nothing", flag=None, key="obstacles"
    )
    seed: int = _option(
        0,
        "seed of the search for ways round obstacles",
        flag="--seed",
        key="seed",
        metavar="N",
        wanted=f"a whole number from 0 to {MOST_SEED}",
    )

    def __post_init__(self) -> None:
        if self.workspace is not None:
            from purcell_cli.motion.workspace import Workspace

            refuse_types(workspace=(self.workspace, Workspace))
        if self.obstacles is not None:
            from purcell_cli.environment.scene import Scene

            refuse_types(obstacles=(self.obstacles, Scene))
        for name, option in OPTIONS.items():
            given = getattr(self, name)
            value = self.left_out(name) if given is None and option.default is None else given
            object.__setattr__(self, name, option.checked(value, name))

    def left_out(self, name: str) -> Any:
        """Return what an option is where it is not given, the others being as they are."""
        if name == "objective":
            return Objective.TIME if self.controls == Controls.SIMULTANEOUS else Objective.TRAVEL
        return OPTIONS[name].default


OPTIONS: Mapping[str, Option] = MappingProxyType(
    {field.name: field.metadata["option"] for field in dataclasses.fields(PlanOptions)}
)
"""How each field of `PlanOptions` was declared, by its name."""
