"""The surfaces of obstacles, and of what is near a curve, as triangles to be drawn."""

from __future__ import annotations

import numpy as np

from purcell_cli.environment.mesh import Mesh
from purcell_cli.environment.obstacle import Obstacle, dot
from purcell_cli.environment.solids import Box, Capsule, HalfSpace, Sphere
from purcell_cli.environment.tube import Tube
from purcell_cli.geometry.rotations import Array, cross

_AROUND = 20
"""Sides of a tube or a ball as it is drawn."""
_ALONG = 10
"""Rings of a ball from pole to pole."""
_MOST_RINGS = 150
"""A curve of more points is drawn by so many of them."""
_SHARP = 0.7
"""At a corner whose cosine is below this (45 degrees) a tube ends round, and another one begins."""


def surface(obstacle: Obstacle, middle: Array, reach_m: float) -> Array:
    """Return the surface of an obstacle.

    Args:
        obstacle: The obstacle.
        middle: Where the motion is; a half space is drawn as a square beside it [m]. Shape (3,).
        reach_m: How far that square goes to all sides [m].

    Returns:
        Triangles [m]. Shape (n, 3, 3).
    """
    if isinstance(obstacle, Sphere):
        return _rod(np.array([obstacle.centre_m] * 2), obstacle.radius_m)
    if isinstance(obstacle, Capsule):
        return _rod(np.array([obstacle.from_m, obstacle.to_m]), obstacle.radius_m)
    if isinstance(obstacle, Box):
        return _box(obstacle)
    if isinstance(obstacle, HalfSpace):
        normal = np.array(obstacle.normal)
        foot = middle - dot(middle - np.array(obstacle.point_m), normal) * normal
        u, v = _aside(normal)
        at = foot + reach_m * np.array([u + v, v - u, -u - v, u - v])
        return np.stack([at[[0, 1, 2]], at[[0, 2, 3]]])
    if isinstance(obstacle, Tube):
        points = np.array(obstacle.points_m)
        return _rings(points, np.gradient(points, axis=0), np.array(obstacle.radii_m))
    assert isinstance(obstacle, Mesh)  # noqa: S101  # there are no others
    return obstacle.triangles


def tube_round(points: Array, radius_m: float) -> Array:
    """Return the surface of all that is within a radius of a polyline; where it is sharp, of two tubes.

    Args:
        points: The polyline's points, two or more, none of which repeats [m]. Shape (n, 3).
        radius_m: The radius [m].

    Returns:
        Triangles [m]. Shape (n, 3, 3).
    """
    if len(points) > _MOST_RINGS:
        points = points[np.unique(np.linspace(0, len(points) - 1, _MOST_RINGS).astype(int))]
    steps = np.diff(points, axis=0)
    units = steps / np.sqrt(dot(steps, steps))[:, None]
    corners = np.flatnonzero(dot(units[1:], units[:-1]) < _SHARP) + 1
    angle = np.linspace(1e-3, 0.5 * np.pi, _ALONG // 2 + 1)[:, None]
    out = []
    for low, high in zip([0, *corners], [*corners, len(steps)], strict=True):
        inner = units[low:high]
        along = np.concatenate([inner[:1], inner[1:] + inner[:-1], inner[-1:]])
        first, last = (
            points[low] - radius_m * np.cos(angle) * inner[0],
            points[high] + radius_m * np.cos(angle) * inner[-1],
        )
        tip = radius_m * np.sin(angle)[:, 0]
        centres = np.concatenate([first[:-1], points[low : high + 1], last[-2::-1]])
        directions = np.concatenate(
            [np.tile(inner[0], (len(tip) - 1, 1)), along, np.tile(inner[-1], (len(tip) - 1, 1))]
        )
        radii = np.concatenate([tip[:-1], np.full(high - low + 1, radius_m), tip[-2::-1]])
        out.append(_rings(centres, directions, radii))
    return np.concatenate(out)


def _aside(direction: Array) -> tuple[Array, Array]:
    """Return two unit vectors across a direction and across each other. Shapes (3,)."""
    helper = np.eye(3)[int(np.argmin(np.abs(direction)))]
    u = cross(helper, direction)
    u = u / np.sqrt(dot(u, u))
    v = cross(direction / np.sqrt(dot(direction, direction)), u)
    return u, v


def _rings(centres: Array, along: Array, radii: Array) -> Array:
    """Return the triangles between rings round a line. Shapes (n, 3), (n, 3) and (n,) to (m, 3, 3)."""
    angle = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)
    u, v = _aside(along[0])
    rings = []
    for centre, direction, radius in zip(centres, along, radii, strict=True):
        unit = direction / np.sqrt(dot(direction, direction))
        u = u - dot(u, unit) * unit  # carried along, so that the rings do not twist
        u = u / np.sqrt(dot(u, u))
        v = cross(unit, u)
        rings.append(centre + radius * (np.cos(angle)[:, None] * u + np.sin(angle)[:, None] * v))
    ring = np.array(rings)
    a, b = ring[:-1], ring[1:]
    a_next, b_next = np.roll(a, -1, axis=1), np.roll(b, -1, axis=1)
    both = [np.stack([a, a_next, b_next], axis=2), np.stack([a, b_next, b], axis=2)]
    return np.concatenate([part.reshape(-1, 3, 3) for part in both])


def _rod(ends: Array, radius: float) -> Array:
    """Return the triangles of a rod with round ends; of a ball where both ends are alike. Shape (n, 3, 3)."""
    way = ends[1] - ends[0]
    size = float(np.sqrt(dot(way, way)))
    unit = way / size if size > 0.0 else np.array([0.0, 0.0, 1.0])
    angle = np.linspace(1e-3, np.pi - 1e-3, _ALONG + 1)
    late = (angle > 0.5 * np.pi)[:, None]
    centres = np.where(late, ends[1], ends[0]) - radius * np.cos(angle)[:, None] * unit
    return _rings(centres, np.tile(unit, (len(angle), 1)), radius * np.sin(angle))


def _box(box: Box) -> Array:
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
    at = (0.5 * signs * np.array(box.size_m)) @ np.array(box.orientation).T + np.array(box.centre_m)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return np.asarray(at[np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])])
