"""The kernel's searches for a motion's angles end where the same searches do, step by step in Python."""

from __future__ import annotations

import functools
import signal

import numpy as np
import pytest
from helpers import bent
from reference.descent import Search, approached

from purcell_cli.geometry import se3
from purcell_cli.kernel.descent import Descent
from purcell_cli.mechanics.collocation import flow_of
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import ROUGH, flow
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.planner.limbs.limb_rotations import rotations_to
from purcell_cli.planner.refine.inequalities import ACTIVE, least_cosines, rows_besides
from purcell_cli.planner.refine.minimum_travel import offered
from purcell_cli.planner.refine.segments import Segment
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refine.trust_region import FIRST_REACH, LARGEST_REACH, LEAST_REACH

BODY = Swimmer().scaled()
BEND = 0.8
LOOP = PrimitiveSequence.of([("limb1 yaw", 0.5), ("limb2 yaw", 0.6), ("limb1 yaw", -0.5), ("limb2 yaw", -0.6)])


def motion(seed: int, meeting: bool) -> Equations:
    """Return a motion about a repeated rectangle that misses its goal, limbs that can meet or not."""
    rng = np.random.default_rng([seed, meeting])
    word = PrimitiveSequence(rng.integers(0, 6, 8), rng.uniform(-0.4, 0.4, 8))
    shape = word.shapes(COLLINEAR)[-1]
    back = [rotations_to(shape[i].T, i + 1).primitives(0) for i in (0, 1)]
    last = [rotations_to(bent(1.0, 2.2, limb)[limb - 1], limb).primitives(0) for limb in (1, 2)] if meeting else []
    parts = [
        Segment(2, (("a", 0.0, 8),), word),
        *(Segment(2, (("b", 0.0, len(some)),), some) for some in back),
        Segment(2, (("c", 0.0, 4),), LOOP, cycles=3),
        Segment(2, (("d", 0.0, 8),), LOOP.times(2), fixed=True),
        *(Segment(3, (("e", 0.0, len(some)),), some) for some in last),
    ]
    whole = functools.reduce(lambda a, b: a + b, [s.sequence.times(s.cycles) for s in parts])
    wanted = flow(BODY, whole) @ se3.exp(rng.uniform(-0.03, 0.03, 6))
    begun = Equations(BODY, parts, COLLINEAR, whole.shapes(COLLINEAR)[-1], wanted, ROUGH)
    return begun.of([s.renamed("offered", offered(s.sequence, 1)) if s.free else s for s in parts])


def descent(equations: Equations, clearance: float | None) -> Descent:
    least = least_cosines(equations.phase, equations.start, equations.goal, BEND, equations.home)
    return equations.descent(least, ACTIVE, *rows_besides(equations, clearance))


