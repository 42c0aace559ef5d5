"""The explanation of a plan says what its strokes do, what is left after them, and what limits them."""

from __future__ import annotations

import dataclasses
import functools
import io
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from helpers import assert_close, mostly_slow, random_sequence, random_shapes
from rich.console import Console

from purcell_cli import Configuration, PrimitiveSequence, Swimmer, plan, realise, stored_gaits, stored_scenarios
from purcell_cli.cli.app import _run
from purcell_cli.cli.reports.common import as_json
from purcell_cli.cli.reports.explanation import explanation_document, show_explanation
from purcell_cli.cli.reports.plan import plan_document
from purcell_cli.explanation import Explanation, explain, in_words, largest_bend
from purcell_cli.files.scenario_file import load_scenario
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import from_euler
from purcell_cli.motion.blocks import Block
from purcell_cli.motion.plan import Plan, Structure
from purcell_cli.solution import Solution, carried_out

DISPLACEMENT_KEYS = {"position_m", "psi_rad", "theta_rad", "phi_rad"}
STROKE_KEYS = {
    *(
        "phase",
        "gait",
        "description",
        "cycles",
        "joint_travel_rad",
        "energy_j",
        "missing",
        "largest_bend_rad",
        "limits",
    ),
}
SENSITIVITY_KEYS = {"parameter", "change", "position_m", "position_over_L", "angle_rad", "largest_part"}
STRUCTURES = (Structure("roll and swim", 12.5), Structure("swim sideways", 14.0), Structure("turn, then swim", 20.0))


@functools.cache
def solution(name: str) -> Solution:
    scenario = load_scenario(stored_scenarios()[name])
    return plan(scenario.start, scenario.goal, swimmer=scenario.swimmer)


@functools.cache
def explanation(name: str) -> Explanation:
    return explain(solution(name))


def played(*steps: tuple[str, float], swimmer: Swimmer | None = None, cycles: int = 1) -> Explanation:
    """Return the explanation of one stroke from the collinear shape."""
    block = Block(2, "own", PrimitiveSequence.of(steps), cycles)
    return explain(carried_out(Plan(swimmer or Swimmer(), Configuration(), Configuration(), (block,))))


def shown(document: dict[str, Any], width: int) -> str:
    """Return what a person reads in a terminal of a width."""
    out = io.StringIO()
    show_explanation(Console(file=out, width=width, highlight=False), document)
    return out.getvalue()


def told(made: Solution, found: Explanation) -> dict[str, Any]:
    """Return a plan's document with an explanation."""
    return {**plan_document(made, "x.csv"), "explanation": explanation_document(found, made.plan.swimmer)}


# --- What is left after a stroke ------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.parametrize("name", ["nearby", "bent-goal", "far"])
def test_what_is_missing_leads_to_where_phase_two_must_end(name: str) -> None:
    """From the rows of the trajectory: the pose after a stroke, moved by what is missing, is where it must lead."""
    rows, found = solution(name).trajectory, explanation(name)
    ends = np.cumsum([s.joint_travel_rad for s in found.strokes]) / solution(name).plan.swimmer.joint_rate_rad_s
    last = np.flatnonzero(rows.phase == 3)
    targets = {2: rows.pose[last[0] if len(last) else -1], 3: rows.pose[-1]}
    for stroke, time in zip(found.strokes, ends, strict=True):
        end = int(np.argmin(np.abs(rows.time_s - time)))
        assert_close(rows.time_s[end], time, 1e-9, float(time))
        target = targets[3 if stroke.phase == 3 else 2]
        assert_close(rows.pose[end] @ stroke.missing, target, 1e-11, 10.0)
    assert_close(found.strokes[-1].missing, np.eye(4), 1e-10)
    assert found.strokes[0].missing[:3, 3].any()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["nearby", "far"])
