"""Outputs and signals that are assigned component by component: `x[1] = ..; x[2] = 2*x[1];`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Protocol

from bgc.diagnostics.catalogue import names
from bgc.diagnostics.collection import already_reported
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.elaboration.instances.assumptions import Assumption
from bgc.elaboration.instances.checks import check_value
from bgc.elaboration.instances.components import component_name, indices
from bgc.elaboration.instances.demands import Demand
from bgc.elaboration.instances.instance_notes import note
from bgc.elaboration.instances.tree import Environment, Quantity, Status
from bgc.elaboration.instances.world import World
from bgc.grammar import syntax
from bgc.record_class import dataclass
from bgc.values.scope import ByComponent
from bgc.values.units import Dimension
from bgc.values.value import Shape, Value

_Assignments = Sequence[tuple[syntax.Assign, Environment]]
_Index = tuple[int, ...]


class _Evaluates(Protocol):
    """The evaluation of quantities, as far as their components need it."""

    world: World
    definitions: dict[Quantity, list[tuple[syntax.Assign, Environment]]]

    def declared_shape(self, quantity: Quantity) -> Shape | None: ...
    def declared_unit(self, quantity: Quantity) -> Dimension | None: ...
    def component_index(
        self, target: syntax.Expr, env: Environment, shape: Shape, name: str
    ) -> _Index: ...


@dataclass(slots=True, eq=False)
class Component:
    """The evaluation of one component, as a demand."""

    quantity: Quantity
    index: _Index
    status: Status = Status.NEW
    value: Value | None = None

    @property
    def path(self) -> str:
        """Its name in messages."""
        return component_name(self.quantity.path, self.index)

    @property
    def declaration(self) -> syntax.Value:
        """The declaration of the whole value."""
        return self.quantity.declaration


class AssignedComponents:
    """Evaluates components when they are first needed, each by itself.

    A component may depend on others of the same value, in any order of the statements.
    """

    def __init__(self, quantities: _Evaluates) -> None:
        self._quantities = quantities
        self._places: dict[Quantity, dict[_Index, tuple[syntax.Assign, Environment]]] = {}
        self._demands: dict[tuple[Assumption | None, Quantity, _Index], Component] = {}

    def forget(self) -> None:
        """Discard values that contain placeholders for variables of bonds."""
        self._demands.clear()

    def whole(
        self, quantity: Quantity, statements: _Assignments, assumed: Assumption | None
    ) -> Value:
        """Assemble a value from the assignments of its components."""
        shape = self._quantities.declared_shape(quantity) or ()
        self._placed(quantity, statements)
        ordered = [self._evaluated(quantity, index, assumed) for index in indices(shape)]
        return Value(
            shape,
            tuple(value.nodes[0] for value in ordered),
            tuple(value.units[0] for value in ordered),
        )

    def by_component(self, quantity: Quantity, assumed: Assumption | None) -> ByComponent | None:
        """The components of a value; None where it is assigned as a whole."""
        statements = self._quantities.definitions.get(quantity, [])
        if quantity not in self._places and not (
            statements and all(isinstance(s.target, syntax.Index) for s, _ in statements)
        ):
            return None
        shape = self._quantities.declared_shape(quantity) or ()
        return ByComponent(shape, partial(self._evaluated, quantity, assumed=assumed))

    def _placed(
        self, quantity: Quantity, statements: _Assignments
    ) -> dict[_Index, tuple[syntax.Assign, Environment]]:
        """The assignments by component; BgError for a component that is given twice."""
        known = self._places.get(quantity)
        if known is not None and len(known) == len(statements):
            return known
        found: dict[_Index, tuple[syntax.Assign, Environment]] = {}
        shape = self._quantities.declared_shape(quantity) or ()
        for statement, env in statements:
            index = self._quantities.component_index(statement.target, env, shape, quantity.path)
            if index in found:
                first, _ = found[index]
                raise BgError(
                    [names.given_twice(statement.span, quantity.declaration.name, first.span)]
                )
            found[index] = (statement, env)
        self._places[quantity] = found
        return found

    def _evaluated(self, quantity: Quantity, index: _Index, assumed: Assumption | None) -> Value:
        declaration = quantity.declaration
        if index not in self._placed(quantity, self._quantities.definitions[quantity]):
            label = component_name(declaration.name, index)
            raise BgError([names.no_value(declaration.name_span, label, declaration.kind, None)])
        key = (assumed, quantity, index)
        demand = self._demands.setdefault(key, Component(quantity, index))
        if demand.value is not None:
            return demand.value
        if demand.status is Status.FAILED:
            raise already_reported()
        demands = self._quantities.world.demands
        if demand.status is Status.OPEN:
            cycle = demands.under_way[demands.under_way.index(demand) :]
            raise BgError([defined_by_themselves(cycle)])
        return demands.meet(demand, partial(self._compute, demand))

    def _compute(self, demand: Component) -> Value:
        quantity, world = demand.quantity, self._quantities.world
        statement, env = self._places[quantity][demand.index]
        unit = self._quantities.declared_unit(quantity)
        try:
            value = world.evaluate(statement.value, env)
            check_value(value, (), unit, statement.value.span, f"`{quantity.declaration.name}`")
        except BgError as err:
            world.report.add(*err.diagnostics, note=note(quantity.env))
            raise already_reported() from err
        demand.status = Status.DONE
        demand.value = Value.scalar(value.nodes[0], value.units[0] if unit is None else unit)
        return demand.value


def defined_by_themselves(cycle: Sequence[Demand]) -> Diagnostic:
    """Report a cyclic definition at its first declaration, wherever the evaluation entered it."""
    found = [demand for demand in cycle if isinstance(demand, Quantity | Component)]
    spans = [each.declaration.name_span for each in found]
    first = min(range(len(found)), key=lambda k: (spans[k].source.name, spans[k].start))
    paths = [each.path for each in (*found[first:], *found[: first + 1])]
    return names.defined_by_itself(spans[first], paths)
