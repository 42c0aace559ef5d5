"""Links that feel each other's flow: published numbers, laws of Stokes flow, the table, and exact plans."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from helpers import (
    COLLINEAR,
    PITCH_1,
    YAW_1,
    YAW_2,
    assert_close,
    flown,
    in_lengths,
    is_close,
    missed,
    random_shapes,
    read_table,
    resistance,
)
from reference import beads as by_numpy

from purcell_cli import load_scenario, plan, stored_scenarios, user_cache
from purcell_cli.cli.reports.plan import plan_document
from purcell_cli.errors import ParameterError
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, about_axis, as_euler, from_quaternion
from purcell_cli.kernel.beads import NUMBERS, bead_resistance, looked_up, swimmer_numbers
from purcell_cli.mechanics import bead_table
from purcell_cli.mechanics.base_velocity import kernel_numbers
from purcell_cli.mechanics.beads import LOWER, Beads, grand_resistance, solved_anew
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.connection import connection, power, resistance_and_coupling, shape_from_angles
from purcell_cli.mechanics.drag import LinkSize, LinkSizes
from purcell_cli.mechanics.lift import flow, work
from purcell_cli.mechanics.lift_derivatives import flow_and_jacobian, flow_and_jacobian_of_moves
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.missions import plan_mission
from purcell_cli.motion.mission import Mission, Waypoint
from purcell_cli.motion.trajectory import as_table
from purcell_cli.verification.verify import verify

STOUT = Swimmer(slenderness=0.05, fluid="beads")
"""Ten beads a link: its table is made in a second."""
ALONE = dataclasses.replace(STOUT, fluid="local")
of = PrimitiveSequence.of


@pytest.fixture(scope="module", autouse=True)
def cache(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Keep tables in a folder of the tests, not in the user's."""
    with pytest.MonkeyPatch.context() as patch:
        place = tmp_path_factory.mktemp("cache")
        patch.setattr(user_cache, "folder", lambda: place)
        yield


def loop(a: float, b: float, first: int = YAW_1, second: int = YAW_2) -> PrimitiveSequence:
    """Return the rectangle: one control by a, another by b, and both back."""
    return of([(first, a), (second, b), (first, -a), (second, -b)])


def bent_shapes(rng: np.random.Generator, most: float, count: int) -> Array:
    """Return shapes with limbs bent at random, up to so much [rad], and rolled. Shape (count, 2, 3, 3)."""
    out = np.empty((count, 2, 3, 3))
    for k in range(count):
        for limb in (0, 1):
            aside, roll = rng.uniform(-math.pi, math.pi, 2)
            bend = about_axis(2, rng.uniform(0.0, most))
            out[k, limb] = about_axis(0, aside) @ bend @ about_axis(0, roll)
    return out


# --- Against numbers from elsewhere --------------------------------------------------------------------------------


@pytest.mark.parametrize("row", read_table("bead_connection_points.csv"))
def test_the_connection_is_that_of_the_published_points(row: dict[str, str]) -> None:
    number = {name: float(value) for name, value in row.items()}
    swimmer = Swimmer(number["base_m"], number["limb_m"], number["slenderness"], fluid="beads")
    shape = from_quaternion(np.array([[number[f"l{i}_q{c}"] for c in "wxyz"] for i in (1, 2)]))
    wanted = np.array([[number[f"A{i}{j}"] for j in range(1, 7)] for i in range(1, 7)])
    assert len(Beads.of(swimmer).link) == 3 * int(number["beads_per_link"])
    assert_close(connection(swimmer, shape), wanted, 1e-12)
    assert not is_close(connection(dataclasses.replace(swimmer, fluid="local"), shape), wanted, 1e-3)


