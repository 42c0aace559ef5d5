"""The sizes of the three links, base first: what pictures and exports draw."""

from __future__ import annotations

from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.clearance import radius_m

Sizes = tuple[float, float, float]


def halves_m(swimmer: Swimmer) -> Sizes:
    """Return the half lengths of base, limb 1 and limb 2 [m]."""
    return swimmer.base_half_length_m, swimmer.limb_half_length_m, swimmer.limb_half_length_m


def radii_m(swimmer: Swimmer) -> Sizes:
    """Return the radii of base, limb 1 and limb 2 [m]."""
    base, one, two = (radius_m(swimmer, half) for half in halves_m(swimmer))
    return base, one, two
