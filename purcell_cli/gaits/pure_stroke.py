"""Pure strokes: a gait's free angles solved so that it does nothing but its own motion (section V-B of the paper).

The equations hold on the true flow, for the swimmer at hand; Newton's method starts at the gait's guesses. Many gaits
are pure by a symmetry that a swimmer with unequal limbs has not; then all their angles are free, and change as little
as purity asks for.
Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import cast

import numpy as np

from purcell_cli.errors import GaitError, ParameterError, refuse_types
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.gaits.gait import IMPURE, MOTIONS, Gait, Stroke
from purcell_cli.geometry import se3
from purcell_cli.geometry.linear_systems import least_squares, singular_values
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift_derivatives import flow_and_jacobian, shape_gap
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer

_STRONG = 1e-4
"""Directions of unknowns whose singular value is above this part of the largest are followed from the first step on.

With 1e-6 x-rotation is not solved for a swimmer of slenderness 0.05; with 1e-2 the stored gaits take 5 % more steps."""

_SETTLED = 1e-6
"""A step below this part of every unknown ends the wait for the weaker directions: 1e-2 is too early, and x-rotation is
not solved at amplitudes near 1 rad for long limbs; with 1e-12 the stored gaits take a third more steps."""

PURE = 3e-13
"""Cross-talk and closure (L, rad) of a stroke that count as none."""
_PURE_ON_BEADS = 1e-10
"""The same of links that feel each other's flow: rounding in their table leaves up to some 1e-11."""
_FREED_STEPS, _FREED_RAD = 60, 0.2
"""Newton steps with all angles free, at most (8 are usual), and the largest change of an angle in one [rad]."""
_FREED_RANK = 1e-9
"""Directions of angles whose singular value is below this part of the largest move no equation: rounding."""
_FREED_FAR = 0.75
"""Angles that change by more than this part of the amplitude make another stroke than the gait's."""
_CLOSINGS, _CLOSED_RAD = 4, 1e-4
"""Newton steps to close a guessed cycle, at most, and a gap after which none follows: what one leaves is the square."""


