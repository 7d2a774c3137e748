"""A source that stirs when long steps would suit everything else."""

import numpy as np
import pytest


@pytest.mark.parametrize("solver", ["rodas5p", "rodas4p2", "radau5", "dopri5"])
@pytest.mark.parametrize("width", [0.02, 0.05, 1.0])
def test_a_pulse_that_rows_resolve_is_not_stepped_over(load, solver, width):
    result = load("pulse", "late").simulate(solver=solver, parameters={"width": width})
    assert result["reached"][-1] == pytest.approx(np.sqrt(np.pi) * width, rel=1e-3)
