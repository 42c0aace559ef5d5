"""Loops of bent limbs: what is drawn does what it says, ways that all but meet are found, and plans become shorter."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import assert_close, missed

from purcell_cli import Configuration, PlanOptions, Swimmer, plan
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.geometry import se3
from purcell_cli.kernel.pairs import MeetingPrices, meetings
from purcell_cli.mechanics.configuration import displacement_between
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import EXACT, flow
from purcell_cli.planner.effort import Breadth
from purcell_cli.planner.limbs import bent_loops as module
from purcell_cli.planner.limbs.bent_loops import BENT_LOOPS, bent_loops, met
from purcell_cli.planner.limbs.bent_loops import PRICES as MISSING
from purcell_cli.planner.limbs.drawn_ways import DrawnWays
from purcell_cli.planner.limbs.pairs import OuterPhases
from purcell_cli.planner.problem import Problem
from purcell_cli.planner.refine.exact_arrival import BY_WHOLE_STEPS, Patience
from purcell_cli.planner.refine.shooting import Equations

BODY = Swimmer().scaled()


def rotation(*vector: float) -> np.ndarray:
    """Return the rotation by a rotation vector [rad]."""
    return se3.exp(np.array([0.0, 0.0, 0.0, *vector]))[:3, :3]


START = Configuration(np.eye(4), np.stack([rotation(0.34, 0.93, 0.67), rotation(1.91, 1.37, -1.2)]))
GOAL = Configuration(
    se3.pose(rotation(0.09, 0.15, 0.04), [-0.017, 0.0082, 0.0161]),
    np.stack([rotation(0.72, -1.62, -1.6), rotation(0.65, -1.15, -1.56)]),
)
PRICES = MeetingPrices(swing=2.0, far=3.0, aside=5.0, along=1.5)


def problem(start: Configuration = START, goal: Configuration = GOAL) -> Problem:
    return Problem(BODY, start.shape, goal.shape, displacement_between(start, goal, Swimmer().length_m), stored_gaits())


def spent_on(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return what is missing of straight ways by the formula, without their length, of all pairs."""
    way = second[None, :, :3] - first[:, None, :3]
    on = np.sum(way * first[:, None, 3:], axis=-1)
    length = np.linalg.norm(way, axis=-1)
    toward = np.where(on < 0.0, -1.0, 1.0)[..., None] * way / length[..., None]
    swing = np.linalg.norm(first[:, None, 3:] - second[None, :, 3:], axis=-1)
    near = PRICES.swing * swing + PRICES.aside * np.sqrt(length**2 - on**2)
    far = np.linalg.norm(first[:, None, 3:] - toward, axis=-1) + np.linalg.norm(second[None, :, 3:] - toward, axis=-1)
    return np.minimum(near, PRICES.far * far)


def test_ways_that_meet_are_those_of_the_formula() -> None:
    """What is missing is bounded; with a lower bound (the foil) other pairs are found."""
    rng = np.random.default_rng(1)
    first, second = rng.normal(size=(2, 40, 6))
    for poses in (first, second):
        poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    before, after = rng.uniform(1.0, 6.0, 40), np.sort(rng.uniform(1.0, 6.0, 40))
    lacking = spent_on(first, second)
    length = np.linalg.norm(second[None, :, :3] - first[:, None, :3], axis=-1)
    own = before[:, None] + after
    found = {}
    for missing in (np.inf, 4.0):
        cost = np.where(lacking <= missing, own + lacking + PRICES.along * length, np.inf)
        found[missing], index = meetings(first, second, before, after, PRICES, 1e9, 1e6, missing)
        some = np.isfinite(cost.min(axis=1))
        assert_close(found[missing][some], cost.min(axis=1)[some], 1e-12)
        assert np.all(index == np.where(some, cost.argmin(axis=1), -1))
    assert np.sum(found[4.0] > found[np.inf] + 0.1) > 5
    least = found[np.inf].min()
    few, index = meetings(first, second, before, after, PRICES, 1.5 * least, 1.5, np.inf)
    assert few.min() == least
    assert np.all((index >= 0) == np.isfinite(few))
    assert 0 < np.sum(index >= 0) < 40


def test_what_is_drawn_moves_the_base_by_what_it_says() -> None:
    """On the exact flow; without its loops, the foil, it does something else."""
    query = problem()
    ways = query.ways(4).first
    begun = DrawnWays.drawn(ways, query.shape_loops[0], 15, np.random.default_rng(0))
    some, drawn = begun.varied(np.arange(len(begun.way)), 15, np.random.default_rng(1)).ascending()
    assert len(drawn) == len(ways) + 30
    assert np.all(np.diff(drawn.joint_travel_rad) > -1e-9)
    assert np.array_equal(drawn.loop, some.loop)
    for k in np.flatnonzero(np.any(drawn.loop, axis=1))[::4].tolist():
        sequence = drawn.sequence(k)
        assert sequence.joint_travel_rad == pytest.approx(drawn.joint_travel_rad[k], abs=1e-12)
        assert_close(sequence.shapes(query.start)[-1], COLLINEAR, 1e-12)
        does = flow(BODY, sequence, query.start)
        assert missed(drawn.displacement[k], does) < 0.02
        assert (
            missed(drawn.displacement[k], flow(BODY, sequence[len(sequence) - 6 :], sequence.shapes(query.start)[-7]))
            > 0.05
        )


