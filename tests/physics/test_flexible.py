"""Flexible beams against Euler and Bernoulli, statics, rotor modes, and momentum."""

import numpy as np
import pytest

E, G, DENSITY, LENGTH = 210e9, 210e9 / 2.6, 7850.0, 10.0
CLAMPED, FREE = 1.87510406871196**2, 4.73004074486270**2


def unit(width, height):
    """sqrt(E I/(m' L^4)) of bending about the axis along the width."""
    return np.sqrt(E * height**2 / 12 / DENSITY) / LENGTH**2


def modes(model, **parameters):
    values = model.eigenvalues(parameters=parameters)
    values = values[values.imag > 1e-3]
    return values[np.argsort(np.abs(values))]


@pytest.mark.parametrize(("scene", "bound"), [("clamped_4", 3e-3), ("clamped", 4e-4)])
def test_a_clamped_beam_has_the_modes_of_its_formulas(load, scene, bound):
    found = modes(load("flexible", scene))
    first = CLAMPED * np.array([unit(0.2, 0.12), unit(0.12, 0.2)])
    np.testing.assert_allclose(np.abs(found[:2]), first, rtol=bound)
    assert -found[0].real / abs(found[0]) == pytest.approx(0.01, rel=bound)
    if scene == "clamped":
        found = modes(load("flexible", scene), **{"beam.damping_ratio": 0.0})
        torsion = 0.12**3 * 0.2 * (1 / 3 - 0.21 * 0.6 * (1 - 0.6**4 / 12))  # Roark
        turning = np.pi / 2 / LENGTH * np.sqrt(G * torsion / (DENSITY * 0.12 * 0.2 * 0.0544 / 12))
        axial = np.pi / 2 / LENGTH * np.sqrt(E / DENSITY)
        for exact in (turning, axial):
            assert np.abs(np.abs(found) / exact - 1).min() < 2e-3


@pytest.mark.parametrize("scene", ["clamped_4", "clamped"])
def test_the_tip_of_a_loaded_beam_stands_where_statics_puts_it(load, scene):
    result = load("flexible", scene).simulate()
    area, about_y, about_z = 0.024, 0.12 * 0.2**3 / 12, 0.2 * 0.12**3 / 12
    deflection = [
        30 * LENGTH / E / area - 0.6 * (0.00204**2 + 0.00128**2) / LENGTH,  # and by its bow
        40 * (LENGTH**3 / 3 / E / about_z + LENGTH / (5 / 6 * G * area))
        - 20 * LENGTH**2 / 2 / E / about_z,
        -60 * (LENGTH**3 / 3 / E / about_y + LENGTH / (5 / 6 * G * area))
        - 30 * LENGTH**2 / 2 / E / about_y,
    ]
    turn = [
        60 * LENGTH**2 / 2 / E / about_y + 30 * LENGTH / E / about_y,
        40 * LENGTH**2 / 2 / E / about_z - 20 * LENGTH / E / about_z,
    ]
    np.testing.assert_allclose(result["beam.deflection"][0, 1:], deflection[1:], rtol=2e-4)
    assert result["beam.deflection"][0, 0] == pytest.approx(deflection[0], abs=3e-8)
    np.testing.assert_allclose(result["turn"][0, 1:], turn, rtol=2e-4)


@pytest.mark.parametrize(
    ("spin", "flapping"), [(0, 3.5160), (3, 4.7973), (6, 7.3604), (12, 13.1702)]
)
def test_a_beam_on_a_turning_base_is_stiffened(load, spin, flapping):
    """Flapping, root at the hub: A. D. Wright et al., J. Applied Mechanics 49 (1982) 197."""
    scale = unit(0.12, 0.05)
    found = np.abs(modes(load("flexible", "spinning"), rate=spin * scale)) / scale
    assert np.abs(found / flapping - 1).min() < 2.5e-3


def test_a_free_beam_rings_and_flies(load):
    model = load("flexible", "flying")
    found = modes(model, **{f"twist0[{k}]": 0.0 for k in range(1, 7)})
    ring = np.sqrt(E * (0.1**2 + 0.09**2) / 16 / DENSITY) / LENGTH**2
    np.testing.assert_allclose(np.abs(found[:2]), FREE * ring, rtol=3e-3)
    result = model.simulate(rtol=1e-7)
    start = np.array([0, -5.0, 0])
    velocity = np.array([1, 2, 3]) + np.cross([0.3, 0.5, 0.8], start)
    straight = start + result.time[:, None] * velocity
    np.testing.assert_allclose(result["centre"], straight, atol=1e-5)
    assert np.abs(result["energy.residual"]).max() < 1e-4
