"""Phases 1 and 3: limbs to the collinear shape and from it, by primitives (section IV-B of the paper).

Three turns about its own axes straighten a limb, in twelve orders and two ways each; either limb
may go first. All of them move the base, each differently, so which is best depends on where the
swimmer is to go: here they are all listed, with what they do to the base. Ways on which the limbs
come too near each other are left out.
"""

from __future__ import annotations

import dataclasses
import itertools
import warnings

import numpy as np

from purcell_cli.clearance import TOLERANCE_L, clearances
from purcell_cli.lift import SEARCHING, piece_displacements
from purcell_cli.primitives import PrimitiveSequence, joined
from purcell_cli.rotations import Array
from purcell_cli.sweeps import Sweeps, bends
from purcell_cli.swimmer import Swimmer

_NEGLIGIBLE_RAD = 1e-15
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
        halves: What each way plays first and then. n pairs.
        joint_travel_rad: Their joint travel, ascending [rad]. Shape (n,).
        displacement: What each does to the base, to search by, in units of L. Shape (n, 4, 4).
    """

    halves: list[tuple[PrimitiveSequence, PrimitiveSequence]]
    joint_travel_rad: Array
    displacement: Array

    def sequence(self, k: int) -> PrimitiveSequence:
        """Return the primitives of one of the ways."""
        return joined(self.halves[k])


def straightenings(swimmer: Swimmer, shape: Array, clearance_m: float = 0.0) -> Straightenings:
    """Return the ways to straighten both limbs of a scaled swimmer, one limb after the other.

    No limb bends further on the way than it does at the beginning or the bend limit allows, and the
    limbs stay apart. Where no way keeps them apart, the ways on which they come least near are returned.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        shape: The shape to begin with. Shape (2, 3, 3).
        clearance_m: How far the limbs' surfaces stay apart, in units of L.
    """
    limbs = [_within(turns_to(shape[i].T, i + 1), shape, swimmer.max_bend_rad) for i in (0, 1)]
    played = _played(swimmer, shape, limbs, clearance_m)
    travels = [np.array([way.joint_travel_rad for way in limb]) for limb in limbs]
    orders = (0, 1) if len(limbs[0][0]) and len(limbs[1][0]) else (0,)
    apart = [np.minimum(played[i, 0].apart[:, None], played[1 - i, 1].apart) for i in orders]
    least = min(clearance_m, max(float(a.max()) for a in apart)) - TOLERANCE_L
    shortest = min(float((travels[i][:, None] + travels[1 - i])[apart[i] >= least].min(initial=np.inf)) for i in orders)
    halves, travel, displacement = [], [], []
    for i in orders:
        pairs = travels[i][:, None] + travels[1 - i]
        kept = np.argwhere((pairs <= shortest + _LONGER_RAD) & (apart[i] >= least))
        halves += [(limbs[i][k], limbs[1 - i][j]) for k, j in kept.tolist()]
        travel.append(pairs[kept[:, 0], kept[:, 1]])
        displacement.append(played[i, 0].moves[kept[:, 0]] @ played[1 - i, 1].moves[kept[:, 1]])
    order = np.argsort(np.round(np.concatenate(travel), 9), kind="stable")
    return Straightenings(
        [halves[k] for k in order], np.concatenate(travel)[order], np.concatenate(displacement)[order]
    )


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class _Played:
    """What one limb's ways do, before or after the other limb is straight.

    Attributes:
        moves: To the base. Shape (k, 4, 4).
        apart: How near the limbs come, as far as it matters, in units of L. Shape (k,).
    """

    moves: Array
    apart: Array


def _played(
    swimmer: Swimmer, shape: Array, limbs: list[list[PrimitiveSequence]], clearance_m: float
) -> dict[tuple[int, int], _Played]:
    """Return what each limb's ways do, before (0) and after (1) the other limb is straight."""
    played = [(i, straight, way) for i in (0, 1) for straight in (0, 1) for way in limbs[i]]
    begun = []
    for i, straight, way in played:
        here = shape.copy()
        if straight:
            here[1 - i] = np.eye(3)
        begun.append(way.shapes(here)[:-1])
    chain = joined([way for _, _, way in played])
    pieces = np.concatenate(begun), chain.rates(), chain.duration
    moves = piece_displacements(swimmer, *pieces, SEARCHING)
    apart = clearances(swimmer, *pieces, clearance_m)
    lengths = np.array([len(way) for _, _, way in played])
    first = np.cumsum(lengths) - lengths
    whole, near = np.tile(np.eye(4), (len(played), 1, 1)), np.full(len(played), np.inf)
    for k in range(int(lengths.max())):
        live = lengths > k
        whole[live] = whole[live] @ moves[first[live] + k]
        near[live] = np.minimum(near[live], apart[first[live] + k])
    counts = np.cumsum([0, len(limbs[0]), len(limbs[0]), len(limbs[1]), len(limbs[1])])
    keys = [(0, 0), (0, 1), (1, 0), (1, 1)]
    parts = itertools.pairwise(counts.tolist())
    return {key: _Played(whole[a:b], near[a:b]) for key, (a, b) in zip(keys, parts, strict=True)}


def _within(ways: list[PrimitiveSequence], shape: Array, max_bend_rad: float) -> list[PrimitiveSequence]:
    """Return the ways that bend a limb no further than it is, or than the limit."""
    out = []
    for way in ways:
        if not len(way):
            return [way]
        limb = int(way.control[0] // 3)
        limit = max(max_bend_rad, float(bends(shape[limb, :, 0]))) + _BEND_SLACK_RAD
        sweeps = Sweeps.of(way.shapes(shape)[:-1], way.rates(), way.duration)
        if np.max(sweeps.largest_bends()[0][:, limb]) <= limit:
            out.append(way)
    return out or ways[:1]
