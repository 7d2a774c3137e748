"""Units of defaults, which bind the values that replace them.

A default is read in a DAG of its own, so that no parameter is numbered and no node is added for a
value that is not used.
"""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterator, Mapping
from contextlib import contextmanager
from functools import partial

from bgc.algebra.dag import Dag, Kind
from bgc.diagnostics.catalogue.names import replaces_other_unit
from bgc.diagnostics.collection import already_reported
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.source import Span
from bgc.elaboration.instances.scopes import find_member
from bgc.elaboration.instances.tree import Environment, Quantity, Status
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax
from bgc.record_class import dataclass
from bgc.resolution.modules import Declared
from bgc.values.expressions import evaluate
from bgc.values.scope import ByComponent, FunctionUse, Namespace
from bgc.values.units import Dimension, Written, describe_dimension, parse_unit
from bgc.values.value import Value

_READABLE = frozenset({"const", "let", "param"})


@dataclass(slots=True, eq=False)
class _Reading:
    """The evaluation of a default, as a demand; `value` is None where its unit does not bind."""

    status: Status = Status.NEW
    value: Value | None = None


class Defaults:
    """The units of defaults, each evaluated when it is first needed.

    A default is an expression of numbers, functions, and parameters and constants with such
    defaults. Any other, which reads a part, a variable, data or a constant that an argument
    replaces, has no unit here.
    """

    def __init__(self, world: World) -> None:
        """Read in a scratch DAG beside that of the world."""
        self.dag = Dag()
        self._world = world
        self._readings: dict[Hashable, _Reading] = {}
        self._symbols = 0

    def have_unit(self, quantity: Quantity) -> bool:
        """Return whether the default of a quantity has a unit."""
        value = self._value(quantity, quantity.declaration, quantity.env)
        return value is not None and any(unit is not None for unit in value.units)

    def apply(self, quantity: Quantity, value: Value, span: Span) -> Value:
        """Give a value the units of the default that it replaces, where it has none.

        Raises BgError if a unit of the value differs from that of the default.
        """
        declaration = quantity.declaration
        if declaration.unit is not None or declaration.value is None:
            return value
        default = self._value(quantity, declaration, quantity.env)
        if default is None:
            return value
        units = default.units
        if default.shape != value.shape:
            units = (default.unit,) * len(value.units)
        for found, expected in zip(value.units, units, strict=True):
            if found is not None and expected is not None and found != expected:
                raise BgError([_other_unit(span, declaration, expected, found)])
        pairs = zip(value.units, units, strict=True)
        fitted = tuple(expected if found is None else found for found, expected in pairs)
        return Value(value.shape, value.nodes, fitted)

    def named(self, name: str, env: Environment) -> Value | None:
        """The default value that a name stands for; None where it has none."""
        match find_member(env, name):
            case Declared(syntax=syntax.Value() as declaration, module=module) as declared:
                return self._value(declared, declaration, Environment(None, module, {}))
            case Quantity(declaration=declaration) as quantity if declaration.kind in _READABLE:
                is_replaced = quantity.given is not None or quantity.parts
                if declaration.kind == "const" and is_replaced:
                    return None
                return self._value(quantity, declaration, quantity.env)
            case Value(shape=shape, nodes=nodes, units=units):
                numbers = [self._world.dag.value(node) for node in nodes]
                known = [self.dag.const(number) for number in numbers if number is not None]
                return Value(shape, tuple(known), units) if len(known) == len(nodes) else None
            case _:
                return None

    def _value(self, key: Hashable, declaration: syntax.Value, env: Environment) -> Value | None:
        reading = self._readings.setdefault(key, _Reading())
        if reading.status is Status.NEW:
            compute = partial(self._read, reading, declaration, env)
            return self._world.demands.meet(reading, compute)
        return reading.value  # None too where it is OPEN: a default that depends on itself

    def _read(self, reading: _Reading, declaration: syntax.Value, env: Environment) -> Value | None:
        value = None
        if declaration.value is not None:
            try:
                value = evaluate(declaration.value, _ClosedScope(self, env), self.dag)
            except BgError:
                value = None
        if value is not None and declaration.unit is not None:
            unit = parse_unit(declaration.unit)
            value = value.with_unit(Written(unit.dimension, declaration.unit)) if unit else None
        if value is not None and declaration.kind != "const":
            value = Value(value.shape, tuple(map(self._symbol, value.nodes)), value.units)
        reading.status, reading.value = Status.DONE, value
        return value

    def _symbol(self, _: int) -> int:
        self._symbols += 1
        return self.dag.symbol(Kind.PARAM, self._symbols)


@dataclass(frozen=True, slots=True)
class _ClosedScope:
    """The names that a default may hold: parameters, constants and functions."""

    defaults: Defaults
    env: Environment
    allows_rates: bool = False

    def lookup(self, name: str, span: Span) -> Value | Namespace | None:
        return self.defaults.named(name, self.env)

    def names(self) -> Collection[str]:
        return ()

    def is_value(self, name: str) -> bool:
        return False

    def component_of(self, name: str) -> ByComponent | None:
        return None

    def function(self, name: str) -> FunctionUse | None:
        declared = self.env.module.functions.get(name)
        if declared is None:
            return None
        scope = _ClosedScope(self.defaults, Environment(None, declared.module, {}))
        return FunctionUse(declared.syntax, scope)

    def data(self, file: str, span: Span) -> Namespace:
        raise already_reported()

    def function_names(self) -> Collection[str]:
        return ()

    def variable(self, path: syntax.Expr, owner: Value | Namespace | None) -> Hashable | None:
        return None

    @contextmanager
    def assuming(self, values: Mapping[Hashable, Value]) -> Iterator[_ClosedScope]:
        yield self


def _other_unit(
    span: Span, declaration: syntax.Value, expected: Dimension, found: Dimension
) -> Diagnostic:
    """Report a value in another unit than the default that it replaces."""
    default = declaration.value.span if declaration.value else declaration.name_span
    return replaces_other_unit(
        span,
        declaration.name,
        describe_dimension(expected),
        describe_dimension(found),
        default,
    )
