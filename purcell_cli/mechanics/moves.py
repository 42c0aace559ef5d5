"""Moves: controls that act at once, and what any sequence of controls is.

On a move all six controls are constant, so each limb turns at a constant rate about an axis fixed
in it. A primitive is a move on which one control acts. Conventions: `rotations`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Protocol, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.shapes import shapes_along
from purcell_cli.mechanics import primitives
from purcell_cli.mechanics.primitives import PrimitiveSequence


class ControlSequence(Protocol):
    """Pieces of constant controls, played from first to last: primitives or moves."""

    def __len__(self) -> int: ...

    def __getitem__(self, part: slice) -> Self: ...

    @property
    def duration(self) -> Array:
        """How long each piece lasts at a joint rate of 1 rad/s [s]. Shape (n,)."""

    @property
    def joint_travel_rad(self) -> float:
        """The sum over all pieces and joints of |angle| [rad]."""

    def rates(self, shapes: Array | None = None) -> Array:
        """Return the limb rates of each piece at a joint rate of 1 rad/s [rad/s]. Shape (n, 6).

        Args:
            shapes: Shapes before the pieces, which turns about the base's z need. Shape (n, 2, 3, 3).
        """

    def turns(self, shapes: Array | None = None) -> Array:
        """Return how each piece turns the limbs, in their own frames; see `rates`. Shape (n, 2, 3, 3)."""

    def shapes(self, start: ArrayLike) -> Array:
        """Return the shapes before, between and after the pieces. Shape (n + 1, 2, 3, 3)."""

    def inverse(self) -> Self:
        """Return the sequence run backwards, which undoes the motion (no inertia)."""

    def lasting(self, piece: NDArray[np.int64], duration: Array) -> Self:
        """Return some of the pieces, at the rates they have, each for a time of its own.

        Args:
            piece: Which pieces. Shape (m,).
            duration: How long each is played at a joint rate of 1 rad/s [s]. Shape (m,).
        """


@frozen_dataclass(eq=False)
class MoveSequence:
    """A sequence of moves, played from first to last.

    Attributes:
        rate: The six controls at a joint rate of 1 rad/s, none above 1 [rad/s]. Shape (n, 6).
        duration: How long each move lasts at that joint rate [s]. Shape (n,).
    """

    rate: Array
    duration: Array

    def __repr__(self) -> str:
        return f"<MoveSequence: {len(self)} moves, joint travel {self.joint_travel_rad:.6g} rad>"

    def __post_init__(self) -> None:
        rate, duration = np.array(self.rate, dtype=np.float64), np.array(self.duration, dtype=np.float64)
        if duration.ndim != 1 or rate.shape != (len(duration), 6):
            raise ParameterError(f"six rates a duration are wanted, found shapes {rate.shape} and {duration.shape}")
        if not (np.all(np.isfinite(rate)) and np.all(np.isfinite(duration)) and np.all(duration >= 0.0)):
            raise ParameterError("rates must be finite, and durations finite and not negative")
        if np.any(np.abs(rate) > 1.0):
            raise ParameterError(f"rates of at most 1 rad/s are wanted, found {float(np.max(np.abs(rate)))!r}")
        for name, value in (("rate", rate), ("duration", duration)):
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    @classmethod
    def of_turns(cls, turn: ArrayLike) -> MoveSequence:
        """Return the moves that turn both limbs by rotation vectors as fast as their joints can.

        Args:
            turn: Rotation vectors of both limbs, each in its own frame [rad]. Shape (n, 6).
        """
        wanted = np.asarray(turn, dtype=np.float64).reshape(-1, 6)
        duration = np.max(np.abs(wanted), axis=1)
        return cls(wanted / np.where(duration > 0.0, duration, 1.0)[:, None], duration)

    @classmethod
    def of_controls(cls, sequence: ControlSequence) -> MoveSequence:
        """Return any sequence of controls as moves."""
        return cls(sequence.rates(), sequence.duration)

    def __len__(self) -> int:
        return len(self.duration)

    def __add__(self, other: MoveSequence) -> MoveSequence:
        return MoveSequence(np.concatenate([self.rate, other.rate]), np.concatenate([self.duration, other.duration]))

    def __getitem__(self, part: slice) -> MoveSequence:
        return MoveSequence(self.rate[part], self.duration[part])

    @property
    def turn(self) -> Array:
        """The rotation vectors of both limbs, each in its own frame [rad]. Shape (n, 6)."""
        return self.rate * self.duration[:, None]

    @property
    def joint_travel_rad(self) -> float:
        """The sum over all moves and joints of |rate| times duration [rad]."""
        return float(np.sum(np.abs(self.rate) * self.duration[:, None]))

    def rates(self, shapes: Array | None = None) -> Array:  # noqa: ARG002  # moves know their rates
        """Return the limb rates at a joint rate of 1 rad/s [rad/s]. Shape (n, 6)."""
        return self.rate

    def inverse(self) -> MoveSequence:
        """Return the sequence run backwards, which undoes the motion (no inertia)."""
        return MoveSequence(-self.rate[::-1], self.duration[::-1])

    def lasting(self, piece: NDArray[np.int64], duration: Array) -> MoveSequence:
        """Return some of the moves, at the rates they have, each for a time of its own [s]."""
        return MoveSequence(self.rate[piece], duration)

    def turns(self, shapes: Array | None = None) -> Array:  # noqa: ARG002
        """Return how each move turns the limbs, in their own frames. Shape (n, 2, 3, 3)."""
        return se3.rotation(self.turn.reshape(-1, 2, 3))

    def shapes(self, start: ArrayLike) -> Array:
        """Return the shapes before, between and after the moves.

        Args:
            start: Shape before the first move. Shape (2, 3, 3).

        Returns:
            Shapes. Shape (n + 1, 2, 3, 3).
        """
        return shapes_along(np.asarray(start, dtype=np.float64), None, self.turn)


def chained(sequences: Sequence[ControlSequence]) -> ControlSequence:
    """Return sequences one after the other: primitives if all of them are, moves otherwise."""
    one_by_one = [s for s in sequences if isinstance(s, PrimitiveSequence)]
    return primitives.joined(one_by_one) if len(one_by_one) == len(sequences) else joined(sequences)


def joined(sequences: Iterable[ControlSequence]) -> MoveSequence:
    """Return sequences of any kind as moves, one after the other."""
    parts = list(sequences)
    rate = np.concatenate([np.empty((0, 6)), *(s.rates() for s in parts)])
    return MoveSequence(rate, np.concatenate([np.empty(0), *(s.duration for s in parts)]))
