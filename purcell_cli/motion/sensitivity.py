"""How far the end of a motion moves if the swimmer is not quite what it was planned for.

The same controls are replayed, all of them, for a swimmer with one parameter a little off, up and
down; nothing is linearised but the share of each stroke. The shape path does not depend on the
swimmer's body, and a stroke that repeats is a power of its one cycle, so a replay costs the
distinct strokes only. Viscosity has no part in it, but where the drag of some links is known in numbers: else it
scales forces and never the path. For links that feel each other it is told as for links alone: a table for each
parameter would take minutes.
"""

from __future__ import annotations

import contextlib
import dataclasses
import functools
from collections.abc import Iterator, Mapping, Sequence
from types import MappingProxyType

import numpy as np

from purcell_cli.errors import ParameterError
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.reproducible import inner, matmul, norm
from purcell_cli.geometry.rotations import Array, angle_between
from purcell_cli.mechanics.collocation import Accuracy
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.drag import FINITE_RODS, LINKS, LinkDrag, LinkDrags
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.blocks import Block, block_displacements

PARAMETERS: Mapping[str, str] = MappingProxyType(
    {
        "slenderness": "slenderness",
        "drag_ratio": "drag ratio",
        "base_half_length_m": "half length of the base",
        "limb_half_length_m": "half length of the limbs",
    }
)
"""The parameters of a swimmer that its path depends on, and what they are called."""

_SOMETIMES: Mapping[str, str] = MappingProxyType(
    {"body_radius_m": "radius of the body", "viscosity_pa_s": "viscosity, of what has no numbers"}
)
"""Those that the path of some swimmers depends on."""

_DRAGS = {"along_n_s_per_m": "along", "across_n_s_per_m": "across", "turn_n_m_s": "of turning", "spin_n_m_s": "of spin"}
"""What the numbers of a link's drag are called."""

CHANGE = 0.01
"""How much a parameter is off, as a fraction of it."""

_BASE, _LIMBS = LINKS[:1], LINKS[1:]
_KINDS = (
    (_BASE, "along_n_s_per_m"),
    (_BASE, "turn_n_m_s"),
    (_LIMBS, "along_n_s_per_m"),
    (_LIMBS, "across_n_s_per_m"),
    (_LIMBS, "turn_n_m_s"),
)
"""Which drags are uncertain on their own: shielding changes those of one kind of link alike."""
_STEP = 1e-3
"""The relative change that derivatives by the logarithm of a drag are taken with: less than a rod's ratio allows."""

_ENOUGH = Accuracy(stages=5, step=0.4)
"""Errors of 1e-8 (L, rad) in a whole plan, in half the time."""


@frozen_dataclass(eq=False)
class Sensitivity:
    """What a parameter that is a little off does to the end of a motion.

    Attributes:
        parameter: One of `parameters`.
        change: The fraction by which it is off, of the two signs the one that moves the end further.
        position_m: How far the base's end position moves [m].
        angle_rad: How far the base's end orientation turns [rad].
        by_block: What each block adds, as twists seen at the end, first order in the
            change [m, rad]. Shape (n, 6).
    """

    parameter: str
    change: float
    position_m: float
    angle_rad: float
    by_block: Array

    def __post_init__(self) -> None:
        self.by_block.setflags(write=False)


def sensitivities(
    swimmer: Swimmer, start: Configuration, blocks: Sequence[Block], change: float = CHANGE
) -> tuple[Sensitivity, ...]:
    """Return what each of `parameters`, a little off, does to the end of a motion.

    Args:
        swimmer: The swimmer that the motion was planned for.
        start: The configuration at the beginning.
        blocks: The motion.
        change: How much a parameter is off, as a fraction of it.
    """
    swimmer = dataclasses.replace(swimmer, fluid="local")
    planned = block_displacements(swimmer, blocks, start.shape, _ENOUGH)
    after = _after(planned)
    end = matmul(start.pose, after[0])
    out = []
    for parameter in parameters(swimmer):
        found = []
        for fraction, other in _neighbours(swimmer, parameter, change):
            moved = block_displacements(other, blocks, start.shape, _ENOUGH)
            other_end = matmul(start.pose, _after(moved)[0])
            steps = se3.normalised(
                matmul(matmul(matmul(se3.inverse(after[1:]), se3.inverse(planned)), moved), after[1:])
            )
            position = float(norm(other_end[:3, 3] - end[:3, 3]))
            angle = float(angle_between(end[:3, :3], other_end[:3, :3]))
            by_block = se3.log(steps) if len(steps) else np.empty((0, 6))
            found.append(Sensitivity(parameter, fraction, position, angle, by_block))
        out.append(max(found, key=lambda s: s.position_m / swimmer.length_m + s.angle_rad))
    return tuple(out)


