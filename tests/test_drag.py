"""Drag laws, measured drags, links of their own sizes and the body: tables, laws of physics, refusals."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest
from helpers import (
    UNIT,
    assert_close,
    dop853_flow,
    in_lengths,
    is_close,
    missed,
    mostly_slow,
    random_sequence,
    random_shapes,
    read_table,
    resistance,
    unequal_swimmer,
)
from scipy.spatial.transform import Rotation

from purcell_cli import (
    Configuration,
    LinkDrag,
    LinkDrags,
    LinkSize,
    LinkSizes,
    Swimmer,
    load_swimmer,
    plan,
    stored_gaits,
)
from purcell_cli.errors import InputError, ParameterError
from purcell_cli.files.swimmer_file import SWIMMER, swimmer_written
from purcell_cli.gaits.pure_stroke import fault, realise
from purcell_cli.geometry.rotations import about_axis
from purcell_cli.mechanics import drag as drags
from purcell_cli.mechanics.base_velocity import base_motion
from purcell_cli.mechanics.connection import COLLINEAR, base_twist, connection, shape_from_angles
from purcell_cli.mechanics.drag import FINITE_RODS, sphere
from purcell_cli.mechanics.lift import flow
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import LIMITS
from purcell_cli.motion.clearance import apart_bend_rad, body_distance, least_clearance
from purcell_cli.motion.limb_circles import bends
from purcell_cli.motion.options import Effort, PlanOptions
from purcell_cli.verification.replay import replay

UNEVEN = Swimmer(links=LinkSizes(limb2=LinkSize(0.08, 0.02)), drag="cylinder")
BODY = Swimmer(drag="spheroid", body_radius_m=0.04)
NUMBERS = Swimmer(
    drag=LinkDrags(LinkDrag(0.13, 0.26, 8.6e-4, 9.6e-6), LinkDrag(0.2, 0.3, 1.2e-3), LinkDrag(across_n_s_per_m=0.6))
)

DISCS = Swimmer(drag=LinkDrags(*(LinkDrag(0.36, 0.3) for _ in range(3))))
"""Links that drag more along their axes than across them."""


# --- Single links ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("row", read_table("rod_drag.csv"), ids=lambda row: f"{row['drag']} {row['slenderness']}")
def test_a_rod_drags_as_tabulated(row: dict[str, str]) -> None:
    """To all digits of the table; with the slenderness taken over the half length, the foil, none agrees."""
    slenderness = float(row["slenderness"])
    swimmer = Swimmer(0.5, 0.5, slenderness, viscosity_pa_s=1.0, drag=row["drag"])
    foil = dataclasses.replace(swimmer, slenderness=2.0 * slenderness)
    for name in ("along", "across", "turn", "spin"):
        digits = len(row[name].split("e")[0].replace(".", "").lstrip("0"))
        wanted = float(row[name])
        for link in range(3):
            assert f"{getattr(swimmer.rod(link), name):.{digits}g}" == f"{wanted:.{digits}g}"
        assert not is_close(getattr(foil.rod(0), name), wanted, 1e-2, wanted)


@pytest.mark.parametrize("law", FINITE_RODS)
@pytest.mark.parametrize("slenderness", [1e-6, 1e-3, 0.03, 0.2])
def test_a_rod_inside_another_drags_less(law: str, slenderness: float) -> None:
    """Drag is monotone under inclusion (Hill and Power 1956); a sphere round the rod bounds it too."""
    thick, thin, short = (
        FINITE_RODS[law](l, a, 1.0) for l, a in ((1, slenderness), (1, slenderness / 2), (0.9, slenderness))
    )
    around = sphere(1.0, 1.0)
    for name, bound in zip(
        ("along", "across", "turn", "spin"), (around[0], around[0], around[1], around[1]), strict=True
    ):
        outer = getattr(thick, name)
        assert getattr(thin, name) < outer < bound
        assert getattr(short, name) <= outer
    assert thick.along < thick.across


def test_a_spheroid_that_is_round_is_a_sphere() -> None:
    force, torque = sphere(1.0, 1.0)
    found = FINITE_RODS["spheroid"](1.0, 0.99, 1.0)
    assert_close([found.along, found.across, found.turn, found.spin], [force, force, torque, torque], 0.03, torque)
    assert not is_close(FINITE_RODS["spheroid"](1.0, 0.8, 1.0).along, force, 0.03, force)


# --- The swimmer -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(30))
def test_resistance_is_symmetric_positive_definite_and_its_three_ways_agree(seed: int) -> None:
    rng = np.random.default_rng(seed)
    swimmer = unequal_swimmer(rng)
    shapes, rates = random_shapes(rng, 4), rng.normal(size=(4, 6))
    p = resistance(swimmer, shapes)
    assert_close(p, np.swapaxes(p, 1, 2), 1e-14, float(np.abs(p).max()))
    assert np.min(np.linalg.eigvalsh(p)) > 0.0
    size = np.repeat([swimmer.length_m, 1.0], 3)
    solved = -np.einsum("nij,nj->ni", connection(swimmer, shapes), rates) / size
    assert_close(base_twist(swimmer, shapes, rates) / size, solved, 1e-11)
    turning = np.einsum("nlij,nlj->nli", shapes, rates.reshape(-1, 2, 3))
    assert_close(base_motion(swimmer, shapes[..., 0], turning).twist, solved, 1e-11)


@pytest.mark.parametrize("seed", range(6))
def test_the_flow_agrees_with_other_integrators(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    swimmer, sequence = unequal_swimmer(rng), random_sequence(rng, 5)
    found = in_lengths(swimmer, flow(swimmer, sequence))
    assert missed(found, in_lengths(swimmer, dop853_flow(swimmer, sequence))) < 1e-11
    time, rate = np.append(0.0, np.cumsum(sequence.duration)), np.concatenate([sequence.rates(), np.zeros((1, 6))])
    again = replay(swimmer, Configuration(), time, rate, False, 1e-9, 1e-9)
    assert missed(found, in_lengths(swimmer, again.end.pose)) < 1e-12
    foil = dataclasses.replace(swimmer, links=LinkSizes(), drag="cox", body_radius_m=0.0)
    assert missed(found, in_lengths(foil, flow(foil, sequence))) > 1e-3


@pytest.mark.parametrize("swimmer", [UNEVEN, BODY, NUMBERS], ids=["uneven", "body", "numbers"])
def test_a_planar_motion_stays_planar_and_any_plane_through_the_axis_is_alike(swimmer: Swimmer) -> None:
    rate = np.array([0.0, 0.0, 1.0, 0.0, 0.0, -0.4])
    shape = shape_from_angles((40, 0, 0), (-25, 0, 0))
    xi = base_twist(swimmer, shape, rate)
    assert_close(xi[[2, 3, 4]], np.zeros(3), 1e-15)
    roll = about_axis(0, 0.7)
    turned = base_twist(swimmer, roll @ shape, rate)
    assert_close(turned, np.concatenate([roll @ xi[:3], roll @ xi[3:]]), 1e-15)
    assert np.min(np.abs(xi[[0, 1, 5]])) > 1e-4


def test_end_for_end_symmetry_exchanges_links_with_their_sizes() -> None:
    """Seen from behind, limb 2 is limb 1; the same swimmer with unexchanged limbs is the foil."""
    behind = dataclasses.replace(UNEVEN, links=LinkSizes(limb1=LinkSize(0.08, 0.02)))
    half_turn = np.diag([-1.0, -1.0, 1.0])
    shape, rate = shape_from_angles((40, 10, 5), (-25, 3, 9)), np.array([0.3, 0.1, 1.0, -0.2, 0.5, -0.4])
    xi = base_twist(UNEVEN, shape, rate)
    other = half_turn @ shape[::-1] @ half_turn
    swapped = np.concatenate([half_turn @ rate[3:], half_turn @ rate[:3]])
    seen = np.concatenate([half_turn @ xi[:3], half_turn @ xi[3:]])
    assert_close(base_twist(behind, other, swapped), seen, 1e-15)
    assert not is_close(base_twist(UNEVEN, other, swapped), seen, 1e-3)
    assert [swimmer.equal_limbs for swimmer in (UNIT, BODY, UNEVEN, NUMBERS)] == [True, True, False, False]


@pytest.mark.parametrize("swimmer", [UNEVEN, BODY, NUMBERS], ids=["uneven", "body", "numbers"])
def test_size_and_the_unit_of_force_change_no_path(swimmer: Swimmer) -> None:
    sequence = PrimitiveSequence.of([("limb1 yaw", 0.5), ("limb2 pitch", 0.7), ("limb1 roll", 0.3)])
    wanted = in_lengths(swimmer, flow(swimmer, sequence))
    unit = swimmer.scaled()
    assert_close([unit.length_m, unit.lateral_drag()], [1.0, 1.0], 1e-15, 2.0)
    assert missed(wanted, flow(unit, sequence)) < 1e-14
    thick = dataclasses.replace(swimmer, viscosity_pa_s=1.2)
    if isinstance(swimmer.drag, str):
        assert missed(wanted, in_lengths(thick, flow(thick, sequence))) < 1e-14
    else:  # numbers stay while what has none follows the viscosity
        assert missed(wanted, in_lengths(thick, flow(thick, sequence))) > 1e-3


def test_what_does_not_differ_is_the_paper_s_swimmer() -> None:
    same = Swimmer(links=LinkSizes(LinkSize(0.1, 0.01), LinkSize(0.1), LinkSize(slenderness=0.01)), drag=LinkDrags())
    assert same == Swimmer()
    assert hash(same) == hash(Swimmer())
    assert Swimmer(links=LinkSizes(base=LinkSize(0.2))) == Swimmer(base_half_length_m=0.2)
    cox = Swimmer().rod(1)
    numbers = LinkDrag(cox.along, cox.across, cox.turn, cox.spin)
    sequence = PrimitiveSequence.of([("limb1 yaw", 0.5), ("limb2 pitch", 0.7), ("limb1 roll", 0.3)])
    told = Swimmer(drag=LinkDrags(numbers, numbers, numbers))
    assert_close(flow(told, sequence), flow(Swimmer(), sequence), 1e-15)


# --- The body --------------------------------------------------------------------------------------------------------


def test_the_body_resists_as_a_sphere_in_every_direction() -> None:
    force, torque = 6.0 * math.pi * 0.95 * 0.04, 8.0 * math.pi * 0.95 * 0.04**3
    bare = dataclasses.replace(BODY, body_radius_m=0.0)
    more = resistance(BODY, COLLINEAR) - resistance(bare, COLLINEAR)
    assert_close(more, np.diag([force] * 3 + [torque] * 3), 1e-15)


def test_limbs_keep_clear_of_the_body() -> None:
    """Against points sampled along the limb; a limb touches the body at the bend that phase 2 may reach."""
    swimmer = dataclasses.replace(BODY, links=LinkSizes(limb1=LinkSize(0.05)))
    assert np.all(np.isinf(body_distance(Swimmer(), np.zeros(2))))
    rng, along = np.random.default_rng(1), np.linspace(0.0, 1.0, 20001)[:, None]
    for axes in random_shapes(rng, 40)[..., 0]:
        found = body_distance(swimmer, bends(axes))
        for limb, side in ((0, 1.0), (1, -1.0)):
            points = side * (np.array([0.1, 0.0, 0.0]) + 2.0 * swimmer.halves_m[limb + 1] * along * axes[limb])
            near = np.min(np.linalg.norm(points, axis=1)) - swimmer.radii_m[limb + 1] - 0.04
            assert_close(found[limb], near, 1e-8)
    long = dataclasses.replace(BODY, base_half_length_m=0.3, limb_half_length_m=0.15, body_radius_m=0.2)
    most = apart_bend_rad(long, 0.01)
    assert_close(np.min(body_distance(long, np.full(2, most))), 0.01, 1e-12)
    assert apart_bend_rad(dataclasses.replace(long, body_radius_m=0.0), 0.01) > most + 0.5


def test_a_folding_limb_comes_nearest_to_the_body_where_it_bends_most() -> None:
    pieces = Pieces.of(PrimitiveSequence.of([("limb2 yaw", 2.7), ("limb2 yaw", -2.7)]))
    found = least_clearance(BODY, pieces)
    assert found.between == "limb 2 and the body"
    assert_close(found.distance_m, body_distance(BODY, np.full(2, 2.7))[1], 1e-12)
    assert least_clearance(dataclasses.replace(BODY, body_radius_m=0.0), pieces).between == "limb 1 and limb 2"


# --- Gaits and plans -------------------------------------------------------------------------------------------------


def test_links_that_drag_more_along_than_across_swim_the_other_way() -> None:
    """As exactly as others; a rod's numbers (the foil) swim ahead."""
    sequence = random_sequence(np.random.default_rng(1), 5)
    found = in_lengths(DISCS, flow(DISCS, sequence))
    assert missed(found, in_lengths(DISCS, dop853_flow(DISCS, sequence))) < 1e-11
    gait = stored_gaits()["x-cruise"]
    ahead = []
    for swimmer in (DISCS, Swimmer()):
        stroke = realise(gait, swimmer, 0.6)
        assert fault(stroke, gait.moves, swimmer) == ""
        ahead.append(float(stroke.displacement(swimmer)[0, 3]))
    assert ahead[0] < -1e-3
    assert ahead[1] > 1e-3
    goal = Configuration.from_angles((0.03, 0.01, -0.02), (10.0, 5.0, -8.0))
    solution = plan(Configuration(), goal, swimmer=DISCS, options=PlanOptions(effort=Effort.QUICK))
    assert solution.verdict == "reached"
    assert solution.certificate.deviation.within(1e-9 * DISCS.length_m, 1e-9)


