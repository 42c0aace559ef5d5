"""Gaits do what they are called and nothing else, for any swimmer; the printed sequences do what the table says."""

from __future__ import annotations

import dataclasses
import functools
import json
import math
from pathlib import Path

import numpy as np
import pytest
from helpers import assert_close, dop853_flow, in_lengths, is_close, mostly_slow, random_swimmer, read_table
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from purcell_cli.cli.app import _run
from purcell_cli.cli.reports.gait import gait_document
from purcell_cli.errors import GaitError, InputError, ParameterError, UnknownNameError
from purcell_cli.files.builtin import stored_gaits
from purcell_cli.files.gait_file import load_gait
from purcell_cli.gaits.gait import MOTIONS, Stroke, Turn, find
from purcell_cli.gaits.pure_stroke import realise
from purcell_cli.gaits.sampling import sample_stroke
from purcell_cli.geometry import se3
from purcell_cli.geometry.rotations import Array, angle_between
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.connection import COLLINEAR
from purcell_cli.mechanics.lift import flow
from purcell_cli.mechanics.primitives import PrimitiveSequence
from purcell_cli.mechanics.swimmer import Swimmer
from purcell_cli.motion.trajectory import as_table
from purcell_cli.verification.replay import replay
from purcell_cli.verification.verify import verify

PURE, CLOSED = 1e-10, 1e-12
PAPERS = Swimmer()
GAITS = stored_gaits()
NAMED = ("x-motion", "y-motion", "z-motion", "x-rotation", "y-rotation", "z-rotation", "x-cruise")
SOLVED = ("x-rotation", "y-rotation", "z-rotation", "x-cruise")
PAIRS = ("x-motion", "y-motion", "z-motion")
"""Gaits that are pure by symmetry, a loop and its mirror image: nothing is solved for."""
PRINTED = ("x", "y", "z", "psi", "theta", "phi")
AMPLITUDES = (0.05, 0.1, 0.25, 0.5, 0.75, 1.0)

OWN_GAIT = """
name: {name}
also: [wag]
summary: a wag of one limb
moves: none
amplitude: {{symbol: a, means: bend of limb 1, default_rad: 0.4}}
cycle:
  - limb1 yaw: a
  - limb1 yaw: -a
"""

NO_SOLUTION = """
name: hopeless
summary: a loop whose drift along y the roll of a straight limb cannot take back
moves: x
amplitude: {symbol: a, means: bend of each limb, default_rad: 1.0}
cycle:
  - limb2 yaw: a
  - limb1 yaw: a
  - limb2 yaw: -a
  - limb1 yaw: -a
  - limb1 roll: b
  - limb1 roll: -b
free:
  b: {guess: 0.5}
"""


@functools.cache
def swimmer_of(seed: int) -> Swimmer:
    """Return the paper's swimmer for 0, else a random one with a drag ratio of 1.2 to 4."""
    rng = np.random.default_rng(seed)
    return dataclasses.replace(random_swimmer(rng), drag_ratio=rng.uniform(1.2, 4.0)) if seed else PAPERS


def moved(swimmer: Swimmer, g: Array) -> Array:
    """Return a displacement in the order of `MOTIONS`: position over L, then roll, pitch, yaw by scipy. Shape (6,)."""
    return np.concatenate([g[:3, 3] / swimmer.length_m, Rotation.from_matrix(g[:3, :3]).as_euler("ZYX")[::-1]])


def along(name: str, swimmer: Swimmer, g: Array) -> tuple[float, float]:
    """Return the displacement along a gait's own axis, and the largest of the five others."""
    own = MOTIONS.index(GAITS[name].moves)
    six = moved(swimmer, g)
    return float(six[own]), float(np.max(np.abs(np.delete(six, own))))


def with_angles(stroke: Stroke, change: np.ufunc | functools.partial[Array]) -> Stroke:
    """Return a stroke with all its angles changed."""
    parts = {part: getattr(stroke, part) for part in ("approach", "cycle")}
    return dataclasses.replace(stroke, **{k: p.with_angles(change(p.angle)) for k, p in parts.items()})