@pytest.mark.parametrize(
    "row",
    [
        pytest.param(row, marks=[] if row["slenderness"] == "0.05" else pytest.mark.slow)
        for row in read_table("bead_strokes.csv")
    ],
)
def test_cycles_are_the_published_ones(row: dict[str, str]) -> None:
    """By the table, in both models; the largest bend is 1 rad."""
    swimmer = Swimmer(slenderness=float(row["slenderness"]), fluid=row["model"])
    start = shape_from_angles(*((math.degrees(float(row[f"yaw{i}_rad"])), 0, 0) for i in (1, 2)))
    moves = [move.split(":") for move in row["moves"].split()]
    sequence = of([(3 * (int(limb) - 1) + "xyz".index(axis), float(angle)) for limb, axis, angle in moves])
    found = flow(swimmer, sequence, start)
    wanted = [float(row[name]) for name in ("x_over_L", "y_over_L", "z_over_L", "psi_rad", "theta_rad", "phi_rad")]
    assert_close([*(found[:3, 3] / swimmer.length_m), *as_euler(found[:3, :3])], np.array(wanted), 5e-9)


@pytest.mark.parametrize(
    ("slenderness", "along", "across", "turn"),
    [(0.01, 1.62157167, 2.53407760, 0.29194350), (0.05, 2.69971477, 3.73793094, 0.506037831)],
)
def test_a_rod_of_touching_beads_drags_as_published(
    slenderness: float, along: float, across: float, turn: float
) -> None:
    """Per unit viscosity, for a full length of 1."""
    beads = Beads.of(Swimmer(0.5, 0.5, slenderness))
    base = beads.link == 0
    place = np.zeros((int(base.sum()), 3))
    place[:, 0] = beads.along[base]
    entries = bead_resistance(place, 0.0 * place, beads.radius[base], beads.link[base])
    found = {pair: value for *pair_, value in zip(*LOWER, entries, strict=True) for pair in [tuple(pair_)]}
    assert_close([found[k, k] for k in (0, 1, 2, 4, 5)], np.array([along, across, across, turn, turn]), 1e-8)
    assert found[3, 3] < 1e-12, "beads feel forces only"


# --- The kernel against numpy --------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(20))
def test_a_resistance_is_that_of_numpy(seed: int) -> None:
    """Beads of unequal radii, overlapping and inside one another too."""
    rng = np.random.default_rng(seed)
    place, radius = rng.normal(size=(24, 3)), rng.uniform(0.02, 0.6, 24)
    link = rng.integers(0, 3, 24)
    arm = rng.normal(size=(24, 3))
    gap = np.linalg.norm(place[:, None] - place, axis=-1)[np.triu_indices(24, 1)]
    sums, apart = ((radius[:, None] + s * radius)[np.triu_indices(24, 1)] for s in (1.0, -1.0))
    assert np.any(gap > sums)
    assert np.any((gap < sums) & (gap > abs(apart)))
    wanted = by_numpy.resistance(place, arm, radius, link)
    found = bead_resistance(place, arm, radius, link)
    assert np.max(np.abs(found - wanted[LOWER])) < 1e-11 * np.max(np.abs(wanted))


def test_bad_arrays_are_refused() -> None:
    place = np.zeros((2, 3))
    with pytest.raises(ValueError, match="positive definite"):
        bead_resistance(place, place, np.ones(2), np.zeros(2, dtype=np.int64))  # one in the same place as the other
    with pytest.raises(ValueError, match="link and radius"):
        bead_resistance(place, place, np.ones(2), np.array([0, 3]))
    with pytest.raises(ValueError, match="link and radius"):
        bead_resistance(place, place, np.array([1.0, 0.0]), np.array([0, 1]))
    numbers = kernel_numbers(STOUT)
    for wrong in (numbers[:-1], numbers[:22], np.append(numbers, 0.0)):
        with pytest.raises(ValueError, match="swimmer"):
            swimmer_numbers(wrong)
    huge = numbers.copy()
    huge[22] = 1e9
    with pytest.raises(ValueError, match="swimmer"):
        swimmer_numbers(huge)
    with pytest.raises(ValueError, match="table"):
        looked_up(kernel_numbers(ALONE), np.zeros((1, 2, 3)))


