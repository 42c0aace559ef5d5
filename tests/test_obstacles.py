"""Obstacles: distances from segments, the bound over whole motions, and what is refused."""

from __future__ import annotations

import functools
import itertools
import json
import re
import struct
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from helpers import assert_close, random_rotations, random_sequence, random_shapes, random_swimmer, runner
from numpy.typing import NDArray

from purcell_cli import Configuration, PlanOptions, Swimmer, load_scenario, plan
from purcell_cli.environment.mesh import Mesh, open_edges, tree
from purcell_cli.environment.obstacle import Obstacle
from purcell_cli.environment.scene import Scene
from purcell_cli.environment.solids import Box, Capsule, HalfSpace, Sphere
from purcell_cli.environment.tube import Tube
from purcell_cli.errors import InputError, ParameterError, PurcellWarning
from purcell_cli.files.plan_file import PlanDocument, is_plan, load_plan, write_plan
from purcell_cli.files.scenario_file import warn_if_far
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array
from purcell_cli.kernel.triangles import from_triangles
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.limits import Limits
from purcell_cli.motion.limits_check import check
from purcell_cli.motion.obstacle_distance import LINKS, least_link_distance, link_distances
from purcell_cli.motion.trajectory import sample

HERE = Configuration(np.eye(4), COLLINEAR)
PART = np.linspace(0.0, 1.0, 801)[:, None]
Signed = Callable[[Array], Array]


