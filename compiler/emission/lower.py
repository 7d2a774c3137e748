"""Lower a program to the contents of its C functions."""

from __future__ import annotations

from dataclasses import replace

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.algebra.linalg import spelled_out
from bgc.emission.factorisation import choose_blocks
from bgc.emission.inverses import with_inverses
from bgc.emission.kernels import hoisted_nodes
from bgc.emission.least_cost import planned
from bgc.emission.program_kernels import (
    program_kernels,
    range_kernel,
    stores,
    timed_range_kernel,
    watch_kernels,
)
from bgc.emission.sparse import entries_of_matrix
from bgc.emission.switches import hold_modes
from bgc.emission.watches import find_watches
from bgc.ir.graph import Node
from bgc.ir.lowered import Kernel, Lowered, Reads
from bgc.ir.program import Closures, Program


def lower(program: Program) -> Lowered:
    """Differentiate an optimised program, plan its linear algebra and list its kernels.

    The result has its own program on its own DAG, to which all its nodes belong.
    """
    program, switches, jacobian, timed, plan = planned(*hold_modes(program))
    program = replace(program, closures=_moving(program.dag, program.closures))
    watches = find_watches(program)
    kernels = (*program_kernels(program, switches, jacobian), *watch_kernels(watches))
    ranges, timed_ranges = range_kernel(timed), timed_range_kernel(switches)
    watching = [kernel for kernel in (ranges, timed_ranges) if kernel is not None]
    for kernel in (*kernels, *watching):
        _verify(program.dag, kernel)
    hoisted = with_inverses(program.dag, hoisted_nodes(program.dag, (*kernels, *watching)))
    prepare = Kernel(
        "prepare",
        "Everything that depends on parameters alone.",
        ("p",),
        ("h",),
        Reads.PARAMETERS,
        stores("h", hoisted),
    )
    return Lowered(
        program=program,
        switches=switches,
        jacobian=jacobian,
        plan=plan,
        hoisted=hoisted,
        kernels=(prepare, *kernels),
        watches=watches,
        ranges=ranges,
        timed_ranges=timed_ranges,
        blocks=choose_blocks(plan, entries_of_matrix(program, jacobian)),
    )


def _moving(dag: Dag, closures: Closures | None) -> Closures | None:
    """Closed chains without those that stand still, on which slicing left nothing to act."""
    if closures is None:
        return None
    kept = [k for k, row in enumerate(closures.by_impulse) if any(x != dag.zero for x in row)]
    others = [k for k in range(len(closures.flows)) if k >= closures.kept or k not in kept]
    moving = replace(
        closures,
        chain_of=tuple(closures.chain_of[k] for k in kept),
        flows=tuple(closures.flows[k] for k in (*kept, *others)),
        kept=len(kept),
        selectors=tuple(closures.selectors[k] for k in kept),
        by_impulse=tuple(closures.by_impulse[k] for k in kept),
        response=tuple(tuple(row[k] for k in kept) for row in closures.response),
    )
    return moving if moving.kept or moving.moved else None


def _verify(dag: Dag, kernel: Kernel) -> None:
    """Assert that a kernel's nodes depend on its arguments only."""
    arguments = {*kernel.inputs, *(kernel.results if kernel.in_place else ())}
    if "s" in kernel.inputs:
        held = {
            s.kind for s in map(dag.symbol_of, dag.reachable(s.node for s in kernel.stores)) if s
        }
        assert Kind.STATE not in held, f"{kernel.name} reads states"
    elif "x" not in arguments:
        highest = Level.TIME if "t" in arguments else Level.PARAM
        for store in kernel.stores:
            assert dag.level[store.node] <= highest, f"{kernel.name} reads what it is not given"
    elif "u" not in arguments:
        symbols = (dag.symbol_of(n) for n in dag.reachable(s.node for s in kernel.stores))
        inputs = [s for s in symbols if s is not None and s.kind is Kind.INPUT]
        assert not inputs, f"{kernel.name} reads device inputs"


def dependent_defaults(program: Program) -> list[tuple[int, Node]]:
    """The index and default of each parameter whose default depends on others."""
    dag = program.dag
    found = [p for p in program.parameters if _has_symbols(dag, p.value)]
    values = spelled_out(dag, [parameter.value for parameter in found])
    return [(p.index, value) for p, value in zip(found, values, strict=True)]


def _has_symbols(dag: Dag, node: Node) -> bool:
    return any(dag.op[n] == Op.SYMBOL for n in dag.reachable([node]))
