"""A free rigid body with offset centre of mass: energy and inertial momenta stay."""

import numpy as np
import pytest

from bgc.language.solver import Solver
from bgc.runtime.running.failures import SimulationError
from bgc.runtime.running.structures import Status


def spread(columns: np.ndarray) -> float:
    """Largest departure from the first row, relative to its length."""
    return float(np.abs(columns - columns[0]).max() / np.linalg.norm(columns[0]))


@pytest.mark.parametrize("scene", ["quaternion", "euler"])
def test_energy_and_inertial_momenta_are_kept(load, scene):
    result = load("tumbling", scene).simulate()
    kinetic = 0.5 * np.einsum("ij,ij->i", result["momentum"], result["twist"])
    assert result.time[-1] == 10
    assert np.ptp(result["twist"], axis=0).max() > 1, "it has to tumble"
    assert spread(kinetic[:, None]) < 1e-9
    assert np.abs(result["energy.stored"]).max() < 1e-9 * kinetic[0]
    assert spread(result["linear"]) < 1e-9
    assert spread(result["angular"]) < 1e-9


def test_the_quaternion_has_length_one_after_every_step(load):
    """Long steps of a method that does not keep it by itself."""
    model = load("tumbling", "quaternion")
    attitude = [k for k, state in enumerate(model.states) if ".attitude." in state.name]
    row = np.empty((1, len(model.measured)))
    with model.started(Solver("ros23", step=0.05), False) as instance:
        for step in range(1, 41):
            assert instance.run(np.array([0.05 * step]), row)[0] is Status.OK
            assert np.linalg.norm(instance.state[attitude]) == pytest.approx(1, abs=1e-15)


def test_euler_angles_give_the_motion_of_the_quaternion(load):
    """The same start in both: eqs. 14-16 with the erratum against the quaternion."""
    start = {f"twist0[{k}]": v for k, v in enumerate([1, -2, 0.5, 0.05, -0.08, 2.2], 1)}
    start |= {"angles0[1]": 0, "angles0[2]": 0, "angles0[3]": 0.9}
    quaternion = load("tumbling", "quaternion").simulate(parameters=start)
    euler = load("tumbling", "euler").simulate()
    assert np.abs(euler["theta"]).max() > 0.2, "theta has to move"
    for name in ("linear", "angular", "twist"):
        np.testing.assert_allclose(euler[name], quaternion[name], rtol=0, atol=1e-7)


def test_euler_angles_end_the_run_at_their_singularity(load):
    with pytest.raises(SimulationError, match="singular at theta = \\+-90 deg") as caught:
        load("tumbling", "singular").simulate()
    done = caught.value.result
    assert done.time[-1] < np.pi / 4  # theta = 2 t
    np.testing.assert_allclose(done["theta"], 2 * done.time, rtol=1e-6)
