"""The YAML files: what they may say, and that whatever else they say is one clear error, with little work."""

from __future__ import annotations

import dataclasses
import importlib.util
import io
import math
import os
import re
import socket
import string
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import yaml
from helpers import calls
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

import purcell_cli
from purcell_cli.errors import InputError, PurcellWarning
from purcell_cli.files.configuration_file import load_configuration, load_goal
from purcell_cli.files.gait_file import load_gait
from purcell_cli.files.linear_expression import linear_terms
from purcell_cli.files.scenario_file import SCHEMAS, Expect, Scenario, load_scenario, warn_if_far
from purcell_cli.files.swimmer_file import load_swimmer
from purcell_cli.gaits.gait import Guess, Turn
from purcell_cli.geometry import rotations
from purcell_cli.mechanics.configuration import Configuration
from purcell_cli.mechanics.swimmer import LIMITS, Swimmer
from purcell_cli.motion.mission import Waypoint
from purcell_cli.motion.workspace import Workspace

GAIT = """\
name: x-rotation
also: [roll]
summary: rolls about the long axis by a crank of limb 1
moves: roll
amplitude: {symbol: a, means: angle of roll, default_rad: 0.5, is_displacement: true}
source: "text"
approach:
  - limb1 yaw: b
cycle:
  - limb1 yaw: -a
  - limb2 yaw: 2 a
  - limb1 pitch: a - 0.5*p + 1e-3
free:
  b: {guess: 0.65}
  p: {guess: {amplitude_rad: [0.05, 1.0], value: [0.07, 0.35], sharpness_power: 1}}
"""
SCENARIO = """\
name: out-and-back_1.5
start: {}
goal: {base: {position_m: [0.1, 0, 0]}}
"""
MEBIBYTE = 1 << 20
MOST_CALLS = 2_000_000
"""The work that a refusal may take, however bad or large the file is."""
floats = st.floats(allow_nan=False, allow_infinity=False)
reuse_folder = settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)


def written(folder: Path, text: str | bytes, name: str = "file.yaml") -> Path:
    path = folder / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


def fault(path: Path | str, load: str = "load_configuration") -> str:
    """Return the message of the InputError that loading raises, with the file's name taken off."""
    told: list[str] = []

    def loaded() -> None:
        with pytest.raises(InputError) as caught:
            getattr(purcell_cli, load)(path)
        told.append(str(caught.value))

    assert calls(loaded) < MOST_CALLS
    (text,) = told
    assert "\n" not in text
    assert len(text) < 600 + len(str(path))
    return text.removeprefix(f"{path}:")


def refusal(path: Path, load: Callable[[Path], object]) -> str:
    """Return the message of the InputError that loading raises, "" if it raises none."""
    try:
        load(path)
    except InputError as error:
        return str(error)
    return ""


def assert_fault(
    folder: Path, text: str | bytes, line: int, key: str, *parts: str, load: str = "configuration"
) -> None:
    """Check that a bad file is reported with its line, its key, what was wanted and what was found."""
    path = written(folder, text)
    found = fault(path, f"load_{load}")
    assert found.startswith(f"{line}: {key}: wanted "), found
    assert ", found " in found
    for part in parts:
        assert part in found


# Configurations


def test_empty_mapping_is_the_collinear_configuration_at_the_origin(tmp_path: Path) -> None:
    found = load_configuration(written(tmp_path, "{}"))
    assert np.array_equal(found.pose, np.eye(4))
    assert np.array_equal(found.shape, np.stack([np.eye(3)] * 2))


def test_the_forms_of_an_orientation_say_the_same(tmp_path: Path) -> None:
    wanted = Configuration.from_angles([0.1, -0.2, 3.0], [30, -20, 50], [10, 20, 30], [-40, 5, 6])
    base, limb1, limb2 = wanted.pose[:3, :3], *wanted.shape
    text = f"""\
base: {{position_m: [0.1, -2e-1, 3], orientation: {{euler_rad: {rotations.as_euler(base).tolist()}}}}}
limb1: {{quaternion_wxyz: {rotations.as_quaternion(limb1).tolist()}}}
limb2:
  matrix: {limb2.tolist()}
"""
    found = load_configuration(written(tmp_path, text))
    assert np.allclose(found.pose, wanted.pose, rtol=0, atol=1e-14)
    assert np.allclose(found.shape, wanted.shape, rtol=0, atol=1e-14)
    degrees = load_configuration(written(tmp_path, "limb1: {euler_deg: [10, 20, 30]}"))
    assert np.allclose(degrees.shape[0], limb1, rtol=0, atol=1e-14)
    assert not np.allclose(degrees.shape[0], rotations.from_euler(np.radians([30, 20, 10])), atol=1e-3)


@pytest.mark.parametrize("off", [0.0, 9e-7, -9e-7])
def test_a_quaternion_within_a_millionth_is_normalised(tmp_path: Path, off: float) -> None:
    text = f"limb1: {{quaternion_wxyz: [{0.6 * (1 + off)!r}, 0, {0.8 * (1 + off)!r}, 0]}}"
    limb = load_configuration(written(tmp_path, text)).shape[0]
    assert np.allclose(limb, rotations.from_quaternion([0.6, 0, 0.8, 0]), rtol=0, atol=1e-15)


