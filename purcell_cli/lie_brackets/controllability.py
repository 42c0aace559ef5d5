"""Local controllability at a shape, from the Lie brackets themselves (section IV and appendix A of the paper).

The six controls span the limbs' motions, so brackets have only the base to win: with the lift of its limb part
taken away, a bracket leaves a twist in se(3) (`fields.Frame.vertical`). Two questions are answered by them:

- Chow's: the control fields and their brackets up to depth k span a space of dimension 6 + rank of those twists.
  12 of it is all of Q: every shape and pose nearby can be reached (strong controllability).
- The appendix's: h_1 = span A(r), h_2 = span DA(r), h_3, ... add up to se(3) or not: every pose nearby can
  be reached, the shape left free (weak controllability).

Derivatives are exact; what is left is rounding. Those of links that feel each other's flow are by interpolation
(`bead_polynomials`), and beside a wall the second question is not asked: it rests on left invariance. Singular values
are in units of L and rad per rad^depth.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.errors import ParameterError, refuse_types
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.lie_brackets.control_fields import (
    ALL_CONTROLS,
    MOST_DEPTH,
    YAW_CONTROLS,
    Frame,
    Word,
    brackets_by_depth,
    first_brackets,
    frame,
)
from purcell_cli.lie_brackets.joint_fields import joint_frame
from purcell_cli.lie_brackets.ranks import WEAK, Rank, null_space, rank_of, simplest
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.connection import COLLINEAR, checked_shape
from purcell_cli.mechanics.joint_motion import in_plane, plane_axis, refuse_shape
from purcell_cli.mechanics.swimmer import Swimmer

DIRECTIONS = ("surge", "sway", "heave", "roll", "pitch", "yaw")
"""The base's directions: along x, y, z and about them."""

Shown = Literal["controllable", "weakly controllable", "undecided", "not shown"]
"""What can be shown of a shape within a depth."""

PLANAR_ROWS = (0, 1, 5)
"""The directions of a swimmer that stays in its x-y plane."""

_MOST_LEVELS = 4
"""h_5 would have a thousand million brackets."""


@frozen_dataclass(eq=False)
class Level:
    """One bracket depth, or one space h_k of the appendix, with all that is below it.

    Attributes:
        number: The depth, or k.
        count: How many brackets there are of this level.
        rank: The rank of the twists up to here.
        added: The directions that are new, in their simplest form: a row each. Shape (n, directions).
    """

    number: int
    count: int
    rank: Rank
    added: Array


@frozen_dataclass(eq=False)
class Bracket:
    """A bracket and the base motion it leaves when the limbs are brought back.

    Attributes:
        word: The bracket's controls.
        twist: The twist (v/L, omega) per rad^depth. Shape (6,).
        limbs: The limb rotation of the bracket, to be brought back, per rad^depth. Shape (6,).
    """

    word: Word
    twist: Array
    limbs: Array


@frozen_dataclass(eq=False)
class Controllability:
    """What can be reached from a shape.

    Attributes:
        swimmer: The swimmer.
        shape: The shape. Shape (2, 3, 3).
        controls: The controls that act.
        rows: The base directions that count, indices into `DIRECTIONS`.
        direct: Rank of A(r): what the controls do directly, h_1.
        null: Limb rates that leave the base still, in their simplest form: a row each. Shape (n, controls).
        depths: The brackets by depth from 2, until full with nothing weak, or to the depth asked for.
        levels: The spaces h_1 + ... + h_k, until full with nothing weak, or to the depth asked for; at most four, and
            none beside a wall.
        brackets: All brackets that were made, by depth.
        beside: How the swimmer sees its wall, the normal in base coordinates and its middle's height [m]. Shape (4,).
    """

    swimmer: Swimmer
    shape: Array
    controls: tuple[int, ...]
    rows: tuple[int, ...]
    direct: Rank
    null: Array
    depths: tuple[Level, ...]
    levels: tuple[Level, ...]
    brackets: tuple[Bracket, ...]
    beside: Array | None = None

    def __repr__(self) -> str:
        return f"<Controllability: {self.verdict}, growth vector {self.growth}>"

    @property
    def dimension(self) -> int:
        """The dimension of the configuration space: 12, 5 in the plane, and as joints have it."""
        return len(self.controls) + len(self.rows)

    @property
    def growth(self) -> tuple[int, ...]:
        """The growth vector: the dimension that brackets up to depth 1, 2, ... span."""
        return (len(self.controls), *(len(self.controls) + level.rank.dimension for level in self.depths))

    @property
    def chow(self) -> bool:
        """Whether Chow's condition holds within the depth: strong controllability."""
        return self.growth[-1] == self.dimension

    @property
    def verdict(self) -> Shown:
        """What is shown: controllable, weakly controllable, undecided (rounding could be it) or not shown."""
        ways: tuple[tuple[tuple[Level, ...], Shown], ...]
        ways = (self.depths, "controllable"), (self.levels, "weakly controllable")
        for levels, verdict in ways:
            full = [level for level in levels if level.rank.dimension == len(self.rows)]
            if any(level.rank.robustness != "undecided" for level in full):
                return verdict
        return "undecided" if self.chow or self.weak_level else "not shown"

    @property
    def weak_level(self) -> int | None:
        """The k at which h_1 + ... + h_k is all of se(3): weak controllability; None where it is not seen."""
        full = [level.number for level in self.levels if level.rank.dimension == len(self.rows)]
        return full[0] if full else None


