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
from purcell_cli.kernel.triangles import from_triangles

_LEAF = 8
"""Triangles of a leaf at most: fewer make more boxes than they save triangles."""
_FLAT = 1e-9
"""A mesh that encloses less than so much of its surface times its size encloses nothing: files have some 7 digits."""
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
        object.__setattr__(self, "_tree", tree(self.triangles))

    def distance(self, first: Array, last: Array) -> Array:
        """Return the distances of segments from the surface [m]. Shapes (n, 3) to (n,)."""
        return self.within(first, last, np.full(len(first), np.inf))

    def within(self, first: Array, last: Array, most: Array) -> Array:
        """Return the distances of segments, or of those that are farther than this, this [m]. (n, 3), (n,) to (n,)."""
        return from_triangles(first, last, most, *self.__dict__["_tree"])

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
    """Return how many edges are not shared by two triangles that run along them in opposite directions.

    Args:
        triangles: Their corners [m]. Shape (n, 3, 3).
    """
    _, corner = np.unique(triangles.reshape(-1, 3), axis=0, return_inverse=True)
    corner = corner.reshape(-1, 3)
    corner = corner[(corner[:, 0] != corner[:, 1]) & (corner[:, 1] != corner[:, 2]) & (corner[:, 2] != corner[:, 0])]
    edges = np.concatenate([corner[:, [0, 1]], corner[:, [1, 2]], corner[:, [2, 0]]])
    forth = edges[:, 0] < edges[:, 1]
    _, edge = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True)
    return int(np.count_nonzero(np.bincount(edge.ravel(), weights=np.where(forth, 1.0, -1.0))))


def tree(triangles: Array) -> tuple[Array, Array]:
    """Return the boxes and the leaves of a tree of triangles, for `from_triangles`. (2 m - 1, 2, 3), (m, w, 3, 3)."""
    order = np.arange(len(triangles))
    levels = max(int(np.ceil(np.log2(max(len(order) / _LEAF, 1.0)))), 0)
    groups, centre = [order], triangles.mean(axis=1)
    for _ in range(levels):
        halves = []
        for group in groups:
            spread = np.ptp(centre[group], axis=0)
            ranked = group[np.argsort(centre[group, int(np.argmax(spread))], kind="stable")]
            halves += [ranked[: (len(ranked) + 1) // 2], ranked[(len(ranked) + 1) // 2 :]]
        groups = halves
    width = max(len(g) for g in groups)
    leaves = triangles[np.array([np.resize(g, width) for g in groups])]
    found = leaves.reshape(len(groups), -1, 3)
    boxes = [np.stack([found.min(axis=1), found.max(axis=1)], axis=1)]
    while len(boxes[0]) > 1:
        below = boxes[0].reshape(-1, 2, 2, 3)
        boxes.insert(0, np.stack([below[:, :, 0].min(axis=1), below[:, :, 1].max(axis=1)], axis=1))
    return np.concatenate(boxes), leaves
