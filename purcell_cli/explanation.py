"""Why a plan is as it is: what each stroke does and leaves to be done, what limits it, what upsets it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, as_euler, as_vector
from purcell_cli.mechanics.configuration import Deviation
from purcell_cli.mechanics.moves import ControlSequence
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.motion.blocks import starting_shapes
from purcell_cli.motion.limb_circles import LimbCircles, bends
from purcell_cli.motion.on_beads import end_on_beads
from purcell_cli.motion.plan import Plan, Structure
from purcell_cli.motion.sensitivity import Sensitivity, sensitivities
from purcell_cli.solution import Solution, phase_displacement, stroke_cycles

_MINOR = 0.05
"""Parts of a displacement below this share of the largest are not put into words."""

_NOTICED = 0.01
"""A displacement with a left-out part above this share of the largest is described by "mainly"."""

_NOTHING = 1e-8
"""A displacement below this (L, rad) is none."""

_NEARLY_STRAIGHT_RAD = 0.5
"""Limbs bent no more than this are called nearly straight: small bends then roll the base [rad]."""

_AT_LIMIT_RAD = 5e-4
"""A stroke whose largest bend is within this of the limit [rad] is limited by it: strokes keep 2e-4 from it, and what
refines them a little more."""

_MANY_CYCLES = 4
"""From this many cycles on, the explanation says that each cycle's error adds up."""


@frozen_dataclass(eq=False)
class StrokeReason:
    """What a stroke is for.

    Attributes:
        phase: 1, 2 or 3 of the reconfiguration.
        gait: Its name.
        words: What it does, in words.
        cycles: How often it is played.
        joint_travel_rad: What it costs: the sum over its primitives of |angle| [rad].
        energy_j: The energy it dissipates [J].
        missing: Body displacement still to make after it: in phases 1 and 2 to where phase 3 begins,
            in phase 3 to the goal [m]. Shape (4, 4).
        largest_bend_rad: The largest angle between a limb's axis and the base's while it is played [rad].
        limits: Which limits it is at.
    """

    phase: int
    gait: str
    words: str
    cycles: int
    joint_travel_rad: float
    energy_j: float
    missing: Array
    largest_bend_rad: float
    limits: tuple[str, ...]


@frozen_dataclass
class Culprit:
    """The stroke that has the largest part in a sensitivity.

    Attributes:
        stroke: Its index.
        share: Its part of what all strokes add, from 0 to 1.
        words: What makes it sensitive, in words; empty where nothing special does.
    """

    stroke: int
    share: float
    words: str


@frozen_dataclass
class OnBeads:
    """Where a plan would end if links felt each other's flow.

    Attributes:
        off: How far from the goal; None where that is not known.
        why_not: Why it is not known, in words; else empty.
    """

    off: Deviation | None
    why_not: str = ""

    @classmethod
    def of(cls, plan: Plan) -> OnBeads:
        """Return it for a plan, at once and to `on_beads.ACCURACY` of it."""
        if plan.swimmer.fluid == "beads":
            return cls(None, "the plan is made for links that feel each other")
        try:
            end = end_on_beads(plan.swimmer, plan.start, plan.blocks)
        except ParameterError as error:
            return cls(None, str(error))
        return cls(Deviation.between(end, plan.goal))


@frozen_dataclass(eq=False)
class Explanation:
    """Why a plan is as it is.

    Attributes:
        strokes: What each stroke is for.
        structures: The structures that were weighed, best first; the first one was taken.
        sensitivities: What the end does if the swimmer is a little off.
        culprits: For each of them, the stroke with the largest part in it; None where nothing moves.
        on_beads: Where it would end if links felt each other's flow.
    """

    strokes: tuple[StrokeReason, ...]
    structures: tuple[Structure, ...]
    sensitivities: tuple[Sensitivity, ...]
    culprits: tuple[Culprit | None, ...]
    on_beads: OnBeads


def explain(solution: Solution) -> Explanation:
    """Return why a plan is as it is."""
    plan = solution.plan
    reasons = _reasons(solution)
    found = sensitivities(plan.swimmer, plan.start, plan.blocks)
    culprits = tuple(_culprit(solution, s, reasons) for s in found)
    return Explanation(tuple(reasons), plan.structures, found, culprits, OnBeads.of(plan))


