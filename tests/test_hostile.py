"""Hostile input: whatever a document or a path is, a command ends soon, in one clear line, and writes nothing."""

from __future__ import annotations

import contextlib
import copy
import io
import json
import os
import re
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from helpers import calls, mostly_slow
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st

from purcell_cli.cli.app import _run
from purcell_cli.files import yaml_source
from purcell_cli.files.trajectory_csv import COLUMNS
from purcell_cli.files.validate import KINDS

MISUSE = 2
MOST_CALLS, MOST_BYTES = 2_000_000, 300 << 20
"""The work and the memory that a refusal may take."""
COUNTED = 10
"""The work of one document in so many is counted."""
FUZZ = {"truncated": 200, "replaced": 500, "unknown": 200, "garbage": 200, "unprintable": 200, "nested": 20}
"""How many different documents are generated of each kind: 1,320 in all, a fiftieth of them in the quick subset."""

# Good documents, each with the command that reads it --------------------------------------------------------------

START = {
    "base": {"position_m": [0.1, 0, 0], "orientation": {"euler_deg": [10, 0, 5]}},
    "limb1": {"euler_deg": [9, 0, 0]},
}
GOAL = {**START, "workspace_m": {"min": [-1, -1, -1], "max": [1, 1, 1]}}
SWIMMER = {
    "base_half_length_m": 0.1,
    "slenderness": 0.02,
    "max_bend_rad": 1.2,
    "drag": {
        "base": {"along_n_s_per_m": 0.2, "turn_n_m_s": 0.002},
        "limb1": {"along_n_s_per_m": 0.9, "across_n_s_per_m": 0.7},
    },
    "links": {"limb2": {"half_length_m": 0.09, "slenderness": 0.03}},
    "body_radius_m": 0.02,
    "joints": {
        "limb1": {"kind": "universal", "range_deg": {"psi": [5, 90], "theta": [-60, 45.5]}, "rate_rad_s": 0.5},
        "limb2": {"kind": "hinge", "axis": "yaw", "range_deg": [-80, 60]},
    },
    "joint_acceleration_rad_s2": 4.0,
}
SCENARIO = {
    "name": "n",
    "start": {"base": {"position_m": [0, 0, 0]}},
    "goal": {"limb2": {"quaternion_wxyz": [1, 0, 0, 0]}},
    "swimmer": {"drag_ratio": 1.9},
    "expect": {"verdict": "reached", "max_joint_travel_rad": 9.5},
}
GAIT = {
    "name": "own",
    "also": ["other"],
    "summary": "a square",
    "moves": "none",
    "amplitude": {"symbol": "a", "means": "bend", "default_rad": 0.5},
    "cycle": [{"limb1 yaw": "a"}, {"limb2 yaw": "a - 0.5 b"}, {"limb1 yaw": "-a"}],
    "free": {"b": {"guess": {"amplitude_rad": [0.1, 1.0], "value": [0.2, 0.3]}}},
}
PLAN = {
    "schema": "purcell/plan-document/1",
    "purcell": "1",
    "swimmer": {"slenderness": 0.01},
    "start": {},
    "goal": {"limb1": {"matrix": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}},
    "dt_s": 0.05,
    "blocks": [{"phase": 1, "gait": "g", "cycles": 1, "primitives": [["limb1 yaw", 0.5], ["limb1 yaw", -0.5]]}],
}
SERVO_MAP = {
    "hinge_order": {"limb1": "zyx", "limb2": "xyz"},
    "lock_margin_deg": 5,
    "channels": {
        "limb1_yaw": {"unit": "us", "zero": 1500, "sign": -1, "scale": 11.1, "range": [500, 2500]},
        "limb2_roll": {"unit": "deg", "range": [-90, 90.5]},
    },
}
DOCUMENTS: dict[str, tuple[dict[str, Any], list[str]]] = {
    "start": (START, ["plan", "bad.yaml", "goal.yaml"]),
    "goal": (GOAL, ["plan", "start.yaml", "bad.yaml"]),
    "swimmer": (SWIMMER, ["plan", "start.yaml", "goal.yaml", "--swimmer", "bad.yaml"]),
    "scenario": (SCENARIO, ["plan", "bad.yaml"]),
    "gait": (GAIT, ["gait", "own", "--gaits", "gaits"]),
    "plan": (PLAN, ["run", "bad.yaml"]),
    "servo-map": (SERVO_MAP, ["export", "still.csv", "--to", "servo", "--map", "bad.yaml"]),
}
BAD_VALUES = [
    *(".nan", ".inf", "-.inf", "1e400", "-1e999", "9" * 400, "0x" + "f" * 300, "1:60:60.5", "2001-01-01"),
    *("null", "~", "[[]]", "[[[1]]]", "{zz: 1}", "{[]: 1}", "{? {a: b} : c}", "{1: 2}", "!!binary aGk=", "!!set {a}"),
    *("!!python/object/apply:os.system ['touch pwned']", "!!python/name:os.system x", "!!python/tuple [1]"),
    *("!!python/object/new:type ['z', [], {}]", "!local 1", "!<tag:x,1:y> 1", "*nowhere", "&a [*a]", "&a {a: *a}"),
    *("{<<: {a: 1}}", "{a: 1, a: 1}", "[1, 2", "{a: 1", "'open", '"open', '"\\x1b"', '"\\q"', "@", "`", "%"),
]
"""Values, as YAML, that are wrong wherever they stand."""


