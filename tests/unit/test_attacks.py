"""Models that were once answered wrongly, or not at all."""

import numpy as np
import pytest
from refusals import refusal

import bgc
from bgc.diagnostics.diagnostic import BgError


@pytest.fixture
def simulate(tmp_path):
    def simulate_text(text: str, **options):
        path = tmp_path / "attack.bg"
        path.write_text(text)
        return bgc.compile(path).simulate(**options)

    return simulate_text


def codes(error: pytest.ExceptionInfo[BgError]) -> list[str]:
    return [diagnostic.code for diagnostic in error.value.diagnostics]


def test_a_model_of_algebraic_equations_alone_is_solved_and_not_integrated(simulate):
    result = simulate(
        "model M { unknown x = 1; equation x^3 + 2*x = 6 + time; }"
        "scene run_it of M { observe x; run 1 s; }"
    )
    np.testing.assert_allclose(result["x"] ** 3 + 2 * result["x"], 6 + result.time, rtol=1e-6)


def test_given_charges_of_parallel_compliances_that_agree_hold(simulate):
    result = simulate(
        "model M { j : J0; a : C(1, q0 = 1); b : C(2, q0 = 2); r : R(1); j -> a, b, r; }"
        "scene run_it of M { observe b.q; run 1 s; }"
    )
    np.testing.assert_allclose(result["b.q"], 2 * np.exp(-result.time / 3), rtol=1e-4)


def test_a_given_charge_holds_beside_the_source_that_drives_the_compliances(simulate):
    result = simulate(
        "model M { v : Se(e = 5); j : J1; a : C(1, q0 = 1); b : C(2); v -> j -> a, b; }"
        "scene run_it of M { observe a.q, b.q; run 1 s; }"
    )
    np.testing.assert_allclose([result["a.q"][-1], result["b.q"][-1]], [1, 8])


def test_of_several_equations_the_one_without_a_solution_is_named(simulate):
    with pytest.raises(BgError) as error:
        simulate(
            "model M { unknown a = 1; unknown b = 1; unknown c = 1;"
            "equation a^3 + a/10 = 3; equation b^2 + b/100 = -1 - a/1000; equation c^3 + c = a; }"
            "scene run_it of M { observe a, b, c; run 1 s; }"
        )
    assert codes(error) == ["BG711"]
    assert "state `b` is at fault" in error.value.diagnostics[0].message


LOSING = "state x = 1; der(x) = -1; unknown z = 0.1; equation z^2 = x;"


@pytest.mark.parametrize(
    ("model", "scene", "allowed"),
    [
        (
            "v : Se(e = 6); j : J1; a : R { e = f^2 + 10; } n : J0; b : R(2);"
            "v -> j -> a; j -> n -> b;",
            "observe n.e; run 1 s;",
            "BG704 BG711",
        ),
        (
            "j : J0; a : C(1, q0 = 1); b : C(2, q0 = 1); r : R(1); j -> a, b, r;",
            "observe b.q; run 1 s;",
            "BG516",
        ),
        (LOSING, "observe x, z; solver ros34prw; step 250 ms; run 2 s;", "BG701 BG703 BG711"),
        (LOSING, "observe x, z; solver lie; step 10 ms; run 2 s;", "BG701 BG703 BG711"),
        (LOSING, "observe x, z; solver rodas5p; run 2 s;", "BG701 BG703 BG711"),
        (
            "state x = 1; state y = 0; equation der(x) + der(y) = -x;equation der(x) - der(y) = y;",
            "observe x; step 1 ms; run 1 s; solver rk4;",
            "BG710",
        ),
    ],
)
def test_equations_without_a_solution_are_refused(simulate, model, scene, allowed):
    with pytest.raises(BgError) as error:
        simulate(f"model M {{ {model} }} scene run_it of M {{ {scene} }}")
    (code,) = codes(error)
    assert code in allowed.split()


def test_a_file_without_a_scene_is_said_to_have_none(simulate):
    diagnostic = refusal(simulate, "model M { state x = 1; der(x) = -x; }")
    assert (diagnostic.code, "``" in diagnostic.message) == ("BG067", False)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        ("sqrt(0.5 - time)", "`y` is not finite from 0.75 s onwards"),
        ("1 / (time - 0.5)", "`y` is not finite at 0.5 s"),
        ("1 / (time - 0.3)", None),
    ],
)
def test_a_value_that_is_not_finite_is_a_warning(simulate, law, message):
    result = simulate(
        f"model M {{ state x = 1; der(x) = -x; let y = {law}; let z = y; }}"
        "scene run_it of M { observe x, y, z; run 1 s; }",
        every=0.25,
    )
    assert len(result.time) == 5
    assert [(w.code, w.message) for w in result.warnings] == (
        [("BG712", message)] if message else []
    )


@pytest.mark.parametrize(
    ("scene", "code"),
    [
        ("device h = omega; drive x = h.position[1]; run 1 s;", "BG073"),
        ("run 1 s every 1 s; solver rodas5p(max_steps = 2);", "BG702"),
    ],
)
def test_a_run_that_cannot_be_made_says_which_kind_it_is(simulate, scene, code):
    with pytest.raises(BgError) as error:
        simulate(
            "model M { input x : m = 0; unknown z = 1; equation z^2 = 2 + x/(1 m) + sin(50*time); }"
            f"scene run_it of M {{ observe z; {scene} }}"
        )
    assert codes(error) == [code]


def test_a_transient_that_dies_within_a_fixed_step_does_not_upset_the_energy(simulate):
    # The damper takes 1e-6 m/s at once, in 1 ns; a cubic through the first slope would not.
    result = simulate(
        "model M { push : Se(e = 1); j : J1; mass : I(1e-3); damper : R(1e6);"
        "push -> j -> mass, damper; } scene run_it of M { observe energy.residual, "
        "energy.dissipated; solver ros34prw; step 1 ms; run 10 ms; }"
    )
    assert result["energy.dissipated"][-1] == pytest.approx(1e-8, rel=0.1)
    assert np.abs(result["energy.residual"]).max() < 1e-9
