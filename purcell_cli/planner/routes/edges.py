"""Edges of a roadmap: arcs from one collinear pose to another along which the swimmer is clear of obstacles."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.environment.scene import Scene
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import hypot, matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.planner.arcs.loop_family import Fan
from purcell_cli.planner.arcs.needle_steering import steer
from purcell_cli.planner.routes.swing import Swing

_STARTS = 8
"""Starts of needle steering for an edge: the cheapest of them that is clear is taken."""
_SAMPLES = 5
"""Poses at which each third of an arc is looked at; the exact legs are bounded between all instants."""
_SIEVE = 5
"""Every fifth of those poses is looked at first."""
_PER_ARC_RAD = 4.0
"""About what the ways into and out of an arc's loop cost beside its cycles [rad]."""
_IN_PLACE = 3
"""Strokes of an arc that is tighter than the tightest loop."""
_EMPTY_RAD = 0.3
"""An arc that costs less is left out [rad]."""
_TOGETHER = 2048
"""Edges that are looked at together: bounds the memory."""


@frozen_dataclass(eq=False)
class Edge:
    """A way from one pose to another by arcs.

    Attributes:
        price: About its joint travel [rad].
        bend_rad: The bend limit of its strokes [rad].
        poses: The poses between its arcs [m]. Shape (k, 4, 4).
    """

    price: float
    bend_rad: float
    poses: Array

    def backwards(self) -> Edge:
        """Return the same way from its end to its beginning: what the swimmer swims, it can swim backwards."""
        return dataclasses.replace(self, poses=self.poses[::-1])


def room(
    scene: Scene, swing: Swing, length_m: float, clearance_m: float, poses: Array, most_m: float = np.inf
) -> Array:
    """Return how much room poses have beyond what strokes take, so much at most [m]. Shapes (..., 4, 4) to (...)."""
    wanted_m = swing.wanted_m(length_m, clearance_m)
    flat = poses.reshape(-1, 1, 4, 4)
    middle = flat[..., :3, 3] + swing.lines[:, None] * length_m * flat[..., :3, swing.aside]
    reach = swing.half * length_m * flat[..., :3, 0]
    found, _ = scene.distance((middle - reach).reshape(-1, 3), (middle + reach).reshape(-1, 3), wanted_m + most_m)
    least = np.min(found.reshape(len(flat), len(swing.lines)), axis=1)
    return np.asarray(least - wanted_m).reshape(poses.shape[:-2])


def first_with_room(
    scene: Scene, swings: Sequence[Swing], length_m: float, clearance_m: float, poses: Array
) -> NDArray[np.int64]:
    """Return which of some swings first has room at poses; how many there are if none. Shapes (n, 4, 4) to (n,)."""
    out, left = np.full(len(poses), len(swings)), np.arange(len(poses))
    for k, swing in enumerate(swings):
        fits = room(scene, swing, length_m, clearance_m, poses[left], 0.0) >= 0.0
        out[left[fits]], left = k, left[~fits]
    return out


def clear_edges(
    scene: Scene | None,
    swing: Swing,
    length_m: float,
    clearance_m: float,
    begin: Array,
    end: Array,
    plane: str | None = None,
) -> list[Edge | None]:
    """Return the cheapest ways between poses that are clear of obstacles; None where there is none.

    Args:
        scene: The obstacles; None in empty water.
        swing: The room that strokes take.
        length_m: The swimmer's L [m].
        clearance_m: How far links stay from obstacles [m].
        begin: The poses where the edges begin [m]. Shape (n, 4, 4).
        end: Where they end [m]. Shape (n, 4, 4).
        plane: The axis of the hinges that keep the swimmer in a plane, if there are such.
    """
    out: list[Edge | None] = [None] * len(begin)
    for low in range(0, len(begin), _TOGETHER):
        here, there = begin[low : low + _TOGETHER], end[low : low + _TOGETHER]
        wanted = matmul(se3.inverse(here), there)
        wanted[:, :3, 3] /= length_m
        found = steer(se3.normalised(wanted), swing.loops, _STARTS, plane=plane)
        if not len(found.arc):
            continue
        each = swing.loops.cost(found.arc[..., 0], hypot(found.arc[..., 1], found.arc[..., 2]))
        strokes = np.where(_tight(swing.loops, found.arc)[0], _IN_PLACE, 1) * (each > _EMPTY_RAD)
        price = np.sum(each, axis=1) + _PER_ARC_RAD * np.maximum(np.sum(strokes, axis=1), 1)
        order = np.lexsort((np.round(price, 6), found.displacement))
        open_ = np.ones(len(here), dtype=bool)
        rank = np.arange(len(order)) - np.searchsorted(found.displacement[order], found.displacement[order])
        for k in range(int(rank.max(initial=-1)) + 1):
            some = order[(rank == k) & open_[found.displacement[order]]]
            if not len(some):
                continue
            which = found.displacement[some]
            ends, along = swept(swing.loops, found.arc[some], here[which], length_m)
            clear = np.arange(len(along)) if scene is None else _clear(scene, swing, length_m, clearance_m, along)
            for n in clear.tolist():
                busy = np.flatnonzero(each[some[n]] > _EMPTY_RAD)
                inner = ends[n, busy[:-1]]
                out[low + int(which[n])] = Edge(float(price[some[n]]), swing.bend_rad, inner)
                open_[which[n]] = False
    return out


