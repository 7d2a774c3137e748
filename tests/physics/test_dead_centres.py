"""Divisors that vanish at a state end the run, whatever the method; others do not."""

import math

import numpy as np
import pytest

from bgc import SimulationError

SOLVERS = [{"solver": name} for name in ("rodas5p", "rodas4p2", "radau5", "dopri5")]
SOLVERS += [{"solver": name, "step": 0.01} for name in ("ros34prw", "gauss4", "rk4", "lie")]
POLES = {
    "bare": ("the inertia of `mass`", "`angle`", math.pi / 2),
    "resisted": ("a divisor of the algebraic loop", "`angle`", math.pi / 2),
    "divided": ("a divisor of the algebraic loop at `brake.f`", "`left`", 2.0),
    "touched": ("a divisor of the algebraic loop at `brake.f`", "`left`", 1.0),
}


@pytest.mark.parametrize("solver", SOLVERS, ids=lambda solver: solver["solver"])
@pytest.mark.parametrize("scene", POLES)
def test_a_run_ends_where_a_divisor_vanishes(load, scene, solver):
    what, state, pole = POLES[scene]
    with pytest.raises(SimulationError) as caught:
        load("dead_centres", scene).simulate(**solver)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "BG725"
    assert what in diagnostic.message and state in diagnostic.message
    time = float(diagnostic.message.split("at t = ")[1].split(" s ")[0])
    assert time == pytest.approx(pole, abs=0.01)
    assert pole - 0.02 < caught.value.result.time[-1] <= pole


def test_the_ratio_of_rows_before_a_pole_is_right(load):
    with pytest.raises(SimulationError) as caught:
        load("dead_centres", "bare").simulate(rtol=1e-9)
    result = caught.value.result
    # The momentum x of the flow obeys x' = 1 - x tan(t): x = cos(t) ln((1 + sin(t)) / cos(t)).
    t = result.time
    np.testing.assert_allclose(result["mass.p"], np.log((1 + np.sin(t)) / np.cos(t)), rtol=1e-6)


@pytest.mark.parametrize("solver", SOLVERS, ids=lambda solver: solver["solver"])
def test_an_inertia_before_the_modulus_carries_the_run_through(load, solver):
    result = load("dead_centres", "weighted").simulate(**solver)
    angle = result["angle"]
    assert angle[-1] == pytest.approx(3)
    assert np.isfinite(result["mass.p"]).all()


@pytest.mark.parametrize("solver", SOLVERS[:5], ids=lambda solver: solver["solver"])
def test_a_divisor_of_many_decades_is_no_pole(load, solver):
    model = load("dead_centres", "switched")
    assert model.library.model.n_divisor > 0
    assert model.simulate(**solver)["seen"][-1] == pytest.approx(1.0, rel=1e-2)


def test_instances_with_a_pole_are_named_one_by_one(load):
    many = load("dead_centres", "divided").simulate_many([{}] * 9, duration=3.0)
    assert len(many.failures) == 9
    assert all("BG725" in str(failure) for failure in many.failures.values())
