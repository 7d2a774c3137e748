"""Check the invariants of each intermediate representation.

Each pass relies on the invariants of the representation that it receives. A violation raises
`BrokenInvariant`: it is a bug in bgc, never an error in the user's model. The passes themselves
check numerical identities (`N` against the original rows, the power balance) in every compilation.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from itertools import accumulate
from typing import Any

from bgc.algebra.dag import Dag, Kind, Level
from bgc.ir.causal import CausalGraph
from bgc.ir.fields import INDICES, nodes_of, values_of
from bgc.ir.graph import (
    Element,
    FlatGraph,
    Gyrator,
    Gyristor,
    LinearLaw,
    Matrix,
    Node,
    Parameter,
    Resistor,
    Storage,
    Transformer,
    ports_of,
)
from bgc.ir.lowered import SCRATCH, BlockPlan, Kernel, Lowered, LuPlan
from bgc.ir.program import Program


class BrokenInvariant(AssertionError):
    """The result of a pass violates an invariant of its representation."""


def verify(result: object) -> None:
    """Check the invariants of the result of a pass; other objects are accepted."""
    match result:
        case FlatGraph():
            _verify_graph(result)
        case CausalGraph():
            _verify_causal(result)
        case Program():
            _verify_program(result)
        case Lowered():
            _verify_lowered(result)
        case _:
            pass


def _require(holds: bool, message: str) -> None:
    if not holds:
        raise BrokenInvariant(message)


def _verify_graph(graph: FlatGraph) -> None:
    """Require two ends per bond, symbols of this graph only, and laws that fit their ports."""
    _require_indices(graph)
    _require_numbered("bond", (bond.index for bond in graph.bonds))
    _require_numbered("parameter", (parameter.index for parameter in graph.parameters))
    _require_numbered("state", (state.index for state in graph.states))
    _require_numbered("unknown", (unknown.index for unknown in graph.unknowns))
    ends = Counter((p.bond, p.sign) for element in graph.elements for p in ports_of(element))
    expected = {(bond.index, sign): 1 for bond in graph.bonds for sign in (-1, 1)}
    _require(ends == expected, "a bond has other ends than one tail and one head")
    storage = [element for element in graph.elements if isinstance(element, Storage)]
    places = sorted(e.first_state + k for e in storage for k in range(len(e.ports)))
    _require(places == list(range(len(places))), "storage ports are not numbered one by one")
    for element in graph.elements:
        _verify_matrix(element)
    inputs = sum(len(device.inputs) for device in graph.devices)
    inputs += graph.varied + len(graph.held)
    _verify_held(graph)
    counts = {
        Kind.PARAM: len(graph.parameters),
        Kind.TIME: 1,
        Kind.INPUT: inputs,
        Kind.STATE: len(graph.states),
        Kind.RATE: len(graph.states),
        Kind.UNKNOWN: len(graph.unknowns),
        Kind.EFFORT: len(graph.bonds),
        Kind.FLOW: len(graph.bonds),
        Kind.DISPLACEMENT: len(places),
        Kind.MOMENTUM: len(places),
    }
    _require_symbols(graph.dag, nodes_of(graph), counts)
    _require_parameters(graph.dag, graph.parameters)
    resettable = {Kind.STATE, Kind.DISPLACEMENT, Kind.MOMENTUM}
    for reset in (reset for jump in graph.jumps for reset in jump.resets):
        target = graph.dag.symbol_of(reset.target)
        _require(target is not None and target.kind in resettable, "a reset is not of a state")
    observed = {observation.name for observation in graph.observations}
    others = [column for column in graph.scene.columns if column not in observed]
    _require(len(others) == len(graph.scene.accounts), "a column is not observed")


def _verify_held(result: FlatGraph | Program) -> None:
    """Require one INPUT symbol for each held value, and rates that exist and do not vary."""
    indices = [held.index for held in result.held]
    _require(len(set(indices)) == len(indices), "two held values have one symbol")
    for rate in result.rates:
        level = max(result.dag.level[rate.period], result.dag.level[rate.offset])
        _require(level <= Level.PARAM, "a sampling period varies")


def _verify_matrix(element: Element) -> None:
    """Require that the matrix of a law has one row and column per port."""
    match element:
        case Storage(law=LinearLaw(matrix=matrix)) | Resistor(law=LinearLaw(matrix=matrix)):
            size = len(element.ports)
            _require_shape(element.name, matrix, size, size)
        case Transformer():
            sizes = (len(element.ports2), len(element.ports1))
            _require_shape(
                element.name,
                element.matrix,
                *(sizes if element.given in {"f2", "e1"} else sizes[::-1]),
            )
        case Gyrator():
            _require_shape(element.name, element.matrix, len(element.ports2), len(element.ports1))
        case Gyristor():
            size = len(element.ports)
            _require_shape(element.name, element.matrix, size, size)
        case _:
            pass


def _verify_causal(causal: CausalGraph) -> None:
    """Require one class and one stroke per bond, and each class to be dependent or in the basis."""
    _require_indices(causal)
    bonds = len(causal.graph.bonds)
    for name, table in (
        ("dual", causal.dual),
        ("class_of", causal.class_of),
        ("strokes", causal.strokes),
    ):
        _require(len(table) == bonds, f"`{name}` has {len(table)} entries for {bonds} bonds")
    members = {bond: k for k, found in enumerate(causal.classes) for bond in found.bonds}
    _require(
        members == dict(enumerate(causal.class_of)),
        "`classes` does not fit `class_of`",
    )
    _require(len(causal.flows) == len(causal.classes), "a class has no row of N")
    dependent = [step.dependent for step in causal.steps]
    independent = [basis.bond_class for basis in causal.basis]
    _require(
        sorted(dependent + independent) == list(range(len(causal.classes))),
        "a class is not either eliminated or in the basis",
    )
    for place, basis in enumerate(causal.basis):
        own = causal.flows[basis.bond_class]
        unit = own == ((place, causal.graph.dag.one),)
        _require(unit, "an independent flow is not its own row of N")


def _verify_program(program: Program, modes: int = 0) -> None:
    """Require symbols of the program only, a mass matrix of the right size, and unique names."""
    _require_indices(program)
    dag = program.dag
    names = Counter(state.name for state in program.states)
    twice = [name for name, count in names.items() if count > 1]
    _require(not twice, f"two states are called `{', '.join(twice)}`")
    closures = program.closures
    selectors = 0 if closures is None else sum(s != dag.one for s in closures.selectors)
    counts = {
        Kind.PARAM: len(program.parameters),
        Kind.SELECTOR: len(program.parameters) + selectors,
        Kind.TIME: 1,
        Kind.INPUT: program.inputs + modes,
        Kind.STATE: len(program.states),
        Kind.START: 0 if program.start is None else len(program.start.guess),
    }
    _require_symbols(dag, nodes_of(program), counts)
    _require_parameters(dag, program.parameters)
    for state in program.states:
        _require(dag.level[state.initial] < Level.STATE, f"`{state.name}` starts at a state")
        _require(dag.level[state.scale] <= Level.PARAM, f"the scale of `{state.name}` varies")
    for entry in program.mass or ():
        _require(dag.level[entry.value] <= Level.PARAM, "an entry of M varies")
        kind = program.states[entry.row].kind
        zero = entry.value == dag.zero
        _require(kind != "algebraic" or zero, "an algebraic row has an entry in M")
    _verify_held(program)
    for divisor in program.divisors:
        _require(dag.level[divisor.node] > Level.PARAM, "a watched divisor does not vary")
    for jump in program.jumps:
        _require(dag.level[jump.condition] > Level.PARAM, "the condition of a jump never changes")
        _require(bool(jump.resets), "a jump resets nothing")
        for reset in jump.resets:
            moves = program.states[reset.state].kind != "algebraic"
            _require(moves, "a jump resets what is not integrated")
    if program.speeds is not None:
        speeds = program.speeds
        roots = (*speeds.values, *speeds.residuals)
        _require(len(speeds.values) == len(speeds.residuals), "a flow has no equation")
        _require_symbols(speeds.dag, roots, counts | {Kind.SPEED: len(speeds.values)})
    for positive in program.positive:
        _require(dag.level[positive.node] <= Level.PARAM, "a guarded divisor varies")


def _verify_lowered(lowered: Lowered) -> None:
    """Require single stores, a sorted Jacobian, pivots that permute the rows and columns."""
    program, jacobian, plan = lowered.program, lowered.jacobian, lowered.plan
    _verify_program(program, len(lowered.switches))
    states = len(program.states)
    size = states + jacobian.inner
    places = list(zip(jacobian.rows, jacobian.columns, strict=True))
    _require(places == sorted(set(places)), "entries of J are not sorted, or repeat")
    _require(all(max(place) < size for place in places), "an entry of J is outside")
    _require(len(jacobian.entries) == len(places), "J has another number of values than places")
    _require(len(jacobian.by_time) == states, "df/dt has another number of rows than f")
    slopes = list(jacobian.slopes)
    _require(slopes == sorted(set(slopes)), "the places of df/dx are not sorted, or repeat")
    _require(all(max(place) < states for place in slopes), "a place of df/dx is outside")
    for order in (plan.rows, plan.columns):
        _require(sorted(order) == list(range(size)), "pivots are not a permutation")
    for k, (left, right) in enumerate(zip(plan.lower, plan.upper, strict=True)):
        below = all(entry < k for entry in left) and all(entry > k for entry in right)
        _require(below, "an entry of the factors is on the wrong side of its pivot")
    if lowered.blocks is not None:
        _verify_blocks(lowered.blocks, plan)
    for node in lowered.hoisted:
        _require(program.dag.level[node] <= Level.PARAM, "a varying node is hoisted")
    for kernel in (*lowered.kernels, *lowered.range_kernels):
        _verify_kernel(kernel)
    kept = {tuple(store.node for store in kernel.left) for kernel in lowered.kernels}
    for kernel in lowered.kernels:
        there = not kernel.found or kernel.found in kept
        _require(there, f"`{kernel.name}` finds what no kernel leaves in w")


def _verify_blocks(blocks: BlockPlan, plan: LuPlan) -> None:
    """Require blocks of the plan's pivots, whose entries are on the right sides of them."""
    pivots = set(zip(blocks.rows, blocks.columns, strict=True))
    _require(pivots == set(zip(plan.rows, plan.columns, strict=True)), "blocks have other pivots")
    _require(sum(blocks.sizes) == len(plan.rows), "blocks hold another number of pivots")
    _require(all(0 < size <= 8 for size in blocks.sizes), "a block is empty, or too large")
    ends = accumulate(blocks.sizes)
    for t, (end, left, right) in enumerate(zip(ends, blocks.left, blocks.right, strict=True)):
        ordered = list(left) == sorted(set(left)) and list(right) == sorted(set(right))
        _require(ordered, "entries of a block are not sorted, or repeat")
        sides = all(s < t for s in left) and all(end <= k < len(plan.rows) for k in right)
        _require(sides, "an entry of a block is on the wrong side of it")


