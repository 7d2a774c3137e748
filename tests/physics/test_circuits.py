"""Electric parts of the library against answers in closed form, or by SciPy from the equations."""

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq


@pytest.fixture(scope="module")
def transients(load):
    return load("circuits", "transients").simulate()


def test_a_capacitor_charges_behind_a_battery(transients):
    voltage = 10 - 8 * np.exp(-transients.time / 10e-3)
    np.testing.assert_allclose(transients["charged.voltage"], voltage, rtol=1e-8)
    charge = 1e-3 * (voltage - 2)
    np.testing.assert_allclose(transients["battery.charge"], charge, atol=1e-11)


def test_a_struck_circuit_rings(transients):
    t, decay = transients.time, 2 / (2 * 10e-3)
    beat = np.sqrt(1 / (10e-3 * 100e-6) - decay**2)
    envelope = np.exp(-decay * t)
    voltage = 1 - envelope * (np.cos(beat * t) + decay / beat * np.sin(beat * t))
    np.testing.assert_allclose(transients["ringing"], voltage, atol=1e-7)
    current = envelope * np.sin(beat * t) / (beat * 10e-3)
    np.testing.assert_allclose(transients["coil.current"], current, atol=1e-8)


def test_a_transformer_steps_the_voltage_up(transients):
    np.testing.assert_allclose(transients["burden.voltage"], 3 / 4 * 5, rtol=1e-12)
    np.testing.assert_allclose(transients["primary"], 3 * 5 / 4**2, rtol=1e-12)


def test_coupled_coils_share_their_flux(transients):
    """Flux p of both coils: p1' = 5 - i1, p2' = -0.5 i2, i = L^-1 p."""
    mutual = 0.8 * np.sqrt(20e-3 * 5e-3)
    inductance = np.array([[20e-3, mutual], [mutual, 5e-3]])
    rates = np.zeros((3, 3))
    rates[:2, :2] = -np.diag([1, 0.5]) @ np.linalg.inv(inductance)
    rates[0, 2] = 5
    fluxes = [expm(t * rates)[:2, 2] for t in transients.time]
    currents = [np.linalg.solve(inductance, flux) for flux in fluxes]
    first, second = np.transpose(currents)
    np.testing.assert_allclose(transients["coils.current1"], first, atol=1e-7)
    np.testing.assert_allclose(transients["coils.current2"], second, atol=1e-7)


def test_a_diode_rectifies_a_switch_opens_an_amplifier_inverts(load):
    result = load("circuits", "switched").simulate()
    mains = 10 * np.sin(2 * np.pi * 50 * result.time)

    def drop(voltage):
        """Shockley's law in series with the resistor."""

        def excess(u):
            return 1e-9 * np.expm1(min(u / 45e-3, 40)) + u / 1e8 - (voltage - u) / 100

        return brentq(excess, min(voltage, 0) - 1, 1.5, xtol=1e-13)

    expected = [drop(voltage) for voltage in mains]
    np.testing.assert_allclose(result["drop"], expected, atol=1e-6)
    np.testing.assert_allclose(result["rectified"], mains - expected, atol=1e-6)
    conducting = (mains - 0.7 * (1 - 1e-6)) / (99 + 1)
    ideal = np.where(mains > 0.7 + 99 * 0.7e-6, conducting, mains / (99 + 1e6))
    np.testing.assert_allclose(result["ideal"], ideal, atol=1e-9)
    closed = result.time < 7e-3 - 1e-9
    np.testing.assert_allclose(
        result["lit"], np.where(closed, mains / (1 + 1e-6), mains * 1e-5), atol=1e-4
    )
    np.testing.assert_allclose(result["amplified"], -mains, atol=2e-3)


def test_a_machine_lifts_a_load(load):
    """Steady: the armature's equation with the torque of the weight, through a gear with losses."""
    result = load("circuits", "lift").simulate()
    torque = 5 * 9.81 * 0.1 / 20 / 0.8  # at the machine
    rate = (24 - 0.6 * torque / 0.05) / (0.05 + 0.6 * 2e-5 / 0.05)
    np.testing.assert_allclose(result["machine.rate"][-1], rate, rtol=1e-6)
    np.testing.assert_allclose(result["load.velocity"][-1], rate / 20 * 0.1, rtol=1e-6)
    assert np.abs(result["energy.residual"]).max() < 1e-6


def test_a_shorted_machine_brakes_a_load_that_sinks(load):
    """The load drives: the machine receives 0.8 of the power."""
    result = load("circuits", "lowering").simulate()
    torque = 5 * 9.81 * 0.1 / 20 * 0.8
    rate = -torque / (0.05**2 / 0.6 + 2e-5)
    np.testing.assert_allclose(result["machine.rate"][-1], rate, rtol=1e-6)
    np.testing.assert_allclose(result["machine.current"][-1], -0.05 * rate / 0.6, rtol=1e-6)
    assert np.abs(result["energy.residual"]).max() < 1e-6
