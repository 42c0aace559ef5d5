"""The numpy reference of the kernel's mesh and collocation."""

from __future__ import annotations

import dataclasses

import numpy as np

from purcell_cli.geometry import se3
from purcell_cli.geometry.component_first import cross_rows, dot_rows
from purcell_cli.geometry.reproducible import apply, exp_coefficients, matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.collocation import Accuracy, _collocation
from reference.base_velocity import TwistModel

_SPIN_SHARE = 0.25
"""What a spin of a limb about its own axis counts in the length of steps, as a share of a turn across that axis."""


@dataclasses.dataclass(frozen=True, slots=True)
class _Steps:
    """The mesh: steps, each within one piece; shapes last, as in `twist`.

    Attributes:
        piece: The piece each step is of, ascending. Shape (n,).
        axes: The limbs' axes where it begins. Shape (3, 2, n).
        rates: Rates of the limbs in base coordinates. Shape (3, 2, n).
        duration: How long it lasts. Shape (n,).
    """

    piece: NDArrayInt
    axes: Array
    rates: Array
    duration: Array

    def __getitem__(self, part: slice) -> _Steps:
        return _Steps(self.piece[part], self.axes[..., part], self.rates[..., part], self.duration[part])


NDArrayInt = np.ndarray[tuple[int, ...], np.dtype[np.int64]]


def _mesh(model: TwistModel, axes: Array, rates: Array, duration: Array, step: float) -> _Steps:
    """Cut pieces into steps that are short against the distance from the collinear shape.

    The distance changes at most `steepness` times as fast as the limbs turn, so a step that is
    short enough at its middle is everywhere. A limb spinning about its own axis sweeps nothing, but
    turns the base; a piece of no duration needs no step.

    Args:
        model: The swimmer.
        axes: The limbs' axes where the pieces begin. Shape (n, 2, 3).
        rates: Rates of the limbs in base coordinates. Shape (n, 2, 3).
        duration: How long the pieces last. Shape (n,).
        step: Largest step, as a fraction of the distance.
    """
    axes, rates = (np.ascontiguousarray(np.moveaxis(x, 0, -1).swapaxes(0, 1)) for x in (axes, rates))
    swept, spun = cross_rows(rates, axes), _SPIN_SHARE * dot_rows(rates, axes)
    sweep = np.sqrt((dot_rows(swept, swept) + spun * spun).sum(axis=0))
    piece = np.flatnonzero(duration)
    start, length = np.zeros(len(piece)), duration[piece]
    done: list[tuple[NDArrayInt, Array, Array]] = [(piece[:0], start[:0], length[:0])]
    while len(piece):
        turned = _rotate(rates[..., piece] * (start + 0.5 * length), axes[..., piece])
        arc = sweep[piece] * length
        near = model.distance(turned)
        nearest = np.maximum(near - 0.5 * model.steepness * arc, model.sharpness)
        ratio = arc / (step * nearest)
        parts = np.where(arc > step * near, np.minimum(np.ceil(ratio), 8), 1).astype(np.int64)
        good = parts == 1
        done.append((piece[good], start[good], length[good]))
        parts = parts[~good]
        index = np.arange(parts.sum()) - np.repeat(np.cumsum(parts) - parts, parts)
        length = np.repeat(length[~good] / parts, parts)
        start = np.repeat(start[~good], parts) + index * length
        piece = np.repeat(piece[~good], parts)
    piece, start, length = (np.concatenate(column) for column in zip(*done, strict=True))
    order = np.lexsort((start, piece))
    piece, start, length = piece[order], start[order], length[order]
    turning = rates[..., piece]
    return _Steps(piece, _rotate(turning * start, axes[..., piece]), turning, length)


def _rotate(axis_angle: Array, vector: Array) -> Array:
    """Return vectors turned by rotation vectors, both (3, ...)."""
    a, b, _ = exp_coefficients(dot_rows(axis_angle, axis_angle))
    first = cross_rows(axis_angle, vector)
    return np.asarray(vector + a * first + b * cross_rows(axis_angle, first))


