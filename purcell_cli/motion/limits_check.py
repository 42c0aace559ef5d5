"""The check that a motion keeps its limits over its whole path.

Every limit is bounded between rows too: see `clearance`, `limb_circles`, `workspace`, `obstacle_distance`, `off_curve`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from purcell_cli.environment.scene import Scene
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.collocation import Accuracy
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.joint_motion import angle_changes, angles_along, bend_limits, excess_of_ranges
from purcell_cli.mechanics.joints import ANGLES, MISFIT_RAD, RANGE_SLACK_RAD
from purcell_cli.mechanics.lift import piece_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block, BlockPieces, block_displacements, starting_shapes
from purcell_cli.motion.clearance import TOLERANCE_L as CLEARANCE_SLACK_L
from purcell_cli.motion.clearance import least_clearance
from purcell_cli.motion.limb_circles import BEND_SLACK_RAD, LimbCircles, bends
from purcell_cli.motion.limits import Limits, LimitsReport, Violation
from purcell_cli.motion.mission import Follow
from purcell_cli.motion.obstacle_distance import LINKS, Encounter, nearest_obstacle
from purcell_cli.motion.off_curve import OffCurve, farthest
from purcell_cli.motion.places import Places
from purcell_cli.motion.workspace import ENDS, WALLS, Excess, Workspace, largest_excess
from purcell_cli.motion.workspace import TOLERANCE_L as WORKSPACE_SLACK_L

_FINE = Accuracy(stages=4, step=0.4)
"""How the base's motion within a piece is computed: to some 1e-8 L, a thousandth of what workspaces are held to."""


@frozen_dataclass(eq=False)
class _Path:
    """The pieces of a motion, each cycle of a repeated block once, and last a piece of no duration at its end.

    Attributes:
        pieces: The pieces. There are n of them.
        begun: When each begins for the last time [s]. Shape (n,).
        phase: In which phase each is. Shape (n,).
    """

    pieces: Pieces
    begun: Array
    phase: Array

    @classmethod
    def of(cls, swimmer: Swimmer, start: Array, blocks: Sequence[Block]) -> _Path:
        rate = swimmer.joint_rate_rad_s
        once = BlockPieces.of(blocks, start)
        duration = once.sequence.duration / rate
        ends = np.concatenate([[0.0], np.cumsum(duration)])
        edges = ends[np.cumsum([0, *once.counts])]
        again = np.concatenate([[0.0], np.cumsum((once.cycles - 1) * np.diff(edges))])
        block = once.block
        phase = np.array([b.phase for b in blocks], dtype=np.int64)
        return cls(
            Pieces(
                once.shapes,
                np.concatenate([once.sequence.rates(once.shapes[:-1]) * rate, np.zeros((1, 6))]),
                np.concatenate([duration, [0.0]]),
            ),
            np.concatenate([ends[:-1] + again[block], [ends[-1] + again[-1]]]),
            np.concatenate([phase[block], [blocks[-1].phase if blocks else 3]]),
        )


