"""The planner's head: candidates, generators, stages, the incumbent, and the record of structures, each alone."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Callable

import numpy as np
import pytest
from helpers import assert_close

from purcell_cli import Configuration, Swimmer
from purcell_cli.errors import GaitError
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Deviation, displacement_between
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.blocks import Block, block_displacements, energies, starting_shapes
from purcell_cli.motion.clock import rounded
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.plan import Plan, Structure
from purcell_cli.planner import candidates as candidates_module
from purcell_cli.planner import reconfiguration
from purcell_cli.planner.arcs.steered import steered_arcs
from purcell_cli.planner.candidate import Candidate
from purcell_cli.planner.candidates import GENERATORS, Generator, generate, ranked
from purcell_cli.planner.effort import EFFORTS, Breadth, Stage
from purcell_cli.planner.exploration import Exploration
from purcell_cli.planner.gait_sequence import gait_sequences
from purcell_cli.planner.incumbent import ARRIVES, Contender, Incumbent
from purcell_cli.planner.library.recalled import library_plans
from purcell_cli.planner.limbs.bent_loops import bent_loops
from purcell_cli.planner.problem import Problem
from purcell_cli.planner.refine.segments import Segment, segments_of
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refinement import Near, Refinement, closed_on_the_clock, cycles_apart, played
from purcell_cli.planner.structures import StructureRecord

BODY = Swimmer().scaled()
START = Configuration.from_angles((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (20.0, 0.0, 10.0))
GOAL = Configuration.from_angles((0.004, -0.002, 0.001), (5.0, 3.0, -4.0), (0.0, 0.0, 0.0), (0.0, -15.0, 20.0))
FAR_BENT = (
    Configuration(
        np.eye(4), se3.exp([[0.0, 0.0, 0.0, 0.34, 0.93, 0.67], [0.0, 0.0, 0.0, 1.91, 1.37, -1.2]])[:, :3, :3]
    ),
    Configuration(
        se3.exp([-0.017, 0.0082, 0.0161, 0.09, 0.15, 0.04]),
        se3.exp([[0.0, 0.0, 0.0, 0.72, -1.62, -1.6], [0.0, 0.0, 0.0, 0.65, -1.15, -1.56]])[:, :3, :3],
    ),
)
"""Limbs bent so far that loops of theirs bring the swimmer from one to the other."""
SMALL = Breadth(orders=2, pairs=2, starts=24, chains=2, rounds=5, shorter=0, library_plans=2)


def problem(objective: str = "travel", start: Configuration = START, goal: Configuration = GOAL) -> Problem:
    wanted = displacement_between(start, goal, Swimmer().length_m)
    return Problem(BODY, start.shape, goal.shape, wanted, stored_gaits(), objective)


def empty(query: Problem) -> Equations:
    return Equations(BODY, (), query.start, query.goal, query.wanted, SEARCHING)


def rolled(angle: float, cycles: int = 1) -> Block:
    return Block(2, "roll", PrimitiveSequence.of([("limb1 roll", angle), ("limb1 roll", -angle)]), cycles)


def motion(travel: float) -> Equations:
    """Return a motion of a joint travel [rad]."""
    return Equations(BODY, segments_of([rolled(0.5 * travel)]), COLLINEAR, COLLINEAR, np.eye(4), SEARCHING)


# The incumbent


def contender(cost: float, off: float = 0.0, excess: float = 0.0, words: str = "") -> Contender:
    return Contender(motion(cost), words, off, excess, cost)


BETTER = [
    (contender(9.0), contender(1.0, off=1e-3), "an arriving plan beats a cheaper one that misses"),
    (contender(9.0, excess=0.5), contender(1.0, off=1e-3), "even one outside limits"),
    (contender(9.0), contender(1.0, excess=1e-6), "one within limits beats a cheaper one outside"),
    (contender(9.0, excess=0.1), contender(1.0, excess=0.2), "the nearer to its limits, the better"),
    (contender(1.0), contender(1.1), "the cheaper, the better"),
    (contender(9.0, off=1e-3), contender(1.0, off=1e-3, excess=0.2), "so too where nothing arrives"),
]


@pytest.mark.parametrize(("better", "worse", "law"), BETTER, ids=[law for *_, law in BETTER])
def test_the_better_contender_is_kept_in_whichever_order_they_come(
    better: Contender, worse: Contender, law: str
) -> None:
    first, last = Incumbent(), Incumbent()
    assert first.consider(better)
    assert not first.consider(worse)
    assert last.consider(worse)
    assert last.consider(better)
    assert first.best is last.best is better
    assert (better.cost < worse.cost) == (law == "the cheaper, the better"), "cost alone would decide otherwise"


def test_an_equal_contender_does_not_replace_the_incumbent() -> None:
    incumbent, one, other = Incumbent(), contender(3.0, words="one"), contender(3.0, words="other")
    assert incumbent.consider(one)
    assert not incumbent.consider(other)
    assert incumbent.best is one
    assert incumbent.consider(contender(math.nextafter(3.0, 0.0)))


def test_the_incumbent_does_not_depend_on_the_order_of_all_contenders() -> None:
    several = [contender(c, o, e) for c, o, e in itertools.product((1.0, 2.0), (0.0, 1e-3), (0.0, 0.1))]
    for order in itertools.permutations(range(len(several)), 4):
        incumbent = Incumbent()
        for k in order:
            incumbent.consider(several[k])
        assert incumbent.best is several[min(order, key=lambda k: several[k].rank)]


def test_the_incumbent_says_what_it_has() -> None:
    incumbent = Incumbent()
    assert (incumbent.arrives, incumbent.good, incumbent.beats(math.inf)) == (False, False, False)
    assert incumbent.joint_travel_rad == math.inf
    incumbent.consider(contender(1.0, off=2.0 * ARRIVES))
    assert (incumbent.arrives, incumbent.good, incumbent.beats(5.0)) == (False, False, False)
    incumbent.consider(contender(3.0, off=0.5 * ARRIVES, excess=1e-3))
    assert (incumbent.arrives, incumbent.good, incumbent.beats(5.0)) == (True, False, False)
    incumbent.consider(contender(4.0, off=0.5 * ARRIVES))
    assert (incumbent.arrives, incumbent.good) == (True, True)
    assert [incumbent.beats(cost) for cost in (3.9, 4.0, 4.1)] == [False, True, True]
    assert incumbent.joint_travel_rad == pytest.approx(4.0, abs=1e-12)


# Candidates


def test_making_strokes_changes_nothing_that_a_candidate_says() -> None:
    """A chain's estimate differs from its strokes' joint travel, so a candidate that swapped them would tell."""
    for candidate in steered_arcs(problem(), SMALL):
        before = (candidate.words, candidate.estimate_rad, candidate.astray)
        blocks = candidate.make()
        made = candidate.made()
        assert (candidate.words, candidate.estimate_rad, candidate.astray) == before
        assert made.estimate_rad == sum(b.joint_travel_rad for b in blocks) != candidate.estimate_rad
        assert (made.words, made.astray) == (candidate.words, candidate.astray)
        for one, other in zip(blocks, made.make(), strict=True):
            assert np.array_equal(one.sequence.rates(), other.sequence.rates())
            assert np.array_equal(one.sequence.duration, other.sequence.duration)
        with pytest.raises(dataclasses.FrozenInstanceError):
            candidate.estimate_rad = 0.0  # type: ignore[misc]


def test_candidates_that_may_not_arrive_come_last_and_equals_keep_their_order() -> None:
    several = [
        Candidate("astray", 1.0, tuple, astray=True),
        Candidate("dear", 3.0, tuple),
        Candidate("cheap", 2.0, tuple),
        Candidate("as cheap but for rounding", 2.0 * (1.0 - 1e-15), tuple),
    ]
    words = [c.words for c in ranked(problem(), several)]
    assert words == ["cheap", "as cheap but for rounding", "dear", "astray"]
    assert words != [c.words for c in sorted(several, key=lambda c: c.estimate_rad)]


def test_another_objective_is_ranked_by_what_the_strokes_spend_of_it() -> None:
    """A limb that rolls dissipates little for its joint travel, and one that yaws much."""
    roll = rolled(1.0)
    yaw = Block(2, "yaw", PrimitiveSequence.of([("limb1 yaw", 0.5), ("limb1 yaw", -0.5)]))
    several = [Candidate.of("yaw", (yaw,)), Candidate.of("roll", (roll,))]
    query = problem(start=Configuration(), goal=GOAL)
    assert [c.words for c in ranked(query, several)] == ["yaw", "roll"]
    by_energy = ranked(dataclasses.replace(query, objective="energy"), several)
    assert [c.words for c in by_energy] == ["roll", "yaw"]
    spent = [float(energies(BODY, c.make(), COLLINEAR).sum()) for c in by_energy]
    assert spent[0] < spent[1]


# Generators


def test_all_generators_are_listed() -> None:
    assert (bent_loops, library_plans, steered_arcs, gait_sequences) == GENERATORS


@pytest.mark.parametrize("generator", GENERATORS)
def test_what_a_generator_makes_almost_arrives(generator: Generator) -> None:
    """Within a few per cent of what is wanted; the displacement seen from the world, g_3 g_2^-1, would not be."""
    start, goal = FAR_BENT if generator is bent_loops else (START, GOAL)
    query = problem("travel", start, goal)
    found = list(generator(query, SMALL, ()))
    assert found
    for candidate in found:
        blocks = candidate.make()
        assert candidate.astray is False
        assert_close(starting_shapes(blocks, query.start)[-1], query.goal, 5e-3)
        done = se3.prefix_products(block_displacements(BODY, blocks, query.start))[-1]

        def missed(wanted: Array, done: Array = done) -> float:
            return float(np.max(np.abs(se3.log(se3.inverse(wanted) @ done))))

        assert missed(query.wanted) < 0.03
        assert missed(se3.inverse(query.wanted)) > 0.1
        assert {b.phase for b in blocks} <= {1, 2, 3}
        assert [b.phase for b in blocks] == sorted(b.phase for b in blocks)
        assert 0.7 < sum(b.joint_travel_rad for b in blocks) / candidate.estimate_rad < 1.1
        refined = Refinement(Swimmer(), start, Limits(), "travel").near(empty(query).of(segments_of(blocks)))
        assert refined.close


def test_library_plans_are_made_only_if_they_promise_to_be_shorter_than_what_is_known() -> None:
    query = problem()
    assert list(library_plans(query, SMALL, ()))
    assert list(library_plans(query, SMALL, [Candidate("short", 0.1, tuple)])) == []
    assert list(library_plans(query, SMALL, [Candidate("short", 0.1, tuple, astray=True)]))


def test_without_gaits_there_are_no_arcs_and_gait_sequences_are_refused_unless_something_else_is_known() -> None:
    query = dataclasses.replace(problem(), gaits={})
    assert list(steered_arcs(query, SMALL, ())) == []
    with pytest.raises(GaitError):
        gait_sequences(query, SMALL, ())
    with pytest.raises(GaitError):
        generate(query, SMALL)


def test_every_generator_is_asked_and_told_what_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """Also where one lacks a stored gait; only if nothing at all is found that is an error."""
    asked: list[int] = []

    def some(_problem: Problem, _breadth: Breadth, known: list[Candidate]) -> list[Candidate]:
        asked.append(len(known))
        return [Candidate("some", 61.0, tuple)]

    def lacking(_problem: Problem, _breadth: Breadth, known: list[Candidate]) -> list[Candidate]:
        asked.append(len(known))
        raise GaitError("none rolls")

    monkeypatch.setattr(candidates_module, "GENERATORS", (lacking, some, lacking, some))
    assert len(generate(problem(), SMALL)) == 2
    assert asked == [0, 0, 1, 1]
    monkeypatch.setattr(candidates_module, "GENERATORS", (lacking,))
    with pytest.raises(GaitError, match="none rolls"):
        generate(problem(), SMALL)


def test_what_seems_dear_is_priced_and_made_only_when_it_is_asked_for() -> None:
    """Beside a candidate of little travel, gaits and arcs are prices; beside a dear one, or none, they are made."""
    query = problem()
    cheap, dear = (Candidate("known", travel, tuple) for travel in (1e-3, 1e3))
    for generator in (gait_sequences, steered_arcs):
        later, made = generator(query, SMALL, [cheap]), generator(query, SMALL, [dear])
        assert 1 <= len(later) <= len(made)
        travel = sum(b.joint_travel_rad for b in later[0].make())
        assert travel == pytest.approx(sum(b.joint_travel_rad for b in made[0].make()), rel=0.3)
        assert 0.3 < later[0].estimate_rad / travel < 1.2
        assert later[0].estimate_rad != travel
        assert generator(query, SMALL, [dataclasses.replace(cheap, astray=True)])[0].words == made[0].words


def test_limb_ways_are_worked_out_once_for_a_breadth() -> None:
    query = problem()
    pairs = query.pairs(SMALL)
    assert query.pairs(dataclasses.replace(SMALL)) is pairs
    assert query.pairs(dataclasses.replace(SMALL, pairs=1)) is not pairs
    assert query.one_by_one is query.one_by_one
    assert len(pairs) == len(pairs.missing) == len(pairs.joint_travel_rad) == 2
    for k in range(len(pairs)):
        blocks = pairs.around(k, [])
        assert sum(b.joint_travel_rad for b in blocks) == pytest.approx(pairs.joint_travel_rad[k], abs=1e-12)
        before, after = (
            block_displacements(BODY, [b], s)[0] for b, s in zip(blocks, (query.start, COLLINEAR), strict=True)
        )
        assert_close(before @ pairs.missing[k] @ after, query.wanted, 1e-3)


# The record of structures


def test_the_record_keeps_what_is_known_best_of_every_structure() -> None:
    record = StructureRecord()
    first, again, other, unmade = (Candidate(w, e, tuple) for w, e in (("a", 5.0), ("a", 1.0), ("b", 6.0), ("c", 7.0)))
    record.made(other, 6.5)
    record.near("d", 9.0)
    record.near("d", 8.0)
    record.near("d", 8.5)
    taken = Structure("taken", 2.0)
    found = record.structures(taken, [first, again, other, unmade])
    assert found == (taken, Structure("a", 5.0), Structure("b", 6.5), Structure("c", 7.0), Structure("d", 8.0))
    assert [s.why_not for s in record.structures(Structure("taken", 7.5), [first, other, unmade])] == [
        *("", "was not tried: this is an estimate", "does not come near the goal"),
        *("was not tried: this is an estimate", ""),
    ]
    record.near("e", 1.0, "leaves the workspace")
    record.near("e", 1.5)
    record.near("f", 0.5)
    assert [s.why_not for s in record.structures(taken, [])] == [
        *("", "takes more once it arrives exactly", "leaves the workspace", "")
    ]
    assert record.structures(taken, [], "energy")[1].why_not == "dissipates more energy"
    record = StructureRecord()
    record.made(other, 6.5)
    record.near("d", 8.0)
    record.near("b", 4.0)
    assert record.structures(taken, [other])[1] == Structure("b", 4.0)
    assert record.structures(Structure("b", 3.0), [other, unmade])[:2] == (Structure("b", 3.0), Structure("c", 7.0))


# Refinement


def test_cycles_come_apart_from_the_last_as_far_as_there_is_room() -> None:
    blocks = [rolled(0.3, 3), rolled(0.1), rolled(0.2, 4)]
    chain = Equations(BODY, segments_of(blocks), COLLINEAR, COLLINEAR, np.eye(4), SEARCHING)
    for most, cycles in ((0, [3, 1, 4]), (7, [3, 1, 4]), (9, [1, 1, 1, 1, 4]), (10, [3, 1, 1, 1, 1, 1]), (16, [1] * 8)):
        apart = cycles_apart(chain, most)
        assert [b.cycles for b in apart] == cycles
        assert sum(b.joint_travel_rad for b in apart) == pytest.approx(chain.joint_travel_rad, abs=1e-12)


def test_a_contender_arrives_exactly_and_is_judged_by_its_limits() -> None:
    query = problem()
    candidate = next(iter(library_plans(query, SMALL, ())))
    refinement = Refinement(Swimmer(), START, Limits(), "travel")
    near = refinement.near(empty(query).of(segments_of(candidate.make())))
    found = refinement.contender(near, candidate.words)
    assert found.good
    assert found.cost == pytest.approx(found.motion.joint_travel_rad, abs=1e-12)
    assert near.off > ARRIVES, "the approach alone does not arrive"
    end = START.pose @ in_metres(se3.prefix_products(block_displacements(BODY, played(found.motion), START.shape))[-1])
    reached = Configuration(se3.normalised(end), starting_shapes(played(found.motion), START.shape)[-1])
    assert Deviation.between(reached, GOAL).within(1e-10, 1e-9)
    apart = Refinement(Swimmer(), START, Limits(clearance_m=10.0), "travel").contender(near, "")
    assert apart.arrives
    assert not apart.good
    assert apart.excess > 90.0, "in units of L, of 0.1 m"


def test_a_repeated_stroke_that_closes_to_rounding_closes_on_the_clock() -> None:
    """Seventy thousand cycles of a stroke that does not turn a limb far."""
    angle = np.array([-0.022, -0.0039, -0.0378, 0.0023, 0.0598, 0.0016])
    stroke = PrimitiveSequence(np.array([2, 5, 2, 5, 2, 5]), angle)

    def on_the_clock(some: Array) -> Array:
        return rounded(some, 1.0, 0.007)

    for control in (2, 5):
        own = stroke.control == control
        assert abs(np.sum(angle[own])) < 1e-15
        assert abs(np.sum(on_the_clock(angle[own]))) > 1e-3, "one by one they leave a step of the clock each cycle"
        made = closed_on_the_clock(stroke, on_the_clock).angle
        assert abs(np.sum(made[own])) < 1e-15
        assert np.max(np.abs(made - angle)) <= 0.007


def test_a_rectangle_that_closes_only_once_it_is_on_the_clock_arrives_too() -> None:
    """Its sides are free then, so there are more unknowns than there were before the rounding."""
    far = Configuration(in_metres(se3.pose(np.eye(3), np.array([3.0, 0.2, 0.1]))), COLLINEAR)
    query = problem(goal=far)

    def askew(segment: Segment) -> Segment:
        if not segment.rectangles:
            return segment
        angle = segment.sequence.angle.copy()
        angle[2] = np.nextafter(angle[2], np.inf)
        return dataclasses.replace(segment, sequence=segment.sequence.with_angles(angle))

    closed = empty(query).of(segments_of(next(iter(gait_sequences(query, SMALL, ()))).make()))
    refinement = Refinement(Swimmer(), START, Limits(), "travel")
    near = refinement.near(closed.of([askew(s) for s in closed.segments]))
    assert len(near.motion.angles) < len(closed.angles)
    assert refinement.contender(near, "").good


def in_metres(pose: Array) -> Array:
    out = pose.copy()
    out[:3, 3] *= Swimmer().length_m
    return out


# Exploration and stages


class Refiner:
    """Stands for a refinement: motions longer than a limit do not come near the goal."""

    bend_rad, clearance = 1.0, 0.0

    objective = "travel"

    def __init__(self, longest: float) -> None:
        self.longest = longest
        self.finished: list[float] = []

    def near(self, tried: Equations) -> Near:
        return Near(tried, tried.at(tried.angles), 1.0 if tried.joint_travel_rad > self.longest else 0.0)

    def cost(self, tried: Equations) -> float:
        return tried.joint_travel_rad

    def contender(self, near: Near, words: str) -> Contender:
        self.finished.append(near.motion.joint_travel_rad)
        return Contender(near.motion, words, near.off, 0.0, self.cost(near.motion))


def explored(travels: list[float], stage: Stage, longest: float = 10.0) -> tuple[Exploration, list[tuple[int, int]]]:
    told: list[tuple[int, int]] = []
    search = Exploration(
        motion(0.0).of(()),
        Refiner(longest),
        progress=lambda done, of, _news: told.append((done, of)),  # type: ignore[arg-type]
    )
    search.explore(stage, [Candidate.of(f"{t:g}", (rolled(0.5 * t),)) for t in travels])
    return search, told


@pytest.mark.parametrize(
    ("travels", "count", "best", "refined"),
    [
        ([3.0, 2.0, 1.0], 1, "3", 1),
        ([3.0, 2.0, 1.0], 2, "2", 2),
        ([12.0, 11.0, 2.0, 1.0], 1, "2", 3),
        ([12.0, 11.0], 1, "", 2),
    ],
    ids=["one", "two", "more until one arrives", "none arrives"],
)
def test_a_stage_refines_as_many_as_it_says_and_more_until_one_arrives(
    travels: list[float], count: int, best: str, refined: int
) -> None:
    search, told = explored(travels, Stage(candidates=count))
    assert search.incumbent.best is not None
    assert search.incumbent.best.words == best
    assert told == [(k + 1, count) for k in range(refined)]
    assert search.incumbent.good == (best != "")


@pytest.mark.parametrize(("estimate", "best"), [(4.9, "4.9"), (5.1, "10")])
def test_what_may_not_arrive_is_tried_where_it_promises_far_less(estimate: float, best: str) -> None:
    search = Exploration(motion(0.0).of(()), Refiner(10.0))  # type: ignore[arg-type]
    sure, other, astray = (Candidate.of(f"{t:g}", (rolled(0.5 * t),)) for t in (10.0, 10.5, estimate))
    search.explore(Stage(), [sure, other, dataclasses.replace(astray, astray=True)])
    assert search.incumbent.best is not None
    assert search.incumbent.best.words == best


def test_only_what_may_be_better_is_brought_exactly_to_the_goal() -> None:
    search, _ = explored([2.0, 3.0, 2.0, 1.0], Stage(candidates=4))
    assert search.refinement.finished == pytest.approx([2.0, 1.0])  # type: ignore[attr-defined]
    assert [s.words for s in search.structures(())] == ["1", "2", "3"], "all that came near are on record"


def test_what_never_arrives_is_kept_until_something_does() -> None:
    search, _ = explored([12.0, 13.0], Stage(candidates=2))
    assert search.incumbent.joint_travel_rad == pytest.approx(12.0)
    search.consider(motion(9.0), "late")
    assert search.incumbent.best is not None
    assert search.incumbent.best.words == "late"


def reconfigured(effort: str = "quick", progress: Callable[[int, int, str], None] = lambda *_: None) -> Plan:
    return reconfiguration.reconfigure(Swimmer(), START, GOAL, stored_gaits(), effort, progress=progress)


def stop(*_: object) -> None:
    raise KeyboardInterrupt


@pytest.mark.slow
def test_an_interrupt_keeps_the_best_plan_only_in_a_stage_that_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is given up at the first news, when one candidate has arrived."""
    for keeps in (True, False):
        stages = (Stage(SMALL, interrupt_keeps_best=keeps), Stage(SMALL, candidates=99, interrupt_keeps_best=keeps))
        monkeypatch.setattr(reconfiguration, "EFFORTS", {"quick": stages})
        if not keeps:
            with pytest.raises(KeyboardInterrupt):
                reconfigured(progress=stop)
            continue
        found = reconfigured(progress=stop)
        assert found.limits is not None
        assert found.limits.kept
        assert found.joint_travel_rad == found.structures[0].joint_travel_rad > 0.0


