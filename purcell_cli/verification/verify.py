"""The check of a trajectory file: does it start, move and end as it must, and keep its limits?

Its rows may come in parts, so that a file of millions of rows takes little memory.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, as_euler, as_vector, from_euler, from_quaternion
from purcell_cli.mechanics.bead_table import tabulated
from purcell_cli.mechanics.configuration import Configuration, Deviation
from purcell_cli.mechanics.joint_motion import refuse_shape
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.coordinates import refuse_large
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.verification.certificate import Certificate
from purcell_cli.verification.extrapolation import Resistances, segment_displacements
from purcell_cli.verification.joints_kept import too_fast
from purcell_cli.verification.limits_kept import NOTHING_MORE, LimitsKept, Wanted
from purcell_cli.verification.replay import Replay, replay
from purcell_cli.verification.waypoints_passed import Passing, WaypointsPassed

_PART = 0.1
"""Each part of a trajectory is replayed so well that its bound is small against this part of the tolerance."""
_MOST_TURNED_RAD = 100.0
"""A row whose controls turn farther before the next one is not looked at [rad]: to integrate it would take long."""

_LOOKED_AT = 64
"""Rows whose motion is compared with the swimmer's, to tell whether it can have made them."""
_ROUNDING = 1e-14
"""What writing poses as numbers may change [L, rad], a part of the coordinates."""
MISFIT = 1e-6
"""A larger part of a row's motion that is not the swimmer's is not the rounding of a file."""


@frozen_dataclass
class Verification:
    """What the check of a trajectory file found.

    Attributes:
        start: How far the first row is from the start configuration.
        certificate: What the re-integration of its controls found.
        limits: How near it comes to its limits.
        waypoints: Where it passes its waypoints.
        faults: What is wrong, in words; nothing where all holds.
    """

    start: Deviation
    certificate: Certificate
    limits: LimitsKept
    waypoints: tuple[Passing, ...]
    faults: tuple[str, ...]

    @property
    def holds(self) -> bool:
        """Whether the file starts at the start, moves by the flow, keeps its limits and ends at the goal."""
        return not self.faults


