"""The loops that a swimmer has by its joints, and the screw motion that each makes. Lengths are in units of L."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import arccos, cos, matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.joint_motion import bend_limits, plane_axis
from purcell_cli.mechanics.joints import ANGLES
from purcell_cli.mechanics.lift import SEARCHING, run_displacements
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import AXIS_OF, EMPTY, LIMB_OF, PrimitiveSequence, joined
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.limb_circles import BEND_SLACK_RAD, LimbCircles
from purcell_cli.motion.limits import BEND_MARGIN_RAD
from purcell_cli.planner.joints.loop import Aside, Loop, paired, rectangle, rolled
from purcell_cli.planner.joints.paired import cancelling
from purcell_cli.planner.joints.rectangles import Grid, Rectangles, rectangles_on

Rows = NDArray[np.int64]

_SMALL = (0.03, 0.06, 0.1, 0.2, 0.35)
"""Half sides of the small loops of one limb's two angles, which roll the base [rad]."""
_OFFSET = 0.5
"""How far aside another angle is for some loops, as a part of how far it may go."""
_MIRRORED = (1.0, 0.7, 0.5, 0.3, 0.15)
"""The sides of mirrored loops, as parts of how far their angles may go both ways."""
_LEAST_MIRRORED_RAD = 0.05
"""Angles that may go less far than this both ways make no mirrored loops [rad]."""
_IMAGES = ((1.0, 1.0), (-1.0, 1.0), (1.0, -1.0), (-1.0, -1.0))
"""A rectangle and its mirror images, by the signs of its sides."""
_ROLLED = ((-1.0, 1.0), (-0.5, 0.5), (-0.2, 0.2), (-1.0, 0.0), (0.0, 1.0), (-0.05, 0.05))
"""The sides of loops of a ball joint alone, as parts of how far its angles may go."""
_ABOUT_RAD = (0.0, 0.25 * math.pi, -0.25 * math.pi)
"""The directions about the limb's axis in which they are looked at [rad]; quarter turns exchange yaw and pitch."""
_LONE_SHARE = 0.95
"""The part of its room that a ball joint alone takes: the repeated strokes have no angles that could bend less."""
_PAIRED = 400
"""Pairs are made of at most so many loops, evenly taken from all: those take a tenth of a second."""
_SEVERAL = 10
"""Loops of so many primitives are several already."""
_STRAIGHT = 1.0 - 1e-9
"""The cosine of a bend above which a limb is straight: a yaw and a pitch then need nothing but mirrored loops."""
_SENSES = ((1, 1, 1, 1), (1, 1, -1, -1), (1, -1, 1, -1), (1, -1, -1, 1))
"""Which images are played forward, and which backward."""
_ORDERS = ((0, 1, 2, 3), (0, 3, 1, 2))
"""In which order images are played: the order decides what neighbours leave."""
_WIDEST_RAD = 3.0
"""No loop's angle goes farther than this [rad]."""


@frozen_dataclass(eq=False)
class Screws:
    """What loops do.

    Attributes:
        twist: The body twist of one cycle of each (v/L, omega), seen from the shape between the phases. Shape (n, 6).
        travel: The joint travel of one cycle [rad]. Shape (n,).
        approach: That of both approaches [rad]. Shape (n,).
    """

    twist: Array
    travel: Array
    approach: Array

    def __len__(self) -> int:
        return len(self.twist)

    def and_more(self, other: Screws) -> Screws:
        """Return these and others."""
        pairs = (self.twist, other.twist), (self.travel, other.travel), (self.approach, other.approach)
        return Screws(*(np.concatenate(pair) for pair in pairs))

    def some(self, rows: Rows) -> Screws:
        """Return some of them."""
        return Screws(self.twist[rows], self.travel[rows], self.approach[rows])


@frozen_dataclass(eq=False)
class Loops:
    """Loops with what they do.

    Attributes:
        loops: The loops.
        screws: What they do.
    """

    loops: tuple[Loop, ...]
    screws: Screws


@frozen_dataclass(eq=False)
class EveryLoop:
    """All loops of a swimmer, of which few are ever made.

    Attributes:
        rectangles: Those on grids.
        others: The others.
        screws: What all do, those on grids first.
        pairs: How many of them are pairs whose common rotation cancels: the last ones.
    """

    rectangles: Rectangles
    others: tuple[Loop, ...]
    screws: Screws
    pairs: int = 0

    def some(self, rows: Rows) -> Loops:
        """Return some of the loops."""
        many = len(self.rectangles)
        made = [self.rectangles.loop(k) if k < many else self.others[k - many] for k in rows.tolist()]
        return Loops(tuple(made), self.screws.some(rows))


