"""The elements of a document: what they read, and that their JSON Schema says the same."""

from __future__ import annotations

import json
import re
from typing import Any

import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from purcell_cli.errors import InputError, ParameterError
from purcell_cli.files.containers import Either, Field, ListOf, MapOf, Pair, Record
from purcell_cli.files.documents import Made
from purcell_cli.files.elements import Element
from purcell_cli.files.place import Place, shortened
from purcell_cli.files.scalars import Choice, Flag, Number, Text, Whole
from purcell_cli.files.scenario_file import SCHEMAS
from purcell_cli.mechanics.swimmer import LIMITS, Swimmer


def read(element: Element[Any], text: str) -> Any:
    return element.read(place_of(text))


def place_of(text: str) -> Place:
    node = yaml.compose(text, yaml.SafeLoader)
    assert node is not None
    return Place("f", node)


def allows(rules: dict[str, Any], value: Any) -> bool:
    """Return whether a JSON Schema of the keywords in use allows a value: a second, independent reading."""
    if "anyOf" in rules:
        return any(allows(r, value) for r in rules["anyOf"])
    if "enum" in rules:
        return value in rules["enum"]
    if rules["type"] == "integer" and (isinstance(value, float) and not value.is_integer()):
        return False
    if rules["type"] in {"number", "integer"}:
        low, least, most = rules.get("exclusiveMinimum"), rules.get("minimum"), rules.get("maximum")
        is_number = isinstance(value, int | float) and not isinstance(value, bool)
        return (
            is_number
            and (low is None or value > low)
            and (least is None or value >= least)
            and (most is None or value <= most)
            and not ("not" in rules and value == rules["not"]["const"])
        )
    if rules["type"] == "boolean":
        return isinstance(value, bool)
    if rules["type"] == "string":
        return isinstance(value, str) and re.search(rules["pattern"], value) is not None
    if rules["type"] == "array":
        size = isinstance(value, list) and rules.get("minItems", 0) <= len(value) <= rules.get("maxItems", len(value))
        if not size:
            return False
        places = rules["prefixItems"] if "prefixItems" in rules else [rules["items"]] * len(value)
        return all(allows(inner, item) for inner, item in zip(places, value, strict=True))
    return isinstance(value, dict) and allows_mapping(rules, value)


def allows_mapping(rules: dict[str, Any], value: dict[str, Any]) -> bool:
    if not rules.get("minProperties", 0) <= len(value) <= rules.get("maxProperties", len(value)):
        return False
    if not set(rules.get("required", ())) <= set(value):
        return False
    if "propertyNames" in rules:
        names = all(re.search(rules["propertyNames"]["pattern"], key) for key in value)
        return names and all(allows(rules["additionalProperties"], item) for item in value.values())
    known = rules["properties"]
    return set(value) <= set(known) and all(allows(known[key], item) for key, item in value.items())


ELEMENTS: list[Element[Any]] = [
    Number(),
    Number(above=0.0, at_most=2.0),
    Number(at_least=-1.0, nonzero=True),
    Whole(0, 2),
    Flag(),
    Choice(("a", "b")),
    Made(Pair(Choice(("a", "b")), Number(at_least=0.0)), lambda pair, _: list(pair)),
    Text(r"[ab]+", "letters"),
    ListOf(Number(), 2),
    ListOf(Flag(), at_least=1),
    ListOf(Choice(("a",))),
    Record({"a": Field(Number(), required=True), "b": Field(Flag())}),
    Record({"a": Field(Number()), "b": Field(Flag())}, exactly_one=True),
    MapOf(Text(r"[ab]", "a letter"), Number()),
    Either(Number(), Record({"a": Field(Number())})),
]

scalars = st.one_of(st.sampled_from([-1, 0, 1, 2, 2.5, True, False, "a", "b", "c", "ab", "1", None]))
values = st.recursive(
    scalars, lambda v: st.lists(v, max_size=3) | st.dictionaries(st.sampled_from("abc"), v, max_size=2), max_leaves=4
)


@pytest.mark.slow
@pytest.mark.parametrize("element", ELEMENTS)
@given(value=values)
def test_an_element_reads_just_what_its_json_schema_allows(element: Element[Any], value: Any) -> None:
    text = yaml.safe_dump(value)
    if allows(element.json_schema(), value):
        assert read(element, text) == value
    else:
        with pytest.raises(InputError, match=r"^f:\d+: .*: wanted .*, found .*$"):
            read(element, text)


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_document_prints_itself_as_json_schema(name: str) -> None:
    rules = SCHEMAS[name].json_schema()
    assert rules == json.loads(json.dumps(rules, allow_nan=False))
    assert rules["$schema"] == "https://json-schema.org/draft/2020-12/schema"
    assert rules["type"] == "object"
    assert rules["additionalProperties"] is False


def test_the_json_schema_of_a_swimmer_has_its_limits_and_defaults() -> None:
    properties: Any = SCHEMAS["swimmer"].json_schema()["properties"]
    own = {"fluid", "wall", "drag", "links", "body_radius_m", "joints", "joint_acceleration_rad_s2"}
    assert set(properties) == {*LIMITS, *own}
    assert properties["fluid"]["enum"] == ["local", "beads"]
    for name, (low, high) in LIMITS.items():
        rules = properties[name]
        assert (rules["exclusiveMinimum"], rules["maximum"], rules["default"]) == (low, high, getattr(Swimmer(), name))


def test_the_names_of_documents_are_those_of_the_command() -> None:
    assert list(SCHEMAS) == ["start", "goal", "swimmer", "scenario", "gait"]


@pytest.mark.parametrize(
    ("message", "key", "rest"),
    [
        ("a: one is wanted, found two", "k.a", "wanted one, found two"),
        ("one is wanted, found two", "k", "wanted one, found two"),
        ("no form that is known", "k", "wanted a value that can be, found no form that is known"),
    ],
)
def test_a_parameter_error_gets_the_place_it_speaks_of(message: str, key: str, rest: str) -> None:
    def make(_: Any, __: Place) -> None:
        raise ParameterError(message)

    element = Record({"k": Field(Made(MapOf(Text(), Number()), make))})
    with pytest.raises(InputError) as caught:
        read(element, "k:\n  b: 1\n  a: 2")
    assert str(caught.value) == f"f:{3 if key == 'k.a' else 2}: {key}: {rest}"


def test_a_place_that_is_not_there_keeps_its_parents_line() -> None:
    place = place_of("a:\n  - 1\n  - 2")
    assert (place.at("a", 1).line, place.at("a", 1).key) == (3, "a[1]")
    assert (place.at("a", 5).line, place.at("a", 5).key) == (2, "a[5]")
    assert (place.at("b", "c").line, place.at("b", "c").key) == (1, "b.c")


@pytest.mark.slow
@given(text=st.text(), most=st.integers(3, 80))
def test_a_shortened_text_is_one_printable_line(text: str, most: int) -> None:
    found = shortened(text, most)
    assert found.isprintable()
    assert len(found) <= most
