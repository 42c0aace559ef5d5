"""The swimmer and the fluid forces on its links (section III-A of the paper, as corrected)."""

from __future__ import annotations

import dataclasses
import functools
import math
from collections.abc import Callable, Mapping
from numbers import Real
from types import MappingProxyType
from typing import Any, TypeVar

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import log
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.drag import (
    COX,
    FINITE_RODS,
    LAWS,
    LINKS,
    LinkDrags,
    LinkSize,
    LinkSizes,
    RodDrag,
    cox,
    refuse_odd,
    sphere,
)
from purcell_cli.mechanics.fluid import Fluid, refuse_unfit
from purcell_cli.mechanics.joints import ACCELERATION_LIMITS, BALL, Joint, Joints
from purcell_cli.mechanics.wall import Wall

T = TypeVar("T")

LIMITS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "base_half_length_m": (1e-12, 1e6),
        "limb_half_length_m": (1e-12, 1e6),
        "slenderness": (1e-6, 0.2),
        "viscosity_pa_s": (1e-12, 1e12),
        "drag_ratio": (1.0, 1e3),
        "max_bend_rad": (1e-3, math.pi),
        "joint_rate_rad_s": (1e-9, 1e6),
    }
)
"""What each parameter of a swimmer is above, and at most."""

LARGEST_BODY_RADIUS_M = 1e6
"""The largest radius of a body [m], that of the longest base."""


def _kept(method: Callable[[Swimmer], T]) -> Callable[[Swimmer], T]:
    """Return a method without arguments whose values are kept for the last swimmers: a plan asks hundreds of times."""
    return functools.wraps(method)(functools.lru_cache(maxsize=64)(method))


