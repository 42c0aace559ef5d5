"""What is too large is refused before it is begun: memory, and coordinates that no number can say."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from helpers import Run, runner

from purcell_cli import Configuration, PlanOptions, Swimmer, plan, read_csv, write_csv
from purcell_cli.errors import ParameterError
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.mechanics.drag import LinkSize, LinkSizes
from purcell_cli.mechanics.joints import Joint
from purcell_cli.missions import plan_mission
from purcell_cli.motion import memory
from purcell_cli.motion.coordinates import refuse_large
from purcell_cli.motion.curve import Curve
from purcell_cli.motion.memory import MOST_ROWS, refuse_huge
from purcell_cli.motion.mission import Follow, Mission, Waypoint
from purcell_cli.planner.arcs.primitive_counts import PROMISED, PrimitiveCounts, promised
from purcell_cli.planner.refine.simultaneous import quickened
from purcell_cli.planner.refinement import Refinement
from purcell_cli.solution import carried_out

QUICK = PlanOptions(effort="quick")
HINGE = Joint("hinge", "yaw")
THIN_LIMBS = [Swimmer(links=LinkSizes(limb2=LinkSize(slenderness=thin))) for thin in (2e-4, 1e-4)]


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Return a function that runs a command: exit code, stdout, stderr."""
    return runner(capsys)


@pytest.mark.parametrize(("primitives", "rows", "refused"), [(10, 1e3, False), (10, 1e7, True), (4_000_000, 0.0, True)])
def test_rows_and_primitives_are_counted(primitives: int, rows: float, refused: bool) -> None:
    if not refused:
        refuse_huge(primitives, rows, 3.9)
        return
    with pytest.raises(ParameterError, match=r"max-memory: a budget of at least [\d.]+ GB for"):
        refuse_huge(primitives, rows, 3.9)
    refuse_huge(primitives, rows, 100.0)


def test_the_default_is_half_of_what_is_free_if_that_is_less(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "free_bytes", lambda: int(1e9))
    refuse_huge(10, 5e5, memory.DEFAULT_GB)
    with pytest.raises(ParameterError, match=r"found 0\.5 GB"):
        refuse_huge(10, 1e6, memory.DEFAULT_GB)
    refuse_huge(10, 1e6, 0.9)
    monkeypatch.setattr(memory, "free_bytes", lambda: None)
    refuse_huge(10, 1e6, memory.DEFAULT_GB)


def test_what_holds_copies_of_files_counts_as_free(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    told = tmp_path / "meminfo"
    told.write_text("MemTotal:  24684092 kB\nMemFree:    310000 kB\nMemAvailable:  17254400 kB\n")
    monkeypatch.setattr(memory, "_KNOWN_TO_LINUX", told)
    assert memory.free_bytes() == 17254400 * 1024
    told.write_text("Nonsense: 1 kB\n")  # an old kernel: what the C library says
    other = memory.free_bytes()
    assert other is None or other != 17254400 * 1024


def test_plans_of_many_moves_are_not_made_simultaneous() -> None:
    """The derivatives of some 9,000 moves took 7 GB."""
    few = plan(Configuration(), Configuration.from_angles((0.3, 0.0, 0.0)), options=QUICK).plan
    many = dataclasses.replace(few, blocks=few.blocks * 300)
    assert sum(len(block.sequence) for block in many.blocks) > 1000
    assert quickened(many) is many


def test_a_plan_beyond_the_budget_is_refused() -> None:
    goal = Configuration.from_angles((2.0, 0.0, 0.0))
    with pytest.raises(ParameterError, match="max-memory"):
        plan(Configuration(), goal, options=PlanOptions(effort="quick", max_memory_gb=0.2))
    assert plan(Configuration(), goal, options=QUICK).verdict == "reached"


def test_a_query_that_takes_too_many_primitives_is_refused_before_anything_is_refined(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    weak = Swimmer(limb_half_length_m=0.01, drag_ratio=1.1, max_bend_rad=0.06)
    assert not PrimitiveCounts.of(weak, stored_gaits()).within(PROMISED)
    near = Refinement.near
    monkeypatch.setattr(Refinement, "near", lambda *_: pytest.fail("a motion is refined"))
    turn = Configuration.from_angles((0.0, 0.0, 0.0), (60.0, 0.0, 0.0))
    with pytest.raises(ParameterError, match=r"^max-memory: .*to turn by a radian .* a larger max_bend_rad"):
        plan(Configuration(), turn, swimmer=weak, options=QUICK)
    monkeypatch.setattr(Refinement, "near", near)
    ahead = Configuration.from_angles((0.01, 0.0, 0.0))
    assert plan(Configuration(), ahead, swimmer=weak, options=QUICK).verdict == "reached"


def test_rows_that_are_too_many_are_refused_before_anything_is_refined(monkeypatch: pytest.MonkeyPatch) -> None:
    goal = Configuration.from_angles((2.0, 0.0, 0.0))
    seconds = plan(Configuration(), goal, options=QUICK).duration_s
    monkeypatch.setattr(Refinement, "near", lambda *_: pytest.fail("a motion is refined"))
    for asked, wanted in (
        (
            PlanOptions(dt_s=0.3 * seconds / MOST_ROWS),
            r"^dt: a time above [\d.e-]+ s is wanted \(at most 3e\+06 rows\)",
        ),
        (PlanOptions(dt_s=1.2 * seconds / MOST_ROWS, max_memory_gb=0.5), r"^max-memory: .* and [\d.e+]+ rows \(fewer"),
    ):
        with pytest.raises(ParameterError, match=wanted):
            plan(Configuration(), goal, options=asked)
    there = Configuration.from_angles((1.0, 0.0, 0.0))
    for mission in (
        Mission(Configuration(), goal, via=(Waypoint(position_m=np.array([1.0, 0.1, 0.0])),)),
        Mission(Configuration(), there, follow=Follow(Curve(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]])), 0.1)),
    ):
        with pytest.raises(ParameterError, match=r"^dt: a time above [\d.e-]+ s is wanted"):
            plan_mission(mission, options=PlanOptions(dt_s=1e-6))


