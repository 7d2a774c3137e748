"""The bare supply vessel, linearised about rest and moving."""

import numpy as np


def oscillations(eigenvalues: np.ndarray) -> np.ndarray:
    """Rows (period in s, damping ratio) of the oscillating modes, by period."""
    modes = [x for x in eigenvalues if x.imag > 1e-3]
    rows = [(2 * np.pi / x.imag, -x.real / abs(x)) for x in modes]
    return np.array(sorted(rows))


def test_undamped_periods(load):
    at_rest = {"ship.r0[3]": 0}
    modes = oscillations(load("vessel_at_rest", "undamped").eigenvalues(parameters=at_rest))
    np.testing.assert_allclose(modes[:, 0], [5.150, 7.633, 10.181], atol=5e-4)
    np.testing.assert_allclose(modes[:, 1], 0, atol=1e-9)


def test_damped_periods(load):
    modes = oscillations(load("vessel_at_rest", "damped").eigenvalues())
    np.testing.assert_allclose(modes[:, 0], [5.487, 7.753, 10.356], atol=5e-4)
    np.testing.assert_allclose(modes[:, 1], [0.330, 0.205, 0.156], atol=5e-4)


def test_an_undamped_heave_keeps_its_energy(load):
    result = load("vessel_at_rest", "undamped").simulate(20)
    displacement = result["displacement"]
    potential = 0.5 * 12018034.8 * displacement[0, 0] ** 2
    assert displacement[0, 0] == 0.1
    assert np.ptp(displacement[:, 0]) > 0.1, "it has to heave"
    assert np.abs(result["energy.stored"]).max() < 1e-7 * potential


def test_it_is_carried_along_by_the_current(load):
    """Let go at rest over ground, in the end it drifts with the current and does not turn."""
    from_rest = {"ship.current[1]": 0.5, "ship.twist0[1]": -0.5}
    result = load("vessel_at_rest", "damped").simulate(600, every=1, parameters=from_rest)
    velocity = np.diff(result["deck"], axis=0)
    assert abs(velocity[0, 0]) < 0.01
    np.testing.assert_allclose(velocity[-1], [0.5 * (1 - np.exp(-6)), 0, 0], atol=5e-4)


def test_a_steady_load_trims_and_heels_it(load):
    """Statics in library axes: down sinks it, a moment about y (port) presses the bow down."""
    model = load("vessel_at_rest", "damped")
    wrench = {"load[3]": -1e5, "load[4]": 2e5, "load[5]": 3e6}
    result = model.simulate(300, every=10, parameters=wrench)
    stiffness = [[12018034.8, 0, 6009017.4], [0, 100856879.185, 0], [6009017.4, 0, 5874549987.19]]
    expected = np.linalg.solve(stiffness, [-1e5, 2e5, 3e6])
    np.testing.assert_allclose(result["displacement"][-1], expected, rtol=2e-3)


def test_quaternion_and_euler_angles_roll_alike(load):
    quaternion, euler = (load("vessel_at_rest", s).simulate() for s in ("rolling", "rolling_euler"))
    assert np.ptp(quaternion["displacement"][:, 1]) > 0.2
    for name in ("displacement", "deck"):
        np.testing.assert_allclose(quaternion[name], euler[name], atol=1e-8)
    # The restoring field's roll and pitch are the Euler angles themselves.
    np.testing.assert_allclose(euler["displacement"][:, 1:], euler["angles"][:, :2], atol=1e-12)


def test_at_rest_in_the_water_it_goes_with_the_current_however_it_is_turned(load):
    result = load("vessel_at_rest", "adrift").simulate()
    expected = np.outer(result.time, [1, 0.5, 0])
    np.testing.assert_allclose(result["place"], expected, atol=1e-6)