@frozen_dataclass
class Swimmer:
    """Three slender links in a viscous fluid; the defaults are the paper's swimmer in glycerin.

    Attributes:
        base_half_length_m: Half length of the base link [m].
        limb_half_length_m: Half length of each of the two limbs [m].
        slenderness: Radius over full length of a link, between 0 and 0.2.
        viscosity_pa_s: Dynamic viscosity of the fluid [Pa s]; it scales forces, never the path.
        drag_ratio: Lateral over longitudinal drag by the law of Cox; a swimmer needs more than 1.
        max_bend_rad: How far a gait may bend a limb's axis from the base's axis [rad].
        joint_rate_rad_s: The rate at which one joint turns, where its own is not given [rad/s].
        drag: One of `drag.LAWS`, or numbers for some links; what is left out of them is by the law of Cox.
        links: The sizes of links that differ from the first three. The base's half length is kept in
            `base_half_length_m`, and what does not differ is left out.
        body_radius_m: Radius of a sphere at the base's middle that drags too; 0 for none [m].
        fluid: "local", each link alone in the fluid, or "beads", links that feel each other's flow (`beads`).
        wall: A plane wall that it swims beside, of links that feel each other's flow; None for none.
        joints: The joints of limb 1 and limb 2.
        joint_acceleration_rad_s2: How fast joints' rates change; None where rates may jump [rad/s^2].

    Raises:
        ParameterError: A parameter that no swimmer can have.
    """

    base_half_length_m: float = 0.1
    limb_half_length_m: float = 0.1
    slenderness: float = 0.01
    viscosity_pa_s: float = 0.95
    drag_ratio: float = 2.0
    max_bend_rad: float = 1.0
    joint_rate_rad_s: float = 1.0
    drag: str | LinkDrags = COX
    links: LinkSizes = LinkSizes()
    body_radius_m: float = 0.0
    fluid: Fluid = "local"
    wall: Wall | None = None
    joints: Joints = (BALL, BALL)
    joint_acceleration_rad_s2: float | None = None

    def __post_init__(self) -> None:
        joints: object = self.joints
        if not (isinstance(joints, tuple) and [type(joint) for joint in joints] == [Joint, Joint]):
            raise ParameterError(f"joints: two of type Joint, limb 1's and limb 2's, are wanted, found {joints!r}")
        self._own_sizes()
        for name in LIMITS:
            object.__setattr__(self, name, within_limits(name, getattr(self, name), name))
        for k, half in enumerate(self.halves_m):
            ratio = half / self.base_half_length_m
            if not 1e-2 <= ratio <= 1e2:
                own = getattr(self.links, LINKS[k]).half_length_m is not None
                name = f"links.{LINKS[k]}.half_length_m" if own else "limb_half_length_m"
                raise ParameterError(f"{name}: 0.01 to 100 times base_half_length_m is wanted, found {ratio:g} times")
        self._known_drag()
        self._slim_body()
        refuse_unfit(self)
        low, high = ACCELERATION_LIMITS
        found = self.joint_acceleration_rad_s2
        if found is not None and (isinstance(found, bool) or not low < found <= high):
            raise ParameterError(
                f"joint_acceleration_rad_s2: a number above {low:g} and at most {high:g} is wanted, found {found!r}"
            )

    def __repr__(self) -> str:
        fields = dataclasses.fields(self)
        told = [f.name for f in fields if f.name in LIMITS or getattr(self, f.name) != f.default]
        return f"Swimmer({', '.join(f'{name}={getattr(self, name)!r}' for name in told)})"

    def _own_sizes(self) -> None:
        """Check the links' own sizes, and leave out those that do not differ."""
        if self.links == LinkSizes():
            return
        if (half := self.links.base.half_length_m) is not None:
            object.__setattr__(self, "base_half_length_m", half)
        kept = []
        for link in LINKS:
            own: dict[str, float] = {}
            for name, like in (("half_length_m", "limb_half_length_m"), ("slenderness", "slenderness")):
                value = getattr(getattr(self.links, link), name)
                if value is None or (link, name) == ("base", "half_length_m"):
                    continue
                if within_limits(f"links.{link}.{name}", value, like) != getattr(self, like):
                    own[name] = value
            kept.append(LinkSize(**own))
        object.__setattr__(self, "links", LinkSizes(*kept))

    def _known_drag(self) -> None:
        """Refuse a law that is unknown, and numbers that no link can have beside the others."""
        if self.drag == LinkDrags():
            object.__setattr__(self, "drag", COX)
        if not isinstance(self.drag, LinkDrags):
            if self.drag not in LAWS:
                raise ParameterError(f"drag: one of {', '.join(LAWS)}, or numbers, is wanted, found {self.drag!r}")
            return
        refuse_odd([self.rod(k) for k in range(3)], self.halves_m)

    def _slim_body(self) -> None:
        """Refuse a sphere that hides a joint."""
        radius = self.body_radius_m
        if isinstance(radius, bool) or not isinstance(radius, Real) or not 0.0 <= radius <= LARGEST_BODY_RADIUS_M:
            raise ParameterError(
                f"body_radius_m: a number at least 0 and at most {LARGEST_BODY_RADIUS_M:g} is wanted, found {radius!r}"
            )
        object.__setattr__(self, "body_radius_m", float(radius))
        free = self.base_half_length_m - max(self.radii_m[1:])
        if radius and not radius < free:
            raise ParameterError(
                f"body_radius_m: a sphere below {free:g} m, which leaves room for a limb at each joint, is wanted, "
                f"found {radius:g}"
            )

    @property
    def halves_m(self) -> tuple[float, float, float]:
        """Half lengths of base, limb 1 and limb 2 [m]."""
        one, two = self.links.limb1.half_length_m, self.links.limb2.half_length_m
        both = self.limb_half_length_m
        return self.base_half_length_m, both if one is None else one, both if two is None else two

    @property
    def radii_m(self) -> tuple[float, float, float]:
        """Radii of base, limb 1 and limb 2: slenderness times full length [m]."""
        base, one, two = (self.slenderness_of(k) * 2.0 * half for k, half in enumerate(self.halves_m))
        return base, one, two

    def slenderness_of(self, link: int) -> float:
        """Return a link's radius over its full length."""
        own: float | None = getattr(self.links, LINKS[link]).slenderness
        return self.slenderness if own is None else own

    @property
    def equal_limbs(self) -> bool:
        """Whether the two limbs are alike, so that the swimmer looks the same end for end."""
        return self.halves_m[1] == self.halves_m[2] and self.rod(1) == self.rod(2)

    @property
    def length_m(self) -> float:
        """The length L that displacements are measured in: the mean half length of the links [m]."""
        base, one, two = self.halves_m
        return (base + (one + two)) / 3.0

    def scaled(self) -> Swimmer:
        """Return the same swimmer with L = 1, at unit rate, in a fluid of unit lateral drag.

        Its base moves along the same path in units of L; plans are made for it.
        """
        return _scaled(self)

    @property
    def ball_joints(self) -> bool:
        """Whether both limbs hang on ball joints, as the paper's do."""
        return self.joints[0].ball and self.joints[1].ball

    @property
    def controls(self) -> tuple[int, ...]:
        """The primitives that its joints can make, numbers in the order of `PRIMITIVE_NAMES`."""
        return (*self.joints[0].controls(0), *self.joints[1].controls(1))

    def rate_of(self, limb: int) -> float:
        """Return the rate at which a limb, 0 or 1, turns on its joint [rad/s]."""
        own = self.joints[limb].rate_rad_s
        return self.joint_rate_rad_s if own is None else own

    def lateral_drag(self) -> float:
        """Return k, the lateral drag of a link per length [N s/m^2]: 4 pi mu / ln(l/a) (Cox).

        The paper (section III-A) writes k_T; l/a is one over the slenderness. Drags are counted in it.
        """
        return 4.0 * math.pi * self.viscosity_pa_s / log(1.0 / self.slenderness)

    def rod(self, link: int, lateral: float | None = None) -> RodDrag:
        """Return the drag of a link about its middle, without the sphere.

        Args:
            link: 0 for the base, 1 or 2 for a limb.
            lateral: `lateral_drag`, where it is known better than by its formula.
        """
        half, radius, slenderness = self.halves_m[link], self.radii_m[link], self.slenderness_of(link)
        if isinstance(self.drag, str) and self.drag != COX:
            return FINITE_RODS[self.drag](half, radius, self.viscosity_pa_s)
        k = self.lateral_drag() if lateral is None else lateral
        own = k * (log(1.0 / self.slenderness) / log(1.0 / slenderness))
        rod = cox(half, radius, self.viscosity_pa_s, own, self.drag_ratio)
        numbers = None if isinstance(self.drag, str) else getattr(self.drag, LINKS[link])
        return rod if numbers is None else numbers.over(rod)

    @_kept
    def weights(self) -> tuple[float, float]:
        """Return the least and the greatest lateral drag per length of links that turn or drift, in units of k.

        They are 1 for rods of one slenderness that drag as Cox has it.
        """
        k, found = self.lateral_drag(), []
        for link, half in enumerate(self.halves_m):
            rod = self.rod(link)
            found += [rod.across / (2.0 * k * half), rod.turn / (2.0 / 3.0 * k * half * half * half)]
        return min(found), max(found)

    @_kept
    def bend_spread(self) -> float:
        """Return the spread of the links about their best-fitting line, per squared bend of one limb [m^3].

        To leading order: the integral along the limb of its squared distance from the base's line, less what a line
        through all links can take away. Lengths count by their lateral drag at most; the larger of both limbs.
        """
        b, *limbs = self.halves_m
        half = b + (limbs[0] + limbs[1])
        body = sphere(self.body_radius_m, self.viscosity_pa_s)[0] / self.lateral_drag()
        total = 2.0 * half + body
        found = []
        for l, other in (limbs, limbs[::-1]):
            off = l - other
            shift, tilt = 2.0 * l * l, 8.0 / 3.0 * l * l * l + 2.0 * b * l * l
            tilt -= 2.0 * half / total * off * shift
            line = 2.0 / 3.0 * half * half * half + 2.0 * half * body / total * off * off
            found.append(8.0 / 3.0 * l * l * l - shift * shift / total - tilt * tilt / line)
        return self.weights()[1] * max(found)

    @_kept
    def roll_sharpness(self) -> float:
        """Return the bend of a limb at which lateral drag resists roll as much as spin drag does [rad].

        Nearer to the collinear shape than this the roll row of A(r) varies quickly: a limb bent by
        beta that rolls with the swimmer is dragged sideways through the `bend_spread` times beta^2.
        """
        return _roll_sharpness(self)

    def drag_matrix(self, link: int) -> Array:
        """Return H_i, the drag matrix of link i about its own centre, in its own frame, the base's with its sphere.

        Force and torque on the link are -H_i xi_i.

        Args:
            link: 0 for the base, 1 or 2 for a limb.

        Returns:
            Diagonal matrix on (v, omega) [N s/m, N s m]. Shape (6, 6).
        """
        rod = self.rod(link)
        force, torque = sphere(0.0 if link else self.body_radius_m, self.viscosity_pa_s)
        forces, torques = (rod.along, rod.across, rod.across), (rod.spin, rod.turn, rod.turn)
        return np.diag([*(v + force for v in forces), *(v + torque for v in torques)])


