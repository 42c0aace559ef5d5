"""The check of a trajectory file: does it start, move and end as it must?"""

from __future__ import annotations

import dataclasses

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, as_euler, as_vector, from_euler, from_quaternion
from purcell_cli.mechanics.configuration import Configuration, Deviation
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.clearance import Clearance, least_clearance
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.verification.certificate import Certificate, judged
from purcell_cli.verification.extrapolation import Rows
from purcell_cli.verification.replay import replay

_RATE_SLACK = 1e-9
"""By which part of itself the joint rate may be exceeded: above the rounding of a rate that is written and read,
and below what anybody would call faster."""


@dataclasses.dataclass(frozen=True, slots=True)
class Verification:
    """What the check of a trajectory file found.

    Attributes:
        start: How far the first row is from the start configuration.
        certificate: What the re-integration of its controls found.
        faults: What is wrong, in words; nothing where all holds.
        clearance: How near the limbs come to each other, where all holds.
    """

    start: Deviation
    certificate: Certificate
    faults: tuple[str, ...]
    clearance: Clearance | None

    @property
    def holds(self) -> bool:
        """Whether the file starts at the start, moves by the flow and ends at the goal."""
        return not self.faults


def verify(
    table: Table,
    start: Configuration,
    goal: Configuration,
    swimmer: Swimmer,
    tolerance_l: float,
    tolerance_rad: float,
) -> Verification:
    """Check a trajectory file against a start and a goal.

    Its controls are replayed by another method from the start configuration; the end, and every
    row, must be where the file says.

    Args:
        table: What the file says.
        start: The start configuration.
        goal: The goal configuration.
        swimmer: The swimmer.
        tolerance_l: Position tolerance, in units of L.
        tolerance_rad: Angle tolerance [rad].
    """
    limit = tolerance_l * swimmer.length_m
    poses, shapes = se3.pose(from_quaternion(table.base), table.position_m), from_quaternion(table.limbs)
    found = replay(swimmer, start, table.time_s, table.rate_rad_s, True, tolerance_l, tolerance_rad)
    certificate = judged(found, goal, limit, tolerance_rad)
    first = Configuration(poses[0], shapes[0])
    faults = [
        *_off("first row against the start", first, start, limit, tolerance_rad),
        *_off("re-integrated end against the goal", found.end, goal, limit, tolerance_rad),
        *_off("last row against the goal", Configuration(poses[-1], shapes[-1]), goal, limit, tolerance_rad),
        *_rows(table, poses, shapes, found.row, found.pose, found.shape, limit, tolerance_rad),
        *_phases(table),
        *_controls(table, swimmer),
        *_angles(table, poses, shapes, tolerance_rad),
    ]
    seconds = np.append(np.diff(table.time_s), 0.0)
    near = None if faults else least_clearance(swimmer, Pieces(shapes, table.rate_rad_s, seconds))
    return Verification(Deviation.between(first, start), certificate, tuple(faults), near)


def _off(label: str, found: Configuration, wanted: Configuration, limit_m: float, limit_rad: float) -> list[str]:
    """Return what is off, in which coordinate and by how much."""
    out = []
    gap = found.pose[:3, 3] - wanted.pose[:3, 3]
    if np.linalg.norm(gap) > limit_m:
        parts = ", ".join(f"{axis} by {value:+.3e} m" for axis, value in zip("xyz", gap, strict=True))
        out.append(f"{label}: base position off in {parts} (tolerance {limit_m:.1e} m)")
    pairs = [
        ("base", found.pose[:3, :3], wanted.pose[:3, :3]),
        ("limb 1", found.shape[0], wanted.shape[0]),
        ("limb 2", found.shape[1], wanted.shape[1]),
    ]
    for name, here, there in pairs:
        turn = as_vector(there.T @ here)
        if np.linalg.norm(turn) > limit_rad:
            parts = ", ".join(f"{axis} by {value:+.3e} rad" for axis, value in zip("xyz", turn, strict=True))
            out.append(f"{label}: {name} orientation off about {parts} (tolerance {limit_rad:.1e} rad)")
    return out


def _rows(
    table: Table, poses: Array, shapes: Array, row: Rows, pose: Array, shape: Array, limit_m: float, limit_rad: float
) -> list[str]:
    """Return the first row that is not where the replay is."""
    away = np.linalg.norm(poses[row, :3, 3] - pose[:, :3, 3], axis=1) > limit_m
    away |= np.max(np.abs(poses[row, :3, :3] - pose[:, :3, :3]), axis=(1, 2)) > limit_rad
    away |= np.max(np.abs(shapes[row] - shape), axis=(1, 2, 3)) > limit_rad
    inside = np.flatnonzero(away[1:-1]) + 1
    if not len(inside):
        return []
    k = int(inside[0])
    n = int(row[k])
    label = f"line {n + 2} (t = {table.time_s[n]:.6g} s) against the re-integration"
    return _off(label, Configuration(poses[n], shapes[n]), Configuration(pose[k], shape[k]), limit_m, limit_rad)


def _phases(table: Table) -> list[str]:
    wrong = ~np.isin(table.phase, (1, 2, 3))
    wrong[1:] |= np.diff(table.phase) < 0
    if not np.any(wrong):
        return []
    n = int(np.flatnonzero(wrong)[0])
    return [f"line {n + 2}: the phases of a reconfiguration are 1, 2, 3 in this order, found {table.phase[n]:g}"]


def _controls(table: Table, swimmer: Swimmer) -> list[str]:
    out = []
    over = np.abs(table.rate_rad_s).max(axis=1) > swimmer.joint_rate_rad_s * (1 + _RATE_SLACK)
    if np.any(over):
        n = int(np.flatnonzero(over)[0])
        out.append(
            f"line {n + 2}: a joint turns at {np.abs(table.rate_rad_s[n]).max():.9g} rad/s, "
            f"more than {swimmer.joint_rate_rad_s:g}"
        )
    if np.any(table.rate_rad_s[-1] != 0.0):
        out.append(f"line {len(table.time_s) + 1}: the controls of the last row must be 0")
    return out


def _angles(table: Table, poses: Array, shapes: Array, limit_rad: float) -> list[str]:
    """Return the first row whose Euler angles are not those of its quaternion."""
    for k, (name, rotation) in enumerate(
        (("base", poses[:, :3, :3]), ("limb 1", shapes[:, 0]), ("limb 2", shapes[:, 1]))
    ):
        off = np.max(np.abs(from_euler(table.euler_rad[:, k]) - rotation), axis=(1, 2)) > max(limit_rad, 1e-9)
        if np.any(off):
            n = int(np.flatnonzero(off)[0])
            wanted = ", ".join(f"{v:.6g}" for v in as_euler(rotation[n]))
            return [f"line {n + 2}: the {name}'s Euler angles are not those of its quaternion, which are {wanted} rad"]
    return []
