"""A plane wall without slip: Blake's image, its limits and laws, and swimming, tracking and refusals beside it."""

from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest
from helpers import Run, assert_close, bent, is_close, runner, slope
from reference import beads as by_numpy

from purcell_cli import Configuration, Swimmer, Wall, controllability, plan, write_csv
from purcell_cli.errors import ParameterError
from purcell_cli.feedback.beside_wall import poses_beside, twist_beside
from purcell_cli.feedback.simulate import simulate
from purcell_cli.feedback.track import track
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.beads import bead_resistance
from purcell_cli.lie_brackets import bead_polynomials
from purcell_cli.lie_brackets.bracket_gaits import bracket_gait
from purcell_cli.lie_brackets.control_fields import brackets_by_depth, frame
from purcell_cli.lie_brackets.controllability import Controllability
from purcell_cli.lie_brackets.curvature import bracket_twists
from purcell_cli.mechanics.beads import LOWER, resistance_entries
from purcell_cli.mechanics.connection import base_twist, connection
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.trajectory import as_table, sample
from purcell_cli.motion.trajectory_table import Table

FREE = Swimmer(slenderness=0.1, fluid="beads")
"""Five beads a link."""
BELOW = Wall((0.0, 0.0, -0.05), (0.0, 0.0, 1.0))
"""Half an L below the origin."""
BESIDE = dataclasses.replace(FREE, wall=BELOW)
LIMBS = bent(0.2, 0.5), bent(-0.3, 0.4, 2)
SHAPE = LIMBS[0] @ LIMBS[1]


def swum(*turns: tuple[str, float]) -> Table:
    """Return the motion of some turns from the collinear swimmer at the origin."""
    block = Block(2, "test", PrimitiveSequence.of(turns))
    return as_table(sample(Swimmer(slenderness=0.1), Configuration(), [block], 0.25))


LOOP = ("limb1 yaw", 0.7), ("limb2 pitch", -0.5), ("limb1 yaw", -0.7), ("limb2 pitch", 0.5)


def bead_mobility(height: float, wall: bool = True) -> Array:
    """Return the mobility of one bead of unit radius above z = 0, its own times 6 pi. Shape (3, 3)."""
    place, plane = np.zeros((1, 3)), np.array([0.0, 0.0, 1.0, height])
    entries = bead_resistance(place, place, np.ones(1), np.zeros(1, dtype=np.int64), plane if wall else None)
    full = np.zeros((12, 12))
    full[LOWER] = full[LOWER[::-1]] = entries
    return 6.0 * math.pi * np.linalg.inv(full[:3, :3])


# --- The image -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("height", [1.001, 1.5, 4.0, 100.0])
def test_one_bead_is_slowed_as_swan_and_brady_have_it(height: float) -> None:
    e = 1.0 / height
    along, across = (
        1.0 - 9.0 / 16.0 * e + e**3 / 8.0 - e**5 / 16.0,
        1.0 - 9.0 / 8.0 * e + e**3 / 2.0 - e**5 / 8.0,
    )
    assert_close(bead_mobility(height), np.diag([along, along, across]), 1e-13)
    assert not is_close(bead_mobility(height), np.diag([across, across, along]), 1e-3)


def test_the_wall_fades_as_one_over_the_height() -> None:
    heights = np.array([50.0, 100.0, 200.0])
    for axis, part in ((0, 9.0 / 16.0), (2, 9.0 / 8.0)):
        slowed = np.array([1.0 - bead_mobility(h)[axis, axis] for h in heights])
        assert abs(slope(heights, slowed) + 1.0) < 1e-3
        assert_close(slowed[-1] * heights[-1], part, 1e-4)
    assert_close(bead_mobility(5.0, wall=False), np.eye(3), 1e-14)


def test_the_fluid_does_not_slip_at_the_wall() -> None:
    """The reference's image of a point force; without it the fluid slips."""
    force, at = np.array([0.1, 0.5, 0.7]), np.array([0.3, 0.2, 0.0])
    assert np.max(np.abs(by_numpy.blake(at, force))) < 1e-16
    assert np.max(np.abs(by_numpy.oseen(at - force))) > 1e-2
    assert np.max(np.abs(by_numpy.blake(at + np.array([0.0, 0.0, 0.1]), force))) > 1e-3


