"""The atlas of strokes: what a stroke does, what it costs, and how that grows with its amplitude.

Speed is the way a cycle goes per radian that the joints turn. Efficiency is of the kind of
Lighthill (1975, Mathematical Biofluiddynamics): the power that would drag the straight swimmer
along its axis at the stroke's mean speed, over the mean power dissipated (Becker, Koehler and Stone
2003, J. Fluid Mech. 490, 15, for Purcell's swimmer). The stroke is taken at the pace of even power,
which is the best it can have, so the efficiency is one of the path alone. Conventions: `rotations`.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence

import numpy as np

from purcell_cli.errors import GaitError, ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.gaits.gait import MOTIONS, Gait, Stroke
from purcell_cli.gaits.joint_fit import refuse_far_stroke
from purcell_cli.gaits.pure_stroke import realise
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, as_euler
from purcell_cli.lie_brackets.leading_order import predicted
from purcell_cli.mechanics.connection import COLLINEAR, resistance_and_coupling
from purcell_cli.mechanics.lift import piece_effort, work
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.swimmer import Swimmer

MOST_AMPLITUDES = 10_000
"""How many amplitudes or ratios a sweep may have."""


def straight_drag(swimmer: Swimmer) -> float:
    """Return the drag on the straight swimmer along its axis, per speed [N s/m]."""
    return float(resistance_and_coupling(swimmer, COLLINEAR)[0][0, 0])


def efficiency(swimmer: Swimmer, stroke: Stroke, distance_m: float) -> float:
    """Return the efficiency of one cycle that goes a distance [m]: drag times distance^2 / effort^2."""
    cycle = Pieces.of(stroke.cycle, stroke.approach.shapes(COLLINEAR)[-1])
    effort = float(np.sum(piece_effort(swimmer, cycle)))
    return straight_drag(swimmer) * (distance_m / effort) ** 2


@frozen_dataclass(eq=False)
class Entry:
    """What one cycle of a gait does, seen from the collinear shape.

    Attributes:
        gait: The gait.
        amplitude_rad: Its amplitude [rad].
        displacement: x, y, z [L] and roll, pitch, yaw [rad]. Shape (6,).
        cross_talk: The largest part of the twist that is not the gait's own motion [L, rad]; None for "none".
        joint_travel_rad: How far the joints turn in a cycle, in sum [rad].
        duration_s: How long a cycle lasts [s].
        energy_j: What a cycle dissipates [J].
        speed: Distance per joint travel [L/rad].
        turning: Angle turned per joint travel [rad/rad].
        efficiency: See the module.
    """

    gait: Gait
    amplitude_rad: float
    displacement: Array
    cross_talk: float | None
    joint_travel_rad: float
    duration_s: float
    energy_j: float
    speed: float
    turning: float
    efficiency: float


def twist_in_lengths(swimmer: Swimmer, stroke: Stroke) -> Array:
    """Return the twist of one cycle, seen from the collinear shape [L, rad]. Shape (6,)."""
    return np.asarray(se3.log(stroke.displacement(swimmer)) / np.repeat([swimmer.length_m, 1.0], 3))


def _fit(gait: Gait, swimmer: Swimmer, amplitude: float | None) -> Stroke:
    """Return the stroke of a gait, which the model of the fluid must know.

    Raises:
        GaitError: The gait has no pure stroke at this amplitude, or bends limbs too far.
    """
    stroke = realise(gait, swimmer, amplitude)
    refuse_far_stroke(swimmer, stroke)
    return stroke


def entry(gait: Gait, swimmer: Swimmer, amplitude: float | None = None) -> Entry:
    """Return a gait's entry in the atlas.

    Args:
        gait: The gait.
        swimmer: The swimmer.
        amplitude: The amplitude, the gait's default where none is given [rad].

    Raises:
        GaitError: The gait has no pure stroke at this amplitude, or bends limbs too far.
    """
    stroke = _fit(gait, swimmer, amplitude)
    g = stroke.displacement(swimmer)
    position, travel = g[:3, 3], stroke.cycle.joint_travel_rad
    twist = twist_in_lengths(swimmer, stroke)
    own = MOTIONS.index(gait.moves) if gait.moves in MOTIONS else None
    distance = float(np.linalg.norm(position))
    inner = stroke.approach.shapes(COLLINEAR)[-1]
    return Entry(
        gait,
        stroke.amplitude_rad,
        np.concatenate([position / swimmer.length_m, as_euler(g[:3, :3])[::-1]]),
        None if own is None else float(np.max(np.abs(np.delete(twist, own)))),
        travel,
        float(np.sum(stroke.cycle.duration)) / swimmer.joint_rate_rad_s,
        float(np.sum(work(swimmer, stroke.cycle, inner))),
        distance / swimmer.length_m / travel,
        float(np.linalg.norm(twist[3:])) / travel,
        efficiency(swimmer, stroke, distance),
    )


def atlas(gaits: Mapping[str, Gait], swimmer: Swimmer) -> tuple[list[Entry], dict[str, str]]:
    """Return the atlas: the entry of every gait at its default amplitude, and why gaits that have none are left out.

    Args:
        gaits: The gaits by name.
        swimmer: The swimmer.
    """
    entries: list[Entry] = []
    left_out: dict[str, str] = {}
    for gait in gaits.values():
        try:
            entries.append(entry(gait, swimmer))
        except GaitError as error:
            left_out[gait.name] = str(error)
    return entries, left_out


@frozen_dataclass
class Row:
    """A gait at one amplitude.

    Attributes:
        amplitude_rad: The amplitude [rad].
        displacement: One cycle's along the motion of the sweep, exact; None where no stroke is pure [L or rad].
        prediction: The same to leading order; 0 where no order up to the third says anything.
        order: The order of the prediction in the turns, or 0.
        reversed: Whether the direction has changed since the row before.
    """

    amplitude_rad: float
    displacement: float | None
    prediction: float | None
    order: int
    reversed: bool


@frozen_dataclass(eq=False)
class Sweep:
    """A gait at many amplitudes.

    Attributes:
        gait: The gait.
        along: The one of `MOTIONS` that is tabulated: the gait's own, or the largest at its default amplitude.
        rows: One for each amplitude.
    """

    gait: Gait
    along: str
    rows: tuple[Row, ...]


def steps(text: str, option: str) -> Array:
    """Return the numbers of A:B:STEP, from A to B. Shape (n,).

    Raises:
        ParameterError: Anything else, or too many numbers.
    """
    try:
        first, last, step = (float(part) for part in text.split(":"))
    except ValueError:
        first = last = step = 0.0
    if not (0.0 < first <= last < np.inf and step > 0.0 and (last - first) / step < MOST_AMPLITUDES):
        raise ParameterError(
            f"{option}: A:B:STEP with 0 < A <= B and at most {MOST_AMPLITUDES} steps is wanted, found {text!r}"
        )
    return np.asarray(first + step * np.arange(int(np.floor((last - first) / step + 1e-9)) + 1))


def sweep(gait: Gait, swimmer: Swimmer, amplitudes: Sequence[float] | Array) -> Sweep:
    """Return a gait's displacement at amplitudes, beside the prediction of Lie brackets at the collinear shape.

    Args:
        gait: The gait.
        swimmer: The swimmer.
        amplitudes: Amplitudes, ascending [rad].

    Raises:
        ParameterError: An amplitude that is none.
    """
    if gait.moves in MOTIONS:
        own = MOTIONS.index(gait.moves)
    else:
        own = int(np.argmax(np.abs(twist_in_lengths(swimmer, realise(gait, swimmer)))))
    rows: list[Row] = []
    sign = 0.0
    for amplitude in amplitudes:
        try:
            stroke = _fit(gait, swimmer, float(amplitude))
        except GaitError:
            rows.append(Row(float(amplitude), None, None, 0, reversed=False))
            continue
        exact = float(twist_in_lengths(swimmer, stroke)[own])
        prediction, order = predicted(swimmer, stroke.played()).leading(own)
        now = float(np.sign(exact))
        rows.append(Row(float(amplitude), exact, prediction, order, reversed=now * sign < 0.0))
        sign = now or sign
    return Sweep(gait, MOTIONS[own], tuple(rows))


@frozen_dataclass
class RatioRow:
    """A gait for a swimmer of one link ratio.

    Attributes:
        ratio: Middle over outer link.
        displacement: One cycle's along the gait's motion, in units of the swimmer's full length, or rad.
    """

    ratio: float
    displacement: float


def ratio_sweep(gait: Gait, swimmer: Swimmer, amplitude: float | None, ratios: Array) -> tuple[str, list[RatioRow]]:
    """Return what a gait does for swimmers of one full length, at ratios of the middle to an outer link, in the mean.

    The design question of Giraldi, Martinon and Zoppello (2015, Phys. Rev. E 91, 023012).

    Args:
        gait: The gait.
        swimmer: The swimmer, whose full length is kept.
        amplitude: The amplitude, the gait's default where none is given [rad].
        ratios: Middle over outer link. Shape (n,).

    Returns:
        The one of `MOTIONS` that is tabulated, and a row for each ratio.

    Raises:
        GaitError: No pure stroke for one of the swimmers.
        ParameterError: A swimmer whose drag is known in numbers only.
    """
    if not isinstance(swimmer.drag, str):
        raise ParameterError("drag: a law, by which links of other lengths drag, is wanted, found numbers")
    base, one, two = swimmer.halves_m
    half = base + (one + two)
    rows: list[RatioRow] = []
    own = MOTIONS.index(gait.moves) if gait.moves in MOTIONS else None
    for ratio in ratios.tolist():
        limb = half / (ratio + 2.0)
        body = _with_halves(swimmer, ratio * limb, limb)
        twist = se3.log(_fit(gait, body, amplitude).displacement(body)) / np.repeat([2.0 * half, 1.0], 3)
        own = int(np.argmax(np.abs(twist))) if own is None else own
        rows.append(RatioRow(ratio, float(twist[own])))
    return MOTIONS[own or 0], rows


def _with_halves(swimmer: Swimmer, base: float, limb: float) -> Swimmer:
    """Return the swimmer with half lengths of its base and, in the mean, of its limbs; those stay in proportion [m]."""
    mean, links = 0.5 * sum(swimmer.halves_m[1:]), swimmer.links
    if swimmer.halves_m[1] != swimmer.halves_m[2]:
        for k, link in enumerate(("limb1", "limb2"), start=1):
            own = dataclasses.replace(getattr(links, link), half_length_m=swimmer.halves_m[k] * limb / mean)
            links = dataclasses.replace(links, **{link: own})
    return dataclasses.replace(swimmer, base_half_length_m=base, limb_half_length_m=limb, links=links)
