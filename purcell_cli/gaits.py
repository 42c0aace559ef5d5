"""Stored gaits: control sequences with an amplitude, made pure by solving for their free angles.

A gait (section V of the paper) starts and ends at the collinear shape. Its angles are linear in
its amplitude and its free symbols; the free symbols are solved so that the gait does nothing but
what it is called, on the true flow, for the swimmer at hand. Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses
import difflib
from collections.abc import Mapping

import numpy as np

from purcell_cli import se3
from purcell_cli.connection import COLLINEAR
from purcell_cli.errors import GaitError, ParameterError, UnknownNameError
from purcell_cli.lift import flow, flow_and_jacobian
from purcell_cli.primitives import EMPTY, PrimitiveSequence
from purcell_cli.rotations import Array, angle_between
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

    def sequence(self, turns: tuple[Turn, ...], symbols: Mapping[str, float]) -> PrimitiveSequence:
        """Return turns as primitives, for values of the symbols [rad]."""
        return PrimitiveSequence(
            np.array([turn.control for turn in turns], dtype=np.int64),
            np.array([sum(c * symbols[s] for s, c in turn.coefficients.items()) for turn in turns]),
        )


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Stroke:
    """A gait at one amplitude for one swimmer: what the swimmer really plays.

    Attributes:
        gait: The gait's name.
        amplitude_rad: The amplitude; negative means the stroke run backwards [rad].
        approach: Primitives played once before the cycles and undone once after them.
        cycle: Primitives of one cycle.
    """

    gait: str
    amplitude_rad: float
    approach: PrimitiveSequence
    cycle: PrimitiveSequence

    def played(self, cycles: int = 1) -> PrimitiveSequence:
        """Return all primitives of a number of cycles, from the collinear shape."""
        return self.approach + self.cycle.times(cycles) + self.approach.inverse()

    def displacement(self, swimmer: Swimmer, cycles: int = 1) -> Array:
        """Return the body displacement of a number of cycles [m]: one cycle and a power. Shape (4, 4)."""
        inner = self.approach.shapes(COLLINEAR)[-1]
        entry = flow(swimmer, self.approach)
        return entry @ se3.power(flow(swimmer, self.cycle, inner), cycles) @ se3.inverse(entry)

    def closure_rad(self) -> float:
        """Return how far one cycle leaves the limbs from the collinear shape, the larger angle [rad]."""
        return float(np.max(angle_between(COLLINEAR, self.played().shapes(COLLINEAR)[-1])))


_PURE = 3e-13
"""Cross-talk and closure (L, rad) that count as none; Newton's method goes on below it while it gains."""


