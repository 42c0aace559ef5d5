"""The loops of a swimmer by its joints: rectangles of two joint angles, and the screw motion that each makes.

A loop begins and ends at the shape between the phases: an approach leads to its corner, and away again. Joint angles
of which each closes by itself make the rectangle close exactly. Lengths are in units of L.
"""

from __future__ import annotations

import dataclasses
import functools
import itertools
import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import arccos, cos, matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.joint_motion import bend_limits, plane_axis
from purcell_cli.mechanics.lift import SEARCHING, run_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import AXIS_OF, EMPTY, LIMB_OF, PRIMITIVE_NAMES, PrimitiveSequence, joined
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limits import BEND_MARGIN_RAD

Rows = NDArray[np.int64]

_PARTS = ((-1.0, 1.0), (-0.75, 0.75), (-0.5, 0.5), (-0.25, 0.25), (-1.0, 0.5), (-0.5, 1.0), (-1.0, 0.0), (0.0, 1.0))
"""The sides of loops, as parts of how far their angles may go."""
_SMALL = (0.03, 0.06, 0.1, 0.2, 0.35)
"""Half sides of the small loops of one limb's two angles, which roll the base [rad]."""
_ASIDE = 0.5
"""How far aside another angle is for some loops, as a part of how far it may go."""
_MIRRORED = (1.0, 0.7, 0.5, 0.3, 0.15)
"""The sides of mirrored loops, as parts of how far their angles may go both ways."""
_LEAST_MIRRORED_RAD = 0.05
"""Angles that may go less far than this both ways make no mirrored loops [rad]."""
_IMAGES = ((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0))
"""A rectangle and its mirror images, by the signs of its sides."""
_STRAIGHT = 1.0 - 1e-9
"""The cosine of a bend above which a limb is straight: a yaw and a pitch then need nothing but mirrored loops."""
_SENSES = ((1, 1, 1, 1), (1, 1, -1, -1), (1, -1, 1, -1), (1, -1, -1, 1))
"""Which images are played forward, and which backward."""
_ORDERS = ((0, 1, 2, 3), (0, 3, 1, 2))
"""In which order images are played: the order decides what neighbours leave."""
_WIDEST_RAD = 3.0
"""No loop's angle goes farther than this [rad]."""


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Loop:
    """A rectangle of two angles, or some with a corner at home, one after the other.

    Attributes:
        approach: The primitives from the shape between the phases to its corner.
        cycle: Its primitives, four a rectangle.
    """

    approach: PrimitiveSequence
    cycle: PrimitiveSequence

    @property
    def name(self) -> str:
        """What its stroke is called."""
        return " ".join(
            [
                "loop" if len(self.cycle) == 4 else "mirrored loops",
                *(PRIMITIVE_NAMES[c].replace("base ", "") for c in self.cycle.control[:2]),
            ]
        )

    def sized(self, part: float) -> Loop:
        """Return the loop about the same centre, or from the same corner, with its sides a part of what they are."""
        if len(self.cycle) > 4:
            return Loop(self.approach, self.cycle.with_angles(part * self.cycle.angle))
        sides = self.cycle.angle[:2]
        moved = 0.5 * (1.0 - part) * sides
        approach = self.approach + PrimitiveSequence(self.cycle.control[:2], moved)
        return Loop(_merged(approach), self.cycle.with_angles(part * self.cycle.angle))


@dataclasses.dataclass(frozen=True, slots=True, eq=False)
class Loops:
    """Loops with what they do.

    Attributes:
        loops: The loops.
        twist: The body twist of one cycle of each (v/L, omega), seen from the shape between the phases. Shape (n, 6).
        travel: The joint travel of one cycle [rad]. Shape (n,).
        approach: That of both approaches [rad]. Shape (n,).
    """

    loops: tuple[Loop, ...]
    twist: Array
    travel: Array
    approach: Array

    def __len__(self) -> int:
        return len(self.loops)

    def some(self, rows: Rows) -> Loops:
        """Return some of the loops."""
        return Loops(tuple(self.loops[int(k)] for k in rows), self.twist[rows], self.travel[rows], self.approach[rows])


def _merged(sequence: PrimitiveSequence) -> PrimitiveSequence:
    """Return an approach with each control once, in the order in which they first act."""
    order = list(dict.fromkeys(sequence.control.tolist()))
    return PrimitiveSequence.of([(c, float(np.sum(sequence.angle[sequence.control == c]))) for c in order])


def _spans(swimmer: Swimmer, home: Array, aside: tuple[int, float] | None, pair: tuple[int, int]) -> list[Array] | None:
    """Return how far below and above its home each angle of a pair may go, or None where there is no room."""
    limits = bend_limits(swimmer, home) - BEND_MARGIN_RAD
    out = []
    for control in pair:
        limb, joint = int(LIMB_OF[control]), swimmer.joints[int(LIMB_OF[control])]
        bent = [float(arccos(np.clip(home[limb, 0, 0], -1.0, 1.0)))]
        if aside is not None and LIMB_OF[aside[0]] == limb:
            bent.append(abs(aside[1]))
        free = float(cos(limits[limb])) / math.prod(float(cos(angle)) for angle in bent if angle > 1e-9)
        both = int(LIMB_OF[pair[0]] == LIMB_OF[pair[1]])
        if not 0.0 < free < 1.0 and len(bent) > 1:
            return None
        reach = float(arccos(min(max(free, -1.0), 1.0))) if not both else float(arccos(math.sqrt(max(free, 0.0))))
        reach = min(reach, _WIDEST_RAD)
        span = np.array([-reach, reach]) if AXIS_OF[control] else np.array([-1.0, 1.0])
        if not joint.ball:
            name = "psi" if AXIS_OF[control] == 2 else "theta"
            at, ends = joint.home_rad()[0 if name == "psi" else 1], joint.range_rad(name)
            span = np.clip(span, ends[0] - at, ends[1] - at)
        if span[1] - span[0] < 1e-3:
            return None
        out.append(span)
    return out