def within_limits(name: str, value: float, like: str) -> float:
    """Return a parameter as a float.

    Args:
        name: What messages call it.
        value: Its value.
        like: The one of `LIMITS` that holds for it.

    Raises:
        ParameterError: It is no number, or outside its limits.
    """
    low, high = LIMITS[like]
    if isinstance(value, bool) or not isinstance(value, Real):
        raise ParameterError(f"{name}: a number is wanted, found {value!r}")
    if not low < float(value) <= high:
        raise ParameterError(f"{name}: a number above {low:g} and at most {high:g} is wanted, found {value!r}")
    return float(value)


@functools.lru_cache(maxsize=64)
def _roll_sharpness(swimmer: Swimmer) -> float:
    """Return `Swimmer.roll_sharpness`, worked out once for a swimmer."""
    spin = swimmer.rod(1).spin + swimmer.rod(2).spin + swimmer.rod(0).spin
    spin += sphere(swimmer.body_radius_m, swimmer.viscosity_pa_s)[1]
    return math.sqrt(spin / (swimmer.lateral_drag() * swimmer.bend_spread()))


@functools.lru_cache(maxsize=64)
def _scaled(swimmer: Swimmer) -> Swimmer:
    """Return `Swimmer.scaled`, made once for a swimmer."""
    size = swimmer.length_m
    out: dict[str, Any] = {
        "base_half_length_m": swimmer.base_half_length_m / size,
        "limb_half_length_m": swimmer.limb_half_length_m / size,
        "wall": None if swimmer.wall is None else swimmer.wall.scaled(size),
        "viscosity_pa_s": log(1.0 / swimmer.slenderness) / (4.0 * math.pi),
        "joint_rate_rad_s": 1.0,
        "joints": (swimmer.joints[0].at_rate(None), swimmer.joints[1].at_rate(None)),
        "joint_acceleration_rad_s2": None,
    }
    sizes = (getattr(swimmer.links, link) for link in LINKS)
    links = LinkSizes(
        *(LinkSize(None if s.half_length_m is None else s.half_length_m / size, s.slenderness) for s in sizes)
    )
    k = swimmer.lateral_drag()
    drag = swimmer.drag if isinstance(swimmer.drag, str) else swimmer.drag.scaled(k * size, k * size * size * size)
    return dataclasses.replace(swimmer, **out, links=links, drag=drag, body_radius_m=swimmer.body_radius_m / size)
