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
from bgc.building.build import build_shared_object
from bgc.building.built import Built, run_facts
from bgc.building.cache import open_cache
from bgc.building.toolchain import find_toolchain
from bgc.driver import Compilation
from bgc.emission.emit import emit_model
from bgc.emission.optimise import optimise
from bgc.options import Options
from bgc.program import Program
from bgc.runtime.model import Model

Array = npt.NDArray[np.float64]
Values = Mapping[str, float]
MODELS = Path(__file__).parents[1] / "models"


def with_rates(program: Program) -> Program:
    """The program that also observes `x'` for each observed x: its derivative along the flow."""
    assert program.mass is None, "states without rates of their own have no accelerations"
    dag = program.dag
    flow = {dag.symbol(Kind.STATE, k): state.derivative for k, state in enumerate(program.states)}
    rates = tuple(
        replace(o, name=f"{o.name}'", node=directional_derivative(dag, o.node, flow))
        for o in program.observations
    )
    return optimise(replace(program, observations=(*program.observations, *rates)))


class Probe:
    """A scene whose `velocities` (observed columns) are linear in its momenta, as many as those.

    Parameters
    ----------
    name, scene
        A scene of tests/models/NAME.bg.
    velocities
        Names of the observed columns.
    """

    def __init__(self, name: str, scene: str, velocities: Sequence[str]) -> None:
        compilation = Compilation(MODELS / f"{name}.bg", Options(scene))
        program = with_rates(compilation.optimised)
        units = emit_model(program, f"rates of {name} {scene}").units
        library = build_shared_object(units, find_toolchain(), open_cache())
        self.model = Model(Built(library, run_facts(program.scene)))
        self.velocities = tuple(velocities)
        self.states = tuple(state.name for state in program.states)
        self._momenta = [k for k, s in enumerate(program.states) if s.kind == "momentum"]
        assert len(self._momenta) == len(self.velocities)

    def mobility(self, state: Array, parameters: Values | None = None) -> Array:
        """The matrix W of `v = W p`, velocities from momenta, at the state's configuration."""
        columns = []
        for k in self._momenta:
            unit = state.copy()
            unit[self._momenta] = 0
            unit[k] = 1
            columns.append(self.observed(unit, parameters))
        return np.array(columns).T

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

    def accelerations(self, state: Array, parameters: Values | None = None) -> Array:
        """Their rates."""
        values = self.model.observe(state, parameters=parameters)
        return np.array([values[f"{name}'"] for name in self.velocities])


@cache
def probe(name: str, scene: str, *velocities: str) -> Probe:
    """One compilation for all tests."""
    return Probe(name, scene, velocities)
