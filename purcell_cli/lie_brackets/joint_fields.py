"""The control fields of a swimmer by its joints, in the coordinates that there are.

A limb on a universal joint or a hinge has joint angles for coordinates, A = Rz(psi) Ry(theta): they commute, and a
rate of psi turns the limb about the base's z. A limb on a ball joint keeps the coordinates of `control_fields`.
"""

from __future__ import annotations

import numpy as np

from purcell_cli.geometry.rotations import Array
from purcell_cli.lie_brackets.bead_polynomials import wall_steps
from purcell_cli.lie_brackets.control_fields import (
    BERNOULLI,
    EXPONENTIAL,
    Fields,
    Frame,
    connection_of_limbs,
    coordinates,
    exponential,
    rounding_of,
)
from purcell_cli.lie_brackets.taylor import taylor
from purcell_cli.mechanics.joints import limb_at
from purcell_cli.mechanics.swimmer import Swimmer


def controls_of(swimmer: Swimmer) -> tuple[int, ...]:
    """Return the controls of a swimmer's joints, 0 to 5: psi of a universal joint counts as the limb's yaw."""
    return tuple(sorted(c if c < 6 else 3 * (c - 6) + 2 for c in swimmer.controls))


def joint_frame(swimmer: Swimmer, shape: Array, degree: int, beside: Array | None = None) -> Frame:
    """Return the control fields by the joints around a shape; see `control_fields.frame`.

    Args:
        swimmer: The swimmer.
        shape: The shape, which its joints can make. Shape (2, 3, 3).
        degree: The degree; brackets of depth k need k - 1.
        beside: How the scaled swimmer sees its wall. Shape (4,).
    """
    controls = controls_of(swimmer)
    ring = taylor(len(controls) + (0 if beside is None else 3), degree)
    x = coordinates(ring, controls)
    steps, limbs, rates, angular = np.zeros((len(ring), 6, 6)), [], np.zeros((len(ring), 6, 6)), []
    for limb, joint in enumerate(swimmer.joints):
        part = slice(3 * limb, 3 * limb + 3)
        own = x[:, part]
        if joint.ball:
            steps[:, part, part] = exponential(ring, own, BERNOULLI)
            rates[:, part, part] = ring.constant(np.eye(3))
            limbs.append(shape[limb] @ exponential(ring, own, EXPONENTIAL))
            continue
        angular.append(limb)
        steps[:, part, part] = ring.constant(np.eye(3))
        rates[:, part, part] = ring.constant(np.eye(3))
        if joint.kind == "fixed":
            limbs.append(ring.constant(shape[limb]))
            continue
        psi, theta = joint.read(shape[limb])
        yaw, pitch = np.zeros_like(own), np.zeros_like(own)
        yaw[:, 2], pitch[:, 1] = own[:, 2], own[:, 1]
        turned = limb_at(psi, 0.0) @ exponential(ring, yaw, EXPONENTIAL), exponential(ring, pitch, EXPONENTIAL)
        a = ring.product(turned[0], limb_at(0.0, theta) @ turned[1], np.matmul)
        limbs.append(a)
        rates[:, part, 3 * limb + 2] = a[:, 2]  # the base's z in the limb's frame
    connection = connection_of_limbs(swimmer, ring, limbs, beside)
    xi = -np.swapaxes(ring.product(connection, rates, np.matmul), 1, 2)
    words = tuple((j,) for j in controls)
    fields = Fields(words, np.eye(6)[list(controls)], xi[:, controls])
    moved = steps[np.ix_(range(len(ring)), controls, controls)]
    base = None if beside is None else wall_steps(ring, beside)
    return Frame(controls, degree, moved, fields, tuple(angular), base, rounding_of(swimmer, shape, beside))