def drag_sensitivity(swimmer: Swimmer, blocks: Sequence[Block], start: Array) -> float:
    """Return how far a motion's end moves when the drag of each kind of link is uncertain, on its own.

    The drag of the base along its axis and in turning, and that of the limbs along, across and in turning: the root of
    the sum of the squares of the end's derivatives by their logarithms. All drags together move nothing, so the base's
    across is left out.

    Args:
        swimmer: The swimmer.
        blocks: The motion.
        start: Shape before it. Shape (2, 3, 3).

    Returns:
        Distances in units of L and angles together [L, rad per relative change].
    """
    total = 0.0
    planned, *others = (_after(block_displacements(one, blocks, start, _ENOUGH))[0] for one in _uncertain(swimmer))
    for end in others:
        twist = se3.log(se3.normalised(matmul(se3.inverse(planned), end))) / _STEP
        twist[:3] /= swimmer.length_m
        total += float(inner(twist, twist))
    return float(np.sqrt(total))


@functools.lru_cache(maxsize=16)
def _uncertain(swimmer: Swimmer) -> tuple[Swimmer, ...]:
    """Return a swimmer in a fluid of links alone, and with each of the `_KINDS` of drag a little more."""
    alone = dataclasses.replace(swimmer, fluid="local")
    out = [alone]
    for links, name in _KINDS:
        drags = {}
        for k, link in enumerate(LINKS):
            rod = alone.rod(k)
            drag = LinkDrag(rod.along, rod.across, rod.turn, rod.spin)
            more = {name: getattr(drag, name) * (1.0 + _STEP)} if link in links else {}
            drags[link] = dataclasses.replace(drag, **more)
        out.append(dataclasses.replace(alone, drag=LinkDrags(**drags)))
    return tuple(out)


def _neighbours(swimmer: Swimmer, parameter: str, change: float) -> Iterator[tuple[float, Swimmer]]:
    """Return the swimmers with a parameter a little more and a little less, where there are such swimmers."""
    for fraction in (change, -change):
        with contextlib.suppress(ParameterError):
            yield fraction, _changed(swimmer, parameter, 1.0 + fraction)


def parameters(swimmer: Swimmer) -> list[str]:
    """Return the names of the parameters that a swimmer's path depends on: keys of its file, with dots between."""
    plain = [name for name in PARAMETERS if name != "drag_ratio" or swimmer.drag not in FINITE_RODS]
    body = ["body_radius_m"] if swimmer.body_radius_m else []
    if isinstance(swimmer.drag, str):
        return plain + body
    own = {link: getattr(swimmer.drag, link) for link in LINKS}
    numbers = [
        f"drag.{link}.{name}" for link, drag in own.items() for name in _DRAGS if getattr(drag, name) is not None
    ]
    return plain + body + (["viscosity_pa_s"] if body or len(numbers) < len(LINKS) * len(_DRAGS) else []) + numbers


def parameter_name(parameter: str) -> str:
    """Return what one of `parameters` is called."""
    known = {**PARAMETERS, **_SOMETIMES}
    if parameter in known:
        return known[parameter]
    _, link, number = parameter.split(".")
    return f"drag {_DRAGS[number]}, {link.replace('limb', 'limb ')}"


def _changed(swimmer: Swimmer, parameter: str, factor: float) -> Swimmer:
    """Return a swimmer with a parameter times a factor; sizes of links of their own change with the swimmer's."""
    if parameter.startswith("drag."):
        _, link, number = parameter.split(".")
        own = getattr(swimmer.drag, link)
        changed = dataclasses.replace(own, **{number: getattr(own, number) * factor})
        return dataclasses.replace(swimmer, drag=dataclasses.replace(swimmer.drag, **{link: changed}))  # type: ignore[type-var]
    name = {"limb_half_length_m": "half_length_m"}.get(parameter, parameter)
    links = swimmer.links
    for link in LINKS:
        own = getattr(links, link)
        if name in {"half_length_m", "slenderness"} and (value := getattr(own, name)) is not None:
            links = dataclasses.replace(links, **{link: dataclasses.replace(own, **{name: value * factor})})
    return dataclasses.replace(swimmer, links=links, **{parameter: getattr(swimmer, parameter) * factor})


def _after(poses: Array) -> Array:
    """Return the displacements from before each block, and after the last, to the end. Shape (n + 1, 4, 4)."""
    return se3.inverse(se3.prefix_products(se3.inverse(poses)[::-1]))[::-1]
