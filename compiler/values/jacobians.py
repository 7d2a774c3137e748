"""`jacobian(y, x)`: exact partial derivatives of an expression by states, signals and inputs.

A state is a symbol of the graph, and the derivative by it is that of the graph. An input or signal
may have any value: a constant, that of another signal, minus a state. The expression is therefore
evaluated again with new symbols in the place of its value, differentiated by these, and the value
is put back. The derivative by an angle that is zero here is thus that of the general expression.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable

from bgc.algebra.dag import Dag, Kind
from bgc.algebra.derivatives import gradient
from bgc.diagnostics.catalogue import data as catalogue
from bgc.grammar import syntax
from bgc.record_class import dataclass, field
from bgc.values.arithmetic import failure
from bgc.values.scope import Scope
from bgc.values.units import divide
from bgc.values.value import Value, describe_shape

# The symbols of a variable are numbered by its identity, so that a repeated evaluation finds them
# again. They do not outlast the differentiation. All numbers are beyond those of unknowns.
_FIRST_SYMBOL = 1 << 41
_BITS = 24


@dataclass(frozen=True, slots=True)
class Jacobian:
    """The differentiation of one expression.

    `evaluate` evaluates an expression in a scope; `variable` gives the quantity that a path names,
    if it is one whose value may be any expression: one object for each.
    """

    dag: Dag
    scope: Scope
    evaluate: Callable[[syntax.Expr, Scope], Value]
    variable: Callable[[syntax.Expr], Hashable | None]
    assumed: dict[Hashable, Value] = field(default_factory=dict)

    def of(self, of: syntax.Expr, by: syntax.Expr) -> Value:
        """The partial derivatives of `of` by the quantities that `by` names, all others held.

        The result has a row for each component of `of` and a column for each of `by`; a scalar
        `by` gives the shape of `of`.
        """
        dag, plain = self.dag, self.evaluate(of, self.scope)
        if len(plain.shape) > 1:
            raise failure(catalogue.jacobian_of_matrix(of.span, describe_shape(plain.shape)))
        is_list = isinstance(by, syntax.Vector)
        targets = [
            self._target(x) for x in (by.elements if isinstance(by, syntax.Vector) else [by])
        ]
        with self.scope.assuming(self.assumed) as scope:
            varied = self.evaluate(of, scope) if self.assumed else plain
        symbols = [symbol for _, nodes in targets for symbol in nodes]
        entries = [entry for node in varied.nodes for entry in gradient(dag, node, symbols)]
        values = [node for value, _ in targets for node in value.nodes]
        nodes = dag.substitute(entries, dict(zip(symbols, values, strict=True)))
        below = [unit for value, _ in targets for unit in value.units]
        units = tuple(
            divide(unit, other) if unit is not None and other is not None else None
            for unit in plain.units
            for other in below
        )
        is_matrix = is_list or targets[0][0].shape != ()
        shape = (len(plain.nodes), len(symbols)) if is_matrix else plain.shape
        return Value(shape, tuple(nodes), units)

    def _target(self, expr: syntax.Expr) -> tuple[Value, tuple[int, ...]]:
        """The value of a quantity to differentiate by, and the symbols that stand for it."""
        value = self.evaluate(expr, self.scope)
        path = expr.base if isinstance(expr, syntax.Index) else expr
        variable = self.variable(path)
        if variable is None:
            if any(self.dag.symbol_of(node) is None for node in value.nodes):
                raise failure(catalogue.jacobian_by_expression(expr.span))
            return value, value.nodes
        if variable not in self.assumed:
            present = self.evaluate(path, self.scope)
            first = _FIRST_SYMBOL + (id(variable) << _BITS)
            nodes = (self.dag.symbol(Kind.UNKNOWN, first + k) for k in range(len(present.nodes)))
            self.assumed[variable] = Value(present.shape, tuple(nodes), present.units)
        with self.scope.assuming({variable: self.assumed[variable]}) as scope:
            return value, self.evaluate(expr, scope).nodes
