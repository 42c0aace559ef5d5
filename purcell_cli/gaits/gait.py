"""Stored gaits: control sequences with an amplitude and free angles, and the strokes made of them.

A gait (section V of the paper) starts and ends at the collinear shape. Its angles are linear in its amplitude and
its free symbols, for which `pure_stroke` solves. A gait may also be a closed curve of shapes on which all joints turn
at once; it is only played. Conventions: `rotations`.
"""

from __future__ import annotations

import bisect
import dataclasses
import math
from collections.abc import Mapping

import numpy as np

from purcell_cli.errors import UnknownNameError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.gaits.shape_curves import Curve, played
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import arccos, log, matmul, power_of
from purcell_cli.geometry.rotations import Array, angle_between
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import flow
from purcell_cli.mechanics.moves import ControlSequence, chained
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.wording import nearest

MOTIONS = ("x", "y", "z", "roll", "pitch", "yaw")
"""What a gait can be made to do, in the order of the twist (v, omega)."""

IMPURE = 1e-9
"""Cross-talk and closure (L, rad) that are a fault: a thousand times the rounding errors of the longest strokes, and
no more than plans may miss their goal by."""


@frozen_dataclass
class Turn:
    """One primitive of a gait: a control and an angle linear in the gait's symbols.

    Attributes:
        control: Index of the control, 0 to 5.
        coefficients: The angle as {symbol: coefficient}; the empty symbol is the constant [rad].
    """

    control: int
    coefficients: Mapping[str, float]


@frozen_dataclass
class Guess:
    """Where to start solving for a free symbol: values over amplitudes, joined in the logarithm.

    Attributes:
        amplitude_rad: Amplitudes, ascending [rad]; one is enough for a guess in proportion.
        value: The symbol there [rad], for a swimmer of unit roll sharpness.
        sharpness_power: How the symbol grows with the swimmer's roll sharpness.
    """

    amplitude_rad: tuple[float, ...]
    value: tuple[float, ...]
    sharpness_power: float = 0.0

    def at(self, amplitude: float, swimmer: Swimmer) -> float:
        """Return the guess for an amplitude [rad] and a swimmer."""
        x, y = self.amplitude_rad, [abs(v) for v in self.value]
        size, sign = abs(amplitude), math.copysign(1.0, self.value[0])
        level = y[0] * size / x[0]
        if len(x) > 1:
            k = min(max(bisect.bisect_left(x, size) - 1, 0), len(x) - 2)
            power = log(y[k + 1] / y[k]) / log(x[k + 1] / x[k])
            level = y[k] * power_of(size / x[k], power)
        return float(sign * level * power_of(swimmer.roll_sharpness(), self.sharpness_power))


@frozen_dataclass(eq=False)
class Gait:
    """A stored gait, as its file describes it.

    Attributes:
        name: Its name.
        summary: One line on what it does.
        moves: The one of `MOTIONS` it is made to do, or "none" for a sequence that is only played.
        symbol: The symbol of its amplitude.
        means: What the amplitude is, in words.
        default_rad: The amplitude where none is asked for [rad].
        approach: Turns played once before the cycles and undone once after them.
        cycle: Turns of one cycle.
        free: Symbols to solve for, with their guesses.
        also: Other names.
        source: Where it comes from.
        amplitude_is_displacement: Whether the displacement along the own axis is the amplitude.
        curve: The closed curve of shapes of one cycle, in place of turns; the amplitude scales it.
    """

    name: str
    summary: str
    moves: str
    symbol: str
    means: str
    default_rad: float
    cycle: tuple[Turn, ...]
    approach: tuple[Turn, ...] = ()
    free: Mapping[str, Guess] = dataclasses.field(default_factory=dict)
    also: tuple[str, ...] = ()
    source: str = ""
    amplitude_is_displacement: bool = False
    curve: Curve | None = None

    def __repr__(self) -> str:
        return f"<Gait {self.name}: {self.summary[:70]}>"

    def stroke(self, values: Mapping[str, float]) -> Stroke:
        """Return the stroke for values of all symbols, the empty one being the constant [rad]."""
        if self.curve is not None:
            amplitude = values[self.symbol]
            return Stroke(self.name, amplitude, *played(self.curve, amplitude / self.default_rad))
        return Stroke(self.name, values[self.symbol], *self.primitives(values))

    def primitives(self, values: Mapping[str, float]) -> tuple[PrimitiveSequence, PrimitiveSequence]:
        """Return the primitives of the approach and of one cycle for values of all symbols [rad]."""
        approach, cycle = (
            PrimitiveSequence(
                np.array([turn.control for turn in turns], dtype=np.int64),
                np.array([sum(c * values[s] for s, c in turn.coefficients.items()) for turn in turns]),
            )
            for turns in (self.approach, self.cycle)
        )
        return approach, cycle


