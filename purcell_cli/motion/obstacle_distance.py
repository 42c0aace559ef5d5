"""How near the links come to obstacles over a whole motion: bounded between instants, not sampled.

A link is a capsule. Between two instants no point of it moves further than its ends may (see `workspace.end_speeds`:
a rigid rod's points move no faster than the faster end), and distances change no faster than points move. So on a
stretch of time h between the distances a and b, the distance is never below (a + b - v h) / 2. Stretches where that
is less than what has been found are halved until it is hardly less.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from purcell_cli.environment.scene import Scene
from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import norm
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import LimbCircles
from purcell_cli.motion.path_parts import PathParts, Rows
from purcell_cli.motion.workspace import end_speeds, link_ends

TOLERANCE_L = 1e-5
"""The least distance is known to this, in units of L, or to `_SHARE` of what it exceeds the wanted one by."""

_SHARE = 0.02
"""How exactly the least distance is found, against how far it is from the wanted one: ten times finer takes three times
as many distances."""

_TOUCHING_L, _TOUCHING = 0.02, 0.3
"""How exactly the depth of a motion that touches is found, in units of L, and against the depth: such a motion is not
taken, whatever its depth."""

_FIRST = 64
"""The places nearest to obstacles, by the base's middle, that are looked at first; what they find rules out others."""

_APART_ROWS = 16
"""How many rows apart those are that are looked at first."""

_MOST_STRETCHES = 1 << 17
"""Stretches at most: when there are more none is cut again, and the error is reported."""

LINKS = ("base", "limb 1", "limb 2", "body")
"""What messages call the links, and the sphere that the base may bear."""

_SEGMENTS = ((0, 1), (0, 2), (1, 3), (4, 4))
"""The ends of `LINKS` among `workspace.ENDS`."""


@frozen_dataclass
class Nearest:
    """The least distance between the surfaces of links and obstacles, and where it is.

    Attributes:
        distance_m: The distance, never more than the truth; negative where a link is inside an obstacle [m].
        link: The index in `LINKS` of the link.
        obstacle: The index of the obstacle.
        place: The index of the pose of the path after which it is.
        time_s: When, from there [s].
        error_m: The truth is more by at most this [m].
    """

    distance_m: float
    link: int
    obstacle: int
    place: int
    time_s: float
    error_m: float


@frozen_dataclass
class Encounter:
    """How near a motion comes to obstacles, and where it comes nearest.

    Attributes:
        distance_m: The least distance between a link's surface and an obstacle's; never more than the truth [m].
        error_m: The truth is more by at most this [m].
        link: Which link.
        obstacle: Which obstacle, from 0 on.
        between: Both, in words.
        time_s: When [s].
        phase: In which phase of the reconfiguration.
    """

    distance_m: float
    error_m: float
    link: str
    obstacle: int
    between: str
    time_s: float
    phase: int


def link_radii(swimmer: Swimmer) -> Array:
    """Return the radii of `LINKS` [m]: the body's only where there is a body. Shape (3,) or (4,)."""
    return np.array([*swimmer.radii_m, *([swimmer.body_radius_m] if swimmer.body_radius_m else [])])


def link_segments(swimmer: Swimmer, poses: Array, axes: Array) -> tuple[Array, Array]:
    """Return the ends of `LINKS` in the world [m]. Shapes (n, 4, 4) and (n, 2, 3) to (n, k, 3) each."""
    ends = link_ends(swimmer, poses, axes)
    pairs = np.array(_SEGMENTS[: 4 if swimmer.body_radius_m else 3])
    return ends[:, pairs[:, 0]], ends[:, pairs[:, 1]]


def link_distances(swimmer: Swimmer, scene: Scene, poses: Array, axes: Array) -> tuple[Array, Rows]:
    """Return how far the surfaces of `LINKS` are from the nearest obstacle [m], and which that is. Shapes (n, k)."""
    first, last = link_segments(swimmer, poses, axes)
    found, which = scene.distance(first.reshape(-1, 3), last.reshape(-1, 3))
    shape = first.shape[:2]
    return found.reshape(shape) - link_radii(swimmer), which.reshape(shape)