STILL = f"{','.join(COLUMNS)}\n0.0,1,g,{','.join(['0.0'] * 3 + ['1.0', *['0.0'] * 6] * 3 + ['0.0'] * 6)}\n"
"""A trajectory of one row, collinear and at rest."""


class Raw(str):
    """A text that stands in a document as it is."""

    __slots__ = ()


def yaml_of(value: Any) -> str:
    """Return a document in YAML's flow style."""
    if isinstance(value, Raw):
        return str(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(k)}: {yaml_of(v)}" for k, v in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(yaml_of, value)) + "]"
    return json.dumps(value)


def places(value: Any, path: tuple[str | int, ...] = ()) -> Iterator[tuple[str | int, ...]]:
    """Yield the path to every value of a document."""
    yield path
    inner = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, below in inner:
        yield from places(below, (*path, key))


def with_value(document: Any, path: tuple[str | int, ...], new: Callable[[Any], Any]) -> Any:
    """Return a document with the value at a path replaced."""
    if not path:
        return new(document)
    out = copy.deepcopy(document)
    parent = out
    for key in path[:-1]:
        parent = parent[key]
    parent[path[-1]] = new(parent[path[-1]])
    return out


# What is made of them ----------------------------------------------------------------------------------------------

kinds = st.sampled_from(list(DOCUMENTS))


@st.composite
def truncated(draw: st.DrawFn) -> tuple[str, bytes]:
    """A document cut short anywhere: a brace at least stays open."""
    kind = draw(kinds)
    text = yaml_of(DOCUMENTS[kind][0])
    return kind, text[: draw(st.integers(0, len(text) - 1))].encode()


@st.composite
def replaced(draw: st.DrawFn) -> tuple[str, bytes]:
    """A document in which one value, however deep, is of a wrong type or no value at all."""
    kind = draw(kinds)
    document = DOCUMENTS[kind][0]
    path, bad = draw(st.sampled_from(list(places(document)))), draw(st.sampled_from(BAD_VALUES))
    assume(not ("workspace_m" in path and bad in {"null", "~", ""}))  # a box may be open to some sides
    return kind, yaml_of(with_value(document, path, lambda _: Raw(bad))).encode()


@st.composite
def unknown(draw: st.DrawFn) -> tuple[str, bytes]:
    """A document in which one mapping has a key too many, or one twice."""
    kind = draw(kinds)
    document = DOCUMENTS[kind][0]
    mappings = [p for p in places(document) if isinstance(_at(document, p), dict)]
    path = draw(st.sampled_from([p for p in mappings if _at(document, p) or p != ()]))
    here = yaml_of(_at(document, path))[1:-1]
    key = json.dumps("zz" + draw(st.text(max_size=20)))
    again = draw(st.booleans()) and here
    more = here.split(":")[0] + ": 1" if again else f"{key}: 1"
    return kind, yaml_of(
        with_value(document, path, lambda _: Raw("{" + ", ".join(filter(None, (here, more))) + "}"))
    ).encode()


