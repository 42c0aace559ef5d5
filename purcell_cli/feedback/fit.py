"""Drag from measured motion: factors on links' drag with which a swimmer moves as was measured, and how sure they are.

The base's displacement along the measured limb motion is fitted, window by window (`windows`), by least squares with
damping (Levenberg and Marquardt). Positions and angles count by what is left of each, estimated anew in every step.
Drags are near the guess at first: each factor's logarithm has a prior deviation of `PRIOR`, far wider than what the
data tell of a factor that they do tell. A direction among the factors that they do not tell is found by the singular
values of what they know; the factor that has most part in it stays at the guess, and the others are fitted again.

Standard errors are the larger of two: as if every row were off by itself, and by how far whole windows are off
together (clustered, Liang and Zeger 1986), which a model that is itself wrong makes larger. Conventions: `rotations`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np

from purcell_cli.errors import ParameterError, refuse_types
from purcell_cli.feedback.drag_factors import Factor, What, factors_of, with_factors
from purcell_cli.feedback.windows import LARGEST_TURN_RAD, Misfit, Window, misfit, turns_between, windows_of
from purcell_cli.frozen_dataclass import frozen_dataclass
from purcell_cli.geometry.linear_systems import inverse, singular_values, solve
from purcell_cli.geometry.reproducible import exp_of, inner, matmul, norm
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.measured_trajectory import MeasuredTrajectory

PRIOR = 1.0
"""Deviation of a factor's logarithm before anything is measured: factors of e and of 1/e are likely."""
UNTOLD = 0.4
"""A factor whose logarithm's standard error is more, a factor of 1.5, is not told by the data."""
_PARTNER = 0.3
"""A factor is named with another that is not told if it has at least this part, of 1, in the untold direction."""
_EXACT = 1e-10
"""The least deviation of a row that is believed [L, rad]: files and flows have such rounding."""
_MOST_STEPS = 60
"""Steps of the fit at most; ten are usual."""
_PATIENCE = 8
"""After so many steps a direction that the data do not tell is not followed any longer."""
_SETTLED, _NEAR = 0.05, 0.2
"""The fit ends with a step of so small a part of the standard errors; of a part like the second where no step helps."""
_DAMPING = 1e-3, 1e-9, 1e9
"""Damping at first, at least and at most; it falls by ten with a step that helps, and grows with one that does not."""
_LARGEST_LOG = 20.0
"""The largest logarithm of a factor that is tried."""
_LONGEST_JUMP = 1.0, 2.0
"""From row to row the base moves by less than so many L, and so many L per radian of joint travel: else it was torn."""
_STILL_RAD = 1e-3
"""Limbs that turn by less in all do not move [rad]."""


@frozen_dataclass
class Fitted:
    """A factor and what is known of it.

    Attributes:
        factor: On which drag.
        value: By how much it is multiplied.
        standard_error: Of the value; that of the guess is not known (None).
        told: Whether the data tell it; else it is 1, as in the guess.
        only_with: The names of factors that the data tell only together with this one, where it is not told.
    """

    factor: Factor
    value: float
    standard_error: float | None
    told: bool
    only_with: tuple[str, ...] = ()


@frozen_dataclass
class Left:
    """What is left of the displacements in windows: root mean squares over their rows.

    Attributes:
        position_l: Of a component of the position, in units of L.
        angle_rad: Of a component of the rotation vector [rad].
    """

    position_l: float
    angle_rad: float


@frozen_dataclass(eq=False)
class Fit:
    """A swimmer that moves as was measured.

    Attributes:
        guess: The swimmer that was begun with.
        swimmer: The swimmer that was fitted.
        factors: The factors between the two.
        rows: Rows that were used.
        windows: Windows that they were parted into.
        before: What the guess leaves of the displacements.
        after: What the fitted swimmer leaves of them.
        settled: Whether the fit ended; else what it asks for is no drag that a link can have.
    """

    guess: Swimmer
    swimmer: Swimmer
    factors: tuple[Fitted, ...]
    rows: int
    windows: int
    before: Left
    after: Left
    settled: bool

    def __repr__(self) -> str:
        told = sum(f.told for f in self.factors)
        return (
            f"<Fit: {told} of {len(self.factors)} factors told, {self.rows} rows, {self.after.position_l:.2g} L left>"
        )