def least_link_distance(swimmer: Swimmer, scene: Scene, poses: Array, axes: Array) -> float:
    """Return how near the surface of any of `LINKS` comes to an obstacle in any row [m].

    Few rows are looked at first: in the others a link is as far as in the nearest of those, but for what its ends are
    away from there. Where that may be nearer than what is known, it is looked at too.

    Args:
        swimmer: The swimmer.
        scene: The obstacles.
        poses: The base's poses in the rows, one or more [m]. Shape (n, 4, 4).
        axes: The limbs' axes in base coordinates. Shape (n, 2, 3).
    """
    few = np.arange(0, len(poses), _APART_ROWS)
    known = link_distances(swimmer, scene, poses[few], axes[few])[0]
    nearest = np.minimum((np.arange(len(poses)) + _APART_ROWS // 2) // _APART_ROWS, len(few) - 1)
    ends = link_segments(swimmer, poses, axes)
    away = [norm(end - end[few[nearest]]) for end in ends]
    least = float(np.min(known))
    may = np.min(known[nearest] - np.maximum(*away), axis=1) < least
    found = link_distances(swimmer, scene, poses[may], axes[may])[0]
    return min(least, float(np.min(found, initial=np.inf)))


def nearest_obstacle(
    swimmer: Swimmer,
    scene: Scene,
    poses: Array,
    piece: Rows,
    pieces: Pieces,
    displacements: Callable[[Swimmer, Pieces], Array],
    wanted_m: float = 0.0,
) -> Nearest:
    """Return how near links come to obstacles over a path of pieces of constant limb rates.

    Args:
        swimmer: The swimmer.
        scene: The obstacles.
        poses: The base's pose at each beginning of a piece [m]. Shape (m, 4, 4).
        piece: Which piece begins there. Shape (m,).
        pieces: The pieces.
        displacements: Returns the base's displacements on pieces [m], to some 1e-8 L. Shape (n, 4, 4).
        wanted_m: The distance that is to be kept; the least one is found the more exactly the nearer it is to that [m].
    """
    path = PathParts(swimmer, pieces, displacements)
    search = _Search(swimmer, scene, wanted_m)
    speeds = _link_speeds(swimmer, path.circles)
    most = np.max(speeds, axis=1, initial=0.0)
    middle = poses[:, :3, 3]
    around = scene.distance(middle, middle)[0]
    order = np.argsort(around, kind="stable")
    reach = swimmer.base_half_length_m + 2.0 * max(swimmer.halves_m[1:]) + max(link_radii(swimmer))
    bound = around - reach - most[piece] * pieces.durations[piece]
    for some in (order[:_FIRST], order[_FIRST:]):
        near = some[bound[some] < search.best.distance_m - search.slack_m]
        search.look(path, speeds, near, poses[near], piece)
    floor = min(search.floor_m, search.best.distance_m)
    return dataclasses.replace(search.best, distance_m=floor, error_m=search.best.distance_m - floor)


def refuse_touching(
    swimmer: Swimmer, scene: Scene, clearance_m: float, name: str, configuration: Configuration
) -> None:
    """Refuse a start or goal at which a link is nearer to an obstacle than it may be.

    Args:
        swimmer: The swimmer.
        scene: The obstacles.
        clearance_m: How far links are to be from obstacles, at least [m].
        name: What the configuration is, for the message.
        configuration: The configuration.

    Raises:
        ParameterError: A link touches an obstacle, or is nearer to one than the clearance.
    """
    poses, axes = configuration.pose[None], configuration.shape[None, ..., 0]
    for k in scene.inside_meshes(link_ends(swimmer, poses, axes)[0]).tolist():
        raise ParameterError(f"{name}: all links outside of {scene.name(k)} are wanted, found one inside")
    found, which = link_distances(swimmer, scene, poses, axes)
    link = int(np.argmin(found[0]))
    distance, obstacle = float(found[0, link]), scene.name(int(which[0, link]))
    if distance < 0.0:
        raise ParameterError(
            f"{name}: all links clear of obstacles are wanted, found {LINKS[link]} {-distance:.6g} m deep in {obstacle}"
        )
    if distance < clearance_m:
        raise ParameterError(
            f"{name}: a clearance of at least {clearance_m:g} m between {LINKS[link]} and {obstacle} is wanted, "
            f"found {distance:.6g} m"
        )


def _link_speeds(swimmer: Swimmer, circles: LimbCircles) -> Array:
    """Return what the speeds of the points of `LINKS` cannot exceed [m/s]. Shape (n, k)."""
    ends = end_speeds(swimmer, circles)
    pairs = np.array(_SEGMENTS[: 4 if swimmer.body_radius_m else 3])
    return np.maximum(ends[:, pairs[:, 0]], ends[:, pairs[:, 1]])


class _Search:
    """The search for the least distance: the best so far, and what is known of what was not cut further.

    Args:
        swimmer: The swimmer.
        scene: The obstacles.
        wanted_m: The distance that is to be kept [m].
    """

    def __init__(self, swimmer: Swimmer, scene: Scene, wanted_m: float) -> None:
        self.swimmer, self.scene, self.wanted_m = swimmer, scene, wanted_m
        self.best = Nearest(np.inf, 0, 0, 0, 0.0, 0.0)
        self.floor_m = np.inf

    @property
    def slack_m(self) -> float:
        """How exactly the least distance is to be found [m]."""
        far, unit = self.best.distance_m - self.wanted_m, self.swimmer.length_m
        if far < 0.0:
            return max(_TOUCHING_L * unit, -_TOUCHING * far)
        return max(TOLERANCE_L * unit, _SHARE * far) if np.isfinite(far) else 0.0

    def look(self, path: PathParts, speeds: Array, row: Rows, poses: Array, piece: Rows) -> None:
        """Look at the pieces that begin at some places of the path.

        Args:
            path: The pieces.
            speeds: What links' speeds on them cannot exceed [m/s]. Shape (n, k).
            row: The places. Shape (r,).
            poses: The base's poses there [m]. Shape (r, 4, 4).
            piece: Which piece begins at each place of the path.
        """

        def more(here: Rows, first: Array, last: Array, length: Array) -> NDArray[np.bool_]:
            bound = np.min(0.5 * (first + last - speeds[here] * length[:, None]), axis=1)
            cut = np.asarray(bound < self.best.distance_m - self.slack_m)
            if np.count_nonzero(cut) > _MOST_STRETCHES:
                cut[:] = False
            self.floor_m = min(self.floor_m, float(np.min(bound[~cut], initial=np.inf)))
            return cut

        path.halve(row, poses, piece, self._distances, more)

    def _distances(self, row: Rows, time: Array, poses: Array, axes: Array) -> Array:
        """Return how far links are from obstacles [m], and keep the least. Shape (n, k)."""
        found, which = link_distances(self.swimmer, self.scene, poses, axes)
        if len(found):
            k, link = np.unravel_index(int(np.argmin(found)), found.shape)
            if found[k, link] < self.best.distance_m:
                obstacle, place = int(which[k, link]), int(row[k])
                self.best = Nearest(float(found[k, link]), int(link), obstacle, place, float(time[k]), 0.0)
        return found
