"""JSON documents are what their types say, key by key, and the page about them is made from those types."""

from __future__ import annotations

import copy
import importlib.util
import json
import math
import types
from collections.abc import Iterator
from enum import Enum
from pathlib import Path
from typing import Annotated, Any, Literal, NotRequired, TypedDict, Union, get_args, get_origin, get_type_hints
from typing import is_typeddict as is_document

import pytest

from purcell_cli import Controls
from purcell_cli.cli import pictures
from purcell_cli.cli.documents.catalogue import DOCUMENTS
from purcell_cli.cli.documents.common import Failure

ROOT = Path(__file__).resolve().parent.parent


def faults(value: Any, kind: Any, place: str = "") -> Iterator[str]:
    """Return where a JSON value is not what a type says, key by key."""
    origin, inner = get_origin(kind), get_args(kind)
    if origin in {Annotated, NotRequired}:
        yield from faults(value, inner[0], place)
    elif origin in {Union, types.UnionType}:
        tries = [list(faults(value, one, place)) for one in inner]
        if all(tries):  # told by the alternative that goes deepest
            yield from max(tries, key=lambda found: len(found[0].partition(":")[0]))
    elif is_document(kind) or origin in {list, dict}:
        yield from _faults_inside(value, kind, place)
    elif not _fits(value, kind):
        yield f"{place}: wanted {kind}, found {value!r}"


def _faults_inside(value: Any, kind: Any, place: str) -> Iterator[str]:
    origin, inner = get_origin(kind), get_args(kind)
    wanted = list if origin is list else dict
    if type(value) is not wanted:
        yield f"{place}: wanted a {wanted.__name__}, found {value!r}"
    elif is_document(kind):
        yield from _faults_of_document(value, kind, place)
    else:
        items = enumerate(value) if origin is list else value.items()
        for key, item in items:
            yield from faults(item, inner[-1], f"{place}[{key}]" if origin is list else f"{place}.{key}")


def _faults_of_document(value: Any, kind: Any, place: str) -> Iterator[str]:
    hints = get_type_hints(kind, include_extras=True)
    order = [key for key in hints if key in value]
    for key, hint in hints.items():
        if key in value:
            yield from faults(value[key], hint, f"{place}.{key}")
        elif get_origin(hint) is not NotRequired:
            yield f"{place}.{key}: wanted, found no such key"
    yield from (f"{place}.{key}: wanted no such key" for key in value if key not in hints)
    if [key for key in value if key in hints] != order and kind in DOCUMENTS.values():
        yield f"{place}: wanted the keys in the order {order}, found {list(value)}"


def _fits(value: Any, kind: Any) -> bool:
    if kind is Any:
        return True
    if get_origin(kind) is Literal:
        return type(value) is str and value in get_args(kind)
    if issubclass(kind, Enum):
        return type(value) is str and value in list(kind)
    if kind is float:  # JSON knows one kind of number
        return type(value) in {float, int} and math.isfinite(value)
    return type(value) is kind


def wrong(document: dict[str, Any]) -> list[str]:
    """Return the faults of a document, by the type that its schema names."""
    kind = Failure if document["verdict"] == "error" else DOCUMENTS[document["schema"]]
    return list(faults(document, kind))


# --- The checker -----------------------------------------------------------------------------------------------------


class Part(TypedDict):
    size_m: Annotated[float, "a size [m]"]
    count: int


class Sample(TypedDict):
    schema: Annotated[Literal["sample"], "the form"]
    controls: Annotated[Controls, "how"]
    parts: Annotated[list[Part], "parts"]
    named: dict[str, float]
    either: Annotated[Part | None, "a part"]
    told: NotRequired[Annotated[str, "what is told"]]


GOOD = {
    "schema": "sample",
    "controls": "primitive",
    "parts": [{"size_m": 1.0, "count": 2}],
    "named": {"a": 0.5},
    "either": None,
}


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        ({}, None),
        ({"told": "yes"}, None),
        ({"parts": [{"size_m": 0, "count": 2}]}, None),
        ({"either": {"size_m": 0.0, "count": 0}}, None),
        ({"told": None}, ".told: wanted"),
        ({"schema": "other"}, ".schema: wanted"),
        ({"controls": "both"}, ".controls: wanted"),
        ({"controls": "PRIMITIVE"}, ".controls: wanted"),
        ({"parts": {}}, ".parts: wanted a list"),
        ({"parts": [{"size_m": 1.0}]}, ".parts[0].count: wanted, found no such key"),
        ({"parts": [{"size_m": 1.0, "count": 2, "more": 1}]}, ".parts[0].more: wanted no such key"),
        ({"parts": [{"size_m": "1", "count": 2}]}, ".parts[0].size_m: wanted"),
        ({"parts": [{"size_m": True, "count": 2}]}, ".parts[0].size_m: wanted"),
        ({"parts": [{"size_m": 1.0, "count": 2.0}]}, ".parts[0].count: wanted"),
        ({"parts": [{"size_m": 1.0, "count": True}]}, ".parts[0].count: wanted"),
        ({"parts": [{"size_m": math.nan, "count": 1}]}, ".parts[0].size_m: wanted"),
        ({"parts": [{"size_m": None, "count": 1}]}, ".parts[0].size_m: wanted"),
        ({"named": {"a": "b"}}, ".named.a: wanted"),
        ({"either": {"size_m": 0.0}}, ".either.count: wanted, found no such key"),
        ({"more": 1}, ".more: wanted no such key"),
    ],
)
def test_the_checker_finds_what_is_wrong(change: dict[str, Any], fault: str | None) -> None:
    found = list(faults({**GOOD, **change}, Sample))
    assert len(found) == (fault is not None), found
    assert all(one.startswith(str(fault)) for one in found)