@st.composite
def garbage(draw: st.DrawFn) -> tuple[str, bytes]:
    """Anything at all, for documents that have keys they cannot do without."""
    signs = st.text(st.sampled_from("{}[]:,-&*a!|>'\"%@`?#<=~ \n\t\\0.e\x85\u2028\ufeff\U0001f41f"), max_size=200)
    data = draw(st.one_of(st.binary(max_size=300), signs.map(str.encode), st.text(max_size=100).map(_encoded)))
    return draw(st.sampled_from(["scenario", "gait", "plan"])), data


@st.composite
def unprintable(draw: st.DrawFn) -> tuple[str, bytes]:
    """A document with a control character, bytes that are no UTF-8, or in another encoding."""
    kind = draw(kinds)
    text = yaml_of(DOCUMENTS[kind][0])
    how = draw(st.sampled_from(["control", "bytes", "utf-16", "utf-32", "utf-16-be", "two"]))
    at = draw(st.integers(0, len(text)))
    if how == "control":
        return kind, (
            text[:at] + draw(st.sampled_from("\0\1\7\x08\x0b\x0c\x1b\x7f\x80\x9b\ufffe\uffff")) + text[at:]
        ).encode()
    if how == "bytes":
        bad = draw(st.sampled_from([b"\xff", b"\xc0\x80", b"\xed\xa0\x80", b"\xf5\x80\x80\x80", b"\xe2\x82", b"\x80"]))
        return kind, text[:at].encode() + bad + text[at:].encode()
    if how == "two":
        return kind, f"{text}\n---\n{text[:at]}".encode()
    return kind, text.encode(how) + b" \0" * draw(st.integers(0, 30))


@st.composite
def nested(draw: st.DrawFn) -> tuple[str, bytes]:
    """A document that is too deep, too long, or explodes by its aliases, whole or as a value."""
    kind = draw(kinds)
    how = draw(st.sampled_from(["deep", "laughs", "long", "keys"]))
    if how == "deep":
        opening = draw(st.sampled_from(["[", "{a: ", "[{a: [", "? ", "- "]))
        bad = opening * draw(st.integers(25, 3000))
    elif how == "laughs":
        width, first = draw(st.integers(8, 12)), draw(st.sampled_from(["[1, 1]", "{a: 1, b: 2}", "xx"]))
        lines = [f"a{k}: &a{k} [{', '.join([f'*a{k - 1}'] * width)}]" for k in range(1, draw(st.integers(6, 15)))]
        bad = "\n".join([f"a0: &a0 {first}", *lines])
    elif how == "long":
        bad = "[" + draw(st.sampled_from(["1,", "[],", "{},", "~,", "a b,"])) * draw(st.integers(20_001, 40_000)) + "]"
    else:
        bad = "{" + ", ".join(f"k{k}: {k}" for k in range(draw(st.integers(10_001, 20_000)))) + "}"
    document = DOCUMENTS[kind][0]
    path = draw(st.sampled_from(list(places(document)))) if how in {"long", "keys"} else ()
    return kind, yaml_of(with_value(document, path, lambda _: Raw(bad))).encode()


def _at(document: Any, path: tuple[str | int, ...]) -> Any:
    for key in path:
        document = document[key]
    return document


def _encoded(text: str) -> bytes:
    return text.encode("utf-8", "replace")


GENERATORS = {g.__name__: g for g in (truncated, replaced, unknown, garbage, unprintable, nested)}


# That each is refused ----------------------------------------------------------------------------------------------


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working folder, with good files in it."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "gaits").mkdir()
    for name, document in (("start", START), ("goal", GOAL)):
        (tmp_path / f"{name}.yaml").write_text(yaml_of(document))
    (tmp_path / "still.csv").write_text(STILL)
    return tmp_path


def file_of(kind: str) -> str:
    """Return where the commands look for a document."""
    return "gaits/bad.yaml" if kind == "gait" else "bad.yaml"


