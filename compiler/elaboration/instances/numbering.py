"""Parameters: their numbers in a model, their ranges, and the variation of inputs."""

from __future__ import annotations

import re
from collections.abc import Sequence

from bgc.algebra.dag import Kind, Level
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.evaluate import to_double as as_float
from bgc.diagnostics.catalogue import ranges
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.source import Span
from bgc.elaboration.instances.checks import check_value, require_level
from bgc.elaboration.instances.components import component_name, indices
from bgc.elaboration.instances.tree import Environment, Quantity
from bgc.elaboration.instances.world import World
from bgc.ir.graph import Parameter
from bgc.options import RUN_NUMBER
from bgc.values.shown_units import Shown
from bgc.values.units import DIMENSIONLESS, Dimension, shown_of, si_text
from bgc.values.value import Value

_COMPONENT = re.compile(r"\[[\d, ]+\]$")


class Numbering:
    """The parameters of a model, numbered in the order in which they are evaluated.

    Attributes
    ----------
    parameters
        The parameters so far; the first symbol of one is its place here.
    ungiven
        The numbers of parameters of parts that keep their declared default.
    """

    def __init__(self, world: World, varied: Sequence[str]) -> None:
        """Take the inputs that are `varied`: each has a parameter of its name added, which is 0."""
        self._world = world
        self._varied = {*varied, *(_COMPONENT.sub("", text) for text in varied)}
        self._variations: dict[Quantity, tuple[int, ...]] = {}  # nodes, by component
        self.parameters: list[Parameter] = []
        self.ungiven: set[int] = set()

    def varies(self, quantity: Quantity) -> bool:
        """Return whether a quantity is one of the inputs that are varied."""
        return quantity.path in self._varied

    def number(self, quantity: Quantity, default: Value) -> Value:
        """Number the components of a parameter with a default in its shape and unit.

        Raises BgError for a default that varies during a run, or outside the declared range.
        """
        declaration = quantity.declaration
        span = quantity.given.span if quantity.given else declaration.name_span
        help = (
            f"declare `{declaration.name}` as an `input` in its model"
            if quantity.given is not None
            else ""
        )
        what = f"parameter `{declaration.name}`"
        require_level(self._world.dag, default, Level.PARAM, span, what, help)
        low, high = self._range(quantity, default)
        first = len(self.parameters)
        is_own = self._is_own(quantity.env)
        is_set = ("sets", quantity.path) in self._world.edits.used
        nodes = []
        for k, index in enumerate(indices(default.shape)):
            dimension = default.units[k]
            symbol = si_text(dimension)
            name = component_name(quantity.path, index)
            exact = self._world.dag.value(default.nodes[k])
            if exact is not None:
                number = as_float(exact)
                if low is not None and high is not None and not low <= number <= high:
                    raise BgError([_range_excludes(span, name, number, low, high, dimension)])
            self.parameters.append(
                Parameter(
                    first + k,
                    name,
                    symbol,
                    default.nodes[k],
                    low,
                    high,
                    declaration.name_span,
                    is_own,
                    is_set or index in quantity.parts,
                    shown_of(dimension),
                )
            )
            nodes.append(self._world.dag.symbol(Kind.PARAM, first + k))
            if quantity.given is None and index not in quantity.parts and not is_own:
                self.ungiven.add(first + k)
        quantity.first = first
        return Value(default.shape, tuple(nodes), default.units)

    def check_constant(self, quantity: Quantity, value: Value) -> None:
        """Refuse a constant outside its declared range."""
        low, high = self._range(quantity, value)
        if low is None or high is None:
            return
        span = quantity.given.span if quantity.given else quantity.declaration.name_span
        numbers = evaluate_nodes(self._world.dag, value.nodes, {})
        for k, index in enumerate(indices(value.shape)):
            if not low <= numbers[k] <= high:
                name, unit = component_name(quantity.path, index), value.units[k]
                raise BgError([_range_excludes(span, name, numbers[k], low, high, unit)])

    def with_variation(self, quantity: Quantity, value: Value) -> Value:
        """Add a parameter to each component of an input; it has the component's name."""
        if quantity not in self._variations:
            first = len(self.parameters)
            for k, index in enumerate(indices(value.shape)):
                name, unit = component_name(quantity.path, index), value.units[k]
                span, zero = quantity.declaration.name_span, self._world.dag.zero
                self.parameters.append(
                    Parameter(first + k, name, si_text(unit), zero, None, None, span)
                )
            added = range(first, len(self.parameters))
            nodes = tuple(self._world.dag.symbol(Kind.PARAM, k) for k in added)
            self._variations[quantity] = nodes
        pairs = zip(value.nodes, self._variations[quantity], strict=True)
        return Value(value.shape, tuple(self._world.dag.add(*pair) for pair in pairs), value.units)

    def run_number(self, span: Span) -> Value:
        """Add the parameter by which a drive distinguishes the runs of an ensemble."""
        index = len(self.parameters)
        one = self._world.dag.one
        self.parameters.append(Parameter(index, RUN_NUMBER, "1", one, None, None, span))
        return Value.scalar(self._world.dag.symbol(Kind.PARAM, index), DIMENSIONLESS)

    def _is_own(self, env: Environment) -> bool:
        """Return whether the scene's own model or file declares a value."""
        if env.instance is None:
            return env.module is self._world.package.root
        return env.instance.parent is None

    def _range(self, quantity: Quantity, default: Value) -> tuple[float | None, float | None]:
        """The bounds of the declared range in SI units; None where no range is declared."""
        ends = quantity.declaration.range
        if ends is None:
            return None, None
        found: list[float] = []
        unit = default.unit
        for end in ends:
            value = self._world.evaluate(end, quantity.env)
            check_value(value, (), unit, end.span, "an end of the range")
            require_level(self._world.dag, value, Level.CONST, end.span, "an end of the range")
            found.append(evaluate_nodes(self._world.dag, value.nodes, {})[0])
        low, high = found
        if not low <= high:
            span = ends[0].span.to(ends[1].span)
            raise BgError([ranges.empty_range(span, quantity.declaration.name, low, high)])
        return low, high


def _range_excludes(
    span: Span, name: str, value: float, low: float, high: float, unit: Dimension | None
) -> Diagnostic:
    """Report a value outside a range, in the unit as written."""
    shown = shown_of(unit) or Shown(si_text(unit))
    return ranges.range_excludes(
        span, name, shown.number(value), shown.number(low), shown.number(high), shown.unit
    )