def is_pure(name: str, swimmer: Swimmer, stroke: Stroke) -> bool:
    """Return whether a stroke closes and its twist is along its own axis alone; past a right angle of pitch too."""
    twist = se3.log(in_lengths(swimmer, stroke.displacement(swimmer)))
    others = np.delete(twist, MOTIONS.index(GAITS[name].moves))
    return bool(np.max(np.abs(others)) <= PURE) and stroke.closure_rad() <= CLOSED


# --- Pure strokes --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", mostly_slow(range(5), 1))
@pytest.mark.parametrize("name", NAMED)
def test_a_gait_moves_along_its_own_axis_alone_and_closes(name: str, seed: int) -> None:
    swimmer = swimmer_of(seed)
    for amplitude in AMPLITUDES:
        stroke = realise(GAITS[name], swimmer, amplitude)
        _, others = along(name, swimmer, stroke.displacement(swimmer))
        assert others <= PURE, f"cross-talk of {others:.2g} at {amplitude} rad"
        assert stroke.closure_rad() <= CLOSED
        assert_close(stroke.played().shapes(COLLINEAR)[-1], COLLINEAR, CLOSED)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("name", NAMED)
def test_a_gait_moves_forward_at_its_default_amplitude(name: str, seed: int) -> None:
    swimmer = swimmer_of(seed)
    own, _ = along(name, swimmer, realise(GAITS[name], swimmer).displacement(swimmer))
    assert own > 1e-4


@pytest.mark.parametrize("seed", [0, 3])
@pytest.mark.parametrize("name", SOLVED)
def test_a_gait_with_its_angles_rounded_to_four_digits_is_not_pure(name: str, seed: int) -> None:
    """The foil of purity: free angles that are nearly right are not enough."""
    swimmer = swimmer_of(seed)
    stroke = realise(GAITS[name], swimmer)
    assert is_pure(name, swimmer, stroke)
    assert not is_pure(name, swimmer, with_angles(stroke, functools.partial(np.round, decimals=4)))


@pytest.mark.parametrize("name", PAIRS)
def test_a_loop_without_its_mirror_image_is_not_pure(name: str) -> None:
    """The foil of purity for the gaits that are pure by symmetry."""
    stroke = realise(GAITS[name], PAPERS)
    assert is_pure(name, PAPERS, stroke)
    assert not is_pure(name, PAPERS, dataclasses.replace(stroke, cycle=stroke.cycle[:4]))


@pytest.mark.parametrize(("name", "seed"), [*((name, 0) for name in NAMED), ("x-rotation", 2), ("x-cruise", 4)])
def test_the_certificate_finds_a_gait_pure_too(name: str, seed: int) -> None:
    """Re-integrated by DOP853 from the sampled controls; the rounded stroke is found out again."""
    swimmer, start = swimmer_of(seed), Configuration()
    stroke = realise(GAITS[name], swimmer)
    rounded = with_angles(stroke, functools.partial(np.round, decimals=4))
    ends = []
    for played in (stroke, rounded):
        trajectory = sample_stroke(swimmer, start, played, 1)
        ends.append(replay(swimmer, start, trajectory.time_s, trajectory.rate_rad_s).end)
    own, others = along(name, swimmer, ends[0].pose)
    assert own > 1e-4
    assert others <= PURE
    assert_close(ends[0].shape, COLLINEAR, CLOSED)
    if name in SOLVED:
        assert along(name, swimmer, ends[1].pose)[1] > PURE


@pytest.mark.parametrize("name", ["y-rotation", "x-rotation"])
def test_the_plain_equations_of_motion_find_a_gait_pure_too(name: str) -> None:
    """Integrated in the world, limbs and all, by code that shares only the connection."""
    swimmer = swimmer_of(1)
    stroke = realise(GAITS[name], swimmer, 0.6)
    own, others = along(name, swimmer, dop853_flow(swimmer, stroke.played()))
    assert own > 1e-4
    assert others <= PURE


