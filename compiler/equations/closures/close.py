"""Close the chains of a program: independent rows, their multipliers, and what projection needs.

The rows are examined as numbers, at the closed start and at random closed configurations: those
that follow from others are dropped, with a warning that the internal efforts are undetermined. A
chain that cannot be closed, or whose rank is not the same everywhere near the start, is refused.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from operator import mul

from bgc.algebra.dag import Dag, Kind, Symbol
from bgc.algebra.dense import independent_in, solve_dense
from bgc.algebra.derivatives import directional_derivative, gradient
from bgc.algebra.evaluate import Evaluator
from bgc.causality.paths import connections
from bgc.diagnostics.catalogue import closures as catalogue
from bgc.diagnostics.catalogue import listed
from bgc.diagnostics.catalogue.equations import unrepresentable
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.equations.closures.contradiction import body_aside, is_within_reach
from bgc.equations.closures.manifold import (
    CLOSED,
    Conditions,
    Point,
    Start,
    closed,
    closed_flows,
    closed_points,
    closed_start,
    gap_of,
    independent_conditions,
    nearest_to_closed,
    response_at,
)
from bgc.equations.closures.multipliers import (
    ClosingRows,
    Responses,
    connected_rows,
    motion_without,
    responses_of,
    settled,
)
from bgc.equations.closures.start_check import require_given
from bgc.equations.start.given import given_names
from bgc.equations.variables.definitions import Variables
from bgc.ir.defaults import default_values, program_values, start_values
from bgc.ir.graph import Node
from bgc.ir.program import ClosedChain, Closures, Program
from bgc.record_class import dataclass, replace

_DEPENDENT = 1e-11  # pivot of S over its diagonal: squares of sines
_NOISE = 1e-18  # of the largest diagonal of S: squares of coefficients that rounded data leave over
_NOISE_IN_A_CHAIN = 1e-12  # the same of the largest in one chain, whose flows are of similar size
_ROUNDED = 1e-3  # m or rad: given values of this accuracy are moved until the chain is closed
_MOUNT_GAP = 0.1  # m or rad: larger gaps are not those of mounts
_KEPT = 1e-5  # rate of a condition, relative to its terms
_ALIKE = 1e-3  # difference of the shares of rows in another, at points where the chain is closed


def close_chains(program: Program, variables: Variables, rows: ClosingRows) -> Program:
    """Solve for the multipliers, and note what keeps the chains closed.

    Raises
    ------
    BgError
        BG526: the start does not close. BG527: it is at a singular position. BG528: a projected
        signal is not kept by the bonds. BG502: the rows that close a chain change their rank.
        BG546: the closed chain moves a given flow. BG550: mounts contradict each other.
    """
    if not (rows.flows or rows.conditions):
        return program
    return _Closing(program, variables, rows).closed()


@dataclass(frozen=True, slots=True)
class _Chosen:
    """The rows and conditions from which the others follow.

    Others may take their place along a run in the `changing` chains, which are lists of rows, and
    among the conditions if these are `changing_conditions`.
    """

    flows: list[int]
    conditions: list[int]
    changing: list[list[int]]
    changing_conditions: bool


class _Closing:
    def __init__(self, program: Program, variables: Variables, rows: ClosingRows) -> None:
        self._program = program
        self._variables = variables
        self._dag: Dag = program.dag
        self._graph = variables.causal.graph
        self._rows = rows
        self._responses: Responses = responses_of(program, variables, rows.flows)
        self._groups = connected_rows(self._dag, variables, self._responses, range(len(rows.flows)))
        self._conditions = self._conditions_on_states()
        self._start = self._start_parameters()

    def closed(self) -> Program:
        """The program with its multipliers solved for, and its `closures`."""
        program = self._program
        values = default_values(self._dag, program.parameters)
        start, found = self._closed_start(values)
        points = [start, *closed_points(self._dag, self._conditions, start)]
        chosen = self._choose(points)
        selectors = self._selectors(chosen)
        made = settled(program, self._variables, self._rows.flows, self._responses, selectors)
        dropped = sorted(set(range(len(self._rows.flows))) - set(chosen.flows))
        made = replace(
            made,
            closures=self._closures(chosen, selectors),
            warnings=(*program.warnings, *self._warn(dropped), *self._warn_of_moves(start)),
        )
        self._require_kept(points, made)
        rounded = start != start_values(program, start)
        require_given(made, program_values(made) | start, rounded=rounded)
        return self._with_start(made, values, found)

    # --- conditions and the start ---------------------------------------------------------------

    def _conditions_on_states(self) -> Conditions:
        """The conditions with the states that they hold, and their derivatives by these."""
        dag, nodes = self._dag, self._rows.conditions
        held = {leaf.index for leaf in dag.symbols_in(nodes, Kind.STATE).values()}
        impulses = set(self._responses.impulses)
        for condition, node in zip(self._graph.conditions, nodes, strict=True):
            for leaf in dag.symbols_in([node]).values():
                if leaf.kind in {Kind.PARAM, Kind.TIME}:
                    continue
                state = self._program.states[leaf.index] if leaf.kind is Kind.STATE else None
                if state is None or state.kind == "algebraic" or leaf.index in impulses:
                    raise BgError([catalogue.not_kept(condition.span, condition.name)])
        moved = sorted(held)
        symbols = [dag.symbol(Kind.STATE, k) for k in moved]
        return Conditions(nodes, moved, [gradient(dag, node, symbols) for node in nodes])

    def _start_parameters(self) -> Start:
        """The parameters that give the start of states in conditions, and that nothing sets."""
        dag, states = self._dag, self._program.states
        free = {state.name: state.free for state in self._graph.states}
        nodes = dict.fromkeys(
            node for k in self._conditions.moved for node in free.get(states[k].name, ())
        )
        starts = self._in_terms_of(set(nodes), [states[k].initial for k in self._conditions.moved])
        slopes = [gradient(dag, start, nodes) for start in starts]
        symbols = [dag.symbol_of(node) for node in nodes]
        return Start([symbol for symbol in symbols if symbol is not None], starts, slopes)

    def _in_terms_of(self, free: set[Node], starts: Sequence[Node]) -> list[Node]:
        """Starts with the parameters that others give replaced by these, as far as free ones."""
        dag = self._dag
        values = {dag.symbol(Kind.PARAM, p.index): p.value for p in self._program.parameters}
        found = list(starts)
        for _ in values:
            held = (set(dag.reachable(found)) & values.keys()) - free
            if not held:
                break
            found = dag.substitute(found, {node: values[node] for node in held})
        return found

    def _closed_start(self, values: dict[Symbol, float]) -> tuple[Point, dict[Symbol, float]]:
        """The start, moved until it is closed, and the values of parameters that close it."""
        dag, conditions, program = self._dag, self._conditions, self._program
        declared = start_values(program, values)
        residuals, _ = conditions.at(dag, declared)
        if gap_of(residuals) <= CLOSED:
            return declared, values
        found = closed_start(program, conditions, self._start, values)
        if found is not None:
            moved = self._with_start(program, values, found)
            values = default_values(dag, moved.parameters)
            return start_values(program, values), found
        near = closed(dag, conditions, declared)
        symbols = [Symbol(Kind.STATE, k) for k in conditions.moved]
        if near is not None:
            moves = [abs(near[s] - declared[s]) for s in symbols]
            if gap_of(moves) <= _ROUNDED:
                return near, values
        if near is None:
            self._require_no_contradiction(declared)
        worst = max(range(len(residuals)), key=lambda k: abs(residuals[k]))
        condition = self._graph.conditions[worst]
        states = self._program.states
        ways = [] if near is None else [(states[s.index].name, near[s]) for s in symbols]
        raise BgError(
            [catalogue.open_start(condition.span, condition.name, residuals[worst], ways)]
        )

    def _require_no_contradiction(self, declared: Point) -> None:
        """Refuse mounts that leave a small gap in every position of the joints."""
        near, residuals = nearest_to_closed(self._dag, self._conditions, declared)
        worst = max(range(len(residuals)), key=lambda k: abs(residuals[k]))
        condition, misfit = self._graph.conditions[worst], residuals[worst]
        body = body_aside(self._graph)
        is_small = abs(misfit) < _MOUNT_GAP and is_within_reach(self._dag, self._conditions, near)
        if body or is_small:
            raise BgError(
                [catalogue.contradicting_mounts(condition.span, condition.name, misfit, body)]
            )

    def _with_start(
        self, program: Program, declared: dict[Symbol, float], found: dict[Symbol, float]
    ) -> Program:
        """The program with defaults that close its start, where nothing gives them."""
        parameters = list(program.parameters)
        for symbol in self._start.parameters:
            if found[symbol] != declared[symbol]:
                value = self._dag.const(found[symbol])
                parameters[symbol.index] = replace(parameters[symbol.index], value=value)
        return replace(program, parameters=tuple(parameters))

    # --- independent rows -------------------------------------------------------------------------

    def _choose(self, points: Sequence[Point]) -> _Chosen:
        """Rows from which all others follow, at the start and at the random points."""
        every = range(len(self._rows.flows))
        slopes = [self._conditions.at(self._dag, point)[1] for point in points]
        held = [sorted(independent_conditions(table)) for table in slopes]
        tables = [response_at(self._dag, self._responses, p, every)[0] for p in points]
        if not _finite(tables[0]):
            chain = self._chain(every)
            raise BgError(
                [unrepresentable(chain.span, f"the closed chain of {listed(chain.names)}", "inf")]
            )
        tables = list(filter(_finite, tables))
        whole = self._but_for_rounding([max(table[k][k] for table in tables) for k in every])
        orders = [independent_in(table, whole, _DEPENDENT) for table in tables]
        rank = max(map(len, orders))
        is_lower = len(orders[0]) < rank or len(held[0]) < max(map(len, held))
        if is_lower and self._rows.conditions:
            if not every:
                self._require_kept(points, self._program)
            chain = self._chain(sorted(set(orders[-1]) - set(orders[0])) or every)
            raise BgError([catalogue.singular_start(chain.span, chain.names)])
        if len(orders[0]) < len(self._acted_on()) and not self._rows.conditions:
            raise self._refused(every)
        kept = sorted(orders[0])
        grams = [_gram(table) for table in slopes]
        return _Chosen(
            flows=kept,
            conditions=held[0],
            changing=[group for group in self._groups if not _is_lasting(tables, kept, group)],
            changing_conditions=not _is_lasting(grams, held[0], range(len(self._rows.conditions))),
        )

    def _but_for_rounding(self, diagonal: Sequence[float]) -> list[float]:
        """The diagonal of S, with zeros for rows that would be zero in exact directions.

        Mounts in seven digits leave 1e-7 of a coefficient over where directions cancel.
        """
        least = [_NOISE * max(diagonal, default=0.0)] * len(diagonal)
        for group in self._groups:
            largest = max(diagonal[k] for k in group)
            for k in group:
                least[k] = max(least[k], _NOISE_IN_A_CHAIN * largest)
        return [x if x > limit else 0.0 for x, limit in zip(diagonal, least, strict=True)]

    def _acted_on(self) -> list[int]:
        """The rows that momenta take part in; all others have to be satisfied by themselves."""
        is_zero = self._variables.causal.fingerprints.is_zero
        found = []
        for k, (flow, row) in enumerate(
            zip(self._rows.flows, self._responses.by_impulse, strict=True)
        ):
            if not all(map(is_zero, row)):
                found.append(k)
            elif not is_zero(flow):
                raise self._refused([k])
        return found

    def _require_kept(self, points: Sequence[Point], program: Program) -> None:
        """Refuse a condition whose rate is not zero where the rows of the program are satisfied."""
        rates, direction = motion_without(self._program, self._variables.multipliers)
        speeds = [rates[k] for k in self._conditions.moved]
        nodes = [
            directional_derivative(self._dag, node, direction) for node in self._rows.conditions
        ]
        for point in points:
            moving = program_values(program) | point
            for number, k in enumerate(self._responses.impulses):
                moving[Symbol(Kind.STATE, k)] += math.sin(1.0 + number)
            if program.closures is not None:
                moving = closed_flows(program, moving)
            numbers = Evaluator(self._dag, moving.__getitem__)
            limit = _KEPT * math.hypot(*numbers.values(speeds)) + 1e-300
            for condition, rate in zip(self._graph.conditions, numbers.values(nodes), strict=True):
                if not abs(rate) <= limit:
                    raise BgError([catalogue.not_kept(condition.span, condition.name)])

    # --- results ----------------------------------------------------------------------------------

    def _selectors(self, chosen: _Chosen) -> dict[int, Node]:
        """The rows with a multiplier, each with its selector."""
        changing = {row for group in chosen.changing for row in group}
        rows = sorted(changing | set(chosen.flows))
        numbers = itertools.count(len(self._program.parameters))
        return {
            row: self._dag.symbol(Kind.SELECTOR, next(numbers))
            if row in changing
            else self._dag.one
            for row in rows
        }

    def _closures(self, chosen: _Chosen, selectors: Mapping[int, Node]) -> Closures:
        groups = connected_rows(self._dag, self._variables, self._responses, list(selectors))
        groups = [sorted(group, key=lambda row: row not in chosen.flows) for group in groups]
        kept = [row for group in groups for row in group]
        dropped = sorted(set(range(len(self._rows.flows))) - set(kept))
        others = sorted(set(range(len(self._rows.conditions))) - set(chosen.conditions))
        held = [*chosen.conditions, *(others if chosen.changing_conditions else ())]
        return Closures(
            chains=tuple(self._chain(group) for group in groups),
            chain_of=tuple(k for k, group in enumerate(groups) for _ in group),
            flows=tuple(self._rows.flows[k] for k in (*kept, *dropped)),
            kept=len(kept),
            ranks=tuple(len(set(group) & set(chosen.flows)) for group in groups),
            selectors=tuple(selectors[row] for row in kept),
            conditions=tuple(self._rows.conditions[k] for k in (*chosen.conditions, *others)),
            names=tuple(self._graph.conditions[k].name for k in (*chosen.conditions, *others)),
            held=len(held),
            held_rank=len(chosen.conditions),
            impulses=self._responses.impulses,
            moved=tuple(self._conditions.moved),
            starts=tuple(self._dag.symbol(s.kind, s.index) for s in self._start.parameters),
            by_impulse=tuple(self._responses.by_impulse[k] for k in kept),
            response=tuple(tuple(row[k] for k in kept) for row in self._responses.response),
            by_place=tuple(tuple(self._conditions.slopes[k]) for k in held),
            by_start=tuple(map(tuple, self._start.slopes)),
        )

    def _chain(self, rows: Sequence[int]) -> ClosedChain:
        """The parts along the chain of some rows; without rows, the projected signals.

        In a chain that was opened these are the part that closes it and the joints before it.
        """
        if not rows:
            conditions = self._graph.conditions
            return ClosedChain(tuple(c.name for c in conditions), conditions[0].span)
        closures = self._variables.causal.closures
        elements = [self._graph.elements[k] for row in rows for k in closures[row].elements]
        names = [element.name for element in elements]
        if self._variables.causal.opened:
            responses, zero = self._responses, self._dag.zero
            held = {
                k
                for row in rows
                for k, slope in zip(responses.impulses, responses.by_impulse[row], strict=True)
                if slope != zero
            }
            names += [self._program.states[k].name for k in sorted(held)]
        return ClosedChain(_parts(names), elements[0].span)

    def _refused(self, rows: Sequence[int]) -> BgError:
        """The refusal of a chain whose rank cannot be relied on."""
        closures = self._variables.causal.closures
        chain = sorted({k for row in rows for k in closures[row].elements})
        moduli = [k for k in chain if self._graph.elements[k].kind in {"TF", "MTF"}]
        others = [k for k in chain if k not in moduli]
        span = self._graph.elements[chain[0]].span if chain else self._graph.conditions[0].span
        found = connections(self._graph, moduli), connections(self._graph, others)
        return BgError([catalogue.changing_rank(span, *found)])

    def _warn(self, dropped: Sequence[int]) -> list[Diagnostic]:
        """Say which chains are held more than once."""
        if not dropped:
            return []
        chain = self._chain(dropped)
        return [catalogue.redundant_rows(chain.span, chain.names, len(dropped))]

    def _warn_of_moves(self, start: Point) -> list[Diagnostic]:
        """Name the given positions that closing the chains moves, for the parameters of the scene.

        A start at rest moves them anyway.
        """
        program = self._program
        if program.scene.rest is not None:
            return []
        before, states = start_values(program, start), program.states
        symbols = [Symbol(Kind.STATE, k) for k in range(len(states))]
        given = given_names(self._graph, [state.name for state in states])
        shown = catalogue.named_moves(
            (start[symbol] - before[symbol], name, state.name, state.unit)
            for symbol, name, state in zip(symbols, given, states, strict=True)
        )
        return [catalogue.moved_positions(shown)] if shown else []


def _is_lasting(
    tables: Sequence[Sequence[Sequence[float]]], chosen: Sequence[int], group: Sequence[int]
) -> bool:
    """Test whether the other rows in a group follow from the chosen ones alike at all points.

    `tables` are the matrices of their scalar products. Of a planar linkage they do if the rows are
    in axes of a body. In other axes, about which its plane turns, the chosen rows become dependent
    where a share grows beyond all bounds.
    """
    kept = [row for row in group if row in chosen]
    shares = []
    for table in tables:
        part = [[table[i][j] for j in kept] for i in kept]
        others = ([table[i][row] for i in kept] for row in group if row not in kept)
        shares.append([solve_dense(part, other) or [math.nan] * len(kept) for other in others])
    return all(
        abs(share - first) <= _ALIKE * (1 + abs(first))
        for found in shares
        for row, others in zip(found, shares[0], strict=True)
        for share, first in zip(row, others, strict=True)
    )


def _gram(table: Sequence[Sequence[float]]) -> list[list[float]]:
    """The scalar products of the rows of a matrix."""
    return [[sum(map(mul, row, other)) for other in table] for row in table]


def _finite(table: Sequence[Sequence[float]]) -> bool:
    return all(math.isfinite(x) for row in table for x in row)


def _parts(names: Sequence[str]) -> tuple[str, ...]:
    """The parts that some elements belong to: their paths as far as they first differ, and on."""
    paths = [name.split(".") for name in dict.fromkeys(names)]
    depth = 0
    while paths and all(len(path) > depth + 1 and path[depth] == paths[0][depth] for path in paths):
        depth += 1
    return tuple(dict.fromkeys(".".join(path[: depth + 1]) for path in paths))