def _level(number: int, below: Array, vectors: Array, basis: Array, rounding: float) -> tuple[Level, Array]:
    """Return the level that twists make with those below it, and all of them."""
    every = np.concatenate([below, vectors])
    rank = rank_of(every, rounding)
    rest = rank.basis - basis @ (basis.T @ rank.basis)
    new = max(rank.dimension - basis.shape[1], 0)
    left = np.linalg.svd(rest)[0][:, :new]
    return Level(number, len(vectors), rank, simplest(left)), every


def _depths(around: Frame, rows: tuple[int, ...]) -> tuple[list[Level], list[Bracket]]:
    levels: list[Level] = []
    brackets: list[Bracket] = []
    every, basis = np.empty((0, len(rows))), np.empty((len(rows), 0))
    for fields in brackets_by_depth(around):
        vertical = around.vertical(fields)[0]
        level, every = _level(len(levels) + 2, every, vertical[:, rows], basis, around.rounding)
        basis = level.rank.basis
        levels.append(level)
        parts = zip(fields.words, vertical, fields.limbs, strict=True)
        brackets += [Bracket(word, twist, limbs) for word, twist, limbs in parts]
        if level.rank.clear_dimension == len(rows):
            break
    return levels, brackets


def _filtration(around: Frame, rows: tuple[int, ...], depth: int) -> list[Level]:
    """Return h_1, h_1 + h_2, ... of appendix A: from k = 3 on covariant derivatives, and brackets with h_2 to h_(k-1).

    The appendix's Lie derivative of the 2-form DA differs from the derivative of its value on the controls'
    fields by values of DA itself: the sums are the same.
    """
    own = around.fields.twist
    if around.base_steps is not None:
        return []
    level, every = _level(1, np.empty((0, len(rows))), own[0][:, rows], np.empty((len(rows), 0)), around.rounding)
    levels, earlier, last = [level], own[:, :0], own
    for number in range(2, min(depth, _MOST_LEVELS) + 1):
        if level.rank.clear_dimension == len(rows):
            break
        degree = depth - number
        ring = around.ring(degree)
        if number == 2:
            last = around.vertical(first_brackets(around))
        else:
            change = around.along(last, degree + 1)
            pairs = (own[: len(ring), :, None], last[: len(ring), None])
            change = change + ring.product(*pairs, se3.bracket)
            pairs = (earlier[: len(ring), :, None], last[: len(ring), None])
            both = ring.product(*pairs, se3.bracket)
            last = np.concatenate([x.reshape(len(ring), -1, 6) for x in (change, both)], axis=1)
        earlier = np.concatenate([earlier[: len(ring)], last], axis=1)
        level, every = _level(number, every, last[0][:, rows], level.rank.basis, around.rounding)
        levels.append(level)
    return levels


def checked_depth(depth: int) -> int:
    """Return a bracket depth that can be computed.

    Raises:
        ParameterError: There are no coefficients for it.
    """
    if not 2 <= depth <= MOST_DEPTH:
        raise ParameterError(f"depth: a whole number from 2 to {MOST_DEPTH} is wanted, found {depth}")
    return depth


