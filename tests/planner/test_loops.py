"""The table of loops: its series against the exact flow, their convergence, their slopes, bends and costs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import assert_close, flown, is_close, largest_bends, missed, slope

from purcell_cli import Swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.primitives import joined
from purcell_cli.motion.blocks import Block, energies
from purcell_cli.planner.arcs import loops as table
from purcell_cli.planner.arcs.loops import Loops, loops, stroke

SERIES = 1e-4
"""What a stroke's displacement by the series may be off by [L, rad]."""

BODY = Swimmer().scaled()
SWIMMERS = {
    "the paper's": BODY,
    "long fat limbs": Swimmer(0.1, 0.25, slenderness=0.04).scaled(),
    "small bends": Swimmer(max_bend_rad=0.5).scaled(),
}


def places(of: Loops, count: int, seed: int = 1) -> tuple[Array, Array]:
    """Return random places within a table. Shapes (count,)."""
    rng = np.random.default_rng(seed)
    return rng.uniform(of.least_rad, of.most_rad, count), rng.uniform(
        of.least_offset_share, of.most_offset_share, count
    )


def played(of: Loops, bend: float, offset_share: float, cycles: int) -> list[Block]:
    """Return the stroke of a number of cycles at a place."""
    half_side, offset = (float(x[0]) for x in of.sides(np.array([bend]), np.array([offset_share])))
    there, loop, back = stroke(half_side, offset, of.across)
    return [Block(2, "", s, n) for s, n in ((there, 1), (loop, cycles), (back, 1)) if n]


def worst(swimmer: Swimmer, of: Loops, count: int = 8) -> float:
    """Return the largest error of a table at random places, of no cycle and of one [L, rad]."""
    bend, offset_share = places(of, count)
    found = of.at(bend, offset_share)
    off = []
    for k in range(count):
        for cycles in (0, 1):
            said = se3.exp(cycles * found.cycle[0, k]) @ se3.exp(found.ways[0, k])
            off.append(missed(said, flown(swimmer, played(of, bend[k], offset_share[k], cycles))))
    return max(off)


@pytest.mark.parametrize("across", [False, True])
@pytest.mark.parametrize("name", SWIMMERS)
def test_the_table_says_what_the_flow_does(name: str, across: bool) -> None:
    """After no cycle, one and three; the foil, a cycle more than is said, is off by far."""
    swimmer, of = SWIMMERS[name], loops(SWIMMERS[name], "travel", across)
    bend, offset_share = places(of, 12)
    found = of.at(bend, offset_share)
    for k in range(len(bend)):
        for cycles in (0, 1, 3):
            said = se3.exp(cycles * found.cycle[0, k]) @ se3.exp(found.ways[0, k])
            assert missed(said, flown(swimmer, played(of, bend[k], offset_share[k], cycles))) < SERIES
            assert missed(said, flown(swimmer, played(of, bend[k], offset_share[k], cycles + 1))) > 10 * SERIES


@pytest.mark.parametrize("across", [False, True])
def test_the_series_converge_geometrically(monkeypatch: pytest.MonkeyPatch, across: bool) -> None:
    """Chebyshev series of an analytic function: each pair of further terms takes a factor off the error."""
    errors = []
    counts = np.array([3, 5, 7])
    for count in counts:
        monkeypatch.setattr(table, "_TERMS", {False: (count, count), True: (count, 2 * count)})
        errors.append(worst(BODY, Loops(BODY, "travel", across)))
    assert np.all(np.diff(errors) < 0.0)
    rate = np.polyfit(counts, np.log(errors), 1)[0]
    assert rate < math.log(0.6)


@pytest.mark.parametrize("across", [False, True])
@pytest.mark.parametrize("measure", ["travel", "energy"])
def test_slopes_are_those_of_differences(measure: str, across: bool) -> None:
    """Whose error falls with the square of their step; the two slopes exchanged, the foil, are others."""
    of = loops(BODY, measure, across)
    bend, offset_share = places(of, 10)
    here, steps = of.at(bend, offset_share), np.array([1e-3, 2e-3, 4e-3])
    for part in ("cycle", "ways"):
        for k, along in enumerate(np.eye(2), 1):
            errors = []
            for step in steps:
                ends = np.stack([bend, offset_share]), step * along[:, None]
                up, down = (getattr(of.at(*(ends[0] + sign * ends[1])), part)[0] for sign in (1.0, -1.0))
                errors.append(float(np.max(np.abs((up - down) / (2.0 * step) - getattr(here, part)[k]))))
            assert abs(slope(steps, errors) - 2.0) < 0.15
            assert not is_close((up - down) / (2.0 * steps[-1]), getattr(here, part)[3 - k], 10.0 * errors[-1])


@pytest.mark.parametrize("across", [False, True])
def test_a_stroke_bends_the_limbs_as_far_as_its_place_says(across: bool) -> None:
    """At most, at any instant; across the plane the sum of half side and offset, the foil, would be more."""
    of = loops(BODY, "travel", across)
    bend, offset_share = places(of, 12)
    half_sides, offsets = of.sides(bend, offset_share)
    for k, (half_side, offset) in enumerate(zip(half_sides, offsets, strict=True)):
        whole = joined(list(stroke(float(half_side), float(offset), across)))
        assert_close(largest_bends(whole), np.full(2, bend[k]), 1e-9)
        assert_close(whole.shapes(COLLINEAR)[-1], COLLINEAR, 1e-14)
        assert (half_side + offset > bend[k] + 1e-3) == across
    for found, wanted in zip(of.place(half_sides, offsets), (bend, offset_share), strict=True):
        assert_close(found, wanted, 1e-12)


@pytest.mark.parametrize("across", [False, True])
def test_costs_are_those_of_the_strokes(across: bool) -> None:
    """Joint travel and switches exactly, energy to the series' error: in the plane what the ways cost has a kink."""
    for measure in ("travel", "switches", "energy"):
        of = loops(BODY, measure, across)
        bend, offset_share = places(of, 6)
        cycle, ways = of.costs(bend, offset_share)
        for k in range(len(bend)):
            there, loop, back = played(of, bend[k], offset_share[k], 1)
            if measure == "travel":
                wanted = [b.joint_travel_rad for b in (loop, there, back)]
            elif measure == "switches":
                wanted = [float(len(b.sequence)) for b in (loop, there, back)]
            else:
                paid = energies(BODY, [there, loop, back], COLLINEAR)
                wanted = [paid[1], paid[0], paid[2]]
            off = (2e-3, 0.05) if measure == "energy" else (1e-12, 1e-12)
            assert cycle[k] == pytest.approx(wanted[0], rel=off[0])
            assert ways[k] == pytest.approx(wanted[1] + wanted[2], abs=(off[0] if across else off[1]) * wanted[0])


def test_places_outside_the_table_are_brought_to_its_edge() -> None:
    of = loops(BODY, "travel", True)
    bend, offset_share = of.clipped(np.array([-1.0, 0.7, 9.0]), np.array([0.5, -1.0, 9.0]))
    assert_close(bend, [of.least_rad, 0.7, of.most_rad], 0.0)
    assert_close(offset_share, [0.5, of.least_offset_share, of.most_offset_share], 0.0)


def test_a_table_is_made_once_for_a_swimmer() -> None:
    assert loops(BODY, "travel", True) is loops(Swimmer().scaled(), "travel", True)
    assert loops(BODY, "travel", True) is not loops(Swimmer(drag_ratio=1.9).scaled(), "travel", True)
