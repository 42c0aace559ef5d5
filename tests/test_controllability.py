"""Ranks of brackets: the theorem, the plane, symmetry, weak directions, and what the command says of them."""

from __future__ import annotations

import json
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from helpers import UNIT, assert_close, bent, is_close, random_shapes

from purcell_cli import Swimmer, controllability, flow
from purcell_cli.cli.app import _run
from purcell_cli.errors import ParameterError
from purcell_cli.geometry.rotations import about_axis
from purcell_cli.lie_brackets.bracket_gaits import TRUST, gait_twist, prediction
from purcell_cli.lie_brackets.controllability import DIRECTIONS, makers
from purcell_cli.lie_brackets.ranks import rank_of, simplest
from purcell_cli.lie_brackets.weak_shapes import bent_alike, strength, weakest
from purcell_cli.mechanics.connection import COLLINEAR, connection
from purcell_cli.mechanics.primitives import PrimitiveSequence

U_SHAPE = bent_alike(np.pi / 2, 0.0)


def dimensions(levels: tuple) -> list[int]:
    return [level.rank.dimension for level in levels]


def test_theorem_1_holds_at_the_collinear_shape() -> None:
    """Weakly controllable at the second level already, and strongly at the third depth; spin drag helps but weakly."""
    found = controllability(UNIT)
    assert found.growth == (6, 10, 12)
    assert found.verdict == "controllable"
    assert (dimensions(found.levels), found.weak_level) == ([5, 6], 2)
    assert [level.rank.robustness for level in found.depths] == ["weak", "clear"]
    assert found.depths[0].rank.clear_dimension == 2
    assert_close(found.levels[1].added, [[1, 0, 0, 0, 0, 0]], 1e-12)


def test_the_planar_swimmer_is_strongly_controllable() -> None:
    found = controllability(UNIT, planar=True)
    assert (found.dimension, found.growth, found.verdict) == (5, (2, 3, 5), "controllable")
    assert all(level.rank.robustness == "clear" for level in (*found.depths, *found.levels))


def test_the_plane_is_part_of_space() -> None:
    """The planar brackets are the same in space, and a limb out of the plane is refused."""
    shape = bent(0.0, 0.4) @ bent(0.0, 0.9, 2)
    planar, spatial = controllability(UNIT, shape, 3, planar=True), controllability(UNIT, shape, 3)
    twists = {b.word: b.twist for b in spatial.brackets}
    assert len(planar.brackets) == 3
    for bracket in planar.brackets:
        assert_close(bracket.twist, twists[bracket.word], 1e-12)
        assert_close(bracket.twist[2:5], np.zeros(3), 1e-15)
    with pytest.raises(ParameterError, match="planar shape"):
        controllability(UNIT, bent(0.1, 0.4), planar=True)


@pytest.mark.parametrize("seed", range(3))
def test_rolling_the_whole_shape_changes_no_singular_value(seed: int) -> None:
    """The base's drag is the same all round; a limb spun about itself alone is another frame of the same shape."""
    shape = random_shapes(np.random.default_rng(seed), 1)[0]
    turn, spun = about_axis(0, 0.7), shape @ np.stack([about_axis(0, 1.1), about_axis(0, -0.4)])
    found, rolled, other = (controllability(UNIT, s, 3) for s in (shape, turn @ shape, spun))
    bent_on = controllability(UNIT, about_axis(2, 0.7) @ shape, 3)
    for level in range(2):
        values = found.depths[level].rank.singular_values
        assert_close(rolled.depths[level].rank.singular_values, values, 1e-11, values[0])
        assert not is_close(bent_on.depths[level].rank.singular_values, values, 1e-3)
    assert_close(other.depths[0].rank.singular_values, found.depths[0].rank.singular_values, 1e-11)


def test_the_null_direction_leaves_the_base_still() -> None:
    shape = random_shapes(np.random.default_rng(7), 1)[0]
    for at, count in ((COLLINEAR, 1), (shape, 1), (U_SHAPE, 3)):
        found = controllability(UNIT, at, 2)
        assert (found.direct.dimension, len(found.null)) == (6 - count, count)
        assert_close(connection(UNIT, at) @ found.null.T, np.zeros((6, count)), 1e-13)
    assert_close(controllability(UNIT, depth=2).null, [[1, 0, 0, -1, 0, 0]], 1e-12)
    still = PrimitiveSequence.of([("limb1 roll", 0.3), ("limb2 roll", -0.3)])
    assert_close(flow(UNIT, still)[:3, 3], np.zeros(3), 1e-14)


