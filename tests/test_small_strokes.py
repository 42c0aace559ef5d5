"""Small strokes of least energy are ellipses in one plane of shape space, by an eigenvalue problem.

A small loop u(t) of shape angles displaces the base by xi_k = 1/2 oint u . D_k du, D being the curvature, and
dissipates the integral of du/dt . G du/dt. So among loops of one value of l . xi, in a given time, that of least energy
is an ellipse in the plane where sum_k l_k D_k has its largest eigenvalues +-i m beside G, a circle as G measures it
(Alouges, DeSimone, Giraldi, Or, Wiezel 2019, New J. Phys. 21, 043050).
"""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

from purcell_cli import Swimmer, curvature
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, as_vector
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import SEARCHING
from purcell_cli.mechanics.lift_derivatives import flow_and_jacobian_of_moves
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.planner.refine.exact_arrival import settled
from purcell_cli.planner.refine.minimum_energy import Dissipation, EnergyProgram
from purcell_cli.planner.refine.minimum_time import minimised
from purcell_cli.planner.refine.segments import Segment
from purcell_cli.planner.refine.shooting import Equations
from purcell_cli.planner.refine.trust_region import FIRST_REACH

UNIT = Swimmer().scaled()
TOTAL_S = 10.0
CORNERS = 12
BENT = MoveSequence.of_turns(np.array([[0.2, 0.3, 0.4, -0.1, -0.4, 0.2]])).shapes(COLLINEAR)[-1]
YAWS, ALL = np.eye(6)[:, [2, 5]], np.eye(6)


@dataclasses.dataclass(frozen=True, eq=False)
class Problem:
    """Strokes around a shape that turn about a span of axes (6, p), for a direction of displacements (6,)."""

    shape: Array
    axes: Array
    direction: Array

    @property
    def metric(self) -> Array:
        """The metric of dissipation. Shape (p, p)."""
        still = Equations(
            UNIT, [Segment.by_moves(2, "any", np.zeros((1, 6)))], self.shape, self.shape, np.eye(4), SEARCHING
        )
        return np.asarray(self.axes.T @ Dissipation(still, TOTAL_S).metric(np.zeros((1, 6)))[0] @ self.axes)

    def ellipse(self, metric: Array) -> tuple[float, Array]:
        """Return the largest eigenvalue beside a metric, and half axes of unit length as that measures. (2, p)."""
        skew = self.axes.T @ np.einsum("k,kij->ij", self.direction, curvature(UNIT, self.shape)) @ self.axes
        root = np.linalg.cholesky(np.linalg.inv(metric))
        values, vectors = np.linalg.eigh(1j * (root.T @ skew @ root))
        best = math.sqrt(2.0) * vectors[:, -1]
        return float(values[-1]), np.stack([root @ best.real, root @ best.imag])

    def stroke(self, half_axes: Array, size_rad: float) -> tuple[Equations, float]:
        """Return a polygon in an ellipse, the largest component of whose half axes is given, and how far it goes."""
        t = 2.0 * math.pi * np.arange(CORNERS + 1) / CORNERS
        scaled = size_rad * half_axes / np.max(np.abs(half_axes))
        corners = np.stack([np.cos(t), np.sin(t)], axis=1) @ scaled @ self.axes.T
        shapes = np.stack([MoveSequence.of_turns(corner[None]).shapes(self.shape)[-1] for corner in corners])
        turn = as_vector(np.swapaxes(shapes[:-1], -1, -2) @ shapes[1:]).reshape(-1, 6)
        made, _ = flow_and_jacobian_of_moves(UNIT, MoveSequence.of_turns(turn), shapes[0], SEARCHING, [])
        free = None if self.axes.shape[1] == 6 else self.axes
        segment = Segment.by_moves(2, "any", turn, tie=free)
        motion = Equations(UNIT, [segment], shapes[0], shapes[0], made, SEARCHING)
        return motion, abs(float(self.direction @ se3.log(made)))

    def disturbed(self, motion: Equations) -> Equations:
        """Return a motion whose turns are off by half of the largest."""
        (segment,) = motion.segments
        noise = np.random.default_rng(3).normal(size=(CORNERS, self.axes.shape[1])) @ self.axes.T
        noise = 0.5 * np.max(np.abs(segment.turn)) * (noise - noise.mean(axis=0))
        return motion.of([segment.with_turns(segment.turn + noise)])

    def offset_share(self, motion: Equations, metric: Array, half_axes: Array) -> float:
        """Return which part of a loop is out of the plane of half axes, as a metric measures it."""
        root = np.linalg.cholesky(metric)
        corners = np.cumsum(motion.segments[0].turn @ self.axes, axis=0)
        corners, plane = (corners - corners.mean(axis=0)) @ root, half_axes @ root
        out = corners - corners @ plane.T @ plane
        return float(np.linalg.norm(out) / np.linalg.norm(corners))


def energy(motion: Equations) -> float:
    return EnergyProgram(motion, TOTAL_S).cost(motion.at(motion.angles).turn)


PROBLEMS = {
    "along x by yaws": Problem(COLLINEAR, YAWS, np.eye(6)[0]),
    "some direction, with bent limbs": Problem(BENT, ALL, np.random.default_rng(1).normal(size=6)),
}


@pytest.mark.parametrize("name", PROBLEMS)
def test_a_small_stroke_of_least_energy_is_the_ellipse_of_the_eigenvalue_problem(name: str) -> None:
    """In energy and in its plane, better the smaller it is; circles of angles (the foil) take more for their way."""
    problem = PROBLEMS[name]
    metric, pi = problem.metric, CORNERS * math.tan(math.pi / CORNERS)  # the latter of a polygon
    most, half_axes = problem.ellipse(metric)
    _, circle = problem.ellipse(np.eye(len(metric)))
    excess, offset_share = [], []
    for size in (0.1, 0.05):
        played, way = problem.stroke(half_axes, size)
        begun = problem.disturbed(played)
        best, off = settled(minimised(begun, EnergyProgram(begun, TOTAL_S), 60, FIRST_REACH).motion)
        least = 4.0 * pi / (most * TOTAL_S)  # per way
        excess.append(energy(best) / way / least - 1.0)
        offset_share.append(problem.offset_share(best, metric, half_axes))
        round_one, other_way = problem.stroke(circle, size)
        assert off < 1e-10
        assert energy(begun) > 1.2 * energy(best)
        assert energy(round_one) / other_way > 1.05 * energy(best) / way
    assert abs(excess[0]) < 0.09
    assert abs(excess[1]) < max(0.6 * abs(excess[0]), 0.01)  # the latter is what the search leaves
    assert offset_share[0] < 0.1
    assert offset_share[1] < max(0.65 * offset_share[0], 1e-12)
