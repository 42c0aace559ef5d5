"""The drag of one link, alone in the fluid: laws for slender rods, numbers that were measured, and a sphere.

Links do not feel each other (resistive force theory). A link is the same all round its axis, so force and torque
about its middle are diagonal: along the axis and across it, turning across the axis, and spinning about it.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Mapping, Sequence
from numbers import Real
from types import MappingProxyType

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import log

LINKS = ("base", "limb1", "limb2")
"""The links, in the order of their numbers."""

COX = "cox"
"""The law of the paper, to leading order in the slenderness."""


@frozen_dataclass
class RodDrag:
    """The drag of a link about its middle.

    Attributes:
        across: Force per speed across the axis [N s/m].
        ratio: How many times the force per speed along the axis that is.
        turn: Torque per rate of turning across the axis [N m s].
        spin: Torque per rate of spinning about it [N m s].
    """

    across: float
    ratio: float
    turn: float
    spin: float

    @property
    def along(self) -> float:
        """Force per speed along the axis [N s/m]."""
        return self.across / self.ratio


def cox(half_m: float, radius_m: float, viscosity_pa_s: float, lateral: float, ratio: float) -> RodDrag:
    """Return the drag of a rod by a lateral drag per length, as section III-A of the paper has it, as corrected.

    The spin is a rigid cylinder's, 4 pi mu a^2 per length; the paper's integral gives half of it.

    Args:
        half_m: Half length [m].
        radius_m: Radius a [m].
        viscosity_pa_s: Viscosity mu [Pa s].
        lateral: Lateral drag per length, 4 pi mu / ln(l/a) with l the full length (Cox) [N s/m^2].
        ratio: Lateral over longitudinal drag.
    """
    spin = 4.0 * math.pi * viscosity_pa_s * radius_m * radius_m
    return RodDrag(2.0 * lateral * half_m, ratio, 2.0 / 3.0 * lateral * half_m * half_m * half_m, 2.0 * spin * half_m)


def cylinder(half_m: float, radius_m: float, viscosity_pa_s: float) -> RodDrag:
    """Return the drag of a cylinder: fits for lengths of 2 to 30 diameters, used beyond them too.

    Tirado, Martinez and Garcia de la Torre 1984, J. Chem. Phys. 81, 2047; the spin is as in `cox`. See there.
    """
    length, p = 2.0 * half_m, half_m / radius_m
    along = 2.0 * math.pi * viscosity_pa_s * length / (log(p) - 0.207 + 0.980 / p - 0.133 / (p * p))
    across = 4.0 * math.pi * viscosity_pa_s * length / (log(p) + 0.839 + 0.185 / p + 0.233 / (p * p))
    turned = math.pi * viscosity_pa_s * length * length * length
    turn = turned / (3.0 * (log(p) - 0.662 + 0.917 / p - 0.050 / (p * p)))
    spin = 4.0 * math.pi * viscosity_pa_s * radius_m * radius_m * length
    return RodDrag(across, across / along, turn, spin)


def spheroid(half_m: float, radius_m: float, viscosity_pa_s: float) -> RodDrag:
    """Return the drag of a prolate spheroid with these half axes, which is exact.

    Chwang and Wu 1975, J. Fluid Mech. 67, 787; Kim and Karrila 1991, Microhydrodynamics, table 3.4. See `cox`.
    """
    thin = radius_m / half_m
    e = math.sqrt((1.0 - thin) * (1.0 + thin))
    g = 2.0 * log((1.0 + e) / thin)
    cubed = e * e * e
    force, torque = 6.0 * math.pi * viscosity_pa_s * half_m, 8.0 * math.pi * viscosity_pa_s * half_m * half_m * half_m
    long = -2.0 * e + (1.0 + e * e) * g
    along = force * 8.0 / 3.0 * cubed / long
    across = force * 16.0 / 3.0 * cubed / (2.0 * e + (3.0 * e * e - 1.0) * g)
    turn = torque * 4.0 / 3.0 * cubed * (2.0 - e * e) / long
    spin = torque * 4.0 / 3.0 * cubed * thin * thin / (2.0 * e - thin * thin * g)
    return RodDrag(across, across / along, turn, spin)


FINITE_RODS: Mapping[str, Callable[[float, float, float], RodDrag]] = MappingProxyType(
    {"cylinder": cylinder, "spheroid": spheroid}
)
"""The laws, besides Cox's, by half length, radius and viscosity."""

LAWS = (COX, *FINITE_RODS)
"""What a swimmer's drag may be called."""

_LARGEST_RATIO = 1e3
"""The largest ratio of lateral over longitudinal drag."""
_MOST_ALONG = 1.5
"""How many times the drag across that along the axis is at most: a flat disc's, broadside over edgewise (16 to 32/3
times viscosity and radius), the most that a body of revolution has. A rod's two numbers exchanged make 2."""
_ALIKE = 1e-6
"""Links of which each drags along and across the same to this part do not push, whatever joints do."""
_UNLIKE = 1e3
"""How many times one link's lateral drag per length may be another's: a unit that was mistaken makes more of it."""
_SHAPES = {"turn": (1e-2, 1e2), "spin": (1e-12, 1e2)}
"""What turning and spinning drags are at least and at most, in units of the drag across times the squared half length:
a rod's turning drag is a third to a half of it, and its spin drag falls with the square of the slenderness."""


def sphere(radius_m: float, viscosity_pa_s: float) -> tuple[float, float]:
    """Return the drag of a sphere (Stokes): force per speed [N s/m] and torque per rate [N m s]."""
    force = 6.0 * math.pi * viscosity_pa_s * radius_m
    return force, 8.0 * math.pi * viscosity_pa_s * radius_m * radius_m * radius_m