@pytest.mark.parametrize("radii", [(0.25, 0.4), (0.4, 0.25), (0.3, 0.3)])
def test_the_image_of_unequal_beads_is_the_average_of_blakes_over_both(radii: tuple[float, float]) -> None:
    """And it is symmetric; a wall whose normal is another is the foil."""
    place, radius = np.array([[0.3, -0.2, 0.9], [1.0, 0.5, 0.6]]), np.array(radii)
    arm, link = np.array([[0.0, 0.0, 0.0], [0.7, -0.4, 0.2]]), np.array([0, 1])
    k = by_numpy.motions(place, arm, link)
    across = by_numpy.averaged_blake(place[0], radii[0], place[1], radii[1])
    back = by_numpy.averaged_blake(place[1], radii[1], place[0], radii[0])
    assert_close(across, back.T, 1e-10)
    own = [
        np.diag(np.diagonal(bead_mobility(p[2] / a))) / (6.0 * math.pi * a) for p, a in zip(place, radii, strict=True)
    ]
    wanted = k.T @ np.linalg.solve(np.block([[own[0], across], [back, own[1]]]), k)
    found = bead_resistance(place, arm, radius, link, np.array([0.0, 0.0, 1.0, 0.0]))
    assert np.max(np.abs(found - wanted[LOWER])) < 1e-8 * np.max(np.abs(wanted))
    tilted = bead_resistance(place, arm, radius, link, np.array([0.6, 0.0, 0.8, 0.3]))
    assert np.max(np.abs(tilted - wanted[LOWER])) > 1e-3 * np.max(np.abs(wanted))


@pytest.mark.parametrize("seed", range(5))
def test_the_resistance_is_positive_definite_and_larger_than_without_a_wall(seed: int) -> None:
    """Beads of neighbouring links overlap; the wall has any direction."""
    rng = np.random.default_rng(seed)
    normal = rng.normal(size=3)
    axes = np.array([[0.8, 0.6, 0.0], [0.6, 0.0, 0.8]])
    unit, beside = FREE.scaled(), np.append(normal / np.linalg.norm(normal), 3.2)
    full, alone = np.zeros((12, 12)), np.zeros((12, 12))
    full[LOWER] = full[LOWER[::-1]] = resistance_entries(unit, axes, beside)
    alone[LOWER] = alone[LOWER[::-1]] = resistance_entries(unit, axes)
    assert np.linalg.eigvalsh(full)[0] > 0.0
    more = np.linalg.eigvalsh((full - alone)[:6, :6])
    assert more[-1] > 1e-3
    assert more[0] > -1e-9


# --- Swimming beside it ----------------------------------------------------------------------------------------------


def test_far_away_it_swims_as_without_and_near_it_does_not() -> None:
    """The motion changes as the second power of the distance: a swimmer exerts no force, but pairs of forces."""
    unit, turning, shape = FREE.scaled(), np.array([[0.3, 0.2, 0.5], [0.1, -0.4, 0.2]]), SHAPE
    rate = np.concatenate([shape[k].T @ turning[k] for k in (0, 1)])
    free = base_twist(unit, shape, rate)
    heights = np.array([20.0, 40.0, 80.0])
    normal = np.array([0.36, 0.48, 0.8])
    off = [np.linalg.norm(twist_beside(unit, shape[..., 0], turning, np.append(normal, h)) - free) for h in heights]
    assert abs(slope(heights, np.array(off)) + 2.0) < 0.1
    near = twist_beside(unit, shape[..., 0], turning, np.append(normal, 3.0))
    assert off[-1] < 2e-5 < 1e-3 < np.linalg.norm(near - free)


def test_a_loop_far_away_ends_where_it_does_without() -> None:
    table = swum(*LOOP)
    free = simulate(table, FREE)
    far, near = (
        simulate(table, dataclasses.replace(FREE, wall=Wall((0.0, 0.0, -z), (0.0, 0.0, 1.0)))) for z in (1e4, 0.05)
    )
    assert_close(far.trajectory.pose, free.trajectory.pose, 3e-9)
    assert np.max(np.abs(near.trajectory.pose - free.trajectory.pose)) > 1e-3


@pytest.mark.parametrize(
    ("g", "kept"),
    [
        (se3.pose(se3.rotation(np.array([0.0, 0.0, 0.7])), [0.3, -0.2, 0.0]), True),
        (se3.pose(se3.rotation(np.array([0.0, 0.1, 0.0])), [0.0, 0.0, 0.03]), False),
        (se3.pose(np.eye(3), [0.0, 0.0, 0.1]), False),
    ],
    ids=["along the wall", "tilted", "away from it"],
)
def test_only_motions_along_the_wall_change_nothing(g: Array, kept: bool) -> None:
    """And all change nothing where the wall goes along."""
    table = swum(*LOOP)
    here = simulate(table, BESIDE).end.pose
    there = simulate(table, BESIDE, begun=g)
    assert is_close(there.end.pose, g @ here, 1e-8) == kept
    moved = Wall(tuple(g[:3, :3] @ BELOW.point_m + g[:3, 3]), tuple(g[:3, :3] @ BELOW.normal))
    assert_close(simulate(table, dataclasses.replace(FREE, wall=moved), begun=g).end.pose, g @ here, 1e-8)


