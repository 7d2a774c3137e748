"""The cost of a program: its size, and the operations of its kernels."""

from __future__ import annotations

from bgc.emission.factorisation import describe_factors
from bgc.ir.lowered import Lowered
from bgc.record_class import dataclass


@dataclass(frozen=True, slots=True)
class Cost:
    """The size of a program, and the operations of one evaluation of its parts.

    `rhs` counts the operations of f, `jacobian` those of J and df/dt, `factorisation` those of one
    LU factorisation; `entries` are the entries of its factors, with two operations each per
    solution; `factors` says how the matrix is factorised. Expressions of parameters are computed
    once per run and not counted.
    """

    states: int
    parameters: int
    rhs: int
    jacobian: int
    factorisation: int
    entries: int
    factors: str

    def operations(
        self, rhs: float, jacobians: float, factorisations: float, solutions: float
    ) -> float:
        """The operations of the given numbers of evaluations, factorisations and solutions."""
        return (
            rhs * self.rhs
            + jacobians * self.jacobian
            + factorisations * self.factorisation
            + solutions * 2 * self.entries
        )


def cost_of(lowered: Lowered) -> Cost:
    """The cost of a lowered program."""
    program, jacobian, plan = lowered.program, lowered.jacobian, lowered.plan
    dag = program.dag
    return Cost(
        states=len(program.states),
        parameters=len(program.parameters),
        rhs=len(dag.repeated(state.derivative for state in program.states)),
        jacobian=len(dag.repeated((*jacobian.entries, *jacobian.by_time))),
        factorisation=plan.operations,
        entries=plan.entries,
        factors=describe_factors(lowered),
    )
