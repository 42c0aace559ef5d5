"""A mission: a start and a goal, and what is to be done between: waypoints to pass, or a curve to follow."""

from __future__ import annotations

from enum import StrEnum
from typing import Literal

import numpy as np

from purcell_cli.errors import ParameterError, refuse_types
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import apply, arctan2_of, inner, matmul, norm
from purcell_cli.geometry.rotations import Array, angle_between, from_matrix
from purcell_cli.mechanics.configuration import Configuration, Deviation
from purcell_cli.motion.curve import Curve
from purcell_cli.motion.options import member

MOST_FREE = 12
"""The most waypoints whose order is free: all orders of so many are compared by 50,000 sums."""
Part = Literal["position_m", "orientation", "limb1", "limb2"]
"""A part of a configuration that a waypoint may name."""
PARTS: tuple[Part, ...] = ("position_m", "orientation", "limb1", "limb2")
"""All of them."""
_MEETS_M, _MEETS_RAD = 1e-9, 1e-9
"""The goal of a curve to follow is its end, to rounding of what is written [m, rad]."""


class Order(StrEnum):
    """In which order waypoints are passed: as given, or as it costs least."""

    GIVEN = "given"
    FREE = "free"


@frozen_dataclass(eq=False)
class Waypoint:
    """A configuration to pass exactly in what it names; the rest is free there.

    Attributes:
        position_m: The base's position [m]; None where it is free. Shape (3,).
        orientation: The base's orientation; None where it is free. Shape (3, 3).
        limb1: Limb 1 in the base; None where it is free. Shape (3, 3).
        limb2: Limb 2 in the base; None where it is free. Shape (3, 3).

    Raises:
        ParameterError: It names nothing, or something that is no position or rotation.
    """

    position_m: Array | None = None
    orientation: Array | None = None
    limb1: Array | None = None
    limb2: Array | None = None

    def __post_init__(self) -> None:
        if self.names == ():
            raise ParameterError("a waypoint that names a position, an orientation or a limb is wanted, found nothing")
        if self.position_m is not None:
            place = np.array(self.position_m, dtype=np.float64)
            if place.shape != (3,) or not np.all(np.isfinite(place)):
                raise ParameterError(f"position_m: three finite numbers are wanted, found {place.tolist()}")
            self._keep("position_m", place)
        for name in PARTS[1:]:
            value = getattr(self, name)
            if value is not None:
                self._keep(name, from_matrix(np.array(value, dtype=np.float64)))

    def _keep(self, name: str, value: Array) -> None:
        value.setflags(write=False)
        object.__setattr__(self, name, value)

    def __repr__(self) -> str:
        return f"<Waypoint: {', '.join(self.names)}>"

    @property
    def names(self) -> tuple[Part, ...]:
        """What it names."""
        return tuple(name for name in PARTS if getattr(self, name) is not None)

    def filled(self, free: Configuration) -> Configuration:
        """Return the configuration that it names, with its free parts taken from another."""
        place = free.pose[:3, 3] if self.position_m is None else self.position_m
        turn = free.pose[:3, :3] if self.orientation is None else self.orientation
        limbs = [free.shape[k] if limb is None else limb for k, limb in enumerate((self.limb1, self.limb2))]
        return Configuration(se3.pose(turn, place), np.stack(limbs))

    def deviation(self, found: Configuration) -> Deviation:
        """Return how far a configuration is from what is named; 0 in what is free."""
        return Deviation.between(found, self.filled(found))


@frozen_dataclass(eq=False)
class Passage:
    """A waypoint of a plan, and where in the plan it is passed.

    Attributes:
        waypoint: The waypoint.
        index: Its place in the mission's list, from 0.
        block: How many blocks of the plan come before it.
    """

    waypoint: Waypoint
    index: int
    block: int


@frozen_dataclass(eq=False)
class Follow:
    """A curve to follow.

    Attributes:
        curve: The curve; the base's middle ends at its end.
        tolerance_m: How far from it the base's middle may be at any instant [m].

    Raises:
        ParameterError: A tolerance that is not above 0.
    """

    curve: Curve
    tolerance_m: float

    def __post_init__(self) -> None:
        if not 0.0 < self.tolerance_m < np.inf:
            raise ParameterError(f"tolerance_m: a finite number above 0 is wanted, found {self.tolerance_m!r}")

    def goal(self, start: Configuration) -> Configuration:
        """Return where the curve ends, in its orientation or as it is looked along; limbs collinear."""
        return Configuration(self.poses(start)[-1])

    def poses(self, start: Configuration) -> Array:
        """Return the base's poses along the curve: where it is at its points [m]. Shape (m, 4, 4).

        Where the orientation is free the swimmer looks along the curve or against it, whichever takes less turning: at
        a sharp corner it goes on backwards. At each point it turns from one step's direction to the next one's.
        """
        points = self.curve.point_m
        if self.curve.orientation is not None:
            return se3.pose(self.curve.orientation, points)
        turn, out = start.pose[:3, :3], []
        steps = np.diff(points, axis=0)
        for k, step in enumerate(steps / norm(steps)[:, None]):
            turn = turned_to(turn, step if float(inner(turn[:, 0], step)) >= -_EVEN else -step)
            out += [se3.pose(turn, points[k]), se3.pose(turn, points[k + 1])]
        return np.stack(out)


