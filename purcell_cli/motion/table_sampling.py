"""A trajectory's table between its rows: limbs turn as the row's controls say, the base goes along a screw."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array, as_vector, from_quaternion
from purcell_cli.motion.trajectory_table import Table

Rows = NDArray[np.int64]


def rows_at(table: Table, time_s: Array) -> Rows:
    """Return the rows that hold at some times: the last one that is not later. Shape (n,) to (n,)."""
    return np.clip(np.searchsorted(table.time_s, time_s, side="right") - 1, 0, len(table.time_s) - 1)


def limbs_at(table: Table, limb: int, time_s: Array) -> Array:
    """Return a limb's orientations in the base, exactly where the rows are what their controls make of them.

    What a row is off that (a measured one) is made up for evenly in time.

    Args:
        table: The trajectory.
        limb: 1 or 2.
        time_s: Times [s]; before the first row and after the last the limb rests. Shape (n,).

    Returns:
        Orientations. Shape (n, 3, 3).
    """
    row, after, since, share = _between(table, time_s)
    rate = table.rate_rad_s[row, 3 * limb - 3 : 3 * limb]
    begin = from_quaternion(table.limbs[row, limb - 1])
    lasts = (table.time_s[after] - table.time_s[row])[:, None]
    end = matmul(begin, se3.rotation(rate * lasts))
    off = as_vector(matmul(np.swapaxes(end, -1, -2), from_quaternion(table.limbs[after, limb - 1])))
    off[after == row] = 0.0
    return matmul(matmul(begin, se3.rotation(rate * since[:, None])), se3.rotation(off * share[:, None]))


def base_at(table: Table, time_s: Array) -> Array:
    """Return the base's poses, from row to row along a screw: to the third order of the time between rows.

    Args:
        table: The trajectory.
        time_s: Times [s]; before the first row and after the last the base rests. Shape (n,).

    Returns:
        Poses in the world [m]. Shape (n, 4, 4).
    """
    row, after, _, share = _between(table, time_s)
    begin, end = (se3.pose(from_quaternion(table.base[k]), table.position_m[k]) for k in (row, after))
    return matmul(begin, se3.exp(share[:, None] * se3.log(matmul(se3.inverse(begin), end))))


def _between(table: Table, time_s: Array) -> tuple[Rows, Rows, Array, Array]:
    """Return for each time the row that holds, the next one, the time since [s] and its share of the row's time."""
    row = rows_at(table, time_s)
    after = np.minimum(row + 1, len(table.time_s) - 1)
    lasts = table.time_s[after] - table.time_s[row]
    since = np.clip(time_s - table.time_s[row], 0.0, lasts)
    return row, after, since, np.divide(since, lasts, out=np.zeros_like(since), where=lasts > 0.0)
