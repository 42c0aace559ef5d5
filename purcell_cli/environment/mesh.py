"""Closed triangle meshes, in a tree of boxes."""

from __future__ import annotations

import dataclasses
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from purcell_cli.environment.obstacle import Obstacle, dot
from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array, cross
from purcell_cli.kernel.linear import nearest_on_segments

_LEAF = 4
"""Triangles of a leaf at most: fewer make more boxes than they save triangles."""
_FLAT = 1e-9
"""A mesh that encloses less than so much of its surface times its size encloses nothing: files have some 7 digits."""
_BATCH = 1 << 12
"""Segments that are looked at together: bounds the memory."""
_PROBE = (0.8017837257372732, 0.5345224838248488, 0.2672612419124244)
"""The direction of the ray that tells inside from outside; along no edge that a mesh is likely to have."""


@frozen_dataclass(slots=False)
class Mesh(Obstacle):
    """A solid whose surface is a closed triangle mesh.

    Distances are from the surface, 0 where a segment meets it; a swimmer that starts outside can only come inside
    through there. `contains` tells inside from outside.

    Attributes:
        file: The file that says it.
        scale: What its coordinates are multiplied by.
        digest: A hash of the file's bytes: what is compared.
        triangles: Its triangles [m]. Shape (m, 3, 3).

    Raises:
        ParameterError: A mesh without triangles, one that is open, or one that encloses nothing.
    """

    kind: ClassVar[str] = "mesh"
    file: str
    scale: float
    digest: str
    triangles: Array = dataclasses.field(compare=False, repr=False)

    def __post_init__(self) -> None:
        if not len(self.triangles):
            raise ParameterError("a mesh of one triangle or more is wanted, found none")
        if (open_ := open_edges(self.triangles)) > 0:
            raise ParameterError(f"a closed mesh is wanted, found one with {open_} open edges")
        if self.volume_m3 == 0.0:
            raise ParameterError("a mesh that encloses a volume is wanted, found one that encloses none")
        object.__setattr__(self, "_tree", _Tree(self.triangles))

    def distance(self, first: Array, last: Array) -> Array:
        """Return the distances of segments from the surface [m]. Shapes (n, 3) to (n,)."""
        return self.within(first, last, np.full(len(first), np.inf))

    def within(self, first: Array, last: Array, most: Array) -> Array:
        """Return the distances of segments, or of those that are farther than this, this [m]. (n, 3), (n,) to (n,)."""
        tree: _Tree = self.__dict__["_tree"]
        cuts = [slice(low, low + _BATCH) for low in range(0, len(first), _BATCH)]
        return np.concatenate([np.empty(0), *(tree.distance(first[cut], last[cut], most[cut]) for cut in cuts)])

    @property
    def volume_m3(self) -> float:
        """The volume that it encloses, negative where its triangles face inwards, 0 where rounding hides it [m^3]."""
        off = self.triangles - self.triangles.mean(axis=(0, 1))
        size = max(float(np.max(np.abs(off))), np.finfo(np.float64).tiny)
        first, second, third = (off / size).transpose(1, 0, 2)
        area = cross(second - first, third - first)
        volume = float(np.sum(dot(first, area))) / 6.0
        return volume * size**3 if abs(volume) > _FLAT * float(np.sum(np.sqrt(dot(area, area)))) else 0.0

    def contains(self, points: Array) -> NDArray[np.bool_]:
        """Return which points are inside: the surface winds round them, so that it may cross itself. (n, 3) to (n,).

        Of how often a ray crosses it outwards and inwards, the difference is the winding number.
        """
        ray = np.array(_PROBE)
        corner, u, v = self.triangles[:, 0], *(self.triangles[:, k] - self.triangles[:, 0] for k in (1, 2))
        across = cross(np.broadcast_to(ray, v.shape), v)
        size = dot(u, across)
        inverse = 1.0 / np.where(size == 0.0, np.inf, size)
        out = np.empty(len(points), dtype=bool)
        for k, point in enumerate(points):
            off = point - corner
            a = dot(off, across) * inverse
            turned = cross(off, u)
            b = dot(turned, np.broadcast_to(ray, turned.shape)) * inverse
            ahead = dot(v, turned) * inverse
            crossed = (a >= 0.0) & (b >= 0.0) & (a + b <= 1.0) & (ahead > 0.0) & (size != 0.0)
            out[k] = np.sum(np.sign(size[crossed])) != 0.0
        return out

    def bounds(self) -> Array:
        """Return the least and the largest x, y and z [m]. Shape (2, 3)."""
        return np.stack([self.triangles.min(axis=(0, 1)), self.triangles.max(axis=(0, 1))])


def open_edges(triangles: Array) -> int:
    """Return how many edges are not shared by two triangles that run along them in opposite directions."""
    _, corner = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    corner = corner.reshape(-1, 3)
    corner = corner[(corner[:, 0] != corner[:, 1]) & (corner[:, 1] != corner[:, 2]) & (corner[:, 2] != corner[:, 0])]
    edges = np.concatenate([corner[:, [0, 1]], corner[:, [1, 2]], corner[:, [2, 0]]])
    forth = edges[:, 0] < edges[:, 1]
    _, edge = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    return int(np.count_nonzero(np.bincount(edge.ravel(), weights=np.where(forth, 1.0, -1.0))))