_EVEN = 1e-9
"""Directions this near to a right angle from where the swimmer looks are swum forwards."""


def turned_to(rotation: Array, direction: Array) -> Array:
    """Return an orientation turned by the least angle so that its x axis points in a direction. Shape (3, 3)."""
    local = apply(rotation.T, direction)
    across = np.array([0.0, -local[2], local[1]])
    size = float(norm(across))
    if size < 1e-12:  # along already, or straight against: any half turn will do
        across, size = np.array([0.0, 0.0, 1.0]), 1.0
        angle = 0.0 if local[0] > 0.0 else np.pi
    else:
        angle = arctan2_of(size, float(local[0]))
    return np.asarray(matmul(rotation, se3.rotation(across / size * angle)))


@frozen_dataclass(eq=False)
class Mission:
    """What is to be done: from a start to a goal through waypoints, or along a curve, past obstacles.

    Attributes:
        start: The start configuration.
        goal: The goal configuration.
        via: The waypoints.
        order: In which order they are passed.
        follow: The curve to follow, if there is one; there are then no waypoints.

    Raises:
        ParameterError: Waypoints that contradict each other, or the curve.
    """

    start: Configuration
    goal: Configuration
    via: tuple[Waypoint, ...] = ()
    order: Order = Order.GIVEN
    follow: Follow | None = None

    def __post_init__(self) -> None:
        refuse_types(start=(self.start, Configuration), goal=(self.goal, Configuration))
        object.__setattr__(self, "via", tuple(self.via))
        for k, one in enumerate(self.via):
            refuse_types(**{f"via[{k}]": (one, Waypoint)})
        object.__setattr__(self, "order", member(Order, self.order, "order"))
        if self.follow is not None:
            refuse_types(follow=(self.follow, Follow))
        if self.order == Order.FREE and len(self.via) > MOST_FREE:
            raise ParameterError(
                f"via: at most {MOST_FREE} waypoints, where their order is free, are wanted, found {len(self.via)}"
            )
        if self.order == Order.FREE and not self.via:
            raise ParameterError("order: given, where there are no waypoints, is wanted, found free")
        self._refuse_repeated()
        if self.follow is not None:
            self._refuse_off_curve(self.follow)

    @property
    def plain(self) -> bool:
        """Whether there is nothing between the start and the goal."""
        return not self.via and self.follow is None

    def fingerprint(self) -> str:
        """Return a text that changes with anything between the start and the goal."""
        parts: list[object] = [str(self.order)]
        parts += [[(name, getattr(one, name).tobytes()) for name in one.names] for one in self.via]
        if self.follow is not None:
            turns = self.follow.curve.orientation
            parts += [self.follow.tolerance_m, self.follow.curve.point_m.tobytes()]
            parts.append(None if turns is None else turns.tobytes())
        return repr(parts)

    def _refuse_repeated(self) -> None:
        """Refuse a waypoint that asks for what the one before it, the start or the goal already is."""
        ends = [("the start", self.start), ("the goal", self.goal)]
        for k, one in enumerate(self.via):
            near = [ends[0]] if k == 0 or self.order == Order.FREE else []
            near += [ends[1]] if k == len(self.via) - 1 or self.order == Order.FREE else []
            for what, end in near:
                if one.position_m is not None and one.deviation(end).within(0.0, 1e-12):
                    raise ParameterError(f"via.{k}: another place than {what} is wanted, found it again")
            earlier = range(k) if self.order == Order.FREE else range(max(k - 1, 0), k)
            for j in earlier:
                if _same(one, self.via[j]):
                    raise ParameterError(f"via.{k}: another waypoint than via[{j}] is wanted, found it again")

    def _refuse_off_curve(self, follow: Follow) -> None:
        curve = follow.curve
        if self.via:
            raise ParameterError("follow: a curve to follow or waypoints to pass, not both, are wanted, found both")
        off = float(norm(self.start.pose[:3, 3] - curve.point_m[0]))
        if off > follow.tolerance_m:
            raise ParameterError(
                f"start: a position within {follow.tolerance_m:g} m of the curve's first point is wanted, "
                f"found one {off:.6g} m from it"
            )
        off = float(norm(self.goal.pose[:3, 3] - curve.point_m[-1]))
        if off > _MEETS_M:
            raise ParameterError(f"goal: the position of the curve's last point is wanted, found one {off:.6g} m off")
        if curve.orientation is not None:
            turn = float(angle_between(curve.orientation[-1], self.goal.pose[:3, :3]))
            if turn > _MEETS_RAD:
                raise ParameterError(
                    f"goal: the orientation of the curve's last point is wanted, found one {turn:.6g} rad off"
                )


def _same(one: Waypoint, other: Waypoint) -> bool:
    """Return whether two waypoints name the same."""
    if one.names != other.names:
        return False
    return all(np.array_equal(getattr(one, name), getattr(other, name)) for name in one.names)
