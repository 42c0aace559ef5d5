"""A box that all three links stay in, and how far a motion leaves it.

The links are capsules, so their extent along x, y and z is that of their ends, enlarged by the
radius. A joint is the end of two links; it counts with the thicker one's radius.

How fast an end can move is bounded by dissipation. The base of a swimmer on which no force acts
moves so that the dissipated power is least, hence it is no more than with the base held fast, and
a link whose end moves at v dissipates at least a quarter of its drag along its axis times v^2 (its other
points may follow at leisure: v(x) = v/4 + 3 v x / (4 L) is the least, if turning drags it as lateral drag
does). So between two instants the ends cannot have been
further out than that speed allows, and only where this may be outside is the motion looked at closer.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.reproducible import inner, matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import LimbCircles
from purcell_cli.motion.path_parts import PathParts

Rows = NDArray[np.int64]

TOLERANCE_L = 1e-5
"""How far a motion leaves its box is known to this, in units of L, or to a hundredth if that is more."""

_MOST_STRETCHES = 1 << 16
"""Stretches at most: when there are more none is cut again, and the error is reported."""

ENDS = ("joint of limb 1", "joint of limb 2", "end of limb 1", "end of limb 2", "body")
"""The points that the links' extent is measured by."""

WALLS = tuple(f"{side} {axis}" for axis in "xyz" for side in ("least", "largest"))
"""The box's walls."""


Corner = tuple[float | None, float | None, float | None]
"""A corner of a box: x, y and z [m], None where the box has no wall."""

OPEN: Corner = (None, None, None)
"""A corner without walls."""


@frozen_dataclass
class Workspace:
    """A box with walls across the world's axes, open where it has none.

    Attributes:
        min: The corner of least x, y and z [m]; None for no wall there.
        max: The opposite corner [m]; None for no wall there.

    Raises:
        ParameterError: Numbers that are not finite, a box of no extent, or one without a wall.
    """

    min: Corner = OPEN
    max: Corner = OPEN

    def __post_init__(self) -> None:
        for name in ("min", "max"):
            corner = tuple(None if v is None else float(v) for v in getattr(self, name))
            if len(corner) != 3 or not all(v is None or math.isfinite(v) for v in corner):
                raise ParameterError(f"{name}: three finite numbers, None for no wall, are wanted, found {[*corner]}")
            object.__setattr__(self, name, corner)
        if not all(low is None or high is None or low < high for low, high in zip(self.min, self.max, strict=True)):
            raise ParameterError(
                f"max: a corner above min ({list(self.min)}) in x, y and z is wanted, found {list(self.max)}"
            )
        if self.min == self.max == OPEN:
            raise ParameterError("a box with one wall or more is wanted, found none")

    @property
    def walls_m(self) -> Array:
        """Where the walls are, infinitely far where there is none [m]. Shape (2, 3), least and largest."""
        corners = zip((self.min, self.max), (-math.inf, math.inf), strict=True)
        return np.array([[far if v is None else v for v in corner] for corner, far in corners])


@frozen_dataclass
class Excess:
    """How far a motion leaves its box at most, and where.

    Attributes:
        distance_m: How far a link stands out; 0 if none ever does [m].
        end: The index in `ENDS` of what stands out furthest.
        wall: The index in `WALLS` of the wall that it passes.
        place: The index of the pose of the path after which it is.
        time_s: When, from there [s].
        error_m: The true excess is greater by at most this [m].
    """

    distance_m: float = 0.0
    end: int = 0
    wall: int = 0
    place: int = 0
    time_s: float = 0.0
    error_m: float = 0.0


_TOGETHER = 4.0
"""How many times the power that limbs alone would take those of links that feel each other may take, against the least
drag of a link among others: 1.8 over 0.6 at the most was found."""


def link_ends(swimmer: Swimmer, poses: Array, axes: Array) -> Array:
    """Return where the `ENDS` are in the world [m], k of them: the body's middle only where there is a body.

    Shapes (n, 4, 4) and (n, 2, 3) to (n, k, 3).
    """
    joints = np.zeros((len(axes), 2, 3))
    joints[:, 0, 0], joints[:, 1, 0] = swimmer.base_half_length_m, -swimmer.base_half_length_m
    arms = 2.0 * np.array(swimmer.halves_m[1:])[:, None] * np.array([1.0, -1.0])[:, None] * axes
    points = np.concatenate([joints, joints + arms], axis=1)
    if swimmer.body_radius_m:
        points = np.concatenate([points, np.zeros((len(axes), 1, 3))], axis=1)
    return np.asarray(matmul(points, np.swapaxes(poses[:, :3, :3], -1, -2)) + poses[:, None, :3, 3])


def end_speeds(swimmer: Swimmer, circles: LimbCircles) -> Array:
    """Return what the speeds of the `ENDS` in the world cannot exceed [m/s]. Shape (n, k)."""
    power, (base, one, two) = _power_and_drags(swimmer, circles)
    ends = [max(base, one), max(base, two), one, two, *([base] if swimmer.body_radius_m else [])]
    return np.asarray(np.sqrt(power[:, None] / np.array(ends)))


