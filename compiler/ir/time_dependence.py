"""Whether a program moves of itself alone, or is moved by the time too."""

from __future__ import annotations

from bgc.algebra.dag import Kind
from bgc.ir.program import Program


def depends_on_time(program: Program) -> bool:
    """Whether the time itself stands in the rates, or in the powers that the scene observes."""
    dag = program.dag
    nodes = [state.derivative for state in program.states]
    if program.scene.accounts:
        nodes += [program.energy.supplied, program.energy.dissipated]
    symbols = map(dag.symbol_of, dag.reachable(nodes))
    return any(symbol is not None and symbol.kind is Kind.TIME for symbol in symbols)