def _positive(numbers: LinkDrag | LinkSize, most: float) -> None:
    """Refuse a field that is no positive number, and turn the others into floats.

    Raises:
        ParameterError: A number that is not positive, not finite, or too large.
    """
    for field in dataclasses.fields(numbers):
        value = getattr(numbers, field.name)
        if value is None:
            continue
        if isinstance(value, bool) or not isinstance(value, Real) or not 0.0 < float(value) <= most:
            raise ParameterError(f"{field.name}: a number above 0 and at most {most:g} is wanted, found {value!r}")
        object.__setattr__(numbers, field.name, float(value))


@frozen_dataclass
class LinkDrag:
    """The drag of a whole link as numbers, where they are known; None is as the law of Cox has it.

    Attributes:
        along_n_s_per_m: Force per speed along the axis [N s/m].
        across_n_s_per_m: Force per speed across it [N s/m].
        turn_n_m_s: Torque per rate of turning across the axis, about the middle [N m s].
        spin_n_m_s: Torque per rate of spinning about the axis [N m s].

    Raises:
        ParameterError: A number that is not positive or not finite.
    """

    along_n_s_per_m: float | None = None
    across_n_s_per_m: float | None = None
    turn_n_m_s: float | None = None
    spin_n_m_s: float | None = None

    def __post_init__(self) -> None:
        _positive(self, 1e12)

    def over(self, rod: RodDrag) -> RodDrag:
        """Return the drag of a link with these numbers in place of those of a law."""
        known = (self.across_n_s_per_m, self.along_n_s_per_m) != (None, None)
        across = rod.across if self.across_n_s_per_m is None else self.across_n_s_per_m
        along = rod.along if self.along_n_s_per_m is None else self.along_n_s_per_m
        return RodDrag(
            across,
            across / along if known else rod.ratio,
            rod.turn if self.turn_n_m_s is None else self.turn_n_m_s,
            rod.spin if self.spin_n_m_s is None else self.spin_n_m_s,
        )

    def scaled(self, force: float, torque: float) -> LinkDrag:
        """Return the numbers in units of a force per speed and a torque per rate."""
        units = {"along_n_s_per_m": force, "across_n_s_per_m": force, "turn_n_m_s": torque, "spin_n_m_s": torque}
        return LinkDrag(**{k: getattr(self, k) / v for k, v in units.items() if getattr(self, k) is not None})


@frozen_dataclass
class LinkSize:
    """A link's own size, where it differs from the swimmer's; None where it does not.

    Attributes:
        half_length_m: Half its length [m].
        slenderness: Its radius over its full length.

    Raises:
        ParameterError: A number that is not positive or not finite.
    """

    half_length_m: float | None = None
    slenderness: float | None = None

    def __post_init__(self) -> None:
        _positive(self, 1e6)


@frozen_dataclass
class LinkDrags:
    """The drag of each link as numbers.

    Attributes:
        base: Of the base, without the sphere.
        limb1: Of limb 1.
        limb2: Of limb 2.
    """

    base: LinkDrag = LinkDrag()
    limb1: LinkDrag = LinkDrag()
    limb2: LinkDrag = LinkDrag()

    def scaled(self, force: float, torque: float) -> LinkDrags:
        """Return the numbers in other units; see `LinkDrag.scaled`."""
        return LinkDrags(*(getattr(self, link).scaled(force, torque) for link in LINKS))


@frozen_dataclass
class LinkSizes:
    """The size of each link, where it differs from the swimmer's.

    Attributes:
        base: Of the base.
        limb1: Of limb 1.
        limb2: Of limb 2.
    """

    base: LinkSize = LinkSize()
    limb1: LinkSize = LinkSize()
    limb2: LinkSize = LinkSize()


def refuse_odd(rods: Sequence[RodDrag], halves_m: Sequence[float]) -> None:
    """Refuse drags, by numbers, that no link can have, or not beside the others.

    A link that is rather a disc than a rod drags more along its axis than across it, and pushes the other way.

    Args:
        rods: The links' drags.
        halves_m: Their half lengths [m].

    Raises:
        ParameterError: A link drags more along its axis, beside what it does across it, than a disc; no link's drags
            along and across differ; turning and drifting do not go together, or links are too unlike.
    """
    for link, rod, half in zip(LINKS, rods, halves_m, strict=True):
        if not rod.across / _LARGEST_RATIO <= rod.along <= _MOST_ALONG * rod.across:
            raise ParameterError(
                f"drag.{link}.along_n_s_per_m: a thousandth of the drag across, {rod.across:g} N s/m, to "
                f"{_MOST_ALONG:g} times it (a flat disc's; are along and across exchanged?) is wanted, "
                f"found {rod.along:g}"
            )
        for name, (low, high) in _SHAPES.items():
            value, scale = getattr(rod, name), rod.across * half * half
            if not low * scale <= value <= high * scale:
                raise ParameterError(
                    f"drag.{link}.{name}_n_m_s: {low * scale:.3g} to {high * scale:.3g} N m s, for a link of this "
                    f"length and drag across, is wanted, found {value:g}"
                )
    if all(abs(rod.ratio - 1.0) < _ALIKE for rod in rods):
        raise ParameterError(
            f"drag: a link whose drags along and across differ by more than {_ALIKE:g} of them (others do not push) is "
            f"wanted, found ratios of across to along of {', '.join(f'{rod.ratio:g}' for rod in rods)}"
        )
    each = [rod.across / half for rod, half in zip(rods, halves_m, strict=True)]
    if max(each) > _UNLIKE * min(each):
        raise ParameterError(
            f"drag: lateral drags per length that differ by less than {_UNLIKE:g} times (links without numbers drag "
            f"by viscosity_pa_s) are wanted, found {max(each) / min(each):.3g} times"
        )
