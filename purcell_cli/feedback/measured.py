"""How exactly a swimmer's configuration is measured."""

from __future__ import annotations

import math

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.feedback.sizes import refuse_sizes, sizes_of
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.joint_motion import flattened, plane_axis
from purcell_cli.mechanics.swimmer import Swimmer

_MOST = {"position_l": 1.0, "base_deg": 45.0}
"""The most noise of each kind: beyond, nothing is measured."""
_AT_REST, _MOST_AT_REST = 4, 100
"""So often a swimmer that rests is measured where nothing else is said, and so often at the most: the mean of four has
half the deviation."""
_HIDDEN = 2.5
"""An arrival is believed where the mean is so many of its own deviations beyond the tolerance: its three components are
off by more together once in ten times."""
_MOST_HIDDEN = 10.0
"""And at so many tolerances from the goal at the most: what is measured worse is no arrival."""


@frozen_dataclass
class Measuring:
    """The noise of measurements of the base's pose: standard deviations of each component.

    The joints' angles are known exactly, as encoders tell them.

    Attributes:
        position_l: Of the position, in units of L.
        base_deg: Of the orientation [deg].
        seed: Seed of the numbers.
        at_rest: How often a swimmer that rests is measured, from 1 to 100; the mean counts.

    Raises:
        ParameterError: A size that is negative or too large, or a seed or a count that is none.
    """

    position_l: float = 0.0
    base_deg: float = 0.0
    seed: int = 0
    at_rest: int = _AT_REST

    def __post_init__(self) -> None:
        refuse_sizes({name: getattr(self, name) for name in _MOST}, _MOST, self.seed)
        if self.at_rest != int(self.at_rest) or not 1 <= self.at_rest <= _MOST_AT_REST:
            wanted = f"at_rest as a whole number from 1 to {_MOST_AT_REST}"
            raise ParameterError(f"noise: {wanted} is wanted, found {self.at_rest!r}")

    @classmethod
    def of_text(cls, text: str, seed: int = 0) -> Measuring:
        """Return the noise of a text such as "position_l=1e-3,base_deg=0.1,at_rest=1"; empty for none.

        Raises:
            ParameterError: A text that says something else, or says it twice.
        """
        sizes = sizes_of(text, {**_MOST, "at_rest": _MOST_AT_REST})
        often = sizes.pop("at_rest", float(_AT_REST))
        return cls(**sizes, seed=seed, at_rest=int(often) if often.is_integer() else often)  # type: ignore[arg-type]

    def of(self, configuration: Configuration, length_m: float, normal: Array) -> Configuration:
        """Return what is measured of a configuration.

        Args:
            configuration: Where the swimmer really is.
            length_m: The swimmer's L [m].
            normal: Normal numbers of unit deviation, or the mean of several. Shape (2, 3).
        """
        if not (self.position_l or self.base_deg):
            return configuration
        away = np.concatenate([np.zeros(3), math.radians(self.base_deg) * normal[1]])
        pose = np.asarray(matmul(configuration.pose, se3.exp(away)))
        pose[:3, 3] += self.position_l * length_m * normal[0]
        return Configuration(se3.normalised(pose), configuration.shape)

    def hidden(self, tolerance_l: float, tolerance_rad: float) -> tuple[float, float]:
        """Return tolerances [L, rad] with what the noise may hide added, up to ten times as large as they are."""
        many = _HIDDEN / math.sqrt(self.at_rest)
        noise = self.position_l, math.radians(self.base_deg)
        first, second = (
            min(t + many * n, _MOST_HIDDEN * t) for t, n in zip((tolerance_l, tolerance_rad), noise, strict=True)
        )
        return first, second


EXACTLY = Measuring()
"""Measurements without noise."""


def in_its_plane(swimmer: Swimmer, start: Configuration, measured: Configuration) -> Configuration:
    """Return a measurement without what two parallel hinges cannot have made since the start; others are as they are.

    Args:
        swimmer: The swimmer.
        start: A configuration that it has been in, which tells the plane that its base stays in.
        measured: Where it was measured to be.
    """
    if plane_axis(swimmer) is None:
        return measured
    away = flattened(swimmer, matmul(se3.inverse(start.pose), measured.pose))
    return Configuration(se3.normalised(matmul(start.pose, away)), measured.shape)