def _verify_kernel(kernel: Kernel) -> None:
    """Require that a kernel stores to its results only, and to each array element once."""
    arrays: dict[str, list[int]] = {}
    for store in kernel.stores:
        arrays.setdefault(store.array, []).append(store.index)
    own = {*kernel.results, SCRATCH}
    _require(set(arrays) <= own, f"`{kernel.name}` stores to another array")
    left = arrays.get(SCRATCH, [])
    _require(sorted(left) == list(range(len(left))), f"`{kernel.name}` leaves a gap in w")
    for array, indices in arrays.items():
        once = len(set(indices)) == len(indices)
        _require(once, f"`{kernel.name}` stores an element of `{array}` twice")


def _require_indices(result: FlatGraph | CausalGraph | Program) -> None:
    """Require that every index is one of the table that its type names."""
    for name, kind in INDICES.items():
        holder: Any = result if hasattr(result, name) else getattr(result, "graph", result)
        table = getattr(holder, name, ())
        for index in values_of(result, kind):
            _require(0 <= index < len(table), f"`{name}` has {len(table)} rows, none is {index}")


def _require_numbered(what: str, indices: Iterable[int]) -> None:
    for place, index in enumerate(indices):
        _require(index == place, f"{what} {place} has the index {index}")


def _require_shape(name: str, matrix: Matrix, rows: int, columns: int) -> None:
    fits = len(matrix) == rows and all(len(row) == columns for row in matrix)
    _require(fits, f"the matrix of `{name}` is not {rows} x {columns}")


def _require_symbols(dag: Dag, roots: Iterable[Node], counts: Mapping[Kind, int]) -> None:
    for node in dag.reachable(roots):
        symbol = dag.symbol_of(node)
        if symbol is not None:
            inside = 0 <= symbol.index < counts.get(symbol.kind, 0)
            _require(inside, f"{symbol.kind.name} {symbol.index} is not a symbol of this result")


def _require_parameters(dag: Dag, parameters: Iterable[Parameter]) -> None:
    for parameter in parameters:
        level = dag.level[parameter.value]
        _require(level <= Level.PARAM, f"the default of `{parameter.name}` varies")
