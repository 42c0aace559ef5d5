"""A trajectory's controls on another swimmer: where it ends, and which stroke lost most.

The controls are integrated by the flow, row by row, from the trajectory's first row; no planner has a part in it.
Joints whose acceleration is limited, and which cannot follow them in time, take the same path more slowly. A uniform
stream carries the swimmer along as it is. Beside a wall: `beside_wall`. Conventions: `rotations`.
"""

from __future__ import annotations

import itertools

import numpy as np
from numpy.typing import NDArray

from purcell_cli.errors import ParameterError
from purcell_cli.feedback.beside_wall import poses_beside
from purcell_cli.feedback.noise import NO_NOISE, Noise
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array, as_euler, from_quaternion, wrapped
from purcell_cli.kernel.flow import played, with_twice_the_digits
from purcell_cli.kernel.shapes import shapes_along
from purcell_cli.mechanics.configuration import Configuration, Deviation
from purcell_cli.mechanics.fluid import refuse_far_bends
from purcell_cli.mechanics.joint_motion import refuse_shape
from purcell_cli.mechanics.joints import Joints, named
from purcell_cli.mechanics.lift import piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import LimbCircles
from purcell_cli.motion.pace import slowed
from purcell_cli.motion.trajectory import Trajectory
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.verification.joints_kept import JointsKept, follow


@frozen_dataclass
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


@frozen_dataclass(eq=False)
class Simulation:
    """What a trajectory's controls make of another swimmer.

    Attributes:
        swimmer: The swimmer that swims.
        noise: What disturbs it.
        planned: The trajectory's last row.
        trajectory: What really happens, in the trajectory's rows, or in no longer ones, as fine as joints' ramps need.
        slower_s: By how much longer it takes than the trajectory says, at the pace of the swimmer's joints [s].
        losses: What each stroke does otherwise than planned; neighbouring rows of one phase and stroke are one.
    """

    swimmer: Swimmer
    noise: Noise
    planned: Configuration
    trajectory: Trajectory
    slower_s: float
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


_MOST_ROWS = 200_000
"""Rows of ramps that are as short as the file's longest, about at most: joints may be a million times slower."""

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
        ParameterError: Controls that still act in the last row or that the swimmer's joints cannot make, bends that its
            model does not know, or a wall that it touches.
    """
    _refuse_unfit_joints(table, swimmer)
    if np.any(table.rate_rad_s[-1] != 0.0):
        raise ParameterError(
            f"line {len(table.time_s) + 1}: a last row without control is wanted, found one whose joints turn"
        )
    first, last = (_configuration(table, row) for row in (0, -1))
    keys, strokes = _strokes(table)
    made = _at_the_joints_pace(table, swimmer, first, strokes)
    shape, rates, stream = noise.disturbed(first.shape, made.rates)
    seconds = np.diff(made.time_s)
    shapes = shapes_along(shape, None, rates[:-1] * seconds[:, None])
    pieces = Pieces(shapes[:-1], rates[:-1], seconds)
    if swimmer.fluid == "beads":
        refuse_far_bends(float(np.max(LimbCircles.of(pieces).largest_bends()[0], initial=0.0)))
    begins = first.pose if begun is None else begun
    if swimmer.wall is None:
        poses = _poses(swimmer, begins, pieces)
        if np.any(stream):
            poses[:, :3, 3] += stream * (made.time_s - made.time_s[0])[:, None]
    else:
        poses = poses_beside(swimmer, swimmer.wall, begins, pieces, stream)
    names, gait = np.unique(table.gait, return_inverse=True)
    phase = table.phase.astype(np.int64)
    really = Trajectory(made.time_s, phase[made.row], gait[made.row], tuple(names.tolist()), poses, shapes, rates)
    longer = float(made.time_s[-1] - table.time_s[-1])
    return Simulation(swimmer, noise, last, really, longer, _losses(table, keys, strokes, made, poses))


@frozen_dataclass(eq=False)
class _Controls:
    """Controls in time: the file's rows that they are of, (n,), when they begin [s], (n,), and their rates, (n, 6)."""

    row: NDArray[np.int64]
    time_s: Array
    rates: Array


def _at_the_joints_pace(table: Table, swimmer: Swimmer, first: Configuration, strokes: NDArray[np.int64]) -> _Controls:
    """Return a trajectory's controls as they are, or with ramps where a swimmer's joints cannot follow them."""
    seconds = np.append(np.diff(table.time_s), 0.0)
    shapes = shapes_along(first.shape, None, table.rate_rad_s * seconds[:, None])
    asked = Pieces(shapes[:-1], table.rate_rad_s, seconds)
    if swimmer.joint_acceleration_rad_s2 is None or follow(swimmer, table.time_s, asked):
        return _Controls(np.arange(len(seconds)), table.time_s.copy(), table.rate_rad_s)
    found = slowed(swimmer, asked, strokes)
    longest_s = max(float(np.max(seconds)), float(np.sum(found.seconds)) / _MOST_ROWS)
    parts = np.ceil(found.seconds / longest_s * (1.0 - 1e-12)).astype(np.int64)
    time_s = table.time_s[0] + np.concatenate([[0.0], np.cumsum(np.repeat(found.seconds / parts, parts))])
    row = np.append(np.repeat(found.row, parts), len(seconds) - 1)
    return _Controls(row, time_s, np.concatenate([np.repeat(found.rates, parts, axis=0), np.zeros((1, 6))]))


