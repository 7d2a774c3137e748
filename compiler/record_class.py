"""The decorator of records: `dataclasses.dataclass` that compiles nothing in advance.

The standard one compiles six methods of each class with `exec`, most of which are never called; for
350 classes this was half of the time in which the compiler is loaded. Here `__init__` is compiled
when the first instance is made, and the other methods are closures over the names of the fields.
Type checkers see the standard decorator. The module is at the bottom of the layers, as
diagnostics are records too.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable
from dataclasses import asdict, astuple, field, fields, is_dataclass, replace
from operator import attrgetter
from reprlib import recursive_repr
from types import MemberDescriptorType
from typing import TYPE_CHECKING, Any

__all__ = ["asdict", "astuple", "dataclass", "field", "fields", "is_dataclass", "replace"]

if TYPE_CHECKING:
    from dataclasses import dataclass
else:

    def dataclass(cls=None, /, **options):
        """Decorate a class as `dataclasses.dataclass` does, with its options except `order`."""
        return _decorated(cls, **options) if cls else lambda cls: _decorated(cls, **options)


def _decorated(
    cls: type,
    *,
    init: bool = True,
    repr: bool = True,
    eq: bool = True,
    frozen: bool = False,
    slots: bool = False,
    kw_only: bool = False,
) -> type:
    own = set(vars(cls))
    if "__eq__" in own and cls.__hash__ is None:
        own.remove("__hash__")  # Python has put it there
    if not cls.__doc__:
        cls.__doc__ = cls.__name__  # instead of a signature, which takes a millisecond
    # The fields, their order and the slots; all methods follow.
    cls = dataclasses.dataclass(init=False, repr=False, eq=False, slots=slots, kw_only=kw_only)(cls)
    methods: dict[str, Any] = {}
    if init:
        methods |= {"__init__": _init_at_first_use(cls), "__signature__": _Signature()}
    if repr:
        methods["__repr__"] = _repr([f.name for f in fields(cls) if f.repr])
    if eq:
        values = _values([f.name for f in fields(cls) if f.compare])
        counted = [(f.name, f.compare if f.hash is None else f.hash) for f in fields(cls)]
        hashed = _values([name for name, counts in counted if counts])
        methods["__eq__"] = _eq(values)
        methods["__hash__"] = (lambda self: hash(hashed(self))) if frozen else None
    if frozen:
        methods |= {"__setattr__": _refuse_assignment, "__delattr__": _refuse_assignment}
    if frozen and slots:
        methods |= {"__getstate__": _state, "__setstate__": _set_state}
    for name in methods.keys() - own:
        setattr(cls, name, methods[name])
    return cls


def _init_at_first_use(cls: Any) -> Callable[..., None]:
    def __init__(self: object, *arguments: Any, **keywords: Any) -> None:
        compiled = cls.__init__ = _compiled_init(cls)
        compiled(self, *arguments, **keywords)

    return __init__


class _Made:
    """The default, in signatures, of fields that a function makes."""

    def __repr__(self) -> str:
        return "<factory>"


class _Signature:
    """The signature of a class for `inspect`, which would find that of the first call."""

    def __get__(self, instance: object, owner: type) -> inspect.Signature:
        if instance is not None:
            raise AttributeError("__signature__")
        found = inspect.signature(_compiled_init(owner))
        return found.replace(parameters=list(found.parameters.values())[1:])


def _compiled_init(cls: type) -> Callable[..., None]:
    """Compile `__init__`, which stores in the slots and so passes a frozen `__setattr__` by."""
    space: dict[str, Any] = {"_made": _Made(), "_set": object.__setattr__}
    parameters, keywords, body = ["self"], ["*"], []
    for each in fields(cls):
        name, value, default = each.name, each.name, f"_default_{each.name}"
        if each.default_factory is not dataclasses.MISSING:
            space |= {f"_make_{name}": each.default_factory, default: space["_made"]}
            value = f"_make_{name}()" + f" if {name} is _made else {name}" * each.init
        elif each.default is not dataclasses.MISSING:
            space[default] = each.default
            value = name if each.init else default
        elif not each.init:
            continue  # the class sets it
        if each.init:
            text = f"{name}={default}" if default in space else name
            (keywords if each.kw_only else parameters).append(text)
        slot = getattr(cls, name, None)
        if isinstance(slot, MemberDescriptorType):
            space[f"_set_{name}"] = slot.__set__
            body.append(f"_set_{name}(self, {value})")
        else:
            body.append(f"_set(self, {name!r}, {value})")
    if hasattr(cls, "__post_init__"):
        body.append("self.__post_init__()")
    signature = ", ".join(parameters + (keywords if len(keywords) > 1 else []))
    exec("\n ".join([f"def __init__({signature}):", *body, "pass"]), space)
    init: Callable[..., None] = space["__init__"]
    types = {each.name: each.type for each in fields(cls) if each.init}
    init.__annotations__ = {**types, "return": None}
    return init


def _values(names: list[str]) -> Callable[[Any], object]:
    """The values of fields, to be compared and hashed."""
    if len(names) > 1:
        return attrgetter(*names)
    return lambda self: tuple(getattr(self, name) for name in names)


def _eq(values: Callable[[Any], object]) -> Callable[[object, object], bool]:
    def __eq__(self: object, other: object) -> bool:
        if other.__class__ is self.__class__:
            return values(self) == values(other)
        return NotImplemented

    return __eq__


def _repr(names: list[str]) -> Callable[[Any], str]:
    @recursive_repr()
    def __repr__(self: object) -> str:
        shown = ", ".join(f"{name}={getattr(self, name)!r}" for name in names)
        return f"{self.__class__.__qualname__}({shown})"

    return __repr__


def _refuse_assignment(self: object, name: str, value: object = None) -> None:
    raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")


def _state(self: Any) -> list[Any]:
    return [getattr(self, each.name) for each in fields(self)]


def _set_state(self: Any, state: list[Any]) -> None:
    for each, value in zip(fields(self), state, strict=True):
        object.__setattr__(self, each.name, value)
