"""List the nodes of a program, and map them to others.

Only this module lists the fields of a `Program` that contain nodes, so that a pass over the DAG is
a function from nodes to nodes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from bgc.algebra.dag import Dag, Level, Op
from bgc.ir.graph import Matrix, Node
from bgc.ir.graph_nodes import map_held, map_rates
from bgc.ir.program import Closures, Divisor, Program


def program_roots(program: Program) -> list[Node]:
    """All nodes of a program, in a fixed order, possibly repeated."""
    roots: list[Node] = []

    def note(node: Node) -> Node:
        roots.append(node)
        return node

    map_program(program, program.dag, note)
    return roots


def without_unused_divisors(program: Program) -> Program:
    """Remove the divisors that are in no other node of the program, or no longer vary.

    The quotient by a divisor may divide by a part of it: `a / -b` is `-(a / b)`. Then that part
    takes its place.
    """
    if not program.divisors:
        return program
    dag = program.dag
    used = set(dag.reachable(program_roots(replace(program, divisors=()))))
    below = {dag.b[node] for node in used if dag.op[node] == Op.DIV}
    left: dict[Node, Divisor] = {}
    for divisor in program.divisors:
        present = divisor.node in used
        for node in [divisor.node] if present else _factors_below(dag, divisor.node):
            if dag.level[node] > Level.PARAM and (present or node in below):
                left.setdefault(node, replace(divisor, node=node))
    return replace(program, divisors=tuple(left.values()))


def _factors_below(dag: Dag, node: Node) -> list[Node]:
    """The divisors of the factors of `1 / node`."""
    found: list[Node] = []
    stack = [dag.div(dag.one, node)]
    while stack:
        top = stack.pop()
        if dag.op[top] == Op.DIV:
            found.append(dag.b[top])
            stack.append(dag.a[top])
        elif dag.op[top] in (Op.NEG, Op.MUL):
            stack.extend(dag.operands(top))
    return found


def without_settled_jumps(program: Program) -> Program:
    """Remove the jumps whose conditions no longer vary: they never become true."""
    if not program.jumps:
        return program
    level = program.dag.level
    left = (jump for jump in program.jumps if level[jump.condition] > Level.PARAM)
    return replace(program, jumps=tuple(left))


def map_program(program: Program, dag: Dag, new: Callable[[Node], Node]) -> Program:
    """Replace every node `n` of a program by `new(n)`, a node of `dag`."""

    def optional(node: Node | None) -> Node | None:
        return None if node is None else new(node)

    mass, start = program.mass, program.start
    energy = program.energy
    return replace(
        program,
        dag=dag,
        states=tuple(
            replace(
                state,
                derivative=new(state.derivative),
                initial=new(state.initial),
                projection=optional(state.projection),
                scale=new(state.scale),
            )
            for state in program.states
        ),
        mass=None if mass is None else tuple(replace(m, value=new(m.value)) for m in mass),
        observations=tuple(replace(o, node=new(o.node)) for o in program.observations),
        requirements=tuple(replace(r, node=new(r.node)) for r in program.requirements),
        devices=tuple(replace(d, values=tuple(new(v) for v in d.values)) for d in program.devices),
        guards=tuple(replace(g, condition=new(g.condition)) for g in program.guards),
        energy=replace(
            energy,
            stored=new(energy.stored),
            supplied=new(energy.supplied),
            dissipated=new(energy.dissipated),
        ),
        positive=tuple(replace(p, node=new(p.node)) for p in program.positive),
        divisors=tuple(replace(d, node=new(d.node)) for d in program.divisors),
        parameters=tuple(replace(p, value=new(p.value)) for p in program.parameters),
        start=None
        if start is None
        else replace(
            start,
            residuals=tuple(map(new, start.residuals)),
            values=tuple((number, new(node)) for number, node in start.values),
        ),
        closures=None if program.closures is None else _closures(program.closures, new),
        held=map_held(program.held, new),
        rates=map_rates(program.rates, new),
        jumps=tuple(
            replace(
                jump,
                condition=new(jump.condition),
                resets=tuple(replace(r, value=new(r.value)) for r in jump.resets),
            )
            for jump in program.jumps
        ),
    )


def _closures(closures: Closures, new: Callable[[Node], Node]) -> Closures:
    def matrix(rows: Matrix) -> Matrix:
        return tuple(tuple(map(new, row)) for row in rows)

    return replace(
        closures,
        flows=tuple(map(new, closures.flows)),
        conditions=tuple(map(new, closures.conditions)),
        starts=tuple(map(new, closures.starts)),
        by_impulse=matrix(closures.by_impulse),
        response=matrix(closures.response),
        by_place=matrix(closures.by_place),
        by_start=matrix(closures.by_start),
    )