def test_a_matrix_within_a_millionth_is_normalised(tmp_path: Path) -> None:
    text = "limb1: {matrix: [[1.0000009, 0, 0], [0, 1, 0], [0, 0, 0.9999991]]}"
    limb = load_configuration(written(tmp_path, text)).shape[0]
    assert np.allclose(limb, np.eye(3), rtol=0, atol=1e-15)


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("quaternion_wxyz: [0, 0, 0, 0]", "length 0"),
        ("quaternion_wxyz: [1.0101, 0, 0, 0]", "length 1.0101"),
        ("quaternion_wxyz: [0.9899, 0, 0, 0]", "length 0.9899"),
        ("quaternion_wxyz: [1e300, 1e300, 0, 0]", "length inf"),
        ("quaternion_wxyz: [1, 0, 0]", "a list of 3"),
        ("matrix: [[1, 0, 0], [0, 1, 0], [0, 0, -1]]", "a reflection"),
        ("matrix: [[1.0101, 0, 0], [0, 1, 0], [0, 0, 1]]", "orthogonal within 0.01"),
        ("matrix: [[1, 0.021, 0], [0, 1, 0], [0, 0, 1]]", "off by 0.021"),
        ("matrix: [[-1.005, 0, 0], [0, 1, 0], [0, 0, 1]]", "reflection"),
        ("matrix: [[1e300, 1e300, 0], [-1e300, 1e300, 0], [0, 0, 1]]", "off by"),
        ("matrix: [[0, 0, 0], [0, 0, 0], [0, 0, 0]]", "off by 1"),
        ("matrix: [1, 0, 0, 0, 1, 0, 0, 0, 1]", "a list of 9"),
        ("euler_deg: 3", "the number 3"),
        ("euler_rad: {psi: 1}", "a mapping"),
        ("euler_rad:", "nothing"),
    ],
)
def test_an_orientation_that_is_none_is_refused_at_its_key(tmp_path: Path, text: str, found: str) -> None:
    key = text.split(":", maxsplit=1)[0]
    assert_fault(tmp_path, f"# a comment\nlimb2:\n  {text}\n", 3, f"limb2.{key}", found)


@pytest.mark.parametrize(
    ("text", "found"),
    [("{euler_deg: [0, 0, 0], euler_rad: [0, 0, 0]}", "euler_deg and euler_rad"), ("{}", "none of them")],
)
def test_an_orientation_has_exactly_one_form(tmp_path: Path, text: str, found: str) -> None:
    assert_fault(tmp_path, f"base:\n  orientation: {text}", 2, "base.orientation", "exactly one", found)


MEASURED = {
    "quaternion_wxyz: [0.707, 0, 0, 0.707]": (1.51e-4, [math.pi / 2, 0, 0]),
    "quaternion_wxyz: [1.01, 0, 0, 0]": (1e-2, [0, 0, 0]),
    "quaternion_wxyz: [0.99, 0, 0, 0]": (1e-2, [0, 0, 0]),
    "quaternion_wxyz: [0, 1.000002, 0, 0]": (2e-6, [0, 0, math.pi]),
    "matrix: [[0.87, -0.5, 0], [0.5, 0.87, 0], [0, 0, 1]]": (3.45e-3, [math.atan2(0.5, 0.87), 0, 0]),
    "matrix: [[1.00001, 0, 0], [0, 1, 0], [0, 0, 1]]": (1e-5, [0, 0, 0]),
    "matrix: [[1, -0.019, 0], [0, 1, 0], [0, 0, 1]]": (9.5e-3, [math.atan2(0.019, 2.0), 0, 0]),
}
"""Orientations of few digits: what they are off, and the Euler angles of the nearest rotation."""


@pytest.mark.parametrize("form", MEASURED)
def test_a_measured_orientation_is_normalised_with_a_warning_that_says_by_how_much(tmp_path: Path, form: str) -> None:
    off, angles = MEASURED[form]
    with pytest.warns(PurcellWarning) as told:
        found = load_configuration(written(tmp_path, f"limb1:\n  {form}")).shape[0]
    (message,) = {str(warning.message) for warning in told}
    key, _, said = message.partition(": limb1.")[2].partition(": normalised, since it is off by ")
    assert message.startswith(f"{tmp_path / 'file.yaml'}:2: limb1.")
    assert key == form.partition(":")[0]
    assert abs(float(said) - off) < 0.05 * off
    assert np.allclose(found, rotations.from_euler(angles), rtol=0, atol=2e-5 if off > 1e-3 else 1e-15)
    assert np.allclose(found.T @ found, np.eye(3), rtol=0, atol=1e-15)


def test_what_is_off_by_a_millionth_is_normalised_without_a_word(tmp_path: Path) -> None:
    """Warnings are errors here."""
    for form in ("quaternion_wxyz: [1.0000009, 0, 0, 0]", "matrix: [[1.0000009, 0, 0], [0, 1, 0], [0, 0, 1]]"):
        shape = load_configuration(written(tmp_path, f"limb1: {{{form}}}")).shape
        assert np.allclose(shape, np.eye(3), rtol=0, atol=1e-15)


@pytest.mark.parametrize("form", ["euler_deg", "euler_rad"])
def test_an_angle_that_a_double_cannot_hold_is_refused_with_the_largest_that_can(tmp_path: Path, form: str) -> None:
    for angle in ("1e300", "-1000001", "1.7e308"):
        text = f"limb1:\n  {form}: [0, {angle}, 0]"
        assert_fault(tmp_path, text, 2, f"limb1.{form}[1]", "at least -1e+06 and at most 1e+06")
    found = load_configuration(written(tmp_path, f"limb1: {{{form}: [-1e6, 0, 0]}}")).shape[0]
    angle = math.radians(-math.fmod(1e6, 360.0)) if form == "euler_deg" else -1e6
    assert np.allclose(found[:2, 0], [math.cos(angle), math.sin(angle)], rtol=0, atol=1e-10)


UNITS = {
    "base: {position_m: [0, 5mm, 0]}": ("base.position_m[1]", "the unit is m, as the key says: write 0.005"),
    "base: {position_m: [0, -1.5e3 µm, 0]}": ("base.position_m[1]", "the unit is m, as the key says: write -0.0015"),
    "base: {position_m: [0, 5in, 0]}": ("base.position_m[1]", "the unit is m, as the key says; write the number alone"),
    "limb1: {euler_deg: [30°, 0, 0]}": ("limb1.euler_deg[0]", "the unit is deg, as the key says: write 30"),
    "limb1: {euler_rad: [30 deg, 0, 0]}": (
        "limb1.euler_rad[0]",
        "the unit is rad, as the key says: write 0.52359",
    ),
    "base: {orientation: {quaternion_wxyz: [1m, 0, 0, 0]}}": ("base.orientation.quaternion_wxyz[0]", "without a unit"),
}


@pytest.mark.parametrize("text", UNITS)
def test_a_number_with_a_unit_is_met_with_the_units_name(tmp_path: Path, text: str) -> None:
    key, hint = UNITS[text]
    assert_fault(tmp_path, text, 1, key, "wanted a finite number", hint)


