"""Primitive controls and their sequences (section V-A of the paper).

A primitive turns one limb about one of its own axes while the other five controls rest. A limb on a universal joint
turns about the base's z instead of its own: in the limb's frame that direction is constant while its pitch rests.
Conventions: `rotations`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

from purcell_cli.errors import ParameterError, UnknownNameError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, about_axis
from purcell_cli.kernel.shapes import shapes_along

AXIS_NAMES = ("roll", "pitch", "yaw")
"""The axes a limb turns about: its own x, y, z."""

CONTROL_NAMES = tuple(f"limb{limb} {axis}" for limb in (1, 2) for axis in AXIS_NAMES)
"""The six controls in their order."""

BASE_YAWS = (6, 7)
"""The numbers of the turns of limb 1 and limb 2 about the base's z, which universal joints make."""

PRIMITIVE_NAMES = (*CONTROL_NAMES, "limb1 base yaw", "limb2 base yaw")
"""All primitives in their order: the six controls, and the turns about the base's z."""

LIMB_OF: NDArray[np.int64] = np.array([0, 0, 0, 1, 1, 1, 0, 1])
"""The limb that each primitive turns, 0 or 1."""
AXIS_OF: NDArray[np.int64] = np.array([0, 1, 2, 0, 1, 2, 2, 2])
"""The axis that each turns about: x, y, z of the limb, or z of the base."""
for _table in (LIMB_OF, AXIS_OF):
    _table.setflags(write=False)


def control_index(name: str) -> int:
    """Return the index of a control named like 'limb1 yaw'.

    Raises:
        UnknownNameError: No control has this name.
    """
    try:
        return PRIMITIVE_NAMES.index(name)
    except ValueError:
        raise UnknownNameError(f"a control is one of {', '.join(PRIMITIVE_NAMES)}; found {name!r}") from None