def _poses(swimmer: Swimmer, begun: Array, pieces: Pieces) -> Array:
    """Return the base's poses before, between and after pieces, by left invariance. Shape (n + 1, 4, 4)."""
    here, out = with_twice_the_digits(begun), np.empty((len(pieces) + 1, 4, 4))
    out[:-1] = played(here, piece_displacements(swimmer, pieces), 1)[0]
    out[-1] = played(here, np.eye(4)[None], 1)[0, 0]
    return out


def _refuse_unfit_joints(table: Table, truth: Swimmer) -> None:
    """Refuse a trajectory that a swimmer's joints cannot make, at whatever pace.

    Raises:
        ParameterError: It begins with a shape that they cannot make, turns a limb about an axis that its joint has not,
            or leaves a range.
    """
    if truth.ball_joints:
        return
    first, seconds = _configuration(table, 0), np.append(np.diff(table.time_s), 0.0)
    refuse_shape(truth, "line 2", first)
    shapes = shapes_along(first.shape, None, table.rate_rad_s * seconds[:, None])
    asked = Pieces(shapes[:-1], table.rate_rad_s, seconds)
    faults = JointsKept(truth, first).faults(0, table.time_s, asked)
    for kind in ("joint", "range"):
        if kind in faults:
            where, _, what = faults[kind].partition(": ")
            raise ParameterError(f"{where}: a motion that the swimmer's joints can make is wanted, found {what}")


def refuse_other_joints(model: Swimmer, truth: Swimmer) -> None:
    """Refuse a truth whose joints are not those that the motion is made for.

    Raises:
        ParameterError: It has others.
    """
    if model.joints != truth.joints:
        wanted, found = named(model.joints), named(truth.joints)
        other = "" if wanted != found else f" with {_difference(model.joints, truth.joints)}"
        raise ParameterError(f"the truth's joints: those of the model, {wanted}, are wanted, found {found}{other}")


def _difference(model: Joints, truth: Joints) -> str:
    """Return the first range or rate that joints of the same kinds do not share, in words."""
    for limb, (mine, other) in enumerate(zip(model, truth, strict=True), 1):
        for key, what in (("psi_deg", "range of psi"), ("theta_deg", "range of theta"), ("rate_rad_s", "rate_rad_s")):
            own, its = getattr(mine, key), getattr(other, key)
            if own != its:
                told = ["none" if one is None else f"{one}" for one in (its, own)]
                return f"limb {limb}'s {what} {told[0]}, not {told[1]}"
    return "others"


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


def _strokes(table: Table) -> tuple[list[tuple[float, str]], NDArray[np.int64]]:
    """Return phase and name of each stroke, neighbouring rows being one, and the rows at which they begin."""
    keys = list(zip(table.phase[:-1].tolist(), table.gait[:-1].tolist(), strict=True))
    grouped = [(key, len(list(rows))) for key, rows in itertools.groupby(keys)]
    return [key for key, _ in grouped], np.cumsum([0, *(count for _, count in grouped)])[:-1]


def _losses(
    table: Table, keys: list[tuple[float, str]], strokes: NDArray[np.int64], made: _Controls, poses: Array
) -> tuple[Loss, ...]:
    """Return what each stroke makes otherwise, seen where the planned motion ends, to first order."""
    planned = se3.pose(from_quaternion(table.base), table.position_m)
    begins = np.append(strokes, len(table.time_s) - 1)
    at, out = np.searchsorted(made.row, begins), []
    for k, (phase, gait) in enumerate(keys):
        low, high = int(begins[k]), int(begins[k + 1])
        here, there = int(at[k]), int(at[k + 1])
        wanted = matmul(se3.inverse(planned[low]), planned[high])
        swum = matmul(se3.inverse(poses[here]), poses[there])
        after = matmul(se3.inverse(planned[high]), planned[-1])
        change = matmul(matmul(matmul(se3.inverse(after), se3.inverse(wanted)), swum), after)
        twist = se3.log(se3.normalised(change))
        sizes = (float(np.sqrt(np.sum(part * part))) for part in (twist[:3], twist[3:]))
        out.append(Loss(int(phase), str(gait), float(made.time_s[here]), float(made.time_s[there]), *sizes))
    return tuple(out)