MILD = Swimmer(links=LinkSizes(limb2=LinkSize(0.08, 0.02)))


@pytest.mark.parametrize("name", ["x-motion", "y-motion", "x-rotation", "y-rotation", "z-rotation", "x-cruise"])
@pytest.mark.parametrize("swimmer", [MILD, BODY, UNEVEN], ids=["mild", "body", "uneven"])
def test_a_gait_is_solved_anew_to_be_pure(name: str, swimmer: Swimmer) -> None:
    """Where limbs differ, symmetry makes no stroke pure: the equal limbs' stroke is the foil."""
    gait = stored_gaits()[name]
    stroke = realise(gait, swimmer, 0.6)
    assert fault(stroke, gait.moves, swimmer) == ""
    if swimmer is MILD and name in {"x-motion", "y-motion"}:
        assert fault(realise(gait, Swimmer(), 0.6), gait.moves, swimmer) != ""


@pytest.mark.parametrize("seed", mostly_slow([5, 2, 0, 1, 3, 4, 6, 7], 1))
def test_any_swimmer_reaches_its_goal(seed: int) -> None:
    rng = np.random.default_rng(200 + seed)
    swimmer = unequal_swimmer(rng)
    turn = Rotation.from_rotvec(rng.normal(size=3)).as_matrix()
    goal = np.eye(4)
    goal[:3, :3], goal[:3, 3] = turn, rng.normal(size=3) * swimmer.length_m
    bent = shape_from_angles(rng.uniform(-40, 40, 3), rng.uniform(-40, 40, 3))
    solution = plan(Configuration(np.eye(4), bent), Configuration(goal, COLLINEAR), swimmer=swimmer)
    assert solution.verdict == "reached"
    off = solution.certificate.deviation
    assert max(off.position_m / swimmer.length_m, off.base_rad, off.limb1_rad, off.limb2_rad) < 1e-9