@pytest.mark.slow
@settings(max_examples=25, deadline=None, derandomize=True)
@given(name=st.sampled_from(NAMED), amplitude=st.floats(0.01, math.pi))
def test_at_any_amplitude_a_gait_is_pure_or_says_that_it_cannot_be(name: str, amplitude: float) -> None:
    try:
        stroke = realise(GAITS[name], PAPERS, amplitude)
    except GaitError:
        return
    assert is_pure(name, PAPERS, stroke)


@pytest.mark.slow
@pytest.mark.parametrize("limb", [0.2, 0.3])
def test_a_thin_swimmer_with_long_limbs_has_an_x_rotation_at_its_default_amplitude(limb: float) -> None:
    """Newton's method must find it from the stored guesses: it exists, a little way from them."""
    swimmer = Swimmer(base_half_length_m=0.1, limb_half_length_m=limb, slenderness=0.003, drag_ratio=3.0)
    for amplitude in np.linspace(0.8, 1.1, 16):
        assert is_pure("x-rotation", swimmer, realise(GAITS["x-rotation"], swimmer, float(amplitude)))


# --- What each of them does ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "per_length"), [("x-motion", 0.114731120), ("y-motion", 0.059771146)])
def test_the_pairs_of_loops_have_their_known_displacement(name: str, per_length: float) -> None:
    own, _ = along(name, PAPERS, realise(GAITS[name], PAPERS, 1.0).displacement(PAPERS))
    assert_close(own, per_length, 1e-9)


@pytest.mark.parametrize(("planar", "rolled"), [("y-motion", "z-motion"), ("z-rotation", "y-rotation")])
@pytest.mark.parametrize("seed", [0, 5])
def test_a_pitch_gait_is_the_yaw_gait_rolled_by_a_quarter_turn(planar: str, rolled: str, seed: int) -> None:
    swimmer = swimmer_of(seed)
    for amplitude in (0.2, 0.8):
        found = [
            along(name, swimmer, realise(GAITS[name], swimmer, amplitude).displacement(swimmer))[0]
            for name in (planar, rolled)
        ]
        assert_close(found[0], found[1], 1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 4])
def test_x_rotation_rolls_by_exactly_its_amplitude(seed: int) -> None:
    swimmer = swimmer_of(seed)
    for amplitude in (0.01, 0.05, 0.3, math.radians(30), 0.9):
        own, _ = along("x-rotation", swimmer, realise(GAITS["x-rotation"], swimmer, amplitude).displacement(swimmer))
        assert_close(own, amplitude, 1e-12)
    slack = with_angles(realise(GAITS["x-rotation"], swimmer, 0.9), functools.partial(np.multiply, 1 + 1e-9))
    assert not is_close(along("x-rotation", swimmer, slack.displacement(swimmer))[0], 0.9, 1e-12)


@pytest.mark.parametrize(("roll", "most"), [(1.0, 0.60), (math.radians(30), 0.371)])
def test_rolling_costs_little_joint_travel(roll: float, most: float) -> None:
    travel = realise(GAITS["x-rotation"], PAPERS, roll).played().joint_travel_rad
    assert 0.0 < travel <= most


@pytest.mark.parametrize("name", NAMED)
def test_a_negative_amplitude_makes_the_inverse_displacement(name: str) -> None:
    swimmer = swimmer_of(2)
    there, back = (realise(GAITS[name], swimmer, a) for a in (0.7, -0.7))
    assert back.amplitude_rad == -there.amplitude_rad == -0.7
    assert back.played().joint_travel_rad == there.played().joint_travel_rad
    both = there.displacement(swimmer) @ back.displacement(swimmer)
    assert_close(in_lengths(swimmer, both), np.eye(4), 1e-12)
    twice = there.displacement(swimmer) @ there.displacement(swimmer)
    assert not is_close(in_lengths(swimmer, twice), np.eye(4), 1e-12)
    sequences = there.played() + back.played()
    assert_close(in_lengths(swimmer, flow(swimmer, sequences)), np.eye(4), 1e-12)