def test_the_strokes_are_those_of_the_plans_table(name: str) -> None:
    document = plan_document(solution(name), None)
    listed = [(p["phase"], s) for p in document["phases"] for s in p["strokes"]]
    for (phase, wanted), found in zip(listed, explanation(name).strokes, strict=True):
        assert (phase, wanted["gait"], wanted["cycles"]) == (found.phase, found.gait, found.cycles)
        assert math.isclose(wanted["joint_travel_rad"], found.joint_travel_rad)
        assert math.isclose(wanted["energy_j"], found.energy_j)


# --- Words ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("way_mm", "turn_deg", "words"),
    [
        ([0, 0, 0], [0, 0, 0], "goes nowhere"),
        ([1e-8, 0, 0], [0, 0, 0], "goes nowhere"),
        ([-2.3349, 0, 0], [0, 0, 0], "moves 2.33 mm along -x"),
        ([2000, 0, 0], [0, 0, 0], "moves 2000 mm along x"),
        ([0, 0, 0], [0, 0, -19.13], "rolls by -19.1 deg"),
        ([3, 0, -4], [1, 0, 0], "moves 3 mm along x and 4 mm along -z and yaws by 1 deg"),
        ([100, 0, 2], [0, 0, 0], "mainly moves 100 mm along x"),
        ([100, 0, 0.9], [0, 0, 0], "moves 100 mm along x"),
        ([0, 0, 0], [10, 20, 30], "yaws by 10 deg, pitches by 20 deg and rolls by 30 deg"),
    ],
)
def test_a_displacement_in_words(way_mm: list[float], turn_deg: list[float], words: str) -> None:
    pose = se3.pose(from_euler(np.radians(turn_deg)), np.multiply(way_mm, 1e-3))
    assert in_words(pose, 0.1) == words


# --- Limits ---------------------------------------------------------------------------------------------------------


def test_the_largest_bend_is_that_of_a_fine_sampling() -> None:
    """Also where a limb passes the far side of the circle it sweeps; the ends alone would miss that."""
    rng = np.random.default_rng(3)
    ends_only = 0
    for shape in random_shapes(rng, 60):
        sequence = random_sequence(rng, 4, 3.0)
        fine = np.repeat(sequence.control, 400), np.repeat(sequence.angle / 400.0, 400)
        axes = PrimitiveSequence(*fine).shapes(shape)[..., 0]
        wanted = float(np.max(np.arccos(np.clip(axes[..., 0], -1.0, 1.0))))
        assert_close(largest_bend(sequence, shape), wanted, 4e-3)  # half a sample, where a limb folds back
        ends = sequence.shapes(shape)[..., 0, 0]
        ends_only += wanted - float(np.max(np.arccos(ends))) > 5e-2
    assert ends_only > 5


@pytest.mark.parametrize(
    ("bend", "limits"),
    [
        (1.0, ("bend limit",)),
        (1.0 - 1.9e-4, ("bend limit",)),
        (1.0 - 2.4e-4, ("bend limit",)),
        (1.0 - 1e-3, ()),
        (0.4, ()),
    ],
)
def test_a_stroke_at_the_bend_limit_says_so(bend: float, limits: tuple[str, ...]) -> None:
    (stroke,) = played(("limb1 yaw", bend), ("limb2 pitch", 0.3)).strokes
    assert stroke.limits == limits
    assert math.isclose(stroke.largest_bend_rad, bend, rel_tol=1e-12)
    assert played(("limb1 yaw", bend), swimmer=Swimmer(max_bend_rad=2.0)).strokes[0].limits == ()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["along-x", "half-turn", "yaw"])
def test_loops_of_a_plan_that_bend_as_far_as_they_may_are_limited_by_that(name: str) -> None:
    """The planner keeps a margin; a margin of the explanation's own, a hundredth of it, saw none of them: the foil."""
    found = explanation(name)
    bends = [s.largest_bend_rad for s in found.strokes]
    at_it = [s.limits == ("bend limit",) for s in found.strokes]
    assert at_it == [bend > solution(name).plan.swimmer.max_bend_rad - 5e-4 for bend in bends]
    assert any(at_it)
    assert not any(abs(bend - 1.0) <= 1e-6 for bend in bends)