def test_a_weak_rank_is_said() -> None:
    """At the U shape all of Q is there at depth 2, but half of it by spin drag alone."""
    two, three = controllability(UNIT, U_SHAPE, 3).depths
    assert (two.rank.dimension, two.rank.clear_dimension, two.rank.robustness) == (6, 3, "weak")
    assert (three.rank.clear_dimension, three.rank.robustness) == (6, "clear")
    fat = controllability(Swimmer(1.0, 1.0, slenderness=0.02), U_SHAPE, 2).depths[0].rank
    assert 2.0 < fat.smallest / two.rank.smallest < 6.0  # spin drag goes with the square of the radius


def test_a_rank_that_rounding_could_make_is_undecided() -> None:
    """A very thin swimmer's spin drag gives 1e-10 beside a roll of 1e8; sixty digits say the rank is 4."""
    two, three = controllability(Swimmer(1.0, 1.0, slenderness=1e-5), depth=3).depths
    assert (two.rank.dimension, two.rank.robustness) == (4, "undecided")
    assert (three.rank.dimension, three.rank.robustness) == (6, "clear")


def test_ranks_of_plain_vectors() -> None:
    vectors = np.diag([3.0, 1e-4, 1e-17, 0.0, 0.0, 0.0])
    rank = rank_of(vectors)
    assert (rank.dimension, rank.clear_dimension, rank.robustness) == (2, 1, "weak")
    assert_close(rank.gap, 1e-4 / rank.floor, 1e-9, rank.gap)
    assert rank_of(np.empty((0, 6))).dimension == 0
    turned = np.linalg.qr(np.array([[1.0, 1.0], [0.0, 2.0], [1.0, 1.0]]))[0]
    assert_close(simplest(turned), [[1.0, 0.0, 1.0], [0.0, 1.0, 0.0]], 1e-12)


@pytest.mark.parametrize("count", [3, 20_000])
def test_many_vectors_take_no_more_memory_than_they_have(count: int) -> None:
    tracemalloc.start()
    rank = rank_of(np.random.default_rng(0).normal(size=(count, 6)))
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert rank.dimension == min(count, 6)
    assert most < 1e6 + 60.0 * 8 * count


def test_surge_is_yaw_against_yaw() -> None:
    """Each direction has a bracket, and where spin drag alone makes the shortest, one of use."""
    found = controllability(UNIT)
    words = {DIRECTIONS[k]: [b.word for b in makers(found, k)] for k in range(6)}
    assert words["surge"] == [(2, 5)]
    assert words["roll"] == [(1, 2)]
    assert words["yaw"][0] == (0, 1)
    assert len(words["yaw"]) == len(words["pitch"]) == 2
    assert all(words.values())


@pytest.mark.parametrize("shape", [COLLINEAR, U_SHAPE], ids=["collinear", "U"])
def test_a_prediction_is_trusted_as_far_as_the_exact_lift_agrees(shape: np.ndarray) -> None:
    found = controllability(UNIT, shape, 3)
    for direction in range(6):
        bracket = makers(found, direction)[-1]
        told = prediction(UNIT, shape, bracket, direction)
        assert 0.0 < told.trusted_rad < 1.0
        sizes = told.trusted_rad * np.array([0.25, 1.0, 2.0**0.25])
        exact = gait_twist(UNIT, bracket.word, sizes, shape)[:, direction]
        off = np.abs(exact / (told.rate * sizes**told.depth) - 1.0)
        assert off[0] < off[1] <= TRUST < off[2]


def test_the_map_finds_the_weak_u() -> None:
    found = {bend: strength(UNIT, np.radians(bend), 0.0, 3) for bend in (75, 90, 120)}
    least = {bend: weakest(s.weak) for bend, s in found.items()}
    assert least[90][0] < 1e-3 < 0.1 < min(least[75][0], least[120][0])
    assert least[90][1] == "sway"
    assert weakest(strength(UNIT, 0.0, 0.8, 3).strong)[1] == "pitch"  # yaw is as weak: the first of equals
    assert [s.direct.dimension for s in found.values()] == [5, 3, 5]
    assert_close(bent_alike(0.5, 0.0)[:, :, 0], [[np.cos(0.5), np.sin(0.5), 0], [np.cos(0.5), -np.sin(0.5), 0]], 1e-15)
    assert_close(bent_alike(0.5, np.pi)[1], about_axis(2, 0.5), 1e-15)


