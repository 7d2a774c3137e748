"""The structure of an FMU: the variables on which each unknown depends, and tunable parameters.

Dependencies are those of the simplified equations, from their graph. Where algebraic equations or a
mass matrix couple several states, each of a coupled group depends on whatever any of them does.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from bgc.algebra.dag import Kind
from bgc.algebra.disjoint_sets import DisjointSets
from bgc.ir.graph import Node
from bgc.ir.lowered import Lowered
from bgc.ir.program import Program
from bgc.record_class import dataclass
from bgc.runtime.fmi.fmu_variables import Table, Variable

Reads = frozenset[tuple[Kind, int]]


@dataclass(frozen=True, slots=True)
class Unknown:
    """A variable with the references of those on which it depends; None stands for all."""

    reference: int
    dependencies: tuple[int, ...] | None


@dataclass(frozen=True, slots=True)
class Structure:
    """The entries of ModelStructure, each by ascending reference."""

    outputs: tuple[Unknown, ...]
    derivatives: tuple[Unknown, ...]
    initial: tuple[Unknown, ...]
    indicators: tuple[tuple[int, ...], ...]  # dependencies of each event indicator


def tunable_parameters(program: Program) -> tuple[bool, ...]:
    """Find the parameters that act on a run and may change during it.

    Not those that act on the start alone, nor those on which sampling times or the geometry of
    closed chains depend.
    """
    fixed = [node for rate in program.rates for node in (rate.period, rate.offset)]
    if program.closures is not None:
        fixed += [*program.closures.conditions, *program.closures.starts]
    starts = {state.initial for state in program.states}
    starts |= {held.initial for held in program.held}
    if program.start is not None:
        starts |= {*program.start.residuals, *(node for _, node in program.start.values)}
    running = [node for node in _running_roots(program) if node not in starts]
    acting = _with_ancestors(program, _parameters_in(program, running))
    barred = _with_ancestors(program, _parameters_in(program, fixed))
    every = range(len(program.parameters))
    return tuple(k in acting and k not in barred for k in every)


def _running_roots(program: Program) -> Iterator[Node]:
    """The nodes that are evaluated during a run."""
    for state in program.states:
        yield state.derivative
        yield state.scale
        if state.projection is not None:
            yield state.projection
    yield from (entry.value for entry in program.mass or ())
    yield from (output.node for output in program.observations)
    yield from (value for device in program.devices for value in device.values)
    yield from (guard.condition for guard in program.guards)
    yield from (program.energy.stored, program.energy.supplied, program.energy.dissipated)
    yield from (jump.condition for jump in program.jumps)
    yield from (reset.value for jump in program.jumps for reset in jump.resets)
    yield from (held.update for held in program.held)


def _parameters_in(program: Program, nodes: Iterable[Node]) -> set[int]:
    symbols = map(program.dag.symbol_of, program.dag.reachable(nodes))
    return {s.index for s in symbols if s is not None and s.kind is Kind.PARAM}


def _with_ancestors(program: Program, parameters: set[int]) -> set[int]:
    """Parameters, and those on which their defaults depend."""
    found, waiting = set(parameters), list(parameters)
    while waiting:
        value = program.parameters[waiting.pop()].value
        more = _parameters_in(program, [value]) - found
        found |= more
        waiting += more
    return found


def model_structure(lowered: Lowered, table: Table, computed_start: bool) -> Structure:
    """Find the dependencies of outputs, rates and initial values.

    `computed_start` says that the start was found by a search, so that initial values do not follow
    from parameters alone.
    """
    return _Finder(lowered, table, computed_start).structure()


class _Finder:
    def __init__(self, lowered: Lowered, table: Table, computed_start: bool) -> None:
        self.program, self.table = lowered.program, table
        self.switches = [switch.argument for switch in lowered.switches]
        self.inputs = len(table.of("input"))
        self.first = {
            kind: (table.of(kind) or (table.variables[0],))[0].reference
            for kind in ("parameter", "input", "state")
        }
        self.reads: dict[Node, Reads] = {}
        self.groups = self._coupled()
        program = self.program
        self.simple_start = (
            not computed_start and program.start is None and program.closures is None
        )

    # --- what nodes read ------------------------------------------------------------------------

    def symbols(self, node: Node) -> Reads:
        """The symbols in a node; the modes of switches stand for their arguments."""
        if node not in self.reads:
            dag = self.program.dag
            found: set[tuple[Kind, int]] = set()
            waiting, seen = [node], {node}
            while waiting:
                for s in map(dag.symbol_of, dag.reachable([waiting.pop()])):
                    if s is None:
                        continue
                    mode = s.index - self.program.inputs
                    if s.kind is Kind.INPUT and mode >= 0:
                        argument = self.switches[mode]
                        if argument not in seen:
                            seen.add(argument)
                            waiting.append(argument)
                    else:
                        found.add((s.kind, s.index))
            self.reads[node] = frozenset(found)
        return self.reads[node]

    def _coupled(self) -> list[list[int]]:
        """For each state the states that mass matrix or algebraic equations couple with it."""
        program = self.program
        size = len(program.states)
        sets = DisjointSets(size)
        for entry in program.mass or ():
            sets.unite(entry.row, entry.column)
        free = set(self.table.free)
        for row, state in enumerate(program.states):
            if state.kind == "algebraic":
                for kind, index in self.symbols(state.derivative):
                    if kind is Kind.STATE and (index not in free or len(free) == size):
                        sets.unite(row, index)
        members: dict[int, list[int]] = {}
        for k in range(size):
            members.setdefault(sets.find(k), []).append(k)
        return [members[sets.find(k)] for k in range(size)]

    def running(self, nodes: Iterable[Node]) -> set[int]:
        """References of the continuous states, inputs and time that nodes depend on."""
        found: set[int] = set()
        free = set(self.table.free)
        waiting = [self.symbols(node) for node in nodes]
        solved: set[int] = set()
        while waiting:
            for kind, index in waiting.pop():
                if kind is Kind.TIME:
                    found.add(0)
                elif kind is Kind.INPUT and index < self.inputs:
                    found.add(self.first["input"] + index)
                elif kind is Kind.STATE and index in free:
                    found.add(self.first["state"] + index)
                elif kind is Kind.STATE and index not in solved:
                    solved |= set(self.groups[index])
                    waiting += [
                        self.symbols(self.program.states[k].derivative) for k in self.groups[index]
                    ]
        return found

    # --- entries ---------------------------------------------------------------------------------

    def structure(self) -> Structure:
        """All entries."""
        table = self.table
        outputs = [v for v in table.listed if v.causality == "output"]
        rates = [v for v in table.listed if v.derivative_of is not None]
        unknown = [
            v
            for v in table.listed
            if v.causality == "output"
            or v.reference in table.continuous
            or v.derivative_of is not None
        ]
        return Structure(
            tuple(Unknown(v.reference, self._while_running(v)) for v in outputs),
            tuple(Unknown(v.reference, self._while_running(v)) for v in rates),
            tuple(Unknown(v.reference, self._at_start(v)) for v in unknown),
            tuple(tuple(sorted(self.running([node]))) for node in self.switches),
        )

    def _nodes(self, variable: Variable) -> list[Node]:
        """The nodes from which a variable is computed during a run."""
        program, k = self.program, variable.index
        energy = program.energy
        match variable.kind:
            case "output":
                return [program.observations[k].node]
            case "command":
                return [[v for device in program.devices for v in device.values][k]]
            case "rate":
                return [program.states[j].derivative for j in self.groups[k]]
            case "power":
                return [(energy.supplied, energy.dissipated)[k]]
            case "account":
                return [energy.stored] if k in (0, 3) else []
            case _:
                return []

    def _while_running(self, variable: Variable) -> tuple[int, ...]:
        found = self.running(self._nodes(variable))
        if variable.kind == "account":
            supplied, dissipated = self.table.continuous[-2:]
            found |= {1: {supplied}, 2: {dissipated}, 3: {supplied, dissipated}}.get(
                variable.index, set()
            )
        return tuple(sorted(found))

    def _at_start(self, variable: Variable) -> tuple[int, ...] | None:
        """Dependencies on parameters, inputs and time at the start; None where all may count."""
        program = self.program
        if variable.kind == "account":
            return ()  # they begin at zero
        nodes = self._nodes(variable)
        if variable.kind == "state":
            nodes = [program.states[variable.index].initial]
        waiting = [self.symbols(node) for node in nodes]
        if variable.kind == "rate":
            members = self.groups[variable.index]
            waiting += [
                self.symbols(entry.value) for entry in program.mass or () if entry.row in members
            ]
        parameters: set[int] = set()
        found: set[int] = set()
        seen: set[int] = set()
        if variable.kind == "state" and program.states[variable.index].kind == "algebraic":
            return None
        while waiting:
            for kind, index in waiting.pop():
                if kind is Kind.PARAM:
                    parameters.add(index)
                elif kind is Kind.TIME:
                    found.add(0)
                elif kind is Kind.INPUT and index < self.inputs:
                    found.add(self.first["input"] + index)
                elif kind is Kind.INPUT or kind is Kind.STATE:
                    if kind is Kind.INPUT or program.states[index].kind == "algebraic":
                        return None
                    if index not in seen:
                        seen.add(index)
                        waiting.append(self.symbols(program.states[index].initial))
        touches_state = variable.kind == "state" or bool(seen)
        if touches_state and not self.simple_start:
            return None
        every = _with_ancestors(program, parameters)
        return tuple(sorted(found | {self.first["parameter"] + k for k in every}))
