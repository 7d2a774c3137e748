"""Storage in derivative causality: closed answers and Lagrange's equations."""

import numpy as np
from lagrange import motion, of_points
from scipy.linalg import expm
from scipy.special import ellipk

GRAVITY = 9.81


def test_two_masses_on_one_junction(load):
    model = load("merged", "two_masses")
    assert len(model.states) == 1
    result = model.simulate()
    v = 1 - np.exp(-result.time / 5)
    np.testing.assert_allclose(result["v"], v, atol=1e-10)
    np.testing.assert_allclose(result["light"], 2 * v, atol=1e-9)
    assert round(result["light"][-1], 6) == 0.362538
    assert round(result["heavy"][-1], 6) == 0.543808


def test_an_inertia_behind_a_transformer(load):
    result = load("merged", "lever").simulate()
    v = (1 - np.exp(-result.time * 4 / 14)) / 4
    np.testing.assert_allclose(result["v"], v, atol=1e-10)
    np.testing.assert_allclose(result["w"], 2 * v, atol=1e-10)
    assert round(result["v"][-1], 7) == 0.0621307


def test_a_modulus_that_states_move(load):
    """m v' + r (M r v)' = 0 for the ratio r(t): v^2 (m + M r^2) stays."""
    result = load("merged", "shifting").simulate(rtol=1e-9)
    a, b = np.exp(-result.time), 2 * np.exp(-3 * result.time)
    np.testing.assert_allclose(result["a"], a, atol=1e-7)
    np.testing.assert_allclose(result["b"], b, atol=1e-7)
    v = np.sqrt((2 + 3 * 3**2) / (2 + 3 * (a + b) ** 2))
    np.testing.assert_allclose(result["v"], v, rtol=1e-7)
    np.testing.assert_allclose(result["w"], (a + b) * v, rtol=1e-7)


def test_a_gear_train_turns_as_one_inertia(load):
    """Seen from the motor, inertias and damping count by the squares of the ratios."""
    model = load("merged", "gear_train")
    assert len(model.states) == 2
    result = model.simulate()
    lay, drum = -0.4, -0.4 * -0.25
    inertia = 0.02 + 0.3 * lay**2 + 4 * drum**2
    damping, stiffness = 0.5 * lay**2, 30 * drum
    system = np.array(
        [[-damping / inertia, -stiffness / inertia, 5 / inertia], [drum, 0, 0], [0, 0, 0]]
    )
    exact = np.array([expm(system * t) @ [0, 0, 1] for t in result.time])
    np.testing.assert_allclose(result["motor"], exact[:, 0], atol=1e-7)
    np.testing.assert_allclose(result["twist"], exact[:, 1], atol=1e-7)
    np.testing.assert_allclose(result["drum"], drum * exact[:, 0], atol=1e-7)


def test_a_slider_on_a_cart(load):
    """Both accelerate evenly, at any slope: also straight down, and along the cart."""
    model = load("merged", "slider")
    for degrees in (-70, 0, 40, 90, 180):
        slope = np.radians(degrees)
        result = model.simulate(parameters={"slope": slope})
        lean = 1.5 * np.cos(slope)
        mass = [[4 + 1.5, lean], [lean, 1.5]]
        rates = np.linalg.solve(mass, [3, -1.5 * GRAVITY * np.sin(slope)])
        found = np.column_stack([result["cart"], result["slider"]])
        np.testing.assert_allclose(found, np.outer(result.time, rates), atol=1e-9)
        momentum = 1.5 * (rates[0] + rates[1] * np.cos(slope)) * result.time
        np.testing.assert_allclose(result["momentum"][:, 0], momentum, atol=1e-9)


def test_capacitors_in_parallel_charge_together(load):
    """The first starts at 1 V, so both do."""
    result = load("merged", "capacitors").simulate()
    voltage = 10 - 9 * np.exp(-result.time / (50 * 5e-3))
    np.testing.assert_allclose(result["voltage"], voltage, atol=1e-8)
    np.testing.assert_allclose(result["one"], 2e-3 * voltage, atol=1e-11)
    np.testing.assert_allclose(result["other"], 3e-3 * voltage, atol=1e-11)