def test_varied_ways_differ_from_a_parent_in_one_place_and_those_of_more_generations_lack_less() -> None:
    """Without generations, the foil, the best pair spends and lacks more."""
    query, rng = problem(), np.random.default_rng(2)
    begun = DrawnWays.drawn(query.ways(4).first, query.shape_loops[0], 60, rng)
    loops = np.sum(begun.loop > 0, axis=1)
    assert np.bincount(loops).tolist() == [len(query.ways(4).first), 20, 20, 20]
    few = np.arange(len(begun.way))[-9:]
    varied = begun.varied(few, 50, rng)
    assert len(varied.way) == 59
    parts, parents = (np.column_stack([some.loop, some.way]) for some in (varied, begun))
    assert np.array_equal(parts[:9], parents[few])
    differ = np.sum(parts[9:, None] != parents[few], axis=-1).min(axis=1)
    assert differ.max() == 1
    best = []
    for generations in (0, 6):
        drawn, pairs = met(query, Breadth(generations=generations))
        best.append(drawn.joint_travel_rad(*pairs[0]) + missing(query, drawn, *pairs[0]))
    assert best[1] < 0.97 * best[0]


def missing(query: Problem, drawn: OuterPhases, i: int, j: int) -> float:
    """Return what the planner's prices say is missing between two ways, along the way too."""
    first, second = drawn.first.displacement[i], query.wanted @ drawn.last.displacement[j]
    way = second[:3, 3] - first[:3, 3]
    heading, other, length = first[:3, 0], second[:3, 0], float(np.linalg.norm(way))
    on = way @ heading
    toward = np.copysign(1.0, on) * way / length
    swing = MISSING.swing * np.linalg.norm(heading - other) + MISSING.aside * np.sqrt(length**2 - on**2)
    far = MISSING.far * (np.linalg.norm(heading - toward) + np.linalg.norm(other - toward))
    return float(min(swing, far) + MISSING.along * length)


def pairs_begun(most: int) -> list[Equations]:
    """Return motions by the first pairs, every control offered, before they are brought to the goal."""
    query = problem()
    drawn, pairs = met(query, Breadth())
    return [module._offered(query, drawn.around(i, (), j)) for i, j in pairs[:most]]


def test_first_steps_are_the_least_to_the_goal_on_the_exact_flow() -> None:
    """By numpy, of differences; with the limbs left where that leaves them, the foil, they are smaller."""
    for begun in pairs_begun(3):
        exact, h = begun.at_accuracy(EXACT), 1e-6
        ends = [[exact.residual(exact.angles + sign * e) for e in h * np.eye(len(exact.angles))] for sign in (1, -1)]
        slope, off = (np.array(ends[0]) - np.array(ends[1])).T / (2.0 * h), exact.residual(exact.angles)
        weight = 1.0 / np.sqrt(1.0 + np.linalg.norm(slope[:6], axis=0))
        steps = [weight * np.linalg.lstsq((slope * weight)[:n], -off[:n], rcond=1e-10)[0] for n in (len(off), 6)]
        whole, base = (float(np.max(np.abs(step))) for step in steps)
        assert module._first_step_rad(begun) == pytest.approx(whole, rel=0.1)
        assert base < 0.8 * whole


def test_where_no_pair_arrives_few_are_tried_and_those_of_small_first_steps_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    steps: dict[int, float] = {}
    tried: list[tuple[Patience, float]] = []
    first_step_rad = module._first_step_rad

    def measured(begun: Equations) -> float:
        return steps.setdefault(id(begun), first_step_rad(begun))

    def given_up(begun: Equations, _bend: float, patience: Patience) -> tuple[Equations, None, float]:
        tried.append((patience, steps.get(id(begun), np.nan)))
        return begun, None, np.inf

    monkeypatch.setattr(module, "_first_step_rad", measured)
    monkeypatch.setattr(module, "approach", given_up)
    breadth = Breadth()
    assert bent_loops(problem(), breadth) == []
    soon = [step for patience, step in tried if patience == BY_WHOLE_STEPS]
    boldly = [step for patience, step in tried if patience != BY_WHOLE_STEPS]
    assert np.isnan(soon[0])
    assert max(soon[1:], default=0.0) < 1.0
    assert len(soon) <= (breadth.meetings + 1) // 2
    assert 0 < len(boldly) <= (breadth.meetings + 1) // 2
    others = [step for step in boldly if step not in soon and not np.isnan(step)]
    assert others == sorted(others)
    assert len(steps) > len(tried)
    assert sum(step < max(others) for step in steps.values()) <= len(tried)


def test_phases_1_and_3_bring_bent_limbs_to_the_goal_at_less_than_half_the_cost() -> None:
    """A quick plan, the foil, does without; with straight limbs there are none."""
    found = plan(START, GOAL)
    quick = plan(START, GOAL, options=PlanOptions(effort="quick"))
    assert found.verdict == quick.verdict == "reached"
    assert BENT_LOOPS in found.plan.structures[0].words
    assert found.joint_travel_rad < 0.5 * quick.joint_travel_rad
    straight = displacement_between(Configuration(), Configuration(se3.pose(np.eye(3), [0.02, 0.0, 0.0])), 0.1)
    assert bent_loops(Problem(BODY, COLLINEAR, COLLINEAR, straight, stored_gaits()), Breadth()) == []
