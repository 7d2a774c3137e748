"""Transfer functions in letters: closed forms from textbooks, and the numeric linear form."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
import sympy
from matplotlib.mathtext import MathTextParser
from refusals import code_of, refusal
from symbolic_models import GEARBOX, QUARTER_CAR, RLC, TANKS, TWINS, chain, symbolic, symbols
from sympy.parsing.latex import parse_latex

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.options import Options
from bgc.resolution.library import library_folder
from bgc.runtime.linearising.operating_point import OpenedModel
from bgc.symbolic import symbolic_model as symbolic_model
from bgc.symbolic.symbolic_model import SymbolicModel
from bgc.symbolic.transfer_latex import transfer_latex
from bgc.symbolic.transfer_text import transfer_lines, transfer_tables

MODELS = Path(__file__).parents[1] / "models"
s = sympy.Symbol("s")


# --- textbooks --------------------------------------------------------------------------------


def test_the_series_circuit_has_its_textbook_function(tmp_path):
    R, L, C = symbols("R L C")
    sym = symbolic(tmp_path, RLC)
    assert sym.transfer("capacitor.e", "supply.e") == 1 / (L * C * s**2 + R * C * s + 1)
    assert sym.transfer("loop.f", "supply.e") == C * s / (L * C * s**2 + R * C * s + 1)
    assert sym.transfer("resistor.e", "supply.e") == C * R * s / (L * C * s**2 + R * C * s + 1)


def test_a_quarter_car_has_its_textbook_function(tmp_path):
    ms, mu, ks, kt, d = symbols("ms mu ks kt d")
    found = symbolic(tmp_path, QUARTER_CAR).transfer("chassis.f", "road.f")
    spring = d * s + ks
    wheel = mu * s**2 + spring + kt
    expected = kt * spring / ((ms * s**2 + spring) * wheel - spring**2)
    assert sympy.cancel(found - expected) == 0
    top, bottom = sympy.fraction(found)
    assert sympy.gcd(top, sympy.expand(bottom)) == 1


def test_a_gearbox_reduces_the_inertia_behind_it(tmp_path):
    n, Jl, b, R, L, k, J = symbols("n Jl b motor.R motor.L motor.k motor.J")
    sym = symbolic(tmp_path, GEARBOX)
    found = sym.transfer_function("load.f", "supply.e")
    inertia, friction = J + Jl / n**2, b / n**2
    expected = k / n / ((L * s + R) * (inertia * s + friction) + k**2)
    assert sympy.cancel(found.expression - expected) == 0
    assert found.static_gain == k * n / (b * R + k**2 * n**2)
    assert found.dependent == {R: sympy.Symbol("Ra")}
    assert found.unit == "rad/(s*V)"


def test_a_factor_of_the_denominator_stays_one(tmp_path):
    m, k, kc, d = symbols("m k kc d")
    found = symbolic(tmp_path, TWINS).transfer_function("right.f", "push.e")
    together = m * s**2 + d * s + k
    assert found.expression == kc * s / (together * (m * s**2 + d * s + k + 2 * kc))
    assert found.order == 4 and len(found.poles()) == 4
    assert found.zeros() == (0,)


def test_what_the_input_does_not_reach_has_no_part_in_the_function(tmp_path):
    """A second circuit, which the output reads too: its letters do not occur."""
    text = RLC.replace(
        "loop -> coil",
        "param a = 7; param b = 3; lone : J1; other : I(a); store : C(b);\n"
        "  lone -> other, store;\n  loop -> coil",
    )
    found = symbolic(tmp_path, text).transfer_function("capacitor.e + store.e", "supply.e")
    assert set(found.ratio.field.letters) == {s, *symbols("L C R")}
    assert found.order == 2


def test_a_channel_without_an_effect_is_zero(tmp_path):
    found = symbolic(tmp_path, RLC).transfer_function("supply.f*0", "supply.e")
    assert found.expression == 0 and found.static_gain == 0
    assert found.poles() == () and found.zeros() == ()


def test_an_integrator_has_an_infinite_static_gain(tmp_path):
    text = "model M { param c = 3; param F = 1; state x = 0; der(x) = c*F; }\n"
    text += "scene s of M { observe x; run 1 s; }"
    found = symbolic(tmp_path, text).transfer_function("x", "F")
    assert found.expression == sympy.Symbol("c") / s
    assert found.static_gain is sympy.zoo
    assert found.poles() == (0,)
    assert found.static_sensitivity("c") == 0


def test_the_laplace_variable_gives_way_to_a_letter_of_the_model(tmp_path):
    text = RLC.replace("param R = 2 ohm", "param s = 2 ohm").replace("R(R)", "R(s)")
    sym = symbolic(tmp_path, text)
    assert sym.laplace == sympy.Symbol("s_")
    R, L, C, p = symbols("s L C s_")
    assert sym.transfer("capacitor.e", "supply.e") == 1 / (L * C * p**2 + R * C * p + 1)


# --- against numbers --------------------------------------------------------------------------

CASES = {
    "series circuit": (RLC, None, "capacitor.e", "supply.e", 0.0),
    "gearbox": (GEARBOX, None, "load.f", "supply.e", 0.0),
    "gearbox by its ratio": (GEARBOX, None, "load.f", "n", 1.0),
    "quarter car": (QUARTER_CAR, None, "body.e", "road.f", 0.0),
    "twins": (TWINS, None, "right.f", "push.e", 0.0),
    "five masses": (chain(5), None, "j1.f", "push.e", 0.0),
    "tanks": (TANKS, None, "h2", "Q", 0.1),
    "motor": ("dc_motor.bg", None, "shaft.f", "supply.e", 0.0),
    "loop": ("loops.bg", "ladder", "store.q", "supply.e", 0.0),
    "nonlinear bridge": ("loops.bg", "bridge", "left.e", "supply.e", 0.0),
    "diodes": ("loops.bg", "diodes", "loop.f", "supply.e", 0.0),
    "turned lever": ("loops.bg", "lever", "store.q", "supply.e", 0.1),
    "gear train": ("merged.bg", "gear_train", "output_shaft.f", "drive.e", 0.0),
    "slider": ("merged.bg", "slider", "sliding.f", "push.e", 0.2),
    "capacitors": ("merged.bg", "capacitors", "node.e", "supply.e", 0.0),
    "cylinder in space": ("actuators.bg", "cylinder", "joint.angle", "force", 0.0),
}


@pytest.mark.parametrize("case", CASES)
def test_it_equals_the_numeric_linear_form(case, tmp_path):
    """`C (s E - A)^-1 B + D` at random s, about the start and about states near it."""
    text, scene, output, input_, spread = CASES[case]
    path = MODELS / text if text.endswith(".bg") else tmp_path / "model.bg"
    if not text.endswith(".bg"):
        path.write_text(text)
    function = SymbolicModel(path, Options(scene)).transfer_function(output, input_)
    opened = OpenedModel(path, Options(scene), [input_], [output])
    point = opened.operating_point(None)
    rng = np.random.default_rng(5)
    names = [state.name for state in opened.opened.program.states]
    moved = point.state + spread * rng.random(len(names))
    linear = opened.linearise(opened.at_state(dict(zip(names, moved, strict=True)), 0.0))
    letters = {symbol.name for symbol in function.ratio.symbols}
    values = {n: float(x) for n, x in zip(names, moved, strict=True) if n in letters}
    size = max(1.0, np.abs(linear.eigenvalues()).max(initial=0.0))
    for place in rng.uniform(-1, 1, (5, 2)) * size:
        at = complex(*place)
        expected = linear.C @ np.linalg.solve(at * linear.E - linear.A, linear.B) + linear.D
        assert function.at(at, values) == pytest.approx(expected[0, 0], rel=1e-9)
    poles = np.array(function.numeric_poles(values))
    eigenvalues = linear.eigenvalues()
    distances = np.abs(poles[:, None] - eigenvalues[None, :]).min(axis=1) if len(poles) else 0.0
    assert np.all(distances <= 1e-6 * size)


def test_numbers_for_algebraic_unknowns_are_solved_for(tmp_path):
    """The scene's own numbers, not the start of a search."""
    path = MODELS / "loops.bg"
    function = SymbolicModel(path, Options("diodes")).transfer_function("loop.f", "supply.e")
    linear = bgc.compile(path, scene="diodes").linearise(["supply.e"], ["loop.f"])
    assert function.at(1.0) == pytest.approx(linear.D[0, 0], rel=1e-9)


def test_poles_and_zeros_in_closed_form_are_those_of_the_numbers(tmp_path):
    for text, output, input_ in (
        (RLC, "loop.f", "supply.e"),
        (GEARBOX, "load.f", "supply.e"),
        (TWINS, "left.f", "push.e"),
    ):
        function = symbolic(tmp_path, text).transfer_function(output, input_)
        numbers = function.symbol_numbers()
        for closed, numeric in (
            (function.poles(), function.numeric_poles()),
            (function.zeros() if text is not TWINS else (), None),
        ):
            if numeric is not None:
                found = sorted((complex(e.xreplace(numbers).evalf()) for e in closed), key=order)
                assert found == pytest.approx(sorted(numeric, key=order), rel=1e-9)


def order(root: complex) -> tuple[float, float]:
    return (round(root.real, 6), root.imag)


def test_poles_of_an_undamped_model_are_imaginary(tmp_path):
    m, k, kc = symbols("m k kc")
    damper = re.compile(r"^  r[12] .*\n|, r[12]", re.MULTILINE)
    text = damper.sub("", TWINS)
    found = symbolic(tmp_path, text).transfer_function("right.f", "push.e").poles()
    first, second = sympy.I * sympy.sqrt(k / m), sympy.I * sympy.sqrt((k + 2 * kc) / m)
    expected = {first**2, second**2}
    assert len(found) == 4 and {sympy.simplify(p**2) for p in found} == {
        sympy.simplify(e) for e in expected
    }


def test_values_change_what_follows_from_them(tmp_path):
    function = symbolic(tmp_path, GEARBOX).transfer_function("load.f", "supply.e")
    assert function.numeric_poles({"Ra": 5.0}) == function.numeric_poles({"motor.R": 5.0})
    assert function.numeric_poles({"Ra": 5.0}) != function.numeric_poles()
    assert function.numeric_poles({"Ra": 5.0, "motor.R": 2.0}) == function.numeric_poles()


# --- sensitivities ----------------------------------------------------------------------------


def test_sensitivities_of_the_series_circuit(tmp_path):
    R, L, C = symbols("R L C")
    function = symbolic(tmp_path, RLC).transfer_function("capacitor.e", "supply.e")
    for letter in (R, L, C):
        expected = sympy.diff(function.expression, letter)
        assert sympy.cancel(function.sensitivity(letter.name) - expected) == 0
    assert function.sensitivity("R") == -C * s / (L * C * s**2 + R * C * s + 1) ** 2
    pole, _ = function.poles()
    moved = function.pole_sensitivity("L").subs(s, pole)
    numbers = function.symbol_numbers()
    assert complex((moved - sympy.diff(pole, L)).xreplace(numbers).evalf()) == pytest.approx(
        0, abs=1e-6 * abs(complex(moved.xreplace(numbers).evalf()))
    )


def test_a_sensitivity_goes_by_way_of_what_follows_from_the_parameter(tmp_path):
    function = symbolic(tmp_path, GEARBOX).transfer_function("load.f", "supply.e")
    assert function.sensitivity("Ra") == function.sensitivity("motor.R") != 0
    R = sympy.Symbol("motor.R")
    assert function.static_sensitivity("Ra") == sympy.cancel(sympy.diff(function.static_gain, R))
    assert refusal(function.sensitivity, "motor.Q").code == "BG079"


def test_a_sensitivity_to_what_stands_in_a_root(tmp_path):
    function = symbolic(tmp_path, TANKS).transfer_function("h2", "Q")
    expected = sympy.diff(function.expression, sympy.Symbol("h1"))
    assert sympy.simplify(function.sensitivity("h1") - expected) == 0


# --- limits and errors ------------------------------------------------------------------------


def test_poles_of_high_degree_have_no_closed_form(tmp_path):
    function = symbolic(tmp_path, chain(3)).transfer_function("j3.f", "push.e")
    assert refusal(function.poles).code == "BG095"
    assert len(function.numeric_poles()) == 6 and len(function.zeros()) == 3


def test_a_large_function_is_refused_with_its_limit(tmp_path, monkeypatch):
    monkeypatch.setattr(symbolic_model, "MOST_TERMS", 100)
    sym = symbolic(tmp_path, chain(5))
    with pytest.raises(BgError) as error:
        sym.transfer("j5.f", "push.e")
    assert code_of(error) == "BG094" and "100 terms" in str(error.value)
    monkeypatch.setattr(symbolic_model, "MOST_TERMS", 50_000)
    monkeypatch.setattr(symbolic_model, "MOST_PRODUCTS", 1_000)
    with pytest.raises(BgError) as error:
        sym.transfer("j5.f", "push.e")
    assert code_of(error) == "BG094" and "1,000 products" in str(error.value)


def test_a_crane_is_refused_before_anything_is_computed():
    path = library_folder() / "scenes" / "two_beam_crane.bg"
    sym = SymbolicModel(path, Options())
    with pytest.raises(BgError) as error:
        sym.transfer("tip_height", "hand.position[3]")
    assert code_of(error) == "BG094" and "operations" in str(error.value)


def test_a_function_that_divides_by_zero_at_its_point_is_refused(tmp_path):
    sym = symbolic(tmp_path, TANKS).at({"h2": 0})
    assert refusal(sym.transfer, "h2", "Q").code == "BG097"


def test_equations_that_do_not_determine_their_unknown_have_no_function(tmp_path):
    text = "model M { param u = 1; unknown z = 1; equation z^3 = u; }\n"
    text += "scene s of M { observe z; run 1 s; }"
    sym = symbolic(tmp_path, text)
    z = sympy.Symbol("z")
    assert sympy.cancel(sym.transfer("z", "u") - 1 / (3 * z**2)) == 0
    assert refusal(lambda: sym.at({"z": 0}).transfer("z", "u")).code == "BG096"


def test_wrong_names_are_refused(tmp_path):
    sym = symbolic(tmp_path, RLC)
    for output, input_, code in (
        ("capacitor.e", "suply.e", "BG080"),
        ("capacitor.x", "supply.e", "BG419"),
    ):
        assert refusal(sym.transfer, output, input_).code == code
    with pytest.raises(BgError) as error:
        sym.transfer_function("capacitor.e", "supply.e").numeric_poles({"Q": 1.0})
    assert code_of(error) == "BG079"


def test_letters_of_the_users_own_need_numbers(tmp_path):
    function = symbolic(tmp_path, TANKS).at({"h1": sympy.Symbol("H")}).transfer_function("h2", "Q")
    assert refusal(function.numeric_poles).code == "BG076"
    at_start = symbolic(tmp_path, TANKS).transfer_function("h2", "Q")
    assert function.numeric_poles({"H": 0.3}) == pytest.approx(at_start.numeric_poles())


# --- as text ----------------------------------------------------------------------------------


@pytest.mark.parametrize("width", [80, 200])
def test_lines_fit_the_terminal(tmp_path, width):
    function = symbolic(tmp_path, chain(4)).transfer_function("j4.f", "push.e")
    lines = transfer_lines(function, width, full=False)
    assert max(map(len, lines)) <= width
    assert any(len(line) > 0.75 * width for line in lines)


def test_a_fraction_is_drawn_where_it_fits(tmp_path):
    function = symbolic(tmp_path, RLC).transfer_function("capacitor.e", "supply.e")
    assert transfer_lines(function, 80, full=False) == [
        "capacitor.e by supply.e",
        "",
        "                  1",
        "  G(s) = -------------------",
        "         L*C*s^2 + R*C*s + 1",
    ]
    narrow = transfer_lines(function, 24, full=False)
    assert narrow[2:] == ["  G(s) = 1/D", "", "  D = L*C*s^2 + R*C*s", "      + 1"]


@pytest.mark.parametrize("name", ["RLC", "car", "chain", "tanks", "twins"])
def test_printed_polynomials_are_those_of_the_function(tmp_path, name):
    """The lines are read back by SymPy, each letter under a name that it takes."""
    text, output, input_ = {
        "RLC": (RLC, "capacitor.e", "supply.e"),
        "car": (QUARTER_CAR, "chassis.f", "road.f"),
        "chain": (chain(4), "j2.f", "push.e"),
        "tanks": (TANKS, "h2", "Q"),
        "twins": (TWINS, "left.f", "push.e"),
    }[name]
    function = symbolic(tmp_path, text).transfer_function(output, input_)
    _, _, *lines = transfer_lines(function, 24, full=True)
    whole = re.sub(r"\n   +", " ", "\n".join(lines).replace("\n\n", "\n"))
    pairs = [line.strip().split(" = ") for line in whole.splitlines()]
    letters = {symbol.name for symbol in function.ratio.symbols}
    names = {name: sympy.Symbol(name) for name in (*letters, *(left for left, _ in pairs))}
    read = {left: sympy.sympify(right.replace("^", "**"), names) for left, right in pairs}
    known = {sympy.Symbol(left): e for left, e in read.items()}
    point = {x: sympy.Integer(sympy.prime(k + 3)) for k, x in enumerate(function.ratio.symbols)}
    found = {x: e.subs(point) for x, e in known.items()}  # exact: roots of primes are independent
    assert sympy.simplify(read["G(s)"].subs({**found, **point})) == sympy.simplify(
        function.expression.subs(point)
    )


def test_tables_show_formulas_and_numbers(tmp_path):
    function = symbolic(tmp_path, GEARBOX).transfer_function("load.f", "supply.e")
    first, second = transfer_tables(function, {}, full=False)
    assert first.rows[0] == (
        "static gain", "n*motor.k/(n^2*motor.k^2 + b*motor.R)", "0.833333", "rad/(s*V)",
    )  # fmt: skip
    assert first.rows[1][1].endswith("characters; --full prints them")
    assert first.rows[1][2] == "-1997.91, -2.50261"
    assert ("motor.R", "2", "ohm", "Ra") in second.rows
    full, _ = transfer_tables(function, {}, full=True)
    assert "+- sqrt(" in full.rows[1][1]


def test_a_function_in_latex_is_read_by_sympy_as_it_is(tmp_path):
    function = symbolic(tmp_path, RLC).transfer_function("loop.f", "supply.e")
    lines = dict(
        line.strip().removesuffix(r" \\").split(" &= ")
        for line in transfer_latex(function, {}, full=False).splitlines()
        if "&=" in line
    )
    found = parse_latex(lines["G(s)"].replace(r"\,", r" \cdot "), backend="lark")
    assert sympy.cancel(found - function.expression) == 0
    assert lines["p_{1,2}"].endswith(r"\approx -1000 \pm 9949.87i") and lines["z_{1}"] == "0"


@pytest.mark.parametrize("text", [GEARBOX, QUARTER_CAR, TANKS, TWINS, chain(3)])
def test_mathtext_takes_every_line(tmp_path, text):
    sym = symbolic(tmp_path, text)
    input_ = {GEARBOX: "supply.e", QUARTER_CAR: "road.f", TANKS: "Q"}.get(text, "push.e")
    function = sym.transfer_function(sym.outputs[0].name, input_)
    _, _, *lines, _ = transfer_latex(function, {}, full=True).splitlines()
    parser = MathTextParser("path")
    for line in lines:
        parser.parse(f"${line.strip().removesuffix(chr(92) * 2).replace('&', '').strip()}$")
    assert len(lines) >= 3


def test_numbers_that_are_undefined_do_not_hide_the_formula(tmp_path):
    text = "model M { param a = 2; param F = 1; state x = 0; der(x) = F - a*x*log(x); }\n"
    text += "scene s of M { observe x; run 1 s; }"
    function = symbolic(tmp_path, text).transfer_function("x", "F")
    table, _ = transfer_tables(function, {}, full=False)
    assert table.rows[0][2] == "undefined" and "log(x)" in table.rows[0][1]
    assert r"\log" in transfer_latex(function, {}, full=False)


def test_names_for_parts_of_a_formula_are_not_the_models(tmp_path):
    text = QUARTER_CAR.replace("kt", "N").replace("ks", "D1")
    function = symbolic(tmp_path, text).transfer_function("chassis.f", "road.f")
    lines = transfer_lines(function, 40, full=False)
    assert "  G(s) = N*Num/Den" in lines


def test_long_polynomials_are_counted_unless_all_is_asked_for(tmp_path):
    function = symbolic(tmp_path, chain(6)).transfer_function("j6.f", "push.e")
    short, whole = (len("\n".join(transfer_lines(function, 80, full))) for full in (False, True))
    assert short < 1_000 and whole > 50_000
    assert "--full" in transfer_latex(function, {}, full=False)
