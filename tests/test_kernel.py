"""The compiled kernel: it agrees with numpy, refuses what it cannot take, and is the same whoever compiles it."""

from __future__ import annotations

import functools
import importlib.util
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from convex_programs import random_program
from helpers import NIGHTLY, random_sequence, random_shapes, random_swimmer
from reference import base_velocity, lift, lift_derivatives
from reference.program import penalised
from scipy.optimize import linprog

from purcell_cli.kernel import chains, distances, library, linear, moves, poses, shooting, sources
from purcell_cli.kernel.beads import looked_up
from purcell_cli.kernel.certificate import _halves, extrapolated, pieces_of, reach
from purcell_cli.kernel.clearance import circles, largest_bends, nearest
from purcell_cli.kernel.descent import Descent
from purcell_cli.kernel.elementary import arctan2, exp_coefficients, sin_cos
from purcell_cli.kernel.flow import Flow, Rule, connection, played, with_twice_the_digits
from purcell_cli.kernel.pairs import pair_prices
from purcell_cli.kernel.screw_chains import solved
from purcell_cli.kernel.sequence import cheapest
from purcell_cli.kernel.shapes import shapes_along
from purcell_cli.kernel.steering import steered
from purcell_cli.kernel.triangles import from_triangles
from purcell_cli.mechanics.base_velocity import kernel_numbers, with_tables
from purcell_cli.mechanics.bead_table import Grid, made_tables
from purcell_cli.mechanics.beads import resistance_entries
from purcell_cli.mechanics.collocation import Accuracy, flow_of
from purcell_cli.mechanics.lift import EXACT, SEARCHING
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.pieces import Pieces
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer

SWIMMER = Swimmer().scaled()
FOLDER = library.HERE
MODULES = (
    "beads",
    "certificate",
    "chains",
    "clearance",
    "convex",
    "descent",
    "elementary",
    "flow",
    "linear",
    "moves",
    "pairs",
    "poses",
    "screw_chains",
    "sequence",
    "shapes",
    "shooting",
    "steering",
)
"""The modules of the kernel that call it."""


def use(monkeypatch: pytest.MonkeyPatch, kernel: object) -> None:
    """Have another kernel called."""
    for module in (*(f"purcell_cli.kernel.{name}" for name in MODULES), "reference.program"):
        monkeypatch.setattr(f"{module}.KERNEL", kernel)


def agree(found: np.ndarray, wanted: np.ndarray, tolerance: float = 1e-13) -> None:
    """Assert that arrays agree, relatively to the largest number where that is above 1."""
    assert found.shape == wanted.shape
    assert np.max(np.abs(found - wanted), initial=0.0) <= tolerance * max(1.0, np.max(np.abs(wanted), initial=0.0))


# --- Against numpy ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(10))
def test_a_thousand_connections_are_those_of_numpy(seed: int) -> None:
    rng = np.random.default_rng(seed)
    swimmer, n = random_swimmer(rng), 100
    shapes = random_shapes(rng, n)
    axes, rates = shapes[..., 0], rng.normal(size=(n, 2, 3))
    model = base_velocity.twist_model(swimmer)
    rows = axes.transpose(2, 1, 0), rates.transpose(2, 1, 0)
    xi, change = model.twist_and_change(*rows)
    found = connection(kernel_numbers(swimmer), axes, rates)
    size = np.max(np.abs(change))
    agree(found.twist, xi.T)
    agree(found.change / size, change.transpose(3, 1, 2, 0) / size)
    agree(found.per_rate, model.per_rate(rows[0]).transpose(3, 1, 2, 0))
    agree(found.power / 10.0, model.joint_power(*rows) / 10.0)