class _Tree:
    """Triangles in a binary tree of boxes whose levels are arrays: box k has the boxes 2 k and 2 k + 1 below it."""

    def __init__(self, triangles: Array) -> None:
        order = np.arange(len(triangles))
        levels = max(int(np.ceil(np.log2(max(len(order) / _LEAF, 1.0)))), 0)
        groups, centre = [order], triangles.mean(axis=1)
        for _ in range(levels):
            halves = []
            for group in groups:
                spread = np.ptp(centre[group], axis=0) if len(group) else np.zeros(3)
                ranked = group[np.argsort(centre[group, int(np.argmax(spread))], kind="stable")]
                halves += [ranked[: (len(ranked) + 1) // 2], ranked[(len(ranked) + 1) // 2 :]]
            groups = halves
        width = max(len(g) for g in groups)
        self.leaf = np.array([np.resize(g, width) if len(g) else np.zeros(width, np.int64) for g in groups])
        self.triangles = triangles
        found = triangles[self.leaf].reshape(len(groups), -1, 3)
        boxes = [np.stack([found.min(axis=1), found.max(axis=1)], axis=1)]
        while len(boxes[0]) > 1:
            below = boxes[0].reshape(-1, 2, 2, 3)
            boxes.insert(0, np.stack([below[:, :, 0].min(axis=1), below[:, :, 1].max(axis=1)], axis=1))
        self.boxes = boxes

    def distance(self, first: Array, last: Array, farthest: Array) -> Array:
        """Return the distances of segments from the nearest triangle, this at most [m]. (n, 3), (n,) to (n,)."""
        n = len(first)
        low, high = np.minimum(first, last), np.maximum(first, last)
        middle, half = 0.5 * (first + last), 0.5 * np.sqrt(dot(last - first, last - first))
        row, box = np.arange(n), np.zeros(n, dtype=np.int64)
        best = farthest.copy()
        for level, boxes in enumerate(self.boxes):
            if level:
                row, box = np.repeat(row, 2), (2 * box[:, None] + np.arange(2)).ravel()
            least, most = boxes[box, 0], boxes[box, 1]
            gap = np.maximum(np.maximum(least - high[row], low[row] - most), 0.0)
            apart = np.maximum(np.maximum(least - middle[row], middle[row] - most), 0.0)
            bound = np.maximum(np.sqrt(dot(gap, gap)), np.sqrt(dot(apart, apart)) - half[row])
            off, reach = middle[row] - 0.5 * (least + most), 0.5 * (most - least)
            np.minimum.at(best, row, np.sqrt(dot(off, off)) + np.sqrt(dot(reach, reach)))
            near = bound <= best[row]
            row, box = row[near], box[near]
        row, triangle = np.repeat(row, self.leaf.shape[1]), self.leaf[box].ravel()
        found = _from_triangles(first[row], last[row], self.triangles[triangle])
        best[:] = farthest
        np.minimum.at(best, row, found)
        return best


def _from_triangles(first: Array, last: Array, triangles: Array) -> Array:
    """Return the distances of segments from triangles, one each [m]. Shapes (n, 3) and (n, 3, 3) to (n,)."""
    way = last - first
    edges = np.roll(triangles, -1, axis=1) - triangles
    gap = first[:, None] - triangles
    found = nearest_on_segments(gap, np.repeat(way[:, None], 3, axis=1), edges)[..., 2].min(axis=1)
    corner, u, v = triangles[:, 0], edges[:, 0], -edges[:, 2]
    normal = cross(u, v)
    square = dot(normal, normal)
    flat = square <= 0.0
    unit = normal / np.sqrt(np.where(flat, 1.0, square))[:, None]
    heights = [dot(end - corner, unit) for end in (first, last)]
    for end, height in zip((first, last), heights, strict=True):
        over = _over(end - corner, u, v) & ~flat
        found = np.where(over, np.minimum(found, np.abs(height)), found)
    drop = heights[0] - heights[1]
    part = heights[0] / np.where(drop == 0.0, np.inf, drop)
    crosses = (heights[0] * heights[1] <= 0.0) & (drop != 0.0) & ~flat
    crosses &= _over(first + part[:, None] * way - corner, u, v)
    return np.asarray(np.where(crosses, 0.0, found))


def _over(off: Array, u: Array, v: Array) -> NDArray[np.bool_]:
    """Return which points are over the triangles of sides u and v. Shapes (n, 3) to (n,)."""
    uu, uv, vv, pu, pv = dot(u, u), dot(u, v), dot(v, v), dot(off, u), dot(off, v)
    size = uu * vv - uv * uv
    a, b = vv * pu - uv * pv, uu * pv - uv * pu
    return np.asarray((a >= 0.0) & (b >= 0.0) & (a + b <= size))