def corners(box: Box) -> Array:
    """Return the twelve triangles of a box, all seen from outside. Shape (12, 3, 3)."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], dtype=np.float64)
    at = 0.5 * signs * np.array(box.size_m) @ np.array(box.orientation).T + np.array(box.centre_m)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return at[np.array([t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))])]


def binary_stl(triangles: Array) -> bytes:
    """Return an STL file of triangles."""
    rows = b"".join(struct.pack("<12fH", *([0.0] * 3), *t.ravel().tolist(), 0) for t in triangles)
    return b"solid no text".ljust(80) + struct.pack("<I", len(triangles)) + rows


def text_stl(triangles: Array) -> bytes:
    facets = []
    for t in triangles:
        points = "\n".join(f"vertex {x!r} {y!r} {z!r}" for x, y, z in t.tolist())
        facets.append(f"facet normal 0 0 0\nouter loop\n{points}\nendloop\nendfacet")
    return ("solid part\n" + "\n".join(facets) + "\nendsolid part\n").encode()


def of_box(box: Box) -> Signed:
    def signed(x: Array) -> Array:
        off = np.abs((x - np.array(box.centre_m)) @ np.array(box.orientation)) - 0.5 * np.array(box.size_m)
        return np.asarray(np.linalg.norm(np.maximum(off, 0.0), axis=-1) + np.minimum(off.max(axis=-1), 0.0))

    return signed


def of_tube(tube: Tube) -> Signed:
    """Return how deep points are in the balls along a centreline, by very many balls."""
    points, radii = np.array(tube.points_m), np.array(tube.radii_m)
    share = np.linspace(0.0, 1.0, 60)[:, None]
    balls = np.concatenate([a + share * (b - a) for a, b in itertools.pairwise(points)])
    sizes = np.concatenate([a + share[:, 0] * (b - a) for a, b in itertools.pairwise(radii)])
    return lambda x: np.asarray(np.max(sizes - np.linalg.norm(x[..., None, :] - balls, axis=-1), axis=-1))


TURNED = random_rotations(np.random.default_rng(1))
BOX = Box((0.1, 0.2, 0.3), (1.0, 0.6, 0.4), tuple(tuple(r) for r in TURNED.tolist()))
ANGLE = np.linspace(0.0, 2.0, 7)
TUBE = Tube(tuple((3 * np.cos(a) - 2.0, 3 * np.sin(a) - 2.0, 0.1 * a) for a in ANGLE), tuple(1.0 + 0.1 * ANGLE))
CASES: list[tuple[Obstacle, Signed, float]] = [
    (Sphere((0.1, 0.2, 0.3), 0.5), lambda x: np.asarray(np.linalg.norm(x - [0.1, 0.2, 0.3], axis=-1) - 0.5), 1e-9),
    (
        Capsule((0, 0, 0), (1, 0, 0), 0.2),
        lambda x: np.asarray(np.linalg.norm(x - np.clip(x[..., :1], 0, 1) * [1.0, 0, 0], axis=-1) - 0.2),
        1e-9,
    ),
    (BOX, of_box(BOX), 1e-9),
    (HalfSpace((0, 0, -0.5), (0, 0, 2)), lambda x: np.asarray(x[..., 2] + 0.5), 1e-9),
    (TUBE, of_tube(TUBE), 0.05),
    (Mesh("", 1.0, "", corners(BOX)), lambda x: np.maximum(of_box(BOX)(x), 0.0), 1e-9),
]


@pytest.mark.parametrize(("obstacle", "signed", "most"), CASES, ids=[c[0].kind for c in CASES])
def test_the_distance_of_a_segment_is_the_least_of_its_points(obstacle: Obstacle, signed: Signed, most: float) -> None:
    """Never above the least of many points, and below by no more than they are apart, and for a tube by its cells."""
    rng = np.random.default_rng(0)
    count = 60 if isinstance(obstacle, Tube) else 400
    first = 0.7 * rng.normal(size=(count, 3))
    last = first + 0.7 * rng.normal(size=(count, 3))
    part = PART[::10] if isinstance(obstacle, Tube) else PART
    every = signed(first[:, None] + part * (last - first)[:, None])
    found, sampled = obstacle.distance(first, last), every.min(axis=1)
    if isinstance(obstacle, Mesh):
        outside = signed(first) > 0.0  # a segment wholly inside is at some distance from the surface
        found, sampled, every, first, last = (x[outside] for x in (found, sampled, every, first, last))
    apart = 0.5 * np.linalg.norm(last - first, axis=1) / (len(part) - 1)
    assert np.all(found < sampled + 1e-3)
    assert np.all(found > sampled - apart - most)
    between = np.minimum(every[:, 0], every[:, -1]) - sampled > 0.05
    if not isinstance(obstacle, HalfSpace):
        assert np.any(between), "some come nearest between their ends"
        assert not np.any(found[between] > np.minimum(every[:, 0], every[:, -1])[between] - 0.04)


def test_a_scene_knows_which_obstacle_is_nearest() -> None:
    rng = np.random.default_rng(2)
    every = [*(Sphere(tuple(rng.normal(size=3)), 0.1) for _ in range(20)), *(one for one, _, _ in CASES[1:4])]
    first = rng.normal(size=(300, 3))
    last = first + 0.2 * rng.normal(size=(300, 3))
    found, which = Scene(tuple(every)).distance(first, last)
    alone = np.array([one.distance(first, last) for one in every])
    assert_close(found, alone.min(axis=0), 1e-15)
    assert np.all(alone[which, np.arange(300)] <= found + 1e-15)
    assert len(set(which.tolist())) > 10


def test_tubes_are_one_vessel() -> None:
    """A segment across the mouth of a branch is inside of neither tube and of both together."""
    trunk, branch = (Tube(p, (0.2, 0.2)) for p in (((-1, 0, 0), (1, 0, 0)), ((0, 0, 0), (0, 1, 0))))
    first, last = np.array([[0.0, -0.1, 0.0]]), np.array([[0.0, 0.5, 0.0]])
    assert trunk.distance(first, last)[0] < 0.0
    assert Scene((trunk, branch)).distance(first, last)[0][0] > 0.05
    assert Scene((branch, trunk)).distance(first, last + np.array([0.0, 0.8, 0.0]))[0][0] < 0.0


def test_a_mesh_tells_inside_from_outside() -> None:
    points = np.random.default_rng(3).normal(size=(300, 3)) * 0.5
    mesh = Mesh("", 1.0, "", corners(BOX))
    assert np.array_equal(mesh.contains(points), of_box(BOX)(points) < 0.0)
    assert 0 < np.count_nonzero(mesh.contains(points)) < 300
    assert open_edges(corners(BOX)[:-1]) == 3
    twice = Mesh("", 1.0, "", np.concatenate([corners(BOX), corners(BOX)]))
    assert np.array_equal(twice.contains(points), mesh.contains(points))  # an even number of crossings
    hollow = Mesh("", 1.0, "", np.concatenate([3.0 * corners(BOX), corners(BOX)[:, ::-1]]))
    assert not np.any(hollow.contains(points) & mesh.contains(points))


def soups() -> dict[str, Array]:
    """Return triangles: large and tiny, far off, of one plane, a single one, and some without an area."""
    rng = np.random.default_rng(0)
    begin, way = 0.001 * rng.integers(-999, 999, (60, 1, 3)), 0.001 * rng.integers(-99, 99, (60, 1, 3))
    halves = np.array([[[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[1, 1, 0], [0, 1, 0], [1, 0, 0]]])
    return {
        "large": rng.normal(size=(300, 3, 3)),
        "tiny": rng.normal(size=(300, 1, 3)) + 0.05 * rng.normal(size=(300, 3, 3)),
        "far": rng.normal(size=(50, 3, 3)) + np.array([1e6, 0.0, -1e6]),
        "plane": (np.arange(-6, 6)[:, None, None, None] * np.array([1.0, 0.0, 0.0]) + halves).reshape(-1, 3, 3),
        "one": rng.normal(size=(1, 3, 3)),
        "points": np.repeat(rng.normal(size=(50, 1, 3)), 3, axis=1),
        "edges": rng.normal(size=(50, 3, 3))[:, [0, 1, 1]],
        "rows": begin + way * np.array([0.0, 1.0, 3.0])[:, None],  # on a line but for rounding
    }


def from_triangle(at: Array, triangles: Array) -> Array:
    """Return how far points are from triangles, one each: from the plane over the inside, else from the sides."""
    found = np.full(len(at), np.inf)
    for a, b in itertools.pairwise([0, 1, 2, 0]):
        side, off = triangles[:, b] - triangles[:, a], at - triangles[:, a]
        size = np.maximum(np.sum(side * side, axis=1), 1e-300)
        part = np.clip(np.sum(off * side, axis=1) / size, 0.0, 1.0)
        found = np.minimum(found, np.linalg.norm(off - part[:, None] * side, axis=1))
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = np.linalg.norm(normal, axis=1)
    inside = area > 1e-9
    unit = normal / np.where(inside, area, 1.0)[:, None]
    for a, b in itertools.pairwise([0, 1, 2, 0]):
        inward = np.cross(unit, triangles[:, b] - triangles[:, a])
        inside &= np.sum(inward * (at - triangles[:, a]), axis=1) >= 0.0
    return np.where(inside, np.abs(np.sum(unit * (at - triangles[:, 0]), axis=1)), found)


@pytest.mark.parametrize("name", soups())
def test_a_tree_of_triangles_finds_what_comparing_with_each_does(name: str) -> None:
    """The same bits as the least over trees of one triangle each, and what a search along the segments finds."""
    triangles = soups()[name]
    rng = np.random.default_rng(1)
    middle, n = triangles.mean(axis=(0, 1)), 60
    first = middle + 1.5 * rng.normal(size=(n, 3))
    last = first + rng.normal(size=(n, 3)) * np.repeat([0.0, 0.1, 1.0], n // 3)[:, None]
    least, infinite = np.full(n, np.inf), np.full(n, np.inf)
    for one in triangles:
        box = np.stack([one.min(axis=0), one.max(axis=0)])
        least = np.minimum(least, from_triangles(first, last, infinite, box[None], one[None, None]))
    found = from_triangles(first, last, infinite, *tree(triangles))
    assert np.array_equal(found, least)
    assert name != "large" or 0 < np.count_nonzero(found == 0.0) < n, "some cross a triangle"
    limits = rng.uniform(0.0, 2.0 * float(np.median(found)), n)
    assert np.array_equal(from_triangles(first, last, limits, *tree(triangles)), np.minimum(found, limits))
    row, k = np.divmod(np.arange(n * len(triangles)), len(triangles))
    low, high, pairs = np.zeros(len(row)), np.ones(len(row)), triangles[k]

    def away(part: Array) -> Array:
        return from_triangle(first[row] + part[:, None] * (last - first)[row], pairs)

    for _ in range(80):  # the distance is convex along a segment
        one, two = low + (high - low) / 3.0, high - (high - low) / 3.0
        left = away(one) < away(two)
        low, high = np.where(left, low, one), np.where(left, two, high)
    searched = away(0.5 * (low + high)).reshape(n, -1).min(axis=1)
    assert_close(found, searched, 1e-8)


@functools.cache
def motion(seed: int) -> tuple[Swimmer, Configuration, tuple[Block, ...]]:
    """Return a random motion: three random strokes, of which one is repeated there and back."""
    rng = np.random.default_rng(seed)
    swimmer = random_swimmer(rng)
    start = Configuration(se3.pose(random_rotations(rng), rng.normal(size=3) * 0.1), random_shapes(rng) @ np.eye(3))
    some = random_sequence(rng, 4)
    again = type(some).of([*some, *some.inverse()])
    return swimmer, start, (Block(1, "a", random_sequence(rng, 3)), Block(2, "b", again, 3), Block(3, "c", some))


@pytest.mark.slow
def test_the_distance_over_a_motion_is_bounded_and_not_sampled() -> None:
    """The bound is never above what very many instants show, and tight; a few instants show more than there is."""
    missed = 0
    for seed in range(8):
        swimmer, start, blocks = motion(seed)
        rng = np.random.default_rng(seed + 100)
        unit = 3.0 * swimmer.length_m
        balls = tuple(Sphere(tuple(rng.normal(size=3) * unit), 0.02 * unit) for _ in range(20))
        scene = Scene((*balls, HalfSpace((0, 0, -3.0 * unit), (0.1, 0, 1))))
        found = check(swimmer, start, blocks, Limits(obstacles=scene)).obstacle
        assert found is not None
        fine = sample(swimmer, start, blocks, 2e-3 / swimmer.joint_rate_rad_s)
        every, which = link_distances(swimmer, scene, fine.pose, fine.shape[..., 0])
        k, link = np.unravel_index(int(np.argmin(every)), every.shape)
        assert found.distance_m <= every.min() + 1e-7 * swimmer.length_m
        assert least_link_distance(swimmer, scene, fine.pose, fine.shape[..., 0]) == every.min()
        assert every.min() <= found.distance_m + found.error_m + 0.02 * swimmer.length_m
        shown = found.distance_m + found.error_m
        most = max(0.021 * shown, 1.1e-5 * swimmer.length_m) if shown > 0.0 else 0.021 * swimmer.length_m - 0.31 * shown
        assert found.error_m <= most
        assert (found.link, found.obstacle) == (LINKS[link], int(which[k, link]))
        switches = np.flatnonzero(np.diff(fine.rate_rad_s, axis=0, prepend=0.0).any(axis=1))
        missed += bool(every[switches].min() > found.distance_m + found.error_m + 1e-3 * swimmer.length_m)
    assert missed >= 2, "the switches alone would have told too much"


def test_few_rows_tell_the_least_distance_of_all() -> None:
    """The same number as from every row, for every kind of obstacle, from a look at few of them."""
    swimmer, start, blocks = motion(3)
    rows = sample(swimmer, start, blocks, 0.01 / swimmer.joint_rate_rad_s)
    asked: list[int] = []

    class Counted(Scene):
        def distance(self, first: Array, last: Array) -> tuple[Array, NDArray[np.int64]]:
            asked.append(len(first))
            return super().distance(first, last)

    for obstacle, _, _ in CASES:
        scene = Counted((obstacle,))
        wanted = float(np.min(link_distances(swimmer, Scene((obstacle,)), rows.pose, rows.shape[..., 0])[0]))
        assert least_link_distance(swimmer, scene, rows.pose, rows.shape[..., 0]) == wanted
        for some in (rows.pose[:1], rows.pose[:17], rows.pose[5:6]):
            n = len(some)
            wanted = float(np.min(link_distances(swimmer, scene, some, rows.shape[:n, ..., 0])[0]))
            assert least_link_distance(swimmer, scene, some, rows.shape[:n, ..., 0]) == wanted
    assert asked[0] < 3 * len(rows) / 10


def test_distances_above_what_need_be_known_are_cut_off() -> None:
    rng = np.random.default_rng(4)
    first, last = rng.normal(size=(2, 300, 3))
    for obstacle, _, _ in CASES:
        scene = Scene((obstacle,))
        wanted = scene.distance(first, last)[0]
        assert np.array_equal(scene.distance(first, last, 0.3)[0], np.minimum(wanted, 0.3))


def test_a_motion_through_a_sphere_between_two_switches_is_caught() -> None:
    """A limb sweeps over a small ball halfway through a primitive; at its ends it is far from it."""
    swimmer = Swimmer()
    blocks = (Block(2, "sweep", random_sequence(np.random.default_rng(0), 0).of([("limb1 yaw", 1.0)])),)
    rows = sample(swimmer, HERE, blocks, 0.01)
    half = len(rows) // 2
    tip = rows.pose[half, :3, 3] + rows.pose[half, :3, :3] @ (np.array([0.1, 0, 0]) + 0.15 * rows.shape[half, 0, :, 0])
    scene = Scene((Sphere(tuple(tip), 1e-3),))
    ends = link_distances(swimmer, scene, rows.pose[[0, -1]], rows.shape[[0, -1], ..., 0])[0]
    assert ends.min() > 0.02
    found = check(swimmer, HERE, blocks, Limits(obstacles=scene))
    assert [v.limit for v in found.violations] == ["obstacle"]
    assert found.obstacle is not None
    assert found.obstacle.between == "limb 1 and obstacle 1 (sphere)"
    assert_close(found.obstacle.time_s, 0.5, 0.1)
    aside = Scene((Sphere((float(tip[0]), float(tip[1]), 0.02), 1e-3),))
    assert check(swimmer, HERE, blocks, Limits(obstacles=aside)).kept
    assert not check(swimmer, HERE, blocks, Limits(clearance_m=0.018, obstacles=aside)).kept


@pytest.mark.parametrize(
    ("obstacle", "told"),
    [
        (Sphere((0.25, 0.0, 0.05), 0.06), "start: all links clear of obstacles are wanted, found limb 1 0.012 m deep"),
        (HalfSpace((0, 0, 0.01), (0, 0, 1)), "m deep in obstacle 1 (half_space)"),
        (Mesh("", 1.0, "", corners(Box((0, 0, 0), (1, 1, 1)))), "outside of obstacle 1 (mesh)"),
        (Tube(((-1, 0, 0), (1, 0, 0)), (0.001, 0.001)), "found base 0.001 m deep in obstacle 1 (tube)"),
    ],
)
def test_a_start_that_touches_is_refused(obstacle: Obstacle, told: str) -> None:
    goal = Configuration(se3.pose(np.eye(3), [0.0, 3.0, 0.0]), COLLINEAR)
    with pytest.raises(ParameterError) as error:
        plan(HERE, goal, options=PlanOptions(obstacles=Scene((obstacle,))))
    assert told in str(error.value)


@pytest.mark.parametrize(
    ("points", "refused"),
    [
        ([(0, 0, 0), (1, 0, 0), (1, 1, 0)], False),
        ([(0, 0, 0), (1, 0, 0), (1, 0.1, 0), (0, 0.1, 0)], True),
        ([(0.1 * np.cos(a), 0.1 * np.sin(a), 0) for a in np.linspace(0, 3, 200)], True),
        ([(0.3 * np.cos(a), 0.3 * np.sin(a), 0) for a in np.linspace(0, 3, 200)], False),
        ([(0.3 * np.cos(a), 0.3 * np.sin(a), 0) for a in np.linspace(0, 3, 7)], False),
        ([(0.01 * k, 1e-3 * (k % 2), 0) for k in range(200)], False),
    ],
)
def test_a_tube_that_turns_tighter_than_its_radius_is_refused(points: list[tuple[float, ...]], refused: bool) -> None:
    def made() -> Tube:
        return Tube(tuple((x, y, z) for x, y, z in points), (0.25,) * len(points))

    if not refused:
        assert len(made().cones[0]) <= len(points)
        return
    with pytest.raises(ParameterError, match="turns no tighter than the tube's radius"):
        made()


GOOD = "name: a\nstart: {}\ngoal: {base: {position_m: [0.1, 0, 0]}}\nobstacles:\n  - "


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("{sphere: {centre_m: [0, 0], radius_m: 1}}", "a.yaml:5: obstacles[0].sphere.centre_m: wanted a list of 3"),
        ("{sphere: {centre_m: [0, 0, 9], radius_m: -1}}", "obstacles[0].sphere.radius_m: wanted a finite number above"),
        ("{sphere: {centre_m: [0, 0, .nan], radius_m: 1}}", "obstacles[0].sphere.centre_m[2]: wanted a finite number"),
        ("{ball: {}}", "one of the keys sphere, capsule, box, half_space, tube, mesh"),
        ("{}", "exactly one of the keys"),
        ("{half_space: {point_m: [0, 0, -1], normal: [0, 0, 0]}}", "half_space.normal: wanted a vector other than 0"),
        ("{box: {centre_m: [0, 9, 0], size_m: [1, 0, 1]}}", "box.size_m[1]: wanted a finite number above 0"),
        ("{tube: {centreline: none.csv, radius_m: 1}}", "a.yaml:5: obstacles[0].tube.centreline: wanted the path of a"),
        ("{tube: {centreline: [[0, 0, 0]], radius_m: 1}}", "a list of 2 or more"),
        ("{tube: {centreline: [[0, 0, 0], [0, 0, 0]], radius_m: 1}}", "points that differ"),
        ("{tube: {centreline: [[0, 0, 0], [1, 0, 0]]}}", "wanted a radius, by the key radius_m or by the"),
        (
            "{tube: {centreline: nan.csv, radius_m: 1}}",
            "nan.csv:3: y_m: wanted a finite number of at most 1e+15, found 'nan'",
        ),
        (
            "{tube: {centreline: head.csv, radius_m: 1}}",
            "head.csv:1: wanted the header x_m,y_m,z_m or x_m,y_m,z_m,radius_m, found 'x,y,z'",
        ),
        ("{tube: {centreline: both.csv, radius_m: 1}}", "found both"),
        (
            "{mesh: {file: none.stl}}",
            "a.yaml:5: obstacles[0].mesh.file: wanted the path of a readable file",
        ),
        ("{mesh: {file: open.stl}}", "wanted a closed mesh, found one with 3 open edges"),
        ("{mesh: {file: empty.stl}}", "wanted a mesh of one triangle or more, found none"),
        ("{mesh: {file: a.yaml}}", "wanted an STL file, found none"),
        ("{mesh: {file: cut.stl}}", "wanted an STL file, found one that breaks off"),
        ("{mesh: {file: far.stl}}", "coordinates up to 1e+09 m"),
        ("{mesh: {file: nan.stl}}", "wanted finite coordinates up to 1e+09 m, found nan in triangle 4"),
        ("{mesh: {file: flat.stl}}", "wanted a mesh that encloses a volume, found one that encloses none"),
        ("{mesh: {file: long.stl}}", "found none: 694 bytes, and as a binary one its 12 triangles take 684"),
        ("{mesh: {file: four.stl}}", "wanted facets of 3 corners, found a facet of 4 that ends on line 9"),
        ("{mesh: {file: word.stl}}", "wanted corners of 3 numbers, found another on line 4"),
        ("{mesh: {file: two.stl}}", "wanted corners of 3 numbers, found another on line 4"),
        ("{tube: {centreline: twice.csv, radius_m: 1}}", "twice.csv:4: wanted points that differ, found two alike"),
        ("{tube: {centreline: back.csv, radius_m: 1}}", "back.csv:3: wanted turns of at most 165 degrees, found one"),
        ("{tube: {centreline: thin.csv}}", "thin.csv:3: radius_m: wanted a finite number above 0 and at most 1e+09"),
        ("{tube: {centreline: word.csv, radius_m: 1}}", "word.csv:3: x_m: wanted a finite number of at most 1e+15"),
        (
            "{tube: {centreline: [[-9, 0, 0], [0, 0, 0], [0, 0.1, 0], [9, 0.1, 0]], radius_m: 1}}",
            "a.yaml:5: obstacles[0].tube.centreline[1]: wanted turns no tighter than the tube's radius (1 m), found",
        ),
    ],
)
def test_bad_obstacles_are_told_with_their_line(tmp_path: Path, text: str, told: str) -> None:
    box = corners(Box((9.0, 0, 0), (1, 1, 1)))
    files = {
        "nan.csv": b"x_m,y_m,z_m\n0,0,0\n1,nan,0\n",
        "head.csv": b"x,y,z\n0,0,0\n1,0,0\n",
        "both.csv": b"x_m,y_m,z_m,radius_m\n0,0,0,1\n1,0,0,1\n",
        "open.stl": binary_stl(box[:-1]),
        "empty.stl": binary_stl(box[:0]),
        "cut.stl": text_stl(box)[:-40],
        "far.stl": text_stl(1e30 * box),
        "nan.stl": binary_stl(np.where(np.arange(12)[:, None, None] == 3, np.nan, box)),
        "flat.stl": text_stl(np.array([[[9, 0, 0], [10, 0, 0], [9, 1, 0]], [[9, 0, 0], [9, 1, 0], [10, 0, 0]]])),
        "long.stl": binary_stl(box) + bytes(10),
        "four.stl": text_stl(box).replace(b"endloop", b"vertex 0 0 0\nendloop", 1),
        "word.stl": re.sub(rb"vertex \S+", b"vertex one", text_stl(box), count=1),
        "two.stl": re.sub(rb"vertex \S+", b"vertex", text_stl(box), count=1),
        "twice.csv": b"x_m,y_m,z_m\n0,0,0\n1,0,0\n1,0,0\n",
        "back.csv": b"x_m,y_m,z_m\n0,0,0\n99,0,0\n0,0,0\n",
        "thin.csv": b"x_m,y_m,z_m,radius_m\n0,0,0,1\n1,0,0,0\n",
        "word.csv": b"x_m,y_m,z_m\n0,0,0\n1_0,0,0\n",
        "a.yaml": (GOOD + text).encode(),
    }
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    with pytest.raises(InputError) as error:
        load_scenario(tmp_path / "a.yaml")
    assert told in str(error.value)


def test_a_mesh_inside_out_is_told_and_taken_as_what_it_encloses(tmp_path: Path) -> None:
    (tmp_path / "in.stl").write_bytes(binary_stl(corners(Box((9.0, 0, 0), (1, 1, 1)))[:, ::-1]))
    (tmp_path / "a.yaml").write_text(GOOD + "{mesh: {file: in.stl}}", encoding="utf-8")
    with pytest.warns(PurcellWarning, match=r"a\.yaml:5: obstacles\[0\]\.mesh\.file: its triangles face inwards"):
        scene = load_scenario(tmp_path / "a.yaml").obstacles
    assert scene is not None
    assert scene.inside_meshes(np.array([[9.0, 0.1, 0.2]])) == [0]
    assert not len(scene.inside_meshes(np.array([[7.0, 0.1, 0.2]])))


def test_a_mesh_that_may_be_in_millimetres_is_remarked_on(tmp_path: Path) -> None:
    (tmp_path / "mm.stl").write_bytes(binary_stl(50.0 * corners(Box((9.0, 0, 0), (1, 1, 1)))))
    for scale, told in (("", ["obstacles[0].mesh is 500 L (50 m) wide; files in millimetres"]), (", scale: 0.5", [])):
        (tmp_path / "a.yaml").write_text(GOOD + f"{{mesh: {{file: mm.stl{scale}}}}}", encoding="utf-8")
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            warn_if_far(load_scenario(tmp_path / "a.yaml"))
        assert [str(one.message)[: len(want)] for one, want in zip(found, told, strict=True)] == told


def test_a_mesh_is_the_same_as_text_and_binary(tmp_path: Path) -> None:
    box = corners(Box((9.0, 0, 0), (1, 1, 1)))
    found = []
    for name, data in (("a.stl", binary_stl(box)), ("b.stl", text_stl(box)), ("c.stl", text_stl(box).upper())):
        (tmp_path / name).write_bytes(data)
        (tmp_path / "a.yaml").write_text(GOOD + f"{{mesh: {{file: {name}, scale: 0.1}}}}", encoding="utf-8")
        scene = load_scenario(tmp_path / "a.yaml").obstacles
        assert scene is not None
        found.append(scene.obstacles[0])
    for mesh in found:
        assert isinstance(mesh, Mesh)
        assert_close(mesh.triangles, 0.1 * box, 1e-15)


def test_a_plan_document_keeps_the_obstacles(tmp_path: Path) -> None:
    (tmp_path / "c.csv").write_text("x_m,y_m,z_m,radius_m\n-1,0,0,0.5\n1,0,0,0.6\n", encoding="utf-8")
    (tmp_path / "a.stl").write_bytes(binary_stl(corners(Box((9.0, 0, 0), (1, 1, 1)))))
    text = GOOD + "\n  - ".join(
        [
            "{sphere: {centre_m: [0, 0.4, 0], radius_m: 0.01}}",
            "{capsule: {from_m: [0, 0, 0.4], to_m: [1, 0, 0.4], radius_m: 0.01}}",
            "{box: {centre_m: [0, 0, 0.9], size_m: [1, 1, 0.1], orientation: {euler_deg: [30, 0, 0]}}}",
            "{half_space: {point_m: [0, 0, -0.4], normal: [0, 0, 1]}}",
            "{tube: {centreline: c.csv}}",
            "{mesh: {file: a.stl, scale: 1.0}}",
        ]
    )
    (tmp_path / "a.yaml").write_text(text, encoding="utf-8")
    scenario = load_scenario(tmp_path / "a.yaml")
    made = plan(scenario.start, scenario.goal, options=PlanOptions(obstacles=scenario.obstacles, effort="quick"))
    assert made.verdict == "reached"
    write_plan(PlanDocument(made.plan, made.options), tmp_path / "plan.json")
    assert load_plan(tmp_path / "plan.json").options.obstacles == scenario.obstacles
    assert load_plan(tmp_path / "plan.json").options.obstacles != Scene(scenario.obstacles.obstacles[:-1])
    assert json.loads((tmp_path / "plan.json").read_text())["obstacles"][-1]["mesh"]["file"] == "a.stl"
    assert made.options.obstacles is not None
    mesh = Path(PlanDocument(made.plan, made.options).as_text().split('"mesh": {"file": "')[1].split('"')[0])
    assert mesh.is_absolute(), "without a folder"
    (tmp_path / "below").mkdir()
    write_plan(PlanDocument(made.plan, made.options), tmp_path / "below" / "plan.json")
    tmp_path.rename(tmp_path.parent / "moved")
    moved = load_plan(tmp_path.parent / "moved" / "below" / "plan.json").options.obstacles
    (tmp_path.parent / "moved").rename(tmp_path)
    assert moved is not None
    assert moved.obstacles[:-1] == scenario.obstacles.obstacles[:-1]
    assert moved.obstacles[-1].digest == scenario.obstacles.obstacles[-1].digest


@pytest.mark.slow
def test_commands_tell_how_near_obstacles_come(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    command = runner(capsys)
    scenario, rows = str(tmp_path / "a.yaml"), str(tmp_path / "a.csv")
    (tmp_path / "a.yaml").write_text(GOOD + "{sphere: {centre_m: [0.1, 0.3, 0], radius_m: 0.1}}", encoding="utf-8")
    code, out, _ = command("plan", scenario, "--out", rows, "--json", "--effort", "quick")
    near = json.loads(out)["limits"]["obstacle"]
    assert (code, near["between"]) == (0, f"{near['link']} and obstacle 1 (sphere)")
    code, out, _ = command("verify", rows, scenario, "--json")
    found = json.loads(out)["obstacle_distance_m"]
    assert code == 0
    assert_close(found, near["distance_m"], 2.0 * near["error_m"] + 1e-6)
    (tmp_path / "a.yaml").write_text(GOOD + "{sphere: {centre_m: [0.1, 0.3, 0], radius_m: 0.25}}", encoding="utf-8")
    code, out, _ = command("verify", rows, scenario)
    assert code == 1
    assert "and obstacle 1 (sphere) are" in out
    assert "apart (they touch), less than 0 mm" in out
    (tmp_path / "a.yaml").write_text(GOOD + "{sphere: {centre_m: [0.1, 0.3, 0], radius_m: 0.31}}", encoding="utf-8")
    code, _, errors = command("plan", scenario, "--out", str(tmp_path / "b.csv"))
    assert (code, (tmp_path / "b.csv").exists()) == (2, False)
    assert "deep in obstacle 1 (sphere)" in errors


@pytest.mark.slow
def test_a_batch_sweeps_over_obstacles(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A ball that comes nearer is clear, clear and touched; its mesh is named from the folder of results."""
    (tmp_path / "a.stl").write_bytes(binary_stl(corners(Box((9.0, 0, 0), (1, 1, 1)))))
    text = (
        "name: swept\nstart: {}\ngoal: {base: {position_m: [0.001, 0, 0]}}\nobstacles:\n"
        "  - {sphere: {centre_m: [0.1, 0.3, 0], radius_m: 0.05}}\n  - {mesh: {file: a.stl, scale: 1.0}}\n"
        "sweep:\n  obstacles[0].sphere.radius_m: [0.05, 0.1, 0.31]\n"
    )
    (tmp_path / "a.yaml").write_text(text, encoding="utf-8")
    out = tmp_path / "results"
    words = ("batch", str(tmp_path / "a.yaml"), "--out", str(out), "--jobs", "1", "--effort", "quick")
    code, _, _ = runner(capsys)(*words)
    assert code == 1, "one of them touches"
    documents = sorted(out.glob("*.json"))
    plans = [load_plan(path) for path in documents if is_plan(str(path))]
    found = [one.options.obstacles.obstacles for one in plans if one.options.obstacles is not None]
    assert sorted(one[0].radius_m for one in found) == [0.05, 0.1]
    assert {json.loads(p.read_text())["obstacles"][1]["mesh"]["file"] for p in documents if is_plan(str(p))} == {
        "../a.stl"
    }
    assert "deep in obstacle 1 (sphere)" in (out / "summary.csv").read_text()
