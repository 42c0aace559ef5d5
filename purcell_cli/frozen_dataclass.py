"""Frozen dataclasses that share their methods.

`dataclasses.dataclass` writes and compiles up to six functions for every class: for the some 140 classes of a plan a
fifth of a start from the shell. Here it only collects the fields, and all classes have the same few methods. They are
dataclasses to `dataclasses.replace`, `fields`, `asdict` and to type checkers. Not by `attrs`, which compiles functions
too, nor by `msgspec`, whose classes are no dataclasses.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from operator import attrgetter
from typing import Any, TypeVar, cast, dataclass_transform, overload

Kind = TypeVar("Kind")


@overload
def frozen_dataclass(kind: type[Kind], /) -> type[Kind]: ...


@overload
def frozen_dataclass(
    *, slots: bool = ..., eq: bool = ..., kw_only: bool = ...
) -> Callable[[type[Kind]], type[Kind]]: ...


@dataclass_transform(frozen_default=True, field_specifiers=(dataclasses.field,))
def frozen_dataclass(
    kind: type[Kind] | None = None, /, *, slots: bool = True, eq: bool = True, kw_only: bool = False
) -> type[Kind] | Callable[[type[Kind]], type[Kind]]:
    """Make a class a frozen dataclass; methods that it defines itself stay.

    Args:
        kind: The class, where the decorator stands without parentheses.
        slots: Whether instances have slots for their fields, and nothing else.
        eq: Whether instances are equal where their fields are; else each is equal to itself only.
        kw_only: Whether all fields are given by name.
    """

    def made(plain: type[Kind]) -> type[Kind]:
        out = dataclasses.dataclass(init=False, repr=False, eq=False, slots=slots, kw_only=kw_only)(plain)
        fields = dataclasses.fields(cast(Any, out))
        methods: dict[str, object] = {
            "__init__": _initialiser(out, fields),
            "__signature__": _Signature(),
            "__setattr__": _refuse_to_set,
            "__delattr__": _refuse_to_delete,
        }
        own: dict[str, object] = {"__repr__": _words}
        if slots:
            own |= {"__getstate__": _state, "__setstate__": _restore}
        if eq:
            own |= _comparison(fields)
        for name, method in (methods | {name: one for name, one in own.items() if name not in vars(plain)}).items():
            setattr(out, name, method)
        return out

    return made if kind is None else made(kind)


_put: Callable[[object, str, object], None] = object.__setattr__


def _initialiser(kind: type, fields: tuple[dataclasses.Field[Any], ...]) -> Callable[..., None]:
    """Return a class's `__init__`."""
    first = [f.name for f in fields if f.init and not f.kw_only]
    later = [f.name for f in fields if f.init and f.kw_only]
    own = [f.name for f in fields if not f.init and f.default_factory is not dataclasses.MISSING]
    default = {f.name: f.default for f in fields if f.default is not dataclasses.MISSING}
    factory = {f.name: f.default_factory for f in fields if f.default_factory is not dataclasses.MISSING}
    begun = cast("Callable[[object], None] | None", getattr(kind, "__post_init__", None))

    def initialise(self: object, /, *given: object, **named: object) -> None:
        for name, value in zip(first, given, strict=False):
            _put(self, name, value)
        for name in [*first[len(given) :], *later]:
            if name in named:
                _put(self, name, named.pop(name))
            elif name in default:
                _put(self, name, default[name])
            elif name in factory:
                _put(self, name, factory[name]())
            else:
                raise TypeError(f"{kind.__qualname__}: missing argument {name!r}")
        if named or len(given) > len(first):
            raise TypeError(_too_many(kind.__qualname__, len(first), len(given), list(named)))
        for name in own:
            _put(self, name, factory[name]())
        if begun is not None:
            begun(self)

    return initialise


def _too_many(kind: str, most: int, found: int, named: list[str]) -> str:
    if named:
        return f"{kind}: unexpected keyword argument {named[0]!r}"
    return f"{kind}: at most {most} positional arguments are wanted, found {found}"


class _Signature:
    """What a class takes, made when it is asked for."""

    def __get__(self, _instance: object, kind: type) -> object:
        from inspect import Parameter, Signature  # here and not above: only those who ask for help need it

        def parameter(field: dataclasses.Field[Any]) -> Parameter:
            way = Parameter.KEYWORD_ONLY if field.kw_only else Parameter.POSITIONAL_OR_KEYWORD
            defaults = [d for d in (field.default, field.default_factory) if d is not dataclasses.MISSING]
            return Parameter(field.name, way, default=(*defaults, Parameter.empty)[0], annotation=field.type)

        asked = [f for f in dataclasses.fields(cast(Any, kind)) if f.init]
        return Signature([parameter(f) for f in sorted(asked, key=lambda f: bool(f.kw_only))], return_annotation=None)


def _comparison(fields: tuple[dataclasses.Field[Any], ...]) -> dict[str, object]:
    """Return `__eq__` and `__hash__` by the fields that are compared; instances are keys of many caches."""
    compared = attrgetter(*(f.name for f in fields if f.compare), "__class__")

    def equal(self: object, other: object) -> bool:
        if other.__class__ is not self.__class__:
            return cast("bool", NotImplemented)
        return bool(compared(self) == compared(other))

    def hashed(self: object) -> int:
        return hash(compared(self))

    return {"__eq__": equal, "__hash__": hashed}


def _refuse_to_set(_self: object, name: str, _value: object) -> None:
    raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")


def _refuse_to_delete(_self: object, name: str) -> None:
    raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")


def _words(self: object) -> str:
    shown = [f.name for f in dataclasses.fields(cast(Any, self)) if f.repr]
    return f"{type(self).__qualname__}({', '.join(f'{name}={getattr(self, name)!r}' for name in shown)})"


def _state(self: object) -> list[object]:
    return [getattr(self, f.name) for f in dataclasses.fields(cast(Any, self))]


def _restore(self: object, state: list[object]) -> None:
    for field, value in zip(dataclasses.fields(cast(Any, self)), state, strict=True):
        _put(self, field.name, value)
