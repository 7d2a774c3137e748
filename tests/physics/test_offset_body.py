"""Error control does not depend on where the frame of a body is."""

import numpy as np
import pytest

SPIN = 100.0 / (20 * 15)  # torque over rate and inertia


def steps_and_error(model, lever: float, rtol: float) -> tuple[int, float]:
    result = model.simulate(rtol=rtol, parameters={"com[2]": lever})
    exact = -SPIN * (1 - np.cos(20 * result.time))
    return result.counts["steps"], float(np.abs(result["spin"] - exact).max())


@pytest.mark.parametrize("rtol", [1e-4, 1e-6])
def test_a_lever_to_the_centre_of_mass_costs_neither_steps_nor_accuracy(load, rtol):
    """With M_ii for the scale, a third of the steps and 300 times the error at 1 km."""
    model = load("offset_body", "shaken")
    steps, error = steps_and_error(model, 0.0, rtol)
    assert error < 2 * rtol
    for lever in (1.0, 100.0, 1e4):
        far_steps, far_error = steps_and_error(model, lever, rtol)
        assert far_steps == pytest.approx(steps, rel=0.05)
        assert far_error < 2 * error
