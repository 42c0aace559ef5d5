"""Random queries for swimmers on all kinds of joints, and a check of their plans that the planner has no part in."""

from __future__ import annotations

import dataclasses

import numpy as np
from random_swimmers import ONE_SIDED, one_sided, ranged
from scipy.spatial.transform import Rotation

from purcell_cli.geometry import se3
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.joints import Joint
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.trajectory import Trajectory

BALL, UNIVERSAL, FIXED = Joint(), Joint("universal"), Joint("fixed")
YAW, PITCH = Joint("hinge", "yaw"), Joint("hinge", "pitch")

COMBINATIONS: dict[str, tuple[Joint, Joint]] = {
    "yaw hinges": (YAW, YAW),
    "pitch hinges": (PITCH, PITCH),
    "yaw and pitch hinge": (YAW, PITCH),
    "universal joints": (UNIVERSAL, UNIVERSAL),
    "universal joint and yaw hinge": (UNIVERSAL, YAW),
    "pitch hinge and universal joint": (PITCH, UNIVERSAL),
    "ball and universal joint": (BALL, UNIVERSAL),
    "ball joint and yaw hinge": (BALL, YAW),
    "pitch hinge and ball joint": (PITCH, BALL),
}
"""The combinations of joints that move both limbs; which limb has which is random."""

EVERY: dict[str, tuple[Joint, Joint]] = {
    **COMBINATIONS,
    "universal joint and fixed limb": (UNIVERSAL, FIXED),
    "ball joint and fixed limb": (BALL, FIXED),
}
"""All combinations of joints that there are plans for, but two ball joints."""

_FARTHEST_FIXED_L = 5.0
"""Queries beside a fixed limb are at most so far: farther ones take thousands of rad [L]."""
_FIXED_RAD = (0.25 * np.pi, 0.5 * np.pi)
"""How far out of line fixed limbs are, at least and at most [rad]."""

_CORNERS_RAD = 0.01
"""Ranges are looked at this often [rad]."""


@dataclasses.dataclass(frozen=True)
class Query:
    """A swimmer, a start and a goal."""

    swimmer: Swimmer
    start: Configuration
    goal: Configuration


def _limb(joint: Joint, rng: np.random.Generator) -> np.ndarray:
    if joint.kind == "ball":
        return Rotation.from_euler("ZYX", rng.uniform(-1.0, 1.0, 3)).as_matrix()
    if joint.kind == "fixed":
        return Rotation.from_euler("XY", [rng.uniform(-np.pi, np.pi), rng.uniform(*_FIXED_RAD)]).as_matrix()
    angles = [0.0, 0.0, 0.0]
    for k, name in enumerate(("psi", "theta")):
        if name in joint.angles:
            low, high = joint.range_rad(name)
            angles[k] = rng.uniform(max(low, -1.2), min(high, 1.2))
    return Rotation.from_euler("ZYX", angles).as_matrix()


def random_query(name: str, seed: int, farthest_l: float = 30.0) -> Query:
    """Return a random query of a combination: from near to far, some joints with ranges."""
    rng = np.random.default_rng([seed, list(EVERY).index(name)])
    ranges = one_sided if rng.random() < ONE_SIDED else ranged
    first, second = (ranges(joint, rng) for joint in EVERY[name])
    swimmer = Swimmer(
        slenderness=float(rng.uniform(0.005, 0.03)),
        max_bend_rad=float(rng.uniform(0.7, 1.3)),
        joints=(first, second) if rng.integers(2) else (second, first),
    )
    fixed = "fixed" in name
    away = float(10.0 ** rng.uniform(-1.5, np.log10(min(farthest_l, _FARTHEST_FIXED_L) if fixed else farthest_l)))
    displacement = displacement_of(rng, swimmer, name, away * swimmer.length_m)
    start = se3.pose(Rotation.random(random_state=seed).as_matrix(), rng.normal(size=3))
    shapes = [shape_of(rng, swimmer) for _ in range(2)]
    for limb, joint in enumerate(swimmer.joints):
        if joint.kind == "fixed":
            shapes[1][limb] = shapes[0][limb]
    return Query(swimmer, Configuration(start, shapes[0]), Configuration(start @ displacement, shapes[1]))