def called(arguments: list[str]) -> tuple[int, str, str]:
    """Run a command in this process; return its exit code, stdout and stderr."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        code = _run(arguments)
    return code, out.getvalue(), err.getvalue()


def assert_refused(code: int, out: str, err: str, json_wanted: bool) -> None:
    """Check that a command ended in misuse, in one clear line, and as one JSON document where that is asked for."""
    assert code == MISUSE, (code, err)
    assert err.startswith("purcell ")
    assert err.endswith("\n")
    assert err.count("\n") == 1, err
    assert err[:-1].isprintable()
    assert len(err) < 2000
    assert "Traceback" not in err
    assert re.search(r": .*wanted.*, found .*", err), err
    if json_wanted:
        assert json.loads(out)["verdict"] == "error"
    else:
        assert not out


def peak_bytes() -> int:
    """Return the largest memory of this process since `forget_peak` [bytes]."""
    found = re.search(r"VmHWM:\s+(\d+) kB", Path("/proc/self/status").read_text())
    assert found
    return int(found[1]) << 10


def forget_peak() -> None:
    """Start the measurement of `peak_bytes` anew."""
    Path("/proc/self/clear_refs").write_text("5")


@pytest.mark.parametrize("share", [pytest.param(1, marks=pytest.mark.slow), 50])
@pytest.mark.parametrize("sort", FUZZ)
def test_thousands_of_bad_documents_are_refused_in_one_clear_line(folder: Path, sort: str, share: int) -> None:
    most = max(1, FUZZ[sort] // share)
    seen: set[tuple[str, bytes]] = set()
    measured = Path("/proc/self/clear_refs").exists()
    if measured:
        forget_peak()
    before = peak_bytes() if measured else 0

    @given(case=GENERATORS[sort]())
    @settings(
        max_examples=2 * most,
        derandomize=True,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    def refused(case: tuple[str, bytes]) -> None:
        if case in seen or len(seen) >= most:
            return
        seen.add(case)
        kind, data = case
        path = folder / file_of(kind)
        path.write_bytes(data)
        arguments = [*DOCUMENTS[kind][1], *(["--json"] if len(seen) % 2 else [])]
        told: list[tuple[int, str, str]] = []
        if len(seen) % COUNTED == 1:  # counting takes longer than refusing
            assert calls(lambda: told.append(called(arguments))) < MOST_CALLS
        else:
            told.append(called(arguments))
        path.unlink()
        assert_refused(*told[0], "--json" in arguments)
        assert sorted(p.name for p in folder.rglob("*")) == ["gaits", "goal.yaml", "start.yaml", "still.csv"]

    refused()
    assert len(seen) == most
    if measured:
        assert peak_bytes() - before < MOST_BYTES


@pytest.mark.parametrize("kind", DOCUMENTS)
def test_what_the_bad_documents_are_made_of_is_good(folder: Path, kind: str) -> None:
    path = folder / file_of(kind)
    path.write_text(yaml_of(DOCUMENTS[kind][0]))
    yaml_source.load(path, KINDS[kind])


# What is no document at all, in a process of its own ---------------------------------------------------------------

_PROGRAM = """
import atexit, os, re, sys
from purcell_cli.cli.app import main

work = 0

def counted(frame, event, argument):
    global work
    work += event == "call"

def told():
    sys.setprofile(None)
    with open("work", "w") as file:
        file.write(str(work))
    if os.path.exists("/proc/self/status"):
        with open("/proc/self/status") as status, open("peak", "w") as file:
            file.write(re.search(r"VmHWM:\\s+(\\d+) kB", status.read())[1])

