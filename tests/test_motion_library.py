"""The motion library: what symmetry makes of its plans, and that small displacements find the plan that suits them."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import assert_close, is_close

from purcell_cli import Configuration, LinkSize, LinkSizes, Swimmer, plan
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import flow
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.limb_circles import LimbCircles
from purcell_cli.planner.library.plan_library import MotionLibrary, image, library_for, stored_plans, symmetries

BODY = Swimmer().scaled()
SHORT = PrimitiveSequence.of(
    [("limb1 yaw", 0.5), ("limb2 pitch", 0.4), ("limb1 roll", 0.3), ("limb2 yaw", -0.6), ("limb1 pitch", 0.2)]
)


def bend(short: PrimitiveSequence) -> float:
    return float(LimbCircles.of(Pieces.of(short)).largest_bends()[0].max())


def seen(symmetry: Array, g: Array) -> Array:
    """Return a displacement as a symmetry shows it."""
    space = np.eye(4)
    space[:3, :3] = symmetry
    return np.asarray(space @ g @ space.T)


@pytest.mark.parametrize("k", range(16))
def test_an_image_does_what_symmetry_shows(k: int) -> None:
    symmetry = symmetries()[k]
    assert_close(symmetry @ symmetry.T, np.eye(3), 0.0)
    does = flow(BODY, SHORT)
    assert_close(flow(BODY, image(SHORT, symmetry)), seen(symmetry, does), 1e-12)
    assert not is_close(flow(BODY, image(SHORT, symmetry)), seen(np.diag([-1.0, 1.0, 1.0]) @ symmetry, does), 1e-3)


def test_symmetries_are_sixteen_and_plans_played_backwards_undo_what_they_do() -> None:
    assert len(np.unique(symmetries(), axis=0)) == 16
    short = stored_plans()[0]
    for symmetry in symmetries():
        there, back = image(short, symmetry), image(short, symmetry, backwards=True)
        assert_close(flow(BODY, there) @ flow(BODY, back, there.shapes(COLLINEAR)[-1]), np.eye(4), 1e-12)


def test_stored_plans_are_short_and_close() -> None:
    plans = stored_plans()
    assert len(plans) >= 20
    for short in plans:
        assert 4 <= len(short) <= 96
        assert_close(short.shapes(COLLINEAR)[-1], COLLINEAR, 1e-5)
        assert bend(short) <= 1.5 + 1e-5
        assert short.joint_travel_rad < 27.0
        assert not is_close(flow(BODY, short), np.eye(4), 1e-3)


@pytest.mark.parametrize("symmetry", [0, 5, 11])
def test_what_a_plan_does_finds_that_plan(symmetry: int) -> None:
    """And the same seen in a mirror finds its image, which is played as it is."""
    for short in stored_plans()[::7]:
        does = seen(symmetries()[symmetry], flow(BODY, short))
        (entry,) = MotionLibrary((short,), Swimmer(max_bend_rad=1.5).scaled()).nearest(
            se3.normalised(does)[None], np.array([2.5]), 1
        )
        assert entry.laps == 1
        assert entry.estimate_rad == pytest.approx(2.5 + short.joint_travel_rad, rel=1e-5)
        assert_close(flow(BODY, entry.lap), does, 1e-5)


SMALL = 40
"""So many of the first plans are for small displacements; another image of a larger one, scaled, may seem shorter."""
UNEVEN = Swimmer(links=LinkSizes(limb1=LinkSize(0.07)), drag="spheroid", max_bend_rad=1.5).scaled()


@pytest.mark.parametrize("symmetry", [0, 5, 11])
def test_plans_of_exchanged_limbs_are_plans_of_their_own_where_limbs_differ(symmetry: int) -> None:
    """What an image does is found as that image; an end-for-end image, the foil, is not what symmetry shows."""
    for short in stored_plans()[:SMALL:7]:
        shown = image(short, symmetries()[symmetry])
        does = flow(UNEVEN, shown)
        library = MotionLibrary((short,), UNEVEN)
        (entry,) = library.nearest(se3.normalised(does)[None], np.zeros(1), 1)
        assert entry.estimate_rad == pytest.approx(short.joint_travel_rad, rel=1e-4)
        assert_close(flow(UNEVEN, entry.lap), does, 1e-4)
        even = seen(symmetries()[symmetry], flow(UNEVEN, short))
        assert is_close(does, even, 1e-9) == (symmetries()[symmetry][0, 0] > 0.0)


def test_a_small_bend_limit_asks_for_laps() -> None:
    short = max(stored_plans(), key=bend)
    library = MotionLibrary((short,), Swimmer(max_bend_rad=0.5 * bend(short)).scaled())
    (entry,) = library.nearest(se3.normalised(flow(BODY, short))[None], np.zeros(1), 1)
    assert entry.laps == 4
    assert bend(entry.lap) == pytest.approx(0.5 * bend(short), rel=0.05)
    assert entry.estimate_rad == pytest.approx(2.0 * short.joint_travel_rad, rel=1e-5)


def test_a_library_is_made_once_for_a_swimmer() -> None:
    assert library_for(BODY) is library_for(Swimmer().scaled())
    assert library_for(BODY) is not library_for(Swimmer(slenderness=0.03).scaled())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("position", "angles", "limit", "most"),
    [
        ([0.01, 0.005, 0.002], [5.0, 5.0, 5.0], 1.0, 18.5),
        ([0.003, -0.004, 0.002], [-2.0, 4.0, 9.0], 1.0, 16.0),
        ([-0.002, 0.0, 0.006], [6.0, 0.0, -5.0], 1.4, 10.0),
    ],
)
def test_small_displacements_take_little_joint_travel(
    position: list[float], angles: list[float], limit: float, most: float
) -> None:
    swimmer = Swimmer(max_bend_rad=limit)
    found = plan(Configuration(), Configuration.from_angles(position, angles), swimmer=swimmer)
    assert found.verdict == "reached"
    assert found.joint_travel_rad <= most
    assert found.limits.largest_bend_rad[1] is not None
    assert found.limits.largest_bend_rad[1] <= limit


@pytest.mark.slow
def test_other_swimmers_and_bent_limbs_use_the_library_too() -> None:
    limbs = (30.0, 10.0, 0.0), (-20.0, 0.0, 40.0)
    start = Configuration.from_angles([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], *limbs)
    goal = Configuration.from_angles([0.003, 0.002, -0.001], [2.0, -3.0, 4.0], *limbs)
    found = plan(start, goal, swimmer=Swimmer(0.1, 0.06, 0.02, max_bend_rad=1.2))
    assert found.verdict == "reached"
    assert any("library plan" in s.words for s in found.plan.structures)
