"""Chains of screw motions brought to a displacement: the product of exponentials is that displacement."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.linalg

from purcell_cli.geometry import se3
from purcell_cli.kernel.screw_chains import solved
from purcell_cli.mechanics.configuration import Configuration

_EVERY = range(6)


def _hat(twist: np.ndarray) -> np.ndarray:
    v, w = twist[:3], twist[3:]
    return np.array([[0.0, -w[2], w[1], v[0]], [w[2], 0.0, -w[0], v[1]], [-w[1], w[0], 0.0, v[2]], [0.0] * 4])


def _made(twists: np.ndarray, order: np.ndarray, cycles: np.ndarray) -> np.ndarray:
    out = np.eye(4)
    for k, n in zip(order, cycles, strict=True):
        out = out @ scipy.linalg.expm(n * _hat(twists[k]))
    return out


def test_chains_that_are_solved_make_the_displacement_in_their_order() -> None:
    rng = np.random.default_rng(3)
    twists, travel = 0.1 * rng.normal(size=(9, 6)), rng.uniform(1.0, 4.0, 9)
    wanted = Configuration.from_angles((0.7, -0.4, 0.2), (40.0, -20.0, 70.0)).pose
    orders = rng.integers(9, size=(200, 7))
    cycles, missing = solved(orders, rng.normal(size=orders.shape), twists, travel, se3.inverse(wanted), _EVERY)
    found = np.flatnonzero(missing < 1e-8)
    assert len(found) > 40
    backwards = 0
    for k in found[:6]:
        assert np.max(np.abs(_made(twists, orders[k], cycles[k]) - wanted)) < 1e-7
        backwards += bool(np.max(np.abs(_made(twists, orders[k, ::-1], cycles[k, ::-1]) - wanted)) > 1e-3)
    assert backwards == 6  # screws do not commute: the other order is another displacement


def test_components_that_do_not_count_may_be_missed() -> None:
    twists = np.array(
        [[0.1, 0.0, 0.0, 0.0, 0.0, 0.02], [0.0, 0.1, 0.05, 0.0, 0.0, 0.1], [0.05, -0.1, 0.0, 0.0, 0.0, 0.1]]
    )
    wanted = Configuration.from_angles((0.3, 0.2, 0.0), (25.0, 0.0, 0.0)).pose
    given = np.array([[0, 1, 2]]), np.ones((1, 3)), twists, np.ones(3), se3.inverse(wanted)
    cycles, missing = solved(*given, (0, 1, 5))
    made = _made(twists, np.array([0, 1, 2]), cycles[0])
    assert missing[0] < 1e-8
    assert np.max(np.abs(made - wanted)[:2]) < 1e-7
    assert abs(made[2, 3]) > 1e-3
    assert solved(*given, _EVERY)[1][0] > 1e-3


def test_what_no_chain_can_make_is_told_by_what_is_missing() -> None:
    wanted = Configuration.from_angles((0.3, 0.0, 0.0), (0.0, 0.0, 0.0)).pose
    along_y = np.array([[0.0, 1.0, 0.0, 0.0, 0.0, 0.0]])
    cycles, missing = solved([[0, 0]], [[0.4, -0.2]], along_y, [1.0], se3.inverse(wanted), _EVERY)
    assert missing[0] == pytest.approx(0.3)
    assert np.all(np.isfinite(cycles))


@pytest.mark.parametrize(
    ("orders", "rows"), [([[0, 1]], _EVERY), ([[-1]], _EVERY), ([[0] * 17], _EVERY), ([[0]], (6,)), ([[0]], ())]
)
def test_screws_and_components_that_there_are_not_are_refused(orders: list[list[int]], rows: tuple[int, ...]) -> None:
    starts = np.zeros(np.array(orders).shape)
    with pytest.raises(ValueError, match="wanted"):
        solved(orders, starts, np.ones((1, 6)), [1.0], np.eye(4), rows)
