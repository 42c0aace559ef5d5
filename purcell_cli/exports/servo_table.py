"""A trajectory as a table for servos: what each channel is told at every tick of a clock."""

from __future__ import annotations

from pathlib import Path
from typing import IO

import numpy as np

from purcell_cli.errors import InputError, ParameterError
from purcell_cli.exports.joint_path import joint_path, place
from purcell_cli.files.polars_package import polars
from purcell_cli.files.servo_map_file import Channel, ServoMap
from purcell_cli.geometry.rotations import Array
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.processes import outside_forks

RATE_HZ = 50.0
"""Ticks in a second where none are asked for [Hz]: a hobby servo takes 50 pulses in a second."""

_FASTEST_HZ = 1e5
"""Ticks in a second at most [Hz]."""

MOST_TICKS = 2_000_000
"""Ticks at most: eleven hours at 50 Hz, a file of 200 MB."""

_EARLY = 1e-9
"""A motion's end so many ticks after a tick is at that tick."""

_ROUNDING = 1e-9
"""A value so much of its channel's range beyond an end is at that end."""


def ticks(table: Table, rate_hz: float) -> Array:
    """Return the times of a clock's ticks from the first row to the first tick that is not before the last row [s].

    Args:
        table: The trajectory.
        rate_hz: Ticks in a second.

    Returns:
        Times [s]. Shape (n,).

    Raises:
        ParameterError: The rate is no number above 0, or there would be too many ticks.
    """
    if not 0.0 < rate_hz <= _FASTEST_HZ:
        raise ParameterError(f"rate: a number above 0 and at most {_FASTEST_HZ:g} is wanted, found {rate_hz!r}")
    lasts = float(table.time_s[-1] - table.time_s[0])
    if lasts * rate_hz > MOST_TICKS:
        wanted = f"a rate of at most {MOST_TICKS:,} ticks for {lasts:.6g} s"
        raise ParameterError(f"rate: {wanted} is wanted, found {rate_hz!r}, {lasts * rate_hz:.3g} ticks")
    count = int(np.ceil(lasts * rate_hz - _EARLY))
    return np.asarray(table.time_s[0] + np.arange(count + 1) / rate_hz)


def column(name: str, channel: Channel) -> str:
    """Return the name of a joint's column: with its unit."""
    return f"{name}_{channel.unit}"


@outside_forks
def write_servo_table(table: Table, servo_map: ServoMap, rate_hz: float, source: Path, stream: IO[bytes]) -> int:
    """Write what each channel is told at every tick as CSV; the last tick is the end.

    Args:
        table: The trajectory.
        servo_map: The joints and their channels.
        rate_hz: Ticks in a second.
        source: The trajectory's file, for messages.
        stream: Where to write.

    Returns:
        How many ticks there are.

    Raises:
        ParameterError: As for `ticks`.
        InputError: As for `joint_path`, or a channel would be told more or less than its range allows.
    """
    time = ticks(table, rate_hz)
    angles = joint_path(table, servo_map, time, source)
    told = {"t_s": time}
    for k, (name, channel) in enumerate(servo_map.channels.items()):
        values = channel.told(angles[:, k]) + 0.0
        _check_range(table, name, channel, time, values, source)
        told[column(name, channel)] = np.clip(values, channel.low, channel.high)
    polars().DataFrame(told).write_csv(stream)
    return len(time)


def _check_range(table: Table, name: str, channel: Channel, time_s: Array, told: Array, source: Path) -> None:
    """Refuse values out of a channel's range, by the first and the worst."""
    beyond = np.maximum(told - channel.high, channel.low - told)
    bad = np.flatnonzero(beyond > _ROUNDING * (channel.high - channel.low))
    if not len(bad):
        return
    first, worst, unit = int(bad[0]), int(np.argmax(beyond)), channel.unit
    where = f"{place(table, source, time_s[first])}: {name} at {time_s[first]:.6g} s"
    found = f"{told[first]:.6g} {unit}, {beyond[first]:.3g} {unit} beyond"
    found += f" (at most {beyond[worst]:.6g} {unit} beyond, at {time_s[worst]:.6g} s)" if worst != first else ""
    raise InputError(f"{where}: wanted {channel.low:g} to {channel.high:g} {unit}, found {found}")
