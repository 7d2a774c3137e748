"""Lazy evaluation of `param const let signal input output state unknown`.

A value is evaluated when it is first needed, so declarations may come in any order; a value that
depends on itself is reported.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial

from bgc.algebra.dag import Kind, Level
from bgc.diagnostics.catalogue import names, values
from bgc.diagnostics.catalogue import shapes as shape_messages
from bgc.diagnostics.collection import already_reported
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.source import Span
from bgc.elaboration.instances.assumptions import Assumed, Assumption
from bgc.elaboration.instances.checks import (
    check_units,
    check_value,
    fit_shape,
    level_of,
    require_level,
)
from bgc.elaboration.instances.component_assignments import (
    AssignedComponents,
    defined_by_themselves,
)
from bgc.elaboration.instances.components import indices
from bgc.elaboration.instances.default_units import Defaults
from bgc.elaboration.instances.instance_notes import note
from bgc.elaboration.instances.limits import MAX_WIDTH
from bgc.elaboration.instances.numbering import Numbering
from bgc.elaboration.instances.scopes import find_member
from bgc.elaboration.instances.tree import Environment, Given, Quantity, Status
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax
from bgc.resolution.modules import Declared
from bgc.values.data_expressions import MOST_NODES, Column, Table, may_be_data
from bgc.values.scope import ByComponent, Namespace
from bgc.values.units import (
    Dimension,
    Written,
    parse_unit,
    suggest_conversion,
    suggest_unit,
)
from bgc.values.value import Shape, Value, describe_shape

_FIXED = frozenset({"param", "const", "state", "unknown"})


class Quantities:
    """Evaluates quantities, and numbers the symbols of parameters, states and unknowns."""

    def __init__(self, world: World, varied: Sequence[str] = ()) -> None:
        """Take the inputs that are `varied`: each has a parameter of its name added, which is 0."""
        self.world = world
        self._defaults = Defaults(world)
        self._numbering = Numbering(world, varied)
        self.parameters = self._numbering.parameters
        self.ungiven = self._numbering.ungiven
        self.run_number = self._numbering.run_number
        self.states: list[Quantity] = []
        self.unknowns: list[Quantity] = []
        self.held: list[Quantity] = []
        self.first_held = 0  # the INPUT symbols before are those of devices
        self.state_count = 0
        self.held_count = 0
        self.unknown_count = 0
        self.definitions: dict[Quantity, list[tuple[syntax.Assign, Environment]]] = {}
        self._constants: dict[Declared[syntax.Value], Quantity] = {}
        self._provisional: dict[Quantity, Value] = {}
        self._assumptions: dict[tuple[tuple[Quantity, tuple[int, ...]], ...], Assumption] = {}
        self._assumed: Assumption | None = None
        self._assigned = AssignedComponents(self)

    # --- reading --------------------------------------------------------------------

    def constant(self, declared: Declared[syntax.Value], span: Span) -> Value | Namespace:
        """The value of a constant or parameter of a file, or the data that a constant is.

        A `set` of its name replaces a parameter, unless the scene's model has a parameter or
        constant of that name, which took the `set` already.
        """
        quantity = self._constants.get(declared)
        if quantity is None:
            name, edits = declared.syntax.name, self.world.edits
            env = Environment(None, declared.module, {})
            quantity = Quantity(name, declared.syntax, env, None)
            if declared.syntax.kind == "param":
                if ("sets", name) not in edits.used:
                    quantity.given = edits.take("sets", name)
                if ("parts", name) not in edits.used:
                    quantity.parts = edits.take_parts(name)
            self._constants[declared] = quantity
        return self.found(quantity, span)

    def enter_set(self) -> None:
        """Evaluate the parameters of files that the scene sets, also where no model reads them."""
        module = self.world.package.root
        for name in (*self.world.edits.sets, *self.world.edits.parts):
            declared = module.constants.get(name)
            if declared is not None and declared.syntax.kind == "param":
                with self.world.report.collecting():
                    self.constant(declared, declared.syntax.name_span)

    def value(self, quantity: Quantity, span: Span) -> Value:
        """The value of a quantity, evaluated at the first call; BgError if it has none."""
        found = self.found(quantity, span)
        if isinstance(found, Column):
            return found.value(self.world.dag, span)
        if not isinstance(found, Value):
            raise BgError([values.not_a_value(span, found.description)])
        return found

    def found(self, quantity: Quantity, span: Span) -> Value | Namespace:
        """The value of a quantity, or the data of a file that a constant is."""
        if self._assumed is not None and quantity.kind not in _FIXED:
            return self._under(self._assumed, quantity)
        if quantity.value is not None:
            return quantity.value
        if quantity.data is not None:
            return quantity.data
        if quantity in self._provisional:
            return self._provisional[quantity]
        if quantity.status is Status.FAILED:
            raise already_reported()
        if quantity.status is Status.OPEN:
            under_way = self.world.demands.under_way
            raise BgError([defined_by_themselves(under_way[under_way.index(quantity) :])])
        return self.world.demands.meet(quantity, partial(self._compute, quantity))

    def by_component(self, quantity: Quantity) -> ByComponent | None:
        """The components of a value that is assigned by component and not yet known.

        Each is evaluated by itself, so that they may depend on each other.
        """
        if quantity.kind not in {"output", "signal"} or quantity.declaration.value is not None:
            return None
        if self._assumed is not None:
            if quantity in self._assumed.given:
                return None
        elif quantity.value is not None or quantity in self._provisional:
            return None
        return self._assigned.by_component(quantity, self._assumed)

    def forget_provisional(self) -> None:
        """Discard values that contain placeholders for variables of bonds."""
        self._provisional.clear()
        self._assumptions.clear()
        self._assigned.forget()

    @contextmanager
    def assuming(self, values: Mapping[Quantity, Value]) -> Iterator[None]:
        """Evaluate with other values of quantities, and of all that they define.

        An assumption within another one adds to it. Values of parameters, constants, states and
        unknowns do not depend on it.
        """
        outer = self._assumed
        given = {**(outer.given if outer else {}), **values}
        key = tuple((quantity, value.nodes) for quantity, value in given.items())
        with self._assume(self._assumptions.setdefault(key, Assumption(given)) if key else None):
            yield

    @contextmanager
    def _assume(self, assumption: Assumption | None) -> Iterator[None]:
        outer, self._assumed = self._assumed, assumption
        try:
            yield
        finally:
            self._assumed = outer

    def _under(self, assumption: Assumption, quantity: Quantity) -> Value:
        """The value of a quantity under an assumption."""
        known = assumption.given.get(quantity) or assumption.values.get(quantity)
        if known is not None:
            return known
        demand = assumption.demands.setdefault(quantity, Assumed())
        if demand.status is Status.OPEN:
            raise BgError([names.defined_by_itself(quantity.declaration.name_span, [])])
        return self.world.demands.meet(demand, partial(self._compute_under, assumption, quantity))

    def _compute_under(self, assumption: Assumption, quantity: Quantity) -> Value:
        with self._assume(assumption):
            value = assumption.values[quantity] = self._define(quantity)
        assumption.demands[quantity].status = Status.DONE
        return value

    def _compute(self, quantity: Quantity) -> Value | Namespace:
        try:
            with self._assume(None):
                data = self._data(quantity) if quantity.kind == "const" else None
                value = self._define(quantity) if data is None else None
        except BgError as err:
            self.world.report.add(*err.diagnostics, note=note(quantity.env))
            raise already_reported() from err
        if value is None:
            assert data is not None
            quantity.status, quantity.data = Status.DONE, data
            return data
        fixed = quantity.sampled or quantity.kind in {"param", "state", "unknown"}
        if self.world.provisional and not fixed and level_of(self.world.dag, value) is Level.STATE:
            quantity.status = Status.NEW
            self._provisional[quantity] = value
        else:
            quantity.status = Status.DONE
            quantity.value = value
        return value

    # --- defining -------------------------------------------------------------------

    def _data(self, quantity: Quantity) -> Namespace | None:
        """The data that a constant is; None for one whose value is an expression.

        A constant of a given size, unit or range is a value, also of numbers of a file.
        """
        declaration, given = quantity.declaration, quantity.given
        expr, env = declaration.value, quantity.env
        plain = declaration.unit is None and not declaration.dims and declaration.range is None
        if given is not None:
            expr, env = given.value, given.env
            plain = plain and not self._defaults.have_unit(quantity)
        if not plain or quantity.parts or not may_be_data(expr):
            return None
        assert expr is not None
        found = self.world.resolve(expr, env)
        if isinstance(found, Column) and found.numbers.array.size <= MOST_NODES:
            return None
        return found if isinstance(found, Column | Table) else None

    def _define(self, quantity: Quantity) -> Value:
        declaration = quantity.declaration
        if quantity.sampled:
            return self._symbols(quantity, Kind.INPUT)
        match declaration.kind:
            case "param":
                return self._numbering.number(quantity, self._given(quantity))
            case "const":
                value = self._given(quantity)
                require_level(
                    self.world.dag, value, Level.CONST, declaration.name_span, "a `const`"
                )
                self._numbering.check_constant(quantity, value)
                return value
            case "state":
                return self._symbols(quantity, Kind.STATE)
            case "unknown":
                return self._symbols(quantity, Kind.UNKNOWN)
            case "output" | "signal" if declaration.value is None:
                return self._from_assignments(quantity)
            case "input" if self._numbering.varies(quantity):
                return self._numbering.with_variation(quantity, self._given(quantity))
            case _:
                return self._given(quantity)

    def _given(self, quantity: Quantity) -> Value:
        """Evaluate the argument or default of a quantity in its declared shape and unit."""
        declaration = quantity.declaration
        given = quantity.given
        if given is None:
            if declaration.value is None:
                raise BgError([self._without_value(quantity)])
            given = Given(declaration.value, quantity.env, declaration.value.span)
        value = self.world.evaluate(given.value, given.env)
        value = self.fit(quantity, value, given.value.span)
        if quantity.given is not None:
            value = self._defaults.apply(quantity, value, given.value.span)
        return self._with_parts(quantity, value)

    def is_zero_by_default(self, expr: syntax.Expr, env: Environment) -> bool:
        """Return whether an expression names a parameter or input of a part with a default of zero.

        An argument that is itself a name is followed to its own quantity. Parameters and inputs of
        the scene's own model do not count, since the user chose their defaults.
        """
        while isinstance(expr, syntax.Name):
            quantity = find_member(env, expr.name)
            if not isinstance(quantity, Quantity) or quantity.kind not in {"param", "input"}:
                return False
            owner, default = quantity.env.instance, quantity.declaration.value
            if quantity.parts or owner is None or owner.parent is None:
                return False
            if quantity.given is None:
                zero = self.world.dag.zero
                return default is not None and all(
                    node == zero for node in self.world.evaluate(default, quantity.env).nodes
                )
            expr, env = quantity.given.value, quantity.given.env
        return False

    def _without_value(self, quantity: Quantity) -> Diagnostic:
        """Report a missing value at the declaration of the part, where it has to be supplied."""
        declaration, instance = quantity.declaration, quantity.env.instance
        here = declaration.name_span
        if instance is None or instance.parent is None:
            return names.no_value(here, declaration.name, declaration.kind, None)
        return names.no_value(instance.span, declaration.name, declaration.kind, here)

    def _with_parts(self, quantity: Quantity, value: Value) -> Value:
        """Replace the components that a scene sets individually."""
        if not quantity.parts:
            return value
        nodes, units = list(value.nodes), list(value.units)
        positions = {index: k for k, index in enumerate(indices(value.shape))}
        for index, given in quantity.parts.items():
            position = positions.get(index)
            if position is None or not value.shape:
                shape = describe_shape(value.shape)
                raise BgError([names.no_such_index(given.span, quantity.path, index, shape)])
            component = self.world.evaluate(given.value, given.env)
            check_value(component, (), units[position], given.value.span, f"`{quantity.path}`")
            nodes[position] = component.nodes[0]
        return Value(value.shape, tuple(nodes), tuple(units))

    def _from_assignments(self, quantity: Quantity) -> Value:
        """Evaluate an output or signal from its assignments, whole or component by component."""
        declaration = quantity.declaration
        statements = self.definitions.get(quantity, [])
        if not statements:
            raise BgError(
                [names.no_value(declaration.name_span, declaration.name, declaration.kind, None)]
            )
        whole = [(s, e) for s, e in statements if not isinstance(s.target, syntax.Index)]
        if not whole:
            return self._assigned.whole(quantity, statements, self._assumed)
        if len(statements) > 1:
            (first, _), (second, _) = statements[:2]
            raise BgError([names.given_twice(second.span, declaration.name, first.span)])
        statement, env = whole[0]
        value = self.world.evaluate(statement.value, env)
        return self.fit(quantity, value, statement.value.span)

    def component_index(
        self, target: syntax.Expr, env: Environment, shape: Shape, name: str
    ) -> tuple[int, ...]:
        """The index (from 1) of the component that an indexed target such as `x[2]` names."""
        assert isinstance(target, syntax.Index)
        index = tuple(
            self.world.whole(i, env, "an index", 1, MAX_WIDTH)
            for i in target.indices
            if not isinstance(i, syntax.Range)
        )
        inside = len(index) == len(shape) and all(i <= n for i, n in zip(index, shape, strict=True))
        if not inside or not shape:
            raise BgError([names.no_such_index(target.span, name, index, describe_shape(shape))])
        return index

    def _symbols(self, quantity: Quantity, kind: Kind) -> Value:
        """Create symbols for a state or unknown, in its declared shape or that of its start."""
        shape = self.declared_shape(quantity)
        unit = self.declared_unit(quantity)
        units: tuple[Dimension | None, ...] | None = quantity.units or None
        if shape is None:
            shape = ()
            if quantity.declaration.value is not None and quantity.kind in {"state", "unknown"}:
                start = self.start(quantity)
                shape, units = start.shape, start.units
        count = len(indices(shape))
        if kind is Kind.STATE:
            quantity.first = self.state_count
            self.state_count += count
            self.states.append(quantity)
        elif kind is Kind.INPUT:
            quantity.first = self.first_held + self.held_count
            self.held_count += count
            self.held.append(quantity)
        else:
            quantity.first = self.unknown_count
            self.unknown_count += count
            self.unknowns.append(quantity)
        nodes = tuple(self.world.dag.symbol(kind, quantity.first + k) for k in range(count))
        return Value(shape, nodes, units or (unit,) * count)

    def start(self, quantity: Quantity) -> Value:
        """The initial value of a state, or the initial guess of an unknown; zero by default."""
        declaration = quantity.declaration
        if declaration.value is None:
            shape = self.declared_shape(quantity) or ()
            zeros = (self.world.dag.zero,) * len(indices(shape))
            return Value.uniform(shape, zeros, self.declared_unit(quantity))
        value = self.world.evaluate(declaration.value, quantity.env)
        span = declaration.value.span
        require_level(self.world.dag, value, Level.TIME, span, f"the start of `{declaration.name}`")
        return self.fit(quantity, value, span)

    # --- shapes and units -----------------------------------------------------------

    def declared_shape(self, quantity: Quantity) -> Shape | None:
        """The shape declared in brackets; None without brackets."""
        dims = quantity.declaration.dims
        if not dims:
            return None
        if len(dims) > 2:
            span, name = quantity.declaration.name_span, quantity.declaration.name
            raise BgError([shape_messages.too_many_dimensions(span, name, len(dims))])
        return tuple(self.world.whole(d, quantity.env, "a dimension", 0, MAX_WIDTH) for d in dims)

    def declared_unit(self, quantity: Quantity) -> Dimension | None:
        """The dimension of the declared unit; None without a unit."""
        text = quantity.declaration.unit
        return dimension_of(text, quantity.declaration.span) if text is not None else None

    def fit(self, quantity: Quantity, value: Value, span: Span) -> Value:
        """Convert a value to the declared shape and check it against the declared unit.

        A component of unknown unit gets the declared one.
        """
        shape = self.declared_shape(quantity)
        unit = self.declared_unit(quantity)
        what = f"`{quantity.declaration.name}`"
        value = fit_shape(self.world.dag, value, shape, span, what)
        check_units(value, unit, span, what)
        return value.with_unit(unit) if unit is not None else value


def dimension_of(text: str, span: Span) -> Dimension:
    """The dimension of a unit as written; BgError if the text is not a unit."""
    unit = parse_unit(text)
    if unit is None:
        conversion = suggest_conversion(text)
        raise BgError([values.unknown_unit(span, text, suggest_unit(text), "", conversion)])
    return Written(unit.dimension, text)
