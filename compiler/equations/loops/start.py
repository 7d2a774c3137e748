"""Starting values of Newton's method for the unknowns of algebraic loops.

The model gives these unknowns no value, and at zero a law may be undefined (a logarithm) or have no
slope (flow through an orifice). The loops are therefore solved here once, with the parameters at
their defaults. A run starts from this solution and solves them again for its own parameters.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.newton import Rows
from bgc.ir.defaults import program_values, start_values
from bgc.ir.program import Program

_DIGITS = 6  # of a start value: enough, and the same on every machine


def algebraic_rows(program: Program) -> list[int]:
    """The indices of the empty rows of the mass matrix."""
    if program.mass is None:
        return []
    filled = {entry.row for entry in program.mass}
    return [k for k in range(len(program.states)) if k not in filled]


def with_start_values(program: Program, loops: Sequence[int]) -> Program:
    """The program with initial values for the states of loops, numbered `loops`.

    Where no solution is found they stay zero.
    """
    dag, rows = program.dag, algebraic_rows(program)
    if not loops:
        return program
    values = start_values(program, program_values(program))
    unknowns = [Symbol(Kind.STATE, k) for k in rows]
    equations = Rows(dag, [program.states[k].derivative for k in rows], unknowns)
    found = equations.solve(values, [values[u] for u in unknowns])
    if found is None:
        return program
    start = dict(zip(rows, found, strict=True))
    states = list(program.states)
    for k in loops:
        value = float(f"{start[k]:.{_DIGITS}g}")
        states[k] = replace(states[k], initial=dag.const(value))
    return replace(program, states=tuple(states))
