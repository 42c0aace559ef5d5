"""What is shown around a motion: obstacles, waypoints, and the curve that it follows with its tolerance.

Each becomes surfaces, lines and marks in the world, which every picture draws in its own way.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from purcell_cli.environment.mesh import Mesh
from purcell_cli.environment.scene import Scene
from purcell_cli.environment.solids import HalfSpace
from purcell_cli.environment.tube import Tube
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array, as_quaternion
from purcell_cli.motion.mission import Follow, Waypoint
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.pictures.surfaces import surface, tube_round

_TRANSLUCENT, _SOLID, _FAINT = 0.12, 0.3, 0.07
"""How much of a triangle's colour covers what is behind it: the swimmer is seen inside tubes, and behind solids; what
is no wall is fainter than what is."""


@frozen_dataclass(slots=False)
class Skin:
    """A surface to draw.

    Attributes:
        of: What it is the surface of.
        triangles: Its triangles [m]. Shape (n, 3, 3).
        alpha: How much of what is behind it a triangle covers, from 0 to 1.
    """

    of: Literal["obstacle", "tolerance"]
    triangles: Array
    alpha: float


@frozen_dataclass(slots=False)
class Mark:
    """A waypoint to draw.

    Attributes:
        name: What messages call it.
        place_m: Where it is [m]. Shape (3,).
        placed: Whether it names that place; if not, the motion comes nearest there to what it does name.
        orientation: The orientation that it names, if it does. Shape (3, 3).
    """

    name: str
    place_m: Array
    placed: bool
    orientation: Array | None


@frozen_dataclass(slots=False)
class Surroundings:
    """What is around a motion.

    Attributes:
        obstacles: What stands in the water, if anything does.
        waypoints: The waypoints, each after its place in the mission's list, from 0.
        follow: The curve to follow, if there is one.
    """

    obstacles: Scene | None = None
    waypoints: tuple[tuple[int, Waypoint], ...] = ()
    follow: Follow | None = None

    @property
    def curve_m(self) -> Array:
        """The curve's points [m]; none where there is no curve. Shape (n, 3)."""
        return np.zeros((0, 3)) if self.follow is None else self.follow.curve.point_m

    def skins(self, table: Table) -> list[Skin]:
        """Return the surfaces around a motion: of each obstacle, and of the tolerance."""
        low, high = table.position_m.min(axis=0), table.position_m.max(axis=0)
        middle, reach = 0.5 * (low + high), 0.75 * float(np.max(high - low)) + 1e-9
        out = []
        for one in () if self.obstacles is None else self.obstacles.obstacles:
            alpha = _TRANSLUCENT if isinstance(one, Tube | Mesh | HalfSpace) else _SOLID
            out.append(Skin("obstacle", surface(one, middle, reach), alpha))
        if self.follow is not None:
            out.append(Skin("tolerance", tube_round(self.curve_m, self.follow.tolerance_m), _FAINT))
        return out

    def marks(self, table: Table) -> list[Mark]:
        """Return the waypoints around a motion."""
        out = []
        for index, one in self.waypoints:
            place = table.position_m[_nearest(one, table)] if one.position_m is None else one.position_m
            out.append(Mark(f"via[{index}]", place, one.position_m is not None, one.orientation))
        return out


NOTHING = Surroundings()
"""Water without anything in it, and no mission."""


def _nearest(waypoint: Waypoint, table: Table) -> int:
    """Return the first row that is nearest to the orientations that a waypoint names."""
    off = np.zeros(len(table.time_s))
    for wanted, found in (
        (waypoint.orientation, table.base),
        (waypoint.limb1, table.limbs[:, 0]),
        (waypoint.limb2, table.limbs[:, 1]),
    ):
        if wanted is not None:
            off = off + 1.0 - np.einsum("nk,k->n", found, as_quaternion(wanted)) ** 2
    return int(np.argmin(np.round(off, 12)))
