"""Solve for the start of jointly starting storage: given values hold, the rest changes least.

With the free states x and the unknowns z of algebraic loops (`r(x, z) = 0`), the conditions
`c(x, z) = 0` of given values are added to an independent set in order of precedence. Where they
leave states open, these have the least stored energy: with multipliers l and m,

    dH/dx = c_x' l + r_x' m,    dH/dz = c_z' l + r_z' m.

Where that has no solution, as for laws that are flat at zero, the least change of the states from
zero is taken, each relative to its scale. A condition that depends on earlier ones must agree with
them; if not, or where no solution is found, the conditions are inserted one at a time, and the
first that cannot hold is named.

The system is solved here with the parameters at their defaults. Where it depends on parameters,
time or inputs, the runtime solves it again from that solution (`runtime/c/start.c`).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.dense import solve_dense
from bgc.algebra.derivatives import gradient
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.newton import Rows
from bgc.diagnostics.catalogue import storage as storage_messages
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.start.least import LeastChange
from bgc.equations.start.problem import Given, Problem, states_in
from bgc.equations.storage.conditions import Answer, System, contradiction, in_order
from bgc.equations.variables.definitions import Variables
from bgc.ir.defaults import known_at_start, program_values
from bgc.ir.graph import Node
from bgc.ir.program import Program, Start
from bgc.record_class import dataclass, replace

_AGREES = 1e-11  # of a value that follows from others, relative
_DIGITS = 15  # of a solution: enough, and the same on every machine


def with_start(
    program: Program, rows: Sequence[Node], problem: Problem | None, variables: Variables
) -> Program:
    """The program with the initial values that equations of its start determine.

    `rows` are linear equations in START symbols, final nodes and as many as symbols: states whose
    initial values hold such symbols become those of `Program.start`. The conditions of `problem`
    are added to them.

    Raises
    ------
    BgError
        A given value contradicts others, or no state is found at which it holds.
    """
    if rows:
        program = _with_rows(program, rows, variables.start_names)
    if problem is None:
        return program
    search = _Search(program, problem, variables)
    return search.started(search.choose(variables.ignored_defaults))


def _with_rows(program: Program, rows: Sequence[Node], names: Sequence[str]) -> Program:
    """The program with the start that linear equations determine."""
    dag, size = program.dag, len(rows)
    starts = {dag.symbol(Kind.STATE, k): s.initial for k, s in enumerate(program.states)}
    residuals = dag.substitute(rows, starts)
    symbols = [dag.symbol(Kind.START, k) for k in range(size)]
    slopes = [x for node in residuals for x in gradient(dag, node, symbols)]
    nowhere = {Symbol(Kind.START, k): 0.0 for k in range(size)}
    numbers = evaluate_nodes(dag, [*residuals, *slopes], _known(program) | nowhere)
    table = [numbers[k : k + size] for k in range(size, len(numbers), size)]
    point = solve_dense(table, numbers[:size])
    assert point is not None, "conditions that were inserted one by one are dependent"
    initials = [(k, state.initial) for k, state in enumerate(program.states)]
    values = tuple((k, x) for k, x in initials if dag.symbols_in([x], Kind.START))
    return _with_values(program, residuals, point, values, names)


def _known(program: Program) -> dict[Symbol, float]:
    return known_at_start(program, program_values(program))


def _with_values(
    program: Program,
    residuals: Sequence[Node],
    point: Sequence[float],
    values: tuple[tuple[int, Node], ...],
    names: Sequence[str],
) -> Program:
    """The program that starts at a solution of the equations.

    `values` are nodes in the unknowns; residuals and point follow those that the program has. Where
    nothing but unknowns takes part, the equations themselves are not kept.
    """
    dag, before = program.dag, program.start
    first = len(before.guess) if before else 0
    point = [float(f"{x:.{_DIGITS}g}") for x in point]
    at = {Symbol(Kind.START, first + k): x for k, x in enumerate(point)}
    if before:
        at |= {Symbol(Kind.START, k): x for k, x in enumerate(before.guess)}
    numbers = evaluate_nodes(dag, [node for _, node in values], _known(program) | at)
    states = list(program.states)
    for (k, _), x in zip(values, numbers, strict=True):
        states[k] = replace(states[k], initial=dag.const(float(f"{x:.{_DIGITS}g}")))
    program = replace(program, states=tuple(states))
    symbols = dag.symbols_in([*residuals, *(node for _, node in values)]).values()
    if before is None and all(symbol.kind is Kind.START for symbol in symbols):
        return program
    start = Start(tuple(residuals), tuple(point), values, tuple(dict.fromkeys(names)))
    if before:
        moved = {k for k, _ in values}
        start = Start(
            before.residuals + start.residuals,
            before.guess + start.guess,
            tuple(pair for pair in before.values if pair[0] not in moved) + start.values,
            tuple(dict.fromkeys((*before.names, *start.names))),
        )
    return replace(program, start=start)


@dataclass(frozen=True, slots=True)
class _Condition:
    """A condition in the unknowns of the start: its residual, and the value in it."""

    given: Given
    residual: Node
    value: Node


class _Search:
    """The conditions in START symbols: first the free states, then the unknowns of loops."""

    def __init__(self, program: Program, problem: Problem, variables: Variables) -> None:
        self._program, self._dag, self._variables = program, program.dag, variables
        dag = program.dag
        residuals = {
            dag.symbol(Kind.STATE, k): state.derivative
            for k, state in enumerate(program.states)
            if state.kind == "algebraic"
        }
        read = [g.node for g in problem.given] + [n for pair in problem.stored for n in pair]
        inner = states_in(dag, read, residuals)
        algebraic = [k for k in sorted(inner) if inner[k] in residuals]
        numbers = [*problem.free, *algebraic]
        self._free, self._inner = problem.free, algebraic
        given = program.start.guess if program.start else ()
        self._first = len(given)
        self._symbols = [dag.symbol(Kind.START, self._first + j) for j in range(len(numbers))]
        moved = {dag.symbol(Kind.STATE, k): s.initial for k, s in enumerate(program.states)}
        if program.start:
            moved |= {dag.symbol(Kind.STATE, k): node for k, node in program.start.values}
        for k, symbol in zip(numbers, self._symbols, strict=True):
            moved[dag.symbol(Kind.STATE, k)] = symbol

        def put(nodes: Iterable[Node]) -> list[Node]:
            return dag.substitute(list(nodes), moved)

        self._rows = put(residuals[dag.symbol(Kind.STATE, k)] for k in algebraic)
        self._conditions = [
            _Condition(given, dag.sub(node, value), value)
            for given, node, value in zip(
                problem.given,
                put(g.node for g in problem.given),
                put(g.condition.value for g in problem.given),
                strict=True,
            )
        ]
        self._stored = put(stored for stored, _ in problem.stored)
        self._answers = put(answer for _, answer in problem.stored)
        values = _known(program)
        values |= {Symbol(Kind.START, k): x for k, x in enumerate(given)}
        starts = [program.states[k].initial for k in numbers]
        sizes = [program.states[k].scale for k in numbers]
        numbers_of = evaluate_nodes(dag, [*starts, *sizes], values)
        self._known = values
        self._least = LeastChange(
            dag, self._rows, len(self._free), numbers_of[: len(numbers)],
            [abs(x) or 1.0 for x in numbers_of[len(numbers) :]], values, len(given),
        )  # fmt: skip

    # --- the independent conditions -----------------------------------------------------------

    def choose(self, ignored: list[str]) -> list[_Condition]:
        """Choose independent conditions; contradictory defaults are noted in `ignored`."""
        groups = in_order((c.given.condition, c) for c in self._conditions)
        while True:
            wanted = [[c for _, c in group] for group in groups]
            chosen = self._independent([c for group in wanted for c in group])
            solved = self._solve(chosen)
            at_fault = None
            if solved is not None:
                at_fault = next((g for g in wanted if not self._hold(g, solved)), None)
                if at_fault is None:
                    return chosen
            place = len(wanted) - 1 if at_fault is None else wanted.index(at_fault)
            if not wanted[place][0].given.condition.is_default:
                raise self._culprit([c for group in wanted for c in group])
            ignored.append(wanted[place][0].given.condition.name)
            del groups[place]

    def _independent(self, conditions: Sequence[_Condition]) -> list[_Condition]:
        """The first conditions of which none follows from others, near the start but not at it."""
        rows = self._least.rows_near([c.residual for c in conditions])
        system = System()
        return [
            condition
            for condition, row in zip(conditions, rows, strict=True)
            if system.insert([*row, 0.0]) is Answer.ADDS
        ]

    def _solve(self, conditions: Sequence[_Condition]) -> list[float] | None:
        return self._least.solve([c.residual for c in conditions])

    def _hold(self, conditions: Sequence[_Condition], at: Sequence[float]) -> bool:
        """Return whether the conditions hold at a point, to a part of their values or of 1."""
        values = self._least.values([n for c in conditions for n in (c.residual, c.value)], at)
        return all(
            abs(residual) <= _AGREES * max(1.0, abs(value))
            for residual, value in zip(values[::2], values[1::2], strict=True)
        )

    def _culprit(self, conditions: Sequence[_Condition]) -> BgError:
        """The error that names the first condition that cannot hold beside the earlier ones."""
        for count, condition in enumerate(conditions, 1):
            chosen = self._independent(conditions[:count])
            solved = self._solve(chosen)
            if solved is not None and self._hold(conditions[:count], solved):
                continue
            one = condition.given.condition
            assert one.initial is not None, "each condition is given by the user"
            others = [c.given.condition for c in conditions[: count - 1]]
            alone = self._solve([condition]) if condition in chosen else None
            if condition in chosen and alone is None:
                variable = f"{one.initial.variable}0"
                return BgError(
                    [storage_messages.initial_out_of_reach(one.initial.span, one.name, variable)]
                )
            return contradiction(self._variables, one, others)
        raise AssertionError("the conditions hold when they are inserted one at a time")

    # --- the system ---------------------------------------------------------------------------

    def started(self, chosen: Sequence[_Condition]) -> Program:
        """The program that starts at the solution, with the unknowns of loops there.

        A loop may have several solutions, and given values hold at one of them alone.
        """
        if not self._free:
            return self._program  # the conditions hold, with no state to move
        residuals = [*(c.residual for c in chosen), *self._rows]
        first = self._solve(chosen)
        assert first is not None, "the conditions were solved when they were chosen"
        if len(chosen) == len(self._free):
            rows, point = residuals, self._polished(residuals, first)
        else:
            rows, found = self._with_least_energy(residuals, first)
            if found is None:
                rows, found = self._with_least_change(residuals, first)
            point = found or [*first, *(0.0 for _ in residuals)]
        values = tuple(zip((*self._free, *self._inner), self._symbols, strict=True))
        names = [c.given.condition.name for c in chosen]
        return _with_values(self._program, rows, point, values, names)

    def _polished(self, rows: Sequence[Node], point: Sequence[float]) -> list[float]:
        """The solution of as many equations as unknowns, to the last digits."""
        found = self._newton(rows, point)
        return list(point) if found is None else found

    def _newton(self, rows: Sequence[Node], point: Sequence[float]) -> list[float] | None:
        unknowns = [Symbol(Kind.START, self._first + k) for k in range(len(point))]
        return Rows(self._dag, rows, unknowns).solve(self._known, point)

    def _with_least_energy(
        self, residuals: Sequence[Node], first: Sequence[float]
    ) -> tuple[list[Node], list[float] | None]:
        """The conditions for the least stored energy, and their solution."""
        dag = self._dag
        after = self._first + len(self._symbols) + len(residuals)
        weights = [dag.symbol(Kind.START, after + k) for k in range(len(self._stored))]
        sum_ = dag.sum(dag.mul(w, node) for w, node in zip(weights, self._stored, strict=True))
        slopes = dag.substitute(
            gradient(dag, sum_, self._symbols), dict(zip(weights, self._answers, strict=True))
        )
        return self._stationary(slopes, residuals, first)

    def _with_least_change(
        self, residuals: Sequence[Node], first: Sequence[float]
    ) -> tuple[list[Node], list[float] | None]:
        """The conditions for the least change of the free states, and their solution."""
        dag, states = self._dag, self._program.states
        slopes = [dag.zero] * len(self._symbols)
        for j, k in enumerate(self._free):
            moved = dag.sub(self._symbols[j], states[k].initial)
            slopes[j] = dag.div(moved, dag.mul(states[k].scale, states[k].scale))
        return self._stationary(slopes, residuals, first)

    def _stationary(
        self, slopes: Sequence[Node], residuals: Sequence[Node], first: Sequence[float]
    ) -> tuple[list[Node], list[float] | None]:
        """`slopes = A' l` with the residuals, A their Jacobian."""
        dag, before = self._dag, self._first + len(self._symbols)
        multipliers = [dag.symbol(Kind.START, before + k) for k in range(len(residuals))]
        total = dag.sum(dag.mul(x, node) for x, node in zip(multipliers, residuals, strict=True))
        forces = gradient(dag, total, self._symbols)
        rows = [dag.sub(x, y) for x, y in zip(slopes, forces, strict=True)] + list(residuals)
        start = self._least.multipliers(slopes, residuals, first)
        return rows, None if start is None else self._newton(rows, [*first, *start])