@frozen_dataclass(eq=False)
class PrimitiveSequence:
    """A sequence of primitives, played from first to last.

    Attributes:
        control: Which control acts, 0 to 7 in the order of `PRIMITIVE_NAMES`. Shape (n,).
        angle: By how much, signed [rad]. Shape (n,).
    """

    control: NDArray[np.int64]
    angle: Array

    def __repr__(self) -> str:
        return f"<PrimitiveSequence: {len(self)} primitives, joint travel {self.joint_travel_rad:.6g} rad>"

    def __post_init__(self) -> None:
        control = np.array(self.control, dtype=np.int64).reshape(-1)
        angle = np.array(self.angle, dtype=np.float64).reshape(-1)
        if control.shape != angle.shape:
            raise ParameterError(
                f"one angle a control is wanted, found {len(control)} controls and {len(angle)} angles"
            )
        if len(control) and control.view(np.uint64).max() > 7:  # what is negative is large
            raise ParameterError("controls are numbered 0 to 7")
        if not np.isfinite(angle).all():
            raise ParameterError("angles must be finite")
        control.setflags(write=False)
        angle.setflags(write=False)
        object.__setattr__(self, "control", control)
        object.__setattr__(self, "angle", angle)

    @classmethod
    def _known(cls, control: NDArray[np.int64], angle: Array) -> PrimitiveSequence:
        """Return the sequence of controls and angles taken from sequences, which need no second check."""
        out = object.__new__(cls)
        for name, values in (("control", control), ("angle", angle)):
            values.setflags(write=False)
            object.__setattr__(out, name, values)
        return out

    @classmethod
    def of(cls, steps: Iterable[tuple[str | int, float]]) -> PrimitiveSequence:
        """Return the sequence of (control, angle) pairs; a control is its name or its index."""
        pairs = [(control_index(c) if isinstance(c, str) else c, a) for c, a in steps]
        return cls(np.array([c for c, _ in pairs], dtype=np.int64), np.array([a for _, a in pairs]))

    def __len__(self) -> int:
        return len(self.control)

    def __iter__(self) -> Iterator[tuple[str, float]]:
        return iter([(PRIMITIVE_NAMES[c], float(a)) for c, a in zip(self.control, self.angle, strict=True)])

    def __add__(self, other: PrimitiveSequence) -> PrimitiveSequence:
        return joined([self, other])

    def __getitem__(self, part: slice | NDArray[np.int64]) -> PrimitiveSequence:
        return self._known(self.control[part], self.angle[part])

    @property
    def joint_travel_rad(self) -> float:
        """The sum over all primitives of |angle| [rad]."""
        return float(np.abs(self.angle).sum())

    @property
    def duration(self) -> Array:
        """How long each primitive lasts at a joint rate of 1 rad/s: |angle| [s]. Shape (n,)."""
        return np.abs(self.angle)

    def inverse(self) -> PrimitiveSequence:
        """Return the sequence run backwards, which undoes the motion (no inertia)."""
        return self._known(self.control[::-1], -self.angle[::-1])

    def times(self, count: int) -> PrimitiveSequence:
        """Return the sequence repeated a number of times."""
        return self._known(np.tile(self.control, count), np.tile(self.angle, count))

    def busy(self) -> PrimitiveSequence:
        """Return the sequence without the primitives that turn nothing."""
        used = np.flatnonzero(self.angle)
        return self._known(self.control[used], self.angle[used])

    def with_angles(self, angle: ArrayLike) -> PrimitiveSequence:
        """Return the same controls with other angles [rad]. Shape (n,)."""
        other = np.array(angle, dtype=np.float64).reshape(-1)
        if other.shape != self.angle.shape or not np.isfinite(other).all():
            return PrimitiveSequence(self.control, other)  # which refuses it
        return self._known(self.control, other)

    def lasting(self, piece: NDArray[np.int64], duration: Array) -> PrimitiveSequence:
        """Return some of the primitives, each for a time of its own [s] at a joint rate of 1 rad/s. Shapes (m,)."""
        sign = np.where(self.angle < 0, -1.0, 1.0)
        return PrimitiveSequence(self.control[piece], sign[piece] * duration)

    @property
    def limb(self) -> NDArray[np.int64]:
        """The limb that each primitive turns, 0 or 1. Shape (n,)."""
        return LIMB_OF[self.control]

    @property
    def axis(self) -> NDArray[np.int64]:
        """The axis that each primitive turns its limb about: x, y, z of the limb, or z of the base. Shape (n,)."""
        return AXIS_OF[self.control]

    def rates(self, shapes: Array | None = None) -> Array:
        """Return the limb rates of each primitive at unit rate [rad/s]. Shape (n, 6).

        Args:
            shapes: Shapes before the primitives, which turns about the base's z need. Shape (n, 2, 3, 3).

        Raises:
            ParameterError: Turns about the base's z, and no shapes.
        """
        out = np.zeros((len(self), 6))
        based, directions = self._about_base(shapes)
        own = np.flatnonzero(self.control < 6)
        sign = np.where(self.angle < 0, -1.0, 1.0)
        out[own, self.control[own]] = sign[own]
        out.reshape(-1, 2, 3)[based, self.control[based] - 6] = sign[based, None] * directions
        return out

    def turns(self, shapes: Array | None = None) -> Array:
        """Return how each primitive turns the limbs, in their own frames. Shape (n, 2, 3, 3).

        Args:
            shapes: Shapes before the primitives, which turns about the base's z need. Shape (n, 2, 3, 3).

        Raises:
            ParameterError: Turns about the base's z, and no shapes.
        """
        out = np.zeros((len(self), 2, 3, 3))
        out[..., range(3), range(3)] = 1.0
        for axis in range(3):
            mine = np.flatnonzero((self.control < 6) & (self.control % 3 == axis))
            out[mine, self.control[mine] // 3] = about_axis(axis, self.angle[mine])
        based, directions = self._about_base(shapes)
        out[based, self.control[based] - 6] = se3.rotation(self.angle[based, None] * directions)
        return out

    def _about_base(self, shapes: Array | None) -> tuple[NDArray[np.int64], Array]:
        """Return the numbers of the turns about the base's z, and that direction in each limb's frame."""
        based = np.flatnonzero(self.control >= 6)
        if not len(based):
            return based, np.empty((0, 3))
        if shapes is None:
            raise ParameterError("turns about the base's z: the shapes before them are wanted, found none")
        return based, shapes[based, self.control[based] - 6, 2]

    def shapes(self, start: ArrayLike) -> Array:
        """Return the shapes before, between and after the primitives.

        Args:
            start: Shape before the first primitive. Shape (2, 3, 3).

        Returns:
            Shapes. Shape (n + 1, 2, 3, 3).
        """
        return shapes_along(np.asarray(start, dtype=np.float64), self.control, self.angle)


EMPTY = PrimitiveSequence(np.empty(0, dtype=np.int64), np.empty(0))
"""The sequence that does nothing."""


def joined(sequences: Sequence[PrimitiveSequence]) -> PrimitiveSequence:
    """Return sequences played one after the other."""
    parts = [EMPTY, *sequences]
    return EMPTY._known(np.concatenate([s.control for s in parts]), np.concatenate([s.angle for s in parts]))
