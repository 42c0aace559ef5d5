"""A configuration: the base's pose and both limbs' orientations (section II-A of the paper)."""

from __future__ import annotations

import dataclasses

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul, norm
from purcell_cli.geometry.rotations import Array, angle_between, as_euler, from_euler, from_matrix
from purcell_cli.geometry.three_numbers import three_numbers
from purcell_cli.mechanics.connection import COLLINEAR


@frozen_dataclass(eq=False)
class Configuration:
    """A point of Q = SO(3) x SO(3) x SE(3). Conventions: `rotations`.

    Attributes:
        pose: The base's pose g in the world [m]. Shape (4, 4).
        shape: The limbs' orientations (A_1, A_2) in the base. Shape (2, 3, 3).

    Raises:
        ParameterError: A number that is not finite, or a matrix that is no rotation.
    """

    pose: Array = dataclasses.field(default_factory=lambda: np.eye(4))
    shape: Array = dataclasses.field(default_factory=lambda: COLLINEAR)

    def __repr__(self) -> str:
        angles = [np.degrees(as_euler(r)) for r in (self.pose[:3, :3], *self.shape)]
        place, base, *limbs = (", ".join(f"{v + 0.0:.4g}" for v in part) for part in (self.pose[:3, 3], *angles))
        return f"<Configuration: at ({place}) m, base ({base}), limbs ({limbs[0]}) and ({limbs[1]}) deg>"

    def __post_init__(self) -> None:
        pose, shape = np.array(self.pose, dtype=np.float64), np.array(self.shape, dtype=np.float64)
        if pose.shape != (4, 4) or shape.shape != (2, 3, 3):
            raise ParameterError(
                f"a pose (4, 4) and a shape (2, 3, 3) are wanted, found {pose.shape} and {shape.shape}"
            )
        if not (np.all(np.isfinite(pose)) and np.all(np.isfinite(shape))):
            raise ParameterError("a configuration's numbers must be finite")
        pose[:3, :3] = from_matrix(pose[:3, :3])
        shape = from_matrix(shape)
        for name, value in (("pose", pose), ("shape", shape)):
            value.setflags(write=False)
            object.__setattr__(self, name, value)

    @classmethod
    def from_angles(
        cls,
        position_m: ArrayLike = (0.0, 0.0, 0.0),
        base_euler_deg: ArrayLike = (0.0, 0.0, 0.0),
        limb1_euler_deg: ArrayLike = (0.0, 0.0, 0.0),
        limb2_euler_deg: ArrayLike = (0.0, 0.0, 0.0),
    ) -> Configuration:
        """Return the configuration with Euler angles (psi, theta, phi) in degrees.

        Args:
            position_m: The base's position [m]. Shape (3,).
            base_euler_deg: The base's orientation [deg]. Shape (3,).
            limb1_euler_deg: Limb 1's orientation [deg]. Shape (3,).
            limb2_euler_deg: Limb 2's orientation [deg]. Shape (3,).

        Raises:
            ParameterError: One of them is not three finite numbers.
        """
        position = three_numbers(position_m, "position_m")
        base = from_euler(np.radians(three_numbers(base_euler_deg, "base_euler_deg")))
        limb1 = from_euler(np.radians(three_numbers(limb1_euler_deg, "limb1_euler_deg")))
        limb2 = from_euler(np.radians(three_numbers(limb2_euler_deg, "limb2_euler_deg")))
        return cls(se3.pose(base, position), np.stack([limb1, limb2]))


@frozen_dataclass
class Deviation:
    """How far one configuration is from another.

    Attributes:
        position_m: Distance of the base positions [m].
        base_rad: Angle between the base orientations [rad].
        limb1_rad: Angle between the orientations of limb 1 [rad].
        limb2_rad: Angle between the orientations of limb 2 [rad].
    """

    position_m: float
    base_rad: float
    limb1_rad: float
    limb2_rad: float

    @classmethod
    def between(cls, found: Configuration, wanted: Configuration) -> Deviation:
        """Return the deviation of a configuration found from the one wanted."""
        limbs = angle_between(wanted.shape, found.shape)
        return cls(
            float(norm(found.pose[:3, 3] - wanted.pose[:3, 3])),
            float(angle_between(wanted.pose[:3, :3], found.pose[:3, :3])),
            float(limbs[0]),
            float(limbs[1]),
        )

    def within(self, position_m: float, angle_rad: float) -> bool:
        """Return whether the position is within one tolerance and every angle within the other."""
        return self.position_m <= position_m and max(self.base_rad, self.limb1_rad, self.limb2_rad) <= angle_rad


def displacement_between(start: Configuration, goal: Configuration, length_m: float) -> Array:
    """Return the body displacement g_start^-1 g_goal from one configuration's base to the other's.

    Args:
        start: The one.
        goal: The other.
        length_m: The length that positions are measured in [m].

    Returns:
        The displacement in units of that length. Shape (4, 4).
    """
    first, second = (se3.pose(c.pose[:3, :3], c.pose[:3, 3] / length_m) for c in (start, goal))
    return np.asarray(matmul(se3.inverse(first), second))
