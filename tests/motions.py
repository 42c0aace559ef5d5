"""Motions that the tests of exports share: a swimmer with unequal links that turns its joints in a few ways."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from pathlib import Path

from purcell_cli import Configuration, Swimmer, write_csv
from purcell_cli.gaits.gait import Stroke
from purcell_cli.gaits.sampling import sample_stroke
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.trajectory import Trajectory

SWIMMER = Swimmer(base_half_length_m=0.1, limb_half_length_m=0.07, slenderness=0.02)
START = Configuration.from_angles((0.2, -0.1, 0.3), (40, -20, 75), (30, 10, -20), (-20, 15, 5))
WAY = (
    *(("limb1 yaw", 0.52), ("limb2 pitch", 0.3), ("limb1 roll", 1.1), ("limb2 yaw", -0.84)),
    *(("limb1 pitch", -0.62), ("limb2 roll", -2.1), ("limb1 yaw", -0.9), ("limb2 pitch", 0.44)),
)
"""A way of both limbs about all of their axes; every angle is a whole number of hundredths."""


def motion(
    way: Sequence[tuple[str, float]] = WAY, start: Configuration = START, dt: float = 0.02, swimmer: Swimmer = SWIMMER
) -> Trajectory:
    """Return the motion of turns of single joints, a row at least every dt [s]."""
    stroke = Stroke("way", 0.1, PrimitiveSequence.of([]), PrimitiveSequence.of(list(way)))
    return sample_stroke(swimmer, start, stroke, 1, dt)


@functools.cache
def usual() -> Trajectory:
    """Return the motion along `WAY`."""
    return motion()


def written(trajectory: Trajectory, folder: Path, name: str = "swim.csv") -> Path:
    """Write a motion and its swimmer into a folder, and return the motion's file."""
    write_csv(trajectory, folder / name)
    text = "base_half_length_m: 0.1\nlimb_half_length_m: 0.07\nslenderness: 0.02\n"
    (folder / "swimmer.yaml").write_text(text)
    return folder / name