def test_the_checker_finds_a_key_that_is_gone() -> None:
    for key in GOOD:
        assert list(faults({k: v for k, v in GOOD.items() if k != key}, Sample)) == [
            f".{key}: wanted, found no such key"
        ]


# --- Real documents --------------------------------------------------------------------------------------------------

OUTSIDE = """name: outside
start: {}
goal: {base: {position_m: [0.02, 0, 0]}}
workspace_m: {min: [-0.5, -0.01, -0.01], max: [0.5, 0.01, 0.01]}
"""

TRUTH = """drag: {base: {along_n_s_per_m: 0.2}, limb1: {turn_n_m_s: 2.0e-3, spin_n_m_s: 1.0e-5}}
links: {limb2: {half_length_m: 0.08, slenderness: 0.02}}
body_radius_m: 0.02
"""

BATCH = {
    "still.yaml": "name: still\nstart: {}\ngoal: {}\n",
    "failing.yaml": "name: failing\nstart: {}\ngoal: {}\nexpect: {verdict: not reached}\n",
    "refused.yaml": "name: refused\nstart: {limb3: {}}\ngoal: {}\n",
    "swept.yaml": "name: swept\nstart: {}\ngoal: {}\nsweep: {swimmer.drag_ratio: [1.9, 2.0]}\n",
}

COMMANDS = {
    "plan": ["plan", "nearby", "--effort", "quick", "--plan-out", "plan.json", "--out", "swim.csv"],
    "plan explained": ["plan", "nearby", "--effort", "quick", "--explain"],
    "plan of nothing": ["plan", "batch/still.yaml", "--explain"],
    "plan outside": ["plan", "outside.yaml", "--effort", "quick"],
    "run": ["run", "plan.json", "--out", "again.csv"],
    "verify": ["verify", "swim.csv", "nearby"],
    "verify a fault": ["verify", "swim.csv", "roll"],
    "simulate": ["simulate", "swim.csv", "--swimmer", "truth.yaml", "--noise", "rate=0.02", "--out", "real.csv"],
    "simulate a plan": ["simulate", "plan.json", "--swimmer", "truth.yaml"],
    "replan": ["replan", "plan.json", "--from", "start.yaml", "--out", "rest.csv"],
    "track": ["track", "roll", "--truth", "truth.yaml", "--replans", "1", "--out", "tracked.csv"],
    "fit": ["fit", "swim.csv", "--what", "ratio", "--out", "fitted.yaml"],
    "gait": ["gait", "x-motion"],
    "gait of moves": ["gait", "max-efficiency"],
    "gait list": ["gait", "--list"],
    "atlas": ["gait", "--all"],
    "sweep": ["gait", "x-motion", "--sweep", "0.5:1.0:0.5"],
    "sweep of turns": ["gait", "x-rotation", "--sweep", "0.5:1.0:0.5", "--out", "sweep.csv"],
    "link ratio": ["gait", "x-motion", "--link-ratio", "0.5:1.0:0.5"],
    "design": ["design", "--max-bend", "2.5", "--controls", "primitive", "--moves", "4", "--starts", "1"],
    "controllability": ["controllability", "--depth", "3"],
    "planar": ["controllability", "--planar", "--depth", "3"],
    "map": ["controllability", "--map", "--depth", "2"],
    "batch": ["batch", "batch", "--out", "found"],
    "plot": ["plot", "swim.csv", "--out", "swim.svg"],
    "plot a gait": ["plot", "x-motion", "--out", "gait.svg"],
    "figures": ["figures"],
    "view": ["view", "swim.csv"],
    "film": ["view", "swim.csv", "--out", "swim.gif", "--duration", "0.2", "--size", "64x64"],
    "export to servos": ["export", "swim.csv", "--to", "servo"],
    "export to urdf": ["export", "swim.csv", "--to", "urdf"],
    "init": ["init", "new"],
    "validate": ["validate", "batch/still.yaml", "batch/refused.yaml", "outside.yaml"],
    "schema in a file": ["schema", "start", "--out", "start.schema.json"],
    "failure": ["plan", "nowhere.yaml"],
    "misuse": ["plan", "nearby", "--dt", "soon"],
}