atexit.register(told)
sys.setprofile(counted)
main()
"""
COMMAND = [sys.executable, "-W", "error", "-c", _PROGRAM]
"""The command, which leaves in files how many functions it called and, where it can be told, its peak of memory."""


def _hundred_megabytes(path: Path) -> None:
    with path.open("wb") as stream:
        for _ in range(100):
            stream.write(b"- a\n" * (1 << 18))


def _loop(path: Path) -> None:
    path.symlink_to("other")
    path.with_name("other").symlink_to(path.name)


def _socket(path: Path) -> None:
    with socket.socket(socket.AF_UNIX) as server:
        server.bind(path.name)


_pipe: Callable[[Path], object] = getattr(os, "mkfifo", Path.touch)

ODDITIES: dict[str, tuple[Callable[[Path], object], list[str]]] = {
    "a file of 100 MB": (_hundred_megabytes, ["plan", "bad", "goal.yaml"]),
    "a plan of 100 MB": (_hundred_megabytes, ["run", "bad"]),
    "a folder": (Path.mkdir, ["plan", "start.yaml", "bad", "--json"]),
    "a loop of links": (_loop, ["plan", "start.yaml", "goal.yaml", "--swimmer", "bad"]),
    "a socket": (_socket, ["plan", "bad", "goal.yaml"]),
    "a pipe that nobody writes to": (_pipe, ["plan", "start.yaml", "bad"]),
    "a pipe as a scenario": (_pipe, ["plan", "bad", "--json"]),
    "a device without end": (lambda p: p.symlink_to("/dev/zero"), ["run", "bad"]),
    "a trajectory without end": (lambda p: p.symlink_to("/dev/zero"), ["verify", "bad", "start.yaml", "goal.yaml"]),
    "a pipe to write to": (_pipe, ["plan", "start.yaml", "goal.yaml", "--out", "bad"]),
    "nesting without end": (lambda p: p.write_text("[" * 1_000_000), ["plan", "bad", "goal.yaml"]),
    "a bomb of aliases": (
        lambda p: p.write_text("\n".join(["a0: &a0 x", *(f"a{k}: &a{k} [{f'*a{k - 1},' * 9}]" for k in range(1, 40))])),
        ["plan", "bad"],
    ),
}


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes with names")
@pytest.mark.parametrize("name", mostly_slow(ODDITIES, 0))
def test_what_is_no_document_is_refused_with_little_work_and_memory(folder: Path, name: str) -> None:
    make, arguments = ODDITIES[name]
    make(folder / "bad")
    before = _listed(folder)
    with (folder / "out").open("w+") as out, (folder / "err").open("w+") as err:
        environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
        process = subprocess.Popen([*COMMAND, *arguments], stdout=out, stderr=err, env=environment)
        try:
            process.wait(60.0)
        except subprocess.TimeoutExpired:
            process.kill()
            pytest.fail("it hangs")
        out.seek(0)
        err.seek(0)
        assert_refused(process.returncode, out.read(), err.read(), "--json" in arguments)
    assert 0 < int((folder / "work").read_text()) < MOST_CALLS
    peak = folder / "peak"
    if peak.exists():
        assert 0 < int(peak.read_text()) << 10 < MOST_BYTES
    for made in ("out", "err", "work", "peak"):
        (folder / made).unlink(missing_ok=True)
    assert _listed(folder) == before


def _listed(folder: Path) -> dict[str, int]:
    """Return the names below a folder, each with the kind and mode of what it is."""
    return {str(p.relative_to(folder)): p.lstat().st_mode for p in folder.rglob("*")}


# Numbers that are finite, and far out of bounds --------------------------------------------------------------------

EXTREMES = {
    "far beyond all doubles' sense": ("goal", {"base": {"position_m": [1e308, 0, 0]}}),
    "on opposite sides": ("goal", {"base": {"position_m": [-1e15, 1e15, 0]}}),
    "a billion lengths away": ("goal", {"base": {"position_m": [1.1e8, 0, 0]}}),
    "a box without sense": ("goal", {"workspace_m": {"min": [-1e308, -1, -1], "max": [1e308, 1, 1]}}),
    "a quaternion that overflows": ("goal", {"limb1": {"quaternion_wxyz": [1e308, 1e308, 0, 0]}}),
    "a matrix that overflows": ("goal", {"limb1": {"matrix": [[1e308, 1e308, 0], [0, 1e308, 0], [0, 0, 1]]}}),
    "links of no length": ("swimmer", {"base_half_length_m": 5e-324, "limb_half_length_m": 5e-324}),
    "links of no thickness": ("swimmer", {"slenderness": 5e-324}),
    "thinner than atoms": ("swimmer", {"slenderness": 1e-12}),
    "no bend": ("swimmer", {"max_bend_rad": 5e-324}),
    "hardly a bend": ("swimmer", {"max_bend_rad": 1e-12}),
    "no rate": ("swimmer", {"joint_rate_rad_s": 5e-324}),
    "no viscosity": ("swimmer", {"viscosity_pa_s": 5e-324}),
}


@pytest.mark.parametrize("name", EXTREMES)
def test_numbers_far_out_of_bounds_are_refused_before_they_overflow(folder: Path, name: str) -> None:
    kind, document = EXTREMES[name]
    (folder / "bad.yaml").write_text(yaml_of(document))
    before = _listed(folder)
    told: list[tuple[int, str, str]] = []
    assert calls(lambda: told.append(called(DOCUMENTS[kind][1]))) < MOST_CALLS
    assert_refused(*told[0], json_wanted=False)
    assert _listed(folder) == before
