"""The kernel's equations of an exact arrival, bend limits and least steps are those of numpy."""

from __future__ import annotations

import numpy as np
import pytest
from helpers import random_sequence, random_shapes
from reference import shooting as reference

from purcell_cli.geometry import se3
from purcell_cli.kernel import shooting
from purcell_cli.mechanics.collocation import flow_of
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.lift_derivatives import shape_gap
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer

FLOW = flow_of(Swimmer().scaled(), SEARCHING)
COUNT = 12


def agree(found: np.ndarray, wanted: np.ndarray, tolerance: float = 1e-13) -> None:
    """Assert that arrays agree, relatively to the largest number where that is above 1."""
    assert found.shape == wanted.shape
    assert np.max(np.abs(found - wanted), initial=0.0) <= tolerance * max(1.0, np.max(np.abs(wanted), initial=0.0))


def motion(seed: int, universal: bool) -> tuple[np.ndarray, PrimitiveSequence]:
    """Return a shape to begin with, and random primitives by ball joints, or by limb 1's psi and theta and a ball."""
    rng = np.random.default_rng([seed, universal])
    sequence = random_sequence(rng, COUNT)
    if universal:
        control = np.where(sequence.control < 3, np.where(sequence.control == 1, 1, 6), sequence.control)
        sequence = PrimitiveSequence(control, sequence.angle)
    return random_shapes(rng), sequence


@pytest.mark.parametrize("universal", [False, True])
@pytest.mark.parametrize("seed", range(10))
def test_equations_are_those_put_together_from_their_parts(seed: int, universal: bool) -> None:
    """With a shape wanted on the way and one at the end; another wanted displacement, the foil, leaves more."""
    start, sequence = motion(seed, universal)
    wanted, ends = se3.exp(np.linspace(-0.2, 0.3, 6)), random_shapes(np.random.default_rng(seed), 2)
    given = start, sequence.control, sequence.angle, [(2, 5, 3)]
    shapes, residual, derivative = FLOW.equations(*given, se3.inverse(wanted), [7, COUNT], ends)
    assert np.array_equal(shapes, sequence.shapes(start))
    pose, columns = FLOW.with_derivatives(shapes, sequence.control, sequence.angle, [(2, 5, 3)])
    agree(residual[:6], se3.log(se3.normalised(se3.inverse(wanted) @ pose)))
    agree(derivative[:6], columns, 0.0)
    for k, stop in enumerate((7, COUNT)):
        gap, slope = shape_gap(sequence[:stop], shapes[: stop + 1], ends[k])
        rows = slice(6 + 6 * k, 12 + 6 * k)
        agree(residual[rows], gap)
        agree(derivative[rows, :stop], slope)
        assert not np.any(derivative[rows, stop:])
    other = FLOW.equations(*given, np.eye(4), [7, COUNT], ends)[1]
    assert np.max(np.abs(other[:6] - residual[:6])) > 1e-2
    assert np.array_equal(other[6:], residual[6:])


@pytest.mark.parametrize("universal", [False, True])
@pytest.mark.parametrize("seed", range(10))
def test_rooms_below_the_bend_limit_are_those_of_numpy(seed: int, universal: bool) -> None:
    """Those of primitives that may change only; all, the foil, are more."""
    start, sequence = motion(seed, universal)
    shapes, fixed = sequence.shapes(start), np.arange(COUNT) % 3 // 2
    least = np.random.default_rng(seed).uniform(0.2, 0.9, (COUNT, 2))
    found = shooting.bend_rows(sequence.control, sequence.angle, shapes, least, fixed, 0.35)
    wanted = reference.bend_rows(sequence, shapes, least, fixed, 0.35)
    assert len(found[0])
    for part, other in zip(found, wanted, strict=True):
        agree(part, other)
    every = shooting.bend_rows(sequence.control, sequence.angle, shapes, least, 0 * fixed, np.inf)
    assert len(every[0]) == np.count_nonzero(sequence.axis) > len(found[0])


@pytest.mark.parametrize(("m", "k", "n"), [(6, 0, 9), (18, 12, 60), (12, 10, 40)])
@pytest.mark.parametrize("seed", range(10))
def test_least_steps_are_those_of_numpy(seed: int, m: int, k: int, n: int) -> None:
    """Without the inequalities, the foil, a step breaks one."""
    rng = np.random.default_rng([seed, m])
    arrival, missing, slope = rng.normal(size=(m, n)), 0.1 * rng.normal(size=m), rng.normal(size=(k, n))
    room = np.append(np.full(min(k, 1), -0.2), rng.uniform(-0.1, 0.5, max(k - 1, 0)))
    for reach in (1e9, 0.02):
        found = shooting.bounded_step(arrival, missing, room, slope, reach)
        agree(found, reference.bounded_step(arrival, missing, room, slope, reach), 1e-9)
    assert np.max(np.abs(found)) <= 0.02 * (1.0 + 1e-15)
    if m + k < n and k:
        whole, free = (shooting.bounded_step(arrival, missing, room[:j], slope[:j], 1e9) for j in (k, 0))
        assert np.all(room + slope @ whole > -1e-8)
        assert np.min(room + slope @ free) < -1e-3


@pytest.mark.parametrize("apart", [0.0, 1e-13, 1e-6, 0.3])
def test_least_steps_where_equations_depend_on_one_another_are_those_of_numpy(apart: float) -> None:
    """Two rows are alike, or all but alike, and ask for the same or for other things; then some of it is missed."""
    rng = np.random.default_rng(3)
    arrival, none = rng.normal(size=(12, 40)), (np.empty(0), np.empty((0, 40)))
    arrival[11] = arrival[4] + apart * rng.normal(size=40)
    for conflict in (0.0, 0.1):
        missing = 0.1 * rng.normal(size=12)
        missing[11] = missing[4] + conflict
        found = shooting.bounded_step(arrival, missing, *none, 1e9)
        wanted = reference.bounded_step(arrival, missing, *none, 1e9)
        agree(found, wanted, 1e-6)
        left = np.max(np.abs(arrival @ found + missing))
        assert (left > 0.04) == (conflict > 0.0 and apart < 1e-9)


def test_arrays_of_other_sizes_are_refused() -> None:
    start, sequence = motion(0, False)
    shapes, ends = sequence.shapes(start), start[None]
    for stops in ([COUNT + 1], [-1], [1, 2]):
        with pytest.raises(ValueError, match=r"stops|ends"):
            FLOW.equations(start, sequence.control, sequence.angle, [], np.eye(4), stops, ends)
    with pytest.raises(ValueError, match="repeats"):
        FLOW.equations(start, sequence.control, sequence.angle, [(0, COUNT + 1, 2)], np.eye(4), [COUNT], ends)
    for least, fixed in ((np.ones((COUNT, 1)), np.zeros(COUNT, int)), (np.ones((COUNT, 2)), np.zeros(3, int))):
        with pytest.raises(ValueError, match="an array of shape"):
            shooting.bend_rows(sequence.control, sequence.angle, shapes, least, fixed, 1.0)
    with pytest.raises(ValueError, match="six equations"):
        shooting.bounded_step(np.ones((5, 9)), np.ones(5), np.empty(0), np.empty((0, 9)), 1.0)
    with pytest.raises(ValueError, match="an array of shape"):
        shooting.bounded_step(np.ones((6, 9)), np.ones(5), np.empty(0), np.empty((0, 9)), 1.0)
    assert shooting.bounded_step(np.ones((6, 0)), np.ones(6), np.empty(0), np.empty((0, 0)), 1.0).shape == (0,)