@pytest.fixture(scope="module")
def documents(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    """Return a real document of each command, and the summary of a batch, by what they are."""
    folder = tmp_path_factory.mktemp("documents")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        patch.setattr(pictures, "PAPER_MOTIONS", ("x-motion",))
        patch.setattr(pictures, "PRINTED", ())
        (folder / "outside.yaml").write_text(OUTSIDE)
        (folder / "truth.yaml").write_text(TRUTH)
        (folder / "start.yaml").write_text("limb1: {euler_deg: [2, 0, 0]}\n")
        (folder / "batch").mkdir()
        for name, text in BATCH.items():
            (folder / "batch" / name).write_text(text)
        found = {name: _printed(arguments) for name, arguments in COMMANDS.items()}
        found["batch summary"] = json.loads((folder / "found" / "summary.json").read_text())
    return found


def _printed(arguments: list[str]) -> dict[str, Any]:
    import contextlib
    import io

    from purcell_cli.cli.app import _run

    out = io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()):
        _run([*arguments, "--json"])
    document: dict[str, Any] = json.loads(out.getvalue())
    return document


@pytest.mark.slow
def test_every_document_is_looked_at(documents: dict[str, dict[str, Any]]) -> None:
    good = {d["schema"] for d in documents.values() if d["verdict"] != "error"}
    assert good == set(DOCUMENTS)
    assert {name for name, d in documents.items() if d["verdict"] == "error"} == {"failure", "misuse"}
    assert documents["plan outside"]["limits"]["violations"]
    assert documents["plan explained"]["explanation"]["sensitivity"]
    assert "turn_rad" in documents["gait of moves"]["cycle"][0]
    assert documents["verify a fault"]["faults"]
    assert {row["verdict"] for row in documents["batch summary"]["rows"]} == {"reached", "error"}
    assert documents["batch"]["failures"]


@pytest.mark.slow
@pytest.mark.parametrize("name", [*COMMANDS, "batch summary"])
def test_a_document_is_what_its_type_says(documents: dict[str, dict[str, Any]], name: str) -> None:
    assert wrong(documents[name]) == []


@pytest.mark.slow
@pytest.mark.parametrize("name", [*COMMANDS, "batch summary"])
def test_a_document_with_any_key_gone_renamed_or_of_another_type_is_found_out(
    documents: dict[str, dict[str, Any]], name: str
) -> None:
    good = documents[name]
    for key in good.keys() - {"schema", "verdict", "explanation", "rest"}:
        gone, renamed, other = (copy.deepcopy(good) for _ in range(3))
        renamed[f"{key}_"] = renamed.pop(key)
        del gone[key]
        other[key] = object()
        assert wrong(gone) == [f".{key}: wanted, found no such key"]
        assert f".{key}_: wanted no such key" in wrong(renamed)
        assert len(wrong(other)) == 1, key


# --- The page --------------------------------------------------------------------------------------------------------


def test_the_page_is_what_the_types_say() -> None:
    spec = importlib.util.spec_from_file_location("json_reference", ROOT / "tools" / "json_reference.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    page = (ROOT / "docs" / "reference" / "json.md").read_text(encoding="utf-8")
    assert module.page() == page, "python tools/json_reference.py brings the page up to date"
    headings = [line for line in page.splitlines() if line.startswith("#")]
    assert len(headings) == len(set(headings)), "two parts have one name"
    for name in DOCUMENTS:
        assert f"`{name}`" in page


def test_every_key_has_a_meaning_and_every_number_of_a_quantity_its_unit() -> None:
    units = {
        "_n_s_per_m": "[N s/m]",
        "_n_m_s": "[N m s]",
        "_rad_s": "[rad/s]",
        "_m_s": "[m/s]",
        "_pa_s": "[Pa s]",
        "_rad": "rad]",
        "_m": "[m]",
        "_s": "[s]",
        "_j": "[J]",
        "_deg": "[deg]",
    }
    kinds, seen = [Failure, *DOCUMENTS.values()], set()
    while kinds:
        kind = kinds.pop()
        if is_document(kind) and kind not in seen:
            seen.add(kind)
            for key, hint in get_type_hints(kind, include_extras=True).items():
                inner = get_args(hint)[0] if get_origin(hint) is NotRequired else hint
                assert get_origin(inner) is Annotated, (kind, key)
                meaning = get_args(inner)[1]
                assert meaning.strip(), (kind, key)
                ending = next((end for end in units if key.endswith(end)), None)
                if ending is not None:
                    assert units[ending] in meaning, (kind, key)
        kinds += get_args(kind) if not is_document(kind) else get_type_hints(kind).values()
    assert len(seen) > len(set(DOCUMENTS.values())) + 10
