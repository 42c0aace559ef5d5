"""How much a swimmer has to do to swim its own length L straight on, and for which swimmers plans are promised."""

from __future__ import annotations

from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.planner.arcs.loop_family import fan

PROMISED = 50_000.0
"""The most primitives a length L of swimmers for which every plan within 8 L is promised: it then takes some 2 million
and 2 GB. Of 100 random swimmers of the adversary 91 need fewer."""


def primitives_per_length(swimmer: Swimmer) -> float:
    """Return about how many primitives the best straight loop within the bend limit takes to swim a length L."""
    loops = fan(swimmer.scaled(), "travel", False)
    return 1.0 / (loops.straight * 2.0 * float(loops.bend[0]))


def promised(swimmer: Swimmer) -> bool:
    """Return whether plans are promised for a swimmer: that its strokes are not too many."""
    return primitives_per_length(swimmer) <= PROMISED


def advice(swimmer: Swimmer) -> str:
    """Return what would take a swimmer fewer primitives, for a message; nothing where it needs few."""
    if promised(swimmer):
        return ""
    return (
        f"; this swimmer takes some {primitives_per_length(swimmer):,.0f} primitives to swim its length L, and plans "
        f"are promised up to {PROMISED:,.0f}: a larger max_bend_rad, limbs about as long as the base or a larger "
        "drag_ratio takes fewer"
    )
