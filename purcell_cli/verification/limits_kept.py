"""The limits that a trajectory keeps at every instant: clearance, bends, workspace, obstacles."""

from __future__ import annotations

import dataclasses

import numpy as np

from purcell_cli.environment.scene import Scene
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.joint_motion import bend_limits
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.clearance import TOLERANCE_L as CLEARANCE_SLACK_L
from purcell_cli.motion.clearance import Clearance, least_clearance
from purcell_cli.motion.limb_circles import BEND_SLACK_RAD, LimbCircles, bends
from purcell_cli.motion.mission import Follow, Order, Waypoint
from purcell_cli.motion.obstacle_distance import LINKS, nearest_obstacle
from purcell_cli.motion.off_curve import farthest
from purcell_cli.motion.workspace import ENDS, WALLS, Workspace, largest_excess
from purcell_cli.motion.workspace import TOLERANCE_L as WORKSPACE_SLACK_L
from purcell_cli.verification.extrapolation import Rows, segment_displacements
from purcell_cli.verification.joints_kept import JointsKept


@frozen_dataclass
class Wanted:
    """What a trajectory must keep besides the swimmer's bend limit.

    Attributes:
        clearance_m: How far the surfaces of limb 1 and limb 2 stay apart, at least [m].
        workspace: The box that all links stay in, where one is known.
        obstacles: What no link may touch, where anything is known.
        follow: The curve that the base's middle stays near, where one is known.
        via: The waypoints that it must pass.
        order: In which order.
    """

    clearance_m: float = 0.0
    workspace: Workspace | None = None
    obstacles: Scene | None = None
    follow: Follow | None = None
    via: tuple[Waypoint, ...] = ()
    order: Order = Order.GIVEN


NOTHING_MORE = Wanted()
"""Limbs may come as near as to touch, and there is neither workspace nor obstacle."""


