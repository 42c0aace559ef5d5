"""Pictures show the numbers they stand for, with their units, and are the same bytes each time."""

from __future__ import annotations

import dataclasses
import functools
import itertools
import json
import os
import subprocess
import sys
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from helpers import assert_close, is_close
from matplotlib.image import AxesImage
from matplotlib.patches import Circle

from purcell_cli import Configuration, Swimmer, plan, realise, stored_gaits
from purcell_cli.cli import pictures as commands
from purcell_cli.cli.app import _run
from purcell_cli.environment.scene import Scene
from purcell_cli.environment.solids import HalfSpace
from purcell_cli.errors import InputError
from purcell_cli.gaits.sampling import sample_stroke
from purcell_cli.geometry.rotations import as_euler
from purcell_cli.lie_brackets.planar_curvature import PLANES, planar_curvature
from purcell_cli.mechanics.moves import MoveSequence
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.curve import Curve
from purcell_cli.motion.mission import Follow, Waypoint
from purcell_cli.motion.trajectory import Trajectory, as_table, sample
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.pictures.poses_plot import poses_figure, roll_marks
from purcell_cli.pictures.space_plot import space_figure
from purcell_cli.pictures.stroke_plot import stroke_figure
from purcell_cli.pictures.style import control_legs, save_figure
from purcell_cli.pictures.surroundings import Surroundings
from purcell_cli.pictures.time_plot import time_figure
from purcell_cli.wording import length_unit

PAPER = Swimmer()


@functools.cache
def planned() -> Table:
    """Return a short plan through all three phases."""
    start = Configuration.from_angles((0.0, 0.0, 0.0), (0, 0, 0), (30, 10, 0), (-20, 15, 5))
    goal = Configuration.from_angles((0.001, 0.0, 0.0), (0, 0, 10), (30, 10, 0), (-20, 15, 5))
    return as_table(plan(start, goal).trajectory)


@functools.cache
def cycle(name: str) -> Trajectory:
    return sample_stroke(PAPER, Configuration(), realise(stored_gaits()[name], PAPER), 1, 0.02)


@pytest.mark.slow
def test_motions_are_drawn_against_time_in_degrees_and_millimetres() -> None:
    table = planned()
    figure = time_figure(table, "a plan")
    labels = ["limb 1 [°]", "limb 2 [°]", "base position [mm]", "base angles [°]"]
    degrees = np.degrees(table.euler_rad)
    wanted = [degrees[:, 1], degrees[:, 2], 1e3 * table.position_m, degrees[:, 0]]
    assert [axes.get_ylabel() for axes in figure.axes] == labels
    assert figure.axes[-1].get_xlabel() == "time [s]"
    for axes, values in zip(figure.axes, wanted, strict=True):
        for k, line in enumerate(axes.get_lines()[:3]):
            assert_close(line.get_xdata(), table.time_s, 0.0)
            assert_close(line.get_ydata(), values[:, k], 0.0)


@pytest.mark.slow
def test_phases_are_shaded_from_their_first_row_to_the_next_ones() -> None:
    table = planned()
    figure = time_figure(table, "a plan")
    second, third = (table.time_s[np.flatnonzero(table.phase == phase)[0]] for phase in (2, 3))
    wanted = [(0.0, second), (second, third), (third, table.time_s[-1])]
    for axes in figure.axes:
        spans = [(patch.get_x(), patch.get_x() + patch.get_width()) for patch in axes.patches]
        assert_close(np.array(spans), np.array(wanted), 1e-12)
    assert [text.get_text()[0] for text in figure.axes[0].texts] == ["1", "2", "3"]
    assert not time_figure(as_table(cycle("y-motion")), "one phase").axes[0].patches


def test_an_angle_that_jumps_by_a_turn_is_drawn_with_a_gap() -> None:
    start = Configuration.from_angles((0, 0, 0), (0, 0, 170))
    table = as_table(sample_stroke(PAPER, start, realise(stored_gaits()["x-rotation"], PAPER), 1, 0.01))
    assert np.max(np.abs(np.diff(table.euler_rad[:, 0, 2]))) > 6.0
    roll = time_figure(table, "over the top").axes[3].get_lines()[2].get_ydata()
    assert np.sum(np.isnan(roll)) == 1
    assert np.nanmax(np.abs(np.diff(roll))) < 30.0


