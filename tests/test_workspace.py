"""A workspace: a box that all links stay in, at every instant of every cycle."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest
from helpers import assert_close, mostly_slow, random_shapes, random_swimmer, unequal_swimmer

from purcell_cli import Configuration, PlanOptions, Swimmer, load_scenario, plan, stored_scenarios
from purcell_cli.errors import ParameterError
from purcell_cli.geometry.rotations import Array, cross
from purcell_cli.mechanics.connection import connection
from purcell_cli.mechanics.drag import LinkDrag, LinkDrags
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.limb_circles import LimbCircles
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.limits_check import check
from purcell_cli.motion.workspace import ENDS, WALLS, Workspace, end_speeds, link_ends
from purcell_cli.solution import Solution

FINE_S = 5e-4


@functools.cache
def finely(name: str) -> Solution:
    """Return a stored scenario's plan with very many rows."""
    scenario = load_scenario(stored_scenarios()[name])
    return plan(scenario.start, scenario.goal, swimmer=scenario.swimmer, options=PlanOptions(dt_s=FINE_S))


def extent(solution: Solution) -> tuple[Array, Array]:
    """Return the least box round a plan's rows [m]."""
    swimmer, rows = solution.plan.swimmer, solution.trajectory
    ends = link_ends(swimmer, rows.pose, rows.shape[..., 0])
    radius = swimmer.radii_m[1]
    return ends.min(axis=(0, 1)) - radius, ends.max(axis=(0, 1)) + radius


def corner(values: Array) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z


