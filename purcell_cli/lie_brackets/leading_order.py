"""What a small stroke does to leading order: Lie brackets at the collinear shape (appendix A of the paper).

The controls are vector fields f_i on base and limbs. A closed sequence of moves is the flow of one field,
its logarithm: sums of the controls, of their brackets [f_i, f_j], of [f_i, [f_j, f_k]] and so on,
weighted by iterated integrals of the controls (Chen 1957, Ann. Math. 65, 163). The base's part of
[f_i, f_j] is the curvature of the connection. Leading order in the amplitude; use `lift.flow` for
the exact value. Near the collinear shape roll is sharp: brackets that involve it hold only for
bends far below `Swimmer.roll_sharpness`. Conventions: `rotations`.
"""

from __future__ import annotations

import numpy as np

from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.rotations import Array
from purcell_cli.lie_brackets.control_fields import brackets_by_depth, frame
from purcell_cli.lie_brackets.curvature import bracket_twists, twists_and_slopes
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.moves import ControlSequence
from purcell_cli.mechanics.swimmer import Swimmer

_NOTHING = 1e-7
"""An order counts as cancelled below this part of the sum of its terms' sizes."""


def _nested(swimmer: Swimmer) -> Array:
    """Return the base's part of [f_k, [f_i, f_j]] at the collinear shape. Shape (k, i, j, 6)."""
    out = np.zeros((6, 6, 6, 6))
    _, fields = brackets_by_depth(frame(swimmer, COLLINEAR, 2))
    for (k, i, j), twist in zip(fields.words, fields.twist[0], strict=True):
        out[k, i, j], out[k, j, i] = twist, -twist
    return out


def _logarithm(turns: Array) -> tuple[Array, Array, Array]:
    """Return the logarithm of the iterated integrals of turns, to third order. Shapes (6,), (6, 6), (6, 6, 6)."""
    s1, s2, s3 = np.zeros(6), np.zeros((6, 6)), np.zeros((6, 6, 6))
    for w in turns:
        ww = np.multiply.outer(w, w) / 2.0
        s3 += np.multiply.outer(s2, w) + np.multiply.outer(s1, ww) + np.multiply.outer(ww, w) / 3.0
        s2 += np.multiply.outer(s1, w) + ww
        s1 = s1 + w
    squared = np.multiply.outer(s1, s1)
    l3 = s3 - 0.5 * (np.multiply.outer(s1, s2) + np.multiply.outer(s2, s1)) + np.multiply.outer(squared, s1) / 3.0
    return s1, s2 - 0.5 * squared, l3


@frozen_dataclass(eq=False)
class Prediction:
    """The base's twist as predicted, order by order in the turns.

    Attributes:
        orders: What the first, second and third order contribute [L, rad]. Shape (3, 6).
        sizes: The sum of the sizes of the terms of each. Shape (3, 6).
    """

    orders: Array
    sizes: Array

    def leading(self, component: int) -> tuple[float, int]:
        """Return the first contribution to a component of the twist that does not cancel, and its order; or 0, 0."""
        for k, value in enumerate(self.orders[:, component]):
            if abs(value) > _NOTHING * max(self.sizes[k, component], 1e-12):
                return float(value), k + 1
        return 0.0, 0


def predicted(swimmer: Swimmer, sequence: ControlSequence) -> Prediction:
    """Return what brackets at the collinear shape predict for a sequence that begins there.

    Args:
        swimmer: The swimmer.
        sequence: Primitives or moves.
    """
    l1, l2, l3 = _logarithm(sequence.rates() * sequence.duration[:, None])
    xi, _ = twists_and_slopes(swimmer, COLLINEAR[None])
    fields = (xi[0], bracket_twists(swimmer, COLLINEAR[None])[0] / 2.0, _nested(swimmer) / 3.0)  # Dynkin's 1/n
    terms = [(w[..., None] * f).reshape(-1, 6) for w, f in zip((l1, l2, l3), fields, strict=True)]
    return Prediction(np.array([t.sum(axis=0) for t in terms]), np.array([np.abs(t).sum(axis=0) for t in terms]))