def test_a_mirrored_motion_is_mirrored() -> None:
    """In the x-z plane, which is square to the wall; in the x-y plane, which is not, the foil."""
    there = swum(("limb1 yaw", 0.7), ("limb2 pitch", -0.5), ("limb1 yaw", -0.7))
    across = swum(("limb1 yaw", -0.7), ("limb2 pitch", -0.5), ("limb1 yaw", 0.7))
    within = swum(("limb1 yaw", 0.7), ("limb2 pitch", 0.5), ("limb1 yaw", -0.7))
    found, y, z = (simulate(table, BESIDE).end.pose for table in (there, across, within))
    mirrors = [np.diag([1.0, s, t, 1.0]) for s, t in ((-1.0, 1.0), (1.0, -1.0))]
    assert_close(y, mirrors[0] @ found @ mirrors[0], 1e-8)
    assert not is_close(z, mirrors[1] @ found @ mirrors[1], 1e-4)


def test_a_stroke_and_its_way_back_move_nothing() -> None:
    """The scallop theorem holds beside a wall too; a loop is the foil."""
    there = simulate(swum(("limb1 yaw", 0.7), ("limb2 yaw", 0.4), ("limb2 yaw", -0.4), ("limb1 yaw", -0.7)), BESIDE)
    assert_close(there.end.pose, np.eye(4), 1e-8)
    assert not is_close(simulate(swum(*LOOP), BESIDE).end.pose, np.eye(4), 1e-3)


@pytest.mark.parametrize(
    ("height", "message"),
    [
        (0.019, r"found base at it in row 1 \(0 s\)"),
        (-1.0, r"found base at it in row 1 \(0 s\)"),
        (0.05, r"found limb 1 at it in row [2-9] \(0\.[0-9]+ s\)"),
    ],
)
def test_a_swimmer_that_touches_the_wall_is_told_with_the_row(height: float, message: str) -> None:
    table = swum(("limb1 pitch", 1.2), ("limb1 pitch", -1.2))
    beside = dataclasses.replace(FREE, wall=Wall((0.0, 0.0, -height), (0.0, 0.0, 1.0)))
    with pytest.raises(ParameterError, match=message):
        simulate(table, beside)
    assert simulate(table, dataclasses.replace(FREE, wall=Wall((0, 0, -0.3), (0, 0, 1)))).end is not None


@pytest.mark.slow
def test_a_plan_made_without_the_wall_is_brought_to_its_goal_beside_it() -> None:
    """Two L away from the wall; one plan alone misses."""
    goal = Configuration.from_angles((0.03, 0.0, 0.0))
    model = Swimmer(slenderness=0.1)
    truth = dataclasses.replace(FREE, wall=Wall((0.0, 0.0, -0.2), (0.0, 0.0, 1.0)))
    found = track(Configuration(), goal, truth, model=model)
    assert found.arrived
    assert 1 <= found.replans <= 10
    assert found.off.within(1e-3 * model.length_m, math.radians(0.1))
    alone = found.parts[0].solution
    assert not alone.plan.swimmer.wall
    end = simulate(as_table(alone.trajectory), truth).end
    assert np.linalg.norm(end.pose[:3, 3] - goal.pose[:3, 3]) > 1e-2 * model.length_m


# --- What can be reached beside it -----------------------------------------------------------------------------------


def twists(found: Controllability, depth: int) -> Array:
    """Return the twists of the brackets of a depth. Shape (n, 6)."""
    return np.array([b.twist for b in found.brackets if len(b.word) == depth])


def test_brackets_of_beads_are_those_of_their_table() -> None:
    """The table's derivatives are found in another way; links alone are the foil."""
    found = controllability(FREE, SHAPE, 2)
    by_table = bracket_twists(FREE, SHAPE[None])[0]
    # A bracket of two controls of one limb has that of the limb's rotation besides, which is brought back.
    across = [b for b in found.brackets if b.word[0] < 3 <= b.word[1]]
    assert len(across) == 9
    for bracket in across:
        assert_close(bracket.twist, by_table[bracket.word], 1e-8)
    alone = controllability(dataclasses.replace(FREE, fluid="local"), SHAPE, 2)
    assert not is_close(twists(alone, 2), twists(found, 2), 1e-2)