# --- Files -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("swimmer", [Swimmer(), UNEVEN, BODY, NUMBERS, MILD], ids=str)
def test_a_swimmer_is_written_as_it_is_read(swimmer: Swimmer, tmp_path: Path) -> None:
    import yaml

    path = tmp_path / "swimmer.yaml"
    path.write_text(yaml.safe_dump(swimmer_written(swimmer)))
    assert load_swimmer(path) == swimmer
    assert {"drag", "links", "body_radius_m"} <= set(SWIMMER.json_schema()["properties"])
    assert set(swimmer_written(Swimmer())) == set(LIMITS)


LONG = "links:\n  limb1: {half_length_m: 0.05}\n"
# fmt: off
REFUSED = {
    "an unknown law": ("drag: stokes", 1, "drag", "cox, cylinder, spheroid", "stokes"),
    "a law mistyped": ("drag: cylindre", 1, "drag", "nearest: cylinder", "cylindre"),
    "an unknown link": ("drag:\n  limb3: {}", 2, "drag.limb3", "base, limb1, limb2", "limb3"),
    "an unknown number": ("drag:\n  base:\n    along: 1", 3, "drag.base.along", "along_n_s_per_m", "unknown key"),
    "no drag": ("drag:\n  base: {along_n_s_per_m: 0}", 2, "drag.base.along_n_s_per_m", "above 0", "the number 0"),
    "a negative one": ("drag:\n  limb1:\n    turn_n_m_s: -1", 3, "drag.limb1.turn_n_m_s", "above 0", "-1"),
    "infinity": ("drag:\n  limb1:\n    turn_n_m_s: .inf", 3, "drag.limb1.turn_n_m_s", "finite", ".inf"),
    "along far above across": (
        "drag:\n  limb2:\n    across_n_s_per_m: 0.2\n    along_n_s_per_m: 0.4",
        4,
        "drag.limb2.along_n_s_per_m",
        "the drag across, 0.2 N s/m, to 1.5 times it",
        "found 0.4",
    ),
    "across far below cox's along": (
        "drag:\n  limb2: {across_n_s_per_m: 0.05}",
        2,
        "drag.limb2.along_n_s_per_m",
        "1.5 times it (a flat disc's; are along and across exchanged?)",
        "",
    ),
    "along as across": (
        "drag:" + "".join(f"\n  {link}: {{along_n_s_per_m: 0.3, across_n_s_per_m: 0.3}}" for link in drags.LINKS),
        2,
        "drag",
        "differ by more than 1e-06",
        "1, 1, 1",
    ),
    "a torque for a force": ("drag:\n  base: {turn_n_m_s: 8.6}", 2, "drag.base.turn_n_m_s", "N m s", "8.6"),
    "a spin of no rod": ("drag:\n  base: {spin_n_m_s: 1e-20}", 2, "drag.base.spin_n_m_s", "N m s", "1e-20"),
    "another fluid": (
        "drag:\n  base: {along_n_s_per_m: 1e-4, across_n_s_per_m: 2e-4, turn_n_m_s: 6e-7, spin_n_m_s: 1e-9}",
        2,
        "drag",
        "differ by less than 1000 times",
        "times",
    ),
    "a list of drags": ("drag: [1, 2]", 1, "drag", "cox", "a list of 2"),
    "a link of no length": ("links:\n  limb1: {half_length_m: 0}", 2, "links.limb1.half_length_m", "above", "0"),
    "a fat link": ("links:\n  limb1: {slenderness: 0.3}", 2, "links.limb1.slenderness", "at most 0.2", "0.3"),
    "a link too long": (
        "links:\n  limb1: {half_length_m: 20}",
        2,
        "links.limb1.half_length_m",
        "0.01 to 100 times",
        "200",
    ),
    "a radius below nothing": ("body_radius_m: -0.1", 1, "body_radius_m", "at least 0", "-0.1"),
    "a sphere that hides the joints": (LONG + "body_radius_m: 0.12", 3, "body_radius_m", "below 0.098 m", "0.12"),
    "a sphere that touches limbs": ("body_radius_m: 0.0985", 1, "body_radius_m", "room for a limb", "0.0985"),
}
# fmt: on


@pytest.mark.parametrize("case", REFUSED)
def test_a_bad_drag_is_refused_with_its_place(case: str, tmp_path: Path) -> None:
    text, line, key, wanted, found = REFUSED[case]
    path = tmp_path / "s.yaml"
    path.write_text(text + "\n")
    with pytest.raises(InputError) as caught:
        load_swimmer(path)
    told = str(caught.value)
    assert told.startswith(f"{path}:{line}: {key}: wanted "), told
    assert wanted in told
    assert found in told


@pytest.mark.parametrize("drag", [None, 1.0, "Cox", {}])
def test_a_drag_of_another_type_is_refused(drag: object) -> None:
    with pytest.raises(ParameterError, match="drag: one of cox"):
        Swimmer(drag=drag)  # type: ignore[arg-type]
