"""Chains of rolls and loops, settled on displacements by the kernel."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.kernel.arrays import Array, address, doubles, wholes
from purcell_cli.kernel.library import KERNEL

MEASURES = ("travel", "energy", "switches")
"""What loops may cost, by the kernel's numbers from 0 on."""
_NUMBERS, _TERMS, _MOVES = 10, 16, 12
"""Numbers before a series, the most terms of it in one variable, and its values without the costs."""


@frozen_dataclass(eq=False)
class LoopTable:
    """Loops of one kind.

    Attributes:
        numbers: The least and greatest bend and part aside, the root of this that the series is in, whether it lies
            across the plane, the unit of costs, and the shape of the series; see `struct loops`. Shape (10,).
        series: Chebyshev series of cycles and ways, and of energy what they cost; then their slopes. Shape (3, t, v).
    """

    numbers: Array
    series: Array

    def __post_init__(self) -> None:
        numbers = doubles(self.numbers, "numbers", (_NUMBERS,))
        *_, rows, columns, values = numbers.tolist()
        if not (2 <= rows <= _TERMS and 2 <= columns <= _TERMS and values in (_MOVES, _MOVES + 2)):
            raise ValueError(f"numbers: 2 to {_TERMS} terms and {_MOVES} values or two more are wanted")
        object.__setattr__(self, "numbers", numbers)
        shape = 3, int(rows) * int(columns), int(values)
        object.__setattr__(self, "series", doubles(self.series, "series", shape))


@frozen_dataclass(eq=False)
class RollTable:
    """Roll strokes.

    Attributes:
        roll: By how much one rolls, ascending from 0 [rad]. Shape (k,).
        travel: Its joint travel [rad]. Shape (k,).
        largest: Larger rolls take several strokes [rad].
    """

    roll: Array
    travel: Array
    largest: float

    def __post_init__(self) -> None:
        roll = doubles(self.roll, "roll", (-1,))
        if len(roll) < 2 or not self.largest > 0.0:
            raise ValueError("roll: two rolls at least and a largest one are wanted")
        object.__setattr__(self, "roll", roll)
        object.__setattr__(self, "travel", doubles(self.travel, "travel", (len(roll),)))


class Settled(NamedTuple):
    """Chains that settled.

    Attributes:
        unknown: Their bends, asides and rolls, the best of all rounds. Shape (n, 3 m + 1).
        off: What those miss by; of far displacements what lies across by less, for it is a heading. Shape (n,).
        paid: What those cost. Shape (n,).
        cost: What the chains of the last round cost. Shape (n,).
        displacement: What those do to the base. Shape (n, 4, 4).
        residual: Twists from what is wanted to that. Shape (n, 6).
        derivative: By the unknowns. Shape (n, 6, 3 m + 1).
        slope: Derivatives of costs. Shape (n, 3 m + 1).
    """

    unknown: Array
    off: Array
    paid: Array
    cost: Array
    displacement: Array
    residual: Array
    derivative: Array
    slope: Array


def settled(
    kinds: Sequence[LoopTable],
    rolls: RollTable,
    measure: str,
    which: ArrayLike,
    cycles: ArrayLike,
    mirrored: ArrayLike,
    backwards: ArrayLike,
    unknown: ArrayLike,
    wanted: ArrayLike,
    low: ArrayLike,
    high: ArrayLike,
    loose: ArrayLike,
    rounds: int,
) -> Settled:
    """Return chains changed until they make displacements, at little cost.

    Every round takes the least step to the displacement from where the cost alone would lead, within bounds.

    Args:
        kinds: The loops to choose from.
        rolls: What rolls.
        measure: One of `MEASURES`.
        which: The kind of each arc; -1 for none. Shape (n, m).
        cycles: How many cycles each has. Shape (n, m).
        mirrored: Whether it turns the other way. Shape (n, m).
        backwards: Whether it is swum backwards. Shape (n, m).
        unknown: The bends, asides and rolls to begin with. Shape (n, 3 m + 1).
        wanted: The displacements. Shape (n, 4, 4).
        low: The least unknowns. Shape (n, 3 m + 1).
        high: The greatest. Shape (n, 3 m + 1).
        loose: The inverse of how much their changes count. Shape (n, 3 m + 1).
        rounds: How many rounds; with none the chains stay as they are.
    """
    kind = wholes(which, "which", (-1, -1))
    n, m = kind.shape
    if kind.size and not -1 <= int(kind.min()) <= int(kind.max()) < len(kinds):
        raise ValueError(f"which: numbers from -1 to {len(kinds) - 1} are wanted")
    if measure not in MEASURES or (measure == "energy" and any(k.series.shape[2] == _MOVES for k in kinds)):
        raise ValueError(f"measure: one of {', '.join(MEASURES)} is wanted, with costs of energy, found {measure!r}")
    width = 3 * m + 1
    begun = np.array(doubles(unknown, "unknown", (n, width)))
    flags = [wholes(np.asarray(f, dtype=np.int64), "flags", (n, m)) for f in (mirrored, backwards)]
    count, there = doubles(cycles, "cycles", (n, m)), doubles(wanted, "wanted", (n, 4, 4))
    names = ("low", "high", "loose")
    bounds = [doubles(part, name, (n, width)) for part, name in zip((low, high, loose), names, strict=True)]
    room = np.empty(16 * (2 * m + 1) + 48 * m + 7 * width)
    shapes = (n,), (n,), (n,), (n, 4, 4), (n, 6), (n, 6, width), (n, width)
    found = Settled(begun, *(np.empty(shape) for shape in shapes))
    tables = np.array([address(part) for k in kinds for part in (k.numbers, k.series)], dtype=np.int64)
    arrays = kind, count, *flags, there, *bounds, room, *found
    KERNEL.purcell_settle(
        *(n, m, rounds, address(tables), len(rolls.roll), address(rolls.roll), address(rolls.travel)),
        *(float(rolls.largest), MEASURES.index(measure), *(address(part) for part in arrays)),
    )
    return found
