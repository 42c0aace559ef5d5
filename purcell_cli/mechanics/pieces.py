"""Pieces of constant limb rates, each from a shape of its own: what flows, bends and clearances are computed on."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.moves import ControlSequence


@frozen_dataclass(eq=False)
class Pieces:
    """Pieces on which both limbs rotate at constant rates; they need not follow one another.

    Attributes:
        shapes: Shapes at the pieces' beginnings. Shape (n, 2, 3, 3).
        rates: Limb rates (omega_1, omega_2) [rad/s]. Shape (n, 6).
        durations: How long the pieces last, not negative [s]. Shape (n,).
    """

    shapes: Array
    rates: Array
    durations: Array

    @classmethod
    def of(cls, sequence: ControlSequence, start: ArrayLike = COLLINEAR) -> Pieces:
        """Return the pieces of a sequence of controls, at a joint rate of 1 rad/s.

        Args:
            sequence: The controls.
            start: Shape before the first piece. Shape (2, 3, 3).
        """
        return cls.between(sequence, sequence.shapes(start))

    @classmethod
    def between(cls, sequence: ControlSequence, shapes: Array) -> Pieces:
        """Return the pieces of a sequence of controls whose shapes are known.

        Args:
            sequence: The controls.
            shapes: Shapes before, between and after them. Shape (n + 1, 2, 3, 3).
        """
        return cls(shapes[:-1], sequence.rates(shapes[:-1]), sequence.duration)

    @classmethod
    def together(cls, parts: Iterable[Pieces]) -> Pieces:
        """Return the pieces of all parts, to be computed in one batch."""
        none = cls(np.empty((0, 2, 3, 3)), np.empty((0, 6)), np.empty(0))
        every = [none, *parts]
        return cls(
            np.concatenate([p.shapes for p in every]),
            np.concatenate([p.rates for p in every]),
            np.concatenate([p.durations for p in every]),
        )

    def __len__(self) -> int:
        return len(self.durations)

    def __getitem__(self, some: Any) -> Pieces:
        """Return some of the pieces: a slice, or an array of indices."""
        return Pieces(self.shapes[some], self.rates[some], self.durations[some])