def _clear(scene: Scene, swing: Swing, length_m: float, clearance_m: float, along: Array) -> NDArray[np.int64]:
    """Return which ways have room at all their poses; few of those tell of most. Shape (n, m, 4, 4)."""
    left = np.arange(len(along))
    for first in range(_SIEVE):
        found = room(scene, swing, length_m, clearance_m, along[left, first::_SIEVE], 0.0)
        left = left[np.min(found, axis=1, initial=np.inf) >= 0.0]
    return left


def swept(loops: Fan, arcs: Array, begin: Array, length_m: float) -> tuple[Array, Array]:
    """Return where arcs end, and poses along them.

    An arc tighter than the tightest loop is swum half its turn forwards and half backwards (see `Fan.ways`).

    Args:
        loops: The loops that swim the arcs.
        arcs: Advance [L] and turns about y and z [rad] of each. Shape (n, m, 3).
        begin: Where the first begins [m]. Shape (n, 4, 4).
        length_m: The swimmer's L [m].

    Returns:
        Poses at the ends of arcs, shape (n, m, 4, 4), and along them, shape (n, 15 m + 1, 4, 4) [m].
    """
    n, m = arcs.shape[:2]
    tight, reach = _tight(loops, arcs)
    share = 0.5 * (1.0 + np.abs(arcs[..., 0]) / np.where(reach > 0.0, reach, 1.0))
    way = np.where(arcs[..., 0] < 0.0, -reach, reach)
    advances = np.where(
        tight[..., None], np.stack([0.5 * share * way, -(1.0 - share) * way, 0.5 * share * way], axis=-1), 0.0
    )
    turned = np.where(tight[..., None], np.stack([0.5 * share, 1.0 - share, 0.5 * share], axis=-1), 1.0 / 3.0)
    advances = np.where(tight[..., None], advances, arcs[..., :1] / 3.0)
    twist = np.zeros((n, m * 3, 6))
    twist[..., 0] = (advances * length_m).reshape(n, -1)
    twist[..., 4] = (turned * arcs[..., 1:2]).reshape(n, -1)
    twist[..., 5] = (turned * arcs[..., 2:3]).reshape(n, -1)
    part = (np.arange(_SAMPLES) + 1.0) / _SAMPLES
    steps = se3.exp(part[:, None] * twist[:, :, None])
    here, along, ends = begin, [begin[:, None]], []
    for k in range(3 * m):
        along.append(matmul(here[:, None], steps[:, k]))
        here = along[-1][:, -1]
        if k % 3 == 2:
            ends.append(here)
    return np.stack(ends, axis=1), np.concatenate(along, axis=1)


def _tight(loops: Fan, arcs: Array) -> tuple[NDArray[np.bool_], Array]:
    """Return which arcs are tighter than the tightest loop, and how far that would advance [L]. (..., 3) to (...)."""
    reach = hypot(arcs[..., 1], arcs[..., 2]) * abs(loops.advance[-1] / loops.turn[-1])
    return np.abs(arcs[..., 0]) < 0.97 * reach, reach
