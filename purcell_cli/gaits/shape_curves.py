"""Closed curves of shapes: way points, or truncated Fourier series, played as straight moves.

A shape is given by the rotation vectors of both limbs from the collinear shape, (roll, pitch, yaw)
of limb 1 and then of limb 2. On a straight move each limb turns at a constant rate about one fixed
axis, so the lift follows it exactly. Conventions: `rotations`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import cos, matmul, norm, sin
from purcell_cli.geometry.rotations import Array, as_vector, cross
from purcell_cli.mechanics.moves import MoveSequence

MOST_STEPS = 4096
"""Moves that a Fourier series may be played as."""
_COAXIAL = 1e-12
"""Sine of the angle between parallel rotation vectors, and the length [rad] of one that counts as none: above rounding,
and a thousandth of what a certificate tolerates."""

_LONGEST_RAD = 3.0
"""A rotation vector may change so much in one move where its direction does: it could be no shortest way."""


def straight_moves(way_points: ArrayLike) -> MoveSequence:
    """Return the straight moves from each way point to the next.

    A limb goes the shortest way about one axis; where both rotation vectors have one axis, it turns
    about that axis by the difference, which may be more than half a turn.

    Args:
        way_points: Rotation vectors of both limbs [rad]. Shape (n + 1, 6).

    Raises:
        ParameterError: A rotation vector changes by almost pi or more, and its direction too.
    """
    vectors = np.asarray(way_points, dtype=np.float64).reshape(-1, 2, 3)
    first, last = vectors[:-1], vectors[1:]
    size = norm(first) * norm(last)
    coaxial = norm(cross(first, last)) <= _COAXIAL * np.maximum(size, _COAXIAL)
    turn = as_vector(matmul(np.swapaxes(se3.rotation(first), -1, -2), se3.rotation(last)))
    far = ~coaxial & (norm(last - first) > _LONGEST_RAD)
    if np.any(far):
        k, limb = np.argwhere(far)[0]
        raise ParameterError(
            f"a way point between numbers {k} and {(k + 1) % (len(vectors) - 1)}, since limb {limb + 1}'s rotation "
            f"vector changes by more than {_LONGEST_RAD:g} rad is wanted, found none"
        )
    return MoveSequence.of_turns(np.where(coaxial[..., None], last - first, turn).reshape(-1, 6))


@frozen_dataclass(eq=False)
class WayPoints:
    """A closed polygon of shapes.

    Attributes:
        vectors: Rotation vectors of both limbs at its corners, the first not repeated [rad]. Shape (n, 6).

    Raises:
        ParameterError: Fewer than two way points, or two that are too far apart for a straight move.
    """

    vectors: Array

    def __post_init__(self) -> None:
        vectors = np.array(self.vectors, dtype=np.float64).reshape(-1, 6)
        if len(vectors) < 2:
            raise ParameterError(f"two way points or more are wanted, found {len(vectors)}")
        vectors.setflags(write=False)
        object.__setattr__(self, "vectors", vectors)
        straight_moves(np.concatenate([vectors, vectors[:1]]))

    @property
    def corners(self) -> Array:
        """The shapes between the moves, the first again at the end [rad]. Shape (n + 1, 6)."""
        return np.concatenate([self.vectors, self.vectors[:1]])


@frozen_dataclass(eq=False)
class Fourier:
    """A closed curve of shapes as a truncated Fourier series of the rotation vectors.

    At phase s it is constant + sum over n of cosine[n-1] cos(n s) + sine[n-1] sin(n s), s from 0 to 2 pi.

    Attributes:
        constant: Rotation vectors of both limbs [rad]. Shape (6,).
        cosine: Coefficients [rad]. Shape (harmonics, 6).
        sine: Coefficients [rad]. Shape (harmonics, 6).
        steps: How many straight moves it is played as.

    Raises:
        ParameterError: Fewer than eight steps for each harmonic, or too many.
    """

    constant: Array
    cosine: Array
    sine: Array
    steps: int = 256

    def __post_init__(self) -> None:
        least = 8 * max(len(self.cosine), 1)
        if not least <= self.steps <= MOST_STEPS:
            raise ParameterError(
                f"steps: a whole number at least {least} and at most {MOST_STEPS} is wanted, found {self.steps}"
            )
        straight_moves(self.corners)

    @property
    def corners(self) -> Array:
        """The corners of the polygon that is played, the first again at the end [rad]. Shape (steps + 1, 6).

        The polygon through points of the curve lies inside it: its own harmonic n is sinc^2(n h / 2)
        times as large, h = 2 pi / steps. Divided by that, the corners lie a little outside, the
        harmonics are those of the curve. Turn and distance of a planar curve are met to fourth order in h,
        the direction seen from the collinear shape, and all of a spatial curve, to second.
        """
        harmonic = np.arange(1, len(self.cosine) + 1)
        grown = 1.0 / np.sinc(harmonic / self.steps) ** 2
        s = 2.0 * np.pi * np.arange(self.steps) / self.steps
        angle = np.outer(s, harmonic)
        points = self.constant + matmul(grown * cos(angle), self.cosine) + matmul(grown * sin(angle), self.sine)
        return np.concatenate([points, points[:1]])


Curve = WayPoints | Fourier
"""A closed curve of shapes."""


def size_rad(curve: Curve) -> float:
    """Return how far a limb turns from the collinear shape at most, at a corner [rad]."""
    return float(np.max(norm(curve.corners.reshape(-1, 3))))


def played(curve: Curve, scale: float) -> tuple[MoveSequence, MoveSequence]:
    """Return the straight move from the collinear shape to the curve's beginning, and the moves of one cycle.

    Args:
        curve: The curve.
        scale: All rotation vectors are multiplied by it.

    Raises:
        ParameterError: Two corners are too far apart for a straight move.
    """
    corners = scale * curve.corners
    approach = straight_moves(np.stack([np.zeros(6), corners[0]]))
    return approach if np.any(corners[0]) else approach[:0], straight_moves(corners)
