"""The multipliers of closing rows, from the condition that the rows stay satisfied.

A row `w = G u + G_s s = 0` that closes a chain has a multiplier l, which acts on the momenta by
`-G' l`. While the other equations are derived it is a symbol of its own. The rates of all states
are then linear in l, and so is the rate of w:

    w' = w'(l = 0) - S l,  S = G M^-1 G'.

Setting it to zero gives l by an unrolled L D L' (index 1 by differentiation, solved in the DAG):
every integrator then sees explicit equations. Integration keeps w = 0 only within its tolerance;
each completed step projects the momenta, and with `project x = value` of a signal the positions
(Hairer, Lubich, Wanner, Geometric Numerical Integration, IV.4; `runtime/c/closures.c`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from bgc.algebra.dag import Dag, Kind
from bgc.algebra.derivatives import directional_derivative, gradient
from bgc.algebra.disjoint_sets import groups_sharing
from bgc.algebra.symbolic_systems import solve_definite
from bgc.equations.loops.substitution import Resolver
from bgc.equations.variables.definitions import Variables
from bgc.ir.fields import map_nodes, nodes_of
from bgc.ir.graph import Condition, Matrix, Node
from bgc.ir.program import Program
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class ClosingRows:
    """The closing rows and the conditions of a graph, resolved to states, time and parameters."""

    flows: tuple[Node, ...]
    conditions: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class Responses:
    """The action of multipliers on the states of a program.

    `by_impulse[c]` is the derivative of flow c by the states `impulses`, `response[k]` the rate of
    the k-th of these by each multiplier.
    """

    impulses: tuple[int, ...]
    by_impulse: Matrix
    response: Matrix


def closing_rows(variables: Variables, resolver: Resolver) -> ClosingRows:
    """Resolve the closing rows and the conditions of a graph."""
    causal, dag, symbols = variables.causal, variables.dag, variables.symbols
    flows = []
    for closure in causal.closures:
        ends = causal.rows[closure.row].ends
        terms = (dag.mul(end.coefficient, symbols.through(end.bond)) for end in ends)
        flows.append(resolver.resolve(dag.sum(terms)))
    conditions: Sequence[Condition] = causal.graph.conditions
    return ClosingRows(tuple(flows), tuple(resolver.resolve(c.residual) for c in conditions))


def responses_of(program: Program, variables: Variables, flows: Sequence[Node]) -> Responses:
    """The derivatives of the flows by the states that multipliers act on, and these actions.

    Raises
    ------
    BgError
        The reaction in a chain depends on itself, or a row on a value without a known rate.
    """
    dag, multipliers = program.dag, variables.multipliers
    _require_rates(program, variables, flows)
    states = [dag.symbol(Kind.STATE, k) for k in range(len(program.states))]
    slopes = [gradient(dag, flow, states) for flow in flows]
    impulses, response = [], []
    known = set(multipliers)
    for k, state in enumerate(program.states):
        if known.isdisjoint(dag.reachable([state.derivative])):
            continue
        rates = gradient(dag, state.derivative, multipliers)
        if not known.isdisjoint(dag.reachable(rates)):
            raise variables.places.rate_in_loop(multipliers)
        if any(row[k] != dag.zero for row in slopes):
            impulses.append(k)
            response.append(tuple(rates))
    by_impulse = tuple(tuple(row[k] for k in impulses) for row in slopes)
    return Responses(tuple(impulses), by_impulse, tuple(response))


def _require_rates(program: Program, variables: Variables, flows: Sequence[Node]) -> None:
    """Refuse a closing row with an input or an unknown of an algebraic loop."""
    dag = program.dag
    coupled = {m.row for m in program.mass or () if m.row != m.column or m.value != dag.one}
    for flow, multiplier in zip(flows, variables.multipliers, strict=True):
        for leaf in dag.symbols_in([flow]).values():
            if leaf.kind in {Kind.PARAM, Kind.TIME}:
                continue
            is_state = leaf.kind is Kind.STATE and leaf.index not in coupled
            if not is_state or program.states[leaf.index].kind == "algebraic":
                raise variables.places.no_rate(multiplier)


def response_matrix(dag: Dag, responses: Responses, rows: Sequence[int]) -> list[dict[int, Node]]:
    """`S = G M^-1 G'` of some rows, sparse."""
    matrix: list[dict[int, Node]] = []
    for i in rows:
        line: dict[int, Node] = {}
        for column, j in enumerate(rows):
            actions = [action[j] for action in responses.response]
            entry = dag.neg(dag.dot(responses.by_impulse[i], actions))
            if entry != dag.zero:
                line[column] = entry
        matrix.append(line)
    return matrix


def motion_without(
    program: Program, multipliers: Sequence[Node]
) -> tuple[Sequence[Node], dict[Node, Node]]:
    """The rates of the states with zero multipliers, and these by symbol with 1 for the time."""
    dag = program.dag
    none = dict.fromkeys(multipliers, dag.zero)
    rates = dag.substitute([state.derivative for state in program.states], none)
    direction = {dag.symbol(Kind.STATE, k): rate for k, rate in enumerate(rates)}
    direction[dag.symbol(Kind.TIME)] = dag.one
    return rates, direction


def settled(
    program: Program, variables: Variables, flows: Sequence[Node], responses: Responses,
    selectors: Mapping[int, Node],
) -> Program:  # fmt: skip
    """The program with the multipliers of rows solved for where their selectors are 1.

    Those of other rows are zero: `(E S E + 1 - E) l = E w'(l = 0)` with the selectors in E.
    """
    dag, multipliers = program.dag, variables.multipliers
    none = dict.fromkeys(multipliers, dag.zero)
    _, direction = motion_without(program, multipliers)
    kept = list(selectors)
    right = [dag.mul(selectors[k], directional_derivative(dag, flows[k], direction)) for k in kept]
    matrix = response_matrix(dag, responses, kept)
    for i, line in enumerate(matrix):
        selector = selectors[kept[i]]
        for j, entry in line.items():
            line[j] = dag.mul(dag.mul(selector, selectors[kept[j]]), entry)
        line[i] = dag.add(line.get(i, dag.zero), dag.sub(dag.one, selector))
    values: Mapping[Node, Node] = none
    if kept:
        (solution,) = solve_definite(dag, variables.causal.fingerprints, matrix, [right])
        values = none | {multipliers[k]: node for k, node in zip(kept, solution, strict=True)}
    roots = nodes_of(program)
    new = dict(zip(roots, dag.substitute(roots, values), strict=True))
    return map_nodes(program, dag, new.__getitem__)


def connected_rows(dag: Dag, variables: Variables, responses: Responses,
                   kept: Sequence[int]) -> list[list[int]]:  # fmt: skip
    """The kept rows in groups whose multipliers depend on each other."""
    is_zero = variables.causal.fingerprints.is_zero
    matrix = response_matrix(dag, responses, kept)
    coupled = [{i, *(j for j, x in row.items() if not is_zero(x))} for i, row in enumerate(matrix)]
    return [[kept[i] for i in group] for group in groups_sharing(coupled)]