def verify(
    parts: Iterable[Table],
    start: Configuration,
    goal: Configuration,
    swimmer: Swimmer,
    tolerance_l: float,
    tolerance_rad: float,
    wanted: Wanted = NOTHING_MORE,
    resistances: Resistances = tabulated,
) -> Verification:
    """Check a trajectory against a start and a goal.

    Its controls are replayed by another method from the start configuration; the end, and every
    row, must be where the trajectory says.

    Args:
        parts: The trajectory, in parts of which each begins with the last row of the one before; there is one at least.
        start: The start configuration.
        goal: The goal configuration.
        swimmer: The swimmer.
        tolerance_l: Position tolerance, in units of L.
        tolerance_rad: Angle tolerance [rad].
        wanted: The limits that it must keep besides the bend limit.
        resistances: Of links that feel each other: from their table, or from the beads themselves.

    Raises:
        ParameterError: A coordinate of the start or the goal too large to be said within the tolerance.
        ParameterError: A start or goal that the joints cannot make.
    """
    for name, configuration in (("start", start), ("goal", goal)):
        refuse_large(swimmer, name, configuration, tolerance_l)
        refuse_shape(swimmer, name, configuration)
    limit = tolerance_l * swimmer.length_m
    kept = LimitsKept(swimmer, start, goal, wanted)
    faults: dict[str, list[str]] = {}
    found: Replay | Configuration = start
    ends: list[tuple[Array, Deviation]] = []
    passed = WaypointsPassed(wanted.via, wanted.order, limit, tolerance_rad)
    first, row, segments, integrated, again = start, 0, 0, 0, len(wanted.via)
    for table in parts:
        poses, shapes = se3.pose(from_quaternion(table.base), table.position_m), from_quaternion(table.limbs)
        if not ends:
            first = Configuration(poses[0], shapes[0])
            faults["start"] = _off("first row against the start", first, start, limit, tolerance_rad)
            faults["swimmer"] = _swimmer(table, swimmer)
        care = _PART * tolerance_l, _PART * tolerance_rad
        found = replay(swimmer, found, table.time_s, table.rate_rad_s, True, *care, resistances)
        ends.append((found.end.pose, found.bound))
        segments, integrated = segments + len(found.which), integrated + len(found.moves.fine)
        for kind, new in (
            ("rows", _rows(table, poses, shapes, found, row, limit, tolerance_rad)),
            ("phases", _phases(table, row, again)),
            ("controls", _controls(table, shapes, swimmer, row)),
            ("lengths", _lengths(table, tolerance_rad, row)),
            ("angles", _angles(table, poses, shapes, tolerance_rad, row)),
        ):
            faults[kind] = faults.get(kind) or new
        pieces = Pieces(shapes, table.rate_rad_s, np.append(np.diff(table.time_s), 0.0))
        again -= int(np.count_nonzero(np.diff(table.phase) < 0))
        passed.look(row, table.time_s[found.row], found.pose, found.shape, found.bound)
        kept.look(row, table.time_s, table.phase.astype(np.int64), poses, pieces)
        last, rest = Configuration(poses[-1], shapes[-1]), table.rate_rad_s[-1]
        row += len(table.time_s) - 1
    assert isinstance(found, Replay)  # noqa: S101  # there is one part at least
    certificate = _certificate(found, ends, goal, limit, tolerance_rad, segments, integrated)
    faults["end"] = _off("re-integrated end against the goal", found.end, goal, limit, tolerance_rad)
    if not (certificate.reached or faults["end"]):
        text = f"{certificate.bound.position_m:.1e} m and {certificate.bound.base_rad:.1e} rad"
        faults["end"] = [f"re-integrated end against the goal: it may itself be wrong by {text}, too much to tell"]
    faults["goal"] = _off("last row against the goal", last, goal, limit, tolerance_rad)
    if np.any(rest != 0.0):
        faults["rest"] = [f"line {row + 2}: the controls of the last row must be 0"]
    faults["waypoints"] = passed.faults()
    order = ("swimmer", "start", "end", "goal", "waypoints", "rows", "phases", "controls", "rest", "lengths", "angles")
    told = [text for kind in order for text in faults.get(kind, [])] + list(kept.faults.values())
    return Verification(Deviation.between(first, start), certificate, kept, passed.passings, tuple(told))


def _certificate(
    found: Replay,
    ends: list[tuple[Array, Deviation]],
    goal: Configuration,
    limit_m: float,
    limit_rad: float,
    segments: int,
    integrated: int,
) -> Certificate:
    """Return the certificate of parts, each of which turns all that comes after it by what it may be wrong."""
    end = found.end
    position = sum(b.position_m + b.base_rad * np.linalg.norm(end.pose[:3, 3] - p[:3, 3]) for p, b in ends)
    bound = Deviation(float(position), sum(b.base_rad for _, b in ends), 0.0, 0.0)
    return Certificate(Deviation.between(end, goal), bound, limit_m, limit_rad, segments, integrated)


def misfit(table: Table, swimmer: Swimmer) -> float:
    """Return which part of the rows' motion is not the swimmer's, at some rows: 0 if it can have made them.

    Each of these rows must move to the next as the swimmer does by the row's controls from the row's shape.
    """
    poses, shapes = se3.pose(from_quaternion(table.base), table.position_m), from_quaternion(table.limbs)
    turned = np.linalg.norm(table.rate_rad_s[:-1], axis=1) * np.diff(table.time_s)
    moving = np.flatnonzero((turned > 0.0) & (turned <= _MOST_TURNED_RAD))
    k = moving[np.unique(np.linspace(0, len(moving) - 1, min(_LOOKED_AT, len(moving))).astype(np.int64))]
    if not len(k):
        return 0.0
    seconds = np.diff(table.time_s)[k]
    wanted = segment_displacements(swimmer, shapes[k], table.rate_rad_s[k], seconds).fine.astype(np.float64)
    made = se3.inverse(poses[k]) @ poses[k + 1]
    off = np.linalg.norm(made[:, :3, 3] - wanted[:, :3, 3], axis=1) / swimmer.length_m
    off += np.linalg.norm(made[:, :3, :3] - wanted[:, :3, :3], axis=(1, 2))
    off = np.maximum(off - _ROUNDING * (1.0 + np.abs(poses[k, :3, 3]).max(axis=1) / swimmer.length_m), 0.0)
    return float(np.median(off / (np.linalg.norm(table.rate_rad_s[k], axis=1) * seconds)))