@pytest.mark.parametrize(
    ("text", "unit"),
    [("viscosity_pa_s: 950 mPa.s", "Pa s, as the key says: write 0.95"), ("joint_rate_rad_s: 60deg/s", "write 1.047"),
     ("base_half_length_m: 10cm", "m, as the key says: write 0.1"), ("slenderness: 1 m", "a number alone is wanted")],
)  # fmt: skip
def test_a_swimmers_number_with_a_unit_is_met_with_the_units_name(tmp_path: Path, text: str, unit: str) -> None:
    assert_fault(tmp_path, text, 1, text.partition(":")[0], "wanted a finite number", unit, load="swimmer")


@pytest.mark.parametrize(
    ("text", "line"),
    [("limb1:\n\teuler_deg: [1, 2, 3]", 2), ("\tlimb1: {}", 1), ("limb1:\n  euler_deg:\n\t- 1\n\t- 2", 3),
     ("limb1:\n  euler_deg: [1, 2, 3]\n\tmatrix: 1", 3)],
)  # fmt: skip
def test_a_tab_is_called_a_tab(tmp_path: Path, text: str, line: int) -> None:
    path = written(tmp_path, text)
    assert fault(path).startswith(f"{line}: ")
    assert "found a tab, where only spaces may stand" in fault(path)
    load_configuration(written(tmp_path, "limb1: {euler_deg:\t[1, 2, 3]}"))  # where tabs may stand
    assert "a tab" not in fault(written(tmp_path, "limb1: [\n"))


def test_a_goal_so_far_away_that_it_may_be_millimetres_is_remarked_on() -> None:
    """The foil: 30 m are 300 L, which nobody need be told of."""
    far = Scenario("n", Configuration(), Configuration.from_angles(position_m=[50.0, 0.0, 0.0]))
    with pytest.warns(PurcellWarning, match=r"the goal is 500 L \(50 m\) from the start.*position_m is in metres"):
        warn_if_far(far)
    ways = Waypoint(orientation=np.eye(3)), Waypoint(position_m=np.array([50.0, 0.0, 0.0]))
    with pytest.warns(PurcellWarning, match=r"^via\[1\] is 500 L \(50 m\) from the start"):
        warn_if_far(Scenario("n", Configuration(), Configuration(), via=ways))
    warn_if_far(Scenario("n", Configuration(), Configuration.from_angles(position_m=[30.0, 0.0, 0.0])))
    there = Configuration.from_angles(position_m=[80.0, 0.0, 0.0])
    warn_if_far(Scenario("n", there, Configuration.from_angles(position_m=[110.0, 0.0, 0.0])))
    small = Swimmer(base_half_length_m=0.01, limb_half_length_m=0.01)
    with pytest.warns(PurcellWarning, match="3000 L"):
        warn_if_far(Scenario("n", Configuration(), Configuration.from_angles(position_m=[30.0, 0.0, 0.0]), small))


@pytest.mark.slow
@given(numbers=st.lists(st.floats(-1e15, 1e15), min_size=3, max_size=3))
@example(numbers=[1e-3, 5e-324, -1e15])
@reuse_folder
def test_numbers_come_back_as_they_were_written(tmp_path: Path, numbers: list[float]) -> None:
    for text in (repr(numbers), yaml.safe_dump(numbers)):
        block = "base:\n  position_m:\n" + "".join(f"    {line}\n" for line in text.splitlines())
        found = load_configuration(written(tmp_path, block)).pose[:3, 3]
        assert found.tolist() == numbers


@pytest.mark.parametrize(
    ("text", "value"),
    [("1e-3", 1e-3), ("1E3", 1e3), ("-.5e+1", -5.0), ("+2.e2", 200.0), ("0x1F", 31.0), ("0o17", 15.0),
     ("!!float 3", 3.0), ("-.5", -0.5), ("+.5", 0.5), (".5", 0.5), ("5.", 5.0), ("+7", 7.0), ("-0", 0.0), ("08", 8.0),
     ("07", 7.0), ("00.5", 0.5), ("1.5e3", 1500.0), ("1.5e+3", 1500.0), ("0e0", 0.0), ("0xabc", 2748.0), ("0o0", 0.0)],
)  # fmt: skip
def test_numbers_are_those_of_yaml_1_2(tmp_path: Path, text: str, value: float) -> None:
    assert load_configuration(written(tmp_path, f"base: {{position_m: [{text}, 0, 0]}}")).pose[0, 3] == value


READ_OTHERWISE = {
    "017": ("15", "write 17"), "-010": ("-8", "write -10"), "+0777": ("511", "write 777"),
    "1_000": ("1000", "write 1000"), "-0x1F": ("-31", "write -31"),
    "1_0.5": ("10.5", "write 10.5"), "1:30": ("90", "write 90"), "190:20:30": ("685230", "write 685230"),
    "-1:30": ("-90", "write -90"), "1:30.5": ("90.5", "write 90.5"), "0b11": ("3", "write 3"),
    "0x_f": ("15", "write 15"), "0_7": ("7", "write 7"), "1_": ("1", "write 1"), "!!int 017": ("15", "write 17"),
}  # fmt: skip
"""Scalars that YAML 1.1 reads as a number and YAML 1.2 as another or none: the number, and the hint."""


@pytest.mark.parametrize("text", READ_OTHERWISE)
def test_what_yaml_1_1_reads_otherwise_is_refused_with_a_hint(tmp_path: Path, text: str) -> None:
    """The foil is PyYAML, which reads each without a word."""
    number, hint = READ_OTHERWISE[text]
    assert yaml.safe_load(text) == float(number)
    assert_fault(
        tmp_path, f"base: {{position_m: [{text}, 0, 0]}}", 1, "base.position_m[0]", "wanted a finite number", hint
    )
    if not text.startswith("!"):
        assert_fault(tmp_path, f"name: {text}\nstart: {{}}\ngoal: {{}}", 1, "name", hint, load="scenario")


def test_what_yaml_1_1_takes_for_truth_or_a_date_is_a_text_in_quotes(
    tmp_path: Path,
) -> None:
    for text in ("yes", "No", "ON", "off", "2001-01-01"):
        document = "name: {}\nstart: {{}}\ngoal: {{}}"
        assert_fault(tmp_path, document.format(text), 1, "name", "in quotes it is a text", load="scenario")
        assert load_scenario(written(tmp_path, document.format(f"'{text}'"))).name == text
    for text in ("y", "n", "tRue", "0b", "1.2.3"):
        assert load_scenario(written(tmp_path, document.format(text))).name == text