def test_a_file_whose_rows_do_not_fit_into_the_memory_is_refused_unread(tmp_path: Path) -> None:
    path = tmp_path / "rows.csv"
    write_csv(plan(Configuration(), Configuration.from_angles((0.01, 0.0, 0.0)), options=QUICK).trajectory, path)
    size_gb = 1e-9 * path.stat().st_size
    assert len(read_csv(path, 2.3 * size_gb).time_s) > 10
    path.write_bytes(b"nothing" * (path.stat().st_size // 7))
    with pytest.raises(ParameterError, match=r"^max-memory: a budget of at least .* GB for all rows of .*rows\.csv is"):
        read_csv(path, 2.0 * size_gb)


@pytest.mark.parametrize("command", ["view", "plot", "export", "simulate"])
def test_commands_that_read_whole_files_take_a_budget(
    command: str, run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("rows.csv").write_text("nothing")
    more = {"export": ["--to", "servo"], "simulate": ["--swimmer", "paper"]}.get(command, [])
    code, _, err = run(command, "rows.csv", *more, "--max-memory", "1e-12")
    assert (code, err.partition(" of at least")[0]) == (2, f"purcell {command}: --max-memory: a budget")
    assert [path.name for path in Path().iterdir()] == ["rows.csv"]


def test_what_a_length_takes_is_what_a_far_plan_takes() -> None:
    swimmer = Swimmer(limb_half_length_m=0.06, max_bend_rad=0.4)
    far = plan(Configuration(), Configuration.from_angles((4.0, 0.0, 0.0)), swimmer=swimmer, options=QUICK).plan
    lengths = 4.0 / swimmer.length_m
    np.testing.assert_allclose(far.primitives / lengths, PrimitiveCounts.of(swimmer, stored_gaits()).length, rtol=0.1)


def test_a_swimmer_of_too_many_strokes_is_told_what_takes_fewer() -> None:
    weak = Swimmer(limb_half_length_m=0.01, drag_ratio=1.1, max_bend_rad=0.06)
    assert not promised(weak, stored_gaits())
    few = plan(Configuration(), Configuration.from_angles((0.3, 0.0, 0.0)), options=QUICK).plan
    short = PlanOptions(max_memory_gb=0.15)
    with pytest.raises(ParameterError, match=r"max-memory: .*primitives to swim its length L.* a larger max_bend_rad"):
        carried_out(dataclasses.replace(few, swimmer=weak), short)
    with pytest.raises(ParameterError, match=r"^max-memory: (?!.*max_bend_rad)"):
        carried_out(few, short)


@pytest.mark.parametrize(
    ("kept", "other"),
    [
        (Swimmer(slenderness=2e-4), Swimmer(slenderness=1.9e-4)),
        THIN_LIMBS,
        (Swimmer(joints=(HINGE, HINGE), max_bend_rad=0.3), Swimmer(joints=(HINGE, HINGE), max_bend_rad=0.29)),
        (
            Swimmer(joints=(Joint("hinge", "yaw", (-80.0, 25.0)), HINGE)),
            Swimmer(joints=(Joint("hinge", "yaw", (-80.0, -25.0)), HINGE)),
        ),
        (Swimmer(limb_half_length_m=0.01), Swimmer(limb_half_length_m=0.009, joints=(HINGE, HINGE))),
        (Swimmer(limb_half_length_m=1.1), Swimmer(limb_half_length_m=1.1, joints=(HINGE, HINGE))),
    ],
    ids=["thin", "a thin limb", "bends", "a range", "a short limb", "a long limb"],
)
def test_plans_are_promised_from_here_on(kept: Swimmer, other: Swimmer) -> None:
    assert promised(kept, stored_gaits())
    assert not promised(other, stored_gaits())


def test_the_largest_coordinate_says_a_quarter_of_the_tolerance() -> None:
    swimmer, largest = Swimmer(), 2.0**50 * 1e-9 * 0.1
    assert np.spacing(largest) <= 0.25 * 1e-9 * 0.1 * 1.0001
    refuse_large(swimmer, "goal", Configuration.from_angles((0.999 * largest, 0.0, 0.0)))
    refuse_large(swimmer, "goal", Configuration.from_angles((0.0, 900.0 * largest, 0.0)), 1e-6)
    for place in (1.001 * largest, -1e15):
        with pytest.raises(ParameterError, match=r"goal: position_m: coordinates up to 112589 m are wanted, found"):
            refuse_large(swimmer, "goal", Configuration.from_angles((0.0, 0.0, place)))
    with pytest.raises(ParameterError, match=r"coordinates up to 1\.1e-16 m are wanted, found 0\.01"):
        refuse_large(swimmer, "goal", Configuration.from_angles((0.01, 0.0, 0.0)), 1e-30)


@pytest.mark.slow
def test_near_the_largest_coordinate_a_plan_arrives() -> None:
    start = Configuration.from_angles((1e5, -1e5, 1e5))
    goal = Configuration.from_angles((1e5 + 0.001, -1e5, 1e5 + 0.002), (5.0, 0.0, 0.0))
    found = plan(start, goal, options=QUICK)
    assert found.verdict == "reached"
    with pytest.raises(ParameterError, match="start: position_m"):
        plan(Configuration.from_angles((5e6, 5e6, 0.0)), Configuration.from_angles((5000000.001, 5e6, 0.0)))
