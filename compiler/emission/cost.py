"""What a program costs to run: its size, and the operations of its kernels."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from bgc.algebra.dag import Dag, Level, Op
from bgc.ir.graph import Node
from bgc.ir.lowered import Lowered


@dataclass(frozen=True, slots=True)
class Cost:
    """Sizes and operations. What depends on parameters alone is done once, and not counted.

    `rhs` and `jacobian` count the operations of f and of J with df/dt, `factorisation` those of
    one LU, `entries` the entries of its factors: a solution takes two operations for each.
    """

    states: int
    parameters: int
    rhs: int
    jacobian: int
    factorisation: int
    entries: int

    def operations(
        self, rhs: float, jacobians: float, factorisations: float, solutions: float
    ) -> float:
        """The operations of so many of each."""
        return (
            rhs * self.rhs
            + jacobians * self.jacobian
            + factorisations * self.factorisation
            + solutions * 2 * self.entries
        )


def cost_of(lowered: Lowered) -> Cost:
    """The cost of a lowered program."""
    program, jacobian, plan = lowered.program, lowered.jacobian, lowered.plan
    return Cost(
        states=len(program.states),
        parameters=len(program.parameters),
        rhs=_operations(program.dag, (state.derivative for state in program.states)),
        jacobian=_operations(program.dag, (*jacobian.entries, *jacobian.by_time)),
        factorisation=plan.operations,
        entries=plan.entries,
    )


def _operations(dag: Dag, roots: Iterable[Node]) -> int:
    op, level = dag.op, dag.level
    return sum(1 for n in dag.reachable(roots) if op[n] > Op.SYMBOL and level[n] > Level.PARAM)