def _spans(swimmer: Swimmer, home: Array, offset: Aside, pair: tuple[int, int]) -> list[Array] | None:
    """Return how far below and above its home each angle of a pair may go, or None where there is no room."""
    limits = bend_limits(swimmer, home) - BEND_MARGIN_RAD
    out = []
    for control in pair:
        limb, joint = int(LIMB_OF[control]), swimmer.joints[int(LIMB_OF[control])]
        at = [0.0, 0.0] if joint.ball else list(joint.read(home[limb]))
        if offset is not None and LIMB_OF[offset[0]] == limb:
            at[_angle(offset[0])] += offset[1]
        mine, other = at[_angle(control)], at[1 - _angle(control)]
        limit = float(cos(limits[limb]))  # the bend's cosine is that of one angle times that of the other
        if LIMB_OF[pair[0]] == LIMB_OF[pair[1]]:
            corner = min(max(2.0 * limit - float(cos(abs(mine) - abs(other))), -1.0), 1.0)
            reach = 0.5 * (float(arccos(corner)) + abs(mine) - abs(other))  # both farther from home by the same
        else:
            free = limit / float(cos(other))
            if not 0.0 < free < 1.0 and other:
                return None
            reach = float(arccos(min(max(free, -1.0), 1.0)))
        reach = min(reach, _WIDEST_RAD)
        span = (
            np.array([min(-reach - mine, 0.0), max(reach - mine, 0.0)]) if AXIS_OF[control] else np.array([-1.0, 1.0])
        )
        if not joint.ball:
            ends = joint.range_rad(ANGLES[_angle(control)])
            span = np.clip(span, min(ends[0] - mine, 0.0), max(ends[1] - mine, 0.0))
        if span[1] - span[0] < 1e-3:
            return None
        out.append(span)
    return out


def _angle(control: int) -> int:
    """Return which of a limb's two angles a control turns: 0 is psi, 1 theta; rolls count as theta."""
    return 0 if AXIS_OF[control] == 2 else 1


def _all_loops(swimmer: Swimmer, home: Array) -> tuple[list[Grid], list[Loop]]:
    """Return the grids whose rectangles are loops of a swimmer, and further loops."""
    every = swimmer.controls
    grids: list[Grid] = []
    others: list[Loop] = []
    # A yaw and a pitch alone roll the base with every loop, and nothing else could undo that.
    alone = len(every) == 2 and plane_axis(swimmer) is None
    for pair in itertools.combinations(every, 2):
        same = LIMB_OF[pair[0]] == LIMB_OF[pair[1]]
        if same and swimmer.joints[int(LIMB_OF[pair[0]])].ball:
            # Turns about two axes of the limb do not close; a roll closes them where there are no other loops.
            others += _rolled(swimmer, home, pair) if len(every) == 3 and 0 not in AXIS_OF[list(pair)] else []
            continue
        for offset in _offsets(swimmer, home, pair):
            spans = _spans(swimmer, home, offset, pair)
            if spans is None:
                continue
            others += _mirrored(pair, spans) if alone else []
            if not (alone and np.all(home[:, 0, 0] > _STRAIGHT)):
                grids.append(Grid(pair, np.array(spans), offset))
                others += _small(pair, spans, offset) if same else []
    return grids, others


def _offsets(swimmer: Swimmer, home: Array, pair: tuple[int, int]) -> Iterator[Aside]:
    """Return the places of another angle at which a pair's loops are looked at; None for home."""
    yield None
    for control in swimmer.controls:
        if control not in pair and AXIS_OF[control]:
            room = _spans(swimmer, home, None, (control, pair[0]))
            yield from [] if room is None else [(control, float(_OFFSET * end)) for end in room[0] if abs(end) > 0.1]


def _small(pair: tuple[int, int], spans: list[Array], offset: Aside) -> Iterator[Loop]:
    """Return small squares of a pair within its spans."""
    for side in _SMALL:
        if all(span[0] <= -side and side <= span[1] for span in spans):
            yield rectangle(pair, (-side, side), (-side, side), offset)


