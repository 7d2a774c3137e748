"""Scales of states are those of unit flow: where nothing moves near that, they are too coarse.

Held against the closed form of a series circuit that is switched on.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

import bgc

Array = npt.NDArray[np.float64]

R, L, SUPPLY = 2.0, 1e-3, 5.0
CIRCUIT = f"""
model Circuit {{
  param C = 10 uF;
  param E = {SUPPLY} V;
  supply : Se(e = E);
  loop : J1;
  coil : I({L} H);
  capacitor : C(C);
  resistor : R({R} ohm);
  supply -> loop;
  loop -> coil, capacitor, resistor;
}}
scene switched_on of Circuit {{
  observe capacitor.e;
  run 100 us;
}}
"""


@pytest.fixture(scope="module")
def circuit(tmp_path_factory: pytest.TempPathFactory) -> bgc.Model:
    """The circuit, compiled."""
    path: Path = tmp_path_factory.mktemp("faint") / "circuit.bg"
    path.write_text(CIRCUIT)
    return bgc.compile(path)


def voltage(time: Array, capacity: float) -> Array:
    """Voltage of the capacitor, V, from the differential equation of the circuit."""
    decay = R / (2.0 * L)
    rate = np.sqrt(1.0 / (L * capacity) - decay**2)
    swing = np.cos(rate * time) + decay / rate * np.sin(rate * time)
    return np.asarray(SUPPLY * (1.0 - np.exp(-decay * time) * swing))


@pytest.mark.parametrize("solver", ["rodas5p", "dopri5", "radau5"])
@pytest.mark.parametrize("capacity", [1e-6, 1e-9, 1e-11])
def test_currents_of_microamperes_are_as_accurate_as_those_of_amperes(
    circuit: bgc.Model, capacity: float, solver: str
) -> None:
    # Errors grow with the oscillations: about 160 of them at 10 pF.
    result = circuit.simulate(solver=solver, rtol=1e-7, parameters={"C": capacity})
    assert np.abs(result["capacitor.e"] - voltage(result.time, capacity)).max() < 2e-3


def test_so_they_are_in_vector_registers(circuit: bgc.Model) -> None:
    capacities = [1e-6, 1e-8, 1e-9, 1e-10, 1e-11]
    many = circuit.simulate_many({"C": capacities}, rtol=1e-7)
    for k, capacity in enumerate(capacities):
        expected = voltage(many.time, capacity)
        assert np.abs(many["capacitor.e"][k] - expected).max() < 2e-3


def test_a_model_at_rest_takes_no_more_steps_for_that(circuit: bgc.Model) -> None:
    still = circuit.simulate(parameters={"C": 1e-11, "E": 0.0})
    assert np.array_equal(still["capacitor.e"], np.zeros_like(still.time))
    assert still.counts["steps"] < 50
