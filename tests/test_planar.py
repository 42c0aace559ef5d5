"""The curvature of the planar connection is what small loops of the exact lift do."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import assert_close, is_close, random_swimmer

from purcell_cli import PrimitiveSequence, Swimmer, flow
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import about_axis
from purcell_cli.lie_brackets.planar_curvature import PLANES, Plane, angles_in, planar_curvature, plane_of
from purcell_cli.mechanics.connection import connection

PAPER = Swimmer()


@pytest.mark.parametrize("plane", PLANES, ids=lambda plane: plane.joint)
@pytest.mark.parametrize("seed", range(3))
def test_small_loops_move_by_the_curvature_times_their_area(plane: Plane, seed: int) -> None:
    """By squares centred on a shape, the error falls with their area; the loop the other way is the foil."""
    rng = np.random.default_rng(seed)
    swimmer, angles = random_swimmer(rng), rng.uniform(-2.0, 2.0, 2)
    wanted = planar_curvature(swimmer, plane, angles) / [swimmer.length_m, swimmer.length_m, 1.0]

    def measured(side: float, order: int = 1) -> np.ndarray:
        joints = [f"limb1 {plane.joint}", f"limb2 {plane.joint}"][::order]
        half = side / 2.0
        corner = PrimitiveSequence.of([(joints[0], -half), (joints[1], -half)])
        square = PrimitiveSequence.of([(joints[0], side), (joints[1], side), (joints[0], -side), (joints[1], -side)])
        loop = corner + square + corner.inverse()
        moved = se3.log(flow(swimmer, loop, about_axis(plane.axis, angles)))
        moved[:3] /= swimmer.length_m
        off = np.delete(moved, plane.twist)
        assert_close(off, np.zeros(3), 1e-12)
        return moved[list(plane.twist)] / side**2

    errors = [np.max(np.abs(measured(side) - wanted)) for side in (0.08, 0.04, 0.02)]
    slopes = -np.diff(np.log2(errors))
    assert np.all(np.abs(slopes - 2.0) < 0.15), (errors, slopes)
    assert errors[-1] < 2e-3
    assert not is_close(measured(0.02, -1), wanted, 1e-1 * np.max(np.abs(wanted)))


@pytest.mark.parametrize("plane", PLANES, ids=lambda plane: plane.joint)
def test_the_derivative_is_that_of_the_connection(plane: Plane) -> None:
    """Central differences of the connection; without the bracket, or with its other sign, it is another field."""
    angles, h, c = np.array([0.4, -1.1]), 1e-5, [plane.axis, 3 + plane.axis]

    def forms(d1: float, d2: float) -> tuple[np.ndarray, np.ndarray]:
        a = -connection(PAPER, about_axis(plane.axis, np.add(angles, [d1, d2])))
        return a[:, c[0]], a[:, c[1]]

    curl = (forms(h, 0)[1] - forms(-h, 0)[1] - forms(0, h)[0] + forms(0, -h)[0]) / (2 * h)
    bracket = se3.bracket(*forms(0, 0))
    found = planar_curvature(PAPER, plane, angles)
    for sign, same in ((1.0, True), (0.0, False), (-1.0, False)):
        assert is_close(found, (curl + sign * bracket)[list(plane.twist)], 1e-8) == same


def test_the_pitch_plane_is_the_yaw_plane_rolled_by_a_quarter_turn() -> None:
    """Turned about x by 90 degrees, z takes the place of y, and a pitch that of a yaw runs the other way."""
    rng = np.random.default_rng(0)
    angles = rng.uniform(-2.0, 2.0, (50, 2))
    yaw, pitch = PLANES
    expected = planar_curvature(PAPER, yaw, -angles)
    assert_close(planar_curvature(PAPER, pitch, angles), expected * [1.0, 1.0, -1.0], 1e-13)


def test_x_is_even_and_the_turn_odd_under_the_swimmers_symmetries() -> None:
    """The mirror image of a shape, and the swimmer seen from its other end."""
    angles = np.random.default_rng(1).uniform(-2.0, 2.0, (50, 2))
    here = planar_curvature(PAPER, PLANES[0], angles)
    assert_close(planar_curvature(PAPER, PLANES[0], -angles), here * [1.0, -1.0, -1.0], 1e-13)
    assert_close(planar_curvature(PAPER, PLANES[0], angles[:, ::-1]), here * [1.0, 1.0, -1.0], 1e-13)


def test_the_plane_of_shapes_is_known() -> None:
    angles = np.array([[0.0, 0.0], [1.0, -2.0], [3.0, 0.5], [4.0, 0.0]])
    for plane in PLANES:
        shapes = about_axis(plane.axis, angles)
        assert plane_of(shapes) == plane
        assert_close(angles_in(plane, shapes), angles, 1e-12)
    assert plane_of(np.concatenate([about_axis(1, angles), about_axis(2, angles)])) is None
    assert plane_of(about_axis(0, angles)) is None