def _rolled(swimmer: Swimmer, home: Array, pair: tuple[int, int]) -> Iterator[Loop]:
    """Return the loops of a ball joint alone, from corners in some directions about the limb's axis at home."""
    spans, limb = _spans(swimmer, home, None, pair), int(LIMB_OF[pair[0]])
    if spans is None:
        return
    least = float(cos(bend_limits(swimmer, home)[limb] - BEND_MARGIN_RAD))
    reach = _LONE_SHARE * float(min(spans[0][1], spans[1][1]))
    for about, (a, b), (c, d) in itertools.product(_ABOUT_RAD, _ROLLED, _ROLLED):
        corner = [(3 * limb, about), (pair[0], reach * a), (pair[1], reach * c)]
        loop = rolled(PrimitiveSequence.of(corner).busy(), limb, [(reach * (b - a), reach * (d - c), True)])
        bends = loop.cycle.shapes(loop.approach.shapes(home)[-1])[:, limb, 0, 0]
        if np.min(bends) > least:
            yield loop
    for about, pitch, yaw in itertools.product(_ABOUT_RAD, _MIRRORED, _MIRRORED):
        images = [(s * pitch * reach, t * yaw * reach) for s, t in _IMAGES]
        for senses, order in itertools.product(_SENSES, _ORDERS):
            sides = [(*images[k], senses[k] > 0) for k in order]
            yield rolled(PrimitiveSequence.of([(3 * limb, about)]).busy(), limb, sides)


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


def _measured(swimmer: Swimmer, home: Array, loops: Sequence[Loop]) -> Screws:
    """Return what loops from a shape do. Shape (2, 3, 3) of the shape."""
    pieces, counts = [], []
    for loop in loops:
        played = loop.approach + loop.cycle
        pieces.append(Pieces.of(played, home))
        counts += [len(loop.approach), len(loop.cycle)]
    moves = run_displacements(swimmer, Pieces.together(pieces), counts, np.ones(len(counts), dtype=np.int64), SEARCHING)
    approach, cycle = moves[::2], moves[1::2]
    twist = se3.log(matmul(matmul(approach, cycle), se3.inverse(approach)))
    travel = np.array([loop.cycle.joint_travel_rad for loop in loops])
    return Screws(twist, travel, np.array([2.0 * loop.approach.joint_travel_rad for loop in loops]))


@functools.lru_cache(maxsize=16)
def _every(swimmer: Swimmer, home: bytes) -> EveryLoop:
    shape = np.frombuffer(home).reshape(2, 3, 3)
    grids, others = _all_loops(swimmer, shape)
    found, more = rectangles_on(swimmer, shape, grids), _measured(swimmer, shape, others)
    screws = Screws(found.twist, found.travel, found.approach).and_more(more)
    every = EveryLoop(found, tuple(others), screws)
    both = len(set(LIMB_OF[list(swimmer.controls)].tolist())) > 1
    if both and np.all(shape[:, 0, 0] > _STRAIGHT):
        return every
    pairs = _bent_little(swimmer, shape, _paired(every))
    return EveryLoop(found, (*others, *pairs), screws.and_more(_measured(swimmer, shape, pairs)), len(pairs))


def _paired(every: EveryLoop) -> list[Loop]:
    """Return pairs of loops that are single."""
    many = len(every.rectangles)
    single = [k for k in range(len(every.screws)) if k < many or len(every.others[k - many].cycle) < _SEVERAL]
    some = np.array(single[:: math.ceil(max(len(single), 1) / _PAIRED)], dtype=np.int64)
    screws = every.screws.some(some)
    which, part = cancelling(screws.twist, screws.travel + screws.approach)
    out: list[Loop] = []
    for (i, j), share in zip(which.tolist(), part.tolist(), strict=True):
        first, second = every.some(some[[i, j]]).loops
        out.append(paired((first, second.sized(math.sqrt(abs(share)))), (True, share > 0.0)))
    return out


def _bent_little(swimmer: Swimmer, home: Array, loops: Sequence[Loop]) -> list[Loop]:
    """Return the loops that keep the bend limit throughout: a smaller rolled loop may bend a limb farther."""
    limits = bend_limits(swimmer, home) + BEND_SLACK_RAD  # fixed limbs are at theirs, but for rounding
    every = [Pieces.of(loop.approach + loop.cycle, home) for loop in loops]
    bends = LimbCircles.of(Pieces.together(every)).largest_bends()[0] if every else np.empty((0, 2))
    ends = np.cumsum([len(pieces.durations) for pieces in every])
    kept = [np.all(bends[end - len(p.durations) : end] <= limits) for p, end in zip(every, ends, strict=True)]
    return [loop for loop, keeps in zip(loops, kept, strict=True) if keeps]


def loops_of(swimmer: Swimmer, home: Array) -> EveryLoop:
    """Return the loops of a swimmer that is scaled to L = 1, worked out once a swimmer and shape."""
    return _every(swimmer, np.ascontiguousarray(home).tobytes())
