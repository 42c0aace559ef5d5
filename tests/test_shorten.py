"""Shorter motions: known upper bounds are met, limits hold, and the arrival stays exact."""

from __future__ import annotations

import numpy as np
import pytest

from purcell_cli import Configuration, Swimmer, plan, se3
from purcell_cli.planner.equations import Equations, Stretch
from purcell_cli.planner.limits import bend_rows
from purcell_cli.planner.shorten import merged, offered
from purcell_cli.primitives import PrimitiveSequence
from tests.helpers import assert_close, is_close

KNOWN = {
    "0.1 L along x": ([0.01, 0.0, 0.0], [0.0, 0.0, 0.0], 0.7, 4.52),
    "0.05 L along y": ([0.0, 0.005, 0.0], [0.0, 0.0, 0.0], 1.5, 5.32),
    "a yaw of 5 degrees": ([0.0, 0.0, 0.0], [5.0, 0.0, 0.0], 1.5, 5.72),
    "a roll of 30 degrees": ([0.0, 0.0, 0.0], [0.0, 0.0, 30.0], 1.0, 0.371),
}
BENT = np.stack([np.eye(3), np.eye(3)])


@pytest.mark.parametrize("name", KNOWN)
def test_thorough_plans_meet_the_best_known_joint_travel(name: str) -> None:
    """Within 0.3 % of the best known; the stored gaits alone, the foil, do not but for the roll."""
    position, angles, bend, best = KNOWN[name]
    swimmer, goal = Swimmer(max_bend_rad=bend), Configuration.from_angles(position, angles)
    found = plan(Configuration(), goal, swimmer, effort="thorough")
    assert found.verdict == "reached"
    assert found.joint_travel_rad <= 1.003 * best
    axes = found.trajectory.shape[:, :, 0, 0]
    assert np.max(np.arccos(np.clip(axes, -1.0, 1.0))) <= bend * (1.0 + 1e-4)
    plain = plan(Configuration(), goal, swimmer)
    assert plain.verdict == "reached"
    assert plain.joint_travel_rad >= found.joint_travel_rad
    assert name == "a roll of 30 degrees" or plain.joint_travel_rad > 1.2 * best


def test_offered_controls_change_nothing_until_they_turn() -> None:
    sequence = PrimitiveSequence.of([("limb1 yaw", 0.4), ("limb2 pitch", -0.3)])
    wide = offered(sequence, 2)
    assert len(wide) == 6 + 2 * 2 * 6
    assert list(merged(wide)) == [(name, pytest.approx(angle, abs=1e-15)) for name, angle in sequence]


def test_the_equations_have_the_derivative_they_say() -> None:
    """Central differences at the arrival; the foil: the derivative of the motion run backwards."""
    word = PrimitiveSequence.of([("limb1 yaw", 0.4), ("limb2 pitch", 0.3), ("limb1 yaw", -0.4), ("limb2 pitch", -0.3)])
    loop = PrimitiveSequence.of([("limb1 yaw", 0.5), ("limb2 yaw", 0.5), ("limb1 yaw", -0.5), ("limb2 yaw", -0.5)])
    parts = [
        Stretch(2, (("a", 0.0, 4),), word, BENT, BENT),
        Stretch(2, (("b", 0.0, 4),), loop, BENT, BENT, cycles=3),
        Stretch(2, (("c", 0.0, 4),), word.inverse(), BENT, BENT),
    ]
    made = se3.exp(
        Equations(Swimmer().scaled(), parts, np.eye(4)).at(np.concatenate([word.angle, -word.angle[::-1]])).residual[:6]
    )
    equations = Equations(Swimmer().scaled(), parts, made)
    angle, h = equations.angles() + 0.0, 1e-6
    columns = [
        (equations.at(angle + step).residual - equations.at(angle - step).residual) / (2 * h)
        for step in h * np.eye(len(angle))
    ]
    free = slice(4, 8)  # the last stretch: what it changes, nothing follows
    differences = np.array(columns).T[:, free]
    assert_close(equations.at(angle).derivative[:, free], differences, 1e-6)
    assert not is_close(equations.at(-angle).derivative[:, free], differences, 1e-3)


def test_the_room_below_the_bend_limit_has_the_derivative_it_says() -> None:
    sequence = PrimitiveSequence.of([("limb1 yaw", 0.6), ("limb1 roll", 0.4), ("limb1 pitch", 0.5), ("limb2 yaw", 0.9)])

    def room(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return bend_rows(Stretch(2, (("a", 0.0, 4),), sequence.with_angles(angle), BENT, BENT), 0.9)

    value, derivative = room(sequence.angle)
    assert len(value) == 3
    for k, step in enumerate(1e-6 * np.eye(4)):
        difference = (room(sequence.angle + step)[0] - room(sequence.angle - step)[0]) / 2e-6
        assert_close(derivative[:, k], difference, 1e-8)
