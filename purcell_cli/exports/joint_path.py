"""The angles of all hinges along a trajectory: continuous in time, and refused where they are ill determined."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from purcell_cli.errors import InputError
from purcell_cli.files.servo_map_file import ServoMap
from purcell_cli.geometry.rotations import Array, angle_between, from_quaternion
from purcell_cli.mechanics.hinge_chain import ORDERS, HingeChain
from purcell_cli.motion.table_sampling import limbs_at, rows_at
from purcell_cli.motion.trajectory_table import Table

_STEP_RAD = 0.02
"""A limb turns by no more than this between two instants that are looked at [rad]: with the middle hinge a degree or
more from its lock the outer ones turn by less than pi meanwhile, so that angles are continued the right way."""

_MOST_INSTANTS = 4_000_000
"""Instants that are looked at, at most: their angles take 100 MB."""

_AT_ONCE = 1 << 16
"""Instants whose rotations are computed together: 40 MB of them."""

_SLACK_RAD = 1e-6
"""How far a limb may be from what its hinges can do [rad]: rounding in files of seven digits."""


def joint_path(table: Table, servo_map: ServoMap, time_s: Array, source: Path) -> Array:
    """Return the angles of all joints of a map at some times, continuous along the trajectory [rad].

    Args:
        table: The trajectory.
        servo_map: The hinges.
        time_s: Times in ascending order [s]. Shape (n,).
        source: The trajectory's file, for messages.

    Returns:
        Angles, the joints in the map's order. Shape (n, k).

    Raises:
        InputError: A limb comes too near to where three hinges lock, or turns about an axis that its hinges have not;
            the message names the line and the time where it does first.
    """
    parts = []
    for chain in servo_map.chains:
        watched = np.union1d(_instants(table, chain.limb, source), time_s)
        angles = np.empty((len(watched), len(chain.order)))
        for low in range(0, len(watched), _AT_ONCE):
            part = slice(low, low + _AT_ONCE)
            rotation = limbs_at(table, chain.limb, watched[part])
            angles[part] = chain.angles(rotation)
            _check(table, servo_map, chain, watched[part], rotation, angles[part], source)
        parts.append(np.unwrap(angles, axis=0)[np.searchsorted(watched, time_s)])
    return np.concatenate(parts, axis=1)


def place(table: Table, source: Path, time_s: float) -> str:
    """Return where in a trajectory's file a time is: the line of the row that holds then."""
    return f"{source}:{int(rows_at(table, np.array([time_s]))[0]) + 2}"


def _instants(table: Table, limb: int, source: Path) -> Array:
    """Return all rows' times and as many between them as a limb's rotation there needs [s]. Shape (m,)."""
    lasts = np.diff(table.time_s)
    turned = np.linalg.norm(table.rate_rad_s[:-1, 3 * limb - 3 : 3 * limb], axis=1) * lasts
    ends = from_quaternion(table.limbs[:, limb - 1])
    turned = np.maximum(turned, angle_between(ends[:-1], ends[1:]))
    count = np.maximum(np.ceil(turned / _STEP_RAD), 1.0)
    if np.sum(count) > _MOST_INSTANTS:
        most = f"limbs that turn by {_MOST_INSTANTS * _STEP_RAD:.6g} rad in all at most"
        raise InputError(f"{source}: wanted {most}, found limb {limb} turning by {np.sum(turned):.6g} rad")
    whole = count.astype(np.int64)
    index = np.arange(int(whole.sum())) - np.repeat(np.cumsum(whole) - whole, whole)
    times = np.repeat(table.time_s[:-1], whole) + np.repeat(lasts / count, whole) * index
    return np.append(times, table.time_s[-1])


def _check(
    table: Table, servo_map: ServoMap, chain: HingeChain, time_s: Array, rotation: Array, angles: Array, source: Path
) -> None:
    """Refuse orientations that three hinges are near their lock at, or that fewer cannot make."""
    names = chain.names
    if len(names) == 3:
        distance = 0.5 * np.pi - np.abs(angles[:, 1])
        bad = np.flatnonzero(distance < servo_map.lock_margin_rad)
        if not len(bad):
            return
        k = int(bad[0])
        where = f"{place(table, source, time_s[k])}: {names[1]} at {time_s[k]:.6g} s"
        wanted = f"{np.degrees(servo_map.lock_margin_rad):.3g} degrees or more from +-90, where {names[0]} and "
        wanted += f"{names[2]} turn about one axis (gimbal lock)"
        found = f"{np.degrees(angles[k, 1]):.6g} degrees{_other_order(table, servo_map, chain)}"
        raise InputError(f"{where}: wanted {wanted}, found {found}")
    off = angle_between(chain.rotation(angles), rotation)
    bad = np.flatnonzero(off > _SLACK_RAD)
    if len(bad):
        k = int(bad[0])
        where = f"{place(table, source, time_s[k])}: limb{chain.limb} at {time_s[k]:.6g} s"
        wanted = f"an orientation that the hinges of hinge_order {chain.order} can make"
        raise InputError(f"{where}: wanted {wanted}, found one {np.degrees(off[k]):.3g} degrees off any such")


def _other_order(table: Table, servo_map: ServoMap, chain: HingeChain) -> str:
    """Return the order of hinges that the rows keep farthest from its lock, where that is far enough."""
    rotation = from_quaternion(table.limbs[:, chain.limb - 1])
    largest = {
        order: float(np.max(np.abs(HingeChain(chain.limb, order).angles(rotation)[:, 1])))
        for order in ORDERS
        if order != chain.order
    }
    best = min(largest, key=lambda order: largest[order])
    spare = 0.5 * np.pi - largest[best] - _STEP_RAD
    if spare < servo_map.lock_margin_rad:
        return "; every hinge_order comes near its lock on this way"
    return f" (hinge_order {best} in --map stays {np.degrees(spare):.0f} degrees away)"
