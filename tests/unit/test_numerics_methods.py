"""Observed orders of the methods, and accuracy on problems with known answers."""

from __future__ import annotations

import math
from ctypes import POINTER, byref, c_double
from typing import Any

import numpy as np
import pytest
from method_rows import MethodStruct

from bgc.language.methods import METHODS
from bgc.runtime.running.structures import Status

ORDER = {name: method.order for name, method in METHODS.items()}
ADAPTIVE = tuple(name for name, method in METHODS.items() if not method.fixed)
STIFF = tuple(name for name in ADAPTIVE if METHODS[name].family.jacobian)
IMPLICIT = tuple(
    name
    for name, method in METHODS.items()
    if method.fixed and method.family.jacobian and "Gauss" not in method.family.name
)
TRANSISTOR_END = (  # Test Set for IVP Solvers, at t = 0.2
    -0.5562145012262709e-2,
    3.006522471903042,
    2.849958788608128,
    2.926422536206241,
    2.704617865010554,
    2.761837778393145,
    4.770927631616772,
    1.236995868091548,
)


def observed_order(steps: list[float], errors: list[float]) -> float:
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


def start_equidistant(instance: Any, method: str, step: float) -> None:
    """Start a method that takes this step and no other, whether it is adaptive or not."""
    if method in ADAPTIVE:
        instance.start(method, step=step, max_step=step, rtol=1e3)
    else:
        instance.start(method, step=step, substeps=1)


def kaps_error(c_model: Any, method: str, step: float, eps: float, end: float = 1.0) -> float:
    kaps = c_model("kaps")
    kaps.set(p0=eps)
    start_equidistant(kaps, method, step)
    error = kaps.finish([end])[0] - [math.exp(-2.0 * end), math.exp(-end)]
    return float(np.abs(error).max())


def pendulum_angle(row: Any) -> float:
    return math.atan2(row[0], -row[1])


def test_interface_names_the_methods(c_model: Any) -> None:
    kaps = c_model("kaps")
    found = {}
    info = MethodStruct()
    while kaps.library.bgc_get_method(len(found), byref(info)) == Status.OK:
        found[info.name.decode()] = info.error_order > 0
    assert found == {name: name in ADAPTIVE for name in ORDER}
    assert kaps.library.bgc_get_method(-1, byref(info)) == Status.BAD_ARGUMENT
    assert kaps.options("euler") == "BAD_ARGUMENT"


@pytest.mark.parametrize("method", ORDER)
def test_order_on_smooth_problem(c_model: Any, method: str) -> None:
    steps = [0.1, 0.05, 0.025] if ORDER[method] > 3 else [0.02, 0.01, 0.005]
    errors = [kaps_error(c_model, method, step, eps=1.0) for step in steps]
    assert observed_order(steps, errors) == pytest.approx(ORDER[method], abs=0.3)


@pytest.mark.parametrize("method", [*IMPLICIT, *STIFF])
def test_order_on_kaps_problem_in_the_stiff_limit(c_model: Any, method: str) -> None:
    steps = [0.2, 0.1, 0.05]
    errors = [kaps_error(c_model, method, step, eps=1e-8) for step in steps]
    assert observed_order(steps, errors) > ORDER[method] - 0.2


@pytest.mark.parametrize("method", [*IMPLICIT, *STIFF])
def test_order_on_prothero_robinson_in_the_stiff_limit(c_model: Any, method: str) -> None:
    steps = [0.2, 0.1, 0.05]
    errors = []
    for step in steps:
        problem = c_model("prothero_robinson")
        start_equidistant(problem, method, step)
        errors.append(abs(problem.finish([10.0])[0, 0] - math.cos(10.0)))
    assert observed_order(steps, errors) > min(ORDER[method], 3) - 0.2
    assert errors[-1] < 2e-3


