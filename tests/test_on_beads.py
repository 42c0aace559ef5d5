"""Where a plan would end on beads, at once: what the motion itself makes of them, to two per cent of the miss."""

from __future__ import annotations

import dataclasses

import pytest

from purcell_cli import Configuration, Swimmer
from purcell_cli.errors import ParameterError
from purcell_cli.explanation import OnBeads
from purcell_cli.feedback.simulate import simulate
from purcell_cli.mechanics.configuration import Deviation
from purcell_cli.motion.on_beads import ACCURACY, end_on_beads
from purcell_cli.motion.plan import Plan
from purcell_cli.motion.trajectory import as_table
from purcell_cli.planning import plan

STOUT = Swimmer(slenderness=0.05)
GOALS = [
    Configuration.from_angles((0.02, 0.01, 0.0), (20, 0, 0)),
    Configuration.from_angles((0.0, 0.0, 0.0), (0, 0, 30), (20, 10, 0), (0, -15, 5)),
]


@pytest.mark.parametrize("goal", GOALS)
def test_it_ends_where_the_beads_end(goal: Configuration) -> None:
    start = Configuration()
    solution = plan(start, goal, swimmer=STOUT)
    exact = simulate(as_table(solution.trajectory), dataclasses.replace(STOUT, fluid="beads")).end
    found = end_on_beads(STOUT, start, solution.plan.blocks)
    missed, off = Deviation.between(exact, goal), Deviation.between(found, exact)
    size = missed.position_m / STOUT.length_m + missed.base_rad
    assert size > 0.02  # the foil: links alone would end at the goal
    assert off.position_m / STOUT.length_m + off.base_rad < ACCURACY * size
    told = OnBeads.of(solution.plan)
    assert told.off is not None
    assert told.off == Deviation.between(found, goal)


@pytest.mark.parametrize(
    ("swimmer", "words"),
    [
        (Swimmer(slenderness=0.001), "slenderness"),
        (Swimmer(drag_ratio=1.8), "drag_ratio"),
        (Swimmer(drag="cylinder"), "drag"),
        (Swimmer(slenderness=0.05, fluid="beads"), "is made for links that feel each other"),
    ],
)
def test_where_it_is_not_known_it_says_why(swimmer: Swimmer, words: str) -> None:
    told = OnBeads.of(Plan(swimmer, Configuration(), Configuration(), ()))
    assert told.off is None
    assert words in told.why_not


def test_bends_that_the_beads_have_not_are_refused() -> None:
    start = Configuration.from_angles((0.0, 0.0, 0.0), (0, 0, 0), (110, 0, 0))
    with pytest.raises(ParameterError, match=r"at most 1\.6 rad"):
        end_on_beads(STOUT, start, ())
