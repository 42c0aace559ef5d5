"""A trajectory as a recording for the Rerun viewer: the links, the path of the base and the controls in time.

A recording holds numbers of 24 bits, and marks of its own of when and by which process it was written, so that two
recordings of one trajectory differ in their bytes.
"""

from __future__ import annotations

from typing import IO

import numpy as np

from purcell_cli.errors import MissingPackageError
from purcell_cli.exports.urdf import LINKS, joint_m
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.primitives import CONTROL_NAMES
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.trajectory_table import Table

try:
    import rerun as rr
except ImportError:
    raise MissingPackageError(
        "exports to rerun need rerun-sdk, found none; install it: python -m pip install 'rerun-sdk>=0.41'"
    ) from None

_COLOURS = ((34, 34, 34), (0, 114, 178), (213, 94, 0))
"""The links' colours, as in the pictures: red, green and blue of 255."""

_ALONG_X = np.array([0.0, np.sin(0.25 * np.pi), 0.0, np.cos(0.25 * np.pi)])
"""The quaternion (x, y, z, w) that takes a capsule of Rerun's, which lies along +z, to +x."""

_ALONG_MINUS_X = _ALONG_X * [1.0, -1.0, 1.0, 1.0]
"""The one that takes it to -x."""

_ENTITIES = ("world/base", "world/base/limb1", "world/base/limb2")
"""Where the links are in the tree of the recording."""


def write_rerun(table: Table, swimmer: Swimmer, title: str, stream: IO[bytes]) -> int:
    """Write a trajectory as a recording.

    Args:
        table: The trajectory.
        swimmer: The swimmer, for its lengths and radii.
        title: What the recording is called.
        stream: Where to write.

    Returns:
        How many rows there are.
    """
    recording = rr.RecordingStream("purcell", recording_id=title, send_properties=False)
    kept = recording.memory_recording()
    recording.send_recording_name(title)
    recording.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, static=True)
    place = table.position_m - table.origin_m
    path = rr.LineStrips3D([place], colors=[(128, 128, 128)])
    recording.log("world/path", path, static=True)
    _links(recording, swimmer)
    clock = [rr.TimeColumn("time", duration=np.round(table.time_s * 1e9).astype("timedelta64[ns]"))]
    joints = np.array([[joint_m(swimmer, limb), 0.0, 0.0] for limb in (1, 2)])
    places: list[Array] = [place, *(np.broadcast_to(joint, place.shape) for joint in joints)]
    turns = [table.base, table.limbs[:, 0], table.limbs[:, 1]]
    for entity, at, turn in zip(_ENTITIES, places, turns, strict=True):
        moved = rr.Transform3D.columns(translation=at, quaternion=np.roll(turn, -1, axis=1))
        recording.send_columns(entity, indexes=clock, columns=moved)
    for k, name in enumerate(CONTROL_NAMES):
        rate = rr.Scalars.columns(scalars=table.rate_rad_s[:, k])
        recording.send_columns(f"controls_rad_s/{name.replace(' ', '_')}", indexes=clock, columns=rate)
    recording.flush()
    stream.write(kept.drain_as_bytes())
    return len(table.time_s)


def _links(recording: rr.RecordingStream, swimmer: Swimmer) -> None:
    """Add the links' shapes, each in its own frame: capsules, as everywhere in the program."""
    halves, radii = swimmer.halves_m, swimmer.radii_m
    begins = (-swimmer.base_half_length_m, 0.0, 0.0)
    along = (_ALONG_X, _ALONG_X, _ALONG_MINUS_X)
    for k, entity in enumerate(_ENTITIES):
        capsule = rr.Capsules3D(
            lengths=[2.0 * halves[k]],
            radii=[radii[k]],
            translations=[[begins[k], 0.0, 0.0]],
            quaternions=[along[k]],
            colors=[_COLOURS[k]],
            labels=[LINKS[k]],
            show_labels=False,
        )
        recording.log(f"{entity}/link", capsule, static=True)
    if swimmer.body_radius_m:
        half_sizes = [[swimmer.body_radius_m] * 3]
        recording.log(f"{_ENTITIES[0]}/body", rr.Ellipsoids3D(half_sizes=half_sizes, colors=[_COLOURS[0]]), static=True)
