"""A scene in CasADi: operations, tables and equations against ours, and runs by its integrators."""

from __future__ import annotations

import math
import subprocess
import sys
from array import array
from pathlib import Path

import numpy as np
import pytest
from model_files import model_text
from refusals import refusal

import bgc
import bgc.library
from bgc.algebra.dag import Dag, Kind, Op
from bgc.algebra.derivatives import directional_derivative
from bgc.algebra.operations import ROWS
from bgc.algebra.table import Grid, Method, Outside, Table
from bgc.runtime.linearising.casadi_expressions import expressions

casadi = pytest.importorskip("casadi")


def model(tmp_path, text, scene=None):
    path = tmp_path / "model.bg"
    path.write_text(text)
    return bgc.compile(path, scene=scene)


def function(dag, nodes, symbols):
    """CasADi's function of some nodes in symbols of the kind INPUT."""
    x = casadi.SX.sym("x", len(symbols))
    made = expressions(casadi, dag, nodes, lambda symbol: x[symbol.index], {})
    return casadi.Function("f", [x], [casadi.vertcat(*made)])


# --- expressions ------------------------------------------------------------------------------

OPERATIONS = [
    op for op in Op if op.row.arity > 0 and op.row.smooth and op not in {Op.LISTED, Op.INVERTED}
]
POINTS = [-2.5, -1.0, -0.3, 0.0, 0.4, 0.5, 1.0, 2.5]


@pytest.mark.parametrize("op", OPERATIONS, ids=lambda op: op.name)
def test_operations_have_the_values_of_ours(op):
    dag = Dag()
    symbols = [dag.symbol(Kind.INPUT, k) for k in range(op.row.arity)]
    f = function(dag, [dag.call(op, *symbols)], symbols)
    compared = 0
    for k, first in enumerate(POINTS):
        operands = [first, *(POINTS[(k + 3 * j) % len(POINTS)] for j in range(1, op.row.arity))]
        due = ROWS[op].evaluate(*operands)
        if math.isfinite(due):
            assert float(f(operands)) == pytest.approx(due, rel=1e-14, abs=1e-15), operands
            compared += 1
    assert compared >= 2


X = array("d", [-1.0, 0.5, 1.0, 3.0, 4.5])
Y = array("d", [2.0, -1.0, 0.0, 4.0, 2.0])


@pytest.mark.parametrize("order", [0, 1])
@pytest.mark.parametrize("outside", Outside)
@pytest.mark.parametrize("method", Method)
def test_tables_have_the_values_of_ours(method, outside, order):
    slopes = array("d", [0.3, -1.0, 2.0, 0.0, 0.3] if method is Method.CUBIC else [])
    table = Table(method, outside, X, Y, slopes, None, False, False, "table")
    dag = Dag()
    x = dag.symbol(Kind.INPUT, 0)
    node = dag.look_up(table, x)
    f = function(dag, [directional_derivative(dag, node, {x: dag.one}) if order else node], [x])
    for at in np.random.default_rng(2).uniform(-7, 11, 60):
        assert float(f(at)) == pytest.approx(table.value(order, at), abs=1e-12)


@pytest.mark.parametrize("bicubic", [False, True])
def test_grids_have_the_values_of_ours(bicubic):
    rng = np.random.default_rng(3)
    size = len(X) * 3
    fields = tuple(array("d", rng.normal(size=size)) for _ in range(3 * bicubic))
    grid = Grid(X, array("d", [0.0, 1.0, 3.0]), array("d", rng.normal(size=size)), fields, "grid")
    dag = Dag()
    x, y = (dag.symbol(Kind.INPUT, k) for k in (0, 1))
    node = dag.look_up(grid, x, y)
    slopes = [directional_derivative(dag, node, {symbol: dag.one}) for symbol in (x, y)]
    f = function(dag, [node, *slopes], [x, y])
    for at in rng.uniform(-2, 5, (40, 2)):
        due = [grid.value(orders, *at) for orders in ((0, 0), (1, 0), (0, 1))]
        assert np.array(f(at)).ravel() == pytest.approx(due, abs=1e-11)


# --- models -----------------------------------------------------------------------------------


def test_equations_with_names_and_numbers(tmp_path):
    rlc = model(tmp_path, model_text("symbolic_models_rlc")).casadi()
    assert rlc.states == ("coil.p", "capacitor.q")
    assert rlc.inputs == ("supply.e",) and rlc.outputs == ("capacitor.e", "loop.f")
    results = rlc.function()(0, [2e-3, 3e-6], [7], [10, 1e-3, 1e-6])
    f, g, a, b, c, d = (np.array(casadi.DM(each)) for each in results)
    assert np.allclose(f, [[7 - 20 - 3], [2]]) and np.allclose(g, [[3], [2]])
    assert np.allclose(a, [[-1e4, -1e6], [1e3, 0]]) and np.allclose(b, [[1], [0]])
    assert np.allclose(c, [[0, 1e6], [1e3, 0]]) and np.allclose(d, [[0], [0]])
    assert list(rlc.start) == [0, 0] and float(casadi.evalf(rlc.given)) == 5
    assert repr(rlc) == "<bgc CasADi model: 2 states, 1 input, 2 outputs>"


