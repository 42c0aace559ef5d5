"""Ways to turn one limb: each makes the rotation that is asked for, all are different, the shortest comes first."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import assert_close, is_close, random_rotations
from scipy.spatial.transform import Rotation

from purcell_cli.geometry.rotations import Array, about_axis, angle_between
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.planner.limbs.limb_rotations import rotations_to

QUARTER = 0.5 * math.pi
ROTATIONS = {
    **{f"random {k}": r for k, r in enumerate(random_rotations(np.random.default_rng(5), 4))},
    "nothing": np.eye(3),
    **{f"half a turn about {'xyz'[k]}": about_axis(k, math.pi) for k in range(3)},
    **{f"a quarter turn about {'xyz'[k]}": about_axis(k, QUARTER) for k in range(3)},
    "gimbal lock": about_axis(0, 0.4) @ about_axis(1, QUARTER) @ about_axis(2, -0.9),
    "almost gimbal lock": about_axis(0, 0.4) @ about_axis(1, QUARTER - 1e-9) @ about_axis(2, -0.9),
    "folded back": about_axis(2, 0.3) @ about_axis(1, math.pi) @ about_axis(2, 1.1),
    "hardly anything": about_axis(1, 1e-9) @ about_axis(2, 2e-9),
}


def made(controls: Array, angles: Array) -> Array:
    """Return the product of turns about own axes. Shapes (3,) and (3,)."""
    out = np.eye(3)
    for control, angle in zip(controls, angles, strict=True):
        out = out @ about_axis(int(control) % 3, float(angle))
    return out


@pytest.mark.parametrize("limb", [1, 2])
@pytest.mark.parametrize("name", ROTATIONS)
def test_every_way_begins_where_the_limb_is_and_makes_the_rotation_asked_for(name: str, limb: int) -> None:
    ways = rotations_to(ROTATIONS[name], limb)
    for k in range(len(ways)):
        shapes = ways.primitives(k).shapes(COLLINEAR)
        assert_close(shapes[0], COLLINEAR, 0.0)
        assert_close(shapes[-1, limb - 1], ROTATIONS[name], 2e-15, 4.0)
        assert_close(shapes[:, 2 - limb], np.broadcast_to(np.eye(3), (4, 3, 3)), 0.0)
        assert np.all(ways.control[k] // 3 == limb - 1)
        assert np.all(np.diff(ways.control[k]) != 0)


@pytest.mark.parametrize("name", ["random 0", "random 3", "gimbal lock"])
def test_rotations_in_the_wrong_order_or_sense_make_another_rotation(name: str) -> None:
    """The foils: turns about the axes of the base, and turns undone."""
    ways = rotations_to(ROTATIONS[name], 1)
    backwards = [made(c[::-1], a[::-1]) for c, a in zip(ways.control, ways.angle, strict=True)]
    undone = [made(c, -a) for c, a in zip(ways.control, ways.angle, strict=True)]
    for other in (backwards, undone):
        assert not any(is_close(r, ROTATIONS[name], 1e-3) for r in other)


@pytest.mark.parametrize("seed", range(4))
def test_all_twelve_orders_are_there_two_ways_each_as_scipy_has_them(seed: int) -> None:
    rotation = ROTATIONS[f"random {seed}"]
    ways = rotations_to(rotation, 1)
    assert len(ways) == 24
    found = {"".join("XYZ"[c] for c in control): [] for control in ways.control}
    for control, angle in zip(ways.control, ways.angle, strict=True):
        found["".join("XYZ"[c] for c in control)].append(angle)
    assert len(found) == 12
    for order, (first, second) in found.items():
        wanted = Rotation.from_matrix(rotation).as_euler(order)
        assert any(is_close(angle, wanted, 1e-12) for angle in (first, second))
        assert not is_close(first, second, 1e-3)


@pytest.mark.parametrize("name", ROTATIONS)
def test_ways_differ_and_the_least_joint_travel_comes_first(name: str) -> None:
    ways = rotations_to(ROTATIONS[name], 2)
    played = {tuple((c, round(a, 9)) for c, a in ways.primitives(k).busy()) for k in range(len(ways))}
    assert len(played) == len(ways)
    assert np.all(np.diff(ways.joint_travel_rad) >= -1e-8)
    for k in range(len(ways)):
        assert ways.primitives(k).joint_travel_rad == pytest.approx(ways.joint_travel_rad[k], abs=1e-15)
    # A limb turns at least by the angle of the rotation, whatever the axes.
    assert ways.joint_travel_rad[0] >= angle_between(np.eye(3), ROTATIONS[name]) - 1e-12


@pytest.mark.parametrize("angle", [1e-12, 0.3, -2.0, math.pi])
@pytest.mark.parametrize("axis", range(3))
def test_a_turn_about_one_own_axis_takes_that_turn_alone(axis: int, angle: float) -> None:
    ways = rotations_to(about_axis(axis, angle), 1)
    assert list(ways.primitives(0).busy().control) == [axis]
    assert ways.joint_travel_rad[0] == pytest.approx(abs(angle), rel=1e-12)


def test_no_rotation_takes_no_turn() -> None:
    assert rotations_to(np.eye(3), 1).joint_travel_rad[0] == 0.0
    assert len(rotations_to(np.eye(3), 1).primitives(0).busy()) == 0