@pytest.mark.parametrize("seed", range(20))
def test_a_thousand_displacements_and_their_work_are_those_of_numpy(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    swimmer, n = random_swimmer(rng), 50
    pieces = Pieces(random_shapes(rng, n), rng.uniform(-1.0, 1.0, (n, 6)), rng.uniform(0.0, 1.0, n))
    parts = pieces.shapes, pieces.rates, pieces.durations
    model = base_velocity.twist_model(swimmer)
    for accuracy in (EXACT, SEARCHING):
        wanted = lift.displacements(model, *parts, accuracy).astype(np.float64)
        agree(flow_of(swimmer, accuracy).pieces(*parts), wanted, 1e-13 if accuracy == EXACT else 1e-9)
    for root in (False, True):
        agree(flow_of(swimmer, EXACT).work(*parts, root), lift.summed_power(swimmer, *parts, root))


@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("repeats", [(), ((2, 5, 4),), ((0, 3, 2), (3, 4, 1), (6, 9, 7))])
def test_derivatives_are_those_of_numpy(seed: int, repeats: tuple[tuple[int, int, int], ...]) -> None:
    """Of primitives and of moves, with parts that repeat; 600 derivatives of displacements in all."""
    rng = np.random.default_rng(200 + seed)
    swimmer, start = random_swimmer(rng), random_shapes(rng)
    primitives, moves = random_sequence(rng, 10), MoveSequence.of_turns(rng.uniform(-0.6, 0.6, (10, 6)))
    parts = [lift_derivatives.Repeat(*part) for part in repeats]
    flow, unit = flow_of(swimmer, EXACT), swimmer.length_m
    for found, wanted in (
        (
            flow.with_derivatives(primitives.shapes(start), primitives.control, primitives.angle, repeats),
            lift_derivatives.flow_and_jacobian(swimmer, primitives, start, repeats=parts),
        ),
        (
            flow.with_derivatives(moves.shapes(start), None, moves.turn, repeats),
            lift_derivatives.flow_and_jacobian_of_moves(swimmer, moves, start, repeats=parts),
        ),
    ):
        wanted[0][:3, 3] /= unit
        wanted[1][:3] /= unit
        agree(found[0], wanted[0])
        agree(found[1], wanted[1], 3e-13)


def test_runs_are_products_of_their_pieces() -> None:
    """Against numpy's extended precision: a thousand cycles of a stroke lose nothing."""
    rng = np.random.default_rng(5)
    sequence = random_sequence(rng, 12)
    pieces = Pieces.of(sequence)
    parts = pieces.shapes, pieces.rates, pieces.durations
    found = flow_of(SWIMMER, EXACT).runs(*parts, [5, 0, 7], [1000, 3, 1])
    moves = lift.displacements(base_velocity.twist_model(SWIMMER), *parts, Accuracy())
    once = np.eye(4, dtype=np.longdouble)
    for move in moves[:5]:
        once = once @ move
    assert np.max(np.abs(found[0] - np.linalg.matrix_power(once.astype(np.float64), 1000))) < 1e-9
    assert np.array_equal(found[1], np.eye(4))
    here = with_twice_the_digits(np.eye(4))
    poses = played(here, flow_of(SWIMMER, EXACT).pieces(*parts)[:5], 1000)
    assert poses.shape == (1000, 5, 4, 4)
    agree(here[..., 0], found[0][:3], 1e-10)
    assert np.array_equal(poses[0, 0], np.eye(4))


@pytest.mark.parametrize("seed", range(40))
def test_penalised_programs_are_those_of_highs(seed: int) -> None:
    """The same least sum to rounding; a small step away from the solution, the foil, is worse."""
    rng = np.random.default_rng(seed)
    n, m, k = int(rng.integers(1, 80)), int(rng.integers(0, 19)), int(rng.integers(0, 30))
    cost, matrix, wanted, _, price, low, high, _ = given = program(rng, n, m, k)
    found, total = penalised(*given)
    # x = p - q, and what is missed as further unknowns.
    missed = np.concatenate([-np.eye(m + k), np.eye(m + k)[:, :m]], axis=1)
    columns = np.concatenate([matrix, -matrix, missed], axis=1)
    within = np.concatenate([np.eye(n), -np.eye(n), np.zeros((n, 2 * m + k))], axis=1)
    solved = linprog(
        np.concatenate([cost, cost, np.full(2 * m + k, price)]),
        A_eq=columns[:m] if m else None,
        b_eq=wanted[:m] if m else None,
        A_ub=np.concatenate([columns[m:], within, -within]),
        b_ub=np.concatenate([wanted[m:], high, -low]),
    )
    assert abs(total - solved.fun) <= 1e-9 * max(1.0, abs(solved.fun))
    assert np.all((low <= found) & (found <= high))

    def paid(x: np.ndarray) -> float:
        off = matrix @ x - wanted
        return cost @ np.abs(x) + price * (np.sum(np.abs(off[:m])) + np.sum(np.maximum(off[m:], 0.0)))

    assert abs(paid(found) - total) <= 1e-9 * max(1.0, total)
    for _ in range(20):
        assert paid(np.clip(found + 1e-3 * rng.normal(size=n), low, high)) > total - 1e-9


def test_segments_are_nearest_where_a_search_finds_them() -> None:
    rng = np.random.default_rng(8)
    gap, first, second = rng.normal(size=(3, 100, 3))
    first[0], second[1] = 0.0, 0.0
    second[2] = -2.0 * first[2]
    found = linear.nearest_on_segments(gap, first, second)
    places = np.stack(np.meshgrid(*[np.linspace(0.0, 1.0, 41)] * 2, indexing="ij"), axis=-1).reshape(-1, 1, 2)
    between = gap + places[..., :1] * first - places[..., 1:] * second
    searched = np.linalg.norm(between, axis=-1).min(axis=0)
    at = gap + found[:, :1] * first - found[:, 1:2] * second
    assert np.allclose(np.linalg.norm(at, axis=-1), found[:, 2], atol=1e-14)
    assert np.all(found[:, 2] <= searched + 1e-14)
    assert np.all(searched < found[:, 2] + 0.1)
    assert np.all((found[:, :2] >= 0.0) & (found[:, :2] <= 1.0))


def test_distances_are_what_a_search_finds() -> None:
    """Of segments from balls and a box, exact; inside cones no more than the truth, and hardly less."""
    rng = np.random.default_rng(9)
    first, last, size = *rng.normal(size=(2, 200, 3)), np.array([0.9, 0.5, 0.2])
    first[0] = last[0]
    points = first + np.linspace(0.0, 1.0, 401)[:, None, None] * (last - first)
    middles, radii = rng.normal(size=(5, 3)), rng.uniform(0.1, 0.9, 5)
    searched = (np.linalg.norm(points[:, :, None] - middles, axis=-1) - radii).min(axis=0)
    found, which = distances.from_balls(first, last, middles, radii)
    assert np.all(np.abs(found - searched.min(axis=1)) < 0.01)
    assert np.array_equal(which, searched.argmin(axis=1))
    turn = poses.rotation(np.array([[0.3, -0.5, 0.7]]))[0]
    out = np.abs((points - middles[0]) @ turn) - size
    searched = (np.linalg.norm(np.maximum(out, 0.0), axis=-1) + np.minimum(out.max(axis=-1), 0.0)).min(axis=0)
    found = distances.from_boxes(first, last, middles[:1], turn[None], size[None])[0]
    assert np.all((searched > found - 1e-7) & (searched < found + 0.02))
    assert np.min(found) < -0.1, "some are inside"
    turns, sizes = poses.rotation(rng.normal(size=(5, 3))), rng.uniform(0.1, 0.9, (5, 3))
    every = [distances.from_boxes(first, last, *(x[k : k + 1] for x in (middles, turns, sizes)))[0] for k in range(5)]
    found, which = distances.from_boxes(first, last, middles, turns, sizes)
    assert np.array_equal(found, np.min(every, axis=0))
    assert np.array_equal(which, np.argmin(every, axis=0))
    begin, way, radius, change = CONES
    part = np.linspace(0.0, 1.0, 401)[:, None, None]
    balls = begin + part * way
    deep = [
        (radius + part[..., 0] * change - np.linalg.norm(at[:, None, None] - balls, axis=-1)).max(axis=1).max(axis=1)
        for at in points[::40]
    ]
    found, which = distances.inside_cones(first, last, 10, *CONES)
    assert np.all(found < np.min(deep, axis=0) + 0.01)
    assert np.all(distances.inside_cones(first, first, 1, *CONES)[0] - deep[0] > -0.01)
    assert set(which.tolist()) <= {0, 1, 2}


# --- The same bits whoever compiles it ----------------------------------------------------------------------------


def compilers() -> dict[str, list[str]]:
    """Return the commands of the compilers that this machine has."""
    found = {name: [name] for name in ("gcc", "clang") if shutil.which(name)}
    if importlib.util.find_spec("ziglang"):
        found["zig"] = [sys.executable, "-m", "ziglang", "cc", "-mcpu=baseline", "-fno-sanitize=undefined"]
    return found


def built(folder: Path, command: list[str], *flags: str) -> Path:
    """Build the kernel with a compiler and flags."""
    out = folder / "kernel.so"
    texts = [str(path) for path in sources.sources(FOLDER) if path.suffix == ".c"]
    always = ["-std=c11", "-ffp-contract=off", "-fPIC", "-shared", "-Wno-psabi", '-DPURCELL_DIGEST="trial"']
    done = subprocess.run([*command, *always, *flags, *texts, "-o", str(out), "-lm"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return out


def program(rng: np.random.Generator, columns: int, equal: int, less: int) -> tuple[object, ...]:
    """Return a random linear program, as `penalised` takes it, that begins near its equations."""
    matrix = rng.normal(size=(equal + less, columns)) * 10.0 ** rng.uniform(-1.0, 1.0, (equal + less, 1))
    begun = np.where(rng.random(columns) < 0.7, 0.0, rng.normal(size=columns))
    off = np.concatenate([1e-2 * rng.normal(size=equal), rng.uniform(-0.02, 0.3, less)])
    reach, price = rng.uniform(0.01, 0.5, columns), 10.0 ** rng.uniform(0.0, 3.0)
    cost = rng.uniform(0.0, 2.0, columns)
    return cost, matrix, matrix @ begun + off, equal, price, begun - reach, begun + reach, begun


def bounded(rng: np.random.Generator, *shape: int) -> list[np.ndarray]:
    """Return where steps begin, how loosely they keep to it, and their bounds."""
    begun = rng.normal(size=shape)
    return [begun, rng.uniform(0.1, 1.0, shape), begun - rng.uniform(0.1, 2.0, shape), np.full(shape, np.inf)]


def searched(flow: Flow, sequence: PrimitiveSequence, shapes: np.ndarray) -> list[np.ndarray]:
    """Return what searches for the angles of primitives find, some steps long."""
    where = np.arange(10), np.ones(10), 10, [], shapes[0], poses.exp(np.full((1, 6), 0.05))[0], [10], shapes[1:2]
    search = Descent(
        flow, sequence.control, np.zeros(10), *where, np.zeros((10, 2)), np.zeros(10, int), 0.5, watched=False
    )
    angle, *rest, off = search.approached(sequence.angle, 1e-9, 0.1, 2, 9)
    short, *missed = search.shortened(angle, np.ones(10), 10.0, 3, (0.1, 0.5, 1e-4), 0.1, np.inf)
    return [angle, *rest, np.array([off, *missed]), short]


def chained(rng: np.random.Generator) -> chains.Settled:
    """Return what chains of random loops settle on."""
    numbers = [np.array([0.2, 1.0, 0.0, 0.8, 1.0, across, 1.3, 3.0, 4.0, 12.0]) for across in (0.0, 1.0)]
    kinds = [chains.LoopTable(part, 0.1 * rng.normal(size=(3, 12, 12))) for part in numbers]
    rolls = chains.RollTable(np.linspace(0.0, 1.5, 4), np.array([0.0, 2.0, 5.0, 9.0]), 1.4)
    which, flags = rng.integers(-1, 2, (3, 2)), rng.integers(0, 2, (2, 3, 2))
    unknown, ones = rng.uniform(0.3, 0.7, (3, 7)), np.ones((3, 7))
    there = poses.exp(rng.normal(size=(3, 6)))
    return chains.settled(kinds, rolls, "travel", which, ones[:, :2], *flags, unknown, there, 0.1 * ones, ones, ones, 4)


def on_beads(primitives: PrimitiveSequence, shapes: np.ndarray, turns: np.ndarray) -> list[np.ndarray]:
    """Return flows, their derivatives and work among links that feel each other, by a coarse table."""
    swimmer = Swimmer(slenderness=0.2, fluid="beads")
    flow = Flow(with_tables(swimmer, coarse_tables(swimmer)), flow_of(SWIMMER, EXACT).rule)
    pieces = shapes, np.linspace(-1.0, 1.0, 180).reshape(30, 6), np.linspace(0.0, 1.0, 30)
    return [
        resistance_entries(swimmer, shapes[0, ..., 0]),
        looked_up(flow.swimmer, shapes[..., 0]),
        flow.pieces(*pieces),
        flow.work(*pieces),
        *flow.with_derivatives(primitives.shapes(shapes[0]), primitives.control, primitives.angle),
        *flow.with_derivatives(shapes_along(shapes[0], None, turns), None, turns),
    ]


@functools.cache
def coarse_tables(swimmer: Swimmer) -> np.ndarray:
    """Return tables of few samples."""
    return made_tables(swimmer, grids=[Grid(0.5, 4, 4), Grid(many_bends=5, many_angles=5)])


def two_leaves(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a tree of two leaves, as many triangles in each."""
    leaves = triangles.reshape(2, -1, 3, 3)
    boxes = [np.stack([some.min(axis=(0, 1)), some.max(axis=(0, 1))]) for some in (triangles, *leaves)]
    return np.array(boxes), leaves


def everything(seed: int) -> bytes:
    """Return what all functions of the kernel in use find for random input."""
    rng = np.random.default_rng(seed)
    numbers, shapes = rng.normal(size=1000) * 10.0 ** rng.uniform(-8.0, 5.0, 1000), random_shapes(rng, 30)
    pieces = shapes, rng.uniform(-1.0, 1.0, (30, 6)), rng.uniform(0.0, 1.0, 30)
    turns, primitives = rng.uniform(-0.6, 0.6, (10, 6)), random_sequence(rng, 10)
    flow = Flow(kernel_numbers(random_swimmer(rng)), flow_of(SWIMMER, EXACT).rule)
    found = [
        *sin_cos(numbers),
        arctan2(numbers, numbers[::-1]),
        exp_coefficients(np.abs(numbers)),
        poses.quaternion(shapes),
        poses.log(poses.exp(pieces[1])),
        poses.inverse(poses.exp(pieces[1])),
        poses.adjoint(poses.exp(pieces[1])),
        poses.rotation(pieces[1][:, :3]),
        poses.orthonormalised(shapes + 1e-9),
        linear.products(pieces[1], pieces[1].T),
        linear.products(shapes[:, 0], shapes[:, 1]),
        linear.inner(pieces[1], pieces[1][::-1]),
        linear.cross(pieces[1][:, :3], pieces[1][:, 3:]),
        linear.nearest_on_segments(pieces[1][:, :3], shapes[:, 0, 0], shapes[:, 1, 0]),
        *distances.from_balls(pieces[1][:, :3], pieces[1][:, 3:], shapes[:, 0, 0], pieces[2]),
        *distances.from_boxes(
            *(pieces[1][:, :3], pieces[1][:, 3:], shapes[:, 0, 0]),
            *(shapes[:, 1], np.abs(shapes[:, 0, 1])),
        ),
        *distances.inside_cones(pieces[1][:, :3], pieces[1][:, 3:], 8, *CONES),
        from_triangles(pieces[1][:, :3], pieces[1][:, 3:], np.full(30, 1.0), *two_leaves(shapes[:, 0])),
        linear.least_steps(rng.normal(size=(5, 6, 9)), rng.normal(size=(5, 6)), *bounded(rng, 5, 9)),
        linear.solve(shapes[:, 0] + 0.1, pieces[1].reshape(30, 3, 2)),
        *linear.orthogonal_rows(pieces[1], 1e-9),
        *linear.orthogonal_by_rotations(pieces[1].T),
        *circles(*pieces[:2]),
        *largest_bends(circles(*pieces[:2]), pieces[2]),
        *nearest(circles(*pieces[:2]), pieces[2], LINKS, True, 9.0, 1e-9, 99),
        *connection(flow.swimmer, shapes[..., 0], pieces[1].reshape(-1, 2, 3)),
        flow.pieces(*pieces),
        flow.runs(*pieces, [10, 20], [3, 1000]),
        flow.work(*pieces),
        flow.work(*pieces, root=True),
        *flow.with_derivatives(primitives.shapes(shapes[0]), primitives.control, primitives.angle, [(2, 5, 7)]),
        *flow.with_derivatives(shapes_along(shapes[0], None, turns), None, turns, [(2, 5, 7)]),
        *flow.equations(shapes[0], primitives.control, primitives.angle, [(2, 5, 7)], np.eye(4), [10], shapes[1:2]),
        *extrapolated_both(shapes, pieces),
        *pieces_of(
            np.ones((3, 7)),
            np.array([0.4, 1.2, 0.01, 0.4, 0.25]),
            shapes[..., 0],
            pieces[1].reshape(-1, 2, 3),
            np.linalg.norm(pieces[1], axis=1) * pieces[2],
            pieces[2],
        ),
        reach(poses.exp(pieces[1]), rng.integers(30, size=50), 0.3),
        *shooting.bend_rows(
            primitives.control, primitives.angle, primitives.shapes(shapes[0]), np.ones((10, 2)), np.zeros(10, int), 9.0
        ),
        shooting.bounded_step(rng.normal(size=(8, 30)), np.ones(8), rng.normal(size=4), rng.normal(size=(4, 30)), 0.1),
        *searched(flow, primitives, shapes),
        *chained(rng),
        *steered(0.05, 0.02, [0.0, 0.7, 1.5], [1.0, 1.1, 0.9], poses.exp(pieces[1]), rng.normal(size=(30, 10))),
        played(with_twice_the_digits(np.eye(4)), flow.pieces(*pieces), 5),
        *(np.array(cheapest(pose, np.ones(6, int), np.ones((6, 3)))) for pose in poses.exp(pieces[1])),
        pair_prices(poses.exp(pieces[1]), poses.exp(pieces[1]), pieces[2], pieces[2], np.linspace(0.1, 0.8, 8)),
        *solved(
            rng.integers(30, size=(20, 7)), rng.normal(size=(20, 7)), pieces[1], pieces[2] + 0.1, np.eye(4), range(6)
        ),
        *penalised(*program(rng, 40, 6, 10)),
        random_program(seed).solved(),
        random_program(seed, curved=True).solved(),
        *on_beads(primitives, shapes, turns),
    ]
    return b"".join(np.ascontiguousarray(part).tobytes() for part in found)


def extrapolated_both(shapes: np.ndarray, pieces: tuple[np.ndarray, ...]) -> list[np.ndarray]:
    """Return what pieces displace, in doubles and with twice the digits, some of them with limbs at rest."""
    axes, rates = shapes[:13, :, 0].transpose(1, 2, 0).copy(), 0.1 * pieces[1][:13].reshape(2, 3, -1)
    rates[0, :, 2:9], rates[1, :, 7:] = 0.0, 0.0
    axes[:, :, 5:8] = np.array([1.0, 0.0, -0.0])[:, None]
    given = pieces[2][:13], [0.0, 0.25, 0.5, 0.75], [2, 4], [0, 2, 0, 1, 2, 3]
    more = [np.asarray(part, dtype=np.longdouble) for part in (axes, rates, *given[:2])]
    exact = extrapolated(np.ones((3, 7)), *more, *given[2:])
    return [*extrapolated(np.ones((3, 7)), axes, rates, *given), *(_halves(part) for part in exact)]


@pytest.mark.slow
@pytest.mark.parametrize(
    "flags", [["-O0", "-DPURCELL_NARROW"], pytest.param(["-O3"], marks=NIGHTLY), ["-O3", "-march=native"]], ids=" ".join
)
@pytest.mark.parametrize("compiler", ["gcc", "clang", "zig"])
def test_every_compiler_makes_the_same_bits(
    compiler: str, flags: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    if compiler not in compilers():
        pytest.skip(f"no {compiler} here")
    wanted = [everything(seed) for seed in range(10)]
    other = library.load(built(tmp_path, compilers()[compiler], *flags))
    use(monkeypatch, other)
    assert [everything(seed) for seed in range(10)] == wanted


@pytest.mark.slow
def test_fused_sums_would_make_other_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The foil of the test above."""
    if "gcc" not in compilers() or "fma" not in Path("/proc/cpuinfo").read_text(encoding="ascii").split():
        pytest.skip("no compiler or no processor that fuses sums here")
    wanted = everything(0)
    fused = library.load(built(tmp_path, ["gcc"], "-O2", "-mfma", "-ffp-contract=fast"))
    use(monkeypatch, fused)
    assert everything(0) != wanted


@pytest.mark.slow
@pytest.mark.nightly
def test_an_arm64_processor_makes_the_same_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The library as a wheel for it has it, in an emulator; with fused sums, which it has always, the foil, others."""
    emulated = pytest.importorskip("emulated_kernel", reason="no unicorn here")
    if "zig" not in compilers():
        pytest.skip("no zig here")
    wanted = [everything(seed) for seed in range(5)]
    compiler = [*compilers()["zig"], "-target", "aarch64-linux-gnu.2.17", "-fno-math-errno", "-fno-trapping-math"]

    def found(*flags: str, seeds: range) -> list[bytes]:
        there = emulated.EmulatedKernel(built(tmp_path, compiler, *flags))
        use(monkeypatch, there)
        return [everything(seed) for seed in seeds]

    assert found("-O3", seeds=range(5)) == wanted
    assert found("-O1", "-ffp-contract=fast", seeds=range(1)) != wanted[:1]


# --- Loading --------------------------------------------------------------------------------------------------------


def test_a_library_that_is_missing_broken_or_old_is_told_in_a_sentence(tmp_path: Path) -> None:
    for path in (tmp_path / "kernel.so", tmp_path):
        with pytest.raises(ImportError, match="is missing; install the package again: python -m pip install"):
            library.load(path)
    (tmp_path / "kernel.so").write_bytes(b"no library")
    with pytest.raises(ImportError, match="cannot be loaded"):
        library.load(tmp_path / "kernel.so")
    shutil.copy(library.FILE, tmp_path)
    assert library.load(tmp_path / library.FILE.name).purcell_digest()
    (tmp_path / "other.c").write_text("", encoding="ascii")
    with pytest.raises(ImportError, match="other sources"):
        library.load(tmp_path / library.FILE.name)


def test_the_library_is_built_from_the_sources_beside_it() -> None:
    texts = sources.sources(FOLDER)
    assert not texts or library.KERNEL.purcell_digest().decode() == sources.digest(texts)
    assert sources.file_name("win_amd64") == sources.file_name("win32") == "purcell_kernel.dll"
    assert sources.file_name("macosx_11_0_arm64") == sources.file_name("darwin") == "purcell_kernel.dylib"
    assert sources.file_name("manylinux_2_17_x86_64") == sources.file_name("linux") == "purcell_kernel.so"


@pytest.mark.slow
def test_importing_it_takes_a_fifth_of_what_numpy_takes_at_most() -> None:
    """That is 20 ms where numpy takes 100, beside what of the standard library every module of the package imports."""
    program = (
        "import dataclasses, pathlib, time, typing; first = time.process_time(); import numpy.typing;"
        "then = time.process_time(); import purcell_cli.kernel.flow;"
        "print((time.process_time() - then) / (then - first))"
    )
    runs = [subprocess.run([sys.executable, "-c", program], capture_output=True, text=True) for _ in range(5)]
    assert min(float(run.stdout) for run in runs) < 0.2


# --- Its boundary ---------------------------------------------------------------------------------------------------

FLOW = flow_of(SWIMMER, SEARCHING)
GOOD = {
    "start": np.tile(np.eye(3), (2, 1, 1)),
    "shapes": np.tile(np.eye(3), (3, 2, 1, 1)),
    "rates": np.full((3, 6), 0.3),
    "durations": np.full(3, 0.2),
    "counts": np.array([1, 2]),
    "cycles": np.array([2, 1]),
    "controls": np.array([2, 5]),
    "angles": np.array([0.2, -0.3]),
    "turns": np.full((2, 6), 0.1),
    "axes": np.tile(np.eye(3)[0], (4, 2, 1)),
    "speeds": np.full((4, 2, 3), 0.5),
    "moves": np.tile(np.eye(4), (3, 1, 1)),
    "matrices": np.array([[[3.0, 1.0], [0.5, -2.0]], [[1.0, 0.2], [0.4, 1.0]]]),
    "sides": np.array([[[1.0], [0.5]], [[0.3], [0.2]]]),
    "columns": np.random.default_rng(1).normal(size=(3, 6, 8)),
    "wanted": np.full((3, 6), 0.1),
    "begun": np.full((3, 8), 0.05),
    "loose": np.ones((3, 8)),
    "low": np.full((3, 8), -1.0),
    "high": np.ones((3, 8)),
    "rows": np.arange(6.0).reshape(2, 3) ** 2,
    "pose": np.eye(4),
    "ends": np.tile(np.eye(3), (1, 2, 1, 1)),
    "arrival": np.random.default_rng(2).normal(size=(7, 9)),
    "missing": np.full(7, 0.1),
    "points": np.random.default_rng(3).normal(size=(4, 3)),
    "centres": np.random.default_rng(4).normal(size=(7, 3)),
    "orientations": np.tile(np.eye(3), (7, 1, 1)),
    "halves": np.linspace(0.1, 0.4, 21).reshape(7, 3),
    "stroke": np.arange(1.0, 19.0).reshape(6, 3),
    "limits": np.full(4, 9.0),
}
GOOD["boxes"], GOOD["leaves"] = two_leaves(np.random.default_rng(5).normal(size=(6, 3, 3)))
CONES = np.eye(3), np.eye(3)[::-1] - 0.5, np.array([0.3, 0.2, 0.1]), np.array([0.0, 0.1, 2.0])
LINKS = 1.0, 2.0, 2.0, 0.1


def _moved(found: moves.MoveEquations) -> tuple[object, ...]:
    return *found, *moves.bends(found, np.ones((2, 2)), 9.0)


CALLS = {
    FLOW.pieces: ("shapes", "rates", "durations"),
    FLOW.work: ("shapes", "rates", "durations"),
    FLOW.runs: ("shapes", "rates", "durations", "counts", "cycles"),
    FLOW.with_derivatives: ("shapes", "controls", "angles"),
    (lambda shapes, turns: FLOW.with_derivatives(shapes, None, turns)): ("shapes", "turns"),
    (lambda start, controls, angles, pose, ends: FLOW.equations(start, controls, angles, [], pose, [2], ends)): (
        *("start", "controls", "angles", "pose", "ends"),
    ),
    (lambda start, turns, pose, ends: _moved(moves.equations(FLOW, start, turns, [], pose, [2], ends))): (
        *("start", "turns", "pose", "ends"),
    ),
    (lambda controls, angles, turned: shooting.bend_rows(controls, angles, turned, np.ones((2, 2)), [0, 0], 9.0)): (
        *("controls", "angles", "shapes"),
    ),
    (lambda arrival, missing: shooting.bounded_step(arrival, missing, [], np.empty((0, 9)), 1.0)): (
        *("arrival", "missing"),
    ),
    shapes_along: ("start", "controls", "angles"),
    (lambda start, turns: shapes_along(start, None, turns)): ("start", "turns"),
    (lambda axes, speeds: connection(FLOW.swimmer, axes, speeds)): ("axes", "speeds"),
    (lambda moves: played(with_twice_the_digits(np.eye(4)), moves, 2)): ("moves",),
    linear.products: ("matrices", "sides"),
    linear.solve: ("matrices", "sides"),
    (lambda rows: linear.orthogonal_rows(rows, 1e-9)): ("rows",),
    linear.orthogonal_by_rotations: ("rows",),
    linear.inner: ("rates", "rates"),
    linear.cross: ("speeds", "speeds"),
    linear.nearest_on_segments: ("speeds", "speeds", "speeds"),
    distances.from_balls: ("points", "points", "centres", "missing"),
    distances.from_boxes: ("points", "points", "centres", "orientations", "halves"),
    (lambda first, last: distances.inside_cones(first, last, 8, *CONES)): ("points", "points"),
    from_triangles: ("points", "points", "limits", "boxes", "leaves"),
    circles: ("shapes", "rates"),
    (lambda shapes, rates, durations: largest_bends(circles(shapes, rates), durations)): (
        *("shapes", "rates", "durations"),
    ),
    (lambda shapes, durations: nearest(circles(shapes, np.ones((3, 6))), durations, LINKS, False, 9.0, 1e-6, 99)): (
        *("shapes", "durations"),
    ),
    linear.least_steps: ("columns", "wanted", "begun", "loose", "low", "high"),
    (lambda pose, stroke: cheapest(pose, np.ones(6, int), stroke)): ("pose", "stroke"),
    poses.exp: ("rates",),
    poses.rotation: ("axes",),
    **dict.fromkeys((poses.log, poses.inverse, poses.adjoint, poses.orthonormalised), ("moves",)),
    poses.quaternion: ("start",),
    sin_cos: ("angles",),
    arctan2: ("angles", "angles"),
    exp_coefficients: ("angles",),
}
BROADCAST = (linear.products, linear.solve)
"""Calls that repeat what there is one of."""
WHOLE = ("counts", "cycles", "controls")


def bytes_of(found: object) -> bytes:
    parts = found if isinstance(found, tuple) else (found,)
    return b"".join(np.ascontiguousarray(part).tobytes() for part in parts)


@pytest.mark.parametrize("call", CALLS, ids=[f"{k}" for k in range(len(CALLS))])
def test_any_layout_and_kind_of_number_is_taken(call) -> None:
    """Read-only, strided, transposed, of other widths and byte orders, and lists: the same as plain arrays."""
    good = [GOOD[name] for name in CALLS[call]]
    wanted = bytes_of(call(*good))
    strided = [np.repeat(part, 2, axis=0)[::2] for part in good]
    fortran, swapped = (
        [np.asfortranarray(part) for part in good],
        [part.astype(part.dtype.newbyteorder()) for part in good],
    )
    fixed = [part.copy() for part in good]
    for part in fixed:
        part.setflags(write=False)
    for other in (strided, fortran, swapped, fixed, [part.tolist() for part in good]):
        if not isinstance(other[0], list):
            assert bytes_of(call(*other)) == wanted
    wide = [
        part.astype(np.int32 if name in WHOLE else np.float64) for part, name in zip(good, CALLS[call], strict=True)
    ]
    assert bytes_of(call(*wide)) == wanted


@pytest.mark.parametrize("call", CALLS, ids=[f"{k}" for k in range(len(CALLS))])
def test_wrong_arrays_are_errors_and_never_a_crash(call) -> None:
    names = CALLS[call]
    for k, name in enumerate(names):
        good = GOOD[name]
        bad: list[object] = [
            None,
            "text",
            np.array(["1.0"]),
            good.astype(complex),
            good.astype(object),
            object(),
            {1: 2},
        ]
        if name in WHOLE:
            bad += [good.astype(float) + 0.5, good - 9, good.astype(float) * np.nan]
            bad += [good + 1000] if name != "cycles" else []
        if len(names) > 1 and call not in (arctan2, linear.inner, linear.cross):
            bad += [good[None], good.ravel()[:1], np.empty(0), np.float64(1.0)]
            bad += [good[:-1], np.concatenate([good, good])] if "start" not in names or len(names) > 2 else []
            bad = [part for part in bad if call not in BROADCAST or np.shape(part)[-2:] != good.shape[-2:]]
        for wrong in bad:
            if wrong is None and name == "controls":
                continue
            with pytest.raises((ValueError, TypeError)):
                call(*(wrong if j == k else GOOD[other] for j, other in enumerate(names)))


@pytest.mark.parametrize("number", [np.nan, np.inf, -np.inf, 1e300, -1e300, 1e-320])
@pytest.mark.parametrize("call", CALLS, ids=[f"{k}" for k in range(len(CALLS))])
def test_numbers_that_are_none_end(call, number: float) -> None:
    """They give numbers that are none, or are refused as too long."""
    for k, name in enumerate(CALLS[call]):
        if name in WHOLE:
            continue
        wrong = GOOD[name].copy()
        wrong.flat[-1] = number
        try:
            found = call(*(wrong if j == k else GOOD[other] for j, other in enumerate(CALLS[call])))
        except ValueError as error:
            found = str(error)
        assert not isinstance(found, str) or "too long" in found


def test_nothing_is_taken_too() -> None:
    none = np.empty((0, 2, 3, 3)), np.empty((0, 6)), np.empty(0)
    assert FLOW.pieces(*none).shape == (0, 4, 4)
    assert FLOW.work(*none).shape == (0,)
    assert FLOW.runs(*none, [], []).shape == (0, 4, 4)
    pose, derivative = FLOW.with_derivatives(GOOD["shapes"][:1], [], [])
    assert np.array_equal(pose, np.eye(4))
    assert derivative.shape == (6, 0)
    assert connection(FLOW.swimmer, np.empty((0, 2, 3)), np.empty((0, 2, 3))).twist.shape == (0, 6)
    assert sin_cos([])[0].shape == arctan2([], []).shape == (0,)


@pytest.mark.parametrize(
    "repeats", [[(0, 1, 0)], [(1, 1, 2)], [(0, 3, 2)], [(-1, 1, 2)], [(0, 2, 2), (1, 2, 2)], [(0, 1)]]
)
def test_repeats_that_make_no_sense_are_refused(repeats: list[tuple[int, ...]]) -> None:
    with pytest.raises(ValueError, match=r"repeats|reshape"):
        FLOW.with_derivatives(GOOD["shapes"], GOOD["controls"], GOOD["angles"], repeats)


def test_a_rule_must_be_one() -> None:
    rule = FLOW.rule
    for nodes, weights, step in (
        (np.empty(0), rule.weights, 1.0),
        (np.zeros(17), np.zeros(17), 1.0),
        (rule.nodes, rule.weights[1:], 1.0),
        (rule.nodes, rule.weights, np.nan),
    ):
        with pytest.raises(ValueError, match="wanted"):
            Rule(nodes, weights, rule.to_node, step, 1e-9)


def test_a_program_must_be_one() -> None:
    good = program(np.random.default_rng(3), 5, 2, 3)
    assert penalised(*good) is not None
    assert penalised([], np.empty((0, 0)), [], 0, 1.0, [], [], [])[1] == 0.0
    assert penalised([1.0], np.empty((0, 1)), [], 0, 1.0, [-1.0], [1.0], [0.5])[0] == [0.0]
    for k, bad in (
        *((k, np.full_like(good[k], number)) for k in (0, 1, 2, 5, 6, 7) for number in (np.nan, np.inf)),
        *((k, good[k][:-1]) for k in (0, 1, 2, 5, 6, 7)),
        *((k, good[k].astype(complex)) for k in (0, 1, 2, 5, 6, 7)),
        *((4, price) for price in (0.0, -1.0, np.nan)),
        *((3, equal) for equal in (-1, 6)),
        (0, -good[0]),
        (5, good[6] + 1.0),
    ):
        with pytest.raises((ValueError, TypeError)):
            penalised(*(bad if j == k else part for j, part in enumerate(good)))