def test_parameters_of_a_call_change_the_numbers_and_the_start(tmp_path):
    text = """
    model M { param v = 2 m/s; param m = 3 kg; j : J1; b : I(m, f0 = v); r : R(1 N*s/m);
      j -> b, r; }
    scene s of M { observe b.f; run 1 s; }
    """
    made = model(tmp_path, text).casadi(parameters={"v": "4 m/s"})
    assert dict(zip(made.parameters, made.values, strict=True)) == {"v": 4, "m": 3}
    assert list(made.start) == [12]


def test_a_mass_matrix_is_divided_out(tmp_path):
    text = """
    model M { param m = 2; param k = 3; state x = 1; state v = 0;
              der(x) = v; equation m*der(v) = -k*x; }
    scene s of M { observe x; run 1 s; }
    """
    made = model(tmp_path, text).casadi()
    rates = casadi.Function("rates", [made.x, made.p], [made.rates])
    found = dict(zip(made.states, np.array(rates([5, 7], [2, 3])).ravel(), strict=True))
    x, v = (dict(zip(made.states, [5, 7], strict=True))[name] for name in ("x", "v"))
    assert found == {"x": v, "v": -1.5 * x}


def test_derivatives_are_finite_where_a_norm_is_zero(tmp_path):
    text = """
    model M { state v[2] = zeros(2); der(v) = [1, 1] - norm(v)*v; }
    scene s of M { observe v; run 1 s; }
    """
    made = model(tmp_path, text).casadi()
    assert np.isfinite(np.array(casadi.evalf(casadi.substitute(made.A, made.x, [0, 0])))).all()


# A capacitor that discharges through a resistor whose law has no inverse in closed form.
ALGEBRAIC = """
model M { state q = 2; state i = 1; der(q) = -i; equation i + i^3 = q; }
scene s of M { observe q, i; run 2 s every 0.5 s; }
"""


def test_algebraic_states_go_to_idas_and_not_to_rates(tmp_path):
    ours = model(tmp_path, ALGEBRAIC)
    made = ours.casadi()
    assert refusal(getattr, made, "rates").code == "BG794"
    run = casadi.integrator("run", "idas", made.dae(), 0, 2, {"reltol": 1e-10, "abstol": 1e-12})
    found = run(x0=2, z0=1, p=made.values)
    result = ours.simulate(rtol=1e-10, atol=1e-12)
    assert float(found["xf"]) == pytest.approx(result["q"][-1], rel=1e-7)
    assert float(found["zf"]) == pytest.approx(result["i"][-1], rel=1e-7)


def test_cvodes_ends_where_our_run_does():
    folder = Path(bgc.library.__path__[0]) / "examples"
    ours = bgc.compile(folder / "gyroscope.bg")
    made = ours.casadi()
    options = {"reltol": 1e-10, "abstol": 1e-12}
    run = casadi.integrator("run", "cvodes", made.dae(), 0, 0.5, options)
    end = run(x0=made.start, p=made.values)["xf"]
    outputs = casadi.Function("g", [made.t, made.x, made.u, made.p], [made.g])
    found = np.array(outputs(0.5, end, [], made.values)).ravel()
    due = ours.simulate("0.5 s", rtol=1e-11, atol=1e-13)
    assert made.outputs
    for name, value in zip(made.outputs, found, strict=True):
        assert value == pytest.approx(due[name][-1], rel=1e-7, abs=1e-6), name


def test_generated_c_gives_the_same_numbers(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    f = model(tmp_path, model_text("symbolic_models_tanks")).casadi().function("tanks")
    f.generate("tanks.c")
    subprocess.run(
        ["cc", "-shared", "-fPIC", "-O1", "tanks.c", "-o", "tanks.so", "-lm"], check=True
    )
    other = casadi.external("tanks", "./tanks.so")
    rng = np.random.default_rng(4)
    arguments = [rng.uniform(0.5, 2, f.size_in(k)) for k in range(4)]
    for one, two in zip(f(*arguments), other(*arguments), strict=True):
        assert np.array_equal(np.array(casadi.DM(one)), np.array(casadi.DM(two)))


def test_random_numbers_are_constants(tmp_path):
    text = """
    model M { param seed = 3; state x = 0; der(x) = random(seed, 7)/1 s; }
    scene s of M { observe x; run 1 s; }
    """
    ours = model(tmp_path, text)
    assert float(casadi.evalf(ours.casadi().f)) == pytest.approx(ours.simulate()["x"][-1])


def test_refusals(tmp_path, monkeypatch):
    rlc = model(tmp_path, model_text("symbolic_models_rlc"))
    assert refusal(rlc.casadi, ["nothing.e"]).code == "BG080"
    monkeypatch.setitem(sys.modules, "casadi", None)
    assert refusal(rlc.casadi).code == "BG058"
