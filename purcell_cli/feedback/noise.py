"""What disturbs a swimmer: joints that are not where they should be, uneven rates, and a stream."""

from __future__ import annotations

import math

import numpy as np

from purcell_cli.feedback.sizes import refuse_sizes, sizes_of
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul, normal_numbers
from purcell_cli.geometry.rotations import Array

_MOST = {"angle_deg": 90.0, "rate": 0.5, "drift_m_s": 1e3}
"""The most noise of each kind: beyond, nothing of the motion is left."""


@frozen_dataclass
class Noise:
    """The size of disturbances: standard deviations of normal numbers.

    Attributes:
        angle_deg: Of the error of each joint's three angles, the same all the way: how far off its zero is [deg].
        rate: Of the part by which a joint's rate is off, drawn anew wherever the control changes.
        drift_m_s: Of each component of the velocity of a stream that carries the swimmer along [m/s].
        seed: Seed of the numbers.

    Raises:
        ParameterError: A size that is negative or too large, or a seed that is none.
    """

    angle_deg: float = 0.0
    rate: float = 0.0
    drift_m_s: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        refuse_sizes({name: getattr(self, name) for name in _MOST}, _MOST, self.seed)

    @classmethod
    def of(cls, text: str, seed: int = 0) -> Noise:
        """Return the noise of a text such as "angle_deg=0.5,rate=0.02,drift_m_s=1e-4"; empty for none.

        Raises:
            ParameterError: A text that says something else, or says it twice.
        """
        return cls(**sizes_of(text, _MOST), seed=seed)

    def disturbed(self, shape: Array, rates: Array) -> tuple[Array, Array, Array]:
        """Return what becomes of a motion's shape at the beginning, its controls, and the stream's velocity.

        Args:
            shape: Shape at the beginning. Shape (2, 3, 3).
            rates: Controls, row by row [rad/s]. Shape (n, 6).

        Returns:
            Shapes (2, 3, 3), (n, 6) and (3,).
        """
        rng = np.random.default_rng(self.seed)
        segment = np.cumsum(np.append(False, np.any(rates[1:] != rates[:-1], axis=1)))
        angles, stream, parts = (normal_numbers(rng, size) for size in ((2, 3), (3,), (int(segment[-1]) + 1, 6)))
        twists = np.concatenate([np.zeros((2, 3)), math.radians(self.angle_deg) * angles], axis=1)
        begun = matmul(shape, se3.exp(twists)[:, :3, :3]) if self.angle_deg else shape
        return begun, rates * (1.0 + self.rate * parts[segment]), self.drift_m_s * stream


NO_NOISE = Noise()
"""Nothing disturbs the swimmer."""