def played(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    code = _run(["controllability", *arguments])
    shown = capsys.readouterr()
    return code, shown.out, shown.err


def test_the_command_says_it_as_json(capsys: pytest.CaptureFixture[str]) -> None:
    code, out, _ = played(capsys, "--json")
    told = json.loads(out)
    assert (code, told["schema"], told["verdict"]) == (0, "purcell/controllability/1", "controllable")
    assert (told["growth_vector"], told["weak_level"], told["chow"]) == ([6, 10, 12], 2, True)
    assert told["null_directions"] == [{"roll 1": 1.0, "roll 2": -1.0}]
    surge = told["directions"][0]["brackets"][0]
    assert surge["bracket"] == "[yaw 1, yaw 2]"
    assert_close(surge["rate"], -10.0 / 81.0, 1e-14)
    code, out, _ = played(capsys, "--json", "--depth", "2")
    assert (code, json.loads(out)["verdict"]) == (0, "weakly controllable")


def test_the_command_takes_a_shape_and_a_swimmer(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    shape, swimmer = tmp_path / "shape.yaml", tmp_path / "swimmer.yaml"
    shape.write_text("limb1: {euler_deg: [90, 0, 0]}\nlimb2: {euler_deg: [-90, 0, 0]}\n")
    swimmer.write_text("slenderness: 0.02\n")
    code, out, _ = played(capsys, "--shape", str(shape), "--swimmer", str(swimmer))
    assert code == 0
    assert "Chow's condition holds at depth 2, by directions as weak as" in out
    assert "A(r) has rank 3" in out
    code, out, _ = played(capsys, "--shape", str(shape), "--planar", "--depth", "2")
    assert code == 1
    assert "Chow's condition is not seen up to depth 2: 2 directions are missing" in out
    assert out.endswith("not shown\n")


@pytest.mark.parametrize("width", [80, 132])
def test_directions_of_bent_shapes_do_not_push_columns_out(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path, width: int
) -> None:
    """Each has parts of all six there, and had left no room for the singular values, nor for the headings."""
    (tmp_path / "bent.yaml").write_text("limb2: {euler_deg: [60, 40, 0]}\n")
    monkeypatch.setenv("COLUMNS", str(width))
    code, out, _ = played(capsys, "--shape", str(tmp_path / "bent.yaml"), "--depth", "2")
    assert code == 0
    assert "limb 2 at (60, 40, 0)" in out
    spaces = out[out.index("Spaces of appendix A") : out.index("Which bracket")]
    assert "\N{HORIZONTAL ELLIPSIS}" not in out
    assert " ".join(spaces.split()).count("values") == 1
    assert max(map(len, out.splitlines())) <= width


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--depth", "1"], "from 2 to 6 is wanted, found 1"),
        (["--depth", "7"], "from 2 to 6 is wanted, found 7"),
        (["--plot", "weak.svg"], "--plot: wanted with --map"),
        (["--map", "--planar"], "--map: wanted without"),
        (["--map", "--plot", "weak.txt"], "weak.txt: wanted a picture's ending"),
        (["--shape", "missing.yaml"], "missing.yaml"),
    ],
)
def test_misuse_is_told(capsys: pytest.CaptureFixture[str], arguments: list[str], message: str) -> None:
    code, out, err = played(capsys, *arguments)
    assert (code, out) == (2, "")
    assert message in err


@pytest.mark.slow
def test_the_map_is_shown_and_drawn(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    pictures = [tmp_path / name for name in ("a.svg", "b.svg")]
    for picture in pictures:
        code, out, _ = played(capsys, "--map", "--depth", "2", "--json", "--plot", str(picture))
        told = json.loads(out)
        assert (code, told["schema"], told["picture"]) == (0, "purcell/controllability-map/1", str(picture))
        assert len(told["shapes"]) == 55
    assert pictures[0].read_bytes() == pictures[1].read_bytes()
    assert b"<svg" in pictures[0].read_bytes()


@pytest.mark.slow
def test_the_map_needs_no_matplotlib(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    for module in [m for m in sys.modules if m.startswith(("matplotlib", "purcell_cli.pictures"))]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    code, out, _ = played(capsys, "--map", "--depth", "2")
    assert code == 0
    assert "weakest: " in out
    code, _, err = played(capsys, "--map", "--plot", "weak.svg")
    assert code == 2
    assert "pictures need matplotlib" in err
