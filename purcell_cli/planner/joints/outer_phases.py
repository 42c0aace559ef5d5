"""Phases 1 and 3 by joint angles: the ways between a shape and the shape between the phases."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array, as_euler
from purcell_cli.mechanics.joint_motion import bend_limits
from purcell_cli.mechanics.lift import SEARCHING, displacements
from purcell_cli.mechanics.primitives import EMPTY, PrimitiveSequence, joined
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import BEND_SLACK_RAD, bends

_NOTHING_RAD = 1e-13
"""Angles below this are rounding errors of shapes [rad]."""


@frozen_dataclass(eq=False)
class Way:
    """A way from a shape to the shape between the phases.

    Attributes:
        parts: The primitives of each limb, in the order in which limbs move, with the limb's number.
        displacement: What they do to the base, in units of L. Shape (4, 4).
    """

    parts: tuple[tuple[int, PrimitiveSequence], ...]
    displacement: Array

    @property
    def sequence(self) -> PrimitiveSequence:
        """All primitives."""
        return joined([part for _, part in self.parts])


def ways_home(swimmer: Swimmer, shape: Array, home: Array) -> list[Way]:
    """Return the ways from a shape home: each limb's angles one after the other, in every order of limbs and angles.

    Ways on which a limb bends farther than at both ends, and than it may, are left out, as far as there are others.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        shape: The shape. Shape (2, 3, 3).
        home: The shape between the phases. Shape (2, 3, 3).
    """
    out: dict[bytes, Way] = {}
    beyond: dict[bytes, float] = {}
    limits = np.maximum(bend_limits(swimmer, shape), bends(shape[..., 0])) + BEND_SLACK_RAD
    choices = [list(_limb_ways(swimmer, limb, shape[limb], home[limb])) for limb in (0, 1)]
    for first, second in itertools.product(*choices):
        for order in ((0, 1), (1, 0)):
            both = {0: first, 1: second}
            parts = tuple((limb, both[limb]) for limb in order if len(both[limb]))
            played = joined([part for _, part in parts])
            key = played.control.tobytes() + played.angle.tobytes()
            if key not in out:
                beyond[key] = float(np.max(bends(played.shapes(shape)[..., 0]) - limits))
                moves = displacements(swimmer, played, shape, SEARCHING)
                out[key] = Way(parts, np.asarray(se3.prefix_products(moves)[-1]))
    least = min(beyond.values())
    return [way for key, way in out.items() if beyond[key] <= max(least, 0.0)]


def _limb_ways(swimmer: Swimmer, limb: int, shape: Array, home: Array) -> Iterator[PrimitiveSequence]:
    joint = swimmer.joints[limb]
    if joint.kind == "fixed":
        yield EMPTY
        return
    if joint.ball:
        psi, theta, phi = as_euler(matmul(home.T, shape)).tolist()
        yield _busy([(3 * limb, -phi), (3 * limb + 1, -theta), (3 * limb + 2, -psi)])
        return
    begin, end = np.array(joint.read(shape)), np.array(joint.read(home))
    change = dict(zip(("psi", "theta"), (end - begin).tolist(), strict=True))
    controls = {"psi": 6 + limb if joint.kind == "universal" else 3 * limb + 2, "theta": 3 * limb + 1}
    for names in itertools.permutations(joint.angles):
        yield _busy([(controls[name], change[name]) for name in names])


def _busy(steps: list[tuple[int, float]]) -> PrimitiveSequence:
    return PrimitiveSequence.of([(control, angle) for control, angle in steps if abs(angle) > _NOTHING_RAD])
