"""Test if a program depends explicitly on time."""

from __future__ import annotations

from bgc.algebra.dag import Kind
from bgc.ir.program import Program


def depends_on_time(program: Program) -> bool:
    """Return whether the rates, or the powers of observed accounts, depend explicitly on time."""
    dag = program.dag
    nodes = [state.derivative for state in program.states]
    if program.scene.accounts:
        nodes += [program.energy.supplied, program.energy.dissipated]
    return bool(dag.symbols_in(nodes, Kind.TIME))