@pytest.mark.parametrize("meeting", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_motions_come_as_near_in_the_same_steps(seed: int, meeting: bool) -> None:
    """With fewer rounds of patience, the foil, some motion is given up elsewhere."""
    equations = motion(seed, meeting)
    angle, residual, derivative, shapes, off = descent(equations, None).approached(equations.angles, 3e-4, 0.25, 2, 99)
    wanted, _, missing = approached(equations, BEND, 0.25, 2)
    assert np.max(np.abs(angle - wanted)) < 1e-9
    assert off == pytest.approx(missing, rel=1e-6)
    again = equations.at(angle)
    assert np.array_equal(residual, again.residual)
    assert np.array_equal(shapes, again.shapes)
    assert np.max(np.abs(derivative - again.derivative)) < 1e-12
    assert np.max(np.abs(angle - approached(equations, BEND, 0.02, 2)[0])) > 1e-6


@pytest.mark.parametrize("own", [False, True])
@pytest.mark.parametrize("meeting", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_motions_become_as_short_in_the_same_steps(seed: int, meeting: bool, own: bool) -> None:
    """Limbs that can meet give inequalities of their own; at another price, the foil, a motion ends elsewhere."""
    equations = motion(seed, meeting)
    # Without ties, which rounding would decide.
    equations.weight = equations.weight * np.random.default_rng(seed).uniform(0.9, 1.1, len(equations.weight))
    search = Search(equations, BEND, 0.0, 300.0, own)
    begun = search.restored(search.point(equations.angles), 0.25)
    ended = search.run(begun, 3)
    given, reaches = (equations.angles, equations.weight), (FIRST_REACH, LARGEST_REACH, LEAST_REACH)
    rest = 3, reaches, 0.0
    angle, first, last = descent(equations, 0.0).shortened(*given, 300.0, *rest, np.inf, own=own)
    assert [first, last] == pytest.approx([begun.violation, ended.violation], rel=1e-5, abs=1e-8)
    assert np.max(np.abs(angle - ended.angle)) < 1e-7
    assert ended.merit < begun.merit - 0.01 or seed == 1  # which finds nothing in three steps
    other, *_ = descent(equations, 0.0).shortened(*given, 3.0, *rest, np.inf)
    assert search.point(other).merit > ended.merit + 0.01 or seed == 1
    kept, given_up, _ = descent(equations, 0.0).shortened(*given, 300.0, *rest, 1e-9)
    assert given_up == np.inf
    assert np.max(np.abs(kept - begun.angle)) < 1e-9


@pytest.mark.parametrize("seed", [0, 2])
def test_programs_end_when_little_is_promised(seed: int) -> None:
    """Where all is worth it, the foil, eight programs go further than one."""
    equations = motion(seed, False)
    given = equations.angles, equations.weight, 300.0
    rest = (FIRST_REACH, LARGEST_REACH, LEAST_REACH), np.inf, np.inf
    search = descent(equations, 0.0)
    first, _, _ = search.shortened(*given, 1, *rest)
    further, _, _ = search.shortened(*given, 8, *rest)
    assert np.max(np.abs(further - first)) > 0.01
    last, _, _ = search.shortened(*given, 8, *rest, 1.0)
    assert np.array_equal(last, first)


@pytest.mark.parametrize("seed", [0, 2])
def test_angles_with_radii_of_their_own_go_as_step_by_step(seed: int) -> None:
    """With one radius for all, the foil, a motion ends elsewhere."""
    equations = motion(seed, False)
    equations.weight = equations.weight * np.random.default_rng(seed).uniform(0.9, 1.1, len(equations.weight))
    search = Search(equations, BEND, 0.0, 300.0, True)
    ended = search.run(search.restored(search.point(equations.angles), 0.25), 7)
    given = equations.angles, equations.weight, 300.0, 7, (FIRST_REACH, LARGEST_REACH, LEAST_REACH), 0.0, np.inf
    found = [descent(equations, 0.0).shortened(*given, own=own)[0] for own in (True, False)]
    assert np.max(np.abs(found[0] - ended.angle)) < 1e-6
    assert np.max(np.abs(found[1] - ended.angle)) > 1e-4


def small(more=None, most: int = 0, watched: bool = True, **other: object) -> Descent:
    """Return a search for the angles of two primitives, some of what it is given exchanged."""
    given: dict[str, object] = {
        "controls": [2, 5],
        "given": [0.0, 0.0],
        "index": [0, 1],
        "sign": [1.0, 1.0],
        "free": 2,
        "repeats": [],
        "start": COLLINEAR,
        "wanted_inverse": np.eye(4),
        "stops": [2],
        "ends": COLLINEAR[None],
        "least": np.zeros((2, 2)),
        "fixed": [0, 0],
        "near": ACTIVE,
    }
    return Descent(flow_of(BODY, ROUGH), **(given | other), more=more, most=most, watched=watched)


def test_an_error_or_an_interrupt_between_two_points_ends_a_search() -> None:
    """The same search goes on afterwards; without what is raised it arrives."""
    heard: list[list[float]] = []

    def more(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        heard.append(angle.tolist())
        if len(heard) == 2:
            raise KeyboardInterrupt
        return np.ones(1), np.zeros((1, 2))

    search = small(more, 1)
    with pytest.raises(KeyboardInterrupt):
        search.approached([0.1, -0.2], 1e-6, 0.25, 2, 99)
    assert len(heard) == 2
    assert heard[0] == [0.1, -0.2]
    angle, *_, off = search.approached([0.1, -0.2], 1e-6, 0.25, 2, 99)
    assert off < 1e-6
    assert np.max(np.abs(angle)) < 1e-5
    with pytest.raises(ValueError, match="at most 1 inequalities"):
        small(lambda angle: (np.ones(2), np.zeros((2, 2))), 1).approached([0.1, -0.2], 1e-6, 0.25, 2, 99)
    unheard = small(watched=False).approached([0.1, -0.2], 1e-6, 0.25, 2, 99)
    assert np.array_equal(unheard[0], small().approached([0.1, -0.2], 1e-6, 0.25, 2, 99)[0])


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="needs a timer that sends a signal")
def test_what_a_signal_raises_while_the_kernel_works_ends_a_search() -> None:
    """It is raised where Python runs next: as the watcher is called, before its first line if it were a function."""

    class RungError(Exception):
        pass

    def ring(*_: object) -> None:
        raise RungError

    search = small()

    def searches() -> None:
        signal.setitimer(signal.ITIMER_REAL, 1e-3)
        for _ in range(10_000):
            search.approached([0.1, -0.2], 0.0, 1e-3, 1000, 1000)

    before = signal.signal(signal.SIGALRM, ring)
    try:
        for _ in range(20):
            with pytest.raises(RungError):
                searches()
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
    assert search.approached([0.1, -0.2], 1e-6, 0.25, 2, 99)[-1] < 1e-6


def test_a_search_may_begin_another_between_two_points() -> None:
    """Each works in memory of its own, so both go as they would alone; the one within ends elsewhere: the foil."""
    rest = 1e-6, 0.25, 2, 99
    within: list[np.ndarray] = []

    def more(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.ones(1), np.zeros((1, 2))

    def searching(angle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        within.append(small(more, 1).approached([0.3, 0.1], *rest)[0])
        return more(angle)

    alone, elsewhere = (small(more, 1).approached(begun, *rest)[0] for begun in ([0.1, -0.2], [0.3, 0.1]))
    assert np.array_equal(small(searching, 1).approached([0.1, -0.2], *rest)[0], alone)
    assert within
    assert all(np.array_equal(one, elsewhere) for one in within)
    assert not np.array_equal(alone, elsewhere)


@pytest.mark.parametrize(
    "other",
    [
        {"index": [0, 2]},
        {"index": [-2, 0]},
        {"index": [0]},
        {"index": [0.5, 1.0]},
        {"sign": [1.0]},
        {"sign": ["1", "2"]},
        {"controls": [2, 9]},
        {"controls": None},
        {"given": [0.0, 0.0, 0.0]},
        {"free": -1},
        {"repeats": [(0, 3, 2)]},
        {"start": np.eye(3)},
        {"wanted_inverse": np.eye(3)},
        {"stops": [3]},
        {"ends": COLLINEAR},
        {"least": np.zeros(2)},
        {"fixed": [0]},
    ],
)
def test_arrays_that_do_not_fit_together_are_refused(other: dict[str, object]) -> None:
    with pytest.raises((ValueError, TypeError)):
        small(**other)


def test_searches_refuse_what_they_cannot_begin_with() -> None:
    search, reaches = small(), (0.1, 0.5, 1e-4)
    for angles, weight, price in (
        ([0.1], [1.0, 1.0], 1.0),
        ([0.1, np.nan], [1.0, 1.0], 1.0),
        ([0.1, 0.1], [1.0], 1.0),
        ([0.1, 0.1], [1.0, -1.0], 1.0),
        ([0.1, 0.1], [1.0, 1.0], 0.0),
    ):
        with pytest.raises(ValueError, match="wanted"):
            search.shortened(angles, weight, price, 3, reaches, 0.0, 1.0)
    with pytest.raises(ValueError, match="reaches"):
        search.shortened([0.1, 0.1], [1.0, 1.0], 1.0, 3, (0.1, 0.5), 0.0, 1.0)
    with pytest.raises(ValueError, match="too long"):
        search.approached([1e300, 0.1], 1e-6, 0.25, 2, 99)
    assert not np.isfinite(search.approached([np.nan, 0.1], 1e-6, 0.25, 2, 99)[-1])
    nothing = small(
        **{key: [] for key in ("controls", "given", "index", "sign", "fixed")},
        free=0,
        least=np.empty((0, 2)),
        stops=[0],
    )
    assert nothing.approached([], 1e-6, 0.25, 2, 99)[-1] == 0.0
    assert nothing.shortened([], [], 1.0, 3, reaches, 0.0, 1.0)[0].shape == (0,)