@dataclasses.dataclass(frozen=True, slots=True)
class _Solution:
    """The flow on every step, from the step's start; at its nodes too where a gradient is wanted.

    Attributes:
        step_pose: Displacements. Shape (n, 4, 4).
        node_rotation: Orientations at the nodes. Shape (3, 3, m, n).
        node_position: Positions at the nodes. Shape (3, m, n).
        node_change: How turning a limb changes the twist, times the node's weight. Shape (6, 2, 3, m, n).
    """

    step_pose: Array
    node_rotation: Array
    node_position: Array
    node_change: Array


def _node_states(steps: _Steps, nodes: Array) -> tuple[Array, Array]:
    """Return the limbs' axes and rates at the nodes of all steps. Shapes (3, 2, m n)."""
    times = nodes[:, None] * steps.duration
    rates = np.broadcast_to(steps.rates[:, :, None], (3, 2, *times.shape))
    axes = _rotate(rates * times, steps.axes[:, :, None])
    return axes.reshape(3, 2, -1), rates.reshape(3, 2, -1)


def _solve(model: TwistModel, steps: _Steps, accuracy: Accuracy, gradient: bool) -> _Solution:
    """Solve g' = g hat(xi) from the identity on every step by Gauss collocation, orientations as quaternions."""
    nodes, weights, to_node = _collocation(accuracy.stages)
    n, m = len(steps.duration), len(nodes)
    axes, rates = _node_states(steps, nodes)
    change = np.empty(0)
    if gradient:
        xi, change = model.twist_and_change(axes, rates)
        change = change.reshape(6, 2, 3, m, n) * (weights[:, None] * steps.duration)
    else:
        xi = model.twist(axes, rates)
    xi = xi.reshape(6, m, n) * steps.duration
    omega = 0.5 * xi[3:]
    scalar, vector = np.ones((m, n)), matmul(to_node, omega)
    # Picard iteration: the error falls faster than any power, by |omega / 2|^k / k!.
    for _ in range(100):
        scalar = 1.0 - matmul(to_node, dot_rows(vector, omega))
        renewed = matmul(to_node, scalar * omega + cross_rows(vector, omega))
        changed = float(np.max(np.abs(renewed - vector), initial=0.0))
        vector = renewed
        if changed < accuracy.settled:
            break
    velocity = _turned(scalar, vector, xi[:3])
    end = np.stack(
        [
            1.0 + matmul(weights, -dot_rows(vector, omega)),
            *(matmul(weights, scalar * omega + cross_rows(vector, omega))),
        ]
    )
    end /= np.sqrt(np.sum(end * end, axis=0))
    step_pose = se3.pose(np.moveaxis(_matrix(end[0], end[1:]), -1, 0), (matmul(weights, velocity)).T)
    if not gradient:
        return _Solution(step_pose, change, change, change)
    return _Solution(step_pose, _matrix(scalar, vector), matmul(to_node, velocity), change)


def _turned(scalar: Array, vector: Array, v: Array) -> Array:
    """Return vectors (3, ...) turned by almost unit quaternions, given as scalar and vector parts."""
    across = 2.0 * cross_rows(vector, v)
    return np.asarray(v + scalar * across + cross_rows(vector, across))


def _matrix(scalar: Array, vector: Array) -> Array:
    """Return the matrices (3, 3, ...) of almost unit quaternions, given as scalar and vector parts."""
    columns = [_turned(scalar, vector, e.reshape(3, *(1 for _ in scalar.shape))) for e in np.eye(3)]
    return np.stack(columns, axis=1)


def _base_rates(shapes: Array, rate: Array) -> Array:
    """Return u_i = A_i omega_i. Shapes (n, 2, 3, 3) and (n, 6) to (n, 2, 3)."""
    return np.asarray(apply(shapes, rate.reshape(-1, 2, 3)))
