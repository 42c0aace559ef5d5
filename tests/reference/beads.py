"""The numpy reference of the kernel's beads: the resistance K^T M^-1 K, written from the formulas."""

from __future__ import annotations

import math

import numpy as np

from purcell_cli.geometry.rotations import Array, hat


def mobility(place: Array, radius: Array) -> Array:
    """Return the mobility of beads in a fluid of unit viscosity (Zuk et al. 2014). Shape (3 n, 3 n)."""
    n = len(radius)
    gap = place[:, None] - place[None]
    r = np.linalg.norm(gap, axis=-1) + np.eye(n)  # a bead and itself: set below
    a, b = radius[:, None], radius[None]
    same = (1.0 + (a * a + b * b) / (3.0 * r * r)) / (8.0 * math.pi * r)
    along = (1.0 - (a * a + b * b) / (r * r)) / (8.0 * math.pi * r)
    overlapping, inside = r < a + b, r <= abs(a - b)
    near, cube, apart = 6.0 * math.pi * a * b, 32.0 * r**3, (a - b) ** 2
    same = np.where(overlapping, ((16.0 * r**3 * (a + b) - (apart + 3.0 * r * r) ** 2) / cube) / near, same)
    along = np.where(overlapping, 3.0 * (apart - r * r) ** 2 / cube / near, along)
    same = np.where(inside, 1.0 / (6.0 * math.pi * np.maximum(a, b)), same)
    along = np.where(inside, 0.0, along)
    np.fill_diagonal(same, 1.0 / (6.0 * math.pi * radius))
    np.fill_diagonal(along, 0.0)
    unit = gap / r[..., None]
    out = along[..., None, None] * unit[..., :, None] * unit[..., None, :] + same[..., None, None] * np.eye(3)
    return np.asarray(out.transpose(0, 2, 1, 3).reshape(3 * n, 3 * n))


def resistance(place: Array, arm: Array, radius: Array, link: Array) -> Array:
    """Return the resistance on (v, omega, u_1, u_2) as a matrix. Shape (12, 12)."""
    k = np.zeros((len(place), 3, 12))
    k[:, :, :3], k[:, :, 3:6] = np.eye(3), -hat(place)
    for limb in (1, 2):
        k[link == limb, :, 3 + 3 * limb : 6 + 3 * limb] = -hat(arm[link == limb])
    k = k.reshape(-1, 12)
    return np.asarray(k.T @ np.linalg.solve(mobility(place, radius), k))