@pytest.mark.parametrize(
    ("largest", "wanted"),
    [(2.0, (1.0, "m")), (0.02, (1e3, "mm")), (3e-6, (1e6, "µm")), (2e-12, (1e9, "nm")), (0.0, (1e3, "mm"))],
)
def test_lengths_have_a_unit_of_their_size(largest: float, wanted: tuple[float, str]) -> None:
    assert length_unit(largest) == wanted


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "plane"), [("y-motion", PLANES[0]), ("z-rotation", PLANES[0]), ("z-motion", PLANES[1])]
)
def test_a_planar_stroke_is_drawn_over_the_curvature_of_its_plane(name: str, plane: object) -> None:
    figure = stroke_figure(PAPER, cycle(name), name)
    panels = [axes for axes in figure.axes if axes.get_images()]
    assert [axes.get_title() for axes in panels] == list(plane.names)
    units = [f"curvature of {n} [{u}]" for n, u in zip(plane.names, ("L/rad²", "L/rad²", "°/rad²"), strict=True)]
    assert [axes.get_xlabel() for axes in figure.axes if axes not in panels] == units
    path = panels[0].get_lines()[0].get_xydata()
    figure.draw_without_rendering()
    for axes in figure.axes[len(panels) :]:
        boxes = [label.get_window_extent() for label in axes.get_xticklabels() if label.get_text()]
        assert len(boxes) >= 2
        assert all(a.x1 + 4.0 < b.x0 for a, b in itertools.pairwise(boxes)), "ticks of the colour bars collide"
    for k, axes in enumerate(panels):
        (image,) = axes.get_images()
        assert isinstance(image, AxesImage)
        height, (left, right, *_) = np.asarray(image.get_array()), image.get_extent()
        row, column = 100, 31  # limb 2 upwards, limb 1 to the right
        grid = np.linspace(left, right, len(height))
        wanted = planar_curvature(PAPER, plane, [grid[column], grid[row]]) / [0.1, 0.1, np.pi / 180.0]
        assert_close(height[row, column], wanted[k], 1e-12)
        low, high = image.get_clim()
        assert low == -high, "white is zero"
        assert_close(axes.get_lines()[0].get_xydata(), path, 0.0)
    assert_close(np.abs(path).max(axis=0), np.abs(corners(name)).max(axis=0), 1e-9)


