"""Accelerations of a compiled scene at any state: what it observes, and the rates of that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from bgc.algebra.dag import Kind
from bgc.algebra.derivatives import directional_derivative
from bgc.building.build_result import run_facts
from bgc.building.cache import open_cache
from bgc.driver import build_model, compile_scene
from bgc.emission.emit import emit_model
from bgc.emission.simplification import optimise
from bgc.ir.program import Program
from bgc.options import Options
from bgc.runtime.model import Model

Array = npt.NDArray[np.float64]
Values = Mapping[str, float]
MODELS = Path(__file__).parents[1] / "models"


def with_rates(program: Program) -> Program:
    """The program that also observes `x'` for each observed x, its derivative along the flow,
    and as `stored` the energy stored (where the scene observes that).

    Its states stand still: what they would do is in the rates, and the C stays small.
    """
    assert program.mass is None, "states without rates of their own have no accelerations"
    dag = program.dag
    flow = {dag.symbol(Kind.STATE, k): state.derivative for k, state in enumerate(program.states)}
    rates = tuple(
        replace(o, name=f"{o.name}'", node=directional_derivative(dag, o.node, flow))
        for o in program.observations
    )
    stored = replace(rates[0], name="stored", unit="J", node=program.energy.stored)
    return optimise(
        replace(
            program,
            states=tuple(replace(state, derivative=dag.zero) for state in program.states),
            observations=(*program.observations, *rates, stored),
        )
    )


class Probe:
    """A scene whose `velocities` (observed columns) are linear in its momenta, as many as those.

    Parameters
    ----------
    file, scene
        A scene of a file.
    velocities
        Names of the observed columns.
    """

    def __init__(self, file: Path, scene: str, velocities: Sequence[str]) -> None:
        stages = compile_scene(file, Options(scene, whole=True), until="optimise")
        program = with_rates(stages.optimised)
        emitted = emit_model(program, f"rates of {scene}")
        columns = tuple(o.name for o in program.observations)
        facts = replace(run_facts(replace(program.scene, columns=columns)), accounts=())
        self.model = Model(build_model(emitted, facts, Options(), (), open_cache()))
        self.velocities = tuple(velocities)
        self.states = tuple(state.name for state in program.states)
        self._momenta = [k for k, s in enumerate(program.states) if s.kind == "momentum"]
        assert len(self._momenta) == len(self.velocities)

    def mobility(self, state: Array, parameters: Values | None = None) -> Array:
        """The matrix W of `v = W p`, velocities from momenta, at the state's configuration."""
        units = self._with_momenta(state, np.eye(len(self._momenta)))
        return np.array([self.observed(unit, parameters) for unit in units]).T

    def mass_matrix(self, state: Array, parameters: Values | None = None) -> Array:
        """M of the kinetic energy `v' M v / 2`, at the state's configuration.

        Momenta are conjugate to flows that need not be the velocities. So the energy of unit
        momenta and of their sums is taken: `p' H p / 2`, and `M = W^-T H W^-1`.
        """
        size = len(self._momenta)
        pairs = np.eye(size)[:, None] + np.eye(size)
        energies = np.array(
            [
                self.model.observe(at, parameters=parameters)["stored"]
                for at in self._with_momenta(state, pairs.reshape(-1, size))
            ]
        ).reshape(size, size)
        alone = np.diag(energies) / 4
        hessian = energies - alone - alone[:, None]
        inverse = np.linalg.inv(self.mobility(state, parameters))
        return inverse.T @ hessian @ inverse

    def _with_momenta(self, state: Array, momenta: Array) -> Array:
        """The state with each row of momenta."""
        states = np.tile(state, (len(momenta), 1))
        states[:, self._momenta] = momenta
        return states

    def at(self, declared: Values, velocities: Array, parameters: Values | None = None) -> Array:
        """The state with these values of declared states (else the initial ones) and velocities."""
        state = self.model.initial_state()
        for name, value in declared.items():
            state[self.states.index(name)] = value
        state[self._momenta] = np.linalg.solve(self.mobility(state, parameters), velocities)
        return state

    def observed(self, state: Array, parameters: Values | None = None) -> Array:
        """The velocities."""
        values = self.model.observe(state, parameters=parameters)
        return np.array([values[name] for name in self.velocities])

    def vector(self, state: Array, name: str) -> Array:
        """An observed vector."""
        values = self.model.observe(state)
        return np.array(
            [x for column, x in values.items() if column.rstrip("]0123456789") == f"{name}["]
        )

    def accelerations(self, state: Array, parameters: Values | None = None) -> Array:
        """Their rates."""
        values = self.model.observe(state, parameters=parameters)
        return np.array([values[f"{name}'"] for name in self.velocities])


@cache
def probe(name: str, scene: str, *velocities: str) -> Probe:
    """A scene of tests/models/NAME.bg, compiled once for all tests."""
    return Probe(MODELS / f"{name}.bg", scene, velocities)