def _reasons(solution: Solution) -> list[StrokeReason]:
    plan = solution.plan
    shapes = starting_shapes(plan.blocks, plan.start.shape)
    poses = se3.prefix_products(solution.displacement)
    goal = se3.inverse(plan.start.pose) @ plan.goal.pose
    before_last = goal @ se3.inverse(phase_displacement(solution, 3))
    out = []
    for part in solution.strokes:
        blocks = plan.blocks[part]
        bend = max(largest_bend(b.sequence, shapes[part.start + k]) for k, b in enumerate(blocks))
        target = goal if blocks[0].phase == 3 else before_last
        out.append(
            StrokeReason(
                blocks[0].phase,
                blocks[0].gait,
                in_words(se3.inverse(poses[part.start]) @ poses[part.stop], plan.swimmer.length_m),
                stroke_cycles(blocks),
                sum(b.joint_travel_rad for b in blocks),
                float(np.sum(solution.energy_j[part])),
                se3.normalised(se3.inverse(poses[part.stop]) @ target),
                bend,
                ("bend limit",) if abs(bend - plan.swimmer.max_bend_rad) <= _AT_LIMIT_RAD else (),
            )
        )
    return out


def largest_bend(sequence: ControlSequence, start: Array) -> float:
    """Return the largest angle between a limb's axis and the base's along a sequence of controls [rad].

    Args:
        sequence: The primitives or moves.
        start: Shape before them. Shape (2, 3, 3).
    """
    circles = LimbCircles.of(Pieces.of(sequence, start))
    return float(np.max(circles.largest_bends()[0], initial=np.max(bends(start[..., 0]))))


def in_words(displacement: Array, length_m: float) -> str:
    """Return what a body displacement does, in words, leaving out what is small beside the rest.

    Args:
        displacement: The displacement [m]. Shape (4, 4).
        length_m: The length L that makes a way comparable with an angle [m].
    """
    way, turn = displacement[:3, 3], as_euler(displacement[:3, :3])
    sizes = np.abs(np.concatenate([way / length_m, turn]))
    told = sizes >= max(_NOTHING, _MINOR * float(np.max(sizes)))
    if not np.any(told):
        return "goes nowhere"
    ways = [f"{figure(abs(v) * 1e3)} mm along {'-' if v < 0 else ''}{axis}" for axis, v in zip("xyz", way, strict=True)]
    verbs = zip(("yaws", "pitches", "rolls"), np.degrees(turn), strict=True)
    turns = [f"{verb} by {figure(angle)} deg" for verb, angle in verbs]
    moved = _listed([words for words, said in zip(ways, told[:3], strict=True) if said])
    parts = [*(["moves " + moved] if moved else []), *(w for w, said in zip(turns, told[3:], strict=True) if said)]
    left_out = np.any(sizes[~told] > _NOTICED * float(np.max(sizes)))
    return ("mainly " if left_out else "") + _listed(parts)


def figure(value: float) -> str:
    """Return a number to three figures, in whole units where those are more."""
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e7 else f"{value:.3g}"


def _listed(parts: Sequence[str]) -> str:
    """Return words as a list in a sentence."""
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts)


def _culprit(solution: Solution, found: Sensitivity, reasons: Sequence[StrokeReason]) -> Culprit | None:
    length_m = solution.plan.swimmer.length_m
    twists = np.array([found.by_block[part].sum(axis=0) for part in solution.strokes]).reshape(-1, 6)
    sizes = np.linalg.norm(twists[:, :3], axis=1) / length_m + np.linalg.norm(twists[:, 3:], axis=1)
    if not np.any(sizes > _NOTHING):
        return None
    worst = int(np.argmax(sizes))
    return Culprit(worst, float(sizes[worst] / np.sum(sizes)), _what_is_sensitive(solution, worst, reasons))


def _what_is_sensitive(solution: Solution, stroke: int, reasons: Sequence[StrokeReason]) -> str:
    """Return what makes a stroke sensitive: a roll stroke, a rotation before a long way, or many cycles."""
    length_m = solution.plan.swimmer.length_m
    part, reason = solution.strokes[stroke], reasons[stroke]
    moved = se3.prefix_products(solution.displacement[part])[-1]
    rest = se3.prefix_products(solution.displacement[part.stop :])[-1]
    turns, way = np.abs(as_euler(moved[:3, :3])), float(np.linalg.norm(moved[:3, 3]) / length_m)
    turn = as_vector(moved[:3, :3])
    axis = turn / max(float(np.linalg.norm(turn)), _NOTHING)
    swung = float(np.linalg.norm(np.cross(axis, rest[:3, 3])) / length_m)
    out = []
    if turns[2] > max(turns[0], turns[1], way) and reason.largest_bend_rad <= _NEARLY_STRAIGHT_RAD:
        out.append("it rolls with nearly straight limbs, where little resists a roll")
    if reason.cycles >= _MANY_CYCLES:
        out.append(f"the error of one cycle adds up over {reason.cycles} cycles")
    if np.max(turns) > way and swung > 1.0:
        out.append(
            f"it sets the direction of a displacement of {figure(float(np.linalg.norm(rest[:3, 3])) / length_m)} L"
        )
    return "; ".join(out)