class LimitsKept:
    """How near a trajectory comes to its limits, and the first places where it breaks them.

    Attributes:
        wanted: What it must keep.
        clearance: The least distance of the limbs, the row before it and when.
        largest_bend_rad: The largest bend in phase 2; None where nothing moves in it [rad].
        workspace_violation_m: How far a link leaves the workspace; None without one [m].
        obstacle_distance_m: The least distance of a link from an obstacle; None without one [m].
        off_curve_m: How far the base's middle is from its curve at most; None without one [m].
        turned_rad: How far the base is turned from its curve's orientation at most; None where that is free [rad].
        faults: The limits that are broken, in words; at most one of each kind.

    Args:
        swimmer: The swimmer.
        start: The start configuration.
        goal: The goal configuration.
        wanted: What must be kept.
    """

    def __init__(self, swimmer: Swimmer, start: Configuration, goal: Configuration, wanted: Wanted) -> None:
        self.wanted = wanted
        self.clearance = Clearance(np.inf, 0, 0.0, 0.0)
        self.largest_bend_rad: float | None = None
        self.workspace_violation_m = None if wanted.workspace is None else 0.0
        self.obstacle_distance_m = None if wanted.obstacles is None else np.inf
        self.off_curve_m = None if wanted.follow is None else 0.0
        self.turned_rad: float | None = None
        self.faults: dict[str, str] = {}
        self._swimmer = swimmer
        named = [one.filled(start).shape for one in wanted.via]
        own = {k: np.max([bends(s[..., 0]) for s in (end.shape, *named)], axis=0) for k, end in ((1, start), (3, goal))}
        limit = bend_limits(swimmer, start.shape)
        self._most_rad = {k: np.maximum(limit, own.get(k, np.zeros(2))) for k in (1, 2, 3)}
        self._joints = JointsKept(swimmer, start)

    def look(self, row: int, time_s: Array, phase: Rows, poses: Array, pieces: Pieces) -> None:
        """Look at some more rows.

        Args:
            row: The number of the first.
            time_s: Their times [s]. Shape (n,).
            phase: Their phases. Shape (n,).
            poses: The base's poses [m]. Shape (n, 4, 4).
            pieces: The motion from each to the next; the last may last no time. There are n.
        """
        near = least_clearance(self._swimmer, pieces)
        if near.distance_m < self.clearance.distance_m:
            self.clearance = dataclasses.replace(near, piece=row + near.piece)
        if near.distance_m < self.wanted.clearance_m - CLEARANCE_SLACK_L * self._swimmer.length_m:
            when = f"{_line(row + near.piece)} (t = {time_s[near.piece] + near.time_s:.6g} s)"
            found = f"{1e3 * near.distance_m:.4g} mm apart{' (they overlap)' if near.distance_m < 0.0 else ''}"
            self.faults.setdefault(
                "clearance", f"{when}: {near.between} are {found}, less than {1e3 * self.wanted.clearance_m:g} mm"
            )
        self._bends(row, time_s, phase, pieces)
        for kind, text in self._joints.faults(row, time_s, pieces).items():
            self.faults.setdefault(kind, text)
        if self.wanted.workspace is not None:
            self._workspace(self.wanted.workspace, row, time_s, poses, pieces)
        if self.wanted.obstacles is not None:
            self._obstacles(self.wanted.obstacles, row, time_s, poses, pieces)
        if self.wanted.follow is not None:
            self._follow(self.wanted.follow, row, time_s, poses, pieces)

    def _bends(self, row: int, time_s: Array, phase: Rows, pieces: Pieces) -> None:
        bend, when = LimbCircles.of(pieces).largest_bends()
        for k, most in self._most_rad.items():
            mine = np.flatnonzero((phase == k) & (pieces.durations > 0.0))
            if not len(mine):
                continue
            if k == 2:
                self.largest_bend_rad = max(self.largest_bend_rad or 0.0, float(np.max(bend[mine])))
            n, limb = np.unravel_index(int(np.argmax(bend[mine] - most)), (len(mine), 2))
            found, piece = float(bend[mine[n], limb]), int(mine[n])
            if found > most[limb] + BEND_SLACK_RAD:
                place = f"{_line(row + piece)} (t = {time_s[piece] + when[piece, limb]:.6g} s)"
                what = f"limb {limb + 1} bends by {found:.6g} rad in phase {k}, more than {most[limb]:.6g} rad"
                self.faults.setdefault("bend", f"{place}: {what}")

    def _workspace(self, workspace: Workspace, row: int, time_s: Array, poses: Array, pieces: Pieces) -> None:
        found = largest_excess(self._swimmer, workspace, poses, np.arange(len(poses)), pieces, _displacements)
        self.workspace_violation_m = max(self.workspace_violation_m or 0.0, found.distance_m)
        if found.distance_m > WORKSPACE_SLACK_L * self._swimmer.length_m:
            when = f"{_line(row + found.place)} (t = {time_s[found.place] + found.time_s:.6g} s)"
            what = f"{ENDS[found.end]} is {1e3 * found.distance_m:.4g} mm beyond the workspace's {WALLS[found.wall]}"
            self.faults.setdefault("workspace", f"{when}: {what}")

    def _obstacles(self, scene: Scene, row: int, time_s: Array, poses: Array, pieces: Pieces) -> None:
        every, least = np.arange(len(poses)), self.wanted.clearance_m
        found = nearest_obstacle(self._swimmer, scene, poses, every, pieces, _displacements, least)
        known = np.inf if self.obstacle_distance_m is None else self.obstacle_distance_m
        self.obstacle_distance_m = min(known, found.distance_m)
        if found.distance_m < least:
            when = f"{_line(row + found.place)} (t = {time_s[found.place] + found.time_s:.6g} s)"
            touch = " (they touch)" if found.distance_m < 0.0 else ""
            apart = f"{1e3 * found.distance_m:.4g} mm apart{touch}, less than {1e3 * least:g} mm"
            between = f"{LINKS[found.link]} and {scene.name(found.obstacle)}"
            self.faults.setdefault("obstacle", f"{when}: {between} are {apart}")

    def _follow(self, follow: Follow, row: int, time_s: Array, poses: Array, pieces: Pieces) -> None:
        index, most = np.arange(len(poses)), follow.tolerance_m
        found = farthest(self._swimmer, follow.curve, poses, index, pieces, _displacements, most)
        self.off_curve_m = max(self.off_curve_m or 0.0, found.most_m)
        if found.turned_rad is not None:
            self.turned_rad = max(self.turned_rad or 0.0, found.turned_rad)
        if found.most_m > most:
            when = f"{_line(row + found.place)} (t = {time_s[found.place] + found.time_s:.6g} s)"
            what = f"the base's middle is {1e3 * found.most_m:.4g} mm from its curve, more than {1e3 * most:.4g} mm"
            self.faults.setdefault("follow", f"{when}: {what}")


def _line(row: int) -> str:
    """Return the line of a row in its file, the header being line 1."""
    return f"line {row + 2}"


def _displacements(swimmer: Swimmer, pieces: Pieces) -> Array:
    found = segment_displacements(swimmer, pieces.shapes, pieces.rates, pieces.durations)
    return np.asarray(found.fine, dtype=np.float64)
