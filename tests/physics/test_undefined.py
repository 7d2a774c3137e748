"""A comparison of what is undefined ends the run, unless the model guards it."""

import numpy as np
import pytest

from bgc import SimulationError

SOLVERS = [{"rtol": 1e-6}, {"solver": "radau5"}, {"solver": "ros34prw", "step": 0.013},
           {"solver": "rk4", "step": 0.013}]  # fmt: skip
ENDS = {"bare": 0.75 + 0.25 / 0.3, "never": 0.0, "rounded": 1.0, "signed": 1.0}


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("scene", ENDS)
def test_a_comparison_of_what_is_undefined_ends_the_run(load, scene, solver):
    with pytest.raises(SimulationError) as caught:
        load("undefined", scene).simulate(**solver)
    assert caught.value.diagnostics[0].code == "BG703"
    result = caught.value.result
    assert result.time[-1] == pytest.approx(ENDS[scene], abs=0.02)
    assert np.isfinite(result["x"]).all()
    assert result["x"].min() >= -1e-9, "no row lies beyond where the law is defined"


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(
    ("scene", "end"), [("guarded", -0.1 * (10 - ENDS["bare"])), ("both", 0.25 - 0.3 * 9.25)]
)
def test_what_is_undefined_behind_a_guard_does_no_harm(load, scene, end, solver):
    result = load("undefined", scene).simulate(**solver)
    assert result["x"][-1] == pytest.approx(end, abs=1e-6)


def test_an_assertion_about_what_is_undefined_does_not_hold(load):
    with pytest.raises(SimulationError) as caught:
        load("undefined", "asserted").simulate()
    assert caught.value.diagnostics[0].code == "BG705"