@pytest.mark.parametrize("name", NAMED)
def test_a_gait_does_the_same_for_every_size_fluid_and_pace(name: str) -> None:
    swimmer = swimmer_of(1)
    other = dataclasses.replace(
        swimmer,
        base_half_length_m=3.7 * swimmer.base_half_length_m,
        limb_half_length_m=3.7 * swimmer.limb_half_length_m,
        viscosity_pa_s=41.0 * swimmer.viscosity_pa_s,
        joint_rate_rad_s=5.0,
    )
    thicker = dataclasses.replace(swimmer, drag_ratio=swimmer.drag_ratio + 0.5)
    found, same, foil = (moved(s, realise(GAITS[name], s, 0.6).displacement(s)) for s in (swimmer, other, thicker))
    assert_close(found, same, 1e-11)
    assert GAITS[name].amplitude_is_displacement or not is_close(found, foil, 1e-6)


@pytest.mark.parametrize("name", NAMED)
def test_a_thousand_cycles_are_a_thousand_displacements_one_after_the_other(name: str) -> None:
    swimmer = swimmer_of(3)
    stroke = realise(GAITS[name], swimmer, 0.8)
    once = in_lengths(swimmer, stroke.displacement(swimmer))
    composed = np.eye(4)
    for _ in range(1000):
        composed = composed @ once
    found = in_lengths(swimmer, stroke.displacement(swimmer, 1000))
    scale = max(1.0, float(np.max(np.abs(found))))
    assert_close(found, composed, 1e-9, scale)
    assert not is_close(in_lengths(swimmer, stroke.displacement(swimmer, 999)), composed, 1e-9, scale)


@pytest.mark.parametrize("name", ["x-cruise", "x-rotation"])
def test_cycles_are_what_the_flow_of_all_their_primitives_is(name: str) -> None:
    stroke = realise(GAITS[name], PAPERS)
    wanted = flow(PAPERS, stroke.played(40))
    assert_close(in_lengths(PAPERS, stroke.displacement(PAPERS, 40)), in_lengths(PAPERS, wanted), 1e-11)


@pytest.mark.parametrize("approach", [(), (Turn(1, {"": 0.3}),)], ids=["straight", "bent first"])
def test_a_cycle_that_does_not_close_goes_on_from_where_it_left_the_limbs(approach: tuple[Turn, ...]) -> None:
    """Limbs that jump back between the cycles are the foil. The rows replay, and end where all primitives end."""
    turns = Turn(2, {"a": 1.0}), Turn(4, {"a": 0.5}), Turn(0, {"a": 1.0})
    gait = dataclasses.replace(GAITS["x-motion"], name="open", moves="none", symbol="a", approach=approach, cycle=turns)
    stroke = realise(gait, PAPERS, 0.2)
    whole = stroke.played(3)
    wanted = flow(PAPERS, whole)
    found = stroke.displacement(PAPERS, 3)
    assert_close(in_lengths(PAPERS, found), in_lengths(PAPERS, wanted), 1e-12)
    once = flow(PAPERS, stroke.played())
    assert not is_close(in_lengths(PAPERS, np.linalg.matrix_power(once, 3)), in_lengths(PAPERS, wanted), 1e-2)
    rows = sample_stroke(PAPERS, Configuration(), stroke, 3)
    assert_close(rows.end.shape, whole.shapes(COLLINEAR)[-1], 1e-12)
    assert verify([as_table(rows)], Configuration(), rows.end, PAPERS, 1e-9, 1e-9).holds
    document = gait_document(gait, stroke, PAPERS, 3, None)
    assert document["displacement"]["y_m"] == found[1, 3]
    assert_close(document["closure_rad"], float(np.max(angle_between(COLLINEAR, rows.end.shape))), 1e-12)


def test_a_pitch_past_a_right_angle_is_reported_as_pure() -> None:
    gait = GAITS["y-rotation"]
    document = gait_document(gait, realise(gait, PAPERS, 2.5), PAPERS, 1, None)
    assert document["cross_talk"] <= PURE


