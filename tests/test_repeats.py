"""Cycles that come again and again are replayed once, and only where they are the same to the bit."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import random_shapes, resistance

from purcell_cli import Configuration, Swimmer
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel import certificate
from purcell_cli.verification import extrapolation, limb_rotations
from purcell_cli.verification import replay as replaying
from purcell_cli.verification.certificate import certify
from purcell_cli.verification.replay import replay

TICK = 2.0**-20
"""A step of the clock [s]."""
CYCLES, ALTERED = 10_000, 7_777


def unrolled(first: Array, period: Array, count: Array) -> list[int]:
    """Return which row stands for each, by runs."""
    return [
        int(a) + k for a, p, c in zip(first, period, count, strict=True) for _ in range(int(c)) for k in range(int(p))
    ]


@pytest.mark.parametrize("seed", range(20))
def test_runs_are_the_rows_to_the_bit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    parts = [np.tile(rng.integers(0, 4, rng.integers(1, 7)), rng.integers(1, 40)) for _ in range(rng.integers(1, 8))]
    numbers = np.concatenate(parts)
    rows = np.column_stack([numbers.astype(np.float64), np.full(len(numbers), 0.1)])
    rows[rng.integers(len(rows)), 1] = np.nextafter(0.1, 1.0)
    first, period, count = certificate.repeats(rows, 6)
    stands = unrolled(first, period, count)
    assert rows[stands].tobytes() == rows.tobytes()
    assert np.sum(period * count) == len(rows)
    assert np.all(period[count > 1] <= 6)
    # What comes once has no neighbours that are the same.
    for a, p in zip(first[count == 1], period[count == 1], strict=True):
        alone = rows[a : a + p]
        assert not np.any(np.all(alone[1:] == alone[:-1], axis=1))
    assert len(set(stands)) == np.sum(period)


def test_a_zero_of_the_other_sign_does_not_come_again() -> None:
    rows = np.array([[0.0], [-0.0], [0.0], [-0.0], [0.0]])
    first, period, count = certificate.repeats(rows, 4)
    assert (first.tolist(), period.tolist(), count.tolist()) == ([0, 4], [2, 1], [2, 1])
    assert [len(part) for part in certificate.repeats(np.empty((0, 7)), 4)] == [0, 0, 0]


def strokes(cycles: int, seed: int = 0) -> tuple[Array, Array]:
    """Return rates and durations of cycles of single turns, with a few before and after them."""
    rng = np.random.default_rng(seed)
    cycle = np.zeros((8, 6))
    cycle[np.arange(8), [2, 5, 2, 5, 1, 4, 1, 4]] = [1, 1, -1, -1, 1, 1, -1, -1]
    ends = np.eye(6)[rng.integers(0, 6, 10)]
    lasts = np.tile([0.5, 0.25, 0.5, 0.25, 0.375, 0.125, 0.375, 0.125], cycles)
    around = rng.integers(1 << 15, 1 << 18, (2, 5)) * TICK
    return np.concatenate([ends[:5], np.tile(cycle, (cycles, 1)), ends[5:]]), np.concatenate(
        [around[0], lasts, around[1]]
    )


def test_what_is_left_out_begins_where_the_first_does() -> None:
    rates, durations = strokes(300)
    kept, place = limb_rotations.once(rates, durations)
    assert len(kept) == 18
    assert rates[kept][place].tobytes() == rates.tobytes()
    assert durations[kept][place].tobytes() == durations.tobytes()
    few, every = (
        limb_rotations.turned_along(rates[kept], durations[kept]),
        limb_rotations.turned_along(rates, durations),
    )
    assert np.max(np.abs(few[np.append(place, len(kept))] - every)) < 40.0 * np.finfo(np.longdouble).eps


@pytest.mark.parametrize("off", [TICK, 2.0**-50])
def test_cycles_that_do_not_return_are_all_looked_at(off: float) -> None:
    rates, durations = strokes(50)
    durations[5 : 5 + 8 * 50 : 8] += off
    kept, place = limb_rotations.once(rates, durations)
    assert kept.tolist() == place.tolist() == list(range(len(rates)))


def test_cycles_about_axes_that_do_not_commute_are_all_looked_at() -> None:
    rates = np.tile(np.eye(6)[[0, 1, 0, 1]] * np.array([1.0, 1.0, -1.0, -1.0])[:, None], (20, 1))
    kept, _ = limb_rotations.once(rates, np.full(80, 0.25))
    assert len(kept) == 80


def motion(altered: dict[int, float]) -> tuple[Array, Array]:
    """Return times and rates of many cycles, some of whose segments last longer."""
    rates, durations = strokes(CYCLES)
    for k, by in altered.items():
        durations[5 + 8 * (ALTERED - 1) + k] += by
    return np.concatenate([[0.0], np.cumsum(durations)]), np.concatenate([rates, np.zeros((1, 6))])


@pytest.mark.parametrize(
    "altered", [{3: TICK}, {0: TICK, 2: TICK}, {4: -TICK, 5: TICK}], ids=["one", "there and back", "both"]
)
def test_one_cycle_that_is_altered_by_one_tick_is_not_taken_for_the_others(
    altered: dict[int, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    swimmer, start = Swimmer(), Configuration()
    plain, other = motion({}), motion(altered)
    goal = replay(swimmer, start, *plain).end
    assert certify(swimmer, start, goal, *plain).reached
    found = replay(swimmer, start, *other)
    assert len(found.turned) < 70
    certificate_of_other = certify(swimmer, start, goal, *other)
    assert not certificate_of_other.reached
    assert certificate_of_other.deviation.base_rad > 1e-8
    monkeypatch.setattr(replaying, "once", lambda rates, _: (np.arange(len(rates)), np.arange(len(rates))))
    every = replay(swimmer, start, *other)
    assert len(every.turned) == len(every.which) + 1
    off = np.abs(every.end_pose - found.end_pose)
    assert np.max(off[:3, :3]) < min(1e-11, found.bound.base_rad + every.bound.base_rad)
    assert np.max(off[:3, 3]) < found.bound.position_m + every.bound.position_m
    assert np.max(np.abs(every.end.shape - found.end.shape)) < 1e-15


def test_the_reach_of_small_turns_is_that_of_numpy() -> None:
    rng = np.random.default_rng(1)
    moves, which = se3.exp(0.3 * rng.normal(size=(6, 6))), rng.integers(0, 5, 200)
    place = se3.prefix_products(moves[which])[1:, :3, 3]
    arm = np.linalg.norm(place - place[-1], axis=1) + 0.7
    wanted = [np.bincount(which, arm, 6), np.bincount(which, minlength=6)]
    np.testing.assert_allclose(certificate.reach(moves, which, 0.7), wanted, rtol=1e-12)
    with pytest.raises(ValueError, match="indices of 6"):
        certificate.reach(moves, [6], 0.7)
    assert not np.any(certificate.reach(moves, [], 0.7))


def test_displacements_are_strung_as_numpy_does() -> None:
    rng = np.random.default_rng(1)
    moves, which = se3.exp(0.3 * rng.normal(size=(6, 6))), rng.integers(0, 6, 200)
    if not certificate.has_extended():
        pytest.skip("the kernel has no extended precision of numpy's")
    counts, poses = np.array([0, 3, 1, 0, 196]), moves[which].astype(np.longdouble)
    found = certificate.strung((poses - np.eye(4))[:, :3], counts)
    for out, some in zip(found, np.split(poses, np.cumsum(counts)[:-1]), strict=True):
        product = np.eye(4, dtype=np.longdouble)
        for pose in some:
            product = product @ pose
        assert np.max(np.abs(out - product)) < 1e4 * np.finfo(np.longdouble).eps
    with pytest.raises(ValueError, match="200 pieces in all"):
        certificate.strung((poses - np.eye(4))[:, :3], [3])


@pytest.mark.parametrize("finer", [1.0, 0.3])
@pytest.mark.parametrize("slenderness", [1e-3, 0.05])
def test_pieces_are_short_against_the_distance_from_a_straight_line(slenderness: float, finer: float) -> None:
    """That distance is told by an eigenvalue, here numpy's."""
    rng = np.random.default_rng(3)
    unit = Swimmer(slenderness=slenderness, drag_ratio=1.5).scaled()
    shapes, rates = random_shapes(rng, 40), rng.uniform(-1.0, 1.0, (40, 6))
    shapes[:10] = np.eye(3)
    durations = rng.uniform(0.1, 3.0, 40)
    durations[[5, 12]] = 0.0, 0.02
    turning = extrapolation.Turning.of(shapes, rates)
    swept = np.linalg.norm(rates, axis=1) * durations
    mesh = extrapolation._mesh(unit, turning, swept, durations, finer)
    for k in range(40):
        mine = mesh.owner == k
        ends = np.concatenate([mesh.start[mine], [1.0]])
        assert np.array_equal(ends[:-1] + mesh.length[mine], ends[1:])
        assert np.any(mine) == (k != 5)
    middle = (mesh.start + 0.5 * mesh.length) * durations[mesh.owner]
    limbs = np.stack(
        [shapes[mesh.owner, i] @ se3.rotation(rates[mesh.owner, 3 * i : 3 * i + 3] * middle[:, None]) for i in (0, 1)],
        axis=1,
    )
    least = np.linalg.eigvalsh(resistance(unit, limbs))[:, 0]
    wanted = np.sqrt(least / (unit.lateral_drag() * unit.bend_spread()))
    assert np.all(mesh.near <= wanted * (1.0 + 1e-6))
    assert np.all(mesh.near >= wanted * 6.0 ** (-1.0 / 16.0) * (1.0 - 1e-6))
    arc = swept[mesh.owner] * mesh.length
    nearest = np.maximum(mesh.near - 0.5 * arc, unit.roll_sharpness())
    assert np.all(arc <= finer * np.minimum(0.4 * np.maximum(mesh.near, nearest), 0.25) * (1.0 + 1e-12))
    assert np.max(mesh.length) == 1.0


def test_pieces_without_end_are_refused() -> None:
    axes = np.tile(np.eye(3)[0], (1, 2, 1))
    bounds = (1.0, 1.0, 0.0, 1e-300, 1e-300)
    with pytest.raises(ValueError, match="longer pieces"):
        certificate.pieces_of(np.ones((3, 7)), bounds, axes, np.ones((1, 2, 3)), [1.0], [1.0])
    for swept, lasts in ((np.inf, 1.0), (1.0, np.inf), (np.nan, 1.0), (1.0, np.nan)):
        try:
            owner, _ = certificate.pieces_of(np.ones((3, 7)), np.ones(5), axes, np.ones((1, 2, 3)), [swept], [lasts])
        except ValueError:
            continue
        assert not np.any(owner)