def _rectangles(swimmer: Swimmer, home: Array) -> Iterator[Loop]:
    every = swimmer.controls
    for pair in itertools.combinations(every, 2):
        same = LIMB_OF[pair[0]] == LIMB_OF[pair[1]]
        if same and swimmer.joints[int(LIMB_OF[pair[0]])].ball:
            continue  # turns about two axes of the limb do not close
        for aside in _asides(swimmer, home, pair):
            spans = _spans(swimmer, home, aside, pair)
            if spans is not None:
                # A yaw and a pitch alone roll the base with every loop, and nothing else could undo that.
                alone = len(every) == 2 and plane_axis(swimmer) is None
                if alone:
                    yield from _mirrored(pair, spans)
                if not (alone and np.all(home[:, 0, 0] > _STRAIGHT)):
                    yield from _within(pair, spans, aside, same)


def _asides(swimmer: Swimmer, home: Array, pair: tuple[int, int]) -> Iterator[tuple[int, float] | None]:
    """Return the places of another angle at which a pair's loops are looked at; None for home."""
    yield None
    for control in swimmer.controls:
        if control not in pair and AXIS_OF[control]:
            room = _spans(swimmer, home, None, (control, pair[0]))
            yield from [] if room is None else [(control, float(_ASIDE * end)) for end in room[0] if abs(end) > 0.1]


def _within(pair: tuple[int, int], spans: list[Array], aside: tuple[int, float] | None, same: bool) -> Iterator[Loop]:
    """Return the rectangles of a pair within its spans."""
    for (a, b), (c, d) in itertools.product(_PARTS, _PARTS):
        first, second = _part(spans[0], a, b), _part(spans[1], c, d)
        if first is not None and second is not None:
            yield _rectangle(pair, first, second, aside)
    for side in (-s for s in _SMALL if same):
        if all(span[0] <= side and -side <= span[1] for span in spans):
            yield _rectangle(pair, (side, -side), (side, -side), aside)


def _mirrored(pair: tuple[int, int], spans: list[Array]) -> Iterator[Loop]:
    """Return a rectangle from home and its three mirror images, each one way or the other round.

    One loop of a yaw and a pitch rolls the base far more than it moves it. The images' senses choose what adds up:
    the way along x, roll, or one of the ways and rotations across.
    """
    reach = [float(min(-span[0], span[1])) for span in spans]
    if min(reach) < _LEAST_MIRRORED_RAD:
        return
    for (i, a), (j, b) in itertools.product(enumerate(_MIRRORED), enumerate(_MIRRORED)):
        if abs(i - j) > 1:
            continue
        sides = [(s * a * reach[0], t * b * reach[1]) for s, t in _IMAGES]
        corners = [
            PrimitiveSequence.of([(c, x) for c, x in zip((*pair, *pair), (p, q, -p, -q), strict=True)])
            for p, q in sides
        ]
        for senses, order in itertools.product(_SENSES, _ORDERS):
            played = [corners[k] if senses[k] > 0 else corners[k].inverse() for k in order]
            yield Loop(EMPTY, joined(played))


def _part(span: Array, low: float, high: float) -> tuple[float, float] | None:
    """Return a part of a span, or None where it is too short."""
    ends = [abs(float(span[0])) * x if x < 0.0 else float(span[1]) * x for x in (low, high)]
    return (ends[0], ends[1]) if ends[1] - ends[0] > 1e-3 else None


def _rectangle(
    pair: tuple[int, int], first: tuple[float, float], second: tuple[float, float], aside: tuple[int, float] | None
) -> Loop:
    approach = ([] if aside is None else [aside]) + [(pair[0], first[0]), (pair[1], second[0])]
    a, b = first[1] - first[0], second[1] - second[0]
    cycle = PrimitiveSequence.of([(pair[0], a), (pair[1], b), (pair[0], -a), (pair[1], -b)])
    return Loop(PrimitiveSequence.of(approach), cycle)


def measured(swimmer: Swimmer, home: Array, loops: tuple[Loop, ...]) -> Loops:
    """Return loops with what they do.

    Args:
        swimmer: The swimmer, scaled to L = 1.
        home: Shape that they begin and end at. Shape (2, 3, 3).
        loops: The loops.
    """
    pieces, counts = [], []
    for loop in loops:
        played = loop.approach + loop.cycle
        pieces.append(Pieces.of(played, home))
        counts += [len(loop.approach), len(loop.cycle)]
    moves = run_displacements(swimmer, Pieces.together(pieces), counts, np.ones(len(counts), dtype=np.int64), SEARCHING)
    approach, cycle = moves[::2], moves[1::2]
    twist = se3.log(matmul(matmul(approach, cycle), se3.inverse(approach)))
    travel = np.array([loop.cycle.joint_travel_rad for loop in loops])
    return Loops(loops, twist, travel, np.array([2.0 * loop.approach.joint_travel_rad for loop in loops]))


@functools.lru_cache(maxsize=16)
def _every(swimmer: Swimmer, home: bytes) -> Loops:
    shape = np.frombuffer(home).reshape(2, 3, 3)
    return measured(swimmer, shape, tuple(_rectangles(swimmer, shape)))


def loops_of(swimmer: Swimmer, home: Array) -> Loops:
    """Return the loops of a swimmer that is scaled to L = 1, worked out once a swimmer and shape."""
    return _every(swimmer, np.ascontiguousarray(home).tobytes())
