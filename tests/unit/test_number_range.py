"""Numbers at the edges of the range of doubles: a model compiles, or is refused with a code.

Constants are folded as exact rationals, whose products and quotients may leave that range.
"""

import math
from pathlib import Path

import pytest
from refusals import refusal

from bgc.algebra.dag import Level
from bgc.algebra.evaluate import evaluate_nodes
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.ir.fields import nodes_of
from bgc.options import Options
from bgc.resolution.resolve import load_text

NUMBERS = (
    "5e-324", "1e-320", "1e-308", "1e-200", "1e-160", "1e160", "1e200", "1e308", "1.7e308"
)  # fmt: skip
MODELS = [
    "s : Se(e = 5); j : J1; b : I(X); r : R(1); s -> j; j -> b, r;",
    "s : Se(e = X); j : J1; b : I(1); r : R(1); s -> j; j -> b, r;",
    "s : Se(e = 5); j : J1; b : I(2); r : R(X); s -> j; j -> b, r;",
    "s : Se(e = 5); j : J1; b : I(2); r : R(conductance = X); s -> j; j -> b, r;",
    "s : Se(e = 5); j : J1; b : C(X); r : R(1); s -> j; j -> b, r;",
    "s : Se(e = 5); j : J1; b : C(stiffness = X); r : R(1); s -> j; j -> b, r;",
    "s : Se(e = 5); j : J1; b : I(1); r : R(1); t : TF(X); s -> t -> j; j -> b, r;",
    "s : Se(e = 5); j : J1; b : I(1); r : R(1); t : GY(X); s -> t -> j; j -> b, r;",
    "s : Se(e = 5); j : J1; b : I(1); c : I(2); k : J1; t : TF(X); s -> j; j -> b; "
    "j -> t -> k; k -> c;",
    "s : Se(e = X*X); j : J1; b : I(1); r : R(1); s -> j; j -> b, r;",
    "s : Se(e = 1/X); j : J1; b : I(1); r : R(1); s -> j; j -> b, r;",
    "state x = X; der(x) = -X*x;",
    "param k = X; state x = 1; der(x) = -k*x;",
    "const k = X*X*X; state x = 1; der(x) = -k*x;",
    "param k = X*X; state x = 1; der(x) = -k*x;",
    "state x = 1; der(x) = -X*(X*x);",
    "state x = 1; der(x) = -x + exp(X) - exp(X);",
    "unknown z = 1; equation X*z = 5; state x = 1; der(x) = -x+z;",
    "s : Se[2](e = 5); b : I[2]([[X, 0.1*X], [0.1*X, X]]); s -> b;",
    "param a = X; s : Se[2](e = 5); b : I[2]([[a, 0.1*a], [0.1*a, a]]); s -> b;",
    "param a = X; s : Se(e = 5); j : J1; b : I(a); c : I(2*a); r : R(a); s -> j; j -> b, c, r;",
    "s : Se(e = 5 kN); j : J1; b : I(X t); r : R(1); s -> j; j -> b, r;",
    "s : Se(e = 5); j : J1; b : I { f = p/X; } r : R(1); s -> j; j -> b, r;",
    "s : Se(e = 5); j : J1; b : I { H = X*p^2; } r : R { e = X*f + X*abs(f)*f; } s -> j; "
    "j -> b, r;",
    "s : Se(e = 5); j : J0; b : R { e = X*f + X*f^3; } r : R { e = f^3 + 2*X*X*f; "
    "} s -> j; j -> b, r;",
]


def stages(body: str, until: str):
    package = load_text(f"model M {{ {body} }}", "m.bg")
    return compile_scene(Path("m.bg"), Options(), package=package, until=until)


@pytest.mark.parametrize("number", NUMBERS)
@pytest.mark.parametrize("body", MODELS)
def test_every_constant_of_a_compiled_model_is_a_double(body, number):
    text = body.replace("X", number)
    try:
        program = stages(text, "emit").equations
    except BgError as err:
        # a mass behind a modulus below 1e-162 is zero as a double: BG513
        assert {d.code for d in err.diagnostics} <= {"BG333", "BG513", "BG540"}
        assert all(d.span is not None for d in err.diagnostics)
        return
    dag = program.dag
    constants = [n for n in dag.reachable(nodes_of(program)) if dag.level[n] == Level.CONST]
    values = evaluate_nodes(dag, constants, {})
    assert all(map(math.isfinite, values))
    assert all(x for n, x in zip(constants, values, strict=True) if dag.value(n))


@pytest.mark.parametrize("sizes", [("1e-320", "BG540"), ("1e-200", None), ("1e300", None)])
def test_a_small_mass_is_refused_only_where_its_reciprocal_overflows(sizes):
    number, code = sizes
    body = "s : Se(e = 5); j : J1; b : I(X kg); r : R(1); s -> j -> b, r;".replace("X", number)
    if code is None:
        assert stages(body, "emit").equations.states[0].name == "b.p"
    else:
        diagnostic = refusal(stages, body, "equations")
        assert diagnostic.code == code and diagnostic.span.text.startswith("b")
