"""Proofs that there is no way: the base's middle cannot come from the start to the goal.

All of the swimmer is at least a ball of the base's radius round the base's middle. In tubes alone, where that ball fits
is the union of balls along the centrelines, as far as those are thick enough; between solids it is covered by cells of
a grid, each taken to be open if any point of it may be. If start and goal are in different parts, no way joins them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from purcell_cli.environment.scene import Scene
from purcell_cli.environment.tube import together
from purcell_cli.errors import ParameterError
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.linear import nearest_on_segments
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.swimmer import Swimmer

_PIECES = 12
"""Into how many pieces a cone of a tube is cut that is thick enough all along."""
_RATIO, _GRADED = 1.3, 40
"""Towards a place too thin each piece is shorter than the one before by this ratio, so many times."""
_CELLS = 48
"""Cells of the grid along the longest side: 100,000 distances at most; walls of three cells or more are seen."""
_MOST_BALLS = 1500
"""Pieces of tubes at most: all pairs of them are compared."""


def refuse_closed_off(
    swimmer: Swimmer, scene: Scene, clearance_m: float, start: Configuration, goal: Configuration
) -> None:
    """Refuse a goal that can be shown to be out of reach.

    Args:
        swimmer: The swimmer.
        scene: The obstacles.
        clearance_m: How far links stay from obstacles [m].
        start: The start configuration.
        goal: The goal configuration.

    Raises:
        ParameterError: The goal is shown to be out of reach.
    """
    radius = max(swimmer.radii_m[0], swimmer.body_radius_m) + clearance_m
    ends = np.stack([start.pose[:3, 3], goal.pose[:3, 3]])
    if scene.tubes and not _joined_in_tubes(scene, radius, ends):
        raise ParameterError(
            f"goal: a way as wide as the swimmer is, {2.0 * radius:.6g} m, through the tubes to the goal is wanted, "
            f"found a place too narrow"
        )
    if len(scene.tubes) < len(scene.obstacles) and not _joined_in_grid(scene, radius, ends):
        raise ParameterError("goal: a place that is not closed off from the start is wanted, found no way between them")


def too_narrow(scene: Scene, radius_m: float, start: Array, goal: Array) -> bool:
    """Return whether no way so wide to both sides leads through the tubes from one pose to another. Shapes (4, 4)."""
    return bool(scene.tubes) and not _joined_in_tubes(scene, radius_m, np.stack([start[:3, 3], goal[:3, 3]]))


def _joined_in_tubes(scene: Scene, radius: float, ends: Array) -> bool:
    """Return whether a ball may get through the tubes from one point to another."""
    begins, sides, rooms = [], [], []
    for first, way, thick, change in zip(*together(list(scene.tubes)), strict=True):
        edges = _edges(float(thick) - radius, float(change))
        begins.append(first + edges[:-1, None] * way)
        sides.append(np.diff(edges)[:, None] * way)
        rooms.append(np.maximum(thick + edges[:-1] * change, thick + edges[1:] * change) - radius)
    begin, side, room = np.concatenate(begins), np.concatenate(sides), np.concatenate(rooms)
    n = len(begin)
    if n > _MOST_BALLS:
        return True
    a, b = np.triu_indices(n, 1)
    apart = nearest_on_segments(begin[a] - begin[b], side[a], side[b])[:, 2]
    touch = apart <= room[a] + room[b]
    label = np.arange(n)
    for i, j in zip(a[touch].tolist(), b[touch].tolist(), strict=True):
        if label[i] != label[j]:
            label[label == label[j]] = label[i]
    inside = []
    for end in ends:
        off = nearest_on_segments(np.tile(end, (n, 1)) - begin, np.zeros((n, 3)), side)[:, 2]
        inside.append({int(k) for k in label[off <= room]})
    return bool(inside[0] & inside[1])


def _edges(room: float, change: float) -> Array:
    """Return where a cone is cut, from 0 to 1: what is too thin is left out, and towards it pieces become short."""
    if room >= 0.0 and room + change >= 0.0:
        return np.linspace(0.0, 1.0, _PIECES + 1)
    if room < 0.0 and room + change < 0.0:
        return np.zeros(1)
    thin = -room / change
    end = 1.0 if change > 0.0 else 0.0
    shorter = np.cumprod([1.0, *[1.0 / _RATIO] * _GRADED])  # numpy's powers depend on the processor
    graded = thin + (end - thin) * np.append(shorter, 0.0)[::-1]
    return graded if end > thin else graded[::-1]


def _joined_in_grid(scene: Scene, radius: float, ends: Array) -> bool:
    """Return whether open cells of a grid lead from one point to another; all cells at its border are joined."""
    bounds = scene.bounds()
    low, high = np.fmin(ends.min(axis=0), bounds[0]), np.fmax(ends.max(axis=0), bounds[1])
    size = float(np.max(high - low)) / (_CELLS - 4) if np.max(high - low) > 0.0 else radius
    count = np.ceil((high - low) / size).astype(np.int64) + 4
    corner = 0.5 * (low + high) - 0.5 * size * count
    axes = [corner[k] + size * (np.arange(count[k]) + 0.5) for k in range(3)]
    centres = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    free = (scene.distance(centres, centres)[0] + 0.5 * np.sqrt(3.0) * size >= radius).reshape(count)
    begin, end = (tuple(np.clip(((e - corner) / size).astype(np.int64), 0, count - 1)) for e in ends)
    free[begin] = free[end] = True
    return _flooded(free, begin, end)


def _flooded(free: NDArray[np.bool_], begin: tuple[np.int64, ...], end: tuple[np.int64, ...]) -> bool:
    """Return whether free cells lead from one to another; the border counts as joined outside."""
    border = np.ones_like(free)
    border[1:-1, 1:-1, 1:-1] = False
    border &= free
    seen = np.zeros_like(free)
    seen[begin] = True
    while True:
        wider = seen.copy()
        for axis in range(3):
            ahead, behind = ((slice(None),) * axis + (part,) for part in (slice(1, None), slice(None, -1)))
            wider[ahead] |= seen[behind]
            wider[behind] |= seen[ahead]
        if np.any(wider & border):
            wider |= border
        wider &= free
        if wider[end]:
            return True
        if np.array_equal(wider, seen):
            return False
        seen = wider