@frozen_dataclass(eq=False)
class Stroke:
    """A gait at one amplitude for one swimmer: what the swimmer really plays.

    Attributes:
        gait: The gait's name.
        amplitude_rad: The amplitude; negative means the stroke run backwards [rad].
        approach: Primitives or moves played once before the cycles and undone once after them.
        cycle: Primitives or moves of one cycle.
    """

    gait: str
    amplitude_rad: float
    approach: ControlSequence
    cycle: ControlSequence

    def __repr__(self) -> str:
        return f"<Stroke {self.gait}: amplitude {self.amplitude_rad:.6g} rad, {len(self.cycle)} moves a cycle>"

    def played(self, cycles: int = 1) -> ControlSequence:
        """Return all primitives or moves of a number of cycles, from the collinear shape."""
        return chained([self.approach, *[self.cycle] * cycles, self.approach.inverse()])

    def closes(self) -> bool:
        """Return whether a cycle brings the limbs back, so that it can be repeated as it is."""
        return _left_rad(self.played()) <= IMPURE

    def without_repeats(self, cycles: int) -> ControlSequence:
        """Return all primitives or moves of a number of cycles; of cycles that close, those of one."""
        return self.played(1 if self.closes() else cycles)

    def parts(self, cycles: int) -> list[tuple[ControlSequence, int]]:
        """Return what is played one after the other, and how often; each cycle by itself where it does not close."""
        repeated = (self.cycle, cycles) if self.closes() else (chained([self.cycle] * cycles), 1)
        return [(self.approach, 1), repeated, (self.approach.inverse(), 1)]

    def inverse(self) -> Stroke:
        """Return the stroke run backwards, which makes the inverse displacement."""
        return dataclasses.replace(self, amplitude_rad=-self.amplitude_rad, cycle=self.cycle.inverse())

    def displacement(self, swimmer: Swimmer, cycles: int = 1) -> Array:
        """Return the body displacement of a number of cycles [m]: a power of one that closes. Shape (4, 4)."""
        if not self.closes():
            return flow(swimmer, self.played(cycles))
        inner = self.approach.shapes(COLLINEAR)[-1]
        entry = flow(swimmer, self.approach)
        return matmul(matmul(entry, se3.power(flow(swimmer, self.cycle, inner), cycles)), se3.inverse(entry))

    def bend_rad(self) -> float:
        """Return how far a limb's axis bends from the base's, at most where a primitive ends [rad]."""
        return float(np.max(arccos(np.clip(self.played().shapes(COLLINEAR)[..., 0, 0], -1.0, 1.0))))

    def closure_rad(self, cycles: int = 1) -> float:
        """Return how far a number of cycles leaves the limbs from the collinear shape, the larger angle [rad]."""
        return _left_rad(self.without_repeats(cycles))


def _left_rad(sequence: ControlSequence) -> float:
    """Return how far controls leave the limbs from the collinear shape, the larger angle [rad]."""
    return float(np.max(angle_between(COLLINEAR, sequence.shapes(COLLINEAR)[-1])))


class Gaits(dict[str, Gait]):
    """Gaits by name; `gaits[name]` knows their other names too."""

    def __missing__(self, name: str) -> Gait:
        """Return the gait with another name.

        Raises:
            UnknownNameError: No gait has it; the message proposes the nearest.
        """
        return find(self, name)


def find(gaits: Mapping[str, Gait], name: str) -> Gait:
    """Return the gait with a name or other name.

    Raises:
        UnknownNameError: No gait has it; the message proposes the nearest.
    """
    names = {other: gait for gait in gaits.values() for other in (gait.name, *gait.also)}
    if name in names:
        return names[name]
    near = nearest(name, names)
    hint = f"did you mean {near!r}? " if near else ""
    raise UnknownNameError(f"no gait is called {name!r}; {hint}`purcell gait --list` shows all")