@frozen_dataclass(eq=False)
class _Knowledge:
    """What windows say of the factors near some values.

    Attributes:
        information: Of the factors' logarithms, window by window. Shape (w, k, k).
        pull: Where they would go. Shape (w, k).
        cost: The sum of squares.
        spread: What is left of positions [L] and angles [rad]. Shape (2,).
    """

    information: Array
    pull: Array
    cost: float
    spread: Array

    @property
    def together(self) -> Array:
        """The information's own scatter, by windows that are off together; 0 of too few windows. Shape (k, k)."""
        k, count = self.pull.shape[1], len(self.pull)
        share = count / (count - k) if count >= k + 2 else 0.0
        return matmul(self.pull.T, self.pull) * share

    def errors(self, least: float = 0.0) -> Array:
        """Return the standard errors of the logarithms, with some information besides. Shape (k,)."""
        alone = inverse(np.sum(self.information, axis=0) + least * np.eye(self.pull.shape[1]))
        clustered = matmul(matmul(alone, self.together), alone)
        return np.asarray(np.sqrt(np.maximum(np.diagonal(alone), np.diagonal(clustered))))


def fit(
    measured: MeasuredTrajectory | Sequence[MeasuredTrajectory],
    guess: Swimmer | None = None,
    what: What | str = What.KINDS,
    told: Callable[[int, Left], None] = lambda _step, _left: None,
) -> Fit:
    """Return the swimmer that moves as was measured: the guess with factors on its links' drag.

    Args:
        measured: Measured trajectories.
        guess: What is known of the swimmer, its lengths and joints are kept; the paper's where none is given.
        what: Which factors: the drag "ratio" of all links, of the "kinds" base and limbs, or of all "links".
        told: Is told of the number of each step, and what is left after it.

    Raises:
        ParameterError: A guess whose links feel each other's flow, or trajectories that are too short or do not move.
    """
    every = [measured] if isinstance(measured, MeasuredTrajectory) else list(measured)
    guess = guess or Swimmer()
    refuse_types(guess=(guess, Swimmer), **{f"measured[{k}]": (one, MeasuredTrajectory) for k, one in enumerate(every)})
    if guess.fluid != "local":
        raise ParameterError(
            "fluid: local, links alone in the fluid, is wanted of a guess, found links that feel others"
        )
    factors = factors_of(_known(what))
    windows = [w for one in every for w in windows_of(one, guess.length_m)]
    for one in every:
        _refuse_torn(one, guess.length_m)
    _refuse_too_little(every, windows, len(factors))
    problem = _Problem(windows, guess, factors, told)
    before = problem.knows(np.zeros(len(factors)), np.ones(2)).spread
    held: dict[int, tuple[str, ...]] = {}
    logs = np.zeros(len(factors))
    while True:
        free = [k for k in range(len(factors)) if k not in held]
        logs, known, settled = problem.solved(logs, free)
        untold = _untold(known, free)
        if untold is None:
            break
        worst, partners = untold
        held[worst] = tuple(factors[k].name for k in partners)
        logs[worst] = 0.0
    error = np.full(len(factors), np.nan)
    if free:
        error[free] = known.errors()
    values = [exp_of(log) for log in logs.tolist()]
    found = tuple(
        Fitted(factor, value, None if k in held else value * float(error[k]), k not in held, held.get(k, ()))
        for k, (factor, value) in enumerate(zip(factors, values, strict=True))
    )
    left = problem.knows(logs, known.spread).spread
    rows = sum(len(w.rows) for w in windows)
    fitted = with_factors(guess, factors, logs.tolist())
    return Fit(guess, fitted, found, rows, len(windows), Left(*before.tolist()), Left(*left.tolist()), settled)


def _known(what: What | str) -> What:
    try:
        return What(what)
    except ValueError:
        raise ParameterError(f"what: one of {', '.join(What)} is wanted, found {what!r}") from None


def _refuse_torn(one: MeasuredTrajectory, length_m: float) -> None:
    """Refuse a base that jumps, as no limb could move it."""
    rows = np.flatnonzero(one.seen)
    travel = np.concatenate([[0.0], np.cumsum(np.sum(norm(turns_between(one.shape)), axis=-1))])[rows]
    gone = norm(np.diff(one.pose[rows, :3, 3], axis=0)) / length_m
    least, per_radian = _LONGEST_JUMP
    far = np.flatnonzero(gone > least + per_radian * np.diff(travel))
    if len(far):
        k = int(far[0])
        row, most = int(rows[k + 1]), least + per_radian * float(travel[k + 1] - travel[k])
        raise ParameterError(
            f"{one.source}: row {row + 1} (t_s {float(one.time_s[row]):g}): a base that moves by at most {most:.3g} L "
            f"from the row before is wanted, found {float(gone[k]):.3g} L"
        )


def _refuse_too_little(every: Sequence[MeasuredTrajectory], windows: Sequence[Window], unknowns: int) -> None:
    """Refuse measured motions that tell nothing."""
    for one in every:
        turned = float(np.sum(norm(turns_between(one.shape))))
        if turned < _STILL_RAD:
            raise ParameterError(f"{one.source}: limbs that turn are wanted, found {turned:.2g} rad of joint travel")
    equations, wanted = sum(6 * (len(w.rows) - 1) for w in windows), 2 * unknowns
    if equations < wanted:
        rows = sum(int(np.sum(one.seen)) for one in every)
        used, source = sum(len(w.rows) for w in windows), every[0].source if every else "measured"
        raise ParameterError(
            f"{source}: {wanted // 6 + 2} or more rows that show the base and follow the limbs (no turn above "
            f"{LARGEST_TURN_RAD:g} rad between two) are wanted, found {used} among {rows}"
        )