# --- Laws ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(5))
def test_the_resistance_is_positive_definite_and_the_power_is_that_of_the_torques(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape, rate = random_shapes(rng), rng.normal(size=6)
    p = resistance(STOUT, shape)
    assert_close(p, p.T, 1e-12)
    assert np.linalg.eigvalsh(p)[0] > 0.0
    assert power(STOUT, shape, rate) > 0.0
    angles = 0.3 * rng.normal(size=6)
    sequence = PrimitiveSequence(np.arange(6), angles)
    start = bent_shapes(rng, 0.2, 1)[0]
    # The work of one primitive, from the power of the beads themselves, by Simpson's rule.
    rates = sequence.rates()[:1]
    parts = np.linspace(0.0, abs(angles[0]), 9)
    shapes = [PrimitiveSequence(np.zeros(1, dtype=np.int64), rates[:, 0] * t).shapes(start)[-1] for t in parts]
    values = np.array([float(power(STOUT, one, rates[0])) for one in shapes])
    simpson = (parts[1] / 3.0) * (values[0] + values[-1] + 4.0 * values[1::2].sum() + 2.0 * values[2:-1:2].sum())
    assert_close(work(STOUT, sequence, start)[0], simpson, 1e-7, simpson)


def test_the_gap_to_links_alone_falls_as_the_logarithm_of_the_slenderness() -> None:
    """Times ln(1/s) it tends to a constant; without, it does not."""
    shape = shape_from_angles((40, 20, 0), (-30, 10, 0))
    gaps = {}
    for slenderness in (0.04, 0.02, 0.01, 0.005):
        beads = Swimmer(slenderness=slenderness, fluid="beads")
        apart = resistance(beads, shape) - resistance(dataclasses.replace(beads, fluid="local"), shape)
        gaps[slenderness] = np.linalg.norm(apart[:3, :3]) / np.linalg.norm(resistance(beads, shape)[:3, :3])
    scaled = [gap * math.log(1.0 / s) for s, gap in gaps.items()]
    changes = np.abs(np.diff(scaled)) / scaled[-1]
    assert changes[-1] < 0.04
    assert gaps[0.005] < 0.8 * gaps[0.04]


def test_beads_far_apart_move_each_other_by_the_flow_of_a_point_force() -> None:
    """Oseen's flow, with errors of the square of radius over distance; nearer it does not hold."""

    def error(distance: float) -> float:
        place = np.array([[0.0, 0.0, 0.0], [distance, 0.0, 0.0]])
        mobility = by_numpy.mobility(place, np.ones(2))
        oseen = np.diag([2.0, 1.0, 1.0]) / (8.0 * math.pi * distance)
        return float(np.max(np.abs(mobility[:3, 3:] - oseen)) / np.max(oseen))

    assert error(100.0) < 1e-4
    assert error(2.0) > 0.1
    assert_close(error(50.0) / error(100.0), 4.0, 1e-6)


def test_a_stroke_and_its_way_back_move_nothing() -> None:
    """The scallop theorem; a loop is the foil."""
    there = of([(YAW_1, 0.7), (YAW_2, -0.4), (PITCH_1, 0.3)])
    assert_close(in_lengths(STOUT, flow(STOUT, there + there.inverse())), np.eye(4), 1e-11)
    assert not is_close(in_lengths(STOUT, flow(STOUT, loop(0.7, -0.4))), np.eye(4), 1e-3)


def test_mirror_and_end_for_end_symmetry() -> None:
    """Mirrored in the x-y plane yaw stays and pitch changes its sign; turned end for end the limbs change places."""
    sequence = of([(YAW_1, 0.5), (PITCH_1, 0.4), (YAW_2, -0.7), (YAW_1, -0.2)])
    mirror = np.diag([1.0, 1.0, -1.0, 1.0])
    mirrored = sequence.with_angles(sequence.angle * np.where(sequence.control == PITCH_1, -1.0, 1.0))
    found = flow(STOUT, sequence)
    assert_close(flow(STOUT, mirrored), mirror @ found @ mirror, 1e-12)
    turned = PrimitiveSequence((sequence.control + 3) % 6, sequence.angle * np.where(sequence.control % 3 == 2, 1, -1))
    half_turn = se3.pose(about_axis(2, math.pi), np.zeros(3))
    assert_close(flow(STOUT, turned), half_turn @ found @ half_turn.T, 1e-12)
    assert not is_close(flow(STOUT, turned), found, 1e-4)


def test_the_viscosity_and_the_size_change_no_path() -> None:
    sequence, start = loop(0.6, -0.5), shape_from_angles((20, 10, 0), (5, -15, 0))
    wanted = flow(STOUT, sequence, start)
    assert_close(flow(dataclasses.replace(STOUT, viscosity_pa_s=3.0), sequence, start), wanted, 1e-12)
    longer = dataclasses.replace(STOUT, base_half_length_m=0.2, limb_half_length_m=0.2)
    assert_close(in_lengths(longer, flow(longer, sequence, start)), in_lengths(STOUT, wanted), 1e-12)


# --- The table -----------------------------------------------------------------------------------------------------


def connection_error(most: float) -> float:
    """Return by how much the table's twists are off those of the beads at some shapes."""
    shapes = bent_shapes(np.random.default_rng(3), most, 30)
    unit, off = STOUT.scaled(), 0.0
    for shape, entries in zip(shapes, bead_table.tabulated(unit, shapes[..., 0]), strict=True):
        wanted, found = grand_resistance(unit, shape[..., 0]), np.empty((12, 12))
        found[LOWER] = found[LOWER[::-1]] = entries
        twists = [np.linalg.solve(g[:6, :6], g[:6, 6:]) for g in (wanted, found)]
        off = max(off, float(np.max(np.abs(twists[1] - twists[0]))))
    return off


def test_the_table_is_the_beads_to_many_digits(monkeypatch: pytest.MonkeyPatch) -> None:
    """A table of fewer polynomials is the foil."""
    assert connection_error(1.0) < 3e-12
    assert connection_error(1.3) < 2e-10
    assert connection_error(1.6) < 5e-8
    axes = bent_shapes(np.random.default_rng(3), 1.0, 30)[..., 0]
    monkeypatch.setattr(bead_table, "FINE", [bead_table.Grid(many_bends=7)])
    off = connection_error(1.0)
    assert off > 1e-9
    assert_close(bead_table.table_error(STOUT, axes) / off, 1.0, 1e-4)


def test_a_swimmer_has_one_table_whatever_its_size(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another slenderness, the foil, has another."""
    made: list[str] = []

    def told(_name: str, key: str, _make: object) -> Array:
        made.append(key)
        return np.zeros(1)

    monkeypatch.setattr(bead_table, "kept", told)
    monkeypatch.setattr(bead_table, "_known", {})
    uneven = Swimmer(0.1, 0.07, fluid="beads", slenderness=0.05, links=LinkSizes(limb2=LinkSize(0.06, 0.1)))
    for k, swimmer in enumerate((STOUT, uneven), 1):
        longer = dataclasses.replace(swimmer, viscosity_pa_s=2.0, max_bend_rad=1.3)
        for same in (swimmer, swimmer.scaled(), swimmer.scaled().scaled(), longer):
            bead_table.bead_tables(same)
        assert len(made) == k
    bead_table.bead_tables(dataclasses.replace(STOUT, slenderness=0.0501))
    assert len(made) == 3


@pytest.mark.parametrize(
    "uneven",
    [
        Swimmer(0.1, 0.07, fluid="beads", slenderness=0.125),
        Swimmer(0.07, 0.1, fluid="beads", slenderness=0.125),
        Swimmer(fluid="beads", slenderness=0.125, links=LinkSizes(LinkSize(0.08, 0.1))),
        Swimmer(fluid="beads", slenderness=0.125, links=LinkSizes(limb1=LinkSize(0.08))),
        Swimmer(fluid="beads", slenderness=0.125, links=LinkSizes(LinkSize(0.12), LinkSize(0.08), LinkSize(0.1, 0.1))),
    ],
    ids=["short limbs", "long limbs", "base", "limb 1", "all links"],
)
def test_links_of_unequal_sizes_have_a_table_of_their_own_sizes(uneven: Swimmer) -> None:
    """That of the same links in another order, the foil, is another swimmer's."""
    axes = np.stack([shape_from_angles((30, 12, 0), (-22, 9, 0)), shape_from_angles((-5, 40, 0), (50, 3, 0))])[..., 0]
    assert bead_table.table_error(uneven, axes) < 1e-9
    unit = uneven.scaled()
    other = LinkSizes(*(LinkSize(unit.halves_m[k], unit.slenderness_of(k)) for k in (1, 2, 0)))
    found = bead_table.tabulated(dataclasses.replace(unit, limb_half_length_m=1.0, links=other), axes)
    wanted = solved_anew(unit, axes)
    assert not is_close(found, wanted, 1e-2, float(np.abs(wanted).max()))


@pytest.mark.parametrize("slenderness", [0.08, 0.15, 0.2])
def test_spheres_with_gaps_between_them_are_less_smooth(slenderness: float) -> None:
    """Beside a bent joint they begin to overlap; ones without gaps, the foil, overlap from the start."""
    turns = [((b, 12, 0), (-b, 20, 0)) for b in (15, 30, 45)]
    axes = np.stack([shape_from_angles(*angles) for angles in turns])[..., 0]
    swimmer = Swimmer(fluid="beads", slenderness=slenderness)
    assert 1e-7 < bead_table.table_error(swimmer, axes) < 6e-6
    fuller = 1.0 / (2.0 * (np.round(1.0 / (2.0 * slenderness)) + 0.9))
    assert bead_table.table_error(dataclasses.replace(swimmer, slenderness=fuller), axes) < 1e-9


def test_small_bends_are_looked_up_in_a_table_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """One too coarse spoils only them, and so does one for all bends, the foil, where the other would serve."""
    fine = connection_error(1.0)
    near, far = bead_table.FINE
    assert near.reach_rad < 1.1
    monkeypatch.setattr(bead_table, "FINE", (bead_table.Grid(near.reach_rad, 5), far))
    assert connection_error(1.0) > 1e4 * fine
    bent = shape_from_angles((60, 0, 0), (10, 5, 0))[None, ..., 0]
    assert bead_table.table_error(STOUT, bent) < 1e-10
    monkeypatch.setattr(bead_table, "FINE", (near, bead_table.Grid(many_bends=5)))
    assert connection_error(1.0) > 1e4 * fine  # it is sampled from the other


def test_bends_beyond_the_table_are_refused() -> None:
    far = shape_from_angles((100, 0, 0), (0, 0, 0))[None, ..., 0]
    with pytest.raises(ParameterError, match=r"1.6 rad, for links that feel each other, are wanted, found 1.745"):
        bead_table.tabulated(STOUT, far)
    bent = Configuration(shape=shape_from_angles((100, 0, 0), (0, 0, 0)))
    for start, goal, called in ((bent, Configuration(), "start"), (Configuration(), bent, "goal")):
        with pytest.raises(ParameterError, match=f"^{called}: limbs bent by at most 1.6 rad.*found 1.745 rad"):
            plan(start, goal, swimmer=STOUT)
        assert plan(start, goal, swimmer=ALONE).verdict == "reached"
    bend = Waypoint(limb1=bent.shape[0])
    with pytest.raises(ParameterError, match=r"^via\[0\]: limbs bent by at most 1.6 rad"):
        plan_mission(Mission(Configuration(), Configuration(), (bend,)), swimmer=STOUT)


@pytest.mark.parametrize("start", [COLLINEAR, shape_from_angles((30, 20, 10), (-10, 25, 0))])
def test_derivatives_are_those_of_differences(start: Array) -> None:
    rng = np.random.default_rng(2)
    sequence = PrimitiveSequence(np.array([2, 5, 1, 0, 4, 3, 2]), rng.uniform(-0.4, 0.4, 7))
    moves = MoveSequence.of_turns(rng.uniform(-0.2, 0.2, (3, 6)))
    _, found = flow_and_jacobian(STOUT, sequence, start)
    _, by_moves = flow_and_jacobian_of_moves(STOUT, moves, start)
    step = 1e-5

    def slope(plus: Array, minus: Array) -> Array:
        return se3.log(se3.inverse(minus) @ plus) / (2.0 * step)

    for k in range(len(sequence)):
        ends = []
        for sign in (1.0, -1.0):
            angle = sequence.angle.copy()
            angle[k] += sign * step
            ends.append(flow(STOUT, sequence.with_angles(angle), start))
        assert_close(found[:, k], slope(*ends), 1e-8)
    for k in range(3):
        for c in range(6):
            ends = []
            for sign in (1.0, -1.0):
                turn = moves.turn.copy()
                turn[k, c] += sign * step
                ends.append(flow(STOUT, MoveSequence.of_turns(turn), start))
            assert_close(by_moves[:, k, c], slope(*ends), 1e-8)
    _, alone = flow_and_jacobian(ALONE, sequence, start)
    assert not is_close(alone, found, 1e-3)


# --- Plans ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", ["limb-rolls", "pitch"])
def test_plans_arrive_exactly_on_the_beads_themselves(name: str) -> None:
    """Plans of links alone are the foil: they miss."""
    scenario = load_scenario(stored_scenarios()[name])
    found = plan(scenario.start, scenario.goal, swimmer=STOUT)
    assert found.verdict == "reached"
    assert 0.0 < plan_document(found, None)["table_error"] < 1e-9
    if name == "limb-rolls":  # the other's rows are many
        table = as_table(found.trajectory)
        checked = verify([table], scenario.start, scenario.goal, STOUT, 1e-7, 1e-7, resistances=solved_anew)
        assert checked.holds
        assert checked.certificate.deviation.position_m < 1e-9 * STOUT.length_m
    wanted = se3.inverse(scenario.start.pose) @ scenario.goal.pose
    alone = plan(scenario.start, scenario.goal, swimmer=ALONE).plan.blocks
    if np.array_equal(scenario.start.shape, COLLINEAR):
        assert missed(wanted, flown(STOUT, found.plan.blocks)) < 1e-11
        assert missed(wanted, flown(STOUT, alone)) > 1e-2


def test_links_of_their_own_sizes_have_beads_of_their_own() -> None:
    """As many as each link's slenderness asks for; seen from behind, the other limb's; single links drag alike."""
    one = Swimmer(fluid="beads", slenderness=0.05, links=LinkSizes(limb2=LinkSize(0.06, 0.1)))
    two = Swimmer(fluid="beads", slenderness=0.05, links=LinkSizes(limb1=LinkSize(0.06, 0.1)))
    assert [int(n) for n in np.bincount(Beads.of(one).link)] == [10, 10, 5]
    half_turn = np.diag([-1.0, -1.0, 1.0])
    shape, rate = shape_from_angles((40, 10, 5), (-25, 3, 9)), np.array([0.3, 0.1, 1.0, -0.2, 0.5, -0.4])
    swapped = np.concatenate([half_turn @ rate[3:], half_turn @ rate[:3]])
    p, other = (resistance(s, r) for s, r in ((one, shape), (two, half_turn @ shape[::-1] @ half_turn)))
    turn = np.kron(np.eye(2), half_turn)
    assert_close(other, turn @ p @ turn, 1e-12, float(np.abs(p).max()))
    xi = -np.linalg.solve(*resistance_and_coupling(one, shape)) @ rate
    seen = -np.linalg.solve(*resistance_and_coupling(two, half_turn @ shape[::-1] @ half_turn)) @ swapped
    assert_close(seen, turn @ xi, 1e-12)
    assert not is_close(seen, xi, 1e-3)


@pytest.mark.slow
def test_the_table_of_unequal_limbs_is_sampled_whole() -> None:
    """By the mirror of equal limbs, the foil, it would be another swimmer's."""
    unit = Swimmer(fluid="beads", slenderness=0.1, links=LinkSizes(limb2=LinkSize(0.06, 0.125))).scaled()
    table = np.concatenate([np.zeros(NUMBERS - 1), bead_table.made_tables(unit)])
    axes = np.stack([shape_from_angles((50, 20, 0), (-30, 9, 0)), shape_from_angles((-5, 70, 0), (80, 3, 0))])[..., 0]
    found, wanted = looked_up(table, axes), solved_anew(unit, axes)
    assert_close(found, wanted, 1e-9, float(np.abs(wanted).max()))
    assert not is_close(looked_up(table, axes[:, ::-1]), wanted, 1e-2)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"slenderness": 0.003}, "slenderness: 0.00333333 to 0.2 .* is wanted, found 0.003"),
        ({"max_bend_rad": 1.7}, "max_bend_rad: 0 to 1.6 .* is wanted, found 1.7"),
        ({"drag": "cylinder"}, "drag: cox, .* is wanted, found cylinder"),
        ({"body_radius_m": 0.02}, "body_radius_m: 0.0, .* is wanted, found 0.02"),
        ({"links": LinkSizes(limb1=LinkSize(None, 0.002))}, "links.limb1.slenderness: 0.00333333 to 0.2"),
        ({"drag_ratio": 1.8}, "drag_ratio: 2 for links that feel each other is wanted, found 1.8"),
        ({"fluid": "water"}, "fluid: one of local, beads is wanted, found 'water'"),
    ],
)
def test_what_beads_cannot_be_is_refused(changed: dict[str, Any], message: str) -> None:
    with pytest.raises(ParameterError, match=message):
        dataclasses.replace(STOUT, **changed)