def _swimmer(table: Table, swimmer: Swimmer) -> list[str]:
    """Return that another swimmer has made the rows, where that is so."""
    off = misfit(table, swimmer)
    if off <= MISFIT:
        return []
    return [f"the rows' velocities are not this swimmer's (off by {off:.2g} of the joints' rates): see --swimmer"]


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
    table: Table, poses: Array, shapes: Array, found: Replay, row: int, limit_m: float, limit_rad: float
) -> list[str]:
    """Return the first row that is not where the replay is; the first and the last are held against start and goal."""
    pose, shape = found.pose, found.shape
    away = np.linalg.norm(poses[found.row, :3, 3] - pose[:, :3, 3], axis=1) > limit_m
    away |= np.max(np.abs(poses[found.row, :3, :3] - pose[:, :3, :3]), axis=(1, 2)) > limit_rad
    away |= np.max(np.abs(shapes[found.row] - shape), axis=(1, 2, 3)) > limit_rad
    inside = np.flatnonzero(away[(row == 0) :])[:1] + (row == 0)
    if not len(inside):
        return []
    k = int(inside[0])
    n = int(found.row[k])
    label = f"line {row + n + 2} (t = {table.time_s[n]:.6g} s) against the re-integration"
    return _off(label, Configuration(poses[n], shapes[n]), Configuration(pose[k], shape[k]), limit_m, limit_rad)


def _phases(table: Table, row: int, again: int) -> list[str]:
    """Return the first row whose phase is none, or comes before the last row's; that may be at so many waypoints."""
    wrong = ~np.isin(table.phase, (1, 2, 3))
    wrong[np.flatnonzero(np.diff(table.phase) < 0)[max(again, 0) :] + 1] = True
    if not np.any(wrong):
        return []
    n = int(np.flatnonzero(wrong)[0])
    return [f"line {row + n + 2}: the phases of a reconfiguration are 1, 2, 3 in this order, found {table.phase[n]:g}"]


def _controls(table: Table, shapes: Array, swimmer: Swimmer, row: int) -> list[str]:
    found = too_fast(swimmer, shapes, table.rate_rad_s)
    if found is None:
        return []
    n, rate, most = found
    return [f"line {row + n + 2}: a joint turns at {rate:.9g} rad/s, more than {most:g}"]


def _lengths(table: Table, limit_rad: float, row: int) -> list[str]:
    """Return the first row with a quaternion not of length 1, which the rotations that are compared do not show."""
    for name, quaternion in (("base", table.base), ("limb 1", table.limbs[:, 0]), ("limb 2", table.limbs[:, 1])):
        length = np.linalg.norm(quaternion, axis=1)
        if len(off := np.flatnonzero(np.abs(length - 1.0) > max(limit_rad, 1e-9))):
            n = int(off[0])
            return [f"line {row + n + 2}: the {name}'s quaternion has a length of {length[n]:.9g}, not 1"]
    return []


def _angles(table: Table, poses: Array, shapes: Array, limit_rad: float, row: int) -> list[str]:
    """Return the first row whose Euler angles are not those of its quaternion."""
    for k, (name, rotation) in enumerate(
        (("base", poses[:, :3, :3]), ("limb 1", shapes[:, 0]), ("limb 2", shapes[:, 1]))
    ):
        off = np.max(np.abs(from_euler(table.euler_rad[:, k]) - rotation), axis=(1, 2)) > max(limit_rad, 1e-9)
        if np.any(off):
            n = int(np.flatnonzero(off)[0])
            wanted = ", ".join(f"{v:.6g}" for v in as_euler(rotation[n]))
            return [
                f"line {row + n + 2}: the {name}'s Euler angles are not those of its quaternion, which are {wanted} rad"
            ]
    return []