def test_capacitors_on_a_source_follow_it(load):
    """No state is left; the source's current needs the rate of its voltage."""
    model = load("merged", "driven")
    assert not model.states
    result = model.simulate(solver="ros34prw", step=1e-3, every=0.1)
    voltage, rate = 10 * np.sin(3 * result.time), 30 * np.cos(3 * result.time)
    np.testing.assert_allclose(result["voltage"], voltage, atol=1e-12)
    np.testing.assert_allclose(result["one"], 2e-3 * voltage, atol=1e-14)
    np.testing.assert_allclose(result["other"], 3e-3 * voltage, atol=1e-14)
    np.testing.assert_allclose(result["current"], 5e-3 * rate + voltage / 100, atol=1e-12)
    np.testing.assert_allclose(result["energy.residual"], 0, atol=1e-8)


def test_period_of_a_pendulum_from_nearly_upright(load):
    """Complete elliptic integral: at quarters of the period it hangs, swings, hangs."""
    start = 0.98 * np.pi
    period = 4 * np.sqrt(10 / GRAVITY) * ellipk(np.sin(start / 2) ** 2)
    assert round(period, 7) == 19.5782798
    result = load("pendulums", "pendulum").simulate()
    np.testing.assert_allclose(result.time[-1], period, atol=1e-7)
    np.testing.assert_allclose(result["theta"], start * np.array([1, 0, -1, 0, 1]), atol=1e-6)
    late = result["theta"][1::2] / result["rate"][1::2]
    np.testing.assert_allclose(late, 0, atol=1e-7)


def test_double_pendulum_moves_as_lagrange_says(load):
    model = load("pendulums", "double")
    assert len(model.states) == 4
    for masses in ((1, 0.6), (0.3, 2)):
        result = model.simulate(parameters=dict(zip(("mass1", "mass2"), masses, strict=True)))

        def upper(q):
            return np.array([[np.cos(q[0]), 0], [np.sin(q[0]), 0]])

        def lower(q):
            return upper(q) + 0.7 * np.array([[0, np.cos(q[1])], [0, np.sin(q[1])]])

        def potential(q, masses=masses):
            a, b = -np.cos(q)
            return GRAVITY * (sum(masses) * a + masses[1] * 0.7 * b)

        mass = of_points((masses[0], upper), (masses[1], lower))
        q, v = motion(mass, potential, np.array([2.0, -1]), np.zeros(2), result.time)
        assert np.ptp(q, axis=0).min() > 2
        np.testing.assert_allclose(result["a"], q[:, 0], atol=1e-6)
        np.testing.assert_allclose(result["b"], q[:, 1], atol=1e-6)
        np.testing.assert_allclose(result["a_rate"], v[:, 0], atol=1e-5)
        np.testing.assert_allclose(result["b_rate"], v[:, 1], atol=1e-5)
        assert np.abs(result["energy.residual"]).max() < 1e-7


def test_a_pendulum_on_a_cart_turns_over(load):
    """Through both zeros of the rod's modulus, where neither rate can be solved for alone."""
    result = load("pendulums", "on_cart").simulate()

    def bob(q):
        return np.array([[1, 1.2 * np.cos(q[1])], [0, 1.2 * np.sin(q[1])]])

    def cart(_):
        return np.array([[1.0, 0]])

    def potential(q):
        return 8 * q[0] ** 2 / 2 - 2 * GRAVITY * 1.2 * np.cos(q[1])

    q, v = motion(
        of_points((3, cart), (2, bob)), potential, np.zeros(2), [0, 11 / 1.2], result.time
    )
    assert q[:, 1].max() > np.pi, "it has to turn over"
    found = np.column_stack([result["x"], result["theta"], result["v"], result["rate"]])
    np.testing.assert_allclose(found, np.hstack([q, v]), atol=1e-7)
    assert np.abs(result["energy.residual"]).max() < 1e-7
