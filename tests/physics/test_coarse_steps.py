"""Fixed steps that jump over what happens in them say so; fair ones do not."""

import numpy as np
import pytest

from bgc import BgError

METHODS = ("ros34prw", "rodas23w", "ros23", "lie", "rk4", "heun")


def codes(model, **options) -> set[str]:
    try:
        return {w.code for w in model.simulate(**options).warnings}
    except BgError as problem:
        return {d.code for d in problem.diagnostics}


@pytest.mark.parametrize("step", [0.1, 0.01, 0.001])
@pytest.mark.parametrize("method", [*METHODS, "midpoint", "gauss4"])
def test_no_method_passes_a_pole_without_diagnostics(load, method, step):
    found = codes(load("coarse", "pole"), solver=method, step=step)
    assert found & {"BG719", "BG703", "BG714", "BG730"}


@pytest.mark.parametrize("method", [*METHODS, "midpoint", "gauss4"])
def test_no_method_jumps_a_wall_without_diagnostics(load, method):
    """It turns the mass back within 1 ms: longer steps see one side of it or the other."""
    for step in (0.1, 0.01):
        assert codes(load("coarse", "wall"), solver=method, step=step) & {"BG719", "BG714", "BG730"}
    assert not codes(load("coarse", "wall"), solver=method, step=2.5e-4)


@pytest.mark.parametrize("method", ["rk4", "heun"])
def test_an_explicit_method_beyond_its_stability_warns(load, method):
    for rate in (350, 1000, 1e4):  # the limits are at 283 and, as good as, 0
        options = {"solver": method, "step": 0.01, "parameters": {"rate": rate}}
        assert codes(load("coarse", "swing"), **options) & {"BG719", "BG703"}
    for rate in np.linspace(2.8 if method == "rk4" else 2.01, 6, 40):  # over the step
        options = {"solver": method, "step": 0.01, "parameters": {"rate": 100 * rate}}
        assert codes(load("coarse", "decay"), **options) & {"BG719", "BG703"}, rate


@pytest.mark.parametrize("method", METHODS)
def test_a_step_that_resolves_the_motion_is_not_warned_of(load, method):
    assert not codes(load("coarse", "swing"), solver=method, step=0.01)
    assert not codes(load("coarse", "swing"), solver=method, step=0.002)


def test_the_warning_names_state_step_and_time(load):
    result = load("coarse", "pole").simulate(solver="ros23", step=0.01)
    (warning,) = result.warnings
    assert warning.code == "BG719"
    assert "0.01 s" in warning.message
    assert "`x`" in warning.message
    assert result.counts["correction_time"] == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize(("method", "far"), [("midpoint", 100), ("gauss4", 200)])
def test_a_symmetric_method_that_only_keeps_the_energy_warns(load, method, far):
    """Whatever the step, the energy of a linear swing is kept: its balance shows nothing."""
    options = {"solver": method, "step": 0.01}
    assert codes(load("coarse", "swing"), **options, parameters={"rate": far}) == {"BG719"}
    assert not codes(load("coarse", "swing"), **options, parameters={"rate": far / 4})
