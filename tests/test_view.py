"""The page that plays a motion: it holds the motion whole, needs nothing else, and works in a real browser."""

from __future__ import annotations

import base64
import dataclasses
import functools
import itertools
import json
import re
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers import assert_close, is_close
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation
from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By

from purcell_cli import Configuration, Swimmer, realise, stored_gaits
from purcell_cli.cli.app import _run
from purcell_cli.cli.pictures import surroundings_of
from purcell_cli.environment.scene import Scene
from purcell_cli.environment.solids import Sphere
from purcell_cli.errors import ParameterError
from purcell_cli.files.plan_file import PlanDocument, write_plan
from purcell_cli.gaits.sampling import sample_stroke
from purcell_cli.motion.curve import Curve
from purcell_cli.motion.mission import Follow, Passage, Waypoint
from purcell_cli.motion.options import PlanOptions
from purcell_cli.motion.plan import Plan
from purcell_cli.motion.trajectory import as_table
from purcell_cli.motion.trajectory_table import Table
from purcell_cli.pictures.html_view import page, shown_rows, write_page
from purcell_cli.pictures.surfaces import tube_round
from purcell_cli.pictures.surroundings import NOTHING, Surroundings

SWIMMER = Swimmer(base_half_length_m=0.1, limb_half_length_m=0.07, slenderness=0.02)


@functools.cache
def motion(gait: str = "x-rotation", cycles: int = 2, dt: float = 0.01) -> Table:
    """Return a stroke of a swimmer with unequal links from an odd place."""
    start = Configuration.from_angles((0.2, -0.1, 0.3), (40, -20, 75))
    return as_table(sample_stroke(SWIMMER, start, realise(stored_gaits()[gait], SWIMMER), cycles, dt))


@functools.cache
def long_motion() -> Table:
    """Return a motion of more than 50,000 rows."""
    table = motion("x-cruise", 320, 0.05)
    assert len(table.time_s) > 50_000
    return table


def told(text: str) -> dict[str, Any]:
    """Return the data that a page holds."""
    return json.loads(re.search(r'<script id="data" type="application/json">(.*?)</script>', text, re.DOTALL)[1])


def unpacked(data: dict[str, Any], name: str, kind: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(data[name]), dtype=kind)


def ends(position: np.ndarray, base: np.ndarray, limbs: np.ndarray) -> np.ndarray:
    """Return the ends of base, limb 1 and limb 2, by scipy's rotations. Shape (3, 2, 3)."""
    b, l = SWIMMER.base_half_length_m, SWIMMER.limb_half_length_m
    turn, first, second = (Rotation.from_quat(q, scalar_first=True) for q in (base, *limbs))
    x = np.array([1.0, 0.0, 0.0])
    front, back = position + turn.apply(b * x), position - turn.apply(b * x)
    tips = front + (turn * first).apply(2 * l * x), back - (turn * second).apply(2 * l * x)
    return np.array([[back, front], [front, tips[0]], [back, tips[1]]])


# --- What the page holds -------------------------------------------------------------------------------------------


def test_a_page_holds_every_row_of_a_short_motion() -> None:
    table = motion()
    data = told(page(table, SWIMMER, "roll"))
    frames = unpacked(data, "frames", "<f4").reshape(-1, 15)
    wanted = np.concatenate([table.position_m, table.base, table.limbs[:, 0], table.limbs[:, 1]], axis=1)
    assert np.array_equal(unpacked(data, "time", "<f8"), table.time_s)
    assert np.array_equal(frames, wanted.astype(np.float32))
    assert [data["gaits"][k] for k in unpacked(data, "gait", "<u4")] == table.gait.tolist()
    assert np.array_equal(unpacked(data, "phase", "u1"), table.phase)
    assert data["radii"] == [0.02 * 0.2, 0.02 * 0.14, 0.02 * 0.14]