@pytest.mark.parametrize(
    "text",
    [".nan", ".inf", "-.inf", ".NaN", "1e400", "9" * 400, "9" * 5000, "0x" + "f" * 5000,
     "1:" * 50_000 + "1", "yes", "true",
     '"1"', "'1e-3'", "!!str 1", "1e-3x", "nan", "null", "2020-01-01", "[1]", "{a: 1}",
     "!!float ''", "!!int x", "=", "<<",
     "!!int 1.5", "!!float 0x10", "!!int 1_0", "0o8", "0b", "1e", "+-1", "٣", "1.5.2"],
)  # fmt: skip
def test_what_is_no_finite_number_is_refused(tmp_path: Path, text: str) -> None:
    text = f"base:\n  position_m:\n  - 0\n  - {text}\n  - 0\n"
    assert_fault(tmp_path, text, 4, "base.position_m[1]", "wanted a finite number")


def test_an_unknown_key_is_named_with_the_nearest(tmp_path: Path) -> None:
    assert_fault(
        tmp_path, "base:\n  orientatoin: {}", 2, "base.orientatoin", "position_m, orientation (nearest: orientation)"
    )
    assert_fault(tmp_path, "workspace_m: 1", 1, "workspace_m", "base, limb1, limb2", "unknown key 'workspace_m'")
    assert_fault(tmp_path, "?\n  " + "k" * 100_000 + "\n: 1", 2, "k" * 37 + "...", "unknown key")


def test_a_key_stands_once(tmp_path: Path) -> None:
    text = "limb1: {euler_deg: [0, 0, 0]}\nlimb1: {euler_deg: [0, 0, 0]}"
    assert_fault(tmp_path, text, 2, "limb1", "each key once", "line 1")


@pytest.mark.parametrize(
    "text", ["1: 2", "[a]: 2", "{a: 1}: 2", "? \n: 2", "on: 2", "<<: {limb1: {}}", "!!int limb1: {}"]
)
def test_a_key_is_a_plain_name(tmp_path: Path, text: str) -> None:
    assert_fault(tmp_path, text, 1, "the document", "a plain name")


# Whatever is no document


@pytest.mark.parametrize("load", ["configuration", "swimmer", "gait", "scenario"])
@pytest.mark.parametrize("text", ["", "\n\n", "# nothing\n", "---\n", "---\n...\n", "\ufeff"])
def test_an_empty_file_is_refused(tmp_path: Path, load: str, text: str) -> None:
    assert_fault(tmp_path, text, 1, "the document", "found an empty file", load=load)
    assert ("{}" in fault(tmp_path / "file.yaml", f"load_{load}")) == (load in {"configuration", "swimmer"})


@pytest.mark.parametrize("load", ["configuration", "swimmer", "gait", "scenario"])
@pytest.mark.parametrize("text", ["[]", "3", "text", "null", "true", "- a"])
def test_a_document_is_a_mapping(tmp_path: Path, load: str, text: str) -> None:
    assert_fault(tmp_path, text, 1, "the document", "wanted a mapping", load=load)


@pytest.mark.parametrize(
    ("text", "line", "key", "found"),
    [
        ("base:\n\tlimb: 1", 2, "base", "cannot start any token"),
        ("limb1: {euler_deg: [0, 0, 0}", 1, "limb1.euler_deg", "a fault"),
        ("limb1: {}\nlimb2: *x", 2, "limb2", "undefined alias 'x'"),
        ("{}\n---\n{}", 2, "the document", "another document"),
        ('a: "\\UFFFFFFFF"', 1, "a", "a fault"),
        ("%YAML 1." + "9" * 5000 + "\n---\n{}", 1, "the document", "a fault"),
        ("%YAML 3.0\n---\n{}", 1, "the document", "a fault"),
        ('"', 1, "the document", "a fault"),
        ("base: &a\n  orientation: *a", 2, "base.orientation", "alias *a inside itself"),
        ("base: &a [*a]", 1, "base[0]", "alias *a inside itself"),
    ],
)
def test_malformed_yaml_is_reported_where_it_is(tmp_path: Path, text: str, line: int, key: str, found: str) -> None:
    path = written(tmp_path, text)
    message = fault(path)
    assert re.match(rf"{line}(?<=\d): {re.escape(key)}: wanted ", message) or message.startswith(f"{line + 1}: {key}: ")
    assert found in message


@pytest.mark.parametrize(
    "tag",
    [
        "!!python/object/apply:os.system",
        "!!python/tuple",
        "!!binary",
        "!!set",
        "!!omap",
        "!!timestamp",
        "!local",
        "!<x:y>",
    ],
)
@pytest.mark.parametrize("value", ["[]", "{}", "x"])
def test_a_tag_that_is_not_plain_yaml_is_refused(tmp_path: Path, tag: str, value: str) -> None:
    assert_fault(tmp_path, f"base:\n  position_m: {tag} {value}", 2, "base.position_m", "plain YAML", "the tag")


@pytest.mark.parametrize("text", ["!!str [1]", "!!map [1]", "!!seq x", "!!float {}"])
def test_a_tag_that_does_not_suit_its_value_is_refused(tmp_path: Path, text: str) -> None:
    assert_fault(tmp_path, f"base: {text}", 1, "base", "plain YAML")


LAUGHS = "a0: &a0 [1, 1, 1]\n" + "".join(f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * 9)}]\n" for k in range(1, 12))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("text", "wanted"),
    [
        (LAUGHS, "at most 20000 values"),
        ("[" + "1," * 30_000 + "]", "at most 20000 values"),
        ("- a\n" * 30_000, "at most 20000 values"),
        ("&a {b: [" + "x," * 200 + "], c: [" + "&d [1]," + "*d," * 10_000 + "]}", "at most 20000 values"),
        ("[" * 500_000, "at most 20 levels"),
        ("{a: " * 200_000, "at most 20 levels"),
        ("- " * 500_000, "at most 20 levels"),
        ("? " * 500_000, "at most 20 levels"),
        ("".join(" " * k + "a:\n" for k in range(1000)), "at most 20 levels"),
    ],
)
def test_a_document_that_explodes_or_is_too_deep_is_refused(tmp_path: Path, text: str, wanted: str) -> None:
    assert wanted in fault(written(tmp_path, text))