@dataclasses.dataclass(frozen=True, slots=True)
class _Purity:
    """The equations of a pure stroke: no cross-talk, both limbs back, the amplitude where it is the displacement."""

    gait: Gait
    symbols: tuple[str, ...]

    def sequence(self, amplitude: float, unknown: Array) -> PrimitiveSequence:
        values = {"": 1.0, self.gait.symbol: amplitude, **dict(zip(self.symbols, unknown, strict=True))}
        approach = self.gait.sequence(self.gait.approach, values)
        return approach + self.gait.sequence(self.gait.cycle, values) + approach.inverse()

    def slope(self) -> Array:
        """Return the derivative of every angle by every unknown. Shape (n, unknowns)."""
        rows = [[t.coefficients.get(s, 0.0) for s in self.symbols] for t in self.gait.approach]
        cycle = [[t.coefficients.get(s, 0.0) for s in self.symbols] for t in self.gait.cycle]
        return np.array(rows + cycle + [[-c for c in row] for row in reversed(rows)])

    def residual(self, swimmer: Swimmer, amplitude: float, unknown: Array) -> tuple[Array, Array]:
        """Return the equations' values and derivatives by the unknowns. Shapes (12,), (12, unknowns)."""
        sequence = self.sequence(amplitude, unknown)
        g, jacobian = flow_and_jacobian(swimmer, sequence)
        shapes = sequence.shapes(COLLINEAR)
        value = np.concatenate([se3.log(g), *(_rotation_vector(a) for a in shapes[-1])])
        limb, axis = sequence.control // 3, sequence.control % 3
        turned = shapes[np.arange(len(sequence)), limb, :, axis].T
        derivative = np.concatenate([jacobian, *(np.where(limb == i, turned, 0.0) for i in (0, 1))])
        own = MOTIONS.index(self.gait.moves)
        wanted = amplitude if self.gait.amplitude_is_displacement else value[own]
        value[own] -= wanted
        if not self.gait.amplitude_is_displacement:
            derivative[own] = 0.0
        return value, derivative @ self.slope()

    def newton(self, swimmer: Swimmer, amplitude: float, guess: Array) -> Array | None:
        """Return the solution near a guess, or None where Newton's method loses its way.

        Some strokes have directions of unknowns that hardly move any equation. They are left alone
        until the others are met, and then followed in short steps.
        """
        unknown, scale = guess.copy(), np.abs(guess)
        best, kept = np.inf, None
        for _ in range(60):
            value, derivative = self.residual(swimmer, amplitude, unknown)
            size = float(np.max(np.abs(value)))
            if size < best:
                best, kept = size, unknown
            elif best < _PURE:
                break
            step = scale * np.linalg.lstsq(derivative * scale, -value, rcond=min(1e-4, 1e-2 * size))[0]
            unknown = unknown + step / max(1.0, 5.0 * float(np.max(np.abs(step) / scale)))
            if np.any(np.abs(unknown / guess - 1.0) > 1.5):
                break
        return kept if best < _PURE else None


def _rotation_vector(rotation: Array) -> Array:
    return se3.log(se3.pose(rotation, np.zeros(3)))[3:]


def _guess(gait: Gait, swimmer: Swimmer, amplitude: float) -> Array:
    return np.array([guess.at(amplitude, swimmer) for guess in gait.free.values()])


def realise(gait: Gait, swimmer: Swimmer, amplitude: float | None = None) -> Stroke:
    """Return the stroke of a gait for a swimmer, its free angles solved on the true flow.

    Args:
        gait: The gait.
        swimmer: The swimmer.
        amplitude: The amplitude, the gait's default where none is given; negative runs the stroke
            backwards [rad].

    Raises:
        ParameterError: An amplitude that is zero, not finite, or beyond pi.
        GaitError: No free angles make the stroke pure at this amplitude.
    """
    a = gait.default_rad if amplitude is None else float(amplitude)
    if not 0.0 < abs(a) <= np.pi:
        raise ParameterError(f"amplitude: an angle other than 0 and at most pi is wanted, found {a!r} rad")
    size, unit = abs(a), swimmer.scaled()
    values = {"": 1.0, gait.symbol: size}
    if gait.free:
        purity = _Purity(gait, tuple(gait.free))
        found = purity.newton(unit, size, _guess(gait, unit, size))
        if found is None:
            raise GaitError(f"gait {gait.name!r} has no pure stroke at amplitude {size:g} rad for this swimmer; try another")
        values.update(zip(gait.free, map(float, found), strict=True))
    cycle = gait.sequence(gait.cycle, values)
    approach = gait.sequence(gait.approach, values) if gait.approach else EMPTY
    return Stroke(gait.name, a, approach, cycle if a > 0 else cycle.inverse())


def find(gaits: Mapping[str, Gait], name: str) -> Gait:
    """Return the gait with a name or other name.

    Raises:
        UnknownNameError: No gait has it; the message proposes the nearest.
    """
    names = {other: gait for gait in gaits.values() for other in (gait.name, *gait.also)}
    if name in names:
        return names[name]
    near = difflib.get_close_matches(name, names, n=1, cutoff=0.4)
    hint = f"; did you mean {near[0]!r}?" if near else ""
    raise UnknownNameError(f"no gait is called {name!r}{hint} `purcell gait --list` shows all")
