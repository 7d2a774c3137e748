"""Protocols of the services that the modules of elaboration provide to each other.

Resolving a name may build a part, evaluate a quantity or read a bond, and each of these resolves
names. Each module depends on the few methods here instead of on the others' classes.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from typing import Protocol

from bgc.diagnostics.source import Span
from bgc.elaboration.instances.tree import (
    Element,
    Environment,
    Instance,
    Pending,
    PortEntry,
    Quantity,
)
from bgc.grammar import syntax
from bgc.ir.graph import Parameter
from bgc.resolution.modules import Declared
from bgc.values.scope import ByComponent, Namespace
from bgc.values.value import Shape, Value


class Builds(Protocol):
    """Builds parts when they are first needed."""

    def build(self, pending: Pending) -> Instance | Element:
        """Build a part, or return it if it has been built."""


class Evaluates(Protocol):
    """Evaluates quantities when they are first needed.

    `definitions` are the assignments to outputs and signals. `parameters`, `states`,
    `unknowns` and `held` (by sampled parts) list those evaluated so far, in the order of their
    symbols; `first_held` is the first INPUT symbol of the last.
    """

    parameters: list[Parameter]
    ungiven: set[int]
    states: list[Quantity]
    unknowns: list[Quantity]
    held: list[Quantity]
    first_held: int
    definitions: dict[Quantity, list[tuple[syntax.Assign, Environment]]]

    def constant(self, declared: Declared[syntax.Value], span: Span) -> Value | Namespace:
        """The value of a constant of a file, or the data that it is."""

    def found(self, quantity: Quantity, span: Span) -> Value | Namespace:
        """The value of a quantity, or the data that it is; BgError if it has none."""

    def value(self, quantity: Quantity, span: Span) -> Value:
        """The value of a quantity; BgError if it has none."""

    def by_component(self, quantity: Quantity) -> ByComponent | None:
        """The components of a value that is assigned by component and not yet known."""

    def assuming(self, values: Mapping[Quantity, Value]) -> AbstractContextManager[None]:
        """Evaluate with other values of quantities, and of all that they define."""

    def start(self, quantity: Quantity) -> Value:
        """The initial value of a state, or the initial guess of an unknown."""

    def component_index(
        self, target: syntax.Expr, env: Environment, shape: Shape, name: str
    ) -> tuple[int, ...]:
        """The component that an indexed target such as `x[2]` names."""

    def is_zero_by_default(self, expr: syntax.Expr, env: Environment) -> bool:
        """Return whether an expression names a value of a part that is zero by default."""


class ReadsBonds(Protocol):
    """Reads efforts, flows, displacements, momenta and powers."""

    def of_element(self, element: Element, name: str, span: Span) -> Value | Namespace:
        """A variable of an element by name."""

    def of_port(self, port: PortEntry, name: str, span: Span) -> Value | Namespace:
        """A variable or signal of a port by name."""


class Services(Protocol):
    """All services that resolving a name may need."""

    @property
    def builder(self) -> Builds:
        """Builds parts."""

    @property
    def quantities(self) -> Evaluates:
        """Evaluates quantities."""

    @property
    def bonds(self) -> ReadsBonds:
        """Reads bonds."""

    def data(self, name: str, span: Span) -> Namespace:
        """The contents of a data file."""
