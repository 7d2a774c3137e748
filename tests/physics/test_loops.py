"""Algebraic loops against closed answers, scipy's root finders and its stiff integrator."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, root

import bgc
from bgc.runtime.running.failures import SimulationError


def test_the_resistors_around_a_capacitor(load):
    result = load("loops", "ladder").simulate(1.0, rtol=1e-10)
    assert result["store.q"][-1] == pytest.approx(0.1591331, abs=5e-8)


def diode_current(v: float) -> float:
    """Solve the loop of two diodes behind 1 kOhm as one equation in the sharp one's e."""

    def current(e: float) -> float:
        return 1e-14 * math.expm1(e / 0.02585)

    def excess(e: float) -> float:
        i = current(e)
        return 1000 * i + e + 0.05 * math.log1p(i / 1e-9) - v

    return current(brentq(excess, min(v, 0.0) - 1, 2.0, xtol=1e-300, rtol=1e-14))


@pytest.mark.parametrize("v", [1e-3, 0.1, 0.4, 0.6, 1, 5, 24, 300, 1e4, 1e6])
def test_a_series_diode_loop_from_its_start_value(load, v):
    result = load("loops", "diodes").simulate(0.01, parameters={"v": v})
    assert result["loop.f"][0] == pytest.approx(diode_current(v), rel=1e-9)


@pytest.mark.parametrize("v", [-0.02, -0.3, -20, -1e3])
def test_a_series_diode_loop_that_blocks(load, v):
    result = load("loops", "diodes").simulate(0.01, parameters={"v": v})
    assert result["loop.f"][0] == pytest.approx(diode_current(v), rel=1e-2)  # all but 1e-14 A
    assert result["sharp.e"][0] + result["soft.e"][0] == pytest.approx(v, rel=1e-9)


@pytest.mark.parametrize(
    ("options", "tolerance"),
    [
        ({"rtol": 1e-8}, 1e-8),
        ({"solver": "radau5", "rtol": 1e-8}, 1e-8),
        ({"solver": "ros34prw", "step": 1e-4}, 1e-7),
        ({"solver": "rk4", "step": 1e-4}, 1e-7),
    ],
)
def test_a_rectifier_with_every_kind_of_method(load, options, tolerance):
    times = np.linspace(0, 0.1, 21)
    reference = solve_ivp(
        lambda t, q: [diode_current(5 * math.sin(100 * t) - q[0] / 1e-5)],
        (0, 0.1), [0.0], "Radau", times, rtol=1e-9, atol=1e-15,
    )  # fmt: skip
    result = load("loops", "rectifier").simulate(0.1, every=0.005, **options)
    np.testing.assert_allclose(result["store.q"], reference.y[0], atol=5e-5 * tolerance / 1e-7)
    assert np.abs(result["energy.residual"]).max() < 1e-7


@pytest.mark.parametrize("scene", ["tank", "turned_tank"])
def test_a_tank_empties_as_torricelli_says(load, scene):
    result = load("loops", scene).simulate(30.0, rtol=1e-9)
    level = np.sqrt(3) - 0.5e-3 * np.sqrt(9810 / 2) * result.time
    np.testing.assert_allclose(result["water.q"], level**2, rtol=1e-7)


@pytest.mark.parametrize("scene", ["tank", "turned_tank"])
def test_a_tank_that_is_empty_stays_so(load, scene):
    result = load("loops", scene).simulate(80.0, rtol=1e-6)
    assert np.abs(result["water.q"][-20:]).max() < 1e-4


