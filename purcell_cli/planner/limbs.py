"""Phases 1 and 3: limbs to the collinear shape and from it, by primitives (section IV-B of the paper).

Three turns about its own axes straighten a limb, in twelve orders and two ways each; either limb
may go first. All of them move the base, each differently, so which is best depends on where the
swimmer is to go: here they are all listed, with what they do to the base.
"""

from __future__ import annotations

import dataclasses
import itertools
import warnings

import numpy as np

from purcell_cli.lift import Accuracy, piece_displacements
from purcell_cli.primitives import EMPTY, PrimitiveSequence, joined
from purcell_cli.rotations import Array
from purcell_cli.swimmer import Swimmer

_NEGLIGIBLE_RAD = 1e-15
_ROUGH = Accuracy(stages=5, step=0.8)
_BEND_SLACK_RAD = 1e-9
_LONGER_RAD = 7.0
"""Ways longer than the shortest by more than this are not worth their while."""

_ORDERS = ["".join(o) for o in itertools.product("XYZ", repeat=3) if o[0] != o[1] and o[1] != o[2]]
"""The twelve orders in which three turns about own axes reach any orientation."""


def turns_to(rotation: Array, limb: int) -> list[PrimitiveSequence]:
    """Return every way of turning a limb by a rotation with three turns about its own axes.

    Args:
        rotation: The rotation in the limb's own frame. Shape (3, 3).
        limb: 1 or 2.

    Returns:
        Sequences without empty turns, shortest joint travel first.
    """
    from scipy.spatial.transform import Rotation  # slow to import; few commands need it

    ways: dict[tuple[tuple[int, float], ...], PrimitiveSequence] = {}
    rotor = Rotation.from_matrix(rotation)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # at gimbal lock one of the many equal ways is taken
        for order in _ORDERS:
            angles = rotor.as_euler(order)
            for turns in (angles, _other(angles, order)):
                steps = [
                    (3 * (limb - 1) + "XYZ".index(axis), float(angle))
                    for axis, angle in zip(order, turns, strict=True)
                    if abs(angle) > _NEGLIGIBLE_RAD
                ]
                ways.setdefault(tuple((c, round(a, 9)) for c, a in steps), PrimitiveSequence.of(steps))
    return sorted(ways.values(), key=lambda s: round(s.joint_travel_rad, 9))


def _other(angles: Array, order: str) -> Array:
    """Return the other three turns in the same order that make the same rotation [rad]."""
    middle = -angles[1] if order[0] == order[2] else np.pi - angles[1]
    turned = np.array([angles[0] + np.pi, middle, angles[2] + np.pi])
    return np.asarray(np.remainder(turned + np.pi, 2.0 * np.pi) - np.pi)


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Straightenings:
    """Ways to straighten both limbs.

    Attributes:
        sequences: Their primitives, shortest joint travel first.
        joint_travel_rad: Their joint travel [rad]. Shape (n,).
        displacement: What each does to the base, to search by, in units of L. Shape (n, 4, 4).
    """

    sequences: list[PrimitiveSequence]
    joint_travel_rad: Array
    displacement: Array


def straightenings(swimmer: Swimmer, shape: Array) -> Straightenings:
    """Return the ways to straighten both limbs of a scaled swimmer, one limb after the other.

    No limb bends further on the way than it does at the beginning or the bend limit allows.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        shape: The shape to begin with. Shape (2, 3, 3).
    """
    limbs = [_within(turns_to(shape[i].T, i + 1), shape, swimmer.max_bend_rad) for i in (0, 1)]
    halves = [(i, j, s) for i in (0, 1) for j in (0, 1) for s in limbs[i]]
    if not np.any([len(s) for _, _, s in halves]):
        return Straightenings([EMPTY], np.zeros(1), np.eye(4)[None])
    begun = []
    for i, j, sequence in halves:
        here = shape.copy()
        if j:  # the other limb has been straightened before
            here[1 - i] = np.eye(3)
        begun.append(sequence.shapes(here)[:-1])
    played = joined([s for _, _, s in halves])
    moves = piece_displacements(swimmer, np.concatenate(begun), played.rates(), np.abs(played.angle), _ROUGH)
    made: dict[tuple[int, int], list[Array]] = {(i, j): [] for i in (0, 1) for j in (0, 1)}
    position = 0
    for i, j, sequence in halves:
        g = np.eye(4)
        for move in moves[position : position + len(sequence)]:
            g = g @ move
        made[i, j].append(g)
        position += len(sequence)
    rows: list[tuple[float, PrimitiveSequence, Array]] = []
    for i in (0, 1):
        for one, g in zip(limbs[i], made[i, 0], strict=True):
            for two, h in zip(limbs[1 - i], made[1 - i, 1], strict=True):
                rows.append((one.joint_travel_rad + two.joint_travel_rad, one + two, g @ h))
        if not (len(limbs[0][0]) and len(limbs[1][0])):
            break
    rows.sort(key=lambda row: round(row[0], 9))
    rows = [row for row in rows if row[0] <= rows[0][0] + _LONGER_RAD]
    return Straightenings([r[1] for r in rows], np.array([r[0] for r in rows]), np.stack([r[2] for r in rows]))


def _within(ways: list[PrimitiveSequence], shape: Array, max_bend_rad: float) -> list[PrimitiveSequence]:
    """Return the ways that bend a limb no further than it is, or than the limit."""
    out = []
    for way in ways:
        if not len(way):
            return [way]
        limb = int(way.control[0] // 3)
        limit = max(max_bend_rad, float(np.arccos(np.clip(shape[limb, 0, 0], -1.0, 1.0)))) + _BEND_SLACK_RAD
        finely = PrimitiveSequence(np.repeat(way.control, 8), np.repeat(way.angle / 8, 8))
        if np.all(finely.shapes(shape)[:, limb, 0, 0] >= np.cos(limit)):
            out.append(way)
    return out or ways[:1]
