"""Stored gaits: control sequences with an amplitude, made pure by solving for their free angles.

A gait (section V of the paper) starts and ends at the collinear shape. Its angles are linear in
its amplitude and its free symbols; the free symbols are solved so that the gait does nothing but
what it is called, on the true flow, for the swimmer at hand. A gait may also be a closed curve of
shapes on which all joints turn at once; it is only played. Conventions: `rotations`.
"""

from __future__ import annotations

import bisect
import dataclasses
import math
from collections.abc import Mapping
from typing import cast

import numpy as np

from purcell_cli.errors import GaitError, ParameterError, UnknownNameError
from purcell_cli.gaits.shape_curves import Curve, played
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, angle_between
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import flow
from purcell_cli.mechanics.lift_derivatives import flow_and_jacobian, shape_gap
from purcell_cli.mechanics.moves import ControlSequence, chained
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.wording import nearest

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
        x, y = self.amplitude_rad, [abs(v) for v in self.value]
        size, sign = abs(amplitude), math.copysign(1.0, self.value[0])
        level = y[0] * size / x[0]
        if len(x) > 1:
            k = min(max(bisect.bisect_left(x, size) - 1, 0), len(x) - 2)
            power = math.log(y[k + 1] / y[k]) / math.log(x[k + 1] / x[k])
            level = y[k] * (size / x[k]) ** power
        return float(sign * level * swimmer.roll_sharpness() ** self.sharpness_power)


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
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


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
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

    def played(self, cycles: int = 1) -> ControlSequence:
        """Return all primitives or moves of a number of cycles, from the collinear shape."""
        return chained([self.approach, *[self.cycle] * cycles, self.approach.inverse()])

    def parts(self, cycles: int) -> list[tuple[ControlSequence, int]]:
        """Return what is played one after the other, and how often."""
        return [(self.approach, 1), (self.cycle, cycles), (self.approach.inverse(), 1)]

    def inverse(self) -> Stroke:
        """Return the stroke run backwards, which makes the inverse displacement."""
        return dataclasses.replace(self, amplitude_rad=-self.amplitude_rad, cycle=self.cycle.inverse())

    def displacement(self, swimmer: Swimmer, cycles: int = 1) -> Array:
        """Return the body displacement of a number of cycles [m]: one cycle and a power. Shape (4, 4)."""
        inner = self.approach.shapes(COLLINEAR)[-1]
        entry = flow(swimmer, self.approach)
        return entry @ se3.power(flow(swimmer, self.cycle, inner), cycles) @ se3.inverse(entry)

    def bend_rad(self) -> float:
        """Return how far a limb's axis bends from the base's, at most where a primitive ends [rad]."""
        return float(np.max(np.arccos(np.clip(self.played().shapes(COLLINEAR)[..., 0, 0], -1.0, 1.0))))

    def closure_rad(self) -> float:
        """Return how far one cycle leaves the limbs from the collinear shape, the larger angle [rad]."""
        return float(np.max(angle_between(COLLINEAR, self.played().shapes(COLLINEAR)[-1])))


_STRONG, _SETTLED = 1e-4, 1e-6
PURE = 3e-13
"""Cross-talk and closure (L, rad) of a stroke that count as none."""
_CLOSINGS, _CLOSED_RAD = 4, 1e-4
"""Newton steps to close a guessed cycle, at most, and a gap after which none follows: what one leaves is the square."""


@dataclasses.dataclass(frozen=True, slots=True)
class _Purity:
    """The equations of a pure stroke: no cross-talk, both limbs back, and the displacement wanted, if any.

    Attributes:
        gait: The gait.
        swimmer: The swimmer, scaled.
        known: The symbols that are given [rad].
        symbols: The symbols to solve for.
        wanted: Displacement along the own axis [L or rad], or None where any will do.
    """

    gait: Gait
    swimmer: Swimmer
    known: Mapping[str, float]
    symbols: tuple[str, ...]
    wanted: float | None

    def values(self, unknown: Array) -> dict[str, float]:
        """Return all symbols' values [rad]."""
        return {"": 1.0, **self.known, **dict(zip(self.symbols, map(float, unknown), strict=True))}

    def slope(self) -> Array:
        """Return the derivative of every angle by every unknown. Shape (n, unknowns)."""
        rows = [[t.coefficients.get(s, 0.0) for s in self.symbols] for t in self.gait.approach]
        cycle = [[t.coefficients.get(s, 0.0) for s in self.symbols] for t in self.gait.cycle]
        return np.array(rows + cycle + [[-c for c in row] for row in reversed(rows)])

    def residual(self, unknown: Array) -> tuple[Array, Array]:
        """Return the equations' values and derivatives by the unknowns. Shapes (12,), (12, unknowns)."""
        approach, cycle = self.gait.primitives(self.values(unknown))
        sequence = approach + cycle + approach.inverse()
        g, jacobian = flow_and_jacobian(self.swimmer, sequence)
        gap, closure = shape_gap(sequence, sequence.shapes(COLLINEAR), COLLINEAR)
        value, derivative = np.concatenate([se3.log(g), gap]), np.concatenate([jacobian, closure])
        own = MOTIONS.index(self.gait.moves)
        if self.wanted is None:
            value[own], derivative[own] = 0.0, 0.0
        else:
            value[own] -= self.wanted
        return value, derivative @ self.slope()

    def newton(self, guess: Array, pure: float) -> Array | None:
        """Return the solution near a guess, or None where Newton's method loses its way.

        Some strokes have directions of unknowns that hardly move any equation. They are left alone
        until the stronger ones have settled, and then followed by one short step at a time.

        Args:
            guess: The unknowns to begin with [rad]. Shape (n,).
            pure: Cross-talk and closure (L, rad) that count as none.
        """
        unknown, scale, rank = guess.copy(), np.abs(guess), 0
        for _ in range(100):
            value, derivative = self.residual(unknown)
            if np.max(np.abs(value)) < pure:
                return unknown
            left, singular, right = np.linalg.svd(derivative * scale, full_matrices=False)
            strong = int(np.sum(singular > _STRONG * singular[0]))
            rank = max(rank, strong)
            step = right[:rank].T @ (left.T[:rank] @ -value / singular[:rank])
            longest = float(np.max(np.abs(step)))
            if longest < _SETTLED:
                rank = min(rank + 1, len(singular))
            elif rank == len(singular) > strong:
                rank -= 1
            unknown = unknown + scale * step / max(1.0, 5.0 * longest)
            if np.any(np.abs(unknown / guess - 1.0) > 1.5):
                break
        return None