@pytest.mark.slow
def test_what_would_have_taken_less_joint_travel_says_why_it_was_not_taken() -> None:
    """How such a reason comes about, the planner's own tests tell; of a plan's others, none is told that took more."""
    found = solution("limb-rolls")
    taken, *others = found.plan.structures
    assert not any(s.why_not for s in others if s.joint_travel_rad >= taken.joint_travel_rad)
    less = Structure("three loops", 0.9 * taken.joint_travel_rad, "misses the goal by 1.0e-02 L or rad")
    known = dataclasses.replace(found, plan=dataclasses.replace(found.plan, structures=(taken, less, *others)))
    text = " ".join(shown(told(known, explain(known)), 240).split())
    assert f"three loops; not taken: it {less.why_not}" in text


# --- What is sensitive -----------------------------------------------------------------------------------------------


def aimed(way: int) -> tuple[Explanation, list[str]]:
    """Return the explanation of a roll, a yaw and a long way along x of some cycles, and its strokes' names."""
    parts = [("x-rotation", 0.5, 1), ("z-rotation", 0.9, 6), ("x-cruise", 1.0, way)]
    blocks = []
    for name, amplitude, cycles in parts:
        stroke = realise(stored_gaits()[name], Swimmer(), amplitude)
        into, out = stroke.approach, stroke.approach.inverse()
        blocks += [
            Block(2, name, sequence, count, amplitude)
            for sequence, count in ((into, 1), (stroke.cycle, cycles), (out, 1))
            if len(sequence)
        ]
    found = explain(carried_out(Plan(Swimmer(), Configuration(), Configuration(), tuple(blocks))))
    return found, [s.gait for s in found.strokes]


def test_a_roll_stroke_a_long_way_and_an_aim_are_named_as_sensitive() -> None:
    found, names = aimed(60)
    assert names == ["x-rotation", "z-rotation", "x-cruise"]
    culprits = {s.parameter: c for s, c in zip(found.sensitivities, found.culprits, strict=True)}
    crank, turn, way = (culprits[p] for p in ("slenderness", "base_half_length_m", "drag_ratio"))
    assert (crank.stroke, turn.stroke, way.stroke) == (0, 1, 2)
    assert crank.words.startswith("it rolls with nearly straight limbs, where little resists a roll; it sets the dir")
    assert turn.words.startswith(
        "the error of one cycle adds up over 6 cycles; it sets the direction of a displacement of 2"
    )
    assert way.words == "the error of one cycle adds up over 60 cycles"
    assert 0.5 < way.share < 1.0


def test_one_cycle_and_no_way_to_go_are_not_called_sensitive() -> None:
    found, _ = aimed(1)
    culprits = {s.parameter: c for s, c in zip(found.sensitivities, found.culprits, strict=True)}
    assert (culprits["drag_ratio"].stroke, culprits["drag_ratio"].words) == (2, "")
    assert culprits["slenderness"].words == "it rolls with nearly straight limbs, where little resists a roll"


def test_a_roll_does_not_aim_a_way_along_its_own_axis() -> None:
    strokes = [realise(stored_gaits()[name], Swimmer(), 1.0) for name in ("x-rotation", "x-cruise")]
    parts = [
        (strokes[0].cycle, 1),
        (strokes[1].approach, 1),
        (strokes[1].cycle, 60),
        (strokes[1].approach.inverse(), 1),
    ]
    names = ["x-rotation", "x-cruise", "x-cruise", "x-cruise"]
    blocks = tuple(Block(2, name, sequence, n) for name, (sequence, n) in zip(names, parts, strict=True))
    found = explain(carried_out(Plan(Swimmer(), Configuration(), Configuration(), blocks)))
    crank = found.culprits[0]
    assert crank.stroke == 0
    assert "direction" not in crank.words


