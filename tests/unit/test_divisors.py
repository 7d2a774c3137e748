"""Parameters that the equations divide by: zero is refused wherever a quotient shows it.

At run time by BG707 before the first step, as a constant when the model is compiled.
"""

import numpy as np
import pytest
from refusals import codes_of, refusal, refusals

import bgc

# Bodies with a divisor X, and the parameter or expression that the message names.
DIVIDING = {
    "resistor by its conductance": ("s : Sf(f = 5); r : R(conductance = X); s -> r;", "r.e", "X"),
    "inertia by its law": ("s : Se(e = 5); r : I { f = p/X; } s -> r;", "r.f", "X"),
    "inertia by its energy": ("s : Se(e = 5); r : I { H = p^2/(2*X); } s -> r;", "r.f", "X"),
    "orifice": ("s : Se(e = 5); r : R { e = X*abs(f)*f; } s -> r;", "r.f", "X"),
    "stiffnesses in parallel": (
        "s : Sf(f = 5); r : C(stiffness = X); q : C(stiffness = X); j : J0; s -> j -> r, q;",
        "r.e",
        "2*X",
    ),
    "rate over a constant": ("state y = 0; der(y) = 1/X;", "y", "X"),
    "rate over a square root": ("state y = 1; der(y) = -y/sqrt(X);", "y", "X"),
    "rate over a difference": ("state y = 0; der(y) = 1/(2*X - X^2);", "y", "2*X - X^2"),
    "negative power": ("state y = 0; der(y) = X^(-1.5);", "y", "X"),
    "itself": ("state y = 0; der(y) = X/X;", "y", "X"),
    "argument of a function": ("state y = 1; der(y) = tanh(y/X);", "y", "X"),
    "unit vector": (
        "state y = 1; let v = [X, 0]; let u = v/norm(v); der(y) = u[1]*y;",
        "y",
        "X",
    ),
    "inverse matrix": ("state y = 1; let W = inv([[X, 0], [0, 1]]); der(y) = W[1, 1];", "y", "X"),
    "initial value": ("state y = 1/X; der(y) = -y;", "y", "X"),
    "output": ("state y = 0; der(y) = 1; output w = 1/X;", "w", "X"),
    "energy of both kinds": (
        "s : Se(e = 1); c : IC { H = p^2/(2*X) + q^2; } s -> c;",
        "c.p",
        "X",
    ),
}

# Bodies where zero is a legal value of X.
SOUND = {
    "branch that excludes zero": "state y = 0; der(y) = if X > 0 then 1/X else 0;",
    "springs in series": "state y = 0; der(y) = 1/(1/X + 1/3);",
    "limit": "state y = 0; param far = 3; der(y) = min(far, 2/X);",
    "no stiffness": "state y = 0; der(y) = 1; s : Sf(f = 1); c : C(stiffness = X); s -> c;",
    "infinite mass": "state y = 0; der(y) = 1; s : Se(e = 1); c : I { H = X*p^2; } s -> c;",
    "divisor plus one": "state y = 0; der(y) = 1/(1 + X);",
    "product": "state y = 0; der(y) = X*1 + 1;",
}


def text(body, declaration, observed, extra=""):
    return (
        f"model M {{ {declaration} {body} }}\n"
        f"scene s of M {{ observe {observed}; {extra} run 0.1 s; }}"
    )


@pytest.fixture
def compiled(tmp_path):
    def of(model):
        path = tmp_path / "m.bg"
        path.write_text(model)
        return bgc.compile(path)

    return of


@pytest.mark.parametrize("case", DIVIDING)
def test_zero_for_a_divisor_is_refused_when_a_run_sets_it(compiled, case):
    body, observed, named = DIVIDING[case]
    model = compiled(text(body, "param X = 1;", observed))
    assert np.isfinite(model.simulate().columns[observed]).all()
    diagnostic = refusal(model.simulate, parameters={"X": 0.0})
    assert diagnostic.code == "BG707" and f"`{named}` must not be zero" in diagnostic.message
    assert diagnostic.help == "change `X`"


@pytest.mark.parametrize("case", DIVIDING)
def test_zero_for_a_divisor_is_refused_as_the_default_and_as_a_constant(compiled, case):
    body, observed, _ = DIVIDING[case]
    if case != "stiffnesses in parallel":  # refused when it is compiled
        model = compiled(text(body, "param X = 0;", observed))
        assert codes_of(model.simulate) == ["BG707"]
    for constant in (
        text(body, "const X = 0;", observed),
        text(body, "param X = 1;", observed, "set X = 0;"),
    ):
        found = refusals(lambda t: compiled(t).simulate(), constant)
        allowed = {"BG334", "BG350", "BG511", "BG512", "BG520", "BG540", "BG703"}
        assert {d.code for d in found} <= allowed


@pytest.mark.parametrize("case", SOUND)
def test_zero_is_accepted_where_no_result_is_infinite(compiled, case):
    model = compiled(text(SOUND[case], "param X = 1;", "y"))
    result = model.simulate(parameters={"X": 0.0})
    assert np.isfinite(result["y"]).all()


def test_the_place_of_a_division_by_zero_that_a_scene_sets_is_underlined(compiled):
    model = text("state y = 0; der(y) = 3 + y + 7/X;", "param X = 1;", "y", "set X = 0;")
    diagnostic = refusal(compiled, model)
    assert diagnostic.code == "BG334" and diagnostic.span.text == "7/X"


def test_a_quotient_that_cancels_is_watched_during_the_run(compiled):
    model = compiled(text("state y = Y; der(y) = y/y;", "param Y = 1;", "y"))
    assert model.simulate()["y"][-1] == pytest.approx(1.1)
    diagnostic = refusal(model.simulate, parameters={"Y": 0.0})
    assert diagnostic.code == "BG705" and "`y/y` divides by zero" in diagnostic.message
    assert diagnostic.span.text == "y/y"


def test_a_long_expression_is_checked_as_well(compiled):
    body = """param k[4] = [1, 2, 3, 4]; state y[4] = [1, 0, 0, 0];
    let W = inv([[1 + k[1], k[2], k[3], 0], [k[2], 1 + k[3], k[4], k[1]],
                 [k[3], k[4], 2 + k[1], 1], [0, k[1], 1, X]]);
    der(y) = W*y;"""
    model = compiled(text(body, "param X = 5;", "y"))
    model.simulate()
    zeros = {"k[1]": -1.0, "k[2]": 0.0, "k[3]": 0.0, "X": 1.0}
    diagnostic = refusal(model.simulate, parameters=zeros)
    assert diagnostic.code == "BG707"
    assert "an expression of `X` and `k` must not be zero" in diagnostic.message


@pytest.mark.parametrize("solver", [{}, {"solver": "ros34prw", "step": 0.01}])
def test_an_ensemble_refuses_the_instances_that_divide_by_zero(compiled, solver):
    body = "state y = 1; state z = 1; der(y) = -y/X; der(z) = -z;"
    model = compiled(text(body, "param X = 1;", "y, z"))
    ensemble = model.simulate_many({"X": [1.0, 2.0, 0.0, 3.0, 0.0, 4.0, 5.0, 6.0]}, **solver)
    assert {k: why.code for k, why in ensemble.failures.items()} == {2: "BG707", 4: "BG707"}
    assert list(np.flatnonzero(~ensemble.done)) == [2, 4]
    assert np.isfinite(ensemble.values[ensemble.done]).all()
