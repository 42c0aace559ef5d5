"""Films of a motion: every frame shows the swimmer where it is then, in the time and size that are asked for."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers import Run, runner
from motions import SWIMMER, motion, usual, written
from scipy.spatial.transform import Rotation

from purcell_cli import Configuration, read_csv
from purcell_cli.cli import terminal
from purcell_cli.motion.trajectory import as_table
from purcell_cli.pictures.film_frames import Stage

Image: Any = pytest.importorskip("PIL.Image", reason="no pillow: no films are drawn (pip install '.[video]')")
BLUE, ORANGE = (0, 114, 178), (213, 94, 0)


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that makes a film of the motion in swim.csv: exit code, stdout, stderr."""
    monkeypatch.chdir(tmp_path)
    written(usual(), tmp_path)
    return runner(capsys, "view", "swim.csv", "--swimmer", "swimmer.yaml")


def gif(path: Path) -> tuple[list[np.ndarray], list[int]]:
    """Return the frames of a GIF and how long each is shown [ms]."""
    frames, lasts = [], []
    with Image.open(path) as film:
        for k in range(film.n_frames):
            film.seek(k)
            frames.append(np.asarray(film.convert("RGB")).astype(int))
            lasts.append(film.info["duration"])
    return frames, lasts


def middle(frame: np.ndarray, colour: tuple[int, int, int]) -> np.ndarray:
    """Return the middle of the pixels of one colour: right and down. Shape (2,)."""
    rows, columns = np.nonzero(np.abs(frame - colour).max(axis=2) < 24)
    assert len(rows) > 20
    return np.array([np.mean(columns), np.mean(rows)])


