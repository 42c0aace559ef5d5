"""Shorter motions: known upper bounds are met, limits hold, and the arrival stays exact."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import NIGHTLY, assert_close, is_close

from purcell_cli import Configuration, PlanOptions, Swimmer, load_scenario, plan, stored_scenarios
from purcell_cli.files.builtin import find_scenario, stored_gaits
from purcell_cli.mechanics.configuration import displacement_between
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING, flow
from purcell_cli.mechanics.primitives import PrimitiveSequence, joined
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.limits_check import check
from purcell_cli.planner.incumbent import Contender, Incumbent
from purcell_cli.planner.objectives import cost
from purcell_cli.planner.reconfiguration import reconfigure
from purcell_cli.planner.refine.minimum_travel import Pace, merged, minimise_travel, offered
from purcell_cli.planner.refine.segments import Segment, segments_of
from purcell_cli.planner.refine.shooting import Equations

KNOWN = {
    "0.1 L along x": ([0.01, 0.0, 0.0], [0.0, 0.0, 0.0], 0.7, 4.52),
    "0.05 L along y": ([0.0, 0.005, 0.0], [0.0, 0.0, 0.0], 1.5, 5.32),
    "0.05 L along z": ([0.0, 0.0, 0.005], [0.0, 0.0, 0.0], 1.5, 5.32),
    "a yaw of 5 degrees": ([0.0, 0.0, 0.0], [5.0, 0.0, 0.0], 1.5, 5.72),
    "a roll of 30 degrees": ([0.0, 0.0, 0.0], [0.0, 0.0, 30.0], 1.0, 0.371),
    "20 L along x": ([2.0, 0.0, 0.0], [0.0, 0.0, 0.0], 1.0, 20 / 0.0451),
    "20 L along x, bent further": ([2.0, 0.0, 0.0], [0.0, 0.0, 0.0], 1.2, 20 / 0.0460),
    "(0.1, 0.05, 0.02) L and 5 degrees each": ([0.01, 0.005, 0.002], [5.0, 5.0, 5.0], 1.5, 8.72),
}
"""Position [m], Euler angles [deg], bend limit [rad] and the best joint travel known [rad]."""

BALL_JOINTED = tuple(
    name
    for name, path in stored_scenarios().items()
    if (scenario := load_scenario(path)).mission.plain and scenario.swimmer.ball_joints
)
"""The stored scenarios of swimmers on ball joints, but missions."""


@pytest.mark.slow
@pytest.mark.parametrize("name", KNOWN)
def test_plans_meet_the_best_known_joint_travel(name: str) -> None:
    """Within 1.5 %; the quick plan, the foil, is longer where strokes can be joined."""
    position, angles, bend, best = KNOWN[name]
    swimmer, goal = Swimmer(max_bend_rad=bend), Configuration.from_angles(position, angles)
    found = plan(Configuration(), goal, swimmer=swimmer)
    assert found.verdict == "reached"
    assert found.joint_travel_rad <= 1.015 * best
    axes = found.trajectory.shape[:, :, 0, 0]
    assert np.max(np.arccos(np.clip(axes, -1.0, 1.0))) <= bend + 1e-8
    quick = plan(Configuration(), goal, swimmer=swimmer, options=PlanOptions(effort="quick"))
    assert quick.verdict == "reached"
    assert quick.joint_travel_rad >= 0.999 * found.joint_travel_rad  # the last steps of an arrival change it a little
    # Library plans, the cruise and the crank leave little to be joined; a displacement in every direction does.
    assert name != "(0.1, 0.05, 0.02) L and 5 degrees each" or quick.joint_travel_rad > 1.1 * best


def asked_of(name: str) -> tuple[Configuration, Configuration, Swimmer]:
    """Return the start, the goal and the swimmer of a stored scenario, or of a numbered random query."""
    if not name.isdigit():
        stored = find_scenario(name)
        return stored.start, stored.goal, stored.swimmer
    rng = np.random.default_rng([int(name), 11])
    bend = 0.0 if int(name) % 2 else 40.0
    start, goal = (
        Configuration.from_angles(p, rng.uniform(-60, 60, 3), *rng.uniform(-bend, bend, (2, 3)))
        for p in (np.zeros(3), 0.1 * 10.0 ** rng.uniform(-1.0, 1.0) * rng.uniform(-1.0, 1.0, 3))
    )
    return start, goal, Swimmer(max_bend_rad=rng.uniform(0.7, 1.4))


@pytest.mark.parametrize(
    "name",
    [
        "pitch",
        *(pytest.param(name, marks=NIGHTLY) for name in (*BALL_JOINTED, *map(str, range(50))) if name != "pitch"),
    ],
)
def test_no_objective_finds_less_joint_travel_than_least_joint_travel(name: str) -> None:
    """Nor does that find less energy or fewer primitives."""
    start, goal, swimmer = asked_of(name)
    found = {m: reconfigure(swimmer, start, goal, stored_gaits(), minimize=m) for m in ("travel", "energy", "switches")}
    short = found.pop("travel")
    for measure, other in found.items():
        spent = [cost(measure, swimmer, way.blocks, start.shape) for way in (other, short)]
        assert other.joint_travel_rad >= short.joint_travel_rad * (1.0 - 1e-12)
        assert spent[0] <= spent[1] * (1.0 + 1e-12)


def test_contenders_of_less_joint_travel_than_the_least_are_not_taken() -> None:
    """Though they have fewer primitives; without a least joint travel (the foil) they are."""
    query = Equations(Swimmer().scaled(), (), COLLINEAR, COLLINEAR, np.eye(4), SEARCHING)
    long, short = (query.of(segments_of([Block(2, "any", WORD.times(n))])) for n in (3, 2))
    for least_rad, taken in ((long.joint_travel_rad, "long"), (0.0, "short")):
        incumbent = Incumbent()
        incumbent.least_rad = least_rad
        incumbent.consider(Contender(long, "long", 0.0, 0.0, 12.0))
        incumbent.consider(Contender(short, "short", 0.0, 0.0, 8.0))
        assert incumbent.best is not None
        assert incumbent.best.words == taken


def test_offered_controls_change_nothing_until_they_turn() -> None:
    sequence = PrimitiveSequence.of([("limb1 yaw", 0.4), ("limb2 pitch", -0.3)])
    wide = offered(sequence, 2)
    assert len(wide) == 6 + 2 * 2 * 6
    assert list(merged(wide)) == [(name, pytest.approx(angle, abs=1e-15)) for name, angle in sequence]


WORD = PrimitiveSequence.of([("limb1 yaw", 0.4), ("limb2 pitch", 0.3), ("limb1 yaw", -0.3), ("limb2 roll", 0.2)])
LOOP = PrimitiveSequence.of([("limb1 yaw", 0.5), ("limb2 yaw", 0.6), ("limb1 yaw", -0.5), ("limb2 yaw", -0.6)])
FIXED = PrimitiveSequence.of([("limb1 pitch", 0.2), ("limb2 yaw", 0.1), ("limb2 yaw", -0.1), ("limb1 pitch", -0.2)])


def motion(displacement: np.ndarray) -> Equations:
    """Return equations of free primitives about a repeated rectangle and another repeated stroke."""
    parts = [
        Segment(1, (("a", 0.0, 4),), WORD),
        Segment(2, (("b", 0.0, 4),), LOOP, cycles=7),
        Segment(2, (("c", 0.0, 4),), WORD.inverse()),
        Segment(2, (("d", 0.0, 4),), FIXED, cycles=3),
        Segment(3, (("e", 0.0, 4),), WORD),
    ]
    return Equations(Swimmer().scaled(), parts, COLLINEAR, WORD.shapes(COLLINEAR)[-1], displacement)


def test_the_equations_see_every_cycle() -> None:
    """Against the flow of all cycles one after the other; the foil has one cycle fewer."""
    body = Swimmer().scaled()
    played = joined([WORD, LOOP.times(7), WORD.inverse(), FIXED.times(3), WORD])
    equations = motion(flow(body, played))
    assert_close(equations.residual(equations.angles)[:6], np.zeros(6), 1e-12)
    assert_close(equations.at(equations.angles).residual, equations.residual(equations.angles), 1e-12)
    fewer = joined([WORD, LOOP.times(6), WORD.inverse(), FIXED.times(3), WORD])
    assert not is_close(motion(flow(body, fewer)).residual(equations.angles)[:6], np.zeros(6), 1e-3)


def test_the_equations_have_the_derivative_they_say() -> None:
    """Central differences near the arrival, in free angles, sides of rectangles and shapes at phase ends."""
    played = joined([WORD, LOOP.times(7), WORD.inverse(), FIXED.times(3), WORD])
    equations = motion(flow(Swimmer().scaled(), played))
    angle, h = equations.angles, 1e-5
    assert len(angle) == 4 + 2 + 4 + 0 + 4
    rows = [0, 1, 2, 3, 4, 5, *range(18, 24)]  # at the ends of phases 1 and 2 the word is far from collinear
    differences = np.array(
        [(equations.residual(angle + d) - equations.residual(angle - d)) / (2 * h) for d in h * np.eye(len(angle))]
    ).T
    assert_close(equations.at(angle).derivative[rows], differences[rows], 1e-7)
    assert not is_close(equations.at(-angle).derivative[rows], differences[rows], 1e-3)


def test_the_equations_after_some_segments_miss_the_same() -> None:
    """The base's twist and the gaps of later phases are those of the whole, and so is what the later angles change."""
    displacement = flow(Swimmer().scaled(), WORD) @ np.diag([1.0, -1.0, -1.0, 1.0])
    equations = motion(displacement)
    missing = equations.residual(equations.angles)[:6]
    last = equations.after(4, missing)
    angle = last.angles + 0.1
    whole = np.concatenate([equations.angles[:-4], angle])
    assert_close(last.residual(angle), np.delete(equations.residual(whole), slice(6, 18)), 1e-12)
    assert_close(last.at(angle).derivative[:6], equations.at(whole).derivative[:6, -4:], 1e-11)
    more = equations.after(2, missing)
    assert_close(more.residual(more.angles)[:6], missing, 1e-12)
    assert not is_close(missing, last.residual(angle)[:6], 1e-3)


