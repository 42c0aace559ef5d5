"""Random swimmers with drags, links, bodies and joints of their own, for tests and benchmarks alike."""

from __future__ import annotations

import dataclasses
import math

import numpy as np

from purcell_cli import LinkDrag, LinkDrags, LinkSize, LinkSizes, Swimmer
from purcell_cli.mechanics.drag import LAWS
from purcell_cli.mechanics.joints import Joint, Joints
from purcell_cli.motion.clearance import body_distance, limb_distance
from purcell_cli.motion.limb_circles import bends

ONE_SIDED = 0.25
"""The share of ranges of which one angle's does not hold 0."""
_LOW_DEG, _WIDE_DEG = (2.0, 15.0), (40.0, 90.0)
"""Where such ranges begin, and how wide they are [degrees]."""
_FLAT, _FLATTEST = 0.25, 1.5
"""The share of links with drags of their own that drag more along than across, and by how much at most: flat discs."""


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """Return a number between two, evenly in the logarithm."""
    return float(np.exp(rng.uniform(math.log(low), math.log(high))))


def of_its_own(rng: np.random.Generator, swimmer: Swimmer) -> Swimmer:
    """Return a swimmer with a law of drag or numbers, limbs of their own sizes, and maybe a body."""

    def size() -> LinkSize:
        half = swimmer.limb_half_length_m * between(rng, 0.5, 2.0) if rng.random() < 0.7 else None
        return LinkSize(half, between(rng, 1e-3, 0.1) if rng.random() < 0.5 else None)

    links = LinkSizes(limb1=size(), limb2=size() if rng.random() < 0.7 else LinkSize())
    out = dataclasses.replace(swimmer, drag=str(rng.choice(LAWS)), links=links)
    if rng.random() < 0.4:
        drags, more = [], rng.spawn(1)[0]
        for rod in map(out.rod, range(3)):
            across, along, turn, spin = np.exp(rng.uniform(-0.5, 0.5, 4)) * [rod.across, rod.along, rod.turn, rod.spin]
            along = across * more.uniform(1.0, _FLATTEST) if more.random() < _FLAT else min(along, 0.95 * across)
            drags.append(LinkDrag(along, across, turn, spin if rng.random() < 0.5 else None))
        out = dataclasses.replace(out, drag=LinkDrags(*drags))
    free = out.base_half_length_m - max(out.radii_m[1:])
    body = float(rng.uniform(0.1, 0.9)) * free if rng.random() < 0.4 and free > 0.0 else 0.0
    return dataclasses.replace(out, body_radius_m=body)


def ranged(joint: Joint, rng: np.random.Generator) -> Joint:
    """Return the joint with ranges, in half of all cases; most go a little to one side and far to the other."""
    if joint.kind in {"ball", "fixed"} or rng.integers(2):
        return joint
    ranges = {f"{name}_deg": (float(-rng.uniform(25, 100)), float(rng.uniform(25, 100))) for name in joint.angles}
    return dataclasses.replace(joint, **ranges)


def one_sided(joint: Joint, rng: np.random.Generator) -> Joint:
    """Return the joint with a range of one of its angles, if it has any, that does not hold 0."""
    if not joint.angles:
        return joint
    low = rng.uniform(*_LOW_DEG)
    ends = (float(low), float(low + rng.uniform(*_WIDE_DEG)))
    name = str(rng.choice(joint.angles))
    return dataclasses.replace(joint, **{f"{name}_deg": ends if rng.integers(2) else (-ends[1], -ends[0])})


def jointed(rng: np.random.Generator, swimmer: Swimmer, joints: Joints) -> Swimmer:
    """Return a swimmer on joints of some kinds, with ranges, rates and an acceleration of their own for some."""
    rate = swimmer.joint_rate_rad_s
    first, second = (
        dataclasses.replace(
            ranged(joint, rng), rate_rad_s=rate * between(rng, 0.3, 3.0) if rng.random() < 0.3 else None
        )
        for joint in joints
    )
    more = rng.spawn(1)[0]
    if more.random() < ONE_SIDED:
        first, second = (one_sided(joint, more) for joint in (first, second))
    ramps = rate * rate * between(rng, 0.5, 50.0) if rng.random() < 0.3 else None
    return dataclasses.replace(swimmer, joints=(first, second), joint_acceleration_rad_s2=ramps)


def room(swimmer: Swimmer, axes: np.ndarray) -> float:
    """Return how far limbs are from each other, and from the body [m]."""
    return min(float(limb_distance(swimmer, axes)), float(np.min(body_distance(swimmer, bends(axes)))))