def controllability(
    swimmer: Swimmer, shape: ArrayLike = COLLINEAR, depth: int = 4, planar: bool = False, pose: ArrayLike | None = None
) -> Controllability:
    """Return what the swimmer can reach near a shape, by brackets of its control fields.

    Args:
        swimmer: The swimmer.
        shape: The shape (A_1, A_2). Shape (2, 3, 3).
        depth: The deepest brackets to look at, 2 to 6.
        planar: Whether only the yaw joints turn, which keeps a planar shape in its plane.
        pose: The base's pose, which counts beside a wall alone [m]; the world's frame if there is none. Shape (4, 4).

    Raises:
        ParameterError: A depth that there are no coefficients for, a planar swimmer out of its plane or beside a wall,
            or one that touches its wall.
    """
    refuse_types(swimmer=(swimmer, Swimmer))
    r = checked_shape(shape)
    checked_depth(depth)
    if r.ndim != 3 or not np.all(np.isfinite(r)):
        raise ParameterError("one shape of finite numbers is wanted")
    if planar and not np.all(np.abs(r[:, 2, 2]) >= 1.0 - 1e-12):
        raise ParameterError("a planar shape is wanted, its limbs bent by yaw alone")
    axis = plane_axis(swimmer)
    if swimmer.wall is not None and (planar or axis is not None):
        raise ParameterError(
            "wall: none is wanted for a planar swimmer, which a wall turns out of its plane, found one"
        )
    beside = None if swimmer.wall is None else swimmer.wall.beside(np.eye(4) if pose is None else np.asarray(pose))
    near = None if beside is None else beside / np.append(np.ones(3), swimmer.length_m)
    if planar or swimmer.ball_joints:
        controls, rows = (YAW_CONTROLS, PLANAR_ROWS) if planar else (ALL_CONTROLS, tuple(range(6)))
        around = frame(swimmer, r, depth - 1, controls, near)
    else:
        refuse_shape(swimmer, "shape", Configuration(shape=r))
        if not swimmer.controls:
            raise ParameterError("swimmer: a joint that turns is wanted, found two fixed joints")
        rows = tuple(range(6)) if axis is None else in_plane(axis)
        around = joint_frame(swimmer, r, depth - 1, near)
        controls = around.controls
    depths, brackets = _depths(around, rows)
    direct = around.fields.twist[0][:, rows]
    return Controllability(
        swimmer,
        r,
        controls,
        rows,
        rank_of(direct, around.rounding),
        null_space(direct, around.rounding),
        tuple(depths),
        tuple(_filtration(around, rows, depth)),
        tuple(brackets),
        beside,
    )


def makers(found: Controllability, direction: int) -> Sequence[Bracket]:
    """Return the shortest bracket that moves the base in a direction, and the shortest of use where that is another.

    Of one depth that with most of the direction in it is taken, by size and by share. One of use moves the base by
    `WEAK` or more in the direction, and that is at least half of its whole twist.

    Args:
        found: What the brackets are.
        direction: Index into `DIRECTIONS`.
    """
    out: list[Bracket] = []
    floors = {level.number: level.rank.floor for level in found.depths}
    for depth in floors:
        mine = [b for b in found.brackets if len(b.word) == depth]
        sizes = np.array([b.twist for b in mine]).reshape(-1, 6)
        shares = np.abs(sizes[:, direction]) / np.maximum(np.linalg.norm(sizes, axis=1), 1e-300)
        there = np.abs(sizes[:, direction]) > floors[depth]
        use = there & (np.abs(sizes[:, direction]) >= WEAK) & (shares >= 0.5)
        if (not out and np.any(there)) or np.any(use):
            among = np.flatnonzero(use if np.any(use) else there)
            worth = np.abs(sizes[among, direction]) * shares[among]
            worth = np.round(worth / worth.max(), 9)
            yaws = np.array(
                [sum(control % 3 for control in mine[k].word) for k in among]
            )  # of equals, that with most yaw
            out.append(mine[among[np.lexsort((among, -yaws, -worth))[0]]])
        if np.any(use):
            break
    return out