def middle_speed(swimmer: Swimmer, circles: LimbCircles) -> Array:
    """Return what the speed of the base's middle in the world cannot exceed [m/s]. Shape (n,)."""
    power, _ = _power_and_drags(swimmer, circles)
    base = swimmer.rod(0)
    return np.asarray(np.sqrt(power * swimmer.lateral_drag() / min(base.along, base.across)))


def turning_speed(swimmer: Swimmer, circles: LimbCircles) -> Array:
    """Return what the speed of the base's orientation cannot exceed [rad/s]. Shape (n,)."""
    power, _ = _power_and_drags(swimmer, circles)
    base = swimmer.rod(0)
    return np.asarray(np.sqrt(power * swimmer.lateral_drag() / min(base.turn, base.spin)))


def _power_and_drags(swimmer: Swimmer, circles: LimbCircles) -> tuple[Array, list[float]]:
    """Return what power the motion cannot exceed, shape (n,), and each link's least drag, over the lateral drag."""
    halves, k = swimmer.halves_m, swimmer.lateral_drag()
    spin = circles.turn * np.sqrt(inner(circles.centre, circles.centre))
    power, least = np.zeros(len(circles)), []
    for link, half in enumerate(halves):
        rod = swimmer.rod(link)
        least.append(min(0.25 * rod.along, 1.0 / (1.0 / rod.across + half * half / rod.turn)) / k)
        if link:
            held = (rod.turn + rod.across * half * half) / k * circles.speed[:, link - 1] ** 2
            power += held + rod.spin / k * spin[:, link - 1] ** 2
    if swimmer.fluid == "beads":
        power *= _TOGETHER
    return power, least


def largest_excess(
    swimmer: Swimmer,
    workspace: Workspace,
    poses: Array,
    piece: Rows,
    pieces: Pieces,
    displacements: Callable[[Swimmer, Pieces], Array],
) -> Excess:
    """Return how far links leave a box at most over a path of pieces of constant limb rates.

    A piece that is played again has the same displacement from its new place, so it is swum once.

    Args:
        swimmer: The swimmer.
        workspace: The box.
        poses: The base's pose at each beginning of a piece [m]. Shape (m, 4, 4).
        piece: Which piece begins there. Shape (m,).
        pieces: The pieces.
        displacements: Returns the base's displacements on pieces [m], to some 1e-8 L. Shape (n, 4, 4).
    """
    path = PathParts(swimmer, pieces, displacements)
    box = _Box(swimmer, workspace)
    speeds = end_speeds(swimmer, path.circles)[..., None]
    most = np.max(speeds, axis=(1, 2), initial=0.0)
    error_m = box.error_m

    def more(here: Rows, first: Array, last: Array, length: Array) -> NDArray[np.bool_]:
        nonlocal error_m
        bound = np.max(0.5 * (first + last + speeds[here] * length[:, None, None]), axis=(1, 2))
        cut = np.asarray(bound > box.best.distance_m + (box.error_m if box.best.distance_m > 0.0 else 0.0))
        cut &= most[here] * length > box.error_m
        if np.count_nonzero(cut) > _MOST_STRETCHES:
            error_m = float(np.max(bound)) - box.best.distance_m
            cut[:] = False
        return cut

    path.halve(np.arange(len(poses)), poses, piece, box.beyond, more)
    return dataclasses.replace(box.best, error_m=error_m)


def excess_of(swimmer: Swimmer, workspace: Workspace, pose: Array, shape: Array) -> Excess:
    """Return how far links stand out of a box in one configuration.

    Args:
        swimmer: The swimmer.
        workspace: The box.
        pose: The base's pose [m]. Shape (4, 4).
        shape: The shape. Shape (2, 3, 3).
    """
    box = _Box(swimmer, workspace)
    box.beyond(np.zeros(1, dtype=np.int64), np.zeros(1), pose[None], shape[None, ..., 0])
    return box.best


class _Box:
    """A box, and what stood out of it furthest so far.

    Args:
        swimmer: The swimmer.
        workspace: The box.
    """

    def __init__(self, swimmer: Swimmer, workspace: Workspace) -> None:
        self.swimmer = swimmer
        base, one, two = swimmer.radii_m
        body = [swimmer.body_radius_m] if swimmer.body_radius_m else []
        self.radius = np.array([max(base, one), max(base, two), one, two, *body])[:, None]
        self.low, self.high = workspace.walls_m
        self.best = Excess()

    @property
    def error_m(self) -> float:
        """How exactly the furthest is to be found [m]."""
        return max(TOLERANCE_L * self.swimmer.length_m, 0.01 * self.best.distance_m)

    def beyond(self, row: Rows, time: Array, poses: Array, axes: Array) -> Array:
        """Return how far each end is beyond each wall [m]. Shape (n, k, 6)."""
        place = link_ends(self.swimmer, poses, axes)
        out = np.stack([self.low - place + self.radius, place - self.high + self.radius], axis=-1)
        out = out.reshape(len(place), len(self.radius), 6)
        if len(out):
            k, end, wall = np.unravel_index(int(np.argmax(out)), out.shape)
            if out[k, end, wall] > self.best.distance_m:
                self.best = Excess(float(out[k, end, wall]), int(end), int(wall), int(row[k]), float(time[k]))
        return out
