"""Where a motion would end if links felt each other's flow, at once: by a coarse table made for it alone.

The resistance of links that feel each other is a smooth function of three numbers. Over the bends of one motion few
samples give it to some 1e-4, and where the motion ends to a per cent or two of what it misses; a plan needs 1e-10.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.mechanics.base_velocity import with_tables
from purcell_cli.mechanics.bead_table import REACH_RAD, Grid, made_tables
from purcell_cli.mechanics.collocation import flow_with
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.fluid import refuse_far_bends
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block, BlockPieces
from purcell_cli.motion.limb_circles import BEND_SLACK_RAD, LimbCircles, bends

ACCURACY = 0.02
"""By what part of what a motion misses the miss may be wrong: twice the most that was found of the stored scenarios."""
_LEAST_REACH_RAD = 0.3
"""The table reaches this far at the least, so that small bends are not resolved in vain [rad]."""
_MANY_BENDS, _MANY_ANGLES = 5, 5
"""Samples of each bend and of the angle: 75 for limbs alike, half a second's work at a slenderness of 0.01."""


def end_on_beads(swimmer: Swimmer, start: Configuration, blocks: Sequence[Block]) -> Configuration:
    """Return where a motion would end if the swimmer's links felt each other's flow.

    Args:
        swimmer: The swimmer, its links alone in the fluid.
        start: Where the motion begins.
        blocks: The motion.

    Raises:
        ParameterError: A swimmer, or bends, that the model of links that feel each other does not have.
    """
    beads = dataclasses.replace(swimmer, fluid="beads", max_bend_rad=min(swimmer.max_bend_rad, REACH_RAD))
    pieces = BlockPieces.of(blocks, start.shape)
    once, begun = pieces.once, float(np.max(bends(start.shape[..., 0])))
    bend = float(np.max(LimbCircles.of(once).largest_bends()[0], initial=begun))
    refuse_far_bends(bend)
    if not len(once):
        return start
    reach_rad = min(max(bend + BEND_SLACK_RAD, _LEAST_REACH_RAD), REACH_RAD)
    tables = made_tables(beads, grids=[Grid(reach_rad, _MANY_BENDS, _MANY_ANGLES)])
    flow = flow_with(with_tables(beads, tables), SEARCHING)
    moves = flow.runs(once.shapes, once.rates, once.durations, pieces.counts, pieces.cycles)
    moved = se3.prefix_products(moves)[-1]
    moved[:3, 3] *= swimmer.length_m
    return Configuration(se3.normalised(matmul(start.pose, moved)), pieces.shapes[-1])