@frozen_dataclass
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
        """Return all symbols' values by those of the unknown ones [rad]. Shape (unknowns,)."""
        return {"": 1.0, **self.known, **dict(zip(self.symbols, map(float, unknown), strict=True))}

    def slope(self) -> Array:
        """Return the derivative of every angle by every unknown. Shape (n, unknowns)."""
        rows = [[t.coefficients.get(s, 0.0) for s in self.symbols] for t in self.gait.approach]
        cycle = [[t.coefficients.get(s, 0.0) for s in self.symbols] for t in self.gait.cycle]
        return np.array(rows + cycle + [[-c for c in row] for row in reversed(rows)])

    def residual(self, unknown: Array) -> tuple[Array, Array]:
        """Return the equations' values and derivatives by the unknowns. Shapes (12,), (12, unknowns)."""
        value, derivative = self.equations(*self.gait.primitives(self.values(unknown)))
        return value, matmul(derivative, self.slope())

    def equations(self, approach: PrimitiveSequence, cycle: PrimitiveSequence) -> tuple[Array, Array]:
        """Return the equations' values and derivatives by all angles of the stroke. Shapes (12,), (12, n)."""
        sequence = approach + cycle + approach.inverse()
        g, jacobian = flow_and_jacobian(self.swimmer, sequence)
        gap, closure = shape_gap(sequence, sequence.shapes(COLLINEAR), COLLINEAR)
        value, derivative = np.concatenate([se3.log(g), gap]), np.concatenate([jacobian, closure])
        own = MOTIONS.index(self.gait.moves)
        if self.wanted is None:
            value[own], derivative[own] = 0.0, 0.0
        else:
            value[own] -= self.wanted
        return value, derivative

    def freed(self, stroke: Stroke, pure: float) -> Stroke | None:
        """Return the pure stroke near another, all its angles being free, or None where Newton's method finds none.

        Args:
            stroke: A stroke of primitives.
            pure: Cross-talk and closure (L, rad) that count as none.
        """
        approach, cycle = cast(PrimitiveSequence, stroke.approach), cast(PrimitiveSequence, stroke.cycle)
        n, begun = len(approach), np.concatenate([approach.angle, cycle.angle])
        angle, every = begun.copy(), np.eye(len(begun))
        slope = np.concatenate([every, -every[:n][::-1]])
        for _ in range(_FREED_STEPS):
            approach, cycle = approach.with_angles(angle[:n]), cycle.with_angles(angle[n:])
            value, derivative = self.equations(approach, cycle)
            if np.max(np.abs(value)) < pure:
                return dataclasses.replace(stroke, approach=approach, cycle=cycle)
            left, singular, right = singular_values(matmul(derivative, slope))
            some = singular > _FREED_RANK * singular[0]
            step = matmul(right[some].T, matmul(left.T[some], -value) / singular[some])
            angle = angle + step * min(1.0, _FREED_RAD / max(float(np.max(np.abs(step))), _FREED_RAD))
            if np.max(np.abs(angle - begun)) > _FREED_FAR * np.max(np.abs(begun)):
                return None
        return None

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
            left, singular, right = singular_values(derivative * scale)
            strong = int(np.sum(singular > _STRONG * singular[0]))
            rank = max(rank, strong)
            if not np.all(singular[: max(rank, 1)] > 0.0):
                return None  # unknowns that moved equations move none any more
            step = matmul(right[:rank].T, matmul(left.T[:rank], -value) / singular[:rank])
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
        cycle = cycle.with_angles(cycle.angle - least_squares(slope, gap))
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
    refuse_types(gait=(gait, Gait), swimmer=(swimmer, Swimmer))
    a = gait.default_rad if amplitude is None else float(amplitude)
    if not 0.0 < abs(a) <= np.pi:
        raise ParameterError(f"amplitude: an angle other than 0 and at most pi is wanted, found {a!r} rad")
    size, unit = abs(a), swimmer.scaled()
    pure = max(pure, _PURE_ON_BEADS) if swimmer.fluid == "beads" else pure
    known = {gait.symbol: size}
    wanted = size if gait.amplitude_is_displacement else None
    purity = _Purity(gait, unit, known, tuple(gait.free), wanted)
    guess = _guess(gait, unit, size)
    solved = purity.newton(guess, pure) if gait.free else np.empty(0)
    good = solved is not None and not np.any(np.abs(solved) > np.pi)
    stroke = gait.stroke(purity.values(solved)) if solved is not None and good else None
    uneven = gait.moves in MOTIONS and gait.curve is None and not unit.equal_limbs
    if uneven and (stroke is None or fault(stroke, gait.moves, unit)):
        stroke = purity.freed(gait.stroke(purity.values(guess)), pure)
    if stroke is None:
        raise GaitError(
            f"gait {gait.name!r} has no pure stroke at amplitude {size:g} rad for this swimmer; try another"
        )
    return stroke if a > 0 else stroke.inverse()


def fault(stroke: Stroke, moves: str, swimmer: Swimmer) -> str:
    """Return in words what one cycle of a stroke does that its gait must not, with figures; empty for none.

    Args:
        stroke: The stroke.
        moves: What its gait is made to do; one for "none" has no fault.
        swimmer: The swimmer.
    """
    if moves not in MOTIONS:
        return ""
    unit, own = swimmer.scaled(), MOTIONS.index(moves)
    twist, closure = se3.log(stroke.displacement(unit)), stroke.closure_rad()
    others = np.abs(np.delete(twist, own))
    worst = int(np.argmax(others))
    along = MOTIONS[worst + (worst >= own)]
    found = []
    if closure > IMPURE:
        found.append(f"its cycle leaves a limb {closure:.3g} rad from where it began")
    if others[worst] > IMPURE:
        found.append(f"it moves {along} too, by {others[worst]:.3g} {'L' if along in 'xyz' else 'rad'} a cycle")
    if abs(twist[own]) <= IMPURE:
        found.append(f"it does not move {moves}")
    return " and ".join(found)


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
    if not unit.equal_limbs:
        near = realise(gait, unit, near_rad)
        found = _Purity(gait, unit, {}, (), amount).freed(near, PURE)
        if found is None:
            raise GaitError(f"gait {gait.name!r} has no pure stroke that moves by {amount:g} near {near_rad:g} rad")
        return found
    purity = _Purity(gait, unit, {}, (gait.symbol, *gait.free), amount)
    solved = purity.newton(np.array([near_rad, *_guess(gait, unit, near_rad)]), PURE)
    if solved is None:
        raise GaitError(f"gait {gait.name!r} has no pure stroke that moves by {amount:g} near {near_rad:g} rad")
    return gait.stroke(purity.values(solved))
