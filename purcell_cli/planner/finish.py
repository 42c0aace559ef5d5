"""The exact finish: Newton's method on the true flow until the goal is met in all twelve dimensions.

Strokes that repeat stay as they are. The others lie in stretches between them; in each stretch all
angles change together, by the least amount, so that every stretch still ends at the shape it must
and the base ends at the goal.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy as np

from purcell_cli import se3
from purcell_cli.lift import flow, flow_and_jacobian, shape_gap
from purcell_cli.primitives import EMPTY, PrimitiveSequence
from purcell_cli.rotations import Array
from purcell_cli.swimmer import Swimmer
from purcell_cli.trajectory import Block, on_the_clock, starting_shapes

_ENOUGH = 1e-12
_ROUNDS = 12
_SHORTEST_SINGULAR = 1e-9


@dataclasses.dataclass(slots=True)
class _Stretch:
    """Consecutive blocks whose angles may change, or one repeated block that stays.

    Attributes:
        blocks: The blocks.
        start: Shape before them. Shape (2, 3, 3).
        end: Shape they must end at. Shape (2, 3, 3).
    """

    blocks: list[Block]
    start: Array
    end: Array

    @property
    def repeats(self) -> bool:
        return self.blocks[0].cycles > 1

    def sequence(self) -> PrimitiveSequence:
        return sum((b.sequence for b in self.blocks), EMPTY)

    def change(self, by: Array, swimmer: Swimmer, tick: float) -> None:
        position = 0
        for k, block in enumerate(self.blocks):
            n = len(block.sequence)
            angle = block.sequence.angle + by[position : position + n]
            self.blocks[k] = dataclasses.replace(block, sequence=block.sequence.with_angles(angle))
            position += n
        self.blocks = on_the_clock(self.blocks, swimmer, tick)


def _stretches(blocks: Sequence[Block], start: Array, goal: Array) -> list[_Stretch]:
    shapes = starting_shapes(blocks, start)
    out: list[_Stretch] = []
    for block, before, after in zip(blocks, shapes, shapes[1:], strict=False):
        joins = out and not out[-1].repeats and block.cycles == 1 and out[-1].blocks[-1].phase == block.phase
        if joins:
            out[-1].blocks.append(block)
            out[-1].end = after
        else:
            out.append(_Stretch([block], before, after))
    for here, following in zip(out, [*out[1:], None], strict=True):
        if following is None:
            here.end = goal
        elif here.blocks[-1].phase != following.blocks[0].phase:
            here.end = np.round(here.end)  # between phases the limbs are collinear
            following.start = here.end
    return out


def arrive(
    swimmer: Swimmer,
    blocks: Sequence[Block],
    start_shape: Array,
    goal_shape: Array,
    displacement: Array,
    tick: float,
) -> list[Block]:
    """Return the blocks with their angles changed so that they end exactly at the goal.

    Args:
        swimmer: The swimmer, scaled to L = 1, at its own joint rate.
        blocks: The motion, almost arriving.
        start_shape: Shape before it. Shape (2, 3, 3).
        goal_shape: Shape it must end at. Shape (2, 3, 3).
        displacement: Body displacement it must make, in units of L. Shape (4, 4).
        tick: Clock step that durations are rounded to [s].

    Returns:
        The blocks of the best round; how well they arrive is for the certificate to say.
    """
    stretches = _stretches(on_the_clock(blocks, swimmer, tick), start_shape, goal_shape)
    fixed = {
        k: se3.power(flow(swimmer, s.blocks[0].sequence, s.start), s.blocks[0].cycles)
        for k, s in enumerate(stretches)
        if s.repeats
    }
    best, kept = np.inf, [list(s.blocks) for s in stretches]
    for _ in range(_ROUNDS):
        residual, jacobian = _equations(swimmer, stretches, fixed, displacement)
        size = float(np.max(np.abs(residual)))
        if size < best:
            gain, best, kept = size / best, size, [list(s.blocks) for s in stretches]
            if size < _ENOUGH or gain > 0.5:
                break
        elif size > 1e3 * best:
            break
        step = np.linalg.lstsq(jacobian, -residual, rcond=_SHORTEST_SINGULAR)[0]
        position = 0
        for stretch in stretches:
            if not stretch.repeats:
                n = len(stretch.sequence())
                stretch.change(step[position : position + n], swimmer, tick)
                position += n
    return [block for part in kept for block in part]


def _equations(
    swimmer: Swimmer, stretches: list[_Stretch], fixed: dict[int, Array], displacement: Array
) -> tuple[Array, Array]:
    """Return what is missing at the end of every stretch and at the goal, and its derivative."""
    poses, twists, closures, gaps = [], [], [], []
    for k, stretch in enumerate(stretches):
        if stretch.repeats:
            poses.append(fixed[k])
            twists.append(np.empty((6, 0)))
            continue
        sequence = stretch.sequence()
        g, jacobian = flow_and_jacobian(swimmer, sequence, stretch.start)
        gap, closure = shape_gap(sequence, stretch.start, stretch.end)
        poses.append(g)
        twists.append(jacobian)
        gaps.append(gap)
        closures.append(closure)
    after = np.eye(4)
    for k in range(len(poses) - 1, -1, -1):
        twists[k] = se3.adjoint(se3.inverse(after)) @ twists[k]
        after = poses[k] @ after
    base = se3.log(se3.inverse(displacement) @ after)
    columns = sum(t.shape[1] for t in twists)
    jacobian = np.zeros((6 + 6 * len(closures), columns))
    jacobian[:6] = np.concatenate(twists, axis=1)
    position, row = 0, 6
    for closure in closures:
        n = closure.shape[1]
        jacobian[row : row + 6, position : position + n] = closure
        position, row = position + n, row + 6
    return np.concatenate([base, *gaps]), jacobian
