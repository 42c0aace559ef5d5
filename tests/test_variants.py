"""Sweeps: every combination once, in order, by names that differ."""

from __future__ import annotations

import tracemalloc
from pathlib import Path

import pytest

from purcell_cli import load_scenario
from purcell_cli.batch.cases import Case, find_cases
from purcell_cli.errors import InputError

SWEEP = """\
name: far
start: {}
goal: {base: {position_m: [0, 0, 0.01]}}
expect: {max_duration_s: 9}
sweep:
  goal.base.position_m[0]: [0.01, -0.02, 0.0]
  swimmer.slenderness: {start: 0.01, stop: 0.02, num: 3}
"""


def cases_of(folder: Path, text: str) -> list[Case]:
    (folder / "case.yaml").write_text(text)
    return list(find_cases([str(folder / "case.yaml")]))


def test_a_sweep_is_the_product_of_its_values(tmp_path: Path) -> None:
    cases = cases_of(tmp_path, SWEEP)
    assert [case.name for case in cases] == [
        f"far-{x}-{s}" for x in ("0.01", "-0.02", "0") for s in ("0.01", "0.015", "0.02")
    ]
    for case, (x, s) in zip(cases, ((x, s) for x in (0.01, -0.02, 0.0) for s in (0.01, 0.015, 0.02)), strict=True):
        assert case.scenario is not None
        assert case.scenario.name == case.name
        assert case.scenario.goal.pose[:3, 3].tolist() == [x, 0.0, 0.01]
        assert case.scenario.swimmer.slenderness == s
        assert case.expect.max_duration_s == 9
        assert case.sweep == {"goal.base.position_m[0]": x, "swimmer.slenderness": s}
    assert len({case.fingerprint() for case in cases}) == 9


def test_whole_parts_and_files_can_be_swept(tmp_path: Path) -> None:
    (tmp_path / "one.yaml").write_text("limb1: {euler_deg: [10, 0, 0]}")
    cases = cases_of(
        tmp_path,
        "name: n\nstart: {}\nsweep:\n  goal: [one.yaml, {limb1: {euler_deg: [20, 0, 0]}}]\n"
        "  expect.verdict: [reached, error]\n",
    )
    assert [case.name for case in cases] == ["n-0-reached", "n-0-error", "n-1-reached", "n-1-error"]
    assert [case.expect.verdict for case in cases] == ["reached", "error"] * 2
    assert all(case.scenario is not None for case in cases)


def test_values_that_look_alike_have_names_that_differ(tmp_path: Path) -> None:
    text = "name: n\nstart: {}\ngoal: {}\nsweep: {swimmer.slenderness: {start: 0.01, stop: 0.0100001, num: 12}}\n"
    names = [case.name for case in cases_of(tmp_path, text)]
    assert len(set(names)) == 12
    assert names[0] == "n-0.01"


@pytest.mark.parametrize(
    ("sweep", "message"),
    [
        ("{}", "1 to 1000000 combinations, found none"),
        ("{swimmer.slenderness: []}", "case.yaml:4: sweep.swimmer.slenderness: wanted a list of one value or more"),
        ("{name: [a, b]}", "a key path of the scenario"),
        ("{'goal.base.position_m[7]': [1]}", "goal: wanted a mapping, for the sweep's key goal.base.position_m[7]"),
        ("{'start.limb1.euler_deg[3]': [1]}", "start.limb1.euler_deg: wanted a list of 4 or more"),
        ("{swimmer.slendernes: [0.01]}", "nearest: slenderness"),
        ("{swimmer.slenderness: [-1]}", "case.yaml:4: swimmer.slenderness: wanted a finite number"),
        ("{swimmer.slenderness: {start: 1, stop: 2, num: 99999999}}", "wanted a whole number"),
        (
            "{swimmer.slenderness: {start: 0.01, stop: 0.02, num: 1001}, 'start.limb1.euler_deg[0]': "
            "{start: 0, stop: 1, num: 1000}}",
            "1 to 1000000 combinations, found 1001000",
        ),
    ],
)
def test_a_bad_sweep_is_one_case_that_says_why(tmp_path: Path, sweep: str, message: str) -> None:
    (tmp_path / "goal.yaml").write_text("{}")
    head = "name: n\nstart: {limb1: {euler_deg: [1, 2, 3]}}\ngoal: goal.yaml\n"
    (case,) = cases_of(tmp_path, f"{head}sweep: {sweep}\n")
    assert case.scenario is None
    assert message in case.error


@pytest.mark.slow
def test_a_sweep_that_asks_for_too_much_is_refused_at_once_and_in_little_memory(tmp_path: Path) -> None:
    ranges = "".join(f"  swimmer.x{k}: {{start: 0, stop: 1, num: 100000}}\n" for k in range(300))
    tracemalloc.start()
    (case,) = cases_of(tmp_path, f"name: n\nstart: {{}}\ngoal: {{}}\nsweep:\n{ranges}")
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert "1 to 1000000 combinations" in case.error
    assert peak < 100e6


def test_names_of_one_sweep_that_meet_those_of_another_are_refused(tmp_path: Path) -> None:
    (tmp_path / "other.yaml").write_text("name: far-0-0.02\nstart: {}\ngoal: {}\n")
    (tmp_path / "case.yaml").write_text(SWEEP)
    with pytest.raises(InputError, match=r"found 'far-0-0\.02', which .*case\.yaml has too"):
        find_cases([str(tmp_path)])


def test_a_single_plan_refuses_a_sweep(tmp_path: Path) -> None:
    (tmp_path / "case.yaml").write_text(SWEEP)
    with pytest.raises(InputError, match=r"case.yaml:6: sweep: wanted a scenario without a sweep here"):
        load_scenario(tmp_path / "case.yaml")