def _guess(gait: Gait, swimmer: Swimmer, amplitude: float) -> Array:
    return np.array([guess.at(amplitude, swimmer) for guess in gait.free.values()])


def guessed(gait: Gait, swimmer: Swimmer, amplitude: float) -> Stroke:
    """Return the stroke of a gait with its free angles as guessed, about as pure as the guesses are good.

    Its cycle closes: the angles are changed by as little as brings the limbs back.

    Args:
        gait: The gait, of primitives.
        swimmer: The swimmer.
        amplitude: The amplitude; negative runs the stroke backwards [rad].
    """
    unknown = _guess(gait, swimmer.scaled(), abs(amplitude))
    stroke = gait.stroke(
        {"": 1.0, gait.symbol: abs(amplitude), **dict(zip(gait.free, map(float, unknown), strict=True))}
    )
    cycle = _closed(cast(PrimitiveSequence, stroke.cycle), stroke.approach.shapes(COLLINEAR)[-1])
    stroke = dataclasses.replace(stroke, cycle=cycle)
    return stroke if amplitude > 0 else stroke.inverse()


def _closed(cycle: PrimitiveSequence, start: Array) -> PrimitiveSequence:
    """Return a cycle that almost closes with angles, nearby, by which it does."""
    for _ in range(_CLOSINGS):
        gap, slope = shape_gap(cycle, cycle.shapes(start), start)
        cycle = cycle.with_angles(cycle.angle - np.linalg.lstsq(slope, gap)[0])
        if np.max(np.abs(gap)) < _CLOSED_RAD:
            break
    return cycle


def realise(gait: Gait, swimmer: Swimmer, amplitude: float | None = None, pure: float = PURE) -> Stroke:
    """Return the stroke of a gait for a swimmer, its free angles solved on the true flow.

    Args:
        gait: The gait.
        swimmer: The swimmer.
        amplitude: The amplitude, the gait's default where none is given; negative runs the stroke
            backwards [rad].
        pure: Cross-talk and closure (L, rad) that count as none.

    Raises:
        ParameterError: An amplitude that is zero, not finite, or beyond pi.
        GaitError: No free angles make the stroke pure at this amplitude.
    """
    a = gait.default_rad if amplitude is None else float(amplitude)
    if not 0.0 < abs(a) <= np.pi:
        raise ParameterError(f"amplitude: an angle other than 0 and at most pi is wanted, found {a!r} rad")
    size, unit = abs(a), swimmer.scaled()
    known = {gait.symbol: size}
    wanted = size if gait.amplitude_is_displacement else None
    purity = _Purity(gait, unit, known, tuple(gait.free), wanted)
    solved = purity.newton(_guess(gait, unit, size), pure) if gait.free else np.empty(0)
    if solved is None or np.any(np.abs(solved) > np.pi):
        raise GaitError(
            f"gait {gait.name!r} has no pure stroke at amplitude {size:g} rad for this swimmer; try another"
        )
    stroke = gait.stroke(purity.values(solved))
    return stroke if a > 0 else stroke.inverse()


def realise_displacement(gait: Gait, swimmer: Swimmer, amount: float, near_rad: float) -> Stroke:
    """Return the stroke of a gait that goes a given way along its own axis.

    Amplitude and free angles are solved together.

    Args:
        gait: The gait.
        swimmer: The swimmer.
        amount: Displacement of one cycle, with the sign it has near the guess [L or rad].
        near_rad: A guess of the amplitude [rad].

    Raises:
        GaitError: No pure stroke near the guess goes this far.
    """
    if gait.amplitude_is_displacement:
        return realise(gait, swimmer, amount)
    unit = swimmer.scaled()
    purity = _Purity(gait, unit, {}, (gait.symbol, *gait.free), amount)
    solved = purity.newton(np.array([near_rad, *_guess(gait, unit, near_rad)]), PURE)
    if solved is None:
        raise GaitError(f"gait {gait.name!r} has no pure stroke that moves by {amount:g} near {near_rad:g} rad")
    return gait.stroke(purity.values(solved))


def find(gaits: Mapping[str, Gait], name: str) -> Gait:
    """Return the gait with a name or other name.

    Raises:
        UnknownNameError: No gait has it; the message proposes the nearest.
    """
    names = {other: gait for gait in gaits.values() for other in (gait.name, *gait.also)}
    if name in names:
        return names[name]
    near = nearest(name, names, 0.4)
    hint = f"did you mean {near!r}? " if near else ""
    raise UnknownNameError(f"no gait is called {name!r}; {hint}`purcell gait --list` shows all")
