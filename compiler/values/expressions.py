"""Evaluate expressions: from the syntax tree of one expression, in a scope, to DAG nodes.

The evaluation of an expression ends at its first error; callers that evaluate several expressions
collect the errors of all.
"""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from fractions import Fraction
from typing import TypeAlias, assert_never

from bgc.algebra.angles import PI
from bgc.algebra.dag import Dag, Kind, Op
from bgc.diagnostics.catalogue import data as data_messages
from bgc.diagnostics.catalogue import shapes as shape_messages
from bgc.diagnostics.catalogue import values as catalogue
from bgc.diagnostics.catalogue.fmu_parts import fmu_misused
from bgc.diagnostics.catalogue.syntax import empty_vector
from bgc.diagnostics.source import Span
from bgc.grammar import syntax
from bgc.grammar.peers import function_advice, keyword_advice
from bgc.record_class import dataclass, field
from bgc.values import arithmetic, component_selection, functions
from bgc.values.arithmetic import Operand, failure
from bgc.values.block_matrices import join_blocks
from bgc.values.constants import (
    check_finite,
    check_literal,
    constant_number,
    constant_scalar,
    whole_number,
)
from bgc.values.data_expressions import Column, Table
from bgc.values.function_scope import FunctionScope
from bgc.values.interpolation import interpolate, known, read_options
from bgc.values.jacobians import Jacobian
from bgc.values.scope import FunctionUse, Namespace, Scope
from bgc.values.units import (
    DIMENSIONLESS,
    Written,
    parse_unit,
    spaced_product,
    suggest_conversion,
    suggest_unit,
    times_seconds,
)
from bgc.values.unknown_names import unknown_name
from bgc.values.value import Value, describe_shape

__all__ = ["FunctionUse", "Namespace", "Scope", "evaluate", "evaluate_condition"]
__all__ += ["evaluate_constant", "evaluate_whole", "resolve_path"]

_LARGEST_INDEX = 10**9  # larger indices are out of range anyway
_MAX_CALLS = 64  # depth of nested calls of the user's functions
_MAX_NESTING = 150  # of operations within operations, through the functions that are called

_Calls: TypeAlias = dict[tuple[int, tuple[Value | Namespace, ...]], Value]


def evaluate(expr: syntax.Expr, scope: Scope, dag: Dag) -> Value:
    """Evaluate an expression.

    Raises
    ------
    BgError
        The expression is wrong; with one diagnostic (BG3xx, or one of the scope's).
    """
    evaluator = _Evaluator(scope, dag)
    return evaluator.plain(evaluator.path(expr, 0), expr.span)


def evaluate_constant(expr: syntax.Expr, scope: Scope, dag: Dag, what: str) -> Fraction:
    """The exact value, in SI units, of a scalar that must be known at compile time."""
    return constant_scalar(dag, Operand(evaluate(expr, scope, dag), expr.span), what)


def evaluate_whole(
    expr: syntax.Expr, scope: Scope, dag: Dag, what: str, least: int, most: int
) -> int:
    """The value of a dimension, an index or a bound of `for`, known at compile time."""
    operand = Operand(evaluate(expr, scope, dag), expr.span)
    return whole_number(dag, operand, what, least, most)


def evaluate_condition(expr: syntax.Expr, scope: Scope, dag: Dag, what: str) -> bool:
    """The condition of an `if` with braces, known at compile time."""
    operand = Operand(evaluate(expr, scope, dag), expr.span)
    number = constant_number(dag, arithmetic.truth(operand, what))
    if number is None:
        raise failure(catalogue.not_constant(expr.span, what))
    return number != 0


def resolve_path(expr: syntax.Expr, scope: Scope, dag: Dag) -> Value | Namespace:
    """Evaluate an expression that may be a path to a namespace, as `crane.boom`."""
    return _Evaluator(scope, dag).path(expr, 0)


