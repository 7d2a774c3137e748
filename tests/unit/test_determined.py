"""The user's equations: singular ones are refused, in every build; constraints show the way out."""

import re

import numpy as np
import pytest
from model_files import compiled
from refusals import refusal
from scipy.integrate import solve_ivp

from bgc.algebra.dag import Dag, Kind
from bgc.algebra.expansion import expanded_text

PENDULUM = """model P {
  param l = 2 m; param g = 9.81 m/s^2;
  state x = 2 m; state y = 0 m; state vx = 0 m/s; state vy = 0 m/s; unknown T = 1;
  der(x) = vx; der(y) = vy; der(vx) = -T*x; der(vy) = -T*y - g;
  CONSTRAINT
}
scene s of P { observe x, y, T; run 2 s every 0.1 s; solver rodas5p(rtol = 1e-10); }"""


def refused(tmp_path, text, **options):
    return refusal(lambda: compiled(tmp_path, text, **options).simulate(1.0))


def linear(rows, values=""):
    equations = " ".join(f"equation {row};" for row in rows)
    return f"""model M {{ {values} unknown z = 1; unknown y = 1; {equations}
    state x = 0; der(x) = z; }} scene s of M {{ observe x, z, y; run 1 s; }}"""


@pytest.mark.parametrize("preview", [False, True])
@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (("a*z + b*y = 1", "3*a*z + 3*b*y = 2"), "contradict each other"),
        (("a*z + b*y = 1", "3*a*z + 3*b*y = 3"), "repeat each other"),
        (("a*z + b*y = x", "3*a*z + 3*b*y = 3*x"), "repeat each other"),
        (("exp(a*z + b*y) = 2", "sin(a*z + b*y) = 0.3"), "do not determine"),
        (("z*y = 1", "log(abs(z*y)) = 2"), "do not determine"),
    ],
)
def test_equations_that_are_always_singular_are_refused(tmp_path, rows, words, preview):
    text = linear(rows, "param a = 0.1; param b = 0.3;")
    diagnostic = refused(tmp_path, text, preview=preview)
    assert diagnostic.code == "BG531" and words in diagnostic.message
    assert "`z` and `y`" in diagnostic.message
    assert rows[1] in diagnostic.span.text and rows[0] in diagnostic.labels[0].span.text


@pytest.mark.parametrize("preview", [False, True])
@pytest.mark.parametrize("d", ["0.9", "0.8999999999999999", "0.9000000000000001"])
def test_equations_that_parameters_make_singular_end_the_run(tmp_path, d, preview):
    values = f"param a = 0.1; param b = 0.3; param c = 0.3; param d = {d};"
    text = linear(("a*z + b*y = 1", "c*z + d*y = 2"), values)
    diagnostic = refused(tmp_path, text, preview=preview)
    assert diagnostic.code == "BG704" and "no unique solution" in diagnostic.message


@pytest.mark.parametrize("preview", [False, True])
@pytest.mark.parametrize(("size", "excess"), [(1e-12, 1e-5), (1.0, 1e-12), (1e12, 1e-5)])
def test_equations_that_are_nearly_singular_are_solved(tmp_path, excess, size, preview):
    text = linear(("a*z + a*y = a", f"z + {1 + excess!r}*y = 2"), f"param a = {size};")
    result = compiled(tmp_path, text, preview=preview).simulate(1.0)
    assert result["y"][-1] == pytest.approx(1 / excess, rel=1e-3)


RATES = """model M {{ state a = 3; state b = {b}; unknown z = 1;
equation der(a) + 2*der(b) = z; equation {factor}*der(a) + 6*der(b) = a; equation {last}; }}
scene s of M {{ observe a, b, z; run 1 s; }}"""


def test_rates_that_two_equations_determine(tmp_path):
    text = RATES.format(factor=1, b=0, last="z + b = 3")
    result = compiled(tmp_path, text).simulate(1.0, rtol=1e-10)

    def rates(t, x):
        return np.linalg.solve([[1, 2], [1, 6]], [3 - x[1], x[0]])

    expected = solve_ivp(rates, (0, 1), [3.0, 0.0], rtol=1e-11, atol=1e-12).y[:, -1]
    assert [result["a"][-1], result["b"][-1]] == pytest.approx(expected, rel=1e-8)


def test_equal_combinations_of_rates_leave_an_algebraic_equation(tmp_path):
    text = RATES.format(factor=3, b=2, last="z + b = 3")  # 3 z = a, hence z' = z
    result = compiled(tmp_path, text).simulate(1.0, rtol=1e-10)
    assert [result["z"][-1], result["a"][-1]] == pytest.approx([np.e, 3 * np.e], rel=1e-8)


def test_a_constraint_on_the_combination_that_rates_form_is_refused(tmp_path):
    diagnostic = refused(tmp_path, RATES.format(factor=3, b=0, last="a + 2*b = 3"))
    assert diagnostic.code == "BG531"


def test_the_derivative_that_the_message_gives_determines_the_force(tmp_path):
    diagnostic = refused(tmp_path, PENDULUM.replace("CONSTRAINT", "equation x^2 + y^2 = l^2;"))
    assert diagnostic.code == "BG531" and "twice in time" in diagnostic.help
    (found,) = re.findall(r"`(equation .*?;)`", diagnostic.help)
    result = compiled(tmp_path, PENDULUM.replace("CONSTRAINT", found)).simulate()

    def swing(t, s):
        return [s[1], -9.81 / 2 * np.sin(s[0])]

    times = result["time"]
    angle = solve_ivp(swing, (0, 2), [np.pi / 2, 0], "DOP853", times, rtol=1e-12, atol=1e-12).y[0]
    assert np.allclose(result["x"], 2 * np.sin(angle), atol=1e-6)
    assert np.allclose(result["y"], -2 * np.cos(angle), atol=1e-6)


def test_a_constraint_on_speeds_is_differentiated_once(tmp_path):
    diagnostic = refused(tmp_path, PENDULUM.replace("CONSTRAINT", "equation x*vx + y*vy = 0;"))
    assert "differentiate it in time: `equation " in diagnostic.help


@pytest.mark.parametrize(
    "constraint", ["equation x = y;", "equation x = tanh(time)*y;", "equation x = vx;"]
)
def test_a_constraint_without_a_known_derivative_shows_an_example(tmp_path, constraint):
    text = f"""model M {{ device_free : J1; a : I(1); b : R(1); device_free -> a, b;
    state x = 0; state y = 0; state vx = 0; unknown z = 0; der(x) = 1; der(y) = 2; der(vx) = 3;
    {constraint} }} scene s of M {{ observe x; run 1 s; }}"""
    diagnostic = refused(tmp_path, text)
    assert diagnostic.code == "BG531" and "x*vx + y*vy = 0" in diagnostic.help


def test_text_with_terms_and_factors_collected():
    dag = Dag()
    x, y, z = (dag.symbol(Kind.STATE, k) for k in range(3))

    def text(node, limit=300):
        return expanded_text(dag, node, lambda symbol: "xyz"[symbol.index], limit)

    product = dag.mul(x, y)
    assert text(dag.add(product, dag.mul(y, x))) == "2*x*y"
    assert text(dag.sub(dag.mul(dag.mul(x, x), x), dag.div(z, dag.mul(y, y)))) == "x^3 - z/y^2"
    assert text(dag.sub(x, x)) == "0"
    assert text(dag.neg(dag.add(x, dag.const(0.5)))) == "-x - 0.5"
    assert text(dag.mul(x, dag.add(y, dag.one))) == "x*(1 + y)"
    assert text(dag.mul(x, dag.add(y, dag.one)), 3) is None
