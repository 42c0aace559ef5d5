"""What others published: 300 planar gaits of sysplotter, and the paper's printed sequences, against the flow."""

from __future__ import annotations

import math

import numpy as np
import pytest
from helpers import (
    PITCH_1,
    PITCH_2,
    ROLL_1,
    ROLL_2,
    UNIT,
    YAW_1,
    YAW_2,
    assert_close,
    is_close,
    read_table,
)

from purcell_cli.geometry.rotations import Array, about_axis, as_euler
from purcell_cli.mechanics.connection import COLLINEAR, power
from purcell_cli.mechanics.lift import flow, flow_of_rates
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer

# --- sysplotter ----------------------------------------------------------------------------------------------------

SWIMMER = Swimmer(
    base_half_length_m=1 / 6,
    limb_half_length_m=1 / 6,
    viscosity_pa_s=2.0 * math.log(100.0) / (4.0 * math.pi),
    drag_ratio=2.0,
)
"""Total length 1, lateral drag 2 per length, longitudinal drag 1."""

GAITS = [{key: float(value) for key, value in row.items()} for row in read_table("sysplotter_gaits.csv")]
PUBLISHED_THETA = np.array([gait["theta"] for gait in GAITS])
CENTRED = np.array([gait["c1"] == gait["c2"] == 0.0 for gait in GAITS])
YAW_SIGN = (1.0, -1.0)
"""Limb 1's yaw is +alpha_2, limb 2's is -alpha_1."""


def yaws(gait: dict[str, float], t: Array, sign: tuple[float, float] = YAW_SIGN) -> tuple[Array, Array]:
    """Return the yaws of limb 1 and limb 2 at times of the cycle, and their rates. Shapes (n, 2)."""
    c, s = np.cos(2 * math.pi * t), np.sin(2 * math.pi * t)
    angle = [sign[2 - i] * (gait[f"c{i}"] + gait[f"p{i}"] * c + gait[f"q{i}"] * s) for i in (2, 1)]
    rate = [sign[2 - i] * 2 * math.pi * (gait[f"q{i}"] * c - gait[f"p{i}"] * s) for i in (2, 1)]
    return np.stack(angle, axis=-1), np.stack(rate, axis=-1)


def polygon(gait: dict[str, float], pieces: int, sign: tuple[float, float] = YAW_SIGN) -> tuple[float, Array]:
    """Return net rotation and translation of a polygon inscribed in the gait, played at constant rates."""
    angle, _ = yaws(gait, np.arange(pieces + 1) / pieces, sign)
    rate = np.zeros((pieces, 6))
    rate[:, [YAW_1, YAW_2]] = np.diff(angle, axis=0)
    g = flow_of_rates(SWIMMER, rate, np.ones(pieces), about_axis(2, angle[0]))[1][-1]
    return math.atan2(g[1, 0], g[0, 0]), g[:2, 3]


def smooth(gait: dict[str, float], pieces: int = 24) -> tuple[float, float]:
    """Return net rotation and distance of the smooth gait: two polygons, their error of second order taken out."""
    (turn, move), (finer_turn, finer_move) = polygon(gait, pieces), polygon(gait, 2 * pieces)
    return (4 * finer_turn - turn) / 3, float(np.hypot(*(4 * finer_move - move) / 3))


@pytest.fixture(scope="module")
def computed() -> Array:
    """Return net rotation and distance of all gaits. Shape (300, 2)."""
    return np.array([smooth(gait) for gait in GAITS])


def test_the_table_is_whole() -> None:
    """All 300 gaits are there, five of them about the collinear shape, and many of them turn."""
    assert len(GAITS) == 300
    assert np.count_nonzero(CENTRED) == 5
    assert np.count_nonzero(np.abs(PUBLISHED_THETA) > 0.01) == 97


@pytest.mark.slow
def test_net_rotation_is_the_published_one(computed: Array) -> None:
    """theta of every gait, to the 2e-5 rad that theirs is interpolated to."""
    assert_close(computed[:, 0], PUBLISHED_THETA, 2e-5)


@pytest.mark.slow
def test_net_translation_is_the_published_one(computed: Array) -> None:
    """sqrt(X^2 + Y^2) to 1e-3 where the gait is centred on the collinear shape."""
    wanted = np.array([math.hypot(gait["X"], gait["Y"]) for gait in GAITS])
    assert_close((computed[:, 1] / wanted)[CENTRED], np.ones(5), 1e-3)


