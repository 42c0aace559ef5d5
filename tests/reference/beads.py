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
    k = motions(place, arm, link)
    return np.asarray(k.T @ np.linalg.solve(mobility(place, radius), k))


def motions(place: Array, arm: Array, link: Array) -> Array:
    """Return K, the beads' velocities by (v, omega, u_1, u_2). Shape (3 n, 12)."""
    k = np.zeros((len(place), 3, 12))
    k[:, :, :3], k[:, :, 3:6] = np.eye(3), -hat(place)
    for limb in (1, 2):
        k[link == limb, :, 3 + 3 * limb : 6 + 3 * limb] = -hat(arm[link == limb])
    return k.reshape(-1, 12)


def oseen(gap: Array) -> Array:
    """Return the flow of a point force in a fluid of unit viscosity. Shape (..., 3) to (..., 3, 3)."""
    r = np.linalg.norm(gap, axis=-1)[..., None, None]
    return np.asarray((np.eye(3) / r + gap[..., :, None] * gap[..., None, :] / r**3) / (8.0 * math.pi))


def blake(at: Array, force: Array) -> Array:
    """Return the flow of a point force above a wall at z = 0 (Blake 1971, Proc. Camb. Phil. Soc. 70, equation 3).

    Args:
        at: Where the flow is. Shape (..., 3).
        force: Where the force is. Shape (..., 3).
    """
    mirror, e = np.diag([1.0, 1.0, -1.0]), np.array([0.0, 0.0, 1.0])
    h = force[..., 2, None, None]
    away = at - force @ mirror
    r = np.linalg.norm(away, axis=-1)[..., None, None]
    outer = away[..., :, None] * away[..., None, :]
    z = away[..., 2, None, None]
    doublet = np.eye(3) / r**3 - 3.0 * outer / r**5  # of R_i / R^3 by R_k
    skew = away[..., :, None] * e - e[:, None] * away[..., None, :]
    stokeslet = (z * np.eye(3) + skew) / r**3 - 3.0 * z * outer / r**5  # of the image's third column by R_k
    return np.asarray(oseen(at - force) - oseen(away) + 2.0 * h * (h * doublet - stokeslet) @ mirror / (8.0 * math.pi))


def averaged_blake(first: Array, a: float, second: Array, b: float, nodes: int = 9) -> Array:
    """Return Blake's flow of a force spread over a sphere, averaged over another: by quadrature. Shape (3, 3)."""
    z, weight = np.polynomial.legendre.leggauss(nodes)
    turn = np.arange(2 * nodes) * (math.pi / nodes)
    aside = np.sqrt(1.0 - z * z)
    parts = [np.outer(aside, np.cos(turn)), np.outer(aside, np.sin(turn)), np.outer(z, np.ones_like(turn))]
    points = np.stack(parts, axis=-1).reshape(-1, 3)
    weights = np.repeat(weight / (4.0 * nodes), 2 * nodes)
    flows = blake((first + a * points)[:, None], (second + b * points)[None])
    return np.asarray(np.einsum("i,j,ijkl->kl", weights, weights, flows))