def test_an_interrupt_before_anything_arrives_is_one_in_every_stage(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reconfiguration, "EFFORTS", {"quick": (Stage(SMALL, interrupt_keeps_best=True),)})
    monkeypatch.setattr(reconfiguration, "generate", stop)
    with pytest.raises(KeyboardInterrupt):
        reconfigured()


@pytest.mark.parametrize(
    ("arriving", "last_resort", "tried"),
    [(True, True, [1]), (True, False, [1, 2]), (False, True, [1, 1])],
    ids=["not needed", "another stage", "needed"],
)
def test_a_last_resort_is_for_when_nothing_arrives(
    arriving: bool, last_resort: bool, tried: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    """And what was tried before is not tried again, as it is by other stages."""
    wide = dataclasses.replace(SMALL, pairs=1)
    asked: list[Breadth] = []
    found: list[int] = []
    explore = Exploration.explore

    def some(query: Problem, breadth: Breadth) -> list[Candidate]:
        asked.append(breadth)
        return list(library_plans(query, SMALL, ()))[:1]

    def noted(search: Exploration, stage: Stage, candidates: list[Candidate]) -> None:
        found.append(len(candidates))
        if arriving:
            explore(search, stage, candidates)

    monkeypatch.setattr(reconfiguration, "generate", some)
    monkeypatch.setattr(Exploration, "explore", noted)
    monkeypatch.setattr(reconfiguration, "EFFORTS", {"quick": (Stage(SMALL), Stage(wide, last_resort=last_resort))})
    assert bool(reconfigured().blocks) == arriving
    assert asked == [SMALL, wide][: len(tried)]
    assert found == tried


def test_a_thorough_search_begins_with_the_standard_one() -> None:
    """So it finds no longer plan, and an interrupt leaves one early."""
    assert dataclasses.replace(EFFORTS["thorough"][0], interrupt_keeps_best=False) == EFFORTS["standard"][0]
    assert all(stage.interrupt_keeps_best for stage in EFFORTS["thorough"])
    assert not any(stage.last_resort for stage in EFFORTS["thorough"])
    for effort in ("quick", "standard"):
        assert [stage.last_resort for stage in EFFORTS[effort]] == [False, True]
        assert not any(stage.interrupt_keeps_best for stage in EFFORTS[effort])
