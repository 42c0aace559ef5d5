"""Chains of rolls and loops in numpy, arc by arc: what the kernel's are compared with."""

from __future__ import annotations

import dataclasses

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, about_axis, wrapped
from purcell_cli.kernel.linear import least_steps
from purcell_cli.planner.arcs.chain import Chains
from purcell_cli.planner.arcs.roll_stroke import Rolling

HALF_TURN = np.diag([1.0, -1.0, -1.0, 1.0])


def roll_travel(rolling: Rolling, angle: Array) -> Array:
    """Return about how much joint travel rolls by angles take [rad]. Shape (...)."""
    size, table = np.abs(wrapped(angle)), rolling.table
    count = np.maximum(np.ceil(size / table.largest), 1.0)
    return np.asarray(count * np.interp(size / count, table.roll, table.travel))


def made(chains: Chains, k: int) -> tuple[Array, float]:
    """Return what one of the chains does to the base, and what it costs."""
    out, cost = np.eye(4), float(np.sum(roll_travel(chains.roll_stroke, chains.roll[k])))
    for j, roll in enumerate(chains.roll[k]):
        out = out @ se3.pose(about_axis(0, roll), np.zeros(3))
        if j == chains.which.shape[1] or chains.which[k, j] < 0:
            continue
        fan, place = chains.fans[chains.which[k, j]], (chains.bend[k, j : j + 1], chains.offset_share[k, j : j + 1])
        found, (cycle, ways) = fan.loops.at(*place), fan.loops.costs(*place)
        cost += float(chains.cycles[k, j] * cycle[0] + ways[0]) / fan.unit
        move = se3.exp(chains.cycles[k, j] * found.cycle[0, 0]) @ se3.exp(found.ways[0, 0])
        move = HALF_TURN @ move @ HALF_TURN if chains.mirrored[k, j] else move
        out = out @ (se3.inverse(move) if chains.backwards[k, j] else move)
    return out, cost


def missed(residual: Array, wanted: Array) -> float:
    """Return by how much a displacement is missed."""
    way = float(np.linalg.norm(wanted[:3, 3]))
    ahead = wanted[:3, :3].T @ wanted[:3, 3] / way
    along = float(ahead @ residual[:3])
    across = float(np.max(np.abs(residual[:3] - along * ahead)))
    return max(abs(along) / (1.0 + way / 1000.0), across / (1.0 + way), float(np.max(np.abs(residual[3:]))))


def settled(chains: Chains, wanted: Array, rounds: int) -> tuple[Chains, float, float]:
    """Return one chain changed until it makes a displacement, shape (1, 4, 4), what it misses by, and its cost."""
    low, high = chains._bounds()
    effort = 8.0 * (chains.cycles + 0.5)
    loose = np.concatenate([effort, effort, np.full_like(chains.roll, 5.0)], axis=1) ** -2.0
    best, off, paid, here = chains, np.inf, np.inf, chains
    for k in range(rounds + 1):
        (residual, columns), (_, slope) = here.residuals(wanted), here.costs()
        size, cost = missed(residual[0], wanted[0]), made(here, 0)[1]
        if cost < paid if max(size, off) < 3e-3 else size < off:
            best, off, paid = here, size, cost
        if k < rounds:
            x = here._unknown
            step = least_steps(columns, -residual, -2.0 * loose * slope, loose, low - x, high - x)
            here = here._with(x + step * min(1.0, 0.3 / np.max(np.abs(step))))
    return dataclasses.replace(best), off, paid