def corners(name: str) -> np.ndarray:
    """Return both joints' angles after each primitive, summed up. Shape (n, 2)."""
    cycle = realise(stored_gaits()[name], PAPER).played()
    turned = np.where(cycle.control[:, None] // 3 == [0, 1], cycle.angle[:, None], 0.0)
    return np.cumsum(turned, axis=0)


@pytest.mark.slow
def test_a_smooth_stroke_has_eight_arrows_and_ten_poses() -> None:
    """A circle in the shape plane, of a hundred moves; a square has an arrow and a number a leg."""
    angle = np.linspace(0.0, 2.0 * np.pi, 101)
    turn = np.zeros((100, 6))
    turn[:, 2], turn[:, 5] = np.diff(0.5 - 0.5 * np.cos(angle)), np.diff(0.5 * np.sin(angle))
    circle = sample(PAPER, Configuration(), [Block(2, "circle", MoveSequence.of_turns(turn))], 0.05)

    def drawn(trajectory: Trajectory) -> tuple[int, int]:
        axes = stroke_figure(PAPER, trajectory, "a loop").axes[0]
        return len([text for text in axes.texts if not text.get_text()]), len([t for t in axes.texts if t.get_text()])

    assert drawn(circle) == (8, 0)
    assert drawn(cycle("y-motion")) == (7, 7)
    poses = [axes.get_title() for axes in poses_figure(PAPER, circle, "a circle").axes]
    assert len(poses) == 10
    assert poses[0] == "0 s"
    assert poses[-1] == f"{circle.time_s[-1]:.3g} s"


def test_the_numbers_beside_a_stroke_that_bends_no_limb_lie_apart() -> None:
    figure = stroke_figure(PAPER, cycle("printed-phi"), "printed-phi")
    figure.draw_without_rendering()
    boxes = [label.get_window_extent() for label in figure.axes[1].get_xticklabels()]
    assert len(boxes) > 2
    assert all(left.x1 < right.x0 for left, right in itertools.pairwise(sorted(boxes, key=lambda box: box.x0)))


def test_a_spatial_stroke_is_drawn_on_the_sphere_and_unrolled_to_its_bends() -> None:
    trajectory = cycle("x-rotation")
    figure = stroke_figure(PAPER, trajectory, "x-rotation")
    sphere, chart = figure.axes
    assert chart.get_xlabel() == "bend towards y [rad]"
    drawn = chart.get_lines()[0].get_xydata()
    bend = np.arccos(np.clip(trajectory.shape[:, 0, 0, 0], -1.0, 1.0))
    assert_close(np.hypot(*drawn.T), bend, 1e-7)
    away = bend > 1e-3
    assert_close(np.arctan2(*drawn[away].T[::-1]), np.arctan2(*trajectory.shape[away, 0, 1:, 0].T[::-1]), 1e-9)
    labels = [text.get_text() for text in chart.get_legend().get_texts()]
    assert labels == ["limb 1", "limb 2 does not bend"]
    numbered = {text.get_text(): text.get_position() for text in chart.texts if text.get_text().isdigit()}
    assert list(numbered) == [str(k) for k in range(2, 9)], "its first and last legs roll"
    assert "1, 9: a limb rolls, and its axis stays" in [text.get_text() for text in chart.texts]
    middles = {
        str(k + 1): drawn[(low + high) // 2] for k, (low, high) in enumerate(control_legs(trajectory.rate_rad_s))
    }
    for number, place in numbered.items():
        away = {k: np.hypot(*(place - middle)) for k, middle in middles.items() if k in numbered}
        assert min(away, key=away.get) == number
    on_it = [line.get_xydata() for line in sphere.get_lines() if len(line.get_xdata()) == len(trajectory)]
    assert len(on_it) == 2
    assert np.all(np.hypot(*on_it[0].T) <= 1.0)


def test_poses_are_those_where_controls_switch() -> None:
    """The joints of each pose, by scipy's rotations; limbs exchanged are the foil."""
    trajectory = cycle("z-motion")
    figure = poses_figure(PAPER, trajectory, "z-motion")
    cells = [axes for axes in figure.axes if axes.get_lines()]
    titles = [
        "start",
        "limb1 pitch +1.00 rad",
        "limb2 pitch +1.00 rad",
        "limb1 pitch -1.00 rad",
        "limb2 pitch -2.00 rad",
    ]
    assert [axes.get_title() for axes in cells][:5] == titles
    assert len(cells) == 8
    row = int(np.searchsorted(trajectory.time_s, 2.0 - 1e-9))
    pitch = -as_euler(trajectory.pose[row, :3, :3])[1]
    for sign, same in ((1.0, True), (-1.0, False)):
        tip = trajectory.pose[row, [0, 2], 3] / 0.1
        tip = tip + sign * np.array([np.cos(pitch) + 2 * np.cos(pitch - 1.0), np.sin(pitch) + 2 * np.sin(pitch - 1.0)])
        assert is_close(cells[2].get_lines()[3].get_xydata()[1], tip, 1e-9) == same
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names[:3] == ["limb 1", "base", "limb 2"]
    colours = [line.get_color() for line in figure.legends[0].get_lines()[:3]]
    assert colours == [line.get_color() for line in cells[2].get_lines()[3:0:-1]]


def test_marks_show_how_far_a_limb_has_rolled() -> None:
    """Half a turn of limb 1 turns its mark round, and the base turns a little; the others' marks are the foil."""
    sequence = PrimitiveSequence.of([("limb1 roll", np.pi)])
    trajectory = sample(PAPER, Configuration(), [Block(2, "own", sequence)], 0.05)
    marks = np.stack([roll_marks(PAPER, trajectory, row, 1) for row in (0, -1)])
    along = (marks[:, :, 1] - marks[:, :, 0]) / np.linalg.norm(marks[0, 0, 1] - marks[0, 0, 0])
    assert_close(along[0], np.tile([0.0, 1.0, 0.0], (3, 1)), 1e-12)
    roll = as_euler(trajectory.pose[-1, :3, :3])[2]
    assert roll < -0.5
    for link, angle in enumerate((roll, roll, roll + np.pi)):
        assert_close(along[1, link], [0.0, np.cos(angle), np.sin(angle)], 1e-9)


def test_a_motion_is_drawn_in_space_among_what_is_around_it() -> None:
    """The base's path passes through a waypoint's dot where the motion is there; another place is the foil."""
    table = as_table(cycle("z-motion"))
    there = Waypoint(table.position_m[40], np.eye(3))
    half = HalfSpace((0.0, 0.0, -0.2), (0.0, 0.0, 1.0))
    figure = space_figure(table, PAPER, "a stroke", Surroundings(Scene((half,)), ((4, there),)))
    (axes,) = figure.axes
    assert {"start", "goal", "via[4]", "x", "y", "z"} <= {text.get_text() for text in axes.texts}
    names = [text.get_text() for text in figure.legends[0].get_texts()]
    assert names == ["limb 1", "base", "limb 2", "base's path", "obstacle", "waypoint"]
    path = next(line.get_xydata() for line in axes.get_lines() if len(line.get_xdata()) == len(table.time_s))
    dot = next(line.get_xydata()[0] for line in axes.get_lines() if line.get_marker() == "o")
    assert_close(dot, path[40], 1e-12)
    assert not is_close(dot, path[0], 1e-6)
    links = [line.get_xydata() for line in axes.get_lines() if line.get_linewidth() == 3.0]
    assert_close(links[1].mean(axis=0), path[0], 1e-12)
    assert_close(links[-2].mean(axis=0), path[-1], 1e-12)
    follow = Follow(Curve(np.array([[0.0, 0, 0], [0.1, 0, 0]])), 0.05)
    figure = space_figure(table, PAPER, "a stroke", Surroundings(follow=follow))
    assert [text.get_text() for text in figure.legends[0].get_texts()][-2:] == ["curve", "its tolerance"]


def test_the_body_is_drawn_in_its_size_where_the_base_is() -> None:
    """At every swimmer that is shown, and inside the picture; a swimmer without one has none."""
    swimmer, table = dataclasses.replace(PAPER, body_radius_m=0.06), as_table(cycle("z-motion"))
    figure = space_figure(table, swimmer, "a stroke", Surroundings())
    (axes,) = figure.axes
    bodies = [patch for patch in axes.patches if isinstance(patch, Circle)]
    path = next(line.get_xydata() for line in axes.get_lines() if len(line.get_xdata()) == len(table.time_s))
    assert [body.radius for body in bodies] == [0.06] * len(bodies)
    assert_close(np.array([bodies[0].center, bodies[-1].center]), path[[0, -1]], 1e-12)
    low, high = np.array([axes.get_xlim(), axes.get_ylim()]).T
    assert all(np.all(low < np.array(one.center) - 0.06) for one in bodies)
    assert all(np.all(np.array(one.center) + 0.06 < high) for one in bodies)
    assert not space_figure(table, PAPER, "a stroke", Surroundings()).axes[0].patches


def test_labels_of_places_near_each_other_lie_apart(monkeypatch: pytest.MonkeyPatch) -> None:
    table = as_table(cycle("z-motion"))
    near = Surroundings(None, tuple((k, Waypoint(table.position_m[10 + k])) for k in range(5)))

    def overlapping() -> int:
        figure = space_figure(table, PAPER, "a stroke", near)
        figure.draw_without_rendering()
        texts = [text for text in figure.axes[0].texts if text.get_text()[:3] in {"sta", "goa", "via"}]
        boxes = [text.get_window_extent() for text in texts]
        return sum(a.overlaps(b) for a, b in itertools.combinations(boxes, 2))

    assert overlapping() == 0
    monkeypatch.setitem(space_figure.__globals__, "draw_apart", lambda *_: None)
    assert overlapping() > 3


@pytest.mark.slow
def test_a_picture_is_the_same_bytes_each_time_and_has_no_date(tmp_path: Path) -> None:
    for ending in ("svg", "png", "pdf"):
        for name in ("a", "b"):
            save_figure(stroke_figure(PAPER, cycle("x-rotation"), "roll"), tmp_path / f"{name}.{ending}")
        first, second = ((tmp_path / f"{name}.{ending}").read_bytes() for name in ("a", "b"))
        assert first == second
        assert b"date" not in first.lower()
    assert len(list(tmp_path.iterdir())) == 6


@pytest.mark.slow
def test_another_ending_is_refused(tmp_path: Path) -> None:
    figure = time_figure(planned(), "a plan")
    with pytest.raises(InputError, match=r"a\.gif: wanted a picture's ending \(png, svg, pdf\), found \.gif"):
        save_figure(figure, tmp_path / "a.gif")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_plot_draws_trajectories_and_gaits_and_figures_the_papers_motions(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(commands, "PAPER_MOTIONS", ("x-rotation",))
    monkeypatch.setattr(commands, "PRINTED", ("printed-phi",))

    def document(*arguments: str) -> dict:
        capsys.readouterr()
        assert _run([*arguments, "--json"]) == 0
        return json.loads(capsys.readouterr().out)

    document("gait", "x-rotation", "--out", "swim.csv")
    assert document("plot", "swim.csv") == {
        "schema": "purcell/plot/1",
        "verdict": "done",
        "of": "swim.csv",
        "kind": "trajectory",
        "picture": "swim.png",
    }
    assert document("plot", "roll", "--amplitude", "0.5", "--out", "roll.svg")["kind"] == "gait"
    assert "0.5 rad" in (tmp_path / "roll.svg").read_text()
    pictures = document("figures", "--format", "png")["pictures"]
    assert pictures == [
        f"figures/{n}-{k}.png" for n in ("x-rotation", "printed-phi") for k in ("stroke", "poses", "time")
    ]
    assert all(Path(name).read_bytes().startswith(b"\x89PNG") for name in ["swim.png", *pictures])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["plot", "nope"], "no gait is called 'nope'"),
        (["plot", "nope.csv"], "nope.csv: wanted a trajectory file, found none"),
        (["plot", "x-motion", "--out", "a.gif"], "a.gif: wanted a picture's ending (png, svg, pdf), found .gif"),
        (["plot", "x-motion", "--out", "no/a.png"], "no/a.png: wanted a file in a folder that exists"),
        (["plot", "x-motion", "--scenario", "roll"], "--scenario: nothing around a gait"),
        (["plot", "swim.csv", "--gaits", "own"], "--gaits: no folder is wanted for a trajectory"),
        (["figures", "--format", "gif"], "--format: one of png, svg, pdf is wanted, found 'gif'"),
        (["figures", "--out", "file"], "file: wanted a folder to write to, found none that can be made"),
    ],
)
def test_what_cannot_be_drawn_is_refused_and_nothing_is_written(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    arguments: list[str],
    message: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("file").write_text("")
    assert _run(arguments) == 2
    assert message in capsys.readouterr().err
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


_OF_A_USER = """text.usetex: True
font.size: 20
axes.facecolor: yellow
savefig.bbox: tight
svg.fonttype: none
backend: nonsense
no.such: key
"""


@pytest.mark.slow
def test_pictures_are_the_same_bytes_whatever_settings_a_user_has(tmp_path: Path) -> None:
    """A notebook's backend that is not installed here, TeX, and a file of settings; reading it is the foil."""
    program = """
from purcell_cli.cli.app import _run
for ending in ("svg", "png", "pdf"):
    assert _run(["plot", "x-rotation", "--out", "a." + ending]) == 0
"""
    pictures = []
    for name, settings, backend in (
        ("plain", b"", None),
        ("styled", _OF_A_USER.encode(), "module://matplotlib_inline.backend_inline"),
        ("broken", b"\xff\xfe", "nonsense"),
    ):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "matplotlibrc").write_bytes(settings)
        surroundings = {k: v for k, v in os.environ.items() if k != "MPLBACKEND"}
        surroundings |= {} if backend is None else {"MPLBACKEND": backend}
        command = [sys.executable, "-c", program]
        done = subprocess.run(command, cwd=folder, env=surroundings, capture_output=True, encoding="utf-8")
        assert (done.returncode, done.stderr) == (0, "")
        pictures.append([(folder / f"a.{ending}").read_bytes() for ending in ("svg", "png", "pdf")])
    assert pictures[1:] == pictures[:1] * 2
    foil = subprocess.run([sys.executable, "-c", "import matplotlib"], cwd=folder, capture_output=True)
    assert foil.returncode == 1


@pytest.mark.slow
def test_pictures_drawn_in_a_process_with_settings_of_its_own_do_not_take_them_over(tmp_path: Path) -> None:
    def drawn(name: str) -> bytes:
        save_figure(stroke_figure(PAPER, cycle("x-rotation"), "roll"), tmp_path / name)
        return (tmp_path / name).read_bytes()

    plain = drawn("plain.svg")
    with mpl.rc_context({"text.usetex": True, "font.size": 20, "lines.marker": "o", "savefig.bbox": "tight"}):
        assert drawn("styled.svg") == plain
        assert mpl.rcParams["font.size"] == 20, "the user's own stay as they are"


@pytest.mark.slow
def test_without_matplotlib_the_message_says_what_to_install(tmp_path: Path) -> None:
    program = "import sys; sys.modules['matplotlib'] = None\nfrom purcell_cli.cli.app import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", program, "plot", "x-motion"], cwd=tmp_path, capture_output=True, encoding="utf-8"
    )
    assert done.returncode == 2
    assert "pictures need matplotlib, found none; install it: python -m pip install" in done.stderr
    assert done.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []
