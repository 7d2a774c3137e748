"""Equations and linear forms in letters, and the algebra of polynomials behind them."""

from __future__ import annotations

import itertools
import random

import numpy as np
import pytest
import sympy
from refusals import code_of, refusal
from symbolic_models import GEARBOX, QUARTER_CAR, RLC, TANKS, chain, symbolic, symbols
from sympy import ZZ
from sympy.polys.rings import PolyElement, ring

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.symbolic import system as symbolic_system
from bgc.symbolic.determinants import Budget, determinant_factors
from bgc.symbolic.factors import common_factor, divided, split
from bgc.symbolic.quotients import Field
from bgc.symbolic.roots import numeric_roots

# --- equations --------------------------------------------------------------------------------


def test_equations_are_in_the_models_own_letters(tmp_path):
    R, L, C, e, p, q = symbols("R L C supply.e coil.p capacitor.q")
    sym = symbolic(tmp_path, RLC)
    assert (sym.parameters, sym.states, sym.inputs) == ((R, L, C), (p, q), (e,))
    assert sym.outputs == symbols("capacitor.e loop.f")
    assert sym.f == sympy.Matrix([e - R * p / L - q / C, p / L])
    assert sym.g == sympy.Matrix([q / C, p / L])
    assert sympy.eye(2) == sym.M
    assert sympy.Matrix([[-R / L, -1 / C], [1 / L, 0]]) == sym.A
    assert sympy.Matrix([1, 0]) == sym.B
    assert sympy.Matrix([[0, 1 / C], [1 / L, 0]]) == sym.C
    assert sympy.zeros(2, 1) == sym.D
    assert sym.start == {p: 0, q: 0} and sym.dependent == {}
    assert sym.values[e] == 5.0 and sym.values[L] == 1e-3


def test_inputs_of_ones_own_leave_the_others_as_the_scene_has_them(tmp_path):
    R, L, C, p, q = symbols("R L C coil.p capacitor.q")
    sym = symbolic(tmp_path, RLC, ["R"], ["coil.e"])
    assert sym.f[0] == 5 - R * p / L - q / C
    assert sympy.Matrix([-p / L, 0]) == sym.B
    assert sympy.Matrix([[-R / L, -1 / C]]) == sym.C
    assert sympy.Matrix([[-p / L]]) == sym.D


def test_linear_forms_agree_with_derivatives_by_sympy(tmp_path):
    """A and B come from the compiler's derivative rules; SymPy differentiates f itself."""
    for text in (GEARBOX, QUARTER_CAR, TANKS, chain(3)):
        sym = symbolic(tmp_path, text)
        assert sympy.simplify(sym.f.jacobian(sym.states) - sym.A).is_zero_matrix
        assert sympy.simplify(sym.g.jacobian(sym.states) - sym.C).is_zero_matrix
        if sym.inputs:
            assert sympy.simplify(sym.f.jacobian(sym.inputs) - sym.B).is_zero_matrix


def test_derivatives_by_parameters(tmp_path):
    sym = symbolic(tmp_path, RLC)
    for name in "RLC":
        letter = sympy.Symbol(name)
        assert sym.rates_by(name) == sym.f.diff(letter)
        assert sym.outputs_by(name) == sym.g.diff(letter)
    assert refusal(sym.rates_by, "coil.L").code == "BG079"


def test_derivatives_go_by_way_of_what_follows_from_a_parameter(tmp_path):
    text = RLC.replace("param C = 10 uF;", "param a = 2; param C = 10 uF * a^2;")
    sym = symbolic(tmp_path, text)
    a, C = symbols("a C")
    assert sym.dependent == {C: a**2 / 100_000}
    assert sympy.simplify(sym.rates_by("a") - sym.f.diff(C) * a / 50_000).is_zero_matrix
    inner = symbolic(tmp_path, GEARBOX)
    assert inner.rates_by("Ra") == inner.rates_by("motor.R") != sympy.zeros(2, 1)


def test_a_mass_matrix_is_shown(tmp_path):
    text = """
    model M { param m = 2; param k = 3; state x = 1; state v = 0;
              der(x) = v; equation m*der(v) = -k*x; }
    scene s of M { observe x; run 1 s; }
    """
    sym = symbolic(tmp_path, text)
    m, k, x, v = symbols("m k x v")
    assert sym.M * sympy.Matrix([1, 1]) in (sympy.Matrix([1, m]), sympy.Matrix([m, 1]))
    assert set(sym.f) == {v, -k * x}


def test_a_source_that_follows_the_states_keeps_its_law(tmp_path):
    text = RLC.replace("Se(e = 5 V)", "MSe(e = 5 V - 0.1*capacitor.e)")
    sym = symbolic(tmp_path, text)
    assert sym.inputs == ()
    C, q, e = symbols("C capacitor.q supply.e")
    chosen = symbolic(tmp_path, text, ["supply.e"])
    assert chosen.f[0].coeff(q) == -sympy.Rational(11, 10) / C
    assert chosen.f[0].coeff(e) == 1 and chosen.values[e] == 0.0


def test_a_prescribed_motion_whose_rate_is_needed_stays_as_it_is(tmp_path):
    text = """
    model M { param v = 2; push : Sf(f = v*sin(time)); j : J1; mass : I(3); push -> j -> mass; }
    scene s of M { observe mass.e; run 1 s; }
    """
    sym = symbolic(tmp_path, text)
    assert sym.inputs == ()
    assert sym.g[0] == 3 * sympy.Symbol("v") * sympy.cos(sympy.Symbol("time"))


def test_a_source_beside_jumps_is_an_input(tmp_path):
    ball = """model Ball {
      mass : I(1 kg); flight : J1; weight : Se(-9.81 N); weight -> flight -> mass;
      when flight.f < -1 m/s { reset mass.p = -0.5*mass.p; }
    }
    scene bounce of Ball { observe flight.f; run 1 s; }"""
    sym = symbolic(tmp_path, ball)
    (weight,) = sym.inputs
    assert list(sym.f) == [weight]
    assert sym.values[weight] == -9.81


def test_multiples_of_pi_are_recognised(tmp_path):
    text = """
    model M { param a = 1; state x = 0; der(x) = -2*pi*a*x + 30 deg; }
    scene s of M { observe x; run 1 s; }
    """
    a, x = symbols("a x")
    assert symbolic(tmp_path, text).f[0] == sympy.pi / 6 - 2 * sympy.pi * a * x


def test_equations_that_are_too_long_are_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(symbolic_system, "MOST_OPERATIONS", 5)
    with pytest.raises(BgError) as error:
        _ = symbolic(tmp_path, RLC).f
    assert code_of(error) == "BG094" and "the limit is 5" in str(error.value)


# --- operating points -------------------------------------------------------------------------


def test_an_equilibrium_in_letters(tmp_path):
    A1, A2, c1, c2, Q, h1, h2 = symbols("A1 A2 c1 c2 Q h1 h2")
    sym = symbolic(tmp_path, TANKS)
    found = sym.equilibrium()
    assert found == {h1: Q**2 / c1**2, h2: Q**2 / c2**2}
    at_rest = sym.at({str(x): e for x, e in found.items()})
    assert at_rest.A[0, 0] == -(c1**2) / (2 * A1 * Q)
    s = sympy.Symbol("s")
    expected = 2 * Q * c1**2 / ((2 * A1 * Q * s + c1**2) * (2 * A2 * Q * s + c2**2))
    assert at_rest.transfer("h2", "Q") == expected


def test_of_several_equilibria_the_nearest_is_taken(tmp_path):
    text = """
    model M { param a = 4; state x = 1; der(x) = a - x^2; }
    scene s of M { observe x; run 1 s; }
    """
    a, x = symbols("a x")
    sym = symbolic(tmp_path, text)
    assert sym.equilibrium() == {x: sympy.sqrt(a)}
    assert sym.equilibrium({"x": -1.0}) == {x: -sympy.sqrt(a)}


def test_an_equilibrium_without_a_formula_is_refused(tmp_path):
    text = """
    model M { state x = 1; state y = 2; der(x) = cos(x) - x*y; der(y) = exp(-x) - y; }
    scene s of M { observe x; run 1 s; }
    """
    assert refusal(lambda: symbolic(tmp_path, text).equilibrium()).code == "BG099"
    free = "model M { state x = 1; der(x) = 1; } scene s of M { observe x; run 1 s; }"
    with pytest.raises(BgError) as error:
        symbolic(tmp_path, free).equilibrium()
    assert code_of(error) == "BG099" and "`x`" in str(error.value)


def test_points_of_numbers_and_of_the_start(tmp_path):
    c1, A1 = symbols("c1 A1")
    sym = symbolic(tmp_path, TANKS)
    assert sym.at({"h1": 4}).A[0, 0] == -c1 / (4 * A1)
    started = sym.at({str(x): e for x, e in sym.start.items()})
    assert started.A[0, 0] == -c1 / (2 * A1 * sympy.sqrt(sympy.Rational(3, 10)))
    assert refusal(sym.at, {"h3": 4}).code == "BG079"
    with pytest.raises(BgError) as error:
        _ = sym.at({"h1": 0}).A
    assert code_of(error) == "BG097"


def test_a_model_gives_its_letters(tmp_path):
    path = tmp_path / "tanks.bg"
    path.write_text(TANKS)
    model = bgc.compile(path)
    A1, c1, Q, h1 = symbols("A1 c1 Q h1")
    assert model.symbolic().A[0, 0] == -c1 / (2 * A1 * sympy.sqrt(h1))
    assert model.symbolic(at="steady").A[0, 0] == -(c1**2) / (2 * A1 * Q)
    assert h1 not in model.symbolic(at="start").A[0, 0].free_symbols
    assert h1 not in model.symbolic(at=1.0).A[0, 0].free_symbols
    assert model.symbolic(at={"h1": sympy.Symbol("H")}).A[0, 0].has(sympy.Symbol("H"))
    assert model.symbolic(parameters={"A1": 7}).values[A1] == 7.0
    now = model.symbolic(["Q"], ["h1"], at=1.0).transfer_function("h1", "Q").at(0.01j)
    linear = model.linearise(["Q"], ["h1"], at=1.0)
    assert now == pytest.approx(linear.response(np.array([0.01]))[0, 0, 0], rel=1e-6)


# --- polynomials ------------------------------------------------------------------------------

R5, *GENERATORS = ring("x y z u v", ZZ)


def random_polynomial(rng: random.Random, terms: int, degree: int = 2) -> PolyElement:
    found = R5.zero
    while not found:
        for _ in range(terms):
            term = R5(rng.choice([-7, -2, -1, 1, 3, 6]))
            for generator in rng.sample(GENERATORS, rng.randint(0, 3)):
                term *= generator ** rng.randint(1, degree)
            found += term
    return found


def up_to_sign(polynomial: PolyElement) -> PolyElement:
    return -polynomial if polynomial.LC < 0 else polynomial


@pytest.mark.parametrize("seed", range(40))
def test_common_factors_are_those_of_sympy(seed):
    rng = random.Random(seed)
    a, b, c = (random_polynomial(rng, rng.randint(1, 4)) for _ in range(3))
    pair = (a * c, b * c) if seed % 4 else (a, b)
    assert up_to_sign(common_factor(*pair)) == up_to_sign(pair[0].gcd(pair[1]))
    simple, rest = split(pair[0])
    assert simple * rest == pair[0] and rest.LC > 0 and len(simple) == 1
    assert divided(a * c, c) == a


def test_common_factors_of_zero():
    x, *_ = GENERATORS
    assert common_factor(R5.zero, 2 * x) == 2 * x
    assert common_factor(2 * x, R5.zero) == 2 * x


def budget() -> Budget:
    return Budget(10**7, 10**5, AssertionError)


@pytest.mark.parametrize("seed", range(25))
def test_determinants_are_those_of_the_formula_of_leibniz(seed):
    rng = random.Random(seed)
    size = rng.randint(1, 5)
    rows = [
        {c: random_polynomial(rng, 2) for c in range(size) if rng.random() < 0.5}
        for _ in range(size)
    ]
    expected = R5.zero
    for permutation in itertools.permutations(range(size)):
        crossed = sum(a > b for a, b in itertools.combinations(permutation, 2))
        term = R5(-1 if crossed % 2 else 1)
        for row, column in zip(rows, permutation, strict=True):
            term *= row.get(column, R5.zero)
        expected += term
    factors = determinant_factors(rows, R5, budget())
    product = R5.one if factors is not None else R5.zero
    for factor in factors or ():
        product *= factor
    assert product == expected


def test_a_determinant_of_blocks_is_a_product_of_theirs():
    x, y, z, u, v = GENERATORS
    rows = [{0: x, 1: y}, {0: z, 1: u}, {0: v, 2: x + y}]
    factors = determinant_factors(rows, R5, budget())
    assert sorted(map(len, factors)) == [1, 2, 2]
    assert determinant_factors([{0: x}, {0: y}], R5, budget()) is None
    assert determinant_factors([], R5, budget()) == [R5.one]


@pytest.mark.parametrize("seed", range(20))
def test_quotients_have_the_value_of_their_expression(seed):
    rng = random.Random(seed)
    a, b, c, d = symbols("a b c d")
    parts = [a, b, c, d, sympy.cos(a), sympy.sqrt(b + 2), sympy.Integer(3), sympy.pi]
    for _ in range(8):
        p, q = rng.sample(parts, 2)
        make = rng.choice(
            [
                lambda p, q: p + q,
                lambda p, q: p - 2 * q,
                lambda p, q: p * q,
                lambda p, q: p / (q + 5),
                lambda p, q: (p + q) ** -2,
            ]
        )
        parts.append(make(p, q))
    expression = parts[-1]
    field = Field([expression], (d, c), None)
    quotient = field.of(expression)
    back = field.expression(quotient.above)
    for factor in field.factors(quotient.below):
        back /= field.expression(factor)
    values = {a: 0.3, b: 1.7, c: -2.1, d: 0.9}
    expected = complex(expression.subs(values).evalf())
    assert complex(back.subs(values).evalf()) == pytest.approx(expected, rel=1e-9)


def test_a_division_by_what_vanishes_is_noticed():
    a, b = symbols("a b")
    expression = 1 / ((a + b) ** 2 - a**2 - 2 * a * b - b**2)
    with pytest.raises(ZeroDivisionError):
        Field([expression], (), None).of(expression)


def test_moduli_and_signs_are_one_letter():
    (x,) = symbols("x")
    sign = sympy.sign(x)
    expression = sympy.Abs(x) + x * sign**3 + sign**2 + 1 / sign
    field = Field([expression], (), None)
    quotient = field.of(expression)
    assert field.expression(quotient.above) == 2 * sympy.Abs(x) + 1 + sign
    assert field.factors(quotient.below) == [field.ring.one]


def test_multiple_and_stiff_roots_are_found_to_the_last_digit():
    s = sympy.Symbol("s")
    polynomial = sympy.Poly((s + 3) ** 3 * (s**2 + sympy.Rational(1, 10**12)) * (s + 10**9), s)
    coefficients = [sympy.Rational(c) for c in polynomial.all_coeffs()]
    roots = numeric_roots([c.p / sympy.Integer(c.q) for c in coefficients])
    assert roots[0] == pytest.approx(-1e9, rel=1e-14)
    assert roots[1:4] == pytest.approx([-3.0] * 3, rel=1e-14)
    assert roots[4:] == pytest.approx([-1e-6j, 1e-6j], rel=1e-12)