def shape_of(rng: np.random.Generator, swimmer: Swimmer) -> np.ndarray:
    """Return a random shape that a swimmer's joints can make. Shape (2, 3, 3)."""
    return np.stack([_limb(joint, rng) for joint in swimmer.joints])


def displacement_of(rng: np.random.Generator, swimmer: Swimmer, name: str, away: float) -> np.ndarray:
    """Return a random displacement that a combination of joints can make, of a length [m]. Shape (4, 4)."""
    way, turn = rng.normal(size=3), rng.normal(size=3) * min(1.0, 10.0 * away / swimmer.length_m)
    across = {"yaw hinges": 2, "pitch hinges": 1}.get(name)
    if across is not None:
        way[across], turn[[k for k in range(3) if k != across]] = 0.0, 0.0
    return se3.pose(Rotation.from_rotvec(turn).as_matrix(), away * way / np.linalg.norm(way))


def joint_faults(query: Query, rows: Trajectory) -> list[str]:
    """Return what the rows, and the path every 0.01 rad between them, ask of joints that they have not.

    Limbs turn at constant rates between rows. The angles are read from the shapes by scipy alone.
    """
    faults = []
    lasts = np.append(np.diff(rows.time_s), 0.0)
    for limb, joint in enumerate(query.swimmer.joints):
        if joint.kind == "ball":
            continue
        rates = rows.rate_rad_s[:, 3 * limb : 3 * limb + 3]
        count = np.maximum(np.ceil(np.linalg.norm(rates, axis=1) * lasts / _CORNERS_RAD), 1).astype(int)
        row = np.repeat(np.arange(len(count)), count)
        part = (np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)) / count[row] * lasts[row]
        shape = Rotation.from_matrix(rows.shape[row, limb]) * Rotation.from_rotvec(rates[row] * part[:, None])
        if joint.kind == "fixed":
            shape = Rotation.from_matrix(query.start.shape[limb]).inv() * shape
        angles = shape.as_euler("ZYX")
        allowed = {"universal": (0, 1), "hinge": (0,) if joint.axis == "yaw" else (1,), "fixed": ()}[joint.kind]
        missing = [k for k in range(3) if k not in allowed]
        # A pitch beyond a quarter turn is read as less, with half a turn about both other axes.
        other = (angles * [1.0, -1.0, 1.0] + 2.0 * np.pi) % (2.0 * np.pi) - np.pi
        stray, others = (np.max(np.abs(one[:, missing]), axis=1, initial=0.0) for one in (angles, other))
        angles = np.where((others < stray)[:, None], other, angles)
        worst = float(np.max(np.abs(angles[:, missing])))
        if worst > 1e-9:
            faults.append(f"limb {limb + 1} turns by {worst:.2g} rad about an axis that its joint has not")
        for k in allowed:
            low, high = joint.range_rad("psi" if k == 0 else "theta")
            beyond = float(np.max(np.maximum(low - angles[:, k], angles[:, k] - high)))
            if beyond > 2e-9:
                faults.append(f"limb {limb + 1} leaves its range by {beyond:.2g} rad")
    return faults


def plane_fault(query: Query, name: str, rows: Trajectory) -> float:
    """Return how far two parallel hinges take the base out of its plane at the most [L, rad]."""
    across = {"yaw hinges": 2, "pitch hinges": 1}.get(name)
    if across is None:
        return 0.0
    moved = se3.inverse(query.start.pose) @ rows.pose
    tilt = np.abs(moved[:, across, :3] - np.eye(3)[across])
    return float(max(np.max(np.abs(moved[:, across, 3])) / query.swimmer.length_m, np.max(tilt)))