@dataclass(frozen=True, slots=True)
class _Evaluator:
    """The evaluation of one expression.

    `active` are the user's functions being evaluated. `calls` keeps their results by function and
    arguments, so that nested functions cost no more than the nodes they make.

    Each method takes the `depth` of the operations around its expression. One level takes up to
    four frames of Python's stack, an index and a `block` count as two levels.
    """

    scope: Scope
    dag: Dag
    active: tuple[str, ...] = ()
    calls: _Calls = field(default_factory=dict)

    def operand(self, expr: syntax.Expr, depth: int) -> Operand:
        return Operand(self.value(expr, depth), expr.span)

    def path(self, expr: syntax.Expr, depth: int) -> Value | Namespace:
        match expr:
            case syntax.Name():
                return self.name(expr)
            case syntax.Member(base, name, span):
                if isinstance(base, syntax.Name) and (axis := component_selection.axis_of(name)):
                    by_part = self.scope.component_of(base.name)
                    if by_part is not None and len(by_part.shape) == 1 <= axis <= by_part.shape[0]:
                        return by_part.evaluate((axis,))
                found = self.path(base, depth)
                if isinstance(found, Value):
                    end = Span(span.source, span.end - len(name), span.end)
                    return component_selection.member(found, name, end)
                return found.member(name, span)
            case syntax.Index(base, indices, span):
                if (part := self.component(base, indices, span, depth)) is not None:
                    return part
                return self.index(self.path(base, depth), indices, span, depth)
            case syntax.Call("data") if self.scope.function("data") is None:
                return self.data(expr)
            case _:
                return self.value(expr, depth)

    def component(
        self,
        base: syntax.Expr,
        at: Sequence[syntax.Expr | syntax.Range],
        span: Span,
        depth: int,
    ) -> Value | None:
        """A component of a value that is assigned by component; None to take it from the whole."""
        if not isinstance(base, syntax.Name) or isinstance(at[0], syntax.Text):
            return None
        part = self.scope.component_of(base.name)
        if part is None:
            return None
        chosen = tuple([self.selection(index, depth + 2) for index in at])
        component_selection.check_selection(part.shape, chosen, span)
        if not all(selection.single for selection in chosen):
            return None
        return part.evaluate(tuple(selection.first for selection in chosen))

    def value(self, expr: syntax.Expr, depth: int) -> Value:
        if depth > _MAX_NESTING:
            raise failure(shape_messages.too_deep(expr.span))
        match expr:
            case syntax.Number():
                return self.number(expr)
            case syntax.Name() | syntax.Member() | syntax.Index():
                return self.plain(self.path(expr, depth), expr.span)
            case syntax.Call():
                return self.call(expr, depth)
            case syntax.Unary():
                return self.unary(expr, depth)
            case syntax.Binary():
                return self.binary(expr, depth)
            case syntax.Conditional():
                return self.conditional(expr, depth)
            case syntax.Vector():
                return self.vector(expr, depth)
            case syntax.Text():
                raise failure(catalogue.not_a_value(expr.span, "a text"))
            case syntax.TypeUse():
                raise failure(catalogue.not_a_value(expr.span, f"the type `{expr.name}`"))
        assert_never(expr)

    def plain(self, found: Value | Namespace, span: Span) -> Value:
        """A value; numbers of a data file become one."""
        if isinstance(found, Column):
            return found.value(self.dag, span)
        if not isinstance(found, Value):
            raise failure(catalogue.not_a_value(span, found.description))
        return found

    # --- leaves and paths -----------------------------------------------------------

    def number(self, expr: syntax.Number) -> Value:
        check_literal(expr.value, expr.span)
        if expr.unit is None:
            return Value.scalar(self.dag.const(expr.value))
        unit = parse_unit(expr.unit)
        if unit is None:
            product = spaced_product(
                expr.unit, lambda name: name in ("time", "pi") or self.scope.is_value(name)
            )
            raise failure(
                catalogue.unknown_unit(
                    expr.span,
                    expr.unit,
                    suggest_unit(expr.unit),
                    product,
                    suggest_conversion(expr.unit) or keyword_advice(expr.unit),
                )
            )
        si = expr.value * unit.factor
        check_literal(si, expr.span)
        return Value.scalar(self.dag.const(si), Written(unit.dimension, expr.unit))

    def name(self, expr: syntax.Name) -> Value | Namespace:
        """Look a name up. `time` is in seconds but fits any unit, as in `sin(time)`."""
        if expr.name == "time":
            return Value.scalar(self.dag.symbol(Kind.TIME))
        found = self.scope.lookup(expr.name, expr.span)
        if found is not None:
            return found
        if expr.name == "pi":
            return Value.scalar(self.dag.const(PI), DIMENSIONLESS)
        raise failure(unknown_name(expr, self.scope.names()))

    def index(
        self,
        base: Value | Namespace,
        indices: Sequence[syntax.Expr | syntax.Range],
        span: Span,
        depth: int,
    ) -> Value | Namespace:
        match indices:
            case (syntax.Text() as text,) if isinstance(base, Table):
                return base.member(text.value, text.span)
        selections = tuple([self.selection(index, depth + 2) for index in indices])
        if isinstance(base, Value):
            return component_selection.select(base, selections, span)
        if isinstance(base, Column):
            return base.select(selections, span)
        for selection in selections:
            if not selection.single:
                raise failure(shape_messages.no_range_of_parts(selection.span, base.description))
        return base.index(tuple(selection.first for selection in selections), span)

    def selection(
        self, index: syntax.Expr | syntax.Range, depth: int
    ) -> component_selection.Selection:
        if not isinstance(index, syntax.Range):
            place = self.place(index, depth)
            return component_selection.Selection(place, place, True, index.span)
        first, last = self.place(index.first, depth), self.place(index.last, depth)
        if first > last:
            raise failure(shape_messages.empty_range(index.span, first, last))
        return component_selection.Selection(first, last, False, index.span)

    def place(self, index: syntax.Expr, depth: int) -> int:
        return whole_number(
            self.dag, self.operand(index, depth), "an index", -_LARGEST_INDEX, _LARGEST_INDEX
        )

    # --- operators ------------------------------------------------------------------

    def unary(self, expr: syntax.Unary, depth: int) -> Value:
        operand = self.operand(expr.operand, depth + 1)
        match expr.operator:
            case "-":
                return arithmetic.negate(self.dag, operand)
            case "+":
                return operand.value
            case "not":
                truth = arithmetic.truth(operand, "what `not` negates")
                return Value.scalar(self.dag.call(Op.NOT, truth), DIMENSIONLESS)
            case _:
                raise AssertionError(expr.operator)

    def binary(self, expr: syntax.Binary, depth: int) -> Value:
        """Evaluate an operation. Long sums nest to the left and are evaluated in a loop."""
        links = expr.links()
        left = self.operand(links[0].left, depth + 1)
        for link in links:
            left = Operand(self.operation(link, left, depth), link.span)
            check_finite(self.dag, left)
        return left.value

    def operation(self, expr: syntax.Binary, left: Operand, depth: int) -> Value:
        dag, right = self.dag, self.operand(expr.right, depth + 1)
        match expr.operator:
            case "+":
                return arithmetic.combine("+", dag.add, left, right)
            case "-":
                return arithmetic.combine("-", dag.sub, left, right)
            case "*":
                return arithmetic.multiply(dag, left, right)
            case "/":
                value = arithmetic.quotient(dag, left, right)
                self._mark(value, left.span.to(right.span))
                return value
            case "^":
                return arithmetic.raise_to(dag, left, right)
            case "and" | "or":
                op = Op.AND if expr.operator == "and" else Op.OR
                what = f"each side of `{expr.operator}`"
                sides = (arithmetic.truth(left, what), arithmetic.truth(right, what))
                return Value.scalar(dag.call(op, *sides), DIMENSIONLESS)
            case _:
                value = arithmetic.compare(dag, expr.operator, left, right)
                self._mark(value, left.span.to(right.span))
                return value

    def _mark(self, value: Value, span: Span) -> None:
        """Record the place of a discontinuous operation or a quotient, for messages."""
        for node in value.nodes:
            self.dag.mark(node, span)

    def conditional(self, expr: syntax.Conditional, depth: int) -> Value:
        """Evaluate an `if`; with a constant condition, only the branch that it chooses.

        The branches of `if .. else if .. else` nest to the right: they are evaluated in a loop.
        """
        undecided: list[tuple[syntax.Conditional, int, Operand]] = []
        branch: syntax.Expr = expr
        while isinstance(branch, syntax.Conditional):
            given = self.operand(branch.condition, depth + 1)
            condition = arithmetic.truth(given, "a condition")
            constant = constant_number(self.dag, condition)
            if constant is None:
                undecided.append((branch, condition, self.operand(branch.yes, depth + 1)))
                branch = branch.no
            else:
                branch = branch.yes if constant != 0 else branch.no
        value = self.value(branch, depth + 1)
        for choice, condition, yes in reversed(undecided):
            value = arithmetic.select(self.dag, condition, yes, Operand(value, choice.no.span))
        return value

    def vector(self, expr: syntax.Vector, depth: int) -> Value:
        if not expr.elements:
            raise failure(empty_vector(expr.span))
        elements = [self.operand(element, depth + 1) for element in expr.elements]
        # One component is a scalar beside scalars; else it is a row: the flow of a bond of width 1
        # is a vector, and in brackets no matrix.
        one = () if any(not element.shape for element in elements) else (1,)
        shapes = [one if len(e.value.nodes) == 1 else e.shape for e in elements]
        shape = shapes[0]
        for element, found_shape in zip(elements, shapes, strict=True):
            if found_shape != shape or len(shape) > 1:
                expected = describe_shape(shape if len(shape) < 2 else ())
                found = describe_shape(element.shape)
                raise failure(shape_messages.ragged(element.span, expected, found))
        return Value(
            (len(elements), *shape),
            tuple(node for element in elements for node in element.value.nodes),
            tuple(unit for element in elements for unit in element.value.units),
        )

    # --- functions ------------------------------------------------------------------

    def call(self, expr: syntax.Call, depth: int) -> Value:
        use = self.scope.function(expr.function)
        if use is not None:
            return self.user_call(use, expr, depth)
        match expr.function:
            case "der":
                return self.rate(expr, depth)
            case "block":
                return self.block(expr, depth)
            case "jacobian":
                return self.jacobian(expr, depth)
            case "interpolate":
                return self.interpolate(expr, depth)
            case "fmu":
                raise failure(fmu_misused(expr.span, "`fmu` stands alone, in a sampled part"))
            case "data":
                return self.plain(self.data(expr), expr.span)
            case "length" if len(expr.arguments) == 1:
                found = self.path(expr.arguments[0], depth + 1)
                if isinstance(found, Column) and found.numbers.array.ndim == 1:
                    size = self.dag.const(len(found.numbers.array))
                    return Value.scalar(size, DIMENSIONLESS)
                operand = Operand(self.plain(found, expr.arguments[0].span), expr.arguments[0].span)
                return functions.call(self.dag, "length", [operand], expr.span)
            case name if name in functions.BUILTINS:
                arguments = [self.operand(argument, depth + 1) for argument in expr.arguments]
                value = functions.call(self.dag, name, arguments, expr.span)
                if functions.BUILTINS[name].jumps:
                    self._mark(value, expr.span)
                check_finite(self.dag, Operand(value, expr.span))
                return value
            case name if name in self.scope.names() or name in ("pi", "time"):
                raise failure(catalogue.called_value(expr.span, name))
            case name:
                known = (*functions.BUILTINS, *self.scope.function_names())
                advice = function_advice(name)
                raise failure(catalogue.unknown_function(expr.span, name, known, advice))

    def user_call(self, use: FunctionUse, expr: syntax.Call, depth: int) -> Value:
        function = use.function
        if function.name in self.active:
            calls = self.active[self.active.index(function.name) :]
            raise failure(catalogue.recursive_function(expr.span, function.name, calls))
        if len(self.active) == _MAX_CALLS:
            raise failure(shape_messages.too_deep(expr.span))
        expected, found = len(function.formals), len(expr.arguments)
        if expected != found:
            takes = functions.count(expected)
            raise failure(catalogue.wrong_argument_count(expr.span, function.name, takes, found))
        arguments = tuple([self.argument(argument, depth + 1) for argument in expr.arguments])
        key = (id(function), arguments)
        if key not in self.calls:
            names = (formal.name for formal in function.formals)
            bound = dict(zip(names, arguments, strict=True))
            inner = FunctionScope(bound, use.scope, {name: object() for name in bound})
            active = (*self.active, function.name)
            body = _Evaluator(inner, self.dag, active, self.calls)
            self.calls[key] = body.value(function.body, depth + 1)
        return self.calls[key]

    def argument(self, expr: syntax.Expr, depth: int) -> Value | Namespace:
        """An argument of a user's function: a value, or data."""
        found = self.path(expr, depth)
        return found if isinstance(found, Column | Table) else self.plain(found, expr.span)

    def rate(self, expr: syntax.Call, depth: int) -> Value:
        """`der(x)` of a declared state, inside an `equation`."""
        if not self.scope.allows_rates:
            raise failure(catalogue.misplaced_derivative(expr.span))
        functions.require_count("der", len(expr.arguments), expr.span)
        state = self.operand(expr.arguments[0], depth + 1)
        nodes = []
        for node in state.value.nodes:
            symbol = self.dag.symbol_of(node)
            if symbol is None or symbol.kind is not Kind.STATE:
                raise failure(catalogue.derivative_of_expression(state.span))
            nodes.append(self.dag.symbol(Kind.RATE, symbol.index))
        units = tuple(unit and times_seconds(unit, -1) for unit in state.value.units)
        return Value(state.shape, tuple(nodes), units)

    def jacobian(self, expr: syntax.Call, depth: int) -> Value:
        """`jacobian(y, x)`, whose second argument names what to differentiate by."""
        functions.require_count("jacobian", len(expr.arguments), expr.span)
        of, by = expr.arguments

        def evaluate_in(part: syntax.Expr, scope: Scope) -> Value:
            return _Evaluator(scope, self.dag, self.active).value(part, depth + 2)

        def variable(path: syntax.Expr) -> Hashable | None:
            owner = self.path(path.base, depth + 2) if isinstance(path, syntax.Member) else None
            return self.scope.variable(path, owner)

        return Jacobian(self.dag, self.scope, evaluate_in, variable).of(of, by)

    def data(self, expr: syntax.Call) -> Namespace:
        """`data("file")`, the contents of a file beside the one that names it."""
        match expr.arguments:
            case (syntax.Text(value=name),) if name:
                return self.scope.data(name, expr.span)
        raise failure(data_messages.data_name_expected(expr.span))

    def interpolate(self, expr: syntax.Call, depth: int) -> Value:
        """`interpolate(xs, ys, x)` or `interpolate(xs, ys, Z, x, y)`, with named options."""
        functions.require_count("interpolate", len(expr.arguments), expr.span)
        if len(expr.arguments) == 4:
            raise failure(
                catalogue.wrong_argument_count(expr.span, "interpolate", "3 or 5 arguments", 4)
            )
        options = read_options(expr.named, expr.span)
        count = 2 if len(expr.arguments) == 3 else 3
        data = [
            known(self.dag, self.argument(part, depth + 1), part.span, "data to interpolate")
            for part in expr.arguments[:count]
        ]
        at = [self.operand(part, depth + 1) for part in expr.arguments[count:]]
        return interpolate(self.dag, data, at, options, expr.span)

    def block(self, expr: syntax.Call, depth: int) -> Value:
        """`block([[A, B], [C, D]])`, whose argument is a matrix of matrices."""
        functions.require_count("block", len(expr.arguments), expr.span)
        rows = expr.arguments[0]
        if not isinstance(rows, syntax.Vector):
            raise failure(
                shape_messages.blocks_differ(rows.span, "`block` takes a matrix of matrices")
            )
        blocks = []
        for row in rows.elements:
            if not isinstance(row, syntax.Vector):
                raise failure(
                    shape_messages.blocks_differ(row.span, "this is not a row of matrices")
                )
            blocks.append([self.operand(element, depth + 2) for element in row.elements])
        return join_blocks(self.dag, blocks, expr.span)
