"""What an expression is evaluated in: the protocols that its surroundings implement."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from typing import Protocol

from bgc.diagnostics.source import Span
from bgc.grammar import syntax
from bgc.values.value import Value


class Namespace(Protocol):
    """Something with parts that is no value itself: a part, a port, an array of parts.

    A path as `crane.boom.mass` or `mass[3].p` walks from the scope through namespaces until
    it meets a `Value`; what is left of the path are components of that.
    """

    @property
    def description(self) -> str:
        """What it is, for messages: `a part of type Beam`, `an array of 5 parts`."""
        ...

    def member(self, name: str, span: Span) -> Value | Namespace:
        """The member of that name; raises BgError when there is none."""
        ...

    def index(self, indices: tuple[int, ...], span: Span) -> Value | Namespace:
        """The element at these indices, from 1; raises BgError when there is none."""
        ...


@dataclass(frozen=True, slots=True)
class FunctionUse:
    """A user's function and the scope of the file that declares it."""

    function: syntax.Function
    scope: Scope


class Scope(Protocol):
    """The names that an expression sees."""

    def lookup(self, name: str, span: Span) -> Value | Namespace | None:
        """The value or namespace of that name, None when the name is not visible.

        `time` and `pi` are not asked for. Raises BgError when a visible name has no value
        (a definition in terms of itself).
        """
        ...

    def names(self) -> Collection[str]:
        """All visible names, of parts too, for suggestions."""
        ...

    def is_value(self, name: str) -> bool:
        """Whether the name stands for a value, not for a part or port, or for nothing."""
        ...

    def function(self, name: str) -> FunctionUse | None:
        """The user's function of that name, None when there is none."""
        ...

    def function_names(self) -> Collection[str]:
        """The names of the user's functions, for suggestions."""
        ...

    @property
    def allows_rates(self) -> bool:
        """Whether `der(x)` may stand here: on either side of an `equation`, nowhere else."""
        ...
