"""Frozen dataclasses with shared methods do what those of the standard library do."""

from __future__ import annotations

import dataclasses
import inspect
import pickle
from pathlib import Path

import pytest

from purcell_cli.frozen_dataclass import frozen_dataclass

PACKAGE = Path(__file__).resolve().parent.parent / "purcell_cli"


@frozen_dataclass
class Ours:
    """A thing."""

    first: int
    second: list[int] = dataclasses.field(default_factory=list)
    aside: str = dataclasses.field(default="a", compare=False, repr=False)


@dataclasses.dataclass(frozen=True, slots=True)
class Theirs:
    """A thing."""

    first: int
    second: list[int] = dataclasses.field(default_factory=list)
    aside: str = dataclasses.field(default="a", compare=False, repr=False)


@frozen_dataclass(slots=False)
class More(Ours):
    """A thing with more, which it works out."""

    third: float = 0.5
    kept: dict[int, int] = dataclasses.field(init=False, default_factory=dict)

    def __post_init__(self) -> None:
        object.__setattr__(self, "third", 2.0 * self.third)

    def __repr__(self) -> str:
        return "its own words"


@frozen_dataclass(eq=False, kw_only=True)
class Named:
    """A thing that is equal to itself only."""

    first: int
    second: int = 3


@dataclasses.dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class TheirsNamed:
    """A thing that is equal to itself only."""

    first: int
    second: int = 3


BOTH = pytest.mark.parametrize("kind", [Ours, Theirs])


@BOTH
@pytest.mark.parametrize("given", [((1,), {}), ((1, [2]), {"aside": "b"}), ((), {"first": 3, "second": [4]})])
def test_it_takes_what_the_standard_one_takes(kind, given):
    args, named = given
    made, other = kind(*args, **named), Theirs(*args, **named)
    assert dataclasses.astuple(made) == dataclasses.astuple(other)
    assert repr(made).partition("(")[2] == repr(other).partition("(")[2]
    assert dataclasses.asdict(dataclasses.replace(made, first=7)) == dataclasses.asdict(
        dataclasses.replace(other, first=7)
    )
    assert pickle.loads(pickle.dumps(made)) == made


@BOTH
@pytest.mark.parametrize(
    "given", [((), {}), ((1, [2], "a", 4), {}), ((1,), {"first": 1}), ((1,), {"fourth": 1}), ((), {"second": [1]})]
)
def test_it_refuses_what_the_standard_one_refuses(kind, given):
    args, named = given
    with pytest.raises(TypeError):
        kind(*args, **named)


@BOTH
def test_fields_stay_as_they_are(kind):
    made = kind(1)
    with pytest.raises(dataclasses.FrozenInstanceError, match="'first'"):
        made.first = 2
    with pytest.raises(dataclasses.FrozenInstanceError, match="'first'"):
        del made.first
    with pytest.raises((AttributeError, TypeError)):
        made.fifth = 2
    assert made.first == 1
    assert not hasattr(made, "__dict__")


@BOTH
def test_equality_and_hash_are_of_the_fields_that_compare(kind):
    one, same, other = kind(1, (2,), "a"), kind(1, (2,), "b"), kind(1, (3,), "a")
    assert one == same
    assert hash(one) == hash(same)
    assert one != other
    assert one != (1, (2,))


def test_without_eq_each_is_itself_only():
    one = Named(first=1)
    assert one != Named(first=1)
    assert len({one, Named(first=1)}) == 2
    with pytest.raises(TypeError):
        Named(1)


def test_classes_grow_from_others_and_keep_their_own_methods():
    made = More(1, third=1.5)
    assert (made.third, made.kept, repr(made)) == (3.0, {}, "its own words")
    assert made.kept is not More(1).kept
    with pytest.raises(TypeError, match="kept"):
        More(1, kept={})


@pytest.mark.parametrize(("kind", "same"), [(Ours, Theirs), (Named, TheirsNamed)])
def test_help_shows_what_is_taken(kind, same):
    ours, theirs = inspect.signature(kind), inspect.signature(same)
    assert list(ours.parameters) == list(theirs.parameters)
    for name, parameter in ours.parameters.items():
        other = theirs.parameters[name]
        assert (parameter.kind, parameter.annotation) == (other.kind, other.annotation)
        assert (parameter.default is inspect.Parameter.empty) == (other.default is inspect.Parameter.empty)


def test_the_package_has_no_other_frozen_dataclasses():
    # One of the standard library's takes ten times as long to make, whenever the package is imported.
    texts = {path.name: path.read_text(encoding="utf-8") for path in PACKAGE.rglob("*.py")}
    assert [name for name, text in texts.items() if "dataclass(frozen=True" in text] == []
