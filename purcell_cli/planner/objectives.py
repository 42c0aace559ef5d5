"""Objectives of a plan: joint travel, energy, switches of control, or how far uncertain drag moves the end."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from purcell_cli.errors import UnknownNameError
from purcell_cli.geometry.reproducible import power_of
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block, energies
from purcell_cli.motion.options import Objective
from purcell_cli.motion.sensitivity import drag_sensitivity

_TRAVEL_POWER = 1.5
"""Sensitivity is weighed against this power of joint travel: a third less of it is worth 1.3 times the travel."""

MEASURES = tuple(str(objective) for objective in Objective)


def known_measure(name: str) -> str:
    """Return the name of a measure.

    Raises:
        UnknownNameError: It is none.
    """
    if name not in MEASURES:
        raise UnknownNameError(f"minimize: one of {', '.join(MEASURES)} is wanted, found {name!r}")
    return name


def costs(measure: str, swimmer: Swimmer, blocks: Sequence[Block], start: Array) -> Array:
    """Return what each block spends: joint travel [rad], time [s], energy [J], or how many primitives. Shape (n,).

    Args:
        measure: One of `MEASURES` but sensitivity, which blocks have together alone.
        swimmer: The swimmer.
        blocks: The motion.
        start: Shape before it. Shape (2, 3, 3).
    """
    if measure == "energy":
        return energies(swimmer, blocks, start)
    if measure == "switches":
        return np.array([float(b.cycles * len(b.sequence)) for b in blocks])
    if measure == "time":
        return np.array([b.duration / swimmer.joint_rate_rad_s for b in blocks])
    return np.array([b.joint_travel_rad for b in blocks])


def generated_for(measure: str) -> str:
    """Return the measure that strokes are made for: joint travel where only whole motions have what is measured."""
    return str(Objective.TRAVEL) if measure == Objective.SENSITIVITY else measure


def cost(measure: str, swimmer: Swimmer, blocks: Sequence[Block], start: Array) -> float:
    """Return what blocks spend together from a shape (2, 3, 3), see `costs`.

    The end's sensitivity to drag is weighed with joint travel.
    """
    if measure == Objective.SENSITIVITY:
        travel = sum(b.joint_travel_rad for b in blocks)
        return drag_sensitivity(swimmer, blocks, start) * float(power_of(travel, _TRAVEL_POWER)) if travel else 0.0
    return float(np.sum(costs(measure, swimmer, blocks, start)))