def tips(time_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the middles of limb 1 and limb 2 at a time, by scipy, on a row of the motion. Shapes (3,)."""
    rows = as_table(usual())
    k = int(np.argmin(np.abs(rows.time_s - time_s)))
    base = Rotation.from_quat(rows.base[k], scalar_first=True)
    first, second = (Rotation.from_quat(q, scalar_first=True) for q in rows.limbs[k])
    half = SWIMMER.limb_half_length_m
    joint = np.array([SWIMMER.base_half_length_m, 0.0, 0.0])
    one, two = base.apply(joint + first.apply([half, 0, 0])), base.apply(second.apply([-half, 0, 0]) - joint)
    return rows.position_m[k] + one, rows.position_m[k] + two


def test_a_gif_has_the_frames_time_and_size_that_are_asked_for(run: Run, tmp_path: Path) -> None:
    code, out, err = run("--out", "swim.gif", "--duration", "2", "--fps", "15", "--size", "320x240")
    assert (code, err) == (0, "")
    assert out.startswith("film in swim.gif: 30 frames of 320 x 240, ")
    frames, lasts = gif(tmp_path / "swim.gif")
    assert frames[0].shape == (240, 320, 3)
    assert sum(lasts) == 2000 + 1000, "the last frame rests for a second"
    assert set(lasts[:-1]) <= {60, 70}
    assert tuple(frames[0][0, -1]) == (255, 255, 255)


@pytest.mark.slow
def test_frames_show_the_limbs_where_they_are(run: Run, tmp_path: Path) -> None:
    """Seen along one line throughout: pixels are one linear map of places, the same for both limbs and all times."""
    assert run("--out", "swim.gif", "--duration", "2", "--fps", "12")[0] == 0
    frames, _ = gif(tmp_path / "swim.gif")
    times = np.linspace(0.0, usual().time_s[-1], 24)
    places, pixels = [], []
    for k in (0, 5, 9, 14, 19, 23):
        for place, colour in zip(tips(times[k]), (BLUE, ORANGE), strict=True):
            places.append([*place, 1.0])
            pixels.append(middle(frames[k], colour))
    found, *_ = np.linalg.lstsq(np.array(places), np.array(pixels), rcond=None)
    assert float(np.max(np.abs(np.array(places) @ found - pixels))) < 6.0
    scale = np.linalg.norm(found[:3], axis=0)
    assert abs(scale[0] - scale[1]) < 0.03 * scale[0], "as long sideways as up"
    assert found[2, 1] < 0.0, "z is up"
    swapped = np.array(pixels).reshape(-1, 2, 2)[:, ::-1].reshape(-1, 2)
    other, *_ = np.linalg.lstsq(np.array(places), swapped, rcond=None)
    assert float(np.max(np.abs(np.array(places) @ other - swapped))) > 12.0, "limb 1 is blue"


def test_the_body_is_a_disc_of_its_size() -> None:
    """Twice the radius covers some four times the pixels, none of them at the frame's edge."""
    dark = []
    for radius in (0.03, 0.06):
        swimmer = dataclasses.replace(SWIMMER, body_radius_m=radius)
        stage = Stage(as_table(usual()), swimmer, np.array([0.0, usual().time_s[-1]]), (640, 480))
        dark.append(np.abs(np.asarray(stage.frame(1)).astype(int) - (34, 34, 34)).max(axis=2) < 24)
    small, large = (np.count_nonzero(one) for one in dark)
    assert 2.8 < large / small < 4.2
    assert not dark[1][[0, -1]].any()
    assert not dark[1][:, [0, -1]].any()


def test_a_film_shows_what_is_around_the_motion(run: Run, tmp_path: Path) -> None:
    """A ball is translucent behind the swimmer, and a waypoint a dot; without the scenario there is neither."""
    middle_m = usual().pose[:, :3, 3].mean(axis=0)
    ball = {"sphere": {"centre_m": (middle_m + np.array([0.0, 0.0, 0.3])).tolist(), "radius_m": 0.08}}
    scenario = {
        "name": "a",
        "start": {},
        "goal": {},
        "obstacles": [ball],
        "via": [{"base": {"position_m": [0, 0, 0.2]}}],
    }
    (tmp_path / "a.yaml").write_text(json.dumps(scenario), encoding="utf-8")
    shown = {}
    for name, words in (("with", ["--scenario", "a.yaml"]), ("without", [])):
        code, _, err = run("--out", f"{name}.gif", "--duration", "1", "--fps", "3", "--size", "320x240", *words)
        assert (code, err) == (0, "")
        shown[name] = gif(tmp_path / f"{name}.gif")[0]
    grey_blue = [
        sum(int(np.count_nonzero((f[..., 2] - f[..., 0] > 8) & (f[..., 0] > 150))) for f in frames)
        for frames in (shown["with"], shown["without"])
    ]
    assert grey_blue[0] > 20 * grey_blue[1] + 300
    for frame in shown["with"]:
        middle(frame, (230, 159, 0))


@pytest.mark.slow
def test_a_film_is_the_same_each_time(run: Run, tmp_path: Path) -> None:
    pytest.importorskip("av", reason="no av: no MP4 is written (pip install '.[video]')")
    for ending, times in (("gif", 2), ("mp4", 8)):
        for k in range(times):
            assert run("--out", f"{k}.{ending}", "--duration", "0.5", "--size", "160x120")[0] == 0
        assert len({(tmp_path / f"{k}.{ending}").read_bytes() for k in range(times)}) == 1


@pytest.mark.slow
def test_an_mp4_plays_the_frames_of_the_gif(run: Run, tmp_path: Path) -> None:
    av = pytest.importorskip("av", reason="no av: no MP4 is written (pip install '.[video]')")
    for ending in ("gif", "mp4"):
        assert run("--out", f"swim.{ending}", "--duration", "1", "--fps", "10", "--size", "320x240")[0] == 0
    with av.open(str(tmp_path / "swim.mp4")) as film:
        video = film.streams.video[0]
        shown = [frame.to_ndarray(format="rgb24").astype(int) for frame in film.decode(video)]
        assert (video.codec.name, float(video.average_rate)) == ("h264", 10.0)
    frames, _ = gif(tmp_path / "swim.gif")
    assert len(shown) == len(frames) == 10
    for k in (0, 4, 9):
        off = [float(np.mean(np.abs(shown[k] - frame))) for frame in frames]
        assert int(np.argmin(off)) == k
        assert off[k] < 4.0


@pytest.mark.slow
def test_a_film_takes_the_motions_own_time_and_ten_seconds_at_most(run: Run, tmp_path: Path) -> None:
    for way, lasts in (([("limb1 yaw", 0.4)], 0.4), ([("limb1 roll", 30.0)], 10.0)):
        written(motion(way, Configuration(), 0.1), tmp_path)
        document = json.loads(run("--out", "swim.gif", "--fps", "5", "--size", "64x64", "--json")[1])
        assert document["frames"] == max(2, round(5 * lasts))
        assert (document["fps"], document["width_px"], document["height_px"]) == (5.0, 64, 64)
        assert document["bytes"] == (tmp_path / "swim.gif").stat().st_size
        assert document["rows"] == len(read_csv(tmp_path / "swim.csv").time_s)


def test_one_row_at_rest_makes_a_film_too(run: Run, tmp_path: Path) -> None:
    lines = (tmp_path / "swim.csv").read_text().splitlines(keepends=True)
    (tmp_path / "swim.csv").write_text("".join([lines[0], lines[-1]]))
    assert run("--out", "swim.gif", "--size", "64x64")[0] == 0
    assert len(gif(tmp_path / "swim.gif")[0]) >= 1


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--out", "a.gif", "--fps", "0"], "--fps: a number from 1 to 50 is wanted for .gif, found 0.0"),
        (["--out", "a.gif", "--fps", "60"], "--fps: a number from 1 to 50 is wanted for .gif, found 60.0"),
        (["--out", "a.mp4", "--fps", "nan"], "--fps: a number from 1 to 120 is wanted for .mp4, found nan"),
        (["--out", "a.gif", "--duration", "0"], "--duration: a time above 0 of at most 3000 frames, 120 s, is wanted"),
        (["--out", "a.gif", "--duration", "121"], "--duration: a time above 0 of at most 3000 frames, 120 s, is"),
        (["--out", "a.gif", "--duration", "inf"], "--duration: a time above 0"),
        (["--out", "a.gif", "--size", "640"], "--size: WIDTHxHEIGHT such as 640x480"),
        (["--out", "a.gif", "--size", "641x480"], "two even numbers from 64 to 3840, is wanted, found '641x480'"),
        (["--out", "a.gif", "--size", "1e3x480"], "is wanted, found '1e3x480'"),
        (["--out", "a.mp4", "--size", "999999999x64"], "is wanted, found '999999999x64'"),
        (["--fps", "25"], "--fps: no such option is wanted for a page"),
        (["--out", "a.html", "--size", "640x480"], "--size: no such option is wanted for a page"),
    ],
)
def test_options_that_no_film_can_have_are_refused(run: Run, tmp_path: Path, words: list[str], message: str) -> None:
    code, out, err = run(*words)
    assert (code, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1
    assert sorted(p.name for p in tmp_path.iterdir()) == ["swim.csv", "swimmer.yaml"]


def test_a_bar_is_shown_on_a_terminal_alone_and_when_the_work_takes_long(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    clock = [0.0]
    monkeypatch.setattr(terminal.time, "monotonic", lambda: clock[0])
    for is_terminal, seconds, shown in ((False, 60.0, False), (True, 1.9, False), (True, 2.1, True)):
        monkeypatch.setenv("TTY_COMPATIBLE", "1")
        monkeypatch.setattr("sys.stderr.isatty", lambda answer=is_terminal: answer)
        clock[0] = 0.0
        with terminal.bar("drawing", 2.0) as told:
            told(1, 10, "frames")
            clock[0] = seconds
            told(2, 10, "frames")
        assert ("2/10" in capsys.readouterr().err) == shown, (is_terminal, seconds)


def test_a_film_shows_at_once_that_work_goes_on(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TTY_COMPATIBLE", "1")
    monkeypatch.setattr("sys.stderr.isatty", lambda: True)
    code, _, err = run("--out", "swim.gif", "--duration", "0.1", "--size", "64x64")
    assert code == 0
    assert 0 <= err.find("reading") < err.find("drawing")