@pytest.mark.parametrize("name", mostly_slow(["yaw", "nearby"], 0))
@pytest.mark.parametrize("wall", range(6))
def test_how_far_a_plan_leaves_its_box_is_found_at_any_wall(name: str, wall: int) -> None:
    """A wall pushed in by a millimetre, out by a micrometre more than the rows tell, and far out."""
    solution = finely(name)
    start, blocks, swimmer = solution.plan.start, solution.plan.blocks, solution.plan.swimmer
    low, high = extent(solution)
    for push in (1e-3, -1e-5, -1.0):
        corners = low - 1.0, high + 1.0
        corners[wall % 2][wall // 2] = (low, high)[wall % 2][wall // 2] + (push if wall % 2 == 0 else -push)
        found = check(swimmer, start, blocks, Limits(workspace=Workspace(*map(corner, corners))))
        assert found.workspace is not None
        assert_close(found.workspace.distance_m, max(push, 0.0), 1e-4, swimmer.length_m)
        assert found.kept == (push < 0.0)
        if not found.kept:
            (broken,) = found.violations
            assert WALLS[wall] in broken.what
            row = int(np.searchsorted(solution.trajectory.time_s, broken.time_s + 1e-9)) - 1
            rows = solution.trajectory
            ends = link_ends(swimmer, rows.pose[row : row + 1], rows.shape[row : row + 1, :, :, 0])[0]
            at = ends[ENDS.index(broken.what.partition(" beyond")[0]), wall // 2]
            assert abs(at - corners[wall % 2][wall // 2]) >= broken.excess - 1e-3 - swimmer.radii_m[1]


def test_every_cycle_is_at_a_place_of_its_own() -> None:
    """A cruise leaves a box in its last cycles alone; checking one cycle is the foil."""
    square = PrimitiveSequence.of([("limb1 yaw", 1.5), ("limb2 yaw", 1.5), ("limb1 yaw", -1.5), ("limb2 yaw", -1.5)])
    lead = PrimitiveSequence.of([("limb1 yaw", -0.75), ("limb2 yaw", -0.75)])
    box = Limits(workspace=Workspace((-0.7, -0.3, -0.3), (0.7, 0.3, 0.3)))
    for cycles, kept in ((1, True), (30, False)):
        found = check(Swimmer(), Configuration(), [Block(2, "lead", lead), Block(2, "cruise", square, cycles)], box)
        assert found.kept == kept
    assert found.violations[0].time_s > 20.0 * square.joint_travel_rad


def test_a_start_outside_is_found_at_once() -> None:
    found = check(Swimmer(), Configuration(), [], Limits(workspace=Workspace((-1, -1, -1), (0.25, 1, 1))))
    (broken,) = found.violations
    assert_close(broken.excess, 0.052, 1e-12)
    assert (broken.time_s, broken.what) == (0.0, "end of limb 1 beyond the largest x")


def discs(rng: np.random.Generator) -> Swimmer:
    """Return a swimmer whose links drag more along their axes than across them."""
    rods = map(Swimmer().rod, range(3))
    return Swimmer(drag=LinkDrags(*(LinkDrag(float(rng.uniform(1.0, 1.5)) * rod.across, rod.across) for rod in rods)))


@pytest.mark.parametrize("seed", range(20))
def test_no_end_of_a_link_moves_faster_than_dissipation_allows(seed: int) -> None:
    rng = np.random.default_rng(seed)
    swimmer, n = (random_swimmer, unequal_swimmer, discs)[seed % 3](rng), 200
    shapes, rates = random_shapes(rng, n), rng.normal(size=(n, 6))
    rates[::2] = np.eye(6)[rng.integers(0, 6, n // 2)]
    shapes[: n // 4] = np.eye(3)
    xi = -np.einsum("nij,nj->ni", np.stack([connection(swimmer, s) for s in shapes]), rates)
    axes = shapes[..., 0]
    ends = link_ends(swimmer, np.tile(np.eye(4), (n, 1, 1)), axes)
    speed = xi[:, None, :3] + cross(xi[:, None, 3:], ends)
    swept = cross(np.einsum("nlij,nlj->nli", shapes, rates.reshape(n, 2, 3)), axes)
    speed[:, 2:4] += 2.0 * np.multiply(swimmer.halves_m[1:], [1.0, -1.0])[:, None] * swept
    bound = end_speeds(swimmer, LimbCircles.of(Pieces(shapes, rates, np.ones(n))))
    share = np.linalg.norm(speed, axis=-1) / bound
    assert np.max(share) <= 1.0
    assert np.max(share) > 0.2


@pytest.mark.parametrize(
    ("low", "high"),
    [((0, 0, 0), (1, 1, 0)), ((0, 0, 2), (1, 1, 1)), ((0, 0, math.nan), (1, 1, 1)), ((0, 0, 0), (1, math.inf, 1))],
)
def test_a_box_that_is_none_is_refused(low: tuple[float, float, float], high: tuple[float, float, float]) -> None:
    with pytest.raises(ParameterError, match=r"(min|max): .* wanted, found"):
        Workspace(low, high)


def test_a_box_of_one_wall_holds_what_is_on_its_side_however_far() -> None:
    ahead = Configuration.from_angles(position_m=(1e3, -1e3, 5.0))
    for box, kept in ((Workspace(min=(None, None, 4.9)), True), (Workspace(max=(None, None, 4.9)), False)):
        found = check(Swimmer(), ahead, [], Limits(workspace=box))
        assert found.kept == kept
    assert_close(found.violations[0].excess, 0.102, 1e-12)
    with pytest.raises(ParameterError, match="a box with one wall or more is wanted, found none"):
        Workspace()


def test_a_start_or_goal_outside_the_box_is_refused_and_one_that_touches_its_wall_is_not() -> None:
    for wall, kept in ((0.302, True), (0.3019, False)):
        options = PlanOptions(workspace=Workspace(max=(wall, None, None)))
        if kept:
            assert plan(Configuration(), Configuration(), options=options).verdict == "reached"
            continue
        for name in ("start", "goal"):
            there = Configuration.from_angles(position_m=(-1.0, 0.0, 0.0))
            query = (Configuration(), there) if name == "start" else (there, Configuration())
            with pytest.raises(ParameterError) as caught:
                plan(*query, options=options)
            assert str(caught.value) == (
                f"{name}: all links inside the workspace are wanted, "
                "found the end of limb 1 0.0001 m beyond the largest x"
            )


@pytest.mark.slow
def test_where_a_smaller_bend_keeps_the_links_inside_it_is_found() -> None:
    """A channel too narrow for loops of the swimmer's bend limit, which is what they have in a wide one: the foil."""
    goal = Configuration.from_angles((0.05, 0.0, 0.0))
    most = {}
    for half in (0.5, 0.04):
        box = Workspace((None, -half, -half), (None, half, half))
        found = plan(Configuration(), goal, options=PlanOptions(workspace=box))
        assert found.verdict == "reached"
        most[half] = found.limits.largest_bend_rad[1]
    assert_close(most[0.5], 1.0, 1e-4)
    assert most[0.04] < 0.4
