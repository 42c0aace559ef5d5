"""Joints: turns about the base's z, what files may say, what is refused, ranges, pace, and brackets."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from helpers import Run, assert_close, is_close, runner
from scipy.spatial.transform import Rotation

from purcell_cli import Configuration, PlanOptions, Swimmer, load_plan, plan, write_plan
from purcell_cli.errors import InputError, ParameterError
from purcell_cli.files.builtin import stored_gaits, stored_swimmers
from purcell_cli.files.plan_file import PlanDocument
from purcell_cli.files.servo_map_file import load_servo_map
from purcell_cli.files.swimmer_file import load_swimmer, swimmer_written
from purcell_cli.gaits.joint_fit import refuse_joints
from purcell_cli.gaits.pure_stroke import realise
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, from_euler
from purcell_cli.lie_brackets.control_fields import frame
from purcell_cli.lie_brackets.controllability import controllability
from purcell_cli.lie_brackets.joint_fields import joint_frame
from purcell_cli.lie_brackets.joint_reach import usual_depth, weak_directions
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.joints import Joint, limb_at
from purcell_cli.mechanics.lift import displacements, flow
from purcell_cli.mechanics.lift_derivatives import Repeat, flow_and_jacobian, shape_gap
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.limits_check import check
from purcell_cli.motion.options import Effort
from purcell_cli.motion.pace import paced
from purcell_cli.motion.trajectory import as_table, sample
from purcell_cli.motion.verdict import Verdict
from purcell_cli.solution import carried_out
from purcell_cli.verification.verify import verify

UNIT = Swimmer().scaled()
BALL, UNIVERSAL, FIXED = Joint(), Joint("universal"), Joint("fixed")
YAW, PITCH = Joint("hinge", "yaw"), Joint("hinge", "pitch")
DONE, MISUSE = 0, 2


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    monkeypatch.chdir(tmp_path)
    return runner(capsys)


def differences(sequence: PrimitiveSequence, changes: Array, played: Mapping[str, int] | None = None) -> Array:
    """Return how the displacement changes along some changes of the angles, by central differences. Shape (6, n)."""
    first, stop, cycles = (played or {"first": 0, "stop": 0, "cycles": 1}).values()

    def made(angle: Array) -> Array:
        s = sequence.with_angles(angle)
        return flow(UNIT, s[:first] + s[first:stop].times(cycles) + s[stop:])

    back = se3.inverse(made(sequence.angle))
    step = 1e-5
    ends = [[se3.log(back @ made(sequence.angle + sign * step * c)) for sign in (1, -1)] for c in changes]
    return np.array([(up - down) / (2 * step) for up, down in ends]).T


@pytest.mark.parametrize("controls", [(1, 4, 6, 7), (1, 3, 4, 5, 6)], ids=["both universal", "one of them a ball"])
def test_derivatives_by_a_universal_joints_angles_are_those_of_the_flow(controls: tuple[int, ...]) -> None:
    rng = np.random.default_rng(3)
    sequence = PrimitiveSequence(rng.choice(controls, 12), rng.normal(size=12) * 0.5)
    found = flow_and_jacobian(UNIT, sequence)[1]
    assert_close(found, differences(sequence, np.eye(12)), 1e-7)
    own = np.where(sequence.control >= 6, 3 * (sequence.control - 6) + 2, sequence.control)
    assert not is_close(flow_and_jacobian(UNIT, PrimitiveSequence(own, sequence.angle))[1], found, 1e-2)


def test_derivatives_of_a_repeated_loop_of_psi_and_theta_are_those_of_its_cycles_together() -> None:
    lap = PrimitiveSequence.of([(6, 0.5), (1, 0.3), (4, 0.2), (6, -0.5), (1, -0.3), (4, -0.2)])
    sequence = PrimitiveSequence.of([(6, 0.3), (1, 0.4), (7, -0.2)]) + lap + PrimitiveSequence.of([(1, 0.2), (6, -0.4)])
    found = flow_and_jacobian(UNIT, sequence, repeats=[Repeat(3, 9, 3)])[1]
    together = np.zeros((8, 11))
    for row, (columns, signs) in enumerate(
        [([k], [1]) for k in (0, 1, 2, 9, 10)] + [([k, k + 3], [1, -1]) for k in (3, 4, 5)]
    ):
        together[row, columns] = signs
    wanted = differences(sequence, together, {"first": 3, "stop": 9, "cycles": 3})
    assert_close(found @ together.T, wanted, 1e-7)


def test_squares_of_psi_and_theta_close_exactly_and_squares_of_own_axes_do_not() -> None:
    start = np.stack([limb_at(0.4, -0.3), np.eye(3)])
    square = PrimitiveSequence.of([(6, 0.7), (1, 0.5), (6, -0.7), (1, -0.5)])
    assert_close(square.shapes(start)[-1], start, 1e-15)
    own = PrimitiveSequence.of([(2, 0.7), (1, 0.5), (2, -0.7), (1, -0.5)])
    assert not is_close(own.shapes(start)[-1], start, 0.1)


def test_a_turn_about_the_bases_z_is_a_constant_rate_in_the_limbs_frame() -> None:
    start = np.stack([limb_at(0.4, -0.6), limb_at(-0.2, 0.1)])
    turn = PrimitiveSequence.of([(6, 0.8), (7, -0.5)])
    shapes = turn.shapes(start)
    assert_close(shapes[-1], np.stack([limb_at(1.2, -0.6), limb_at(-0.7, 0.1)]), 1e-15)
    rates = turn.rates(shapes[:-1])
    assert_close(rates[0], [math.sin(0.6), 0.0, math.cos(0.6), 0.0, 0.0, 0.0], 1e-15)
    assert_close(start @ turn.turns(shapes[:-1])[0], shapes[1], 1e-15)
    assert_close(displacements(UNIT, turn, start)[1], displacements(UNIT, turn[1:], shapes[1])[0], 1e-14)
    with pytest.raises(ParameterError, match="shapes before them"):
        turn.rates()


def test_the_gap_of_a_shape_knows_that_pitch_turns_with_psi() -> None:
    rng = np.random.default_rng(1)
    sequence = PrimitiveSequence(rng.choice([1, 4, 6, 7], 10), rng.normal(size=10) * 0.4)
    end = sequence.shapes(COLLINEAR)[-1]
    slope = shape_gap(sequence, sequence.shapes(COLLINEAR), end)[1]
    for k in range(10):
        moved = sequence.with_angles(sequence.angle + 1e-6 * (np.arange(10) == k))
        assert_close(shape_gap(moved, moved.shapes(COLLINEAR), end)[0] / 1e-6, slope[:, k], 1e-5)


# Files

GOOD = {
    "joints: {limb1: universal, limb2: fixed}": (UNIVERSAL, FIXED),
    "joints: {limb2: {kind: hinge, axis: pitch, range_deg: [-90, 60], rate_rad_s: 0.5}}": (
        BALL,
        Joint("hinge", "pitch", theta_deg=(-90.0, 60.0), rate_rad_s=0.5),
    ),
    "joints: {limb1: {kind: universal, range_deg: {psi: [-90, 90], theta: [-60, 60]}}, limb2: hinge}": (
        Joint("universal", psi_deg=(-90.0, 90.0), theta_deg=(-60.0, 60.0)),
        YAW,
    ),
    "joints: {}": (BALL, BALL),
}

BAD = {
    "joints: {limb3: ball}": "joints.limb3: wanted one of the keys limb1, limb2",
    "joints: {limb1: bal}": "joints.limb1: wanted one of ball, universal, hinge, fixed (nearest: ball)",
    "joints: {limb1: {kind: hinge, axis: roll}}": "joints.limb1.axis: wanted one of yaw, pitch",
    "joints: {limb1: {kind: ball, axis: yaw}}": "joints.limb1.axis: wanted none for a ball joint",
    "joints: {limb1: {kind: hinge, range_deg: [60, -60]}}": "joints.limb1.range_deg: wanted two angles of psi",
    "joints: {limb1: {kind: hinge, range_deg: [30, 30]}}": (
        "joints.limb1.range_deg: wanted two angles of psi from -180 to 180, the least first, found [30.0, 30.0]"
    ),
    "joints: {limb1: {kind: hinge, range_deg: [0]}}": "joints.limb1.range_deg: wanted a list of 2",
    "joints: {limb1: {kind: hinge, range_deg: [-200, 10]}}": "joints.limb1.range_deg[0]: wanted a finite number",
    "joints: {limb1: {kind: hinge, range_deg: {theta: [0, 10]}}}": "joints.limb1.range_deg: wanted no range of theta",
    "joints: {limb1: {kind: universal, range_deg: [0, 10]}}": "joints.limb1.range_deg: wanted ranges by angle",
    "joints: {limb1: {kind: ball, range_deg: [0, 10]}}": "joints.limb1.range_deg: wanted none for a ball joint",
    "joints: {limb1: {kind: hinge, rate_rad_s: 0}}": "joints.limb1.rate_rad_s: wanted a finite number above",
    "joints: {limb1: {kind: hinge, rate_rad_s: fast}}": "joints.limb1.rate_rad_s: wanted a finite number",
    "joints: {limb1: {kind: fixed, rate_rad_s: 1}}": "joints.limb1.rate_rad_s: wanted none for a fixed joint, found 1",
    "joints: {limb1: {kind: universal, range_deg: {theta: [9, -9]}}}": (
        "joints.limb1.range_deg.theta: wanted two angles of theta from -180 to 180, the least first, found [9.0, -9.0]"
    ),
    "joints: {limb1: [ball]}": "joints.limb1: wanted one of",
    "joint_acceleration_rad_s2: 0": "joint_acceleration_rad_s2: wanted a finite number above",
    "joint_acceleration_rad_s2: -1": "joint_acceleration_rad_s2: wanted a finite number above",
}


@pytest.mark.parametrize("text", GOOD)
def test_joints_are_read_as_they_are_written(text: str, tmp_path: Path) -> None:
    file = tmp_path / "swimmer.yaml"
    file.write_text(text, encoding="utf-8")
    swimmer = load_swimmer(file)
    assert swimmer.joints == GOOD[text]
    file.write_text(json.dumps(swimmer_written(swimmer)), encoding="utf-8")
    assert load_swimmer(file) == swimmer


@pytest.mark.parametrize("text", BAD)
def test_bad_joints_are_one_message_with_line_key_and_what_was_wanted(text: str, tmp_path: Path) -> None:
    file = tmp_path / "swimmer.yaml"
    file.write_text(f"# a comment\n{text}\n", encoding="utf-8")
    with pytest.raises(InputError) as told:
        load_swimmer(file)
    assert f"swimmer.yaml:2: {BAD[text]}" in str(told.value)


def test_stored_swimmers_read_and_are_found_by_name(run: Run) -> None:
    assert {"paper", "planar", "universal"} <= stored_swimmers().keys()
    assert load_swimmer(stored_swimmers()["paper"]) == Swimmer()
    code, out, _ = run("controllability", "--swimmer", "planar", "--json")
    assert (code, json.loads(out)["growth_vector"]) == (DONE, [2, 3, 5])
    code, _, err = run("controllability", "--swimmer", "plnar")
    assert code == MISUSE
    assert "did you mean 'planar'?" in err


@pytest.mark.slow
def test_init_offers_stored_swimmers(run: Run, tmp_path: Path) -> None:
    assert run("init", "here", "--swimmer", "planar")[0] == DONE
    assert load_swimmer(tmp_path / "here" / "swimmer.yaml").joints == (YAW, YAW)
    assert list(load_servo_map(tmp_path / "here" / "servos.yaml").channels) == ["limb1_yaw", "limb2_yaw"]
    assert run("plan", "here/scenario.yaml", "--effort", "quick")[0] == DONE
    code, _, err = run("init", "there", "--swimmer", "plane")
    assert (code, "a stored swimmer is wanted" in err, (tmp_path / "there").exists()) == (MISUSE, True, False)


# What joints cannot do


def test_a_shape_that_a_joint_cannot_make_is_refused_with_the_angle_and_how_far() -> None:
    cases = (
        (
            (UNIVERSAL, BALL),
            (10, 20, 30),
            "limb 1: a roll of 0, since its joint is a universal joint, is wanted, found 30 deg",
        ),
        ((YAW, BALL), (10, 5, 0), "limb 1: a theta of 0, since its joint is a yaw hinge, is wanted, found 5 degrees"),
        (
            (PITCH, BALL),
            (10, 5, 0),
            "limb 1: a psi of 0, since its joint is a pitch hinge, is wanted, found 10 degrees",
        ),
        (
            (dataclasses.replace(YAW, psi_deg=(-90.0, 60.0)), BALL),
            (75, 0, 0),
            "limb 1: a psi from -90 to 60 degrees is wanted, found 75 degrees, 15 degrees out of its range",
        ),
    )
    for joints, angles, message in cases:
        bent, swimmer = Configuration.from_angles(limb1_euler_deg=angles), Swimmer(joints=joints)
        for start, goal, name in ((bent, Configuration(), "start"), (Configuration(), bent, "goal")):
            with pytest.raises(ParameterError, match=f"{name}: {message}"):
                plan(start, goal, swimmer=swimmer)


def test_a_goal_out_of_reach_of_the_joints_is_refused_with_the_coordinate_and_how_far() -> None:
    planar, fixed = Swimmer(joints=(YAW, YAW)), Swimmer(joints=(UNIVERSAL, FIXED))
    cases = (
        (planar, Configuration.from_angles(position_m=(0.1, 0, 0.02)), "x-y plane.*found its z off by 0.02 m"),
        (planar, Configuration.from_angles(base_euler_deg=(0, 0, 5)), "x-y plane.*found its roll off by 5 degrees"),
        (
            Swimmer(joints=(PITCH, PITCH)),
            Configuration.from_angles(position_m=(0, 0.02, 0)),
            "x-z plane.*y off by 0.02 m",
        ),
        (
            fixed,
            Configuration.from_angles(limb2_euler_deg=(3, 0, 0)),
            "limb 2: the start's orientation.*found one 3 degrees",
        ),
    )
    for swimmer, goal, message in cases:
        with pytest.raises(ParameterError, match=message):
            plan(Configuration(), goal, swimmer=swimmer)


def test_joints_that_cannot_move_the_base_are_refused_with_the_directions() -> None:
    goal = Configuration.from_angles(position_m=(0.01, 0, 0))
    for joints, named in (
        ((YAW, FIXED), "surge, sway, heave, roll, pitch, yaw"),
        ((UNIVERSAL, FIXED), "surge, sway, heave, pitch"),
    ):
        with pytest.raises(ParameterError, match=f"do not move it, or hardly, in: {named}"):
            plan(Configuration(), goal, swimmer=Swimmer(joints=joints))


def test_a_gait_that_a_joint_cannot_play_says_so(run: Run) -> None:
    gaits, paper = stored_gaits(), Swimmer()
    playable = {
        name
        for name in ("x-motion", "y-motion", "z-motion", "z-rotation", "x-rotation")
        for stroke in [realise(gaits[name], paper)]
        if _plays(Swimmer(joints=(YAW, YAW)), stroke)
    }
    assert playable == {"x-motion", "y-motion", "z-rotation"}
    universal = Swimmer(joints=(UNIVERSAL, UNIVERSAL))
    assert _plays(universal, realise(gaits["z-motion"], paper))
    narrow = Swimmer(joints=(dataclasses.replace(YAW, psi_deg=(-30.0, 30.0)), YAW))
    with pytest.raises(ParameterError, match=r"limb 1's psi, 27\.3 degrees out of its own"):
        refuse_joints(narrow, realise(gaits["x-motion"], paper))
    code, _, err = run("gait", "z-motion", "--swimmer", "planar")
    assert (code, "limb 1 on a yaw hinge, which does not pitch" in err) == (MISUSE, True)
    # This one yaws both limbs faster than it pitches them.
    with pytest.raises(ParameterError, match=r"limb 1 on a yaw hinge, which does not (roll|pitch)"):
        refuse_joints(Swimmer(joints=(YAW, PITCH)), realise(gaits["y-across"], paper))


def test_ranges_hold_over_all_cycles_of_a_gait_that_does_not_close(run: Run) -> None:
    """Two cycles, the foil, stay in them."""
    Path("own").mkdir()
    Path("own/open.yaml").write_text(
        "name: open\nsummary: it leaves a limb bent\nmoves: none\ncycle:\n  - limb1 yaw: a\n"
        "amplitude: {symbol: a, means: bend of a cycle, default_rad: 0.4}\n"
    )
    Path("narrow.yaml").write_text("joints: {limb1: {kind: hinge, axis: yaw, range_deg: [-57, 57]}}\n")
    played = "gait", "open", "--gaits", "own", "--swimmer", "narrow.yaml", "--out", "open.csv"
    assert run(*played, "--cycles", "2")[0] == 0
    Path("open.csv").unlink()
    code, _, err = run(*played, "--cycles", "3")
    assert (code, Path("open.csv").exists()) == (MISUSE, False)
    assert "limb 1's psi, 11.75 degrees out of its own" in err


def _plays(swimmer: Swimmer, stroke: object) -> bool:
    try:
        refuse_joints(swimmer, stroke)  # type: ignore[arg-type]
    except ParameterError:
        return False
    return True


# Limits and verification


def test_limits_know_axes_and_ranges_at_every_instant() -> None:
    narrow = dataclasses.replace(YAW, psi_deg=(-30.0, 30.0))
    there = PrimitiveSequence.of([("limb1 yaw", 0.6), ("limb1 yaw", -0.6)])
    (broken,) = check(Swimmer(joints=(narrow, BALL)), Configuration(), [Block(2, "any", there)]).violations
    assert (broken.limit, broken.phase, broken.what) == ("range", 2, "limb 1's psi")
    assert_close([broken.excess, broken.time_s], [0.6 - math.radians(30), 0.6], 1e-12)
    (broken,) = check(Swimmer(joints=(PITCH, BALL)), Configuration(), [Block(2, "any", there)]).violations
    assert (broken.limit, broken.what) == ("joint", "limb 1 on its pitch hinge")
    assert check(Swimmer(joints=(YAW, BALL)), Configuration(), [Block(2, "any", there)]).kept


def test_verification_finds_axes_ranges_and_rates_that_joints_have_not() -> None:
    loop = PrimitiveSequence.of([(6, 0.6), (1, 0.5), (6, -0.6), (1, -0.5)])
    free = Swimmer(joints=(UNIVERSAL, UNIVERSAL))
    rows = sample(free, Configuration(), [Block(2, "any", loop)])
    narrow = dataclasses.replace(UNIVERSAL, theta_deg=(-45.0, 20.0))
    slow = dataclasses.replace(UNIVERSAL, rate_rad_s=0.9)
    for joints, message in (
        ((UNIVERSAL, UNIVERSAL), ""),
        ((narrow, UNIVERSAL), "limb 1's theta is 20.0535 degrees, out of -45 to 20"),
        ((YAW, UNIVERSAL), "about an axis that its yaw hinge has not"),
        ((slow, UNIVERSAL), "a joint turns at 1 rad/s, more than 0.9"),
    ):
        found = verify([as_table(rows)], Configuration(), rows.end, Swimmer(joints=joints), 1e-9, 1e-9)
        assert [message in fault for fault in found.faults] == ([True] if message else [])


@pytest.mark.parametrize(("joint", "kept"), [(UNIVERSAL, False), (BALL, True)], ids=["universal", "ball"])
def test_psi_and_theta_at_once_leave_a_universal_joint_within_a_row(joint: Joint, kept: bool) -> None:
    # Where the row begins both axes are the joint's; from then on they turn against each other.
    both = MoveSequence.of_turns([[0.0, 0.3, 0.2, 0.0, 0.0, 0.0]])
    one = MoveSequence.of_turns([[0.0, 0.0, 0.3, 0.0, 0.2, 0.0]])
    swimmer = Swimmer(joints=(joint, UNIVERSAL))
    assert check(swimmer, Configuration(), [Block(2, "any", one)]).kept
    report = check(swimmer, Configuration(), [Block(2, "any", both)])
    assert [v.limit for v in report.violations] == ([] if kept else ["joint"])


# Pace


@pytest.mark.parametrize("joint", [YAW, UNIVERSAL, BALL], ids=lambda joint: joint.kind)
def test_ramps_keep_the_path_and_the_acceleration(joint: Joint) -> None:
    slow = Swimmer(joints=(dataclasses.replace(joint, rate_rad_s=0.5), joint), joint_acceleration_rad_s2=3.0)
    yaw = 6 if joint.kind == "universal" else 2
    loop = PrimitiveSequence.of(
        [(yaw, 0.6), (yaw + (1 if yaw == 6 else 3), 0.2), (yaw, -0.6), (yaw + (1 if yaw == 6 else 3), -0.2)]
    )
    blocks = [Block(2, "any", loop, 3)]
    plain, ramped = (sample(*made) for made in ((Swimmer(), Configuration(), blocks), _paced(slow, blocks)))
    assert_close(ramped.end.pose, plain.end.pose, 1e-13)
    levels = ramped.rate_rad_s
    changes = np.flatnonzero(np.any(np.abs(np.diff(levels, axis=0)) > 1e-12, axis=1)) + 1
    times, rates = np.append(0.0, ramped.time_s[changes]), np.concatenate([levels[:1], levels[changes]])
    middles = times[:-1] + 0.5 * np.diff(times)
    found = np.max(np.abs(np.diff(rates[:-1], axis=0)), axis=1) / np.diff(middles)
    assert_close(np.max(found), 3.0, 1e-6)
    assert_close(np.max(np.abs(levels[:, :3])), 0.5, 1e-9)
    # Both limbs rest at every switch: 0.2 rad at 3 rad/s^2 is a triangle, 0.6 rad at 0.5 rad/s a trapezoid.
    assert_close(ramped.time_s[-1], 6 * (0.6 / 0.5 + 0.5 / 3.0) + 6 * 2 * math.sqrt(0.2 / 3.0), 1e-9)
    found = verify([as_table(ramped)], Configuration(), plain.end, slow, 1e-9, 1e-9)
    assert found.holds


def _paced(swimmer: Swimmer, blocks: list[Block]) -> tuple[Swimmer, Configuration, tuple[Block, ...]]:
    pace, made = paced(swimmer, COLLINEAR, blocks)
    return pace, Configuration(), made


@pytest.mark.slow
def test_plans_count_rates_and_ramps_and_read_back(tmp_path: Path) -> None:
    goal = Configuration.from_angles(position_m=(0.02, 0.01, 0), base_euler_deg=(5, 0, 0))
    quick = PlanOptions(effort=Effort.QUICK)
    plain = plan(Configuration(), goal, swimmer=Swimmer(joints=(YAW, YAW)), options=quick)
    swimmer = Swimmer(joints=(YAW, dataclasses.replace(YAW, rate_rad_s=0.25)), joint_acceleration_rad_s2=2.0)
    slow = plan(Configuration(), goal, swimmer=swimmer, options=quick)
    assert plain.verdict == slow.verdict == Verdict.REACHED
    assert slow.joint_travel_rad == plain.joint_travel_rad
    assert slow.duration_s > 2.0 * plain.duration_s
    assert_close(slow.trajectory.time_s[-1], slow.duration_s, 1e-9)
    write_plan(PlanDocument(slow.plan, slow.options), tmp_path / "plan.json")
    again = load_plan(tmp_path / "plan.json")
    assert again.plan.swimmer == swimmer
    assert np.array_equal(carried_out(again.plan, again.options).trajectory.rate_rad_s, slow.trajectory.rate_rad_s)


# Brackets

GROWTH = {
    (BALL, BALL): (6, 10, 12),
    (BALL, UNIVERSAL): (5, 9, 11),
    (BALL, YAW): (4, 8, 10),
    (UNIVERSAL, UNIVERSAL): (4, 6, 10),
    (UNIVERSAL, YAW): (3, 5, 9),
    (UNIVERSAL, PITCH): (3, 5, 9),
    (YAW, YAW): (2, 3, 5),
    (PITCH, PITCH): (2, 3, 5),
    (YAW, PITCH): (2, 3, 5, 6, 8),
    (UNIVERSAL, FIXED): (2, 3, 5, 5, 7, 8),
    (YAW, FIXED): (1, 1, 1, 1, 1, 1),
}
"""The growth vectors at the collinear shape, to depth 6 of one or two controls and 4 of more."""


@pytest.mark.parametrize("joints", GROWTH, ids=lambda joints: " and ".join(joint.name for joint in joints))
def test_growth_vectors_by_joints(joints: tuple[Joint, Joint]) -> None:
    swimmer = Swimmer(joints=joints)
    assert controllability(swimmer, COLLINEAR, 6 if len(swimmer.controls) < 3 else 4).growth == GROWTH[joints]


def test_yaw_hinges_have_the_brackets_of_the_planar_swimmer() -> None:
    shape = np.stack([limb_at(0.5, 0.0), limb_at(-0.8, 0.0)])
    found = controllability(Swimmer(joints=(YAW, YAW)), shape)
    wanted = controllability(Swimmer(), shape, planar=True)
    for one, other in zip(found.brackets, wanted.brackets, strict=True):
        assert one.word == other.word
        assert_close(one.twist, other.twist, 1e-9, float(np.max(np.abs(other.twist))))


def test_the_bracket_of_psi_and_theta_is_the_small_loop_of_them() -> None:
    swimmer, shape = Swimmer(joints=(UNIVERSAL, FIXED)), np.stack([limb_at(0.3, -0.4), np.eye(3)])
    side = 1e-3
    loop = PrimitiveSequence.of([(1, side), (6, side), (1, -side), (6, -side)])
    wanted = se3.log(flow(UNIT, loop, shape)) / side**2
    around = joint_frame(swimmer, shape, 1)
    (twist,) = (
        f.twist[0, 0]
        for f in [around.brackets(around.fields, 1)]
        for k in [f.words.index((1, 2))]
        for f in [dataclasses.replace(f, twist=f.twist[:, k : k + 1])]
    )
    assert_close(twist, wanted, 2e-2, float(np.max(np.abs(wanted))))
    own = frame(swimmer, shape, 1)
    k = (both := own.brackets(own.fields, 1)).words.index((1, 2))
    assert not is_close(both.twist[0, k], wanted, 2e-2, float(np.max(np.abs(wanted))))


def test_only_joints_that_move_the_base_in_every_direction_are_strong() -> None:
    straight = COLLINEAR.tobytes()
    assert weak_directions(Swimmer(joints=(YAW, PITCH)).scaled(), straight) == ()
    assert "surge" in weak_directions(Swimmer(joints=(UNIVERSAL, FIXED)).scaled(), straight)


def test_brackets_are_looked_at_as_deep_as_few_joints_want() -> None:
    """At 4, as ball joints have it, crossed hinges miss two directions; see the table of controllability."""
    depths = {(): 4, (YAW, PITCH): 6, (UNIVERSAL, FIXED): 6, (Joint(), FIXED): 5, (UNIVERSAL, UNIVERSAL): 4}
    for joints, depth in depths.items():
        swimmer = Swimmer(joints=joints) if joints else Swimmer()
        assert usual_depth(swimmer) == depth
        assert usual_depth(dataclasses.replace(swimmer, fluid="beads")) == depth


def test_one_hinge_alone_has_no_brackets_and_is_told_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "swimmer.yaml").write_text("joints: {limb1: hinge, limb2: fixed}")
    run = runner(capsys, "controllability", "--swimmer", str(tmp_path / "swimmer.yaml"))
    code, out, err = run()
    assert (code, err) == (1, "")
    assert "growth vector (1, 1, 1, 1, 1, 1) of 7" in out
    assert "not seen up to depth 6: 6 directions are missing" in out
    assert json.loads(run("--json", "--depth", "2")[1])["depths"][0]["gap"] is None


def test_a_ball_joint_is_strong_wherever_the_limb_beside_it_is_fixed(monkeypatch: pytest.MonkeyPatch) -> None:
    """One shape of the ball joint alone (the foil) is weak by chance beside limbs that are fixed to some side."""
    swimmer = Swimmer(joints=(Joint(), FIXED)).scaled()
    over, thin = (
        np.stack([np.eye(3), Rotation.from_euler("XY", [180, bend], degrees=True).as_matrix()]) for bend in (45, 15)
    )
    assert weak_directions(swimmer, over.tobytes()) == ()
    assert weak_directions(swimmer, thin.tobytes()) != ()
    monkeypatch.setattr("purcell_cli.lie_brackets.joint_reach._BENT_RAD", ((0.6, 0.4),))
    assert "sway" in weak_directions.__wrapped__(swimmer, over.tobytes())


def test_plans_for_ball_joints_written_as_such_are_the_papers() -> None:
    shape = from_euler([0.1, 0.2, 0.3])
    assert Swimmer(joints=(Joint("ball"), Joint("ball"))) == Swimmer()
    assert Pieces.of(PrimitiveSequence.of([(2, 0.1)]), np.stack([shape, shape])).rates.tolist() == [[0, 0, 1, 0, 0, 0]]
