"""The scope of the body of a user's function."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterator, Mapping
from contextlib import contextmanager

from bgc.diagnostics.source import Span
from bgc.grammar import syntax
from bgc.record_class import dataclass, field
from bgc.values.scope import ByComponent, FunctionUse, Namespace, Scope
from bgc.values.value import Value


@dataclass(frozen=True, slots=True)
class FunctionScope:
    """The arguments of a function, then the names of its file."""

    arguments: Mapping[str, Value | Namespace]
    outer: Scope
    variables: Mapping[str, object] = field(default_factory=dict)  # an identity for each argument
    allows_rates: bool = False

    def lookup(self, name: str, span: Span) -> Value | Namespace | None:
        """Return the argument of that name, or what the file of the function has."""
        return self.arguments.get(name) or self.outer.lookup(name, span)

    def names(self) -> Collection[str]:
        """Return all visible names."""
        return {*self.arguments, *self.outer.names()}

    def is_value(self, name: str) -> bool:
        """Return whether the name is visible and denotes a value; arguments count as values."""
        return name in self.arguments or self.outer.is_value(name)

    def component_of(self, name: str) -> ByComponent | None:
        """Return the components of a value of the file; arguments are known as a whole."""
        return None if name in self.arguments else self.outer.component_of(name)

    def function(self, name: str) -> FunctionUse | None:
        """Return the function of that name in the file."""
        return self.outer.function(name)

    def data(self, file: str, span: Span) -> Namespace:
        """Return the contents of a data file; its path is relative to the file of the function."""
        return self.outer.data(file, span)

    def function_names(self) -> Collection[str]:
        """Return the names of the functions of the file."""
        return self.outer.function_names()

    def variable(self, path: syntax.Expr, owner: Value | Namespace | None) -> Hashable | None:
        """Return the identity of an argument, or of a variable of the file."""
        if isinstance(path, syntax.Name) and path.name in self.arguments:
            return self.variables[path.name]
        return self.outer.variable(path, owner)

    @contextmanager
    def assuming(self, values: Mapping[Hashable, Value]) -> Iterator[Scope]:
        """Make the scope in which variables, arguments among them, have other values."""
        own = {
            name: values.get(self.variables[name], value) for name, value in self.arguments.items()
        }
        mine = set(self.variables.values())
        others = {key: value for key, value in values.items() if key not in mine}
        with self.outer.assuming(others) as outer:
            yield FunctionScope(own, outer, self.variables)