# --- The cache -----------------------------------------------------------------------------------------------------


def test_what_is_kept_is_made_once_and_made_again_where_the_file_is_damaged() -> None:
    made = []

    def make() -> Array:
        made.append(1)
        return np.arange(5.0)

    assert np.array_equal(user_cache.kept("thing", "a key", make), np.arange(5.0))
    assert np.array_equal(user_cache.kept("thing", "a key", make), np.arange(5.0))
    assert len(made) == 1
    (file,) = user_cache.folder().glob("thing-*.bin")
    whole = file.read_bytes()
    for damaged in (b"", whole[:40], whole[:-1], whole[:50] + b"\0" + whole[51:]):
        file.write_bytes(damaged)
        assert np.array_equal(user_cache.kept("thing", "a key", make), np.arange(5.0))
        assert file.read_bytes() == whole
    assert len(made) == 5
    user_cache.kept("thing", "another key", make)
    assert len(made) == 6
    assert not list(user_cache.folder().glob("*.part"))


def test_where_nothing_can_be_kept_it_is_made_each_time(monkeypatch: pytest.MonkeyPatch, tmp_path) -> None:
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setattr(user_cache, "folder", lambda: tmp_path / "file" / "below")
    assert np.array_equal(user_cache.kept("thing", "key", lambda: np.ones(2)), np.ones(2))