def check(
    swimmer: Swimmer, start: Configuration, blocks: Sequence[Block], limits: Limits | None = None
) -> LimitsReport:
    """Return how near a motion comes to its limits, and which it breaks.

    Args:
        swimmer: The swimmer.
        start: The configuration before the motion.
        blocks: The motion; its end is taken for the goal.
        limits: The limits; where none are given, the limbs may come as near as to touch.
    """
    wanted = limits or Limits()
    path = _Path.of(swimmer, start.shape, blocks)
    clearance = least_clearance(swimmer, path.pieces)
    violations: list[Violation] = []
    if clearance.distance_m < wanted.clearance_m - CLEARANCE_SLACK_L * swimmer.length_m:
        k, short = clearance.piece, wanted.clearance_m - clearance.distance_m
        time = float(path.begun[k]) + clearance.time_s
        violations.append(Violation("clearance", short, "m", time, int(path.phase[k]), clearance.between))
    largest, broken = _bends(swimmer, path)
    violations += broken
    if not swimmer.ball_joints:
        violations += _joints(swimmer, path)
    excess, encounter, off = None, None, None
    if wanted.workspace is not None or wanted.obstacles is not None or wanted.follow is not None:
        places = Places.of(swimmer, start.pose, blocks, path.pieces, path.begun)
        if wanted.workspace is not None:
            excess, broken = _workspace(swimmer, wanted.workspace, path, places)
            violations += broken
        if wanted.obstacles is not None:
            encounter = _obstacles(swimmer, wanted, wanted.obstacles, path, places)
            if (short := wanted.clearance_m - encounter.distance_m) > 0.0:
                time, phase = encounter.time_s, encounter.phase
                violations.append(Violation("obstacle", short, "m", time, phase, encounter.between))
        if wanted.follow is not None:
            off, broken = _follow(swimmer, wanted.follow, path, places)
            violations += broken
    return LimitsReport(wanted, clearance, largest, excess, tuple(violations), encounter, off)


def _bends(swimmer: Swimmer, path: _Path) -> tuple[tuple[float | None, float | None, float | None], list[Violation]]:
    """Return the largest bend in each phase, and the greatest excess in each."""
    pieces = path.pieces
    bend, time = LimbCircles.of(pieces).largest_bends()
    largest: list[float | None] = [None, None, None]
    broken: list[Violation] = []
    for phase, own in ((1, pieces.shapes[0]), (2, None), (3, pieces.shapes[-1])):
        mine = np.flatnonzero((path.phase == phase) & (pieces.durations > 0.0))
        if not len(mine):
            continue
        largest[phase - 1] = float(np.max(bend[mine]))
        limit = bend_limits(swimmer, pieces.shapes[0])
        if own is not None:
            limit = np.maximum(limit, bends(own[..., 0]))
        over = bend[mine] - limit
        k, limb = np.unravel_index(int(np.argmax(over)), over.shape)
        if over[k, limb] > BEND_SLACK_RAD:
            when = float(path.begun[mine[k]] + time[mine[k], limb])
            broken.append(Violation("bend", float(over[k, limb]), "rad", when, phase, f"limb {limb + 1}"))
    return (largest[0], largest[1], largest[2]), broken


def _joints(swimmer: Swimmer, path: _Path) -> list[Violation]:
    """Return the greatest turn about an axis that a joint has not, and the greatest excess of a range.

    An angle changes one way on a piece, so it is farthest at one of the ends.
    """
    pieces, broken = path.pieces, []
    changes, turned = angle_changes(swimmer, pieces)
    k, limb = np.unravel_index(int(np.argmax(turned)), turned.shape)
    if turned[k, limb] > MISFIT_RAD:
        what = f"limb {limb + 1} on its {swimmer.joints[limb].name}"
        broken.append(Violation("joint", float(turned[k, limb]), "rad", float(path.begun[k]), int(path.phase[k]), what))
    angles = angles_along(swimmer, pieces.shapes[0], changes)
    over = excess_of_ranges(swimmer, angles)
    k, limb, angle = np.unravel_index(int(np.argmax(over)), over.shape)
    if over[k, limb, angle] > RANGE_SLACK_RAD:
        piece = max(int(k) - 1, 0)
        when = float(path.begun[piece] + pieces.durations[piece])
        what = f"limb {limb + 1}'s {ANGLES[angle]}"
        broken.append(Violation("range", float(over[k, limb, angle]), "rad", when, int(path.phase[piece]), what))
    return broken


def _displacements(swimmer: Swimmer, pieces: Pieces) -> Array:
    return piece_displacements(swimmer, pieces, _FINE)


