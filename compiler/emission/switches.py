"""Replace piecewise operations by modes, which the runtime holds constant over a step.

An integration method has its order only where the right-hand side is smooth. The result of every
comparison, `sign`, `floor`, `ceil` and `fmod`, and the piece of every `abs`, `min` and `max`, on
which the derivatives or energies depend and which states or time can change, therefore becomes an
input of the kernels (its mode), and the runtime ends a step where the mode would change. A mode of
NaN means that the operation itself is evaluated.

Left to error control are operations without a jump at whose threshold a root, power or logarithm
begins, as in `sign(x)*sqrt(abs(x))` or `if x > 0 then sqrt(x) else 0`: its slope is infinite there,
and no piece continues beyond. A step of a linearly implicit method that began there would stay
there. `==` is true at isolated instants only and causes no event.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from dataclasses import replace

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.algebra.discontinuities import at_threshold, is_segment, joins
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.operation import Jump
from bgc.algebra.operations import ROWS
from bgc.building.build_result import Place, Places
from bgc.ir.fields import map_nodes, nodes_of
from bgc.ir.graph import Node
from bgc.ir.lowered import Lowered, Switch
from bgc.ir.program import LoopSolution, Program

_JUMPS = {int(op): op.row.jump for op in Op if op.row.jump is not None}
_PASSING = frozenset(map(int, (Op.NOT, Op.MUL, Op.NEG, Op.DIV)))
_MOST_KINKS = 4  # in the argument of a switch, up to which it is looked at on each piece
_ROOTS = frozenset(map(int, (Op.SQRT, Op.CBRT, Op.POW, Op.LOG, Op.LOG10)))


def hold_modes(program: Program) -> tuple[Program, tuple[Switch, ...]]:
    """Replace the piecewise operations of a program by modes, those of time alone first.

    Initial values and projections are computed between steps and keep their operations. The given
    program is unchanged; the returned one has its own DAG.
    """
    if _JUMPS.keys().isdisjoint(program.dag.op):
        return program, ()
    integrated = [state.derivative for state in program.states]
    integrated += [program.energy.supplied, program.energy.dissipated]
    conditions = [jump.condition for jump in program.jumps]
    found = _piecewise(program.dag, [*integrated, *conditions])
    if not found:
        return program, ()
    dag = program.dag.copy()
    jumps = _jumps(dag, integrated, found)
    of_jumps = {n for n in dag.reachable(conditions) if n in found and not ROWS[dag.op[n]].kink}
    jumps |= dict.fromkeys(of_jumps, True)
    steep = _steep(dag, integrated, [node for node in found if not jumps[node]])
    order = sorted(found.keys() - steep, key=lambda node: (not found[node], node))
    number = {node: k for k, node in enumerate(order)}
    program, arguments = _with_modes(replace(program, dag=dag), number)
    return program, tuple(
        Switch(
            operation=_JUMPS[dag.op[node]],
            argument=arguments[node],
            timed=found[node],
            jumps=jumps[node],
            place=dag.places.get(node),
            owner=dag.owners.get(node, ""),
            states=_states_in(program, arguments[node]),
            of_jump=node in of_jumps,
        )
        for node in order
    )


def few_states_read(program: Program, nodes: Iterable[Node]) -> tuple[int, ...]:
    """The states that nodes read, if interpolating only them along a step is worthwhile.

    Empty where these are more than half of the states, or where one of them is set by a projection
    or an algebraic equation, which need all states.
    """
    read = sorted({s.index for s in program.dag.symbols_in(nodes, Kind.STATE).values()})
    states = [program.states[index] for index in read]
    alone = all(s.projection is None and s.kind != "algebraic" for s in states)
    return tuple(read) if alone and 2 * len(read) <= len(program.states) else ()


def places_of(lowered: Lowered) -> Places:
    """The source locations that run-time messages refer to."""
    return Places(
        assertions=tuple(Place(guard.span) for guard in lowered.program.guards),
        switches=tuple(Place(switch.place, switch.states) for switch in lowered.switches),
        divisors=tuple(
            Place(divisor.span, _states_in(lowered.program, divisor.node))
            for divisor in lowered.program.divisors
        ),
        start=lowered.program.start.names if lowered.program.start else (),
        loops=tuple(
            (loop.torn, loop.elements)
            for loop in lowered.program.loops
            if loop.solution is LoopSolution.NEWTON
        ),
        jumps=tuple(Place(jump.span) for jump in lowered.program.jumps),
        held=tuple(Place(held.span, (held.name,)) for held in lowered.program.held),
        given=tuple(
            Place(given.span, (given.variable, given.name)) for given in lowered.program.given
        ),
        checks=tuple(Place(check.symmetric) for check in lowered.program.positive),
        parameters=_parameter_places(lowered.program),
    )


def _parameter_places(program: Program) -> tuple[Place, ...]:
    """The place that gives each parameter with a range its value; an empty place for others."""
    dag, parameters = program.dag, program.parameters
    places = [Place(None)] * len(parameters)
    waiting = [p.index for p in parameters if p.low is not None]
    while waiting:
        index = waiting.pop()
        if places[index].span is not None:
            continue
        symbols = dag.symbols_in([parameters[index].value], Kind.PARAM).values()
        read = sorted({symbol.index for symbol in symbols})
        places[index] = Place(parameters[index].span, tuple(parameters[k].name for k in read))
        waiting += read
    return tuple(places)


def _states_in(program: Program, node: Node) -> tuple[str, ...]:
    """Names of the states on which a node depends, in the order of the program."""
    dag = program.dag
    indices = {symbol.index for symbol in dag.symbols_in([node], Kind.STATE).values()}
    return tuple(program.states[index].name for index in sorted(indices))


def _piecewise(dag: Dag, roots: Iterable[Node]) -> dict[Node, bool]:
    """Find the operations that may change during a step.

    Maps each to True if its argument depends on time but not on states.
    """
    changed_by: dict[Node, Kind] = {}  # STATE where a node depends on both
    found: dict[Node, bool] = {}
    for node in dag.reachable(roots, Level.TIME):
        symbol = dag.symbol_of(node)
        if symbol is not None:
            if symbol.kind in {Kind.STATE, Kind.TIME}:
                changed_by[node] = symbol.kind
            continue
        kinds = {changed_by[x] for x in dag.operands(node) if x in changed_by}
        if kinds:
            changed_by[node] = Kind.STATE if Kind.STATE in kinds else Kind.TIME
            if dag.op[node] in _JUMPS:
                found[node] = changed_by[node] is Kind.TIME
    return found


def _with_modes(program: Program, number: Mapping[Node, int]) -> tuple[Program, dict[Node, Node]]:
    """Replace the results of the numbered operations by modes, on the program's own DAG.

    Also returns the argument of each operation, which may itself contain modes.
    """
    dag = program.dag
    bare = replace(program, states=())
    roots = [*nodes_of(bare), *(state.derivative for state in program.states)]
    new: dict[Node, Node] = {}
    arguments: dict[Node, Node] = {}
    fingerprints = Fingerprints(dag)
    kinks: dict[Node, Node] = {}
    for node in dag.reachable(roots, Level.TIME):
        operands = tuple(new.get(x, x) for x in dag.operands(node))
        made = node if operands == dag.operands(node) else dag.rebuild(node, operands)
        new[node] = made
        if node in number:
            mode = dag.symbol(Kind.INPUT, program.inputs + number[node])
            pieces = ROWS[dag.op[node]].pieces
            assert pieces is not None
            argument, result = pieces(dag, mode, *operands)
            new[node] = _in_mode(dag, mode, result, made)
            arguments[node] = _zero_on_pieces(dag, fingerprints, argument, kinks)
            if ROWS[dag.op[node]].kink:
                kinks[mode] = _in_mode(dag, mode, mode, dag.call(Op.LE, dag.zero, argument))
    states = (
        replace(state, derivative=new.get(state.derivative, state.derivative))
        for state in program.states
    )
    return replace(map_nodes(bare, dag, lambda n: new.get(n, n)), states=tuple(states)), arguments


def _in_mode(dag: Dag, mode: Node, held: Node, released: Node) -> Node:
    """One node while a mode is held, and another while the operation itself is evaluated."""
    return dag.select(dag.call(Op.EQ, mode, mode), held, released)


def _zero_on_pieces(
    dag: Dag, fingerprints: Fingerprints, argument: Node, kinks: Mapping[Node, Node]
) -> Node:
    """An argument, as a literal 0 on the pieces of kinks on which it is 0 identically.

    `0.1*abs(v) + 0.2*abs(v) > 0.3*v` compares equal values where v > 0; rounding would decide.
    `kinks` maps the mode of each kink to whether it is on its first piece, held or released.
    """
    modes = [n for n in dag.reachable([argument], Level.TIME) if n in kinks] if kinks else []
    if len(modes) > _MOST_KINKS:
        return argument
    for mode in modes:
        first, second = (
            dag.zero
            if fingerprints.is_zero(*dag.substitute([argument], {mode: piece}))
            else argument
            for piece in (dag.one, dag.zero)
        )
        if first != second:
            argument = dag.select(kinks[mode], first, second)
    return argument


# --- jumps --------------------------------------------------------------------------------------


def _jumps(dag: Dag, roots: Iterable[Node], found: Iterable[Node]) -> dict[Node, bool]:
    """Find where the roots may jump: True for operations not proven continuous at a change."""
    roots = set(roots)
    sudden = [node for node in found if not ROWS[dag.op[node]].kink]
    readers: dict[Node, list[Node]] = {node: [] for node in sudden}
    for node in dag.reachable(roots, Level.TIME):  # operands come first
        passing = dag.op[node] in _PASSING
        for operand in set(dag.operands(node)):
            if operand in readers:
                readers[operand].append(node)
                if passing:
                    readers[node] = []
    fingerprints = Fingerprints(dag)
    jumps = dict.fromkeys(found, False)
    jumps |= {
        node: node in roots
        or not any(
            _are_continuous(dag, fingerprints, node, readers, threshold, roots)
            for threshold in _thresholds(dag, node)
        )
        for node in sudden
    }
    return jumps


def _steep(dag: Dag, roots: Iterable[Node], continuous: Iterable[Node]) -> set[Node]:
    """The continuous operations at whose threshold a root, power or logarithm begins.

    Of comparisons, `max` and `min` only those at an infinite slope: where the slope is finite, as
    of a power of 1.5, their pieces end well.
    """
    kinks = [node for node in continuous if ROWS[dag.op[node]].pieces is not None]
    if not kinks:
        return set()
    found = [node for node in dag.reachable(roots, Level.TIME) if dag.op[node] in _ROOTS]
    begins = {node: frozenset(dag.reachable([dag.a[node]])) for node in found}
    fingerprints = Fingerprints(dag)

    def begins_at(root: Node, threshold: Mapping[Node, Node]) -> bool:
        if begins[root].isdisjoint(threshold):
            return False
        return fingerprints.is_zero(*at_threshold(dag, [dag.a[root]], threshold))

    return {
        node
        for node in kinks
        for threshold in _thresholds(dag, node)
        if any(
            begins_at(root, threshold)
            for root in found
            if dag.op[node] in (Op.ABS, Op.SIGN) or _has_infinite_slope(dag, root)
        )
    }


def _has_infinite_slope(dag: Dag, root: Node) -> bool:
    """Return whether the slope of a root, power or logarithm may be infinite at argument 0."""
    exponent = dag.value(dag.b[root]) if dag.op[root] == Op.POW else None
    return exponent is None or exponent < 1


def _thresholds(dag: Dag, node: Node) -> list[dict[Node, Node]]:
    """Substitutions for the points at which an operation changes its result."""
    a, b = dag.a[node], dag.b[node]
    match _JUMPS[dag.op[node]]:
        case Jump.ABOVE | Jump.NOT_BELOW if b >= 0:
            pairs = [(x, y) for x, y in ((a, b), (b, a)) if dag.level[x] > Level.PARAM]
            return [{x if y != dag.zero else _unscaled(dag, x): y} for x, y in pairs]
        case Jump.ABOVE | Jump.NOT_BELOW | Jump.SIGN:
            return [{_unscaled(dag, a): dag.zero}]
        case Jump.FLOOR if is_segment(dag, node):
            return [{}]  # the readers decide
        case Jump.FLOOR | Jump.CEIL | Jump.TRUNC:
            return []


def _unscaled(dag: Dag, node: Node) -> Node:
    """A node without a sign and factors that do not vary; both vanish together."""
    while True:
        a, b = dag.a[node], dag.b[node]
        match dag.op[node]:
            case Op.NEG:
                node = a
            case Op.MUL if dag.level[a] <= Level.PARAM < dag.level[b]:
                node = b
            case Op.MUL | Op.DIV if dag.level[b] <= Level.PARAM < dag.level[a]:
                node = a
            case _:
                return node


def _are_continuous(
    dag: Dag,
    fingerprints: Fingerprints,
    node: Node,
    readers: Mapping[Node, list[Node]],
    threshold: Mapping[Node, Node],
    roots: Collection[Node],
    *,
    signed: bool | None = None,
) -> bool:
    """Return whether all readers of an operation's result are continuous at its threshold.

    A multiple of a sign, `0.7*sign(x)` or `-sign(x)/b`, jumps as the sign does; what reads it is
    judged in its place.
    """
    if is_segment(dag, node):
        return all(joins(dag, node, reader) for reader in readers[node])
    if signed is None:
        signed = dag.op[node] == Op.SIGN
    for reader in readers[node]:
        a, b, c = dag.a[reader], dag.b[reader], dag.c[reader]
        match dag.op[reader]:
            case Op.NOT:
                passes = True
            case Op.SELECT if node not in (b, c):
                if not fingerprints.equal(*at_threshold(dag, (b, c), threshold)):
                    return False
                continue
            case Op.MUL if signed and a != b:
                (other,) = at_threshold(dag, [b if a == node else a], threshold)
                passes = not fingerprints.is_zero(other)
            case Op.NEG if signed:
                passes = True
            case Op.DIV if signed and b != node:
                passes = True
            case _:
                return False
        if passes and (
            reader in roots
            or not _are_continuous(
                dag, fingerprints, reader, readers, threshold, roots, signed=signed
            )
        ):
            return False
    return True