def test_the_growth_of_beads_is_that_of_links_alone() -> None:
    found = controllability(FREE, depth=3)
    assert (found.growth, found.verdict, found.weak_level) == ((6, 10, 12), "controllable", 2)
    assert [level.rank.robustness for level in found.depths] == ["clear", "clear"]
    planar = controllability(FREE, planar=True)
    assert (planar.growth, planar.verdict) == ((2, 3, 5), "controllable")


def test_a_fit_of_other_reach_leaves_far_less_than_ranks_allow_for(monkeypatch: pytest.MonkeyPatch) -> None:
    unit = FREE.scaled()
    beside = np.array([0.0, 0.6, 0.8, 2.0])
    for wall in (None, beside):
        limit = bead_polynomials.left_of_zero(unit, SHAPE, wall)
        degree = 3 if wall is None else 2
        around = [frame(FREE, SHAPE, degree, beside=wall)]
        with monkeypatch.context() as patch:
            patch.setattr(bead_polynomials, "_REACH_RAD", 0.25)
            patch.setattr(bead_polynomials, "_ROOM", 0.18)
            around.append(frame(FREE, SHAPE, degree, beside=wall))
        found, other = (list(brackets_by_depth(one)) for one in around)
        assert len(found) == degree
        for one, same in zip(found, other, strict=True):
            size = float(np.max(np.abs(one.twist[0])))
            assert 0.0 < np.max(np.abs(one.twist[0] - same.twist[0])) < 0.3 * limit * size


def test_far_from_the_wall_brackets_are_those_without() -> None:
    free = controllability(FREE, SHAPE, 3)
    far, near = (dataclasses.replace(FREE, wall=Wall((0.0, 0.0, -z), (0.0, 0.6, 0.8))) for z in (1e4, 0.2))
    for wall, same in ((far, True), (near, False)):
        found = controllability(wall, SHAPE, 3)
        assert found.growth[0] == 6
        assert is_close(twists(found, 2), twists(free, 2), 1e-7) == same
        assert is_close(twists(found, 3), twists(free, 3), 1e-6) == same
        assert (found.levels, found.weak_level) == ((), None)


@pytest.mark.parametrize("word", [(2, 5), (1, 5), (2, 1, 5)])
def test_a_bracket_beside_the_wall_is_the_motion_of_its_small_gait(word: tuple[int, ...]) -> None:
    """Integrated in the world; without the wall's own derivatives, or without a wall, it would be another."""
    pose = se3.pose(se3.rotation(np.array([0.2, -0.1, 0.3])), [0.0, 0.0, 0.07])
    found = controllability(BESIDE, SHAPE, 3, pose=pose)
    wanted = next(b.twist for b in found.brackets if b.word == word)
    size, depth = 0.03, len(word)
    ends = []
    for sign in (1.0, -1.0):
        gait = bracket_gait(word, sign * size, SHAPE)
        pieces = Pieces.of(gait, SHAPE)
        g = poses_beside(BESIDE, BELOW, pose, pieces, np.zeros(3))[-1]
        g = se3.inverse(pose) @ g
        g[:3, 3] /= BESIDE.length_m
        ends.append(se3.log(g) / (sign * size) ** depth)
    made = 0.5 * (ends[0] + ends[1])  # what is odd in the size falls out
    assert_close(made, wanted, 0.03, float(np.max(np.abs(wanted))))
    free = next(b.twist for b in controllability(FREE, SHAPE, 3).brackets if b.word == word)
    assert not is_close(free, wanted, 0.05, float(np.max(np.abs(wanted))))


# --- The key ---------------------------------------------------------------------------------------------------------