@frozen_dataclass(eq=False)
class _Problem:
    """Windows, and the factors that are sought.

    Attributes:
        windows: The windows.
        guess: The swimmer that the factors are for.
        factors: The factors.
        told: Is told of each step.
    """

    windows: Sequence[Window]
    guess: Swimmer
    factors: Sequence[Factor]
    told: Callable[[int, Left], None]

    def knows(self, logs: Array, spread: Array, free: Sequence[int] = ()) -> _Knowledge:
        """Return what the windows say of some factors near some values, rows being off by a spread. Shape (2,)."""
        weights = np.repeat(1.0 / np.maximum(spread, _EXACT), 3)
        mine, rest = (
            [self.factors[k] for k in free],
            np.array([k for k in range(len(logs)) if k not in free], dtype=int),
        )
        base = (
            with_factors(self.guess, [self.factors[k] for k in rest], logs[rest].tolist()) if len(rest) else self.guess
        )
        information, pull, squares, rows = [], [], np.zeros(2), 0
        for window in self.windows:
            found: Misfit = misfit(window, base, mine, logs[list(free)], bool(free)).without_beginning(weights)
            off, change = found.off * weights, (found.change * weights[:, None]).reshape(6 * len(found.off), len(mine))
            information.append(matmul(change.T, change))
            pull.append(matmul(change.T, off.reshape(-1)))
            squares += [float(np.sum(found.off[:, part] * found.off[:, part])) for part in (slice(3), slice(3, 6))]
            rows += len(off)
        freedom = max(3.0 * (rows - len(self.windows)) - 0.5 * len(mine), 1.0)
        cost = float(np.sum(squares * (weights[::3] * weights[::3])))
        return _Knowledge(np.array(information), np.array(pull), cost, np.sqrt(squares / freedom))

    def solved(self, begun: Array, free: Sequence[int]) -> tuple[Array, _Knowledge, bool]:
        """Return the factors' logarithms with some of them free, what is known of those, and whether it settled."""
        logs, index = begun.copy(), list(free)
        spread = self.knows(logs, np.ones(2)).spread
        known, damping, least = self.knows(logs, spread, index), _DAMPING[0], 1.0 / (PRIOR * PRIOR)
        for step in range(_MOST_STEPS if index else 0):
            self.told(step, Left(*spread.tolist()))
            information = np.sum(known.information, axis=0) + least * np.eye(len(index))
            pull = np.sum(known.pull, axis=0) - least * logs[index]
            part = np.max(np.abs(solve(information, pull)) / (known.errors(least) + _EXACT))
            if part < _SETTLED or (step >= _PATIENCE and _untold(known, index) is not None):
                return logs, known, True
            trial, cost = logs.copy(), known.cost + least * float(inner(logs, logs))
            while damping <= _DAMPING[2]:
                trial[index] = logs[index] + solve(information + damping * np.diag(np.diagonal(information)), pull)
                found = self._possible(trial, spread)
                if found is not None and found.cost + least * float(inner(trial, trial)) <= cost:
                    break
                damping *= 10.0
            else:
                return logs, known, bool(part < _NEAR)
            logs, spread, damping = trial, found.spread, max(damping / 10.0, _DAMPING[1])
            known = self.knows(logs, spread, index)
        return logs, known, not index

    def _possible(self, logs: Array, spread: Array) -> _Knowledge | None:
        """Return what windows say of some values; None where no link can have such a drag."""
        if np.max(np.abs(logs)) > _LARGEST_LOG:
            return None
        try:
            return self.knows(logs, spread)
        except ParameterError:
            return None


def _untold(known: _Knowledge, free: Sequence[int]) -> tuple[int, list[int]] | None:
    """Return the factor that has most part in the direction that the data tell least, and what has a part beside it.

    None where the data tell all directions.
    """
    if not free:
        return None
    information = np.sum(known.information, axis=0)
    _, size, directions = singular_values(information)
    worst, most = -1, UNTOLD
    for k, direction in enumerate(directions):
        strength = max(float(size[k]), 1e-300)
        spread = math.sqrt(
            max(1.0 / strength, float(inner(direction, matmul(known.together, direction))) / strength / strength)
        )
        if spread > most:
            worst, most = k, spread
    if worst < 0:
        return None
    parts = np.abs(directions[worst])
    chosen = int(np.argmax(parts))
    return free[chosen], [free[k] for k in np.flatnonzero(parts >= _PARTNER).tolist() if k != chosen]
