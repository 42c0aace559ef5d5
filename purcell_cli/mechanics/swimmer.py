"""The swimmer and the fluid forces on its links (section III-A of the paper, as corrected)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from numbers import Real
from types import MappingProxyType
from typing import Literal, get_args

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.geometry.reproducible import log
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.joints import ACCELERATION_LIMITS, BALL, Joints

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


BEADS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {"slenderness": (1.0 / 300.0, 0.2), "max_bend_rad": (0.0, 1.6), "drag_ratio": (2.0, 2.0)}
)
"""What parameters of links that feel each other are between: 450 beads at most, and a table of bends that ends there;
how they drag follows from their beads."""

Fluid = Literal["local", "beads"]
FLUIDS: tuple[Fluid, ...] = get_args(Fluid)
"""The models of the fluid: each link alone, or links that feel each other's flow."""


@dataclasses.dataclass(frozen=True, slots=True)
class Swimmer:
    """Three slender links in a viscous fluid; the defaults are the paper's swimmer in glycerin.

    Attributes:
        base_half_length_m: Half length of the base link [m].
        limb_half_length_m: Half length of each of the two limbs [m].
        slenderness: Radius over full length of a link, between 0 and 0.2.
        viscosity_pa_s: Dynamic viscosity of the fluid [Pa s]; it scales forces, never the path.
        drag_ratio: Lateral over longitudinal drag; a swimmer needs more than 1.
        max_bend_rad: How far a gait may bend a limb's axis from the base's axis [rad].
        joint_rate_rad_s: The rate at which one joint turns, where its own is not given [rad/s].
        fluid: "local", each link alone in the fluid, or "beads", links that feel each other's flow (`beads`).
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
    fluid: Fluid = "local"
    joints: Joints = (BALL, BALL)
    joint_acceleration_rad_s2: float | None = None

    def __post_init__(self) -> None:
        if self.fluid not in FLUIDS:
            raise ParameterError(f"fluid: one of {', '.join(FLUIDS)} is wanted, found {self.fluid!r}")
        for name, (low, high) in LIMITS.items():
            value = getattr(self, name)
            if isinstance(value, bool) or not isinstance(value, Real):
                raise ParameterError(f"{name}: a number is wanted, found {value!r}")
            if not low < float(value) <= high:
                raise ParameterError(f"{name}: a number above {low:g} and at most {high:g} is wanted, found {value!r}")
            object.__setattr__(self, name, float(value))
        if self.fluid == "beads":
            for name, (low, high) in BEADS.items():
                if not low <= getattr(self, name) <= high:
                    wanted = f"{low:g} to {high:g} for links that feel each other"
                    raise ParameterError(f"{name}: {wanted} is wanted, found {getattr(self, name):g}")
        low, high = ACCELERATION_LIMITS
        found = self.joint_acceleration_rad_s2
        if found is not None and (isinstance(found, bool) or not low < found <= high):
            raise ParameterError(
                f"joint_acceleration_rad_s2: a number above {low:g} and at most {high:g} is wanted, found {found!r}"
            )
        ratio = self.limb_half_length_m / self.base_half_length_m
        if not 1e-2 <= ratio <= 1e2:
            raise ParameterError(
                f"limb_half_length_m: 0.01 to 100 times base_half_length_m is wanted, found {ratio:g} times"
            )

    @property
    def length_m(self) -> float:
        """The length L that displacements are measured in: the mean half length of the links [m]."""
        return (self.base_half_length_m + 2.0 * self.limb_half_length_m) / 3.0

    def scaled(self) -> Swimmer:
        """Return the same swimmer with L = 1, at unit rate, in a fluid of unit lateral drag.

        Its base moves along the same path in units of L; plans are made for it.
        """
        return dataclasses.replace(
            self,
            base_half_length_m=self.base_half_length_m / self.length_m,
            limb_half_length_m=self.limb_half_length_m / self.length_m,
            viscosity_pa_s=log(1.0 / self.slenderness) / (4.0 * math.pi),
            joint_rate_rad_s=1.0,
            joints=(self.joints[0].at_rate(None), self.joints[1].at_rate(None)),
            joint_acceleration_rad_s2=None,
        )

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

        The paper (section III-A) writes k_T; l/a is one over the slenderness.
        """
        return 4.0 * math.pi * self.viscosity_pa_s / log(1.0 / self.slenderness)

    def spin_drag(self, half_length_m: float) -> float:
        """Return k_R, the torque per length on a link spinning about its own axis [N s].

        4 pi mu a^2, a rigid cylinder of radius a spinning in Stokes flow; the paper leaves it open.
        """
        radius = self.slenderness * 2.0 * half_length_m
        return 4.0 * math.pi * self.viscosity_pa_s * radius * radius

    def bend_spread(self) -> float:
        """Return the spread of the links about their best-fitting line, per squared bend of one limb [m^3].

        To leading order: the integral along the limb of its squared distance from the base's line,
        less what a line through all links can take away.
        """
        b, l = self.base_half_length_m, self.limb_half_length_m
        half = b + 2.0 * l
        shift, tilt = 2.0 * l * l, 8.0 / 3.0 * l * l * l + 2.0 * b * l * l
        line = 2.0 / 3.0 * half * half * half
        return 8.0 / 3.0 * l * l * l - shift * shift / (2.0 * half) - tilt * tilt / line

    def roll_sharpness(self) -> float:
        """Return the bend of a limb at which lateral drag resists roll as much as spin drag does [rad].

        Nearer to the collinear shape than this the roll row of A(r) varies quickly: a limb bent by
        beta that rolls with the swimmer is dragged sideways through the `bend_spread` times beta^2.
        """
        b, l = self.base_half_length_m, self.limb_half_length_m
        spin = 4.0 * self.spin_drag(l) * l + 2.0 * self.spin_drag(b) * b
        return math.sqrt(spin / (self.lateral_drag() * self.bend_spread()))

    def drag(self, link: int) -> Array:
        """Return H_i, the drag matrix of link i about its own centre, in its own frame.

        Force and torque on the link are -H_i xi_i. The spin entry is 2 k_R L where the paper's
        integral gives k_R L (section III-A); the constants are those of half length L.

        Args:
            link: 0 for the base, 1 or 2 for a limb.

        Returns:
            Diagonal matrix on (v, omega) [N s/m, N s m]. Shape (6, 6).
        """
        half = self.base_half_length_m if link == 0 else self.limb_half_length_m
        k, k_spin = self.lateral_drag(), self.spin_drag(half)
        lateral, turn = 2.0 * k * half, 2.0 / 3.0 * k * half * half * half
        return np.diag([lateral / self.drag_ratio, lateral, lateral, 2.0 * k_spin * half, turn, turn])
