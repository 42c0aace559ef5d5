"""The models of the fluid, and what swimmers can be whose links feel each other's flow."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Literal, get_args

from purcell_cli.errors import ParameterError
from purcell_cli.mechanics.drag import COX, LINKS

if TYPE_CHECKING:
    from purcell_cli.mechanics.swimmer import Swimmer

BEADS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {"slenderness": (1.0 / 300.0, 0.2), "max_bend_rad": (0.0, 1.6), "drag_ratio": (2.0, 2.0)}
)
"""What parameters of links that feel each other are between: 450 beads at most, and a table of bends that ends there;
how they drag follows from their beads."""

Fluid = Literal["local", "beads"]
FLUIDS: tuple[Fluid, ...] = get_args(Fluid)
"""The models of the fluid: each link alone, or links that feel each other's flow."""


_SLACK_RAD = 1e-6
"""Room for rounding beyond the largest bend [rad]."""


def refuse_far_bends(bend_rad: float, called: str = "") -> None:
    """Refuse a bend that links that feel each other do not have: beads of different links would come near each other.

    Args:
        bend_rad: The largest bend of a limb [rad].
        called: What has it, where that is not plain.

    Raises:
        ParameterError: It is too large.
    """
    most = BEADS["max_bend_rad"][1]
    if bend_rad > most + _SLACK_RAD:
        place = f"{called}: " if called else ""
        wanted = f"limbs bent by at most {most:g} rad, for links that feel each other, are wanted"
        raise ParameterError(f"{place}{wanted}, found {bend_rad:.4g} rad")


def refuse_unfit(swimmer: Swimmer) -> None:
    """Refuse a fluid that is unknown, and what links that feel each other cannot have.

    Raises:
        ParameterError: Such a fluid, such links, or a wall beside links that do not feel flow.
    """
    if swimmer.fluid not in FLUIDS:
        raise ParameterError(f"fluid: one of {', '.join(FLUIDS)} is wanted, found {swimmer.fluid!r}")
    if swimmer.fluid != "beads":
        if swimmer.wall is not None:
            raise ParameterError(f"fluid: 'beads', which a wall goes with, is wanted, found {swimmer.fluid!r}")
        return
    for name, (low, high) in BEADS.items():
        if not low <= getattr(swimmer, name) <= high:
            wanted = f"{f'{low:g} to ' if low < high else ''}{high:g} for links that feel each other"
            raise ParameterError(f"{name}: {wanted} is wanted, found {getattr(swimmer, name):g}")
    low, high = BEADS["slenderness"]
    for k, link in enumerate(LINKS):
        if not low <= (own := swimmer.slenderness_of(k)) <= high:
            wanted = f"{low:g} to {high:g} for links that feel each other"
            raise ParameterError(f"links.{link}.slenderness: {wanted} is wanted, found {own:g}")
    for name, plain in (("drag", COX), ("body_radius_m", 0.0)):
        own = getattr(swimmer, name)
        if own != plain:
            found = own if isinstance(own, str | float) else "drags of its own"
            raise ParameterError(f"{name}: {plain}, as links that feel each other have it, is wanted, found {found}")