@pytest.mark.parametrize("i", [-30, -1, 0, 0.2, 2, 500])
def test_resistors_that_share_an_effort(load, i):
    def bent(e: float) -> float:
        return 2 * e / (2 + math.sqrt(4 + 4 * abs(e)))

    exact = brentq(lambda e: e + e**3 + bent(e) - i, -1e3, 1e3, xtol=1e-15, rtol=1e-14)
    result = load("loops", "parallel").simulate(0.01, parameters={"i": i})
    assert result["node.e"][0] == pytest.approx(exact, rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("v", [-30, -1, 0, 0.2, 2, 500])
def test_resistors_that_share_a_flow(load, v):
    def excess(e: float) -> float:
        f = e + e**3
        return e + 2 * f + f * abs(f) - v

    e = brentq(excess, -1e3, 1e3, xtol=1e-15, rtol=1e-14)
    result = load("loops", "series").simulate(0.01, parameters={"v": v})
    assert result["loop.f"][0] == pytest.approx(e + e**3, rel=1e-8, abs=1e-12)


@pytest.mark.parametrize("v", [-40, -2, 0.1, 10, 200])
def test_a_bridge_with_nonlinear_branches(load, v):
    def balances(x):
        top, left, right = x
        lamp = 0.3 * math.tanh((top - left) / 4) + 0.01 * (top - left)
        lower = 2 * right / (15 + math.sqrt(225 + 160 * abs(right)))
        return [
            (v - top) / 0.1 - lamp - (top - right) / 20,
            lamp - (left - right) / 50 - left / 30,
            (top - right) / 20 + (left - right) / 50 - lower,
        ]

    exact = root(balances, [v, v / 2, v / 2], tol=1e-13).x
    result = load("loops", "bridge").simulate(0.01, parameters={"v": v})
    found = [result[name][0] for name in ("top.e", "left.e", "right.e")]
    np.testing.assert_allclose(found, exact, rtol=1e-8)


def test_a_loop_through_a_modulus_that_passes_zero(load):
    def rate(t, q):
        m = math.sin(0.3 + math.sin(t))
        # 1 = 2 f1 + m e, e/5 + f3 = m f1, e = 3 f3 + 2 q
        *_, f3 = np.linalg.solve([[2, m, 0], [m, -1 / 5, -1], [0, 1, -3]], [1, 0, 2 * q[0]])
        return [f3]

    times = np.linspace(0, 10, 21)
    reference = solve_ivp(rate, (0, 10), [0.0], "DOP853", times, rtol=1e-12, atol=1e-14)
    result = load("loops", "lever").simulate(10.0, every=0.5, rtol=1e-10)
    np.testing.assert_allclose(result["store.q"], reference.y[0], atol=1e-9)


@pytest.mark.parametrize(
    ("options", "tolerance"),
    [
        ({"rtol": 1e-7}, 1e-6),
        ({"solver": "radau5", "rtol": 1e-7}, 1e-6),
        ({"solver": "dopri5", "rtol": 1e-7}, 1e-5),
        ({"solver": "ros34prw", "step": 1e-4}, 1e-3),
        ({"solver": "ros34prw", "step": 1e-3}, 1e-2),  # fails unless such a step is halved
    ],
)
def test_a_full_wave_rectifier_keeps_kirchhoff_and_its_energy(load, options, tolerance):
    result = load("loops", "full_wave").simulate(0.05, every=1e-3, **options)

    def diode(e):
        return 1e-12 * np.expm1(e / 0.03) + 1e-9 * e

    e = {k: result[f"d{k}.e"] for k in (1, 2, 3, 4)}
    i = {k: diode(e[k]) for k in e}
    source = 10 * np.sin(314 * result.time) - result["rs.f"]
    np.testing.assert_allclose(e[4] - e[3], source, atol=1e-6)  # a - b
    np.testing.assert_allclose(e[1] - e[2], source, atol=1e-6)
    np.testing.assert_allclose(e[1] + e[3] + result["c.e"], 0, atol=1e-6)
    np.testing.assert_allclose(result["rs.f"], i[1] - i[3], atol=1e-9)
    np.testing.assert_allclose(result["rs.f"], i[4] - i[2], atol=1e-9)
    exact = load("loops", "full_wave").simulate(0.05, every=1e-3, solver="rk4", step=1e-5)
    np.testing.assert_allclose(result["c.e"], exact["c.e"], atol=10 * tolerance)


@pytest.mark.parametrize(
    ("options", "tolerance"),
    [
        ({"rtol": 1e-8}, 1e-5),
        ({"solver": "radau5"}, 1e-4),
        ({"solver": "ros34prw", "step": 5e-3}, 1e-3),  # 8e-3 without the halving of steps
        ({"solver": "ros34prw", "step": 1e-3}, 5e-4),
        ({"solver": "rk4", "step": 1e-3}, 1e-4),
    ],
)
def test_stick_slip_is_right_with_coarse_steps_too(load, options, tolerance):
    def dry(f: float) -> float:
        return (2 + math.exp(-abs(f) / 0.02)) * math.tanh(f / 1e-4)

    def rate(_t, state):
        p, q = state
        slip = 0.1 - p
        f = brentq(lambda f: 300 * (slip - f) - dry(f) - 0.1 * f, -3, 3, xtol=1e-16, rtol=1e-14)
        return [300 * (slip - f) - q / 0.01, p]

    times = np.linspace(0, 4, 81)
    exact = solve_ivp(rate, (0, 4), [0, 0], "LSODA", times, rtol=1e-9, atol=1e-12).y[0]
    result = load("loops", "stick_slip").simulate(4.0, every=0.05, **options)
    np.testing.assert_allclose(result["m.p"], exact, atol=tolerance * np.abs(exact).max())


def ladder_source(size: int) -> str:
    """A ladder of nonlinear resistors, each its own."""
    parts = ["model L { param v = 3; supply : Se(e = v); j0 : J1; supply -> j0;"]
    for k in range(size):
        parts.append(
            f"s{k} : R {{ e = {1 + 0.1 * k}*f + f*abs(f) + tanh(f); }} j{k} -> s{k};"
            f"n{k} : J0; j{k} -> n{k}; p{k} : R {{ f = {0.2 + 0.01 * k}*e + e^3; }} n{k} -> p{k};"
        )
        if k + 1 < size:
            parts.append(f"j{k + 1} : J1; n{k} -> j{k + 1};")
    observed = ", ".join(f"n{k}.e" for k in range(size))
    return " ".join(parts) + f"}} scene s of L {{ observe {observed}; run 1 s; }}"


def test_an_equation_without_a_slope_at_its_start_is_solved(tmp_path):
    path = tmp_path / "flat.bg"
    path.write_text(
        "model M { state x = 0; state y = 0; der(y) = 1; equation x*abs(x) = 4 + y; }"
        "scene s of M { observe x; run 1; }"
    )
    result = bgc.compile(path).simulate(rtol=1e-8)
    np.testing.assert_allclose(result["x"], np.sqrt(4 + result.time), rtol=1e-7)


def test_states_that_share_a_rate_move_together_onto_their_equation(tmp_path):
    """x + y keeps what its rate leaves: from 1 and 2 to the parabola x = y^2 on x + y = 3."""
    path = tmp_path / "tied.bg"
    path.write_text(
        "model M { state x = 1; state y = 2; equation der(x) + der(y) = -x; equation x = y^2; }"
        "scene s of M { observe x, y; run 1; }"
    )
    result = bgc.compile(path).simulate(rtol=1e-8)
    y = (math.sqrt(13) - 1) / 2
    assert (result["x"][0], result["y"][0]) == pytest.approx((3 - y, y), rel=1e-9)
    exact = solve_ivp(lambda t, y: -(y**2) / (2 * y + 1), (0, 1), [y], rtol=1e-10, atol=1e-12)
    assert result["y"][-1] == pytest.approx(exact.y[0, -1], rel=1e-7)


def test_a_loop_of_fifty_unknowns(tmp_path):
    size = 50
    path = tmp_path / "ladder.bg"
    path.write_text(ladder_source(size))

    def misses(x):
        e, f = x[:size], x[size:]
        k = np.arange(size)
        before = np.concatenate([[3.0], e[:-1]])
        after = np.concatenate([f[1:], [0.0]])
        return np.concatenate(
            [
                before - e - (1 + 0.1 * k) * f - f * abs(f) - np.tanh(f),
                f - after - (0.2 + 0.01 * k) * e - e**3,
            ]
        )

    exact = root(misses, np.full(2 * size, 0.1), tol=1e-14)
    assert exact.success
    result = bgc.compile(path).simulate(0.01)
    found = np.array([result[f"n{k}.e"][0] for k in range(size)])
    np.testing.assert_allclose(found, exact.x[:size], rtol=1e-7, atol=1e-13)


def test_a_loop_whose_solution_is_lost_ends_the_run(tmp_path):
    path = tmp_path / "lost.bg"
    path.write_text(
        "model L { supply : MSe(e = 1 - time); loop : J1; a : R { e = f^2; } b : R(0.1);"
        "c : C(1e9); supply -> loop -> a, b, c; } scene s of L { observe loop.f; run 2 s; }"
    )
    with pytest.raises(SimulationError) as failure:
        bgc.compile(path).simulate(solver="ros34prw", step=0.01)
    assert failure.value.diagnostics[0].code in {"BG711", "BG704"}
    assert failure.value.result.time[-1] == pytest.approx(1.0025, abs=0.02)