def _workspace(swimmer: Swimmer, workspace: Workspace, path: _Path, places: Places) -> tuple[Excess, list[Violation]]:
    """Return how far links leave the workspace."""
    found = largest_excess(swimmer, workspace, places.poses, places.piece, path.pieces, _displacements)
    if found.distance_m <= WORKSPACE_SLACK_L * swimmer.length_m:
        return found, []
    time = float(places.begun_s[found.place]) + found.time_s
    what = f"{ENDS[found.end]} beyond the {WALLS[found.wall]}"
    phase = int(path.phase[places.piece[found.place]])
    return found, [Violation("workspace", found.distance_m, "m", time, phase, what)]


def _obstacles(swimmer: Swimmer, wanted: Limits, scene: Scene, path: _Path, places: Places) -> Encounter:
    """Return how near links come to obstacles, when and where."""
    enough = wanted.clearance_m
    found = nearest_obstacle(swimmer, scene, places.poses, places.piece, path.pieces, _displacements, enough)
    time = float(places.begun_s[found.place]) + found.time_s
    phase = int(path.phase[places.piece[found.place]])
    between = f"{LINKS[found.link]} and {scene.name(found.obstacle)}"
    return Encounter(found.distance_m, found.error_m, LINKS[found.link], found.obstacle, between, time, phase)


def _follow(swimmer: Swimmer, follow: Follow, path: _Path, places: Places) -> tuple[OffCurve, list[Violation]]:
    """Return how far the base's middle is from a curve at most, and whether that is too far."""
    curve, most = follow.curve, follow.tolerance_m
    found = farthest(swimmer, curve, places.poses, places.piece, path.pieces, _displacements, most)
    if found.most_m <= most:
        return found, []
    time, phase = float(places.begun_s[found.place]) + found.time_s, int(path.phase[places.piece[found.place]])
    return found, [Violation("follow", found.most_m - most, "m", time, phase, "the base's middle off its curve")]


def check_legs(
    swimmer: Swimmer, start: Configuration, legs: Sequence[Sequence[Block]], limits: Limits | None = None
) -> LimitsReport:
    """Return how near a motion of several legs comes to its limits; each leg has phases, and ends, of its own.

    Args:
        swimmer: The swimmer.
        start: The configuration before the motion.
        legs: The motion.
        limits: The limits, as of `check`.
    """
    reports, begun, count, here = [], 0.0, 0, start
    for blocks in legs:
        one = check(swimmer, here, blocks, limits)
        late = tuple(dataclasses.replace(v, time_s=begun + v.time_s) for v in one.violations)
        near = dataclasses.replace(one.clearance, piece=count + one.clearance.piece)
        met = None if one.obstacle is None else dataclasses.replace(one.obstacle, time_s=begun + one.obstacle.time_s)
        reports.append(dataclasses.replace(one, clearance=near, violations=late, obstacle=met))
        moved = block_displacements(swimmer, blocks, here.shape)
        pose = se3.normalised(matmul(here.pose, se3.prefix_products(moved)[-1]))
        here = Configuration(pose, starting_shapes(blocks, here.shape)[-1])
        begun += sum(b.duration for b in blocks) / swimmer.joint_rate_rad_s
        count += sum(len(b.sequence) for b in blocks)
    if len(reports) == 1:
        return reports[0]
    bends_rad = [
        [b for b in phase if b is not None] for phase in zip(*(r.largest_bend_rad for r in reports), strict=True)
    ]
    most = [max(phase, default=None) for phase in bends_rad]
    worst: dict[str, Violation] = {}
    for violation in (v for r in reports for v in r.violations):
        if violation.limit not in worst or violation.excess > worst[violation.limit].excess:
            worst[violation.limit] = violation
    out = [r.workspace for r in reports if r.workspace is not None]
    return LimitsReport(
        reports[0].limits,
        min((r.clearance for r in reports), key=lambda c: c.distance_m),
        (most[0], most[1], most[2]),
        max(out, key=lambda e: e.distance_m, default=None),
        tuple(worst.values()),
        min((r.obstacle for r in reports if r.obstacle is not None), key=lambda m: m.distance_m, default=None),
        max((r.off_curve for r in reports if r.off_curve is not None), key=lambda o: o.most_m, default=None),
    )
