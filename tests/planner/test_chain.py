"""Chains of rolls and loops: against the flow, against differences, and within their limits."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from helpers import assert_close, flown, is_close, missed
from reference import chain as reference

from purcell_cli import Swimmer
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.geometry import se3
from purcell_cli.kernel.chains import LoopTable, RollTable
from purcell_cli.planner.arcs.chain import Chains, linked
from purcell_cli.planner.arcs.loop_family import fan
from purcell_cli.planner.arcs.roll_stroke import roll_stroke
from purcell_cli.planner.arcs.settling import FAR_OFF, SettledChains

SWIMMERS = {
    "the paper's": Swimmer().scaled(),
    "long fat limbs": Swimmer(0.1, 0.25, slenderness=0.04).scaled(),
    "small bends": Swimmer(max_bend_rad=0.5).scaled(),
}
ARCS = [np.array([[2.0, 0.3, 0.5], [1.5, -0.4, 0.1], [-0.9, 0.0, 0.4]]), np.array([[-3.0, 0.2, -0.3]])]


def chains(swimmer: Swimmer, only: int = -1, measure: str = "travel") -> Chains:
    """Return the chains of `ARCS`, with loops of one kind or the cheapest."""
    fans = tuple(fan(swimmer, measure, across) for across in (True, False))
    turning = roll_stroke(stored_gaits()["x-rotation"], swimmer)
    return linked(turning, fans, ARCS, np.array([0.7, -0.4]), np.array([only, only]))


@pytest.mark.parametrize("only", [-1, 0, 1])
@pytest.mark.parametrize("name", SWIMMERS)
def test_a_chain_says_what_its_strokes_do(name: str, only: int) -> None:
    swimmer, some = SWIMMERS[name], chains(SWIMMERS[name], only)
    for k, found in enumerate(some.displacements()):
        assert missed(found, flown(swimmer, some.blocks(k))) < 5e-3
        travel = sum(b.joint_travel_rad for b in some.blocks(k))
        assert some.costs()[0][k] == pytest.approx(travel, rel=1e-2)
    assert some.arcs(0) == 3
    assert some.arcs(1) == 1


@pytest.mark.parametrize("measure", ["travel", "energy", "switches"])
@pytest.mark.parametrize("only", [-1, 0, 1])
def test_the_kernel_puts_chains_together_as_numpy_does(only: int, measure: str) -> None:
    """Costs too, and the steps that settle them; chains that are mirrored, the foil, go elsewhere."""
    some = chains(SWIMMERS["long fat limbs"], only, measure)
    costs, other = some.costs()[0], dataclasses.replace(some, mirrored=~some.mirrored).displacements()
    for k, found in enumerate(some.displacements()):
        wanted, cost = reference.made(some, k)
        assert_close(found, wanted, 1e-12, 5.0)
        assert costs[k] == pytest.approx(cost, rel=1e-12)
        assert not is_close(other[k], wanted, 1e-2)
        one, there = some[np.array([k])], (wanted @ se3.exp(np.array([0.2, -0.1, 0.1, 0.3, 0.05, -0.04])))[None]
        few, off, paid = one.settled(there, 6)
        asked, missing, price = reference.settled(one, there, 6)
        assert_close(
            np.concatenate([few.bend, few.offset_share]), np.concatenate([asked.bend, asked.offset_share]), 1e-7
        )
        assert_close(few.roll, asked.roll, 1e-7)
        assert off[0] == pytest.approx(missing, abs=1e-7)
        assert paid[0] == pytest.approx(price, rel=1e-7)


def test_tables_that_make_no_sense_are_refused() -> None:
    some = chains(SWIMMERS["the paper's"])
    good = some.fans[0].table
    for numbers in (good.numbers[:-1], np.append(good.numbers[:-1], 11.0), np.append(good.numbers[:-3], [17, 16, 12])):
        with pytest.raises(ValueError, match="wanted"):
            LoopTable(numbers, good.series)
    with pytest.raises(ValueError, match="series"):
        LoopTable(good.numbers, good.series[:2])
    for roll, travel, largest in (([0.0], [0.0], 1.0), ([0.0, 1.0], [0.0], 1.0), ([0.0, 1.0], [0.0, 1.0], 0.0)):
        with pytest.raises(ValueError, match="wanted"):
            RollTable(np.array(roll), np.array(travel), largest)
    for wrong in ({"which": some.which + 2}, {"cycles": some.cycles[:1]}, {"mirrored": some.mirrored[:, :1]}):
        with pytest.raises((ValueError, TypeError)):
            dataclasses.replace(some, **wrong).displacements()
    with pytest.raises(ValueError, match="wanted"):
        some.residuals(np.eye(4))


@pytest.mark.parametrize("only", [0, 1])
def test_the_derivative_of_chains_is_that_of_differences(only: int) -> None:
    some = chains(SWIMMERS["the paper's"], only)
    some = dataclasses.replace(some, bend=0.9 * some.bend, offset_share=some.offset_share + 0.05 * (some.which >= 0))
    here = some.displacements()
    slope, cost_slope = some.residuals(here)[1], some.costs()[1]
    step = 1e-5
    for name, low in (("bend", 0), ("offset_share", some.bend.shape[1]), ("roll", 2 * some.bend.shape[1])):
        values = getattr(some, name)
        for j in range(values.shape[1]):
            change = step * (np.arange(values.shape[1]) == j)
            ends = [dataclasses.replace(some, **{name: values + sign * change}) for sign in (1.0, -1.0)]
            live = (some.which >= 0)[:, j] if name != "roll" else np.array([True, True])
            first, last = (end.residuals(here)[0] for end in ends)
            assert_close(((first - last) / (2.0 * step))[live], slope[live][:, :, low + j], 2e-4)
            first, last = (end.costs()[0] for end in ends)
            if name != "roll":
                assert_close(((first - last) / (2.0 * step))[live], cost_slope[live][:, low + j], 1e-3)


def test_settled_chains_make_what_is_wanted_within_their_bounds_and_cost_no_more() -> None:
    swimmer = SWIMMERS["the paper's"]
    some = chains(swimmer)[np.array([0])]
    wanted = some.displacements() @ se3.exp(np.array([0.2, -0.1, 0.1, 0.3, 0.05, -0.04]))
    assert not is_close(some.residuals(wanted)[0], np.zeros((1, 6)), 0.05)
    few, off, cost = some.settled(wanted, 8)
    assert np.all(off < 3e-3)
    better, off_too, less = some.settled(wanted, 30)
    assert np.all(off_too < 3e-3)
    assert np.all(less <= cost + 1e-9)
    assert np.any(less < cost - 0.1)
    assert missed(wanted[0], flown(swimmer, better.blocks(0))) < 5e-3
    live = few.which >= 0
    assert np.all(few.bend[live] <= swimmer.max_bend_rad)
    assert np.all(few.offset_share[live] >= 0.0)


def test_chains_of_full_loops_get_all_the_cycles_that_they_lack() -> None:
    some = chains(SWIMMERS["the paper's"])[np.array([0])]
    full = dataclasses.replace(some, bend=np.where(some.which >= 0, 0.9998, 0.0))
    wanted = dataclasses.replace(full, cycles=full.cycles + 3.0 * (full.which >= 0)).displacements()
    begun = SettledChains.of(full, wanted, np.zeros(1), 5)
    assert begun.off[0] > FAR_OFF
    assert begun.longer(np.array([0])).off[0] > FAR_OFF  # one cycle more of each does not do
    grown = begun.grown()
    assert grown.off[0] <= FAR_OFF
    assert np.all(grown.chains.cycles > begun.chains.cycles + 1.0, where=full.which >= 0)


def test_longer_chains_have_more_cycles_where_loops_are_full() -> None:
    some = chains(SWIMMERS["the paper's"])
    full = dataclasses.replace(some, bend=np.where(some.which >= 0, 0.9998, 0.0))
    there = full.displacements()
    assert np.array_equal(full.longer(there).cycles, full.cycles + (full.which >= 0))
    less = dataclasses.replace(some, bend=0.5 * some.bend)
    assert np.array_equal(less.longer(there).cycles, less.cycles)
    many = dataclasses.replace(full, cycles=100.0 * full.cycles)
    farther = many.displacements()
    farther[:, :3, 3] *= 1.05
    short = 1.0 - 1.0 / 1.05
    assert np.array_equal(many.longer(farther).cycles, np.ceil((1.0 + short) * many.cycles))