def test_aliases_within_the_limits_are_read(tmp_path: Path) -> None:
    found = load_configuration(written(tmp_path, "limb1: &bent {euler_deg: [0, 20, 0]}\nlimb2: *bent"))
    assert np.array_equal(found.shape[0], found.shape[1])
    assert not np.array_equal(found.shape[0], np.eye(3))


@pytest.mark.parametrize(
    "filler", ["#", "\n", " ", "a b\n", "'", '"', "&", "!", "%", "*", "a:", "---\n", "\r\n", "|", "\u2028"]
)
def test_a_full_size_file_of_anything_is_refused_quickly(tmp_path: Path, filler: str) -> None:
    fault(written(tmp_path, (filler * (MEBIBYTE // len(filler.encode())))))


def test_a_file_of_up_to_a_mebibyte_is_read_and_no_more(tmp_path: Path) -> None:
    load_configuration(written(tmp_path, "{}" + " " * (MEBIBYTE - 2)))
    assert_fault(tmp_path, "{}" + " " * (MEBIBYTE - 1), 1, "the document", "at most 1048576 bytes")


def test_an_absurdly_large_file_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "sparse.yaml"
    with path.open("wb") as stream:
        stream.truncate(1 << 40)
    assert "at most 1048576 bytes" in fault(path)


@pytest.mark.parametrize(
    ("data", "line", "found"),
    [
        (b"{}\n# \xff", 2, "0xff"),
        (b"\xff\xfe{\x00}\x00", 1, "0xff"),
        (b"a: \xed\xa0\x80", 1, "0xed"),
        (b"{}\n\n# \x00", 3, "U+0000"),
        (b"# \x1b[31m", 1, "U+001B"),
        (b"# \x7f", 1, "U+007F"),
    ],
)
def test_what_is_not_printable_utf8_is_refused_at_its_line(tmp_path: Path, data: bytes, line: int, found: str) -> None:
    assert_fault(tmp_path, data, line, "the document", found)


def test_a_byte_order_mark_is_skipped(tmp_path: Path) -> None:
    load_configuration(written(tmp_path, "\ufeff{}"))


# What is no file


def test_a_path_that_is_no_readable_file_is_refused(tmp_path: Path) -> None:
    assert "no such file" in fault(tmp_path / "missing.yaml")
    assert "a directory" in fault(tmp_path)
    assert "Not a directory" in fault(written(tmp_path, "{}") / "below.yaml")
    assert "wanted a readable file" in fault("bad\0name")
    assert "wanted a readable file" in fault(tmp_path / ("n" * 5000))


def test_a_loop_of_links_is_refused(tmp_path: Path) -> None:
    (tmp_path / "one").symlink_to(tmp_path / "two")
    (tmp_path / "two").symlink_to(tmp_path / "one")
    assert "wanted a readable file" in fault(tmp_path / "one")


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes with names")
def test_a_pipe_a_socket_and_a_device_do_not_block(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    with socket.socket(socket.AF_UNIX) as server:
        server.bind("socket")
        for path in ("pipe", "socket", "/dev/zero", "/dev/tty"):
            assert "no regular file" in fault(path) or not Path(path).exists()


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may read everything")
def test_a_file_without_permission_is_refused(tmp_path: Path) -> None:
    path = written(tmp_path, "{}")
    path.chmod(0)
    assert "Permission denied" in fault(path)


def test_a_name_with_odd_characters_is_shown_on_one_line(tmp_path: Path) -> None:
    path = written(tmp_path, "3", "a\nb\x1b\udc80.yaml" if os.name == "posix" else "a b.yaml")
    with pytest.raises(InputError) as caught:
        load_configuration(path)
    assert str(caught.value).isprintable()
    str(caught.value).encode()


def test_dash_is_standard_input(monkeypatch: pytest.MonkeyPatch) -> None:
    def feed(data: bytes) -> None:
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(data)))

    feed(b"base: {position_m: [1, 2, 3]}")
    assert load_configuration("-").pose[:3, 3].tolist() == [1, 2, 3]
    feed(b"limb3: {}")
    assert fault("-").startswith("standard input:1: limb3: ")
    feed(b" " * (2 * MEBIBYTE))
    assert "at most 1048576 bytes" in fault("-")
    monkeypatch.setattr(sys, "stdin", None)
    assert "standard input that cannot be read" in fault("-")


# Anything at all


@given(data=st.binary(max_size=300))
@reuse_folder
def test_any_bytes_are_read_or_refused(tmp_path: Path, data: bytes) -> None:
    path = written(tmp_path, data)
    for load in (
        load_configuration,
        load_swimmer,
        load_gait,
        load_scenario,
    ):
        message = refusal(path, load)
        assert not message or re.match(re.escape(str(path)) + r":\d+: .*: wanted .*, found .*", message)


@pytest.mark.slow
@given(data=st.data())
@settings(parent=reuse_folder, max_examples=300)
def test_a_damaged_file_is_read_or_refused(tmp_path: Path, data: st.DataObject) -> None:
    text, load = data.draw(st.sampled_from([(GAIT, load_gait), (SCENARIO, load_scenario)]))
    at = data.draw(st.integers(0, len(text)))
    cut = data.draw(st.integers(0, 5))
    put = data.draw(st.text(st.sampled_from("{}[]:,-&*a!|>'\"%@`?# \n\t\\0.e" + string.ascii_lowercase), max_size=5))
    message = refusal(written(tmp_path, text[:at] + put + text[at + cut :]), load)
    assert not message or re.search(r":\d+: .*: wanted .*, found .*", message)


# Swimmers


def test_an_empty_mapping_is_the_papers_swimmer(tmp_path: Path) -> None:
    assert load_swimmer(written(tmp_path, "{}")) == Swimmer()


def test_a_swimmer_has_the_parameters_of_its_file(tmp_path: Path) -> None:
    found = load_swimmer(written(tmp_path, "slenderness: 1e-2\ndrag_ratio: 1.5\nbase_half_length_m: 1\n"))
    assert found == Swimmer(slenderness=0.01, drag_ratio=1.5, base_half_length_m=1.0)


@pytest.mark.parametrize("name", LIMITS)
def test_a_swimmers_parameter_out_of_range_is_refused_at_its_line(tmp_path: Path, name: str) -> None:
    low, high = LIMITS[name]
    for value in (low, -1.0, math.nextafter(high, math.inf), ".nan", "x"):
        assert_fault(tmp_path, f"# swimmer\n{name}: {value}", 2, name, f"above {low:g} and at most", load="swimmer")


def test_links_of_absurd_proportions_are_refused_at_the_limbs_line(tmp_path: Path) -> None:
    text = "base_half_length_m: 1\nlimb_half_length_m: 1000\n"
    assert_fault(tmp_path, text, 2, "limb_half_length_m", "0.01 to 100 times", "1000 times", load="swimmer")
    assert_fault(tmp_path, "base_half_length_m: 100", 1, "limb_half_length_m", "0.001 times", load="swimmer")


# Gaits


def test_a_gait_is_what_its_file_says(tmp_path: Path) -> None:
    gait = load_gait(written(tmp_path, GAIT))
    assert (gait.name, gait.also, gait.moves, gait.source) == ("x-rotation", ("roll",), "roll", "text")
    assert (gait.symbol, gait.means, gait.default_rad) == ("a", "angle of roll", 0.5)
    assert gait.amplitude_is_displacement
    assert gait.approach == (Turn(2, {"b": 1.0}),)
    assert gait.cycle == (Turn(2, {"a": -1.0}), Turn(5, {"a": 2.0}), Turn(1, {"a": 1.0, "p": -0.5, "": 1e-3}))
    assert gait.free == {"b": Guess((1.0,), (0.65,)), "p": Guess((0.05, 1.0), (0.07, 0.35), 1.0)}


def test_what_a_gait_leaves_out_has_its_default(tmp_path: Path) -> None:
    text = "name: g\nsummary: s\nmoves: y\namplitude: {symbol: a1, means: m, default_rad: 1}\ncycle: [limb1 roll: 2a1]"
    gait = load_gait(written(tmp_path, text))
    assert (gait.also, gait.source, gait.approach, gait.free, gait.amplitude_is_displacement) == ((), "", (), {}, False)
    assert gait.cycle == (Turn(0, {"a1": 2.0}),)


@pytest.mark.parametrize(
    ("old", "new", "line", "key", "parts"),
    [
        ("  - limb1 yaw: -a", "  - limb1 jaw: -a", 10, "cycle[0].limb1 jaw", ["(nearest: limb1 yaw)"]),
        ("  - limb1 yaw: -a", "  - {limb1 yaw: a, limb2 yaw: a}", 10, "cycle[0]", ["limb1 yaw and limb2 yaw"]),
        ("  - limb1 yaw: -a", "  - {}", 10, "cycle[0]", ["exactly one", "none of them"]),
        ("  - limb1 yaw: -a", "  - limb1 yaw", 10, "cycle[0]", ["the text 'limb1 yaw'"]),
        ("  - limb1 yaw: -a", "  - limb1 yaw: -c", 10, "cycle[0].limb1 yaw", ["(a, b, p)", "'c'"]),
        ("  - limb1 yaw: b", "  - limb1 yaw: q", 8, "approach[0].limb1 yaw", ["(a, b, p)", "'q'"]),
        ("  - limb1 yaw: b", "  - limb1 yaw: a", 14, "free.b", ["a symbol that a turn uses", "'b'"]),
        ("  b: {guess: 0.65}", "  a: {guess: 0.65}", 14, "free.a", ["'a', the amplitude's"]),
        ("  b: {guess: 0.65}", "  b: {guess: 0}", 14, "free.b.guess", ["other than 0"]),
        ("  b: {guess: 0.65}", "  b: {}", 14, "free.b.guess", ["no such key"]),
        ("  b: {guess: 0.65}", "  B: {guess: 1}", 14, "free.B", ["one lower-case letter"]),
        ("[0.05, 1.0]", "[1.0, 0.05]", 15, "free.p.guess.amplitude_rad", ["ascending"]),
        ("[0.05, 1.0]", "[0.0, 1.0]", 15, "free.p.guess.amplitude_rad[0]", ["above 0"]),
        ("[0.05, 1.0]", "[]", 15, "free.p.guess.amplitude_rad", ["1 or more"]),
        ("[0.07, 0.35]", "[0.07]", 15, "free.p.guess.value", ["2 in all", "found 1"]),
        ("[0.07, 0.35]", "[-0.07, 0.35]", 15, "free.p.guess.value", ["one sign"]),
        ("moves: roll", "moves: rol", 4, "moves", ["(nearest: roll)", "'rol'"]),
        ("moves: roll", "moves: no", 4, "moves", ["the truth value no"]),
        ("symbol: a,", "symbol: alpha,", 5, "amplitude.symbol", ["one lower-case letter"]),
        ("default_rad: 0.5", "default_rad: -0.5", 5, "amplitude.default_rad", ["above 0"]),
        ("is_displacement: true", "is_displacement: 1", 5, "amplitude.is_displacement", ["true or false"]),
        ("also: [roll]", "also: roll", 2, "also", ["a list", "the text 'roll'"]),
        ("also: [roll]", "also: [1]", 2, "also[0]", ["in quotes it is a text"]),
        ("name: x-rotation", "name: x/rotation", 1, "name", ["a name"]),
        ("summary: rolls", 'summary: "\\e[31m" #', 3, "summary", ["one line of text"]),
        ("summary: rolls", 'summary: "two\\nlines" #', 3, "summary", ["one line of text"]),
        ('source: "text"', 'source: ""', 6, "source", ["a text"]),
        ('source: "text"', 'source: "\\uD800"', 6, "source", []),
    ],
)
def test_a_fault_in_a_gait_is_reported_where_it_is(
    tmp_path: Path, old: str, new: str, line: int, key: str, parts: list[str]
) -> None:
    assert old in GAIT
    assert_fault(tmp_path, GAIT.replace(old, new, 1), line, key, *parts, load="gait")


@pytest.mark.parametrize("key", ["name", "summary", "moves", "amplitude", "cycle"])
def test_a_gait_without_a_needed_key_is_refused(tmp_path: Path, key: str) -> None:
    document = yaml.safe_load(GAIT)
    del document[key]
    assert_fault(tmp_path, yaml.safe_dump(document), 1, key, "no such key", load="gait")


def test_a_gait_has_a_turn(tmp_path: Path) -> None:
    text = GAIT[: GAIT.index("cycle:")] + "cycle: []\n"
    assert_fault(tmp_path, text, 9, "cycle", "1 or more", load="gait")


@pytest.mark.parametrize(
    ("text", "terms"),
    [
        ("a", {"a": 1.0}),
        ("-a", {"a": -1.0}),
        ("+ a", {"a": 1.0}),
        ("2 a", {"a": 2.0}),
        ("2a", {"a": 2.0}),
        ("2*a", {"a": 2.0}),
        ("-1.5e-1 * b2 + a - .25", {"b2": -0.15, "a": 1.0, "": -0.25}),
        ("a+a-3a", {"a": -1.0}),
        ("1 + 2", {"": 3.0}),
        ("2e", {"e": 2.0}),
        ("  a  ", {"a": 1.0}),
    ],
)
def test_linear_terms_are_read(text: str, terms: dict[str, float]) -> None:
    assert linear_terms(text) == terms


@pytest.mark.parametrize(
    "text",
    ["", " ", "a b", "2 3", "a * 2", "* a", "2 *", "--a", "a -", "+", "a*b", "a/2", "(a)", "aa",
     "A", "pi", "a^2", "1e999 a",
     "1e999 - 1e999", "a,b", "\u2212a", "\u0663 a", "a + x y", "__import__('os')", "1_0 a", "1..2", "a." ],
)  # fmt: skip
def test_what_is_not_linear_is_refused(tmp_path: Path, text: str) -> None:
    assert linear_terms(text) is None
    quoted = text.replace("'", "''")
    bad = GAIT.replace("limb1 yaw: -a", f"limb1 yaw: '{quoted}'")
    assert_fault(tmp_path, bad, 10, "cycle[0].limb1 yaw", "linear in symbols", load="gait")


@given(terms=st.dictionaries(st.sampled_from(["a", "b", "e", "e1", "z99", ""]), floats, min_size=1))
def test_linear_terms_come_back_as_they_were_written(terms: dict[str, float]) -> None:
    text = "".join(f" {'-' if math.copysign(1, c) < 0 else '+'} {abs(c)!r} {s}" for s, c in terms.items())
    assert linear_terms(text) == terms


@given(text=st.text(alphabet="ab12.e+-* ", max_size=200))
def test_any_expression_is_read_or_refused(text: str) -> None:
    found = linear_terms(text)
    assert found is None or all(math.isfinite(value) for value in found.values())


# Scenarios


def test_a_scenario_is_what_its_file_says(tmp_path: Path) -> None:
    expect = "{verdict: not reached, position_tolerance: 1e-6, angle_tolerance_rad: 0.1, max_joint_travel_rad: 50}"
    text = f"{SCENARIO}swimmer: {{drag_ratio: 1.5}}\nexpect: {expect}\n"
    found = load_scenario(written(tmp_path, text))
    assert found.name == "out-and-back_1.5"
    assert np.array_equal(found.start.pose, np.eye(4))
    assert found.goal.pose[0, 3] == 0.1
    assert found.swimmer == Swimmer(drag_ratio=1.5)
    assert found.expect == Expect("not reached", 1e-6, 0.1, 50.0)


def test_what_a_scenario_leaves_out_has_its_default(tmp_path: Path) -> None:
    found = load_scenario(written(tmp_path, SCENARIO))
    assert found.swimmer == Swimmer()
    assert found.expect == Expect("reached", None, None, None)


def test_paths_in_a_scenario_start_from_its_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "parts").mkdir()
    written(tmp_path, "base: {position_m: [1, 2, 3]}", "parts/start.yaml")
    written(tmp_path, "drag_ratio: 3", "swimmer.yaml")
    written(
        tmp_path, "name: n\nstart: parts/start.yaml\ngoal: ./parts/../parts/start.yaml\nswimmer: swimmer.yaml", "s.yaml"
    )
    monkeypatch.chdir("/")
    found = load_scenario(tmp_path / "s.yaml")
    assert found.start.pose[:3, 3].tolist() == found.goal.pose[:3, 3].tolist() == [1, 2, 3]
    assert found.swimmer.drag_ratio == 3.0
    monkeypatch.chdir(tmp_path)
    assert load_scenario("s.yaml").start.pose[0, 3] == 1.0


@pytest.mark.parametrize("name", ["missing.yaml", ".", "-", "", '"a\\0b"'])
def test_a_path_in_a_scenario_that_is_no_file_is_refused_at_its_line(
    tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "stdin", None)
    monkeypatch.chdir(tmp_path)
    text = f"name: n\nstart: {{}}\ngoal: {name if name.startswith(chr(34)) else chr(34) + name + chr(34)}\n"
    written(tmp_path, text, "s.yaml")
    found = fault("s.yaml", "load_scenario")
    assert found.startswith("3: goal: wanted the path of a")


def test_a_fault_in_a_file_that_a_scenario_names_is_reported_there(tmp_path: Path) -> None:
    start = written(tmp_path, "\nlimb1: 3", "start.yaml")
    scenario = written(tmp_path, "name: n\nstart: start.yaml\ngoal: {}", "s.yaml")
    with pytest.raises(InputError, match=re.escape(f"{start}:2: limb1: wanted ")):
        load_scenario(scenario)


def test_a_fault_in_an_inline_part_of_a_scenario_has_its_whole_key(tmp_path: Path) -> None:
    text = "name: n\nstart:\n  limb1:\n    euler_deg: [0, 0, .nan]\ngoal: {}"
    assert_fault(tmp_path, text, 4, "start.limb1.euler_deg[2]", "finite", load="scenario")
    ratio = "swimmer:\n  base_half_length_m: 1\n  limb_half_length_m: 1000\n"
    assert_fault(tmp_path, SCENARIO + ratio, 6, "swimmer.limb_half_length_m", "1000 times", load="scenario")


@pytest.mark.parametrize(
    ("text", "line", "key"),
    [
        (SCENARIO.replace("out-and-back_1.5", "../escape"), 1, "name"),
        (SCENARIO.replace("out-and-back_1.5", ".hidden"), 1, "name"),
        (SCENARIO.replace("out-and-back_1.5", "n" * 101), 1, "name"),
        (SCENARIO.replace("out-and-back_1.5", '"line\\n"'), 1, "name"),
        (SCENARIO.replace("out-and-back_1.5", "1.5"), 1, "name"),
        (SCENARIO.replace("start: {}", "start: 3"), 2, "start"),
        (SCENARIO.replace("start: {}", "start: [a]"), 2, "start"),
        (SCENARIO.replace("start: {}", "start:"), 2, "start"),
        (SCENARIO.replace("start: {}\n", ""), 1, "start"),
        (SCENARIO + "expect: {verdict: maybe}", 4, "expect.verdict"),
        (SCENARIO + "expect: {position_tolerance: 0}", 4, "expect.position_tolerance"),
        (SCENARIO + "expect: {angle_tolerance_rad: -1}", 4, "expect.angle_tolerance_rad"),
        (SCENARIO + "expect: {max_joint_travel_rad: lots}", 4, "expect.max_joint_travel_rad"),
        (SCENARIO + "expect: {tolerance: 1}", 4, "expect.tolerance"),
    ],
)
def test_a_fault_in_a_scenario_is_reported_where_it_is(tmp_path: Path, text: str, line: int, key: str) -> None:
    assert_fault(tmp_path, text, line, key, load="scenario")


WORKSPACE = "workspace_m: {min: [-1, -2.5, -3], max: [1, 2, 3]}\n"
BOX = Workspace((-1.0, -2.5, -3.0), (1.0, 2.0, 3.0))


def test_a_goal_and_a_scenario_may_have_a_workspace(tmp_path: Path) -> None:
    goal = written(tmp_path, f"base: {{position_m: [0.1, 0, 0]}}\n{WORKSPACE}", "goal.yaml")
    assert load_goal(goal).workspace == BOX
    assert load_goal(goal).configuration.pose[0, 3] == 0.1
    assert load_goal(written(tmp_path, "{}")).workspace is None
    assert load_scenario(written(tmp_path, SCENARIO + WORKSPACE)).workspace == BOX
    assert load_scenario(written(tmp_path, SCENARIO)).workspace is None
    named = written(tmp_path, "name: n\nstart: {}\ngoal: goal.yaml\n", "scenario.yaml")
    assert load_scenario(named).workspace == BOX
    assert load_scenario(named).goal.pose[0, 3] == 0.1


@pytest.mark.parametrize(
    ("text", "key", "part"),
    [
        ("workspace_m: 3", "workspace_m", "a mapping with some of the keys min, max"),
        ("workspace_m: {min: [~, null, null]}", "workspace_m", "a box with one wall or more"),
        ("workspace_m: {min: [0, '', 0]}", "workspace_m.min[1]", "a finite number"),
        ("workspace_m: {min: [0, 0], max: [1, 1, 1]}", "workspace_m.min", "a list of 3"),
        ("workspace_m: {min: [0, 0, 0], max: [1, .inf, 1]}", "workspace_m.max[1]", "a finite number"),
        ("workspace_m: {min: [0, 0, .nan], max: [1, 1, 1]}", "workspace_m.min[2]", "a finite number"),
        (
            "workspace_m: {min: [0, 0, 0], max: [1, 0, 1]}",
            "workspace_m.max",
            "above min ([0.0, 0.0, 0.0])",
        ),
        ("workspace_m: {min: [0, 2, 0], max: [1, 1, 1]}", "workspace_m.max", "found [1.0, 1.0, 1.0]"),
        ("workspace_m: {min: [0, 0, 0], max: [1, 1, 1], at: 0}", "workspace_m.at", "unknown key"),
        ("workspace: {min: [0, 0, 0], max: [1, 1, 1]}", "workspace", "nearest: workspace_m"),
    ],
)
def test_a_workspace_that_is_none_is_reported_where_it_is(tmp_path: Path, text: str, key: str, part: str) -> None:
    assert_fault(tmp_path, f"limb1: {{euler_deg: [1, 2, 3]}}\n{text}\n", 2, key, part, load="goal")
    assert_fault(tmp_path, f"{SCENARIO}{text}\n", 4, key, part, load="scenario")


def test_a_workspace_may_be_open_to_some_sides(tmp_path: Path) -> None:
    for text, low, high in (
        ("{min: [0, -1, 2]}", (0.0, -1.0, 2.0), (None, None, None)),
        ("{min: [~, null, -0.3], max: [1, null, ~]}", (None, None, -0.3), (1.0, None, None)),
    ):
        goal = written(tmp_path, f"workspace_m: {text}", "goal.yaml")
        assert load_goal(goal).workspace == Workspace(low, high)


def test_a_workspace_in_a_start_or_twice_is_refused(tmp_path: Path) -> None:
    assert_fault(tmp_path, WORKSPACE, 1, "workspace_m", "one of the keys base, limb1, limb2")
    twice = f"name: n\nstart: {{}}\ngoal:\n  {WORKSPACE}{WORKSPACE}"
    assert_fault(tmp_path, twice, 5, "workspace_m", "one workspace, the scenario's or its goal's", load="scenario")


# Without libyaml


@pytest.fixture
def plain_files(monkeypatch: pytest.MonkeyPatch) -> ModuleType:
    """Return the module as it is where PyYAML has no libyaml."""
    monkeypatch.delattr(yaml, "CSafeLoader", raising=False)
    spec = importlib.util.find_spec("purcell_cli.files.yaml_source")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_without_libyaml_files_are_read_and_refused_alike(tmp_path: Path, plain_files: ModuleType) -> None:
    plain = plain_files.load(written(tmp_path, GAIT), SCHEMAS["gait"])
    quick = load_gait(written(tmp_path, GAIT))
    assert dataclasses.asdict(plain) == dataclasses.asdict(quick)
    bad = [
        LAUGHS,
        "[" * 100_000,
        "&a [*a]",
        "{}\n---\n{}",
        "a: *x",
        "!!set {}",
        'a: "\\UFFFFFFFF"',
        "%YAML 1." + "9" * 5000,
    ]
    for text in [*bad, "limb1: {euler_deg: [1e-3, 1, '1']}"]:
        path = written(tmp_path, text)
        with pytest.raises(InputError, match=re.escape(str(path)) + r":\d+: .*: wanted .*, found .*"):
            plain_files.load(path, SCHEMAS["start"])