@pytest.mark.slow
def test_cost_is_the_published_one() -> None:
    """The integral of sqrt(power) to 2e-3, by the trapezoid rule; limb 2 counted the other way is the foil."""
    t = np.arange(256) / 256
    rate = np.zeros((len(GAITS), len(t), 6))
    shape = np.empty((len(GAITS), len(t), 2, 3, 3))
    for k, gait in enumerate(GAITS):
        angle, rate[k][:, [YAW_1, YAW_2]] = yaws(gait, t)
        shape[k] = about_axis(2, angle)
    found = np.sqrt(power(SWIMMER, shape, rate)).mean(axis=1)
    wanted = np.array([gait["cost"] for gait in GAITS])
    assert_close(found / wanted, np.ones(len(GAITS)), 2e-3)
    half = np.sqrt(power(SWIMMER, shape[:, ::2], rate[:, ::2])).mean(axis=1)
    assert_close(half / found, np.ones(len(GAITS)), 3e-4)
    wrong = shape.copy()
    wrong[:, :, 1] = np.swapaxes(wrong[:, :, 1], -1, -2)
    foil_rate = rate.copy()
    foil_rate[:, :, YAW_2] *= -1.0
    foil = np.sqrt(power(SWIMMER, wrong, foil_rate)).mean(axis=1)
    assert np.count_nonzero(np.abs(foil / wanted - 1.0) < 2e-3) < 0.2 * len(GAITS)


@pytest.mark.parametrize("sign", [(1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0)], ids=["limb 2", "both", "limb 1"])
def test_net_rotation_with_another_sign_of_a_yaw_is_not_the_published_one(sign: tuple[float, float]) -> None:
    """Counting a limb's angle the other way misses every gait that turns: the foils."""
    turning = [gait for gait in GAITS if abs(gait["theta"]) > 0.01]
    misses = [abs(polygon(gait, 24, sign)[0] - gait["theta"]) > 5e-3 for gait in turning]
    assert np.mean(misses) > 0.95


# --- The paper's printed sequences ---------------------------------------------------------------------------------


def printed(name: str, t: float) -> PrimitiveSequence:
    """Return the paper's sequence of a name (section V-C), flows as written there: the rightmost acts first."""
    first, second = (YAW_1, YAW_2) if name in ("x", "y", "psi") else (PITCH_1, PITCH_2)
    as_written = {
        "x": [(second, -t), (first, -t), (second, t), (first, t)],
        "y": [(second, t), (first, -t), (second, -t), (first, t), (first, t), (second, -t), (first, -t), (second, t)],
        "psi": [(first, t), (second, t), (first, -t), (second, -t), (second, -t), (first, -t), (second, t), (first, t)],
        "phi": [(ROLL_1, t)],
    }
    return PrimitiveSequence.of(reversed(as_written[{"z": "y", "theta": "psi"}.get(name, name)]))


def found_displacement(sequence: PrimitiveSequence) -> Array:
    """Return position in L and Euler angles after a sequence, as the table's columns."""
    g = flow(UNIT, sequence)
    return np.concatenate([g[:3, 3], as_euler(g[:3, :3])])


PRINTED = [
    (row["printed_sequence"], float(row["amplitude_rad"]), np.array([float(v) for v in list(row.values())[2:]]))
    for row in read_table("printed_sequences.csv")
]


@pytest.mark.parametrize(("name", "amplitude", "wanted"), PRINTED, ids=[f"{n}-{a}" for n, a, _ in PRINTED])
def test_printed_sequence_does_what_the_table_says(name: str, amplitude: float, wanted: Array) -> None:
    """Net displacement to 1e-10; with limb 2 counted the other way, or the opposite sign, it is another: the foils.

    Only "x" tells which flow acts first: y, z, psi and theta are the same read from either end.
    """
    sequence = printed(name, amplitude)
    assert_close(found_displacement(sequence), wanted, 1e-10)
    other_sign = np.where(sequence.control >= ROLL_2, -1.0, 1.0) if name != "phi" else -1.0
    assert not is_close(found_displacement(sequence.with_angles(other_sign * sequence.angle)), wanted, 1e-6)
    leftmost_first = PrimitiveSequence(sequence.control[::-1], sequence.angle[::-1])
    assert is_close(found_displacement(leftmost_first), wanted, 1e-6) == (name != "x")


def test_every_printed_sequence_is_in_the_table() -> None:
    """Six sequences at two amplitudes."""
    assert sorted({name for name, _, _ in PRINTED}) == ["phi", "psi", "theta", "x", "y", "z"]
    assert len(PRINTED) == 12


def test_printed_sequences_do_not_do_what_they_are_called() -> None:
    """The paper's lines in its own frames: y and z mainly rotate, psi and theta translate, x drifts in y."""
    done = {name: wanted for name, amplitude, wanted in PRINTED if amplitude == 1.0}
    assert abs(done["y"][3]) > 10 * abs(done["y"][1])
    assert abs(done["z"][4]) > 10 * abs(done["z"][2])
    for name, axis in (("psi", 1), ("theta", 2)):
        assert abs(found_displacement(printed(name, 1.0))[axis]) > 0.05
        assert_close(found_displacement(printed(name, 1.0))[3:], np.zeros(3), 1e-12)
    assert abs(done["x"][1]) > 0.5 * abs(done["x"][0])


def test_printed_sequences_return_to_the_collinear_shape_but_for_phi() -> None:
    """The phi sequence leaves a limb rolled."""
    for name, amplitude, _ in PRINTED:
        end = printed(name, amplitude).shapes(COLLINEAR)[-1]
        assert is_close(end, COLLINEAR, 1e-14) == (name != "phi")