@pytest.mark.parametrize("amplitude", [0.0, -0.0, math.nan, math.inf, -math.inf, 3.15, -4.0])
def test_an_amplitude_that_is_no_angle_is_refused(amplitude: float) -> None:
    with pytest.raises(ParameterError, match="amplitude: an angle other than 0 and at most pi is wanted, found"):
        realise(GAITS["x-motion"], PAPERS, amplitude)


# --- Names ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("other", "name"),
    [("roll", "x-rotation"), ("pitch", "y-rotation"), ("yaw", "z-rotation"), ("cruise", "x-cruise")],
)
def test_a_gait_is_found_by_its_other_name(other: str, name: str) -> None:
    assert find(GAITS, other) is find(GAITS, name) is GAITS[name]


@pytest.mark.parametrize(
    ("typed", "nearest"),
    [
        ("z-mtion", "z-motion"),
        ("x_rotation", "x-rotation"),
        ("crusie", "cruise"),
        ("Yaw", "yaw"),
        ("printed_x", "printed-x"),
    ],
)
def test_an_unknown_name_proposes_the_nearest(typed: str, nearest: str) -> None:
    with pytest.raises(UnknownNameError, match=rf"no gait is called '{typed}'; did you mean '{nearest}'\?"):
        find(GAITS, typed)


@pytest.mark.parametrize("typed", ["012345", "mygait", "foo"])
def test_a_name_like_nothing_proposes_the_list(typed: str) -> None:
    with pytest.raises(UnknownNameError, match=rf"no gait is called '{typed}'.*--list") as caught:
        find(GAITS, typed)
    assert "did you mean" not in str(caught.value)


DESIGNED = ("turn-across", "turn-planar", "x-fold", "x-loop", "y-across")
FOUND = ("max-displacement", "max-efficiency", *DESIGNED)


def test_the_package_has_the_gaits_it_promises() -> None:
    assert set(GAITS) == {*NAMED, *FOUND, *(f"printed-{p}" for p in PRINTED)}
    assert all(name == gait.name for name, gait in GAITS.items())
    assert [GAITS[name].moves for name in NAMED] == [*MOTIONS, "x"]


# --- The paper's printed sequences ---------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "row", read_table("printed_sequences.csv"), ids=lambda r: f"{r['printed_sequence']}-{r['amplitude_rad']}"
)
def test_the_printed_sequences_do_what_the_table_says(row: dict[str, str]) -> None:
    stroke = realise(GAITS[f"printed-{row['printed_sequence']}"], PAPERS, float(row["amplitude_rad"]))
    columns = ("dx_over_L", "dy_over_L", "dz_over_L", "phi_rad", "theta_rad", "psi_rad")
    wanted = [float(row[c]) for c in columns]
    assert_close(moved(PAPERS, stroke.displacement(PAPERS)), wanted, 1e-10)


def test_the_rightmost_printed_flow_acts_first() -> None:
    """The foil: read from the left, the line for x misses the table; the others read the same both ways."""
    rows = read_table("printed_sequences.csv")
    row = next(r for r in rows if r["printed_sequence"] == "x" and r["amplitude_rad"] == "1.0")
    cycle = realise(GAITS["printed-x"], PAPERS, 1.0).cycle
    turned = flow(PAPERS, PrimitiveSequence(cycle.control[::-1], cycle.angle[::-1]))
    wanted = [float(row[c]) for c in ("dx_over_L", "dy_over_L", "dz_over_L", "phi_rad", "theta_rad", "psi_rad")]
    assert not is_close(moved(PAPERS, turned), wanted, 1e-10)


@pytest.mark.parametrize("letter", PRINTED)
def test_the_printed_phi_leaves_a_limb_rolled_and_the_others_close(letter: str) -> None:
    stroke = realise(GAITS[f"printed-{letter}"], PAPERS, 0.7)
    assert_close(stroke.closure_rad(), 0.7 if letter == "phi" else 0.0, CLOSED)


