"""A trajectory's controls on another swimmer: where it ends, and which stroke lost most.

The controls are integrated by the flow, row by row, from the trajectory's first row; no planner has a part in it.
A uniform stream carries the swimmer along as it is. Beside a wall: `beside_wall`. Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.feedback.beside_wall import poses_beside
from purcell_cli.feedback.noise import NO_NOISE, Noise
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array, as_euler, from_quaternion, wrapped
from purcell_cli.kernel.flow import played, with_twice_the_digits
from purcell_cli.kernel.shapes import shapes_along
from purcell_cli.mechanics.bead_table import REACH_RAD
from purcell_cli.mechanics.configuration import Configuration, Deviation
from purcell_cli.mechanics.joints import named
from purcell_cli.mechanics.lift import piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import BEND_SLACK_RAD, LimbCircles
from purcell_cli.motion.trajectory import Trajectory
from purcell_cli.motion.trajectory_table import Table


@dataclasses.dataclass(frozen=True, slots=True)
class Loss:
    """What a stroke does otherwise than planned.

    Attributes:
        phase: Its phase.
        gait: Its name.
        begins_s: When it begins [s].
        ends_s: When it ends [s].
        position_m: By how much it alone moves the end [m].
        angle_rad: By how much it alone turns the end [rad].
    """

    phase: int
    gait: str
    begins_s: float
    ends_s: float
    position_m: float
    angle_rad: float


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Simulation:
    """What a trajectory's controls make of another swimmer.

    Attributes:
        swimmer: The swimmer that swims.
        noise: What disturbs it.
        planned: The trajectory's last row.
        trajectory: What really happens, in the trajectory's rows.
        losses: What each stroke does otherwise than planned; neighbouring rows of one phase and stroke are one.
    """

    swimmer: Swimmer
    noise: Noise
    planned: Configuration
    trajectory: Trajectory
    losses: tuple[Loss, ...]

    @property
    def end(self) -> Configuration:
        """Where it ends."""
        return self.trajectory.end

    @property
    def off(self) -> Deviation:
        """How far that is from where the trajectory ends."""
        return Deviation.between(self.end, self.planned)

    @property
    def worst(self) -> int | None:
        """The index of the stroke that lost most, a distance of L counting as a radian; None where nothing is lost."""
        sizes = [loss.position_m / self.swimmer.length_m + loss.angle_rad for loss in self.losses]
        return int(np.argmax(sizes)) if max(sizes, default=0.0) > _NOTHING else None


_NOTHING = 1e-9
"""A loss below this (L, rad) is rounding."""


def simulate(table: Table, swimmer: Swimmer, noise: Noise = NO_NOISE, begun: Array | None = None) -> Simulation:
    """Return what a trajectory's controls make of a swimmer.

    Args:
        table: The trajectory.
        swimmer: The swimmer that swims.
        noise: What disturbs it.
        begun: The base's pose where it begins, where that is not the trajectory's first row [m]. Shape (4, 4).

    Raises:
        ParameterError: Controls that still act in the last row, bends that the swimmer's model does not know, or a wall
            that it touches.
    """
    if np.any(table.rate_rad_s[-1] != 0.0):
        raise ParameterError("a last row without control is wanted, found one whose joints turn")
    first, last = (_configuration(table, row) for row in (0, -1))
    shape, rates, stream = noise.disturbed(first.shape, table.rate_rad_s)
    seconds = np.diff(table.time_s)
    shapes = shapes_along(shape, None, rates[:-1] * seconds[:, None])
    pieces = Pieces(shapes[:-1], rates[:-1], seconds)
    if swimmer.fluid == "beads":
        _refuse_far_bends(pieces)
    begins = first.pose if begun is None else begun
    if swimmer.wall is None:
        poses = _poses(swimmer, begins, pieces)
        if np.any(stream):
            poses[:, :3, 3] += stream * (table.time_s - table.time_s[0])[:, None]
    else:
        poses = poses_beside(swimmer, swimmer.wall, begins, pieces, stream)
    names, gait = np.unique(table.gait, return_inverse=True)
    phase = table.phase.astype(np.int64)
    really = Trajectory(table.time_s.copy(), phase, gait, tuple(names.tolist()), poses, shapes, rates)
    return Simulation(swimmer, noise, last, really, _losses(table, poses))


def _poses(swimmer: Swimmer, begun: Array, pieces: Pieces) -> Array:
    """Return the base's poses before, between and after pieces, by left invariance. Shape (n + 1, 4, 4)."""
    here, out = with_twice_the_digits(begun), np.empty((len(pieces) + 1, 4, 4))
    out[:-1] = played(here, piece_displacements(swimmer, pieces), 1)[0]
    out[-1] = played(here, np.eye(4)[None], 1)[0, 0]
    return out


def _refuse_far_bends(pieces: Pieces) -> None:
    """Refuse a motion on which a limb bends further than the table of links that feel each other reaches."""
    bend = float(np.max(LimbCircles.of(pieces).largest_bends()[0], initial=0.0))
    if bend > REACH_RAD + BEND_SLACK_RAD:
        raise ParameterError(
            f"limbs bent by at most {REACH_RAD:g} rad, for links that feel each other, are wanted, found {bend:.4g} rad"
        )


def refuse_other_joints(model: Swimmer, truth: Swimmer) -> None:
    """Refuse a truth whose joints are not those that the motion is made for.

    Raises:
        ParameterError: It has others.
    """
    if model.joints != truth.joints:
        wanted, found = named(model.joints), named(truth.joints)
        raise ParameterError(f"the truth's joints: those of the model, {wanted}, are wanted, found {found}")


def off_by_coordinate(found: Configuration, wanted: Configuration) -> dict[str, list[float]]:
    """Return by how much each coordinate is off: positions [m], Euler angles (psi, theta, phi) of each link [rad]."""
    gap = found.pose[:3, 3] - wanted.pose[:3, 3]
    here, there = (np.stack([c.pose[:3, :3], *c.shape]) for c in (found, wanted))
    angles = wrapped(as_euler(here) - as_euler(there))
    return {
        "position_m": gap.tolist(),
        **{f"{link}_euler_rad": a.tolist() for link, a in zip(("base", "limb1", "limb2"), angles, strict=True)},
    }


def _configuration(table: Table, row: int) -> Configuration:
    pose = se3.pose(from_quaternion(table.base[row]), table.position_m[row])
    return Configuration(pose, from_quaternion(table.limbs[row]))


def _losses(table: Table, poses: Array) -> tuple[Loss, ...]:
    """Return what each stroke makes otherwise, seen where the planned motion ends, to first order."""
    planned = se3.pose(from_quaternion(table.base), table.position_m)
    keys = list(zip(table.phase[:-1].tolist(), table.gait[:-1].tolist(), strict=True))
    out, low = [], 0
    for (phase, gait), rows in itertools.groupby(keys):
        high = low + len(list(rows))
        wanted, made = (matmul(se3.inverse(g[low]), g[high]) for g in (planned, poses))
        after = matmul(se3.inverse(planned[high]), planned[-1])
        change = matmul(matmul(matmul(se3.inverse(after), se3.inverse(wanted)), made), after)
        twist = se3.log(se3.normalised(change))
        times = float(table.time_s[low]), float(table.time_s[high])
        sizes = (float(np.sqrt(np.sum(part * part))) for part in (twist[:3], twist[3:]))
        out.append(Loss(int(phase), str(gait), *times, *sizes))
        low = high
    return tuple(out)
