"""Implicit equations: those of the graph's unknowns, and those that the user wrote.

Each unknown of the graph (`Variables.equations`) is matched with an equation that contains it. The
user's equations become rows of the mass matrix where they are linear in the rates with coefficients
of at most parameter level; otherwise a rate becomes an unknown.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TypeAlias

from bgc.algebra.dag import Dag, Kind, Level
from bgc.algebra.derivatives import gradient
from bgc.algebra.matching import match
from bgc.algebra.reduction import Reduction
from bgc.algebra.strong_components import all_components
from bgc.diagnostics.catalogue import causality as catalogue
from bgc.diagnostics.diagnostic import BgError
from bgc.equations.loops.constraints import derivative_with_unknown
from bgc.equations.loops.singular_jacobian import Row, require_determined
from bgc.equations.loops.substitution import Resolver
from bgc.equations.variables.definitions import Column, Explicit, Kept, Rate, Unknown, Variables
from bgc.ir.graph import Equation, Node

# --- unknowns of the graph ----------------------------------------------------------------------


def pair_equations(variables: Variables) -> dict[Node, Node]:
    """Match each unknown with a residual that contains it.

    Raises
    ------
    BgError
        There is no such pairing: the equations are singular.
    """
    residuals = [residual for residual, _ in variables.equations]
    unknowns = [unknown for _, unknown in variables.equations]
    if not unknowns:
        return {}
    held = _unknowns_in(variables, residuals, unknowns)
    meant = {i: i for i in range(len(unknowns)) if held[i] >> i & 1}
    pairs = match(
        [list(_places(bits)) for bits in held],
        meant,
    )
    lonely = [unknowns[i] for i in range(len(residuals)) if i not in pairs]
    if lonely:
        raise variables.places.unsolvable(lonely)
    return {unknowns[j]: residuals[i] for i, j in pairs.items()}


def _unknowns_in(
    variables: Variables, residuals: Sequence[Node], unknowns: Sequence[Node]
) -> list[int]:
    """For each residual the set (bits) of unknowns that it holds through all definitions."""
    found = {unknown: 1 << k for k, unknown in enumerate(unknowns)}
    for members in all_components(residuals, lambda node: _parts(variables, node)):
        held = 0
        for node in members:
            for part in (node, *_parts(variables, node)):
                held |= found.get(part, 0)
        found |= dict.fromkeys(members, held)
    return [found[root] for root in residuals]


def _places(bits: int) -> Iterator[int]:
    """The places of the bits that are set, in ascending order."""
    while bits:
        lowest = bits & -bits
        yield lowest.bit_length() - 1
        bits ^= lowest


def _parts(variables: Variables, node: Node) -> tuple[Node, ...]:
    """The operands or definition of a raw node; none for a state, parameter, time or unknown."""
    symbol = variables.dag.symbol_of(node)
    if symbol is None:
        return variables.dag.operands(node)
    if node not in variables.definitions and symbol.kind not in {Kind.EFFORT, Kind.FLOW}:
        return ()
    match variables.define(node):
        case Explicit(inner):
            return (inner,)
        case Rate(of):
            return (of,)
        case Unknown() | Kept():
            return ()


# --- the user's equations -----------------------------------------------------------------------


ImplicitRows: TypeAlias = dict[int, tuple[Node, dict[int, Node]]]
"""Program row -> its final right-hand side and entries of the mass matrix (none: algebraic)."""


def implicit_rows(variables: Variables, resolver: Resolver, first: int) -> ImplicitRows:
    """The rows for declared states without a derivative, and for unknowns.

    `first` is the number of the first declared state. An equation whose rates are a linear
    combination of the rates in others is reduced by these to an algebraic equation.

    Raises
    ------
    BgError
        The equations do not contain the variables that they have to determine.
    """
    graph, dag = variables.causal.graph, variables.dag
    open_states = [s for s in graph.states if s.derivative is None]
    wanted = [first + s.index for s in open_states]
    wanted += [first + len(graph.states) + u.index for u in graph.unknowns]
    names = [s.name for s in open_states] + [u.name for u in graph.unknowns]
    assert len(graph.equations) == len(wanted), "elaboration counts equations and unknowns"
    if not wanted:
        return {}
    known = {
        dag.symbol(Kind.RATE, s.index): s.derivative
        for s in graph.states
        if s.derivative is not None
    }
    raw = dag.substitute([e.residual for e in graph.equations], known)
    rates = {dag.symbol(Kind.RATE, s.index): first + s.index for s in open_states}
    forms = [
        _linear_in_rates(dag, resolver.resolve(node), rates, equation)
        for node, equation in zip(raw, graph.equations, strict=True)
    ]
    forms = _with_algebraic_rows(variables, forms)
    place = {number: k for k, number in enumerate(wanted)}
    candidates = []
    for right, entries in forms:
        by_rate = [place[number] for number in entries]
        by_value = [place[number] for number in _moving(variables, right, place)]
        candidates.append(by_rate + sorted(set(by_value) - set(by_rate)))
    pairs = match(candidates, {})
    if len(pairs) < len(wanted):
        missing = [names[k] for k in range(len(wanted)) if k not in pairs.values()]
        loose = next(i for i in range(len(forms)) if i not in pairs)
        span, right = graph.equations[loose].span, forms[loose][0]
        if candidates[loose]:
            raise BgError([catalogue.singular_equations(span, missing, "unpaired")])
        constant_in = [names[place[k]] for k in _states_in(dag, right, place).values()]
        found = derivative_with_unknown(variables, resolver, right, set(wanted))
        derivative = None if found is None else (found.order, found.equation)
        raise BgError([catalogue.equation_without_unknown(span, missing, constant_in, derivative)])
    rows = [
        Row(right, entries, equation)
        for (right, entries), equation in zip(forms, graph.equations, strict=True)
    ]
    require_determined(variables, resolver, rows, dict(zip(wanted, names, strict=True)))
    return {wanted[k]: forms[i] for i, k in pairs.items()}


def _moving(variables: Variables, right: Node, place: Mapping[int, int]) -> list[int]:
    """The states of a mapping that a node varies with: `sign(z)` is constant in z."""
    dag = variables.dag
    held = _states_in(dag, right, place)
    slopes = zip(held.values(), gradient(dag, right, list(held)), strict=True)
    return [index for index, slope in slopes if not variables.causal.fingerprints.is_zero(slope)]


def _states_in(dag: Dag, node: Node, place: Mapping[int, int]) -> dict[Node, int]:
    """The states of a mapping in a node: symbol -> number."""
    states = dag.symbols_in([node], Kind.STATE).items()
    return {node: symbol.index for node, symbol in states if symbol.index in place}


def _linear_in_rates(
    dag: Dag, residual: Node, rates: Mapping[Node, int], equation: Equation
) -> tuple[Node, dict[int, Node]]:
    """`sum entry * rate = right`, from `residual = 0`."""
    present = [node for node in dag.reachable([residual]) if node in rates]
    slopes = gradient(dag, residual, present)
    if any(dag.level[slope] > Level.PARAM for slope in slopes):
        raise BgError([catalogue.rate_not_linear(equation.span)])
    (rest,) = dag.substitute([residual], dict.fromkeys(present, dag.zero))
    return dag.neg(rest), {rates[n]: slope for n, slope in zip(present, slopes, strict=True)}


_Form: TypeAlias = tuple[Node, dict[int, Node]]
_RIGHT: Column = ("right", 0)


def _with_algebraic_rows(variables: Variables, forms: Sequence[_Form]) -> list[_Form]:
    """Eliminate rates from dependent rows; a row left without rates is algebraic."""
    dag, result = variables.dag, list(forms)
    rows = [{_RIGHT: right} | {("rate", j): x for j, x in row.items()} for right, row in forms]
    reduction = Reduction(dag, variables.causal.fingerprints, rows)
    used: list[set[Node]] = [set() for _ in forms]  # the pivots by which each row was changed
    for k, row in enumerate(reduction.rows):
        rates = [column for column in row if column != _RIGHT]
        if rates:
            best = min(rates, key=lambda column: _preference(variables, row[column]))
            for other in reduction.holding[best] - {k}:
                used[other] |= used[k] | {row[best]}
            reduction.eliminate(k, best)
        elif forms[k][1]:
            result[k] = (row.get(_RIGHT, dag.zero), {})
            for pivot in used[k]:
                if dag.level[pivot] == Level.PARAM:
                    variables.watch(pivot, "the equations for the rates are singular")
    return result


def _preference(variables: Variables, node: Node) -> int:
    """Numbers are the best pivots, then parameters that are not zero by default."""
    if variables.dag.level[node] == Level.CONST:
        return 0
    return 1 if variables.default(node) else 2
