"""The small gait that carries out a bracket, and how large it may be for the bracket to foretell it.

The flows of X for a, Y for a, X for -a, Y for -a move any point by a^2 [X, Y] and more of order a^3; nested,
they carry out every bracket. What is left of the limbs' rotation is taken back exactly at the end, so that the gait is
closed and the base moves by a^depth times the bracket's twist, to leading order in a. Conventions: `rotations`.
"""

from __future__ import annotations

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import arccos
from purcell_cli.geometry.rotations import Array, as_euler
from purcell_cli.lie_brackets.control_fields import Word
from purcell_cli.lie_brackets.controllability import Bracket
from purcell_cli.mechanics.bead_table import REACH_RAD
from purcell_cli.mechanics.lift import run_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence, joined
from purcell_cli.mechanics.swimmer import Swimmer

TRUST = 0.1
"""A prediction is trusted where it is off by no more than this part of itself."""

_LARGEST_RAD = 1.0
"""The largest amplitude that a prediction is tried at [rad]: the default bend limit of a gait."""

_PER_FACTOR_TWO = 4
"""Amplitudes tried for each factor of two: the trusted amplitude is known to 19 %."""

_SMALLEST_RAD = 2.0**-10
"""The smallest amplitude that a prediction is tried at [rad]; one that fails there is trusted nowhere."""


@frozen_dataclass
class Prediction:
    """The leading-order motion of a bracket's gait in one direction, and how far it holds.

    Attributes:
        rate: Motion in the direction over amplitude^depth [L or rad per rad^depth].
        depth: The power of the amplitude.
        trusted_rad: The largest amplitude up to which the exact lift agrees within `TRUST` [rad]; 0 where it is below
            all that are tried, None beside a wall, where there is no lift.
    """

    rate: float
    depth: int
    trusted_rad: float | None


def _commutator(word: Word, amplitude_rad: float) -> PrimitiveSequence:
    outer = PrimitiveSequence.of([(word[0], amplitude_rad)])
    if len(word) == 1:
        return outer
    inner = _commutator(word[1:], amplitude_rad)
    return joined([outer, inner, outer.inverse(), inner.inverse()])


def bracket_gait(word: Word, amplitude_rad: float, shape: Array) -> PrimitiveSequence:
    """Return the closed gait that carries out a bracket.

    Args:
        word: The bracket's controls.
        amplitude_rad: By how much each control turns its limb [rad].
        shape: The shape it begins and ends at. Shape (2, 3, 3).
    """
    gait = _commutator(word, amplitude_rad)
    left = np.swapaxes(gait.shapes(shape)[-1], -1, -2) @ shape
    psi, theta, phi = as_euler(left).T  # yaw, pitch, roll about the limb's own axes, one after the other
    back = [(3 * limb + axis, angle[limb]) for axis, angle in ((2, psi), (1, theta), (0, phi)) for limb in range(2)]
    return gait + PrimitiveSequence.of([(control, float(angle)) for control, angle in back if angle != 0.0])


def gait_twist(swimmer: Swimmer, word: Word, amplitudes_rad: Array, shape: Array) -> Array:
    """Return how a bracket's gait moves the base, by the exact lift.

    Args:
        swimmer: The swimmer.
        word: The bracket's controls.
        amplitudes_rad: Amplitudes [rad]. Shape (n,).
        shape: The shape it begins and ends at. Shape (2, 3, 3).

    Returns:
        Logarithms (v/L, omega) of the displacements. Shape (n, 6).
    """
    gaits = [bracket_gait(word, float(a), shape) for a in amplitudes_rad]
    pieces = Pieces.together(Pieces.of(g, shape) for g in gaits)
    counts = [len(g) for g in gaits]
    return se3.log(run_displacements(swimmer.scaled(), pieces, counts, np.ones_like(counts)))


def prediction(swimmer: Swimmer, shape: Array, bracket: Bracket, direction: int) -> Prediction:
    """Return what a bracket foretells of its gait in one direction, and up to which amplitude.

    The amplitudes are powers of 2^(1/4) from 0.001 to 1 rad; the smallest are left out where the lift's rounding shows.
    """
    depth, rate = len(bracket.word), float(bracket.twist[direction])
    if swimmer.wall is not None:
        return Prediction(rate, depth, None)
    steps = np.arange(round(np.log2(_SMALLEST_RAD)) * _PER_FACTOR_TWO, 1)
    amplitudes = _LARGEST_RAD * 2.0 ** (steps / _PER_FACTOR_TWO)
    amplitudes = amplitudes[np.abs(rate) * amplitudes**depth > 1e-11]
    if swimmer.fluid == "beads":  # nor those that may bend a limb further than their table reaches
        limbs = [sum(control // 3 == limb for control in bracket.word) for limb in (0, 1)]
        room = REACH_RAD - arccos(np.clip(shape[:, 0, 0], -1.0, 1.0))
        amplitudes = amplitudes[amplitudes * max(limbs) <= np.min(room)]
    if not len(amplitudes):
        return Prediction(rate, depth, 0.0)
    exact = gait_twist(swimmer, bracket.word, amplitudes, shape)[:, direction]
    holds = np.abs(exact - rate * amplitudes**depth) <= TRUST * np.abs(rate) * amplitudes**depth
    count = len(holds) if np.all(holds) else int(np.argmin(holds))
    return Prediction(rate, depth, float(amplitudes[count - 1]) if count else 0.0)