def test_rectangles_close_whatever_their_sides() -> None:
    equations = motion(np.eye(4))
    angle = equations.angles.copy()
    angle[4:6] += [0.2, -0.1]
    loop = equations.with_angles(angle)[1]
    assert loop.rectangles == 1
    assert_close(loop.sequence.shapes(COLLINEAR)[-1], COLLINEAR, 1e-15)


@pytest.mark.slow
def test_a_motion_with_bent_limbs_becomes_shorter_and_keeps_its_limits() -> None:
    swimmer = Swimmer()
    start = Configuration.from_angles(limb1_euler_deg=(120.0, 0.0, 30.0), limb2_euler_deg=(-110.0, 20.0, 0.0))
    goal = Configuration.from_angles((0.15, 0.05, -0.05), (20.0, 10.0, 30.0), limb1_euler_deg=(0.0, 70.0, 0.0))
    begun = plan(start, goal, swimmer=swimmer, options=PlanOptions(effort="quick")).plan
    wanted = displacement_between(start, goal, swimmer.length_m)
    equations = Equations(swimmer.scaled(), segments_of(begun.blocks), start.shape, goal.shape, wanted)
    found = minimise_travel(equations, swimmer.max_bend_rad - 1e-5, Pace(rounds=3, steps=40))
    assert found.joint_travel_rad < 0.95 * begun.joint_travel_rad
    assert found.at(found.angles).size < 1e-4
    report = check(swimmer, start, found.blocks())
    assert report.clearance.distance_m > 0.0
    assert all(v.excess < 1e-4 for v in report.violations)


@pytest.mark.slow
def test_a_small_displacement_in_all_directions_takes_a_word_that_no_hand_would_write() -> None:
    """(0.1, 0.05, 0.02) L and 5 degrees of yaw, pitch and roll: best known 8.72 rad; to look longer is no worse."""
    goal = Configuration.from_angles([0.01, 0.005, 0.002], [5.0, 5.0, 5.0])
    swimmer = Swimmer(max_bend_rad=1.5)
    found, known = (
        plan(Configuration(), goal, swimmer=swimmer, options=PlanOptions(effort=e)) for e in ("thorough", "standard")
    )
    assert found.verdict == "reached"
    assert found.joint_travel_rad <= min(1.03 * 8.72, known.joint_travel_rad)
