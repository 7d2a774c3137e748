"""Protocols of the scope in which an expression is evaluated."""

from __future__ import annotations

from collections.abc import Callable, Collection, Hashable, Mapping
from contextlib import AbstractContextManager
from typing import Protocol

from bgc.diagnostics.source import Span
from bgc.grammar import syntax
from bgc.record_class import dataclass
from bgc.values.value import Shape, Value


class Namespace(Protocol):
    """A part, a port or an array of parts: it has members, but is not a value itself.

    A path as `crane.boom.mass` or `mass[3].p` leads from the scope through namespaces to a `Value`;
    the rest of the path selects components of the value.
    """

    @property
    def description(self) -> str:
        """Description for messages: `a part of type Beam`, `an array of 5 parts`."""
        ...

    def member(self, name: str, span: Span) -> Value | Namespace:
        """The member of that name; raises BgError if there is none."""
        ...

    def index(self, indices: tuple[int, ...], span: Span) -> Value | Namespace:
        """The element at these indices, counted from 1; raises BgError if there is none."""
        ...


@dataclass(frozen=True, slots=True)
class FunctionUse:
    """A user's function and the scope of the file that declares it."""

    function: syntax.Function
    scope: Scope


@dataclass(frozen=True, slots=True)
class ByComponent:
    """A value that is assigned component by component: `evaluate` evaluates one by itself."""

    shape: Shape
    evaluate: Callable[[tuple[int, ...]], Value]


class Scope(Protocol):
    """The names that an expression sees."""

    def lookup(self, name: str, span: Span) -> Value | Namespace | None:
        """The value or namespace of that name, None if the name is not visible.

        It is not called for `time` and `pi`. Raises BgError if a visible name has no value, as in a
        definition in terms of itself.
        """
        ...

    def names(self) -> Collection[str]:
        """All visible names, including those of parts, for suggestions."""
        ...

    def is_value(self, name: str) -> bool:
        """Test whether the name is visible and denotes a value, not a part or port."""
        ...

    def component_of(self, name: str) -> ByComponent | None:
        """The components of a value that is assigned by component and not yet known."""
        ...

    def function(self, name: str) -> FunctionUse | None:
        """The user's function of that name, None if there is none."""
        ...

    def data(self, file: str, span: Span) -> Namespace:
        """The contents of a data file, whose path is relative to the file of the expression."""
        ...

    def function_names(self) -> Collection[str]:
        """The names of the user's functions, for suggestions."""
        ...

    def variable(self, path: syntax.Expr, owner: Value | Namespace | None) -> Hashable | None:
        """The input, signal, output, let or argument that a path without index names.

        `owner` is what the path names before its last dot. None for anything else: a state, whose
        value is a symbol, a parameter, a bond's variable.
        """
        ...

    def assuming(self, values: Mapping[Hashable, Value]) -> AbstractContextManager[Scope]:
        """The scope in which variables have other values, and with them all that they define."""
        ...

    @property
    def allows_rates(self) -> bool:
        """True where `der(x)` is allowed: on both sides of an `equation`."""
        ...
