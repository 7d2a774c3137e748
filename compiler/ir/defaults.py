"""Evaluate the defaults of parameters, the selectors that follow them, and the start."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from bgc.algebra.dag import Dag, Kind, Symbol
from bgc.algebra.evaluate import Evaluator, evaluate_nodes
from bgc.ir.graph import Parameter
from bgc.ir.program import Program


def program_values(program: Program) -> dict[Symbol, float]:
    """The defaults of the parameters of a program, and the first values of its selectors."""
    return default_values(program.dag, program.parameters) | selector_values(program)


def selector_values(program: Program) -> dict[Symbol, float]:
    """The selectors of closing rows, each with 1 if its row is chosen at first, else 0."""
    closures, values = program.closures, dict[Symbol, float]()
    for k, selector in enumerate(closures.selectors if closures else ()):
        symbol = program.dag.symbol_of(selector)
        if closures and symbol is not None:
            chain = closures.chain_of[k]
            values[symbol] = float(k < closures.chain_of.index(chain) + closures.ranks[chain])
    return values


def known_at_start(program: Program, parameters: Mapping[Symbol, float]) -> dict[Symbol, float]:
    """Values of parameters, and of the time and all inputs at the start: zero."""
    values = {**parameters, Symbol(Kind.TIME, 0): 0.0}
    return values | {Symbol(Kind.INPUT, k): 0.0 for k in range(program.inputs)}


def start_values(program: Program, parameters: Mapping[Symbol, float]) -> dict[Symbol, float]:
    """The same with the initial values of the states."""
    values = known_at_start(program, parameters)
    numbers = Evaluator(program.dag, values.__getitem__)
    initials = numbers.values(state.initial for state in program.states)
    return values | {Symbol(Kind.STATE, k): x for k, x in enumerate(initials)}


def default_values(dag: Dag, parameters: Iterable[Parameter]) -> dict[Symbol, float]:
    """The default of each parameter as a number; a default may depend on other parameters."""
    values: dict[Symbol, float] = {}
    waiting = {Symbol(Kind.PARAM, p.index): p.value for p in parameters}
    needs = {
        symbol: {s for s in map(dag.symbol_of, dag.reachable([node])) if s is not None}
        for symbol, node in waiting.items()
    }
    stack = list(waiting)
    while stack:
        symbol = stack[-1]
        missing = [s for s in needs[symbol] if s not in values and s in waiting]
        if symbol in values or not missing:
            stack.pop()
            if symbol not in values:
                values[symbol] = evaluate_nodes(dag, [waiting[symbol]], values)[0]
        else:
            stack.extend(missing)
    return values