def test_a_long_motion_is_thinned_to_its_switches_and_even_times() -> None:
    table = long_motion()
    rows = shown_rows(table)
    switches = np.flatnonzero(np.any(table.rate_rad_s[1:] != table.rate_rad_s[:-1], axis=1)) + 1
    assert rows[0] == 0
    assert rows[-1] == len(table.time_s) - 1
    assert np.all(np.diff(rows) > 0)
    assert set(switches) <= set(rows)
    assert len(rows) <= 12000
    assert np.max(np.diff(table.time_s[rows])) < 2 * table.time_s[-1] / (12000 - len(switches))
    few = shown_rows(table, 500)
    assert len(few) <= 500
    assert np.max(np.diff(table.time_s[few])) < 2 * table.time_s[-1] / 498
    assert len(page(table, SWIMMER, "long")) < 2e6


def test_a_page_needs_no_network_and_no_text_of_it_can_become_a_program() -> None:
    title = "</script><script>alert(1)</script>"
    text = page(motion(), SWIMMER, title)
    assert not re.search(r"https?:|//[a-z]+\.|\bsrc=|\bhref=\"(?!data:,)|@import|url\(", text)
    assert "default-src 'none'" in text
    assert "<script>alert" not in text
    assert told(text)["title"] == title


def test_view_writes_a_page_and_says_what_it_holds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert _run(["gait", "y-motion", "--out", "swim.csv"]) == 0
    capsys.readouterr()
    assert _run(["view", "swim.csv", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert list(document) == ["schema", "verdict", "trajectory", "page", "rows", "frames", "bytes"]
    assert document["schema"] == "purcell/view/1"
    assert document["rows"] == document["frames"]
    assert (tmp_path / "swim.html").stat().st_size == document["bytes"]
    assert _run(["view", "missing.csv"]) == 2
    assert "missing.csv: wanted a trajectory file, found none" in capsys.readouterr().err
    assert not (tmp_path / "missing.html").exists()


# --- In a browser --------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def browser() -> Iterator[webdriver.Chrome]:
    """Return a browser without a window; where there is none, say so and skip."""
    program = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    driver = shutil.which("chromedriver")
    if program is None or driver is None:
        pytest.skip("no chromium and chromedriver: the page is not tried in a browser (apt install chromium-driver)")
    options = webdriver.ChromeOptions()
    options.binary_location = program
    for argument in ("--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--window-size=1280,860"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
    found = webdriver.Chrome(options=options, service=Service(driver))
    yield found
    found.quit()


def opened(browser: webdriver.Chrome, folder: Path, table: Table, title: str, around: Surroundings = NOTHING) -> float:
    """Open the page of a motion, and return how long that took by the browser's clock [s]."""
    write_page(table, SWIMMER, title, folder / "swim.html", around=around)
    browser.get((folder / "swim.html").as_uri())
    return float(browser.execute_script("return document.documentElement.dataset.opened")) / 1e3


def clock(browser: webdriver.Chrome) -> float:
    return float(browser.find_element(By.ID, "clock").text.split(" s of ")[0])


def drawn(browser: webdriver.Chrome) -> list[str]:
    """Return what both canvases show."""
    return [browser.execute_script(f"return document.getElementById('{k}').toDataURL()") for k in ("scene", "trace")]


@pytest.mark.slow
def test_the_page_opens_plays_pauses_and_scrubs(browser: webdriver.Chrome, tmp_path: Path) -> None:
    opened(browser, tmp_path, motion("y-motion"), "</script> & <b>swim")
    assert browser.find_element(By.ID, "title").text == "</script> & <b>swim"
    assert browser.find_element(By.ID, "phase").text == "2 base displacement: y-motion"
    assert clock(browser) == 0.0
    begun = drawn(browser)
    play = browser.find_element(By.ID, "play")
    play.click()
    time.sleep(0.5)
    play.click()
    reached = clock(browser)
    assert 0.1 < reached < 5.0
    assert play.text == "play"
    time.sleep(0.2)
    assert clock(browser) == reached
    assert all(a != b for a, b in zip(begun, drawn(browser), strict=True))
    ActionChains(browser).click(browser.find_element(By.ID, "scrub")).perform()
    assert abs(clock(browser) - 8.0) < 0.3, "the middle of the slider is the middle of 16 s"
    trace = browser.find_element(By.ID, "trace")
    ActionChains(browser).move_to_element_with_offset(trace, -200, 0).click().perform()
    assert 4.0 < clock(browser) < 7.0
    browser.execute_script("go(end)")
    play.click()
    assert clock(browser) < 1.0, "at the end it plays from the beginning"
    assert browser.execute_script("return performance.getEntriesByType('resource').length") == 0
    assert browser.get_log("browser") == []


@pytest.mark.slow
def test_the_links_stand_where_the_motion_says(browser: webdriver.Chrome, tmp_path: Path) -> None:
    """At rows, and half-way between two: limbs turned half-way. Limbs exchanged are the foil."""
    table = motion()
    opened(browser, tmp_path, table, "roll")
    for row in (0, 17, len(table.time_s) // 2, len(table.time_s) - 1):
        found = browser.execute_script("return linksAt(time[arguments[0]]).map((link) => link.ends)", row)
        wanted = ends(table.position_m[row], table.base[row], table.limbs[row])
        assert_close(np.array(found), wanted, 1e-6)
    row = 20
    assert not is_close(np.array(found), ends(table.position_m[row], table.base[row], table.limbs[row][::-1]), 1e-4)
    found = browser.execute_script("return linksAt(0.5 * (time[20] + time[21])).map((link) => link.ends)")
    middle = [
        Rotation.from_quat(np.sum(pair, axis=0), scalar_first=True).as_quat(scalar_first=True)
        for pair in (table.base[20:22], table.limbs[20:22, 0], table.limbs[20:22, 1])
    ]
    assert_close(np.array(found), ends(table.position_m[20:22].mean(axis=0), middle[0], middle[1:]), 1e-6)


_LABELS = """
const written = {}, scene = document.getElementById("scene"), pen = scene.getContext("2d");
pen.fillText = (text, x, y) => { written[text] = [x, y, pen.measureText(text).width]; };
camera.az = arguments[0]; camera.el = arguments[1]; draw();
delete pen.fillText;
return [written.start, written.goal];
"""


@pytest.mark.slow
def test_start_and_goal_are_named_apart_from_wherever_they_are_seen(browser: webdriver.Chrome, tmp_path: Path) -> None:
    """A letter of the two is 13 pixels high."""
    opened(browser, tmp_path, motion("y-motion"), "swim")
    seen = [
        browser.execute_script(_LABELS, az, el) for az in np.arange(-3.0, 3.0, 0.5).tolist() for el in (-1.2, 0.0, 1.2)
    ]
    assert len(seen) == 36
    for (x0, y0, wide0), (x1, y1, wide1) in seen:
        assert abs(y0 - y1) > 13.0 or x0 + wide0 < x1 or x1 + wide1 < x0


@pytest.mark.slow
def test_every_control_draws_without_an_error(browser: webdriver.Chrome, tmp_path: Path) -> None:
    opened(browser, tmp_path, motion("y-motion"), "swim")
    for name in ("speed", "signal", "window"):
        for option in browser.find_elements(By.CSS_SELECTOR, f"#{name} option"):
            option.click()
    assert browser.execute_script("return speed") == 200
    for name in ("follow", "marks", "fit"):
        before = drawn(browser)[0]
        browser.find_element(By.ID, name).click()
        assert drawn(browser)[0] != before, name
    before = drawn(browser)[0]
    scene = browser.find_element(By.ID, "scene")
    ActionChains(browser).drag_and_drop_by_offset(scene, 150, 40).perform()
    assert drawn(browser)[0] != before
    ActionChains(browser).move_to_element(scene).scroll_by_amount(0, 200).perform()
    assert browser.get_log("browser") == []


@pytest.mark.slow
def test_50000_rows_open_in_three_seconds(browser: webdriver.Chrome, tmp_path: Path) -> None:
    took = [opened(browser, tmp_path, long_motion(), "long") for _ in range(3)]
    assert min(took) < 3.0, took
    assert browser.get_log("browser") == []


def test_an_error_of_a_page_is_seen_in_the_console(browser: webdriver.Chrome) -> None:
    browser.get("data:text/html,<script>nonsense()</script>")
    assert any("nonsense is not defined" in entry["message"] for entry in browser.get_log("browser"))


def test_a_motion_far_from_the_worlds_origin_is_seen_whole() -> None:
    near = motion()
    shift = np.array([5e6, -4e6, 3.0])
    far = dataclasses.replace(near, position_m=near.position_m + shift)
    data = told(page(far, SWIMMER, "t"))
    frames = unpacked(data, "frames", "<f4").reshape(len(near.time_s), 15)
    np.testing.assert_allclose(frames[:, :3], near.position_m - near.position_m[0], atol=2e-8)
    assert data["title"] == "t, from (5000000.2, -4000000.1, 3.3) m"
    assert told(page(near, SWIMMER, "t"))["title"] == "t"
    assert not np.any(dataclasses.replace(near, position_m=np.tile(shift, (len(near.time_s), 1))).origin_m)


def test_a_page_plays_another_motion_beside() -> None:
    table = motion()
    other = dataclasses.replace(table, position_m=table.position_m + np.array([0.1, 0.0, 0.0]))
    data = told(page(table, SWIMMER, "roll", other))
    wanted = np.concatenate([other.position_m, other.base, other.limbs[:, 0], other.limbs[:, 1]], axis=1)
    assert np.array_equal(unpacked(data, "beside", "<f4").reshape(-1, 15), wanted.astype(np.float32))
    assert told(page(table, SWIMMER, "roll"))["beside"] is None
    with pytest.raises(ParameterError, match="the same times"):
        page(table, SWIMMER, "roll", dataclasses.replace(table, time_s=2.0 * table.time_s))


@pytest.mark.slow
def test_the_body_is_drawn() -> None:
    swimmer = dataclasses.replace(SWIMMER, body_radius_m=0.03)
    assert told(page(motion(), swimmer, "roll"))["body_radius"] == 0.03
    assert told(page(motion(), SWIMMER, "roll"))["body_radius"] == 0.0


# --- What is around a motion ---------------------------------------------------------------------------------------


def waypoints() -> tuple[Waypoint, Waypoint]:
    """Return one with a place and an orientation, and one where the motion is at row 70 and names its limbs alone."""
    limbs = [Rotation.from_quat(motion().limbs[70, k], scalar_first=True).as_matrix() for k in (0, 1)]
    turn = Rotation.from_euler("z", 0.5).as_matrix()
    return Waypoint(np.array([0.3, 0.1, 0.2]), turn), Waypoint(limb1=limbs[0], limb2=limbs[1])


def test_a_page_shows_obstacles_and_waypoints() -> None:
    """A waypoint without a place stands where the motion is nearest to the rest; exchanged limbs are the foil."""
    table, (one, two) = motion(), waypoints()
    around = Surroundings(Scene((Sphere((0.2, 0.5, 0.3), 0.1),)), ((0, one), (1, two)))
    data = told(page(table, SWIMMER, "t", around=around))
    (skin,) = data["skins"]
    assert skin["of"] == "obstacle"
    points = unpacked(skin, "triangles", "<f4").reshape(-1, 3)
    assert_close(np.linalg.norm(points - [0.2, 0.5, 0.3], axis=1), np.full(len(points), 0.1), 1e-6)
    placed, free = data["marks"]
    assert [placed["name"], free["name"]] == ["via[0]", "via[1]"]
    assert (placed["place"], placed["placed"], free["placed"], free["axes"]) == ([0.3, 0.1, 0.2], True, False, None)
    assert_close(np.array(placed["axes"])[0], [np.cos(0.5), np.sin(0.5), 0.0], 1e-12)
    assert_close(np.array(free["place"]), table.position_m[70], 1e-12)
    (swapped,) = Surroundings(waypoints=((0, Waypoint(limb1=two.limb2, limb2=two.limb1)),)).marks(table)
    assert not is_close(swapped.place_m, table.position_m[70], 1e-6)
    assert told(page(table, SWIMMER, "t"))["marks"] == []


def test_a_tolerance_is_drawn_as_far_from_its_curve_as_it_allows() -> None:
    """Round an arc of many points; at a corner where it turns back, it ends round."""
    angle = np.linspace(0.0, 2.0, 400)
    arc = np.stack([np.cos(angle), np.sin(angle), 0.1 * angle], axis=1)
    for points, most in ((arc, 0.05), (np.array([[0.0, 0, 0], [1, 0, 0], [0.2, 0, 0]]), 0.1)):
        fine = np.concatenate([np.linspace(a, b, 100) for a, b in itertools.pairwise(points)])
        surface = tube_round(points, most)
        corners = np.unique(surface.reshape(-1, 3), axis=0)
        off, _ = KDTree(fine).query(corners)
        assert_close(off.max(), most, 0.01 * most)
        if points is arc:
            assert off.min() > 0.98 * most
        assert len(surface) < 10_000
    assert_close(corners[:, 0].max(), 1.1, 1e-6)
    data = told(page(motion(), SWIMMER, "t", around=Surroundings(follow=Follow(Curve(arc), 0.05))))
    assert [skin["of"] for skin in data["skins"]] == ["tolerance"]
    assert_close(unpacked(data, "curve", "<f4").reshape(-1, 3), arc, 1e-6)


def test_a_scenario_and_its_plan_document_show_the_same(tmp_path: Path) -> None:
    (tmp_path / "s.yaml").write_text(
        "name: s\nstart: {}\nvia: [{limb1: {euler_deg: [9, 0, 0]}}, {base: {position_m: [0.1, 0, 0]}}]\n"
        "goal: {base: {position_m: [1, 0, 0]}}\nobstacles: [{sphere: {centre_m: [0, 2, 0], radius_m: 0.1}}]\n"
    )
    asked = surroundings_of(str(tmp_path / "s.yaml"))
    passages = tuple(Passage(one, index, 0) for index, one in reversed(asked.waypoints))
    plan = Plan(Swimmer(), Configuration(), Configuration.from_angles((1, 0, 0)), (), passages=passages)
    write_plan(PlanDocument(plan, PlanOptions(obstacles=asked.obstacles)), tmp_path / "plan.json")
    done = surroundings_of(str(tmp_path / "plan.json"))
    assert asked.obstacles == done.obstacles
    marks = [{mark.name: (mark.place_m.tolist(), mark.placed) for mark in x.marks(motion())} for x in (asked, done)]
    assert marks[0] == marks[1]
    assert list(marks[1]) == ["via[1]", "via[0]"]
    assert surroundings_of(None) == NOTHING


@pytest.mark.slow
def test_what_is_around_is_drawn_in_wide_and_narrow_windows(browser: webdriver.Chrome, tmp_path: Path) -> None:
    table, named = motion(), tuple(enumerate(waypoints()))
    line = Curve(np.array([[0.2, -0.1, 0.3], [0.6, 0.2, 0.3]]))
    for wide in (1280, 400):
        browser.set_window_size(wide, 860)
        pictures = []
        for around in (NOTHING, Surroundings(waypoints=named), Surroundings(follow=Follow(line, 0.05))):
            opened(browser, tmp_path, table, "roll", around)
            pictures.append(drawn(browser)[0])
        assert len(set(pictures)) == 3
    assert browser.get_log("browser") == []
    browser.set_window_size(1280, 860)
