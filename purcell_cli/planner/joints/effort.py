"""Efforts of searches for swimmers on other joints than balls: the stages, and how widely chains are looked for."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.planner.effort import AGAIN, LAST, LEG, Stage
from purcell_cli.planner.refine.minimum_travel import Pace


@frozen_dataclass
class JointBreadth:
    """How widely candidates are looked for.

    Attributes:
        ways: Pairs of ways in and out that chains are looked for.
        chains: Random chains that are tried for each; chains like the best ones follow.
        kept: Chains of each that become candidates.
        short: Short plans that are tried.
        arcs: Starts of needle steering, where both limbs hang on hinges of one axis: their plane's arcs.
        pace: How long those that arrive are shortened.
        seed: Seed of the chains and short plans.
    """

    ways: int = 2
    chains: int = 1000
    kept: int = 6
    short: int = 24
    arcs: int = 0
    pace: Pace = Pace(rounds=2, steps=10)
    seed: int = 0


@frozen_dataclass
class JointStage:
    """A stage of the search, and how widely it looks for candidates."""

    stage: Stage
    breadth: JointBreadth


_QUICK = JointStage(Stage(), JointBreadth(chains=500, short=12, pace=Pace(1, 6)))
"""A quick search: the best chain, and nothing is optimised together."""
_STANDARD = JointStage(
    Stage(
        candidates=2,
        pace=Pace(rounds=3, steps=20, worth=1e-3, own=True),
        longest_rad=300.0,
        most_apart=24,
    ),
    JointBreadth(),
)
"""A standard search: the two best chains, optimised; a fifth of the joint travel is saved by that, and half a percent
more by four."""
_WIDE = JointStage(Stage(last_resort=True), JointBreadth(ways=8, chains=3000, kept=12, short=60, seed=1))
"""The last resort: other chains and more of them, so that something arrives."""
_WIDEST = tuple(
    JointStage(Stage(last_resort=True), JointBreadth(ways=12, chains=8000, kept=24, short=60, seed=seed))
    for seed in (3, 7)
)
"""The same twice more, and wider: where ranges leave both limbs bent, chains that arrive are rare."""
_THOROUGH = JointStage(
    Stage(
        candidates=16,
        pace=Pace(rounds=3, steps=40, price=300.0, own=True),
        rungs=((3, LAST),),
        most_apart=60,
        interrupt_keeps_best=True,
    ),
    JointBreadth(ways=6, chains=4000, kept=8, short=120, pace=Pace(3, 30), seed=2),
)
"""The second stage of a thorough search."""

_LEG = JointStage(Stage(), JointBreadth(chains=0, short=0, arcs=24))
"""A leg along an arc: by that arc, where the joints can swim it."""

JOINT_EFFORTS: Mapping[str, tuple[JointStage, ...]] = {
    "quick": (_QUICK, _WIDE, *_WIDEST),
    "standard": (_STANDARD, _WIDE, *_WIDEST),
    "thorough": (
        dataclasses.replace(_STANDARD, stage=dataclasses.replace(_STANDARD.stage, interrupt_keeps_best=True)),
        _THOROUGH,
        _WIDE,
        *_WIDEST,
    ),
    AGAIN: (_STANDARD, _WIDE, *_WIDEST),
    LEG: (_LEG, dataclasses.replace(_QUICK, stage=Stage(last_resort=True))),
}
"""The stages of each effort, in order."""
