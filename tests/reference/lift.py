"""The numpy reference of the kernel's displacements and work, in extended precision."""

from __future__ import annotations

import numpy as np

from purcell_cli.geometry.reproducible import matmul
from purcell_cli.geometry.rotations import Array
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.verification.extended import products
from reference.base_velocity import TwistModel, twist_model
from reference.collocation import (
    Accuracy,
    _base_rates,
    _collocation,
    _mesh,
    _node_states,
    _solve,
)

_BATCH = 4096
"""Steps evaluated at once: bounds the memory of a long path."""


def _normalised(poses: Array) -> Array:
    """Return poses whose rotation a Newton step has mended, in their precision."""
    out, r = poses.copy(), poses[:, :3, :3]
    out[:, :3, :3] = r @ (1.5 * np.eye(3) - 0.5 * np.swapaxes(r, 1, 2) @ r)
    return out


def displacements(model: TwistModel, shapes: Array, rate: Array, duration: Array, accuracy: Accuracy) -> Array:
    """Return the base's displacement on each piece, in units of L. Shape (n, 4, 4).

    The exact ones are put together in extended precision.
    """
    precision = np.longdouble if accuracy == Accuracy() else np.float64
    out = np.zeros((len(duration), 4, 4), dtype=precision)
    for low in range(0, len(duration), _BATCH):
        part = slice(low, low + _BATCH)
        mesh = _mesh(model, shapes[part, :, :, 0], _base_rates(shapes[part], rate[part]), duration[part], accuracy.step)
        poses = np.zeros((len(mesh.piece), 4, 4), dtype=precision)
        for first in range(0, len(poses), _BATCH):
            some = slice(first, first + _BATCH)
            poses[some] = _solve(model, mesh[some], accuracy, gradient=False).step_pose
        out[part] = _normalised(products(poses, np.bincount(mesh.piece, minlength=len(duration[part]))))
    return out


def summed_power(swimmer: Swimmer, shapes: Array, rate: Array, duration: Array, root: bool = False) -> Array:
    """Return the integral of the scaled swimmer's dissipated power, or of its root, over each piece. Shape (n,)."""
    model = twist_model(swimmer)
    mesh = _mesh(model, shapes[:, :, :, 0], _base_rates(shapes, rate), duration, Accuracy().step)
    nodes, weights, _ = _collocation(Accuracy().stages)
    power = model.joint_power(*_node_states(mesh, nodes)).reshape(len(nodes), -1)
    summed = matmul(weights, np.sqrt(np.maximum(power, 0.0)) if root else np.maximum(power, 0.0)) * mesh.duration
    return np.asarray(np.bincount(mesh.piece, weights=summed, minlength=len(duration)), dtype=np.float64)