def test_what_a_wall_cannot_be_is_refused() -> None:
    assert Wall((0, 0, 0), (0, 0, 2)) == Wall((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    for point, normal in (
        ((0, 0), (0, 0, 1)),
        ((0, 0, 0), (0, 0, 0)),
        ((0, 0, math.nan), (0, 0, 1)),
        ((0, 0, 1e9), (0, 0, 1)),
    ):
        with pytest.raises(ParameterError, match=r"^(point_m|normal): "):
            Wall(point, normal)  # type: ignore[arg-type]
    with pytest.raises(ParameterError, match="'beads', which a wall goes with"):
        Swimmer(wall=BELOW)


def test_what_rests_on_left_invariance_refuses_a_wall() -> None:
    for action in (
        lambda: plan(Configuration(), Configuration.from_angles((0.01, 0, 0)), swimmer=BESIDE),
        lambda: connection(BESIDE, SHAPE),
        lambda: base_twist(BESIDE, SHAPE, np.ones(6)),
    ):
        with pytest.raises(ParameterError, match="only simulate, track's --truth and controllability know a wall"):
            action()


TRUTH = "slenderness: 0.1\nfluid: beads\nwall: {point_m: [0, 0, -0.05], normal: [0, 0, 3]}\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("truth.yaml").write_text(TRUTH)
    block = Block(2, "test", PrimitiveSequence.of(LOOP))
    write_csv(sample(Swimmer(), Configuration(), [block], 0.25), "plan.csv")
    return tmp_path


@pytest.mark.usefixtures("folder")
def test_simulate_says_beside_what_and_what_touches(capsys: pytest.CaptureFixture[str]) -> None:
    run: Run = runner(capsys, "simulate")
    code, out, _ = run("plan.csv", "--swimmer", "truth.yaml", "--out", "real.csv", "--json")
    document = json.loads(out)
    assert (code, document["swimmer"]["wall"]) == (0, {"point_m": [0.0, 0.0, -0.05], "normal": [0.0, 0.0, 1.0]})
    assert document["off"]["position_over_L"] > 1e-3
    Path("truth.yaml").write_text(TRUTH.replace("-0.05", "-0.021"))
    code, out, error = run("plan.csv", "--swimmer", "truth.yaml", "--out", "other.csv")
    assert (code, out, Path("other.csv").exists()) == (2, "", False)
    assert "at it in row" in error


@pytest.mark.usefixtures("folder")
def test_controllability_says_beside_what(capsys: pytest.CaptureFixture[str]) -> None:
    run: Run = runner(capsys, "controllability", "--swimmer", "truth.yaml", "--depth", "3")
    Path("up.yaml").write_text("base: {position_m: [1, 2, 0.05]}\n")
    code, out, _ = run("--shape", "up.yaml", "--json")
    document = json.loads(out)
    assert (code, document["verdict"], document["growth_vector"]) == (0, "controllable", [6, 11, 12])
    assert document["beside"] == {"height_m": pytest.approx(0.1), "normal": [0.0, 0.0, 1.0]}
    assert (document["filtration"], document["weak_level"]) == ([], None)
    assert {b["trusted_rad"] for part in document["directions"] for b in part["brackets"]} == {None}
    code, out, _ = run("--shape", "up.yaml")
    assert code == 0
    assert "1 L above a wall" in out
    Path("down.yaml").write_text("base: {position_m: [0, 0, -0.04]}\n")
    for more, why in ((("--planar",), "planar"), (("--map",), "without one"), (("--shape", "down.yaml"), "touches")):
        code, out, error = run(*more)
        assert (code, out) == (2, "")
        assert why in error


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    "arguments",
    [
        ("plan", "nearby", "--swimmer", "truth.yaml"),
        ("gait", "x-cruise", "--swimmer", "truth.yaml"),
        ("track", "nearby", "--truth", "truth.yaml", "--swimmer", "truth.yaml"),
        ("verify", "plan.csv", "nearby", "--swimmer", "truth.yaml"),
    ],
)
def test_commands_that_do_not_know_a_wall_say_so(
    capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...]
) -> None:
    code, out, error = runner(capsys, *arguments)()
    assert (code, out) == (2, "")
    assert "wall: a swimmer without one is wanted" in error


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("wall", "why"),
    [
        ("wall: {point_m: [0, 0, 0]}", "normal"),
        ("wall: {point_m: [0, 0], normal: [0, 0, 1]}", ": wall.point_m: wanted"),
        ("wall: {point_m: [0, 0, 0], normal: [0, 0, 0]}", ": wall.normal: wanted"),
        ("wall: {point_m: [0, 0, 0], normal: [0, 0, .nan]}", ": wall.normal[2]: wanted"),
        ("wall: {point: [0, 0, 0], normal: [0, 0, 1]}", "point"),
        ("wall: ceiling", "wall"),
    ],
)
def test_bad_walls_are_told_by_key(capsys: pytest.CaptureFixture[str], wall: str, why: str) -> None:
    Path("truth.yaml").write_text(f"fluid: beads\n{wall}\n")
    code, _, error = runner(capsys, "simulate")("plan.csv", "--swimmer", "truth.yaml")
    assert code == 2
    assert "truth.yaml:2" in error
    assert why in error
    code, out, _ = runner(capsys, "validate")("truth.yaml", "--json")
    assert code != 0
    assert "truth.yaml:2" in out