@pytest.mark.parametrize("method", [*IMPLICIT, *STIFF])
def test_order_on_a_near_rigid_pendulum_whatever_its_stiffness(c_model: Any, method: str) -> None:
    steps = [0.1, 0.05, 0.025] if method == "radau5" else [1e-3, 5e-4, 2.5e-4]
    errors: dict[float, list[float]] = {}
    for stiffness in (1e10, 1e14):
        reference = c_model("pendulum")
        reference.set(p0=stiffness)
        reference.start("rodas5p", rtol=1e-11)
        angle = pendulum_angle(reference.finish([1.0])[0])
        errors[stiffness] = []
        for step in steps:
            pendulum = c_model("pendulum")
            pendulum.set(p0=stiffness)
            start_equidistant(pendulum, method, step)
            errors[stiffness].append(abs(pendulum_angle(pendulum.finish([1.0])[0]) - angle))
    order = {"lie": 1, "rodas5p": 3, "switching": 3, "rodas4p2": 3, "radau5": 5}.get(method, 2)
    assert observed_order(steps, errors[1e14]) == pytest.approx(order, abs=0.4)
    assert errors[1e14][0] < 3.0 * errors[1e10][0]


@pytest.mark.parametrize("keep", [1, 2, 5])
def test_kept_factorisation_keeps_the_order_of_the_w_method(c_model: Any, keep: int) -> None:
    steps = [0.02, 0.01, 0.005]
    errors = []
    for step in steps:
        kaps = c_model("kaps")
        kaps.set(p0=1.0)
        kaps.start("ros34prw", step=step, keep=keep)
        errors.append(abs(kaps.finish([1.0])[0, 1] - math.exp(-1.0)))
        assert kaps.counts.factorisations == -(-kaps.counts.steps // keep)
        assert kaps.counts.jacobians == kaps.counts.factorisations
    assert observed_order(steps, errors) > 2.7


@pytest.mark.parametrize(
    ("method", "order"),
    [("rodas5p", 5), ("rodas4p2", 4), ("ros34prw", 4), ("radau5", 4), ("dopri5", 5)],
)
@pytest.mark.parametrize("part", [0.2, 0.5, 0.8])
def test_order_of_rows_inside_a_step(c_model: Any, method: str, order: int, part: float) -> None:
    steps = [0.1, 0.05, 0.025]
    errors = [kaps_error(c_model, method, step, 1.0, end=part * step) for step in steps]
    assert observed_order(steps, errors) > order - 0.7


@pytest.mark.parametrize("method", ADAPTIVE)
def test_the_rate_of_the_dense_output_in_the_middle_of_a_step(c_model: Any, method: str) -> None:
    kaps = c_model("kaps")
    start_equidistant(kaps, method, 0.5)
    kaps.finish([0.5])
    parts = np.linspace(0.0, 1.0, 6)  # for polynomials up to degree 4
    points = np.empty((len(parts), 8 * kaps.states))  # room for registers of eight
    for part, point in zip(parts, points, strict=True):
        place = point.ctypes.data_as(POINTER(c_double))
        kaps.library.bgc_interpolate(kaps.model, kaps.data, c_double(0.5 * part), place)
    rate = np.empty(kaps.states)
    kaps.library.bgc_dense_slope(kaps.model, kaps.data, rate.ctypes.data_as(POINTER(c_double)))
    for column, found in zip(points.T[: kaps.states], rate, strict=True):
        slope = np.polyval(np.polyder(np.polyfit(parts, column, 5)), 0.5) / 0.5
        assert found == pytest.approx(slope, rel=1e-10)


@pytest.mark.parametrize("method", STIFF)
def test_rows_inside_steps_along_a_stiff_solution(c_model: Any, method: str) -> None:
    """L-stable methods end every step right, however long, and see no error of it."""
    problem = c_model("prothero_robinson")
    problem.set(p0=-1e8)
    problem.start(method, rtol=1e-5)
    times = np.linspace(0.0, 20.0, 1001)
    assert np.abs(problem.finish(times)[:, 0] - np.cos(times)).max() < 1e-3


@pytest.mark.parametrize("method", IMPLICIT)
def test_rows_in_a_step_that_outlives_a_transient(c_model: Any, method: str) -> None:
    """Slopes at the start of the step would swing a cubic far out."""
    problem = c_model("prothero_robinson")
    problem.start(method, step=0.1)
    problem.state[0] = 2.0  # where the solution is 1
    rows = problem.finish(np.linspace(0.0, 0.1, 11))
    assert rows.max() <= 2.0 and rows.min() > -1.5


@pytest.mark.parametrize("method", ADAPTIVE)
def test_error_follows_the_tolerance(c_model: Any, method: str) -> None:
    for rtol in (1e-4, 1e-7, 1e-10):
        oscillator = c_model("oscillator")
        oscillator.start(method, rtol=rtol)
        rows = oscillator.finish(np.linspace(0.0, 10.0, 101))
        oscillator.start("rodas5p", rtol=1e-13)
        reference = oscillator.finish(np.linspace(0.0, 10.0, 101))
        assert np.abs(rows - reference).max() < 10.0 * rtol


@pytest.mark.parametrize("method", STIFF)
def test_robertson_with_an_algebraic_equation(c_model: Any, method: str) -> None:
    robertson = c_model("robertson")
    robertson.start(method, rtol=1e-8, atol=1e-14)
    assert robertson.state[2] == pytest.approx(0.0, abs=1e-15)  # the start is put right
    rows = robertson.finish([1e11])
    reference = [0.2083340149701255e-7, 0.8333360770334713e-13, 0.9999999791665050]
    np.testing.assert_allclose(rows[0], reference, rtol=1e-6)
    assert robertson.counts.steps < 5000


@pytest.mark.parametrize("method", STIFF)
def test_transistor_amplifier_with_singular_full_mass(c_model: Any, method: str) -> None:
    amplifier = c_model("amplifier")
    amplifier.start(method, rtol=1e-5, atol=1e-7)
    np.testing.assert_allclose(amplifier.finish([0.2])[0], TRANSISTOR_END, rtol=1e-4, atol=1e-5)


def test_fixed_step_solves_algebraic_equations(c_model: Any) -> None:
    amplifier = c_model("amplifier")
    amplifier.start("ros34prw", step=2e-5)
    np.testing.assert_allclose(amplifier.finish([0.2])[0], TRANSISTOR_END, rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize("method", IMPLICIT)
def test_order_with_an_algebraic_equation(c_model: Any, method: str) -> None:
    steps = [0.1, 0.05, 0.025]
    errors = []
    for step in steps:
        fold = c_model("fold")
        fold.start(method, step=step)
        errors.append(np.abs(fold.finish([1.0])[0] - [0.25, 0.5]).max())
    assert observed_order(steps, errors) > ORDER[method] - 0.3


@pytest.mark.parametrize(("method", "order", "longest"), [("rk4", 4, 0.2), ("heun", 2, 0.1)])
def test_explicit_methods_solve_algebraic_equations_at_every_stage(
    c_model: Any, method: str, order: int, longest: float
) -> None:
    steps = [longest, longest / 2, longest / 4]  # errors stay above rounding
    errors = []
    for step in steps:
        robertson = c_model("robertson")
        robertson.start(method, step=step * 2e-3)
        reference = c_model("robertson")
        reference.start("radau5", rtol=1e-13, atol=1e-16)
        y, exact = robertson.finish([1e-2])[0], reference.finish([1e-2])[0]
        errors.append(np.abs(y - exact).max())
        assert y.sum() == pytest.approx(1.0, abs=1e-14)
    assert observed_order(steps, errors) > order - 0.3


def test_explicit_method_refuses_coupled_rates(c_model: Any) -> None:
    amplifier = c_model("amplifier")
    amplifier.start("rk4", step=1e-4)
    assert amplifier.run([1.0])[0] == "NOT_EXPLICIT"
    assert amplifier.library.bgc_failed_state(amplifier.data) == 0


def test_step_option_and_largest_step(c_model: Any) -> None:
    oscillator = c_model("oscillator")
    oscillator.start("rodas5p", rtol=1e-3, max_step=0.01)
    oscillator.finish([1.0])
    assert oscillator.counts.steps >= 100
    oscillator.start("rodas5p", rtol=1e-3, step=1e-9)
    oscillator.finish([0.5e-9])
    assert oscillator.counts.steps == 1
