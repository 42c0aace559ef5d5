"""Curves as CSV files: a point a row, and the base's orientation there if that is wanted."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np

from purcell_cli.errors import InputError, PurcellWarning
from purcell_cli.files.paths import UnreadableError
from purcell_cli.files.place import shortened
from purcell_cli.files.points_csv import POINT, read_points
from purcell_cli.files.yaml_source import file_bytes
from purcell_cli.geometry.rotations import INPUT_SLACK, MEASURED_SLACK, from_quaternion, quaternion_error
from purcell_cli.motion.curve import Curve, CurveError

QUATERNION = ("qw", "qx", "qy", "qz")
"""The columns of a curve with orientations, besides."""


def load_curve(path: Path | str) -> Curve:
    """Return the curve of a CSV file with the columns x_m, y_m, z_m and, if wanted, qw, qx, qy, qz.

    Raises:
        InputError: The file is missing, its header or a row is not a curve's, or its points are no curve.
    """
    try:
        data = file_bytes(Path(path))
    except UnreadableError as error:
        raise InputError(f"{shortened(str(path), 1000)}: wanted a readable file, found {error}") from error
    return curve_of(data, str(path))


def curve_of(data: bytes, name: str) -> Curve:
    """Return the curve that the bytes of a CSV file say.

    Args:
        data: The bytes.
        name: The file's name, for messages.

    Raises:
        InputError: See `load_curve`.
    """
    rows, lines = read_points(data, name, QUATERNION)
    numbers, orientation = np.array(rows, dtype=np.float64), None
    if numbers.shape[1] > len(POINT):
        quaternions = numbers[:, 3:]
        off = quaternion_error(quaternions)
        bad = np.flatnonzero(~(off <= MEASURED_SLACK))
        if len(bad):
            k = int(bad[0])
            raise InputError(f"{name}:{lines[k]}: qw to qz: wanted a unit quaternion, found one off by {off[k]:.3g}")
        if float(np.max(off)) > INPUT_SLACK:
            k = int(np.argmax(off))
            text = f"{name}:{lines[k]}: qw to qz: normalised, since it is off by {off[k]:.2g}"
            warnings.warn(text, PurcellWarning, stacklevel=2)
        orientation = from_quaternion(quaternions, MEASURED_SLACK)
    try:
        return Curve(numbers[:, :3], orientation)
    except CurveError as error:
        raise InputError(f"{name}:{lines[error.point]}: wanted {error.wanted}, found {error.found}") from error