@pytest.mark.parametrize("letter", ["x", "y", "z"])
def test_the_printed_translations_are_not_pure(letter: str) -> None:
    """What the project's own gaits are for."""
    six = np.abs(moved(PAPERS, realise(GAITS[f"printed-{letter}"], PAPERS).displacement(PAPERS)))
    assert np.count_nonzero(six > 1e-4) >= 2


# --- A user's own gaits --------------------------------------------------------------------------------------------


def test_a_gait_of_ones_own_is_played_by_its_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "own").mkdir()
    (tmp_path / "own" / "file.yaml").write_text(OWN_GAIT.format(name="wiggle"))
    monkeypatch.chdir(tmp_path)
    for name in ("wiggle", "wag"):
        assert _run(["gait", name, "--gaits", "own", "--json"]) == 0
        document = json.loads(capsys.readouterr().out)
        assert document["gait"] == "wiggle"
        assert document["amplitude_rad"] == 0.4
        assert document["cycle"] == [
            {"control": "limb1 yaw", "angle_rad": 0.4},
            {"control": "limb1 yaw", "angle_rad": -0.4},
        ]
        assert_close(list(document["displacement"].values()), np.zeros(6), 1e-15)
    assert (tmp_path / "wiggle.csv").is_file()
    assert _run(["gait", "wiggle"]) == 2


def test_a_gait_of_ones_own_takes_the_place_of_the_stored_one(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(OWN_GAIT.format(name="x-motion"))
    found = stored_gaits(tmp_path)
    assert found["x-motion"].summary == "a wag of one limb"
    assert set(found) == set(GAITS)
    assert GAITS["x-motion"].summary != found["x-motion"].summary


def test_two_gaits_of_one_name_in_one_folder_are_refused(tmp_path: Path) -> None:
    for file in ("a.yaml", "b.yaml"):
        (tmp_path / file).write_text(OWN_GAIT.format(name="wiggle"))
    with pytest.raises(InputError, match=r"b\.yaml: wanted a name of its own, found 'wiggle', which .*a\.yaml has"):
        stored_gaits(tmp_path)


def test_a_folder_of_gaits_that_is_none_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    for path in (tmp_path / "missing", tmp_path / "file"):
        with pytest.raises(InputError, match="wanted a folder of gait files, found none"):
            stored_gaits(path)
    (tmp_path / "gaits").mkdir()
    with pytest.raises(InputError, match=r"found no \.yaml or \.yml file there"):
        stored_gaits(tmp_path / "gaits")
    (tmp_path / "gaits" / "a.yml").write_text(OWN_GAIT.format(name="wiggle"))
    assert "wiggle" in set(stored_gaits(tmp_path / "gaits"))
    for text, told in (("base: {position_m: [0, 0, 0]}\n", True), ("name: a\ncycle: 3\n", False), ("a: [", False)):
        (tmp_path / "gaits" / "b.yaml").write_text(text)
        with pytest.raises(InputError) as caught:
            stored_gaits(tmp_path / "gaits")
        assert ("gaits want a folder of their own" in str(caught.value)) == told


@pytest.mark.slow
def test_a_gait_whose_free_angles_have_no_solution_says_so(tmp_path: Path) -> None:
    (tmp_path / "hopeless.yaml").write_text(NO_SOLUTION)
    gait = load_gait(tmp_path / "hopeless.yaml")
    for amplitude in (None, -0.3):
        with pytest.raises(GaitError, match="gait 'hopeless' has no pure stroke at amplitude"):
            realise(gait, PAPERS, amplitude)
    turned = dataclasses.replace(gait, moves="none", free={})
    with pytest.raises(KeyError, match="b"):
        realise(turned, PAPERS)


def test_a_sequence_that_is_only_played_needs_no_solution(tmp_path: Path) -> None:
    (tmp_path / "g.yaml").write_text(OWN_GAIT.format(name="wiggle"))
    stroke = realise(load_gait(tmp_path / "g.yaml"), PAPERS, 0.9)
    assert list(stroke.cycle) == [("limb1 yaw", 0.9), ("limb1 yaw", -0.9)]
    assert stroke.closure_rad() <= 1e-15
