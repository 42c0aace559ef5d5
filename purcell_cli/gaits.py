"""Stored gaits: control sequences with an amplitude, made pure by solving for their free angles.

A gait (section V of the paper) starts and ends at the collinear shape. Its angles are linear in
its amplitude and its free symbols; the free symbols are solved so that the gait does nothing but
what it is called, on the true flow, for the swimmer at hand. Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses
import difflib
import functools
from collections.abc import Mapping

import numpy as np

from purcell_cli import se3
from purcell_cli.connection import COLLINEAR
from purcell_cli.errors import GaitError, ParameterError, UnknownNameError
from purcell_cli.lift import flow, flow_and_jacobian
from purcell_cli.primitives import EMPTY, PrimitiveSequence
from purcell_cli.rotations import Array
from purcell_cli.swimmer import Swimmer

MOTIONS = ("x", "y", "z", "roll", "pitch", "yaw")
"""What a gait can be made to do, in the order of the twist (v, omega)."""


@dataclasses.dataclass(frozen=True, slots=True)
class Turn:
    """One primitive of a gait: a control and an angle linear in the gait's symbols.

    Attributes:
        control: Index of the control, 0 to 5.
        coefficients: The angle as {symbol: coefficient}; the empty symbol is the constant [rad].
    """

    control: int
    coefficients: Mapping[str, float]


@dataclasses.dataclass(frozen=True, slots=True)
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
        x, y = np.log(self.amplitude_rad), np.log(np.abs(self.value))
        size, sign = np.log(abs(amplitude)), np.sign(self.value[0])
        if len(x) == 1:
            level = y[0] + size - x[0]
        else:
            k = int(np.clip(np.searchsorted(x, size) - 1, 0, len(x) - 2))
            level = y[k] + (size - x[k]) * (y[k + 1] - y[k]) / (x[k + 1] - x[k])
        return float(sign * np.exp(level) * swimmer.roll_sharpness() ** self.sharpness_power)


@dataclasses.dataclass(frozen=True, slots=True)
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