def test_slenderness_has_no_part_in_a_planar_motion() -> None:
    """Its logarithm scales all drag alike but for spin; the stroke of no effect is nobody's."""
    found = played(("limb1 yaw", 1.0), ("limb2 yaw", 1.0), ("limb1 yaw", -1.0), ("limb2 yaw", -1.0), cycles=3)
    assert [c is None for c in found.culprits] == [True, False, False, False]
    assert found.sensitivities[0].position_m < 1e-12


# --- What is printed ------------------------------------------------------------------------------------------------


def test_an_explanation_has_exactly_its_keys() -> None:
    made = solution("unequal-links")
    document = told(made, dataclasses.replace(explanation("unequal-links"), structures=STRUCTURES))["explanation"]
    assert json.loads(as_json(document)) == document
    assert set(document) == {"strokes", "structures", "sensitivity", "on_beads"}
    assert set(document["on_beads"]) == {"position_m", "position_over_L", "angle_rad", "why_not"}
    assert all(set(s) == STROKE_KEYS for s in document["strokes"])
    assert all(set(s["missing"]) == DISPLACEMENT_KEYS | {"position_over_L", "angle_rad"} for s in document["strokes"])
    assert all(set(s) == SENSITIVITY_KEYS for s in document["sensitivity"])
    assert all(set(s["largest_part"]) == {"stroke", "share", "description"} for s in document["sensitivity"])
    assert document["structures"] == [
        {"description": s.words, "joint_travel_rad": s.joint_travel_rad, "why_not": ""} for s in STRUCTURES
    ]


@pytest.mark.parametrize("width", [80, 128])
@pytest.mark.parametrize("name", mostly_slow(["unequal-links", "far", "nearby"], 2))
def test_the_tables_fit_and_cut_nothing_short(name: str, width: int) -> None:
    text = shown(told(solution(name), dataclasses.replace(explanation(name), structures=STRUCTURES)), width)
    assert "…" not in text
    assert max(len(line) for line in text.splitlines()) <= width
    for words in (
        "Stroke by stroke",
        "runner-up",
        "1.5000 (12 %)",
        "1 % off",
        "drag ratio",
        "viscosity: none",
        "it would end",
    ):
        assert words in text


def test_structures_are_shown_only_where_they_are_known() -> None:
    made, found = solution("unequal-links"), explanation("unequal-links")
    assert "runner-up" not in shown(told(made, dataclasses.replace(found, structures=())), 128)
    many = tuple(Structure(f"way {k}", 10.0 + k) for k in range(9))
    text = shown(told(made, dataclasses.replace(found, structures=many)), 128)
    assert "way 4" in text
    assert "way 5" not in text
    assert "and 4 more" in text


@pytest.mark.slow
def test_the_commands_explain_when_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)

    def out(*arguments: str) -> str:
        assert _run(list(arguments)) == 0
        shown = capsys.readouterr()
        assert shown.err == ""
        return shown.out

    plain, full = out("plan", "along-x", "--plan-out", "p.json"), out("plan", "along-x", "--explain")
    assert full.startswith(plain.removesuffix("plan in p.json\n"))
    assert "Stroke by stroke" in full
    assert "Stroke by stroke" in out("run", "p.json", "--explain")
    documents = [json.loads(out(*c, "--json", "--explain")) for c in (["plan", "along-x"], ["run", "p.json"])]
    weighed = [d["explanation"].pop("structures") for d in documents]
    assert weighed[0]
    assert weighed[1] == []  # a document holds the plan, not what else was weighed
    assert documents[0]["explanation"] == documents[1]["explanation"]
    assert "explanation" not in json.loads(out("plan", "along-x", "--json"))
    (tmp_path / "here.yaml").write_text("{}")
    assert "nothing to explain" in out("plan", "here.yaml", "here.yaml", "--explain")
    nothing = json.loads(out("plan", "here.yaml", "here.yaml", "--explain", "--json"))["explanation"]
    assert (nothing["strokes"], [s["position_m"] for s in nothing["sensitivity"]]) == ([], [0.0] * 4)
