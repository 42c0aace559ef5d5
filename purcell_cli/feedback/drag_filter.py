"""What is believed of a swimmer's drag, motion by motion: an extended Kalman filter of factors on links' drag.

The factors are those of `fit`; it is made anew from all rows, the filter takes a motion at a time, in tens of
milliseconds, and few measurements are enough. A measurement is the base's displacement from one place of the motion to
the next. What the swimmer does otherwise than any links alone in the fluid would do counts as noise. A motion is taken
in by a few steps of Gauss and Newton (the iterated filter: Bell and Cathey, IEEE Trans. Automatic Control 38, 1993,
294). Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.errors import ParameterError
from purcell_cli.feedback.drag_factors import Factor, What, factors_of, with_factors
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.linear_systems import inverse, solve
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.lift import SEARCHING, piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer

PRIOR = 0.4
"""Deviation of a factor's logarithm before anything is measured: drags half as large again are likely."""
_OFF, _SHARE = 2e-4, 0.004
"""What a displacement is off by with the best factors [L, rad], besides so large a part of it, where links feel each
other's flow: of 1 to 100 times so much what brought 14 scenarios to their goals with least joint travel."""
_ANEW = 0.03
"""By how much a factor's logarithm is believed to differ from one motion to the next."""
_STEP = 1e-4
"""The change of a factor's logarithm by which derivatives are taken."""
_STEPS, _LONGEST = 6, 0.5
"""Steps for each measurement at most, and by how much a step may change a logarithm."""
_SETTLED = 1e-3
"""Steps end with a change of a logarithm below this."""


@frozen_dataclass(eq=False)
class DragFilter:
    """A swimmer with factors on its links' drag, and how sure they are.

    Attributes:
        guess: The swimmer that the factors are for.
        factors: The factors.
        logs: Their logarithms. Shape (k,).
        covariance: Of the logarithms. Shape (k, k).
    """

    guess: Swimmer
    factors: Sequence[Factor]
    logs: Array
    covariance: Array

    @classmethod
    def of(cls, guess: Swimmer) -> DragFilter:
        """Return what is believed before anything is measured."""
        factors = factors_of(What.KINDS)
        return cls(guess, factors, np.zeros(len(factors)), PRIOR * PRIOR * np.eye(len(factors)))

    @property
    def swimmer(self) -> Swimmer:
        """The swimmer that is believed in."""
        return with_factors(self.guess, self.factors, self.logs.tolist()) if np.any(self.logs) else self.guess

    def after(self, parts: Pieces, rows: NDArray[np.int64], made: Array, noise: Array) -> DragFilter:
        """Return what is believed after a motion that was measured on its way.

        Args:
            parts: The limbs' motion.
            rows: After how many of its parts the base was measured, from 0 on. Shape (m + 1,).
            made: The displacements from each measurement to the next, in units of L. Shape (m, 4, 4).
            noise: Standard deviations of their components [L, rad]. Shape (6,).
        """
        prior = self.covariance + _ANEW * _ANEW * np.eye(len(self.logs))
        known, here, information = inverse(prior), self.logs, inverse(prior)
        twist = se3.log(se3.normalised(made))
        sizes = np.sqrt(np.sum(twist * twist, axis=-1))
        weight = 1.0 / np.sqrt(noise * noise + ((_OFF + _SHARE * sizes) ** 2)[:, None])
        try:
            for _ in range(_STEPS):
                off, change = self._misfit(here, parts, rows, made)
                slope = (change * weight[..., None]).reshape(-1, len(here))
                information = known + matmul(slope.T, slope)
                pull = matmul(slope.T, (off * weight).reshape(-1)) - matmul(known, here - self.logs)
                step = solve(information, pull)
                largest = float(np.max(np.abs(step)))
                here = here + step * min(1.0, _LONGEST / max(largest, 1e-300))
                if largest < _SETTLED:
                    break
            with_factors(self.guess, self.factors, here.tolist())
        except ParameterError:  # no link can have such a drag
            return self
        return dataclasses.replace(self, logs=here, covariance=inverse(information))

    def _misfit(self, logs: Array, parts: Pieces, rows: NDArray[np.int64], made: Array) -> tuple[Array, Array]:
        """Return what is missing with some logarithms [L, rad], (m, 6), and how much of it each adds, (m, 6, k)."""

        def displacements(logs: Array) -> Array:
            moves = piece_displacements(with_factors(self.guess, self.factors, logs.tolist()), parts, SEARCHING)
            poses = se3.prefix_products(moves)[rows]
            out = np.asarray(matmul(se3.inverse(poses[:-1]), poses[1:]))
            out[:, :3, 3] /= self.guess.length_m
            return out

        here = se3.inverse(displacements(logs))
        change = np.empty((len(made), 6, len(logs)))
        for k in range(len(logs)):
            aside = logs.copy()
            aside[k] += _STEP
            change[..., k] = se3.log(se3.normalised(matmul(here, displacements(aside)))) / _STEP
        return np.asarray(se3.log(se3.normalised(matmul(here, made)))), change
