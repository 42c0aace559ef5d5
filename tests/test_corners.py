"""Swimmers at the corners of what is allowed: plans for them arrive, and what is called reached is."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from helpers import NIGHTLY

from purcell_cli import Configuration, PlanOptions, Swimmer, load_configuration, plan, stored_gaits
from purcell_cli.files.builtin import find_scenario
from purcell_cli.motion.clock import clock_step
from purcell_cli.motion.trajectory import as_table
from purcell_cli.planner.limbs.quarter_rolls import QuarterRolls
from purcell_cli.planner.reconfiguration import reconfigure
from purcell_cli.solution import Solution
from purcell_cli.verification.limits_kept import Wanted
from purcell_cli.verification.verify import verify

CORNERS = json.loads((Path(__file__).parent / "data" / "corners.json").read_text("utf-8"))["cases"]
QUICK = PlanOptions(effort="quick", dt_s=1e12)


def assert_holds(found: Solution) -> None:
    """The verdict, and what the check of the rows says, which shares nothing with the planner."""
    assert found.verdict == "reached", (found.certificate, found.rows_off, found.limits.violations)
    made = found.plan
    kept = Wanted(found.options.clearance_m)
    assert verify([as_table(found.trajectory)], made.start, made.goal, made.swimmer, 1e-9, 1e-9, kept).faults == ()


def ends_of(case: dict[str, Any], folder: Path) -> list[Configuration]:
    """Return the start and the goal of a case."""
    found = []
    for part in ("start", "goal"):
        (folder / f"{part}.json").write_text(json.dumps(case[part]))
        found.append(load_configuration(folder / f"{part}.json"))
    return found


def test_a_limb_that_is_almost_folded_is_not_bent_further(tmp_path: Path) -> None:
    """By 1.4e-8 rad, which its cosine hardly tells."""
    case = json.loads((Path(__file__).parent / "data" / "folded_limb.json").read_text("utf-8"))
    start, goal = ends_of(case, tmp_path)
    rolls = QuarterRolls.least(start, goal)
    made = reconfigure(Swimmer(**case["swimmer"]), rolls.seen(start), rolls.seen(goal), stored_gaits())
    assert made.limits is not None
    assert made.limits.violations == ()


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=NIGHTLY if n == "small bends, tight turns" else []) for n in CORNERS]
)
def test_what_random_attacks_found_arrives(name: str, tmp_path: Path) -> None:
    case = CORNERS[name]
    options = PlanOptions(**case["options"], dt_s=1e12)
    assert_holds(plan(*ends_of(case, tmp_path), swimmer=Swimmer(**case["swimmer"]), options=options))


@pytest.mark.parametrize("rate", [1e6, 1e-8])
def test_joints_as_fast_and_as_slow_as_is_allowed(rate: float) -> None:
    query = find_scenario("bent-goal")
    found = plan(query.start, query.goal, swimmer=Swimmer(joint_rate_rad_s=rate), options=QUICK)
    assert_holds(found)
    assert clock_step(found.duration_s) * rate < 1e-13


@pytest.mark.parametrize("bend", [0.08, pytest.param(0.05, marks=pytest.mark.slow)])
def test_small_bends(bend: float) -> None:
    roll = Configuration.from_angles((0.0, 0.0, 0.0), (0.0, 0.0, 30.0))
    assert_holds(plan(Configuration(), roll, swimmer=Swimmer(max_bend_rad=bend), options=QUICK))


@pytest.mark.slow
def test_a_stout_swimmer_rolls_within_its_bends() -> None:
    stout = Swimmer(limb_half_length_m=0.02, slenderness=0.1, drag_ratio=1.3, max_bend_rad=0.3)
    found = plan(
        Configuration(), Configuration.from_angles((0.0, 0.0, 0.0), (0.0, 0.0, 90.0)), swimmer=stout, options=QUICK
    )
    assert_holds(found)
    assert found.limits.largest_bend_rad[1] <= 0.3
