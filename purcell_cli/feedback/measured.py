"""How exactly a swimmer's configuration is measured."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.wording import nearest_hint

_MOST = {"position_l": 1.0, "base_deg": 45.0}
"""The most noise of each kind: beyond, nothing is measured."""
_HIDDEN = 2.5
"""A measurement's three components are off by more standard deviations than this together once in ten times."""


@dataclasses.dataclass(frozen=True, slots=True)
class Measuring:
    """The noise of measurements of the base's pose: standard deviations of each component.

    The joints' angles are known exactly, as encoders tell them.

    Attributes:
        position_l: Of the position, in units of L.
        base_deg: Of the orientation [deg].
        seed: Seed of the numbers.

    Raises:
        ParameterError: A size that is negative or too large, or a seed that is none.
    """

    position_l: float = 0.0
    base_deg: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        for name, most in _MOST.items():
            value = getattr(self, name)
            if not 0.0 <= value <= most:
                raise ParameterError(f"noise: {name} of at least 0 and at most {most:g} is wanted, found {value!r}")
        if not 0 <= self.seed < 2**63:
            raise ParameterError(f"seed: a whole number at least 0 and below 2^63 is wanted, found {self.seed!r}")

    @classmethod
    def of_text(cls, text: str, seed: int = 0) -> Measuring:
        """Return the noise of a text such as "position_l=1e-3,base_deg=0.1"; empty for none.

        Raises:
            ParameterError: A text that says something else, or says it twice.
        """
        sizes: dict[str, float] = {}
        for part in filter(None, (part.strip() for part in text.split(","))):
            name, _, value = (one.strip() for one in part.partition("="))
            if name not in _MOST or name in sizes:
                wanted = f"each once, as NAME=SIZE, of {', '.join(_MOST)}{nearest_hint(name, _MOST)}"
                raise ParameterError(f"noise: {wanted} is wanted, found {part!r}")
            try:
                sizes[name] = float(value)
            except ValueError:
                sizes[name] = math.nan
            if not math.isfinite(sizes[name]):
                raise ParameterError(f"noise: a finite number for {name} is wanted, found {value!r}")
        return cls(**sizes, seed=seed)

    def of(self, configuration: Configuration, length_m: float, normal: Array) -> Configuration:
        """Return what is measured of a configuration.

        Args:
            configuration: Where the swimmer really is.
            length_m: The swimmer's L [m].
            normal: Normal numbers of unit deviation. Shape (2, 3).
        """
        if not (self.position_l or self.base_deg):
            return configuration
        away = np.concatenate([np.zeros(3), math.radians(self.base_deg) * normal[1]])
        pose = np.asarray(matmul(configuration.pose, se3.exp(away)))
        pose[:3, 3] += self.position_l * length_m * normal[0]
        return Configuration(se3.normalised(pose), configuration.shape)

    def hidden(self, tolerance_l: float, tolerance_rad: float) -> tuple[float, float]:
        """Return tolerances [L, rad] with what the noise may hide added."""
        return tolerance_l + _HIDDEN * self.position_l, tolerance_rad + _HIDDEN * math.radians(self.base_deg)


EXACTLY = Measuring()
"""Measurements without noise."""
