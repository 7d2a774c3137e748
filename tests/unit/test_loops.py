"""Algebraic loops: what is reported of them, how they are solved, and what is refused."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from refusals import codes_of

import bgc
from bgc.algebra.dag import Dag, Kind
from bgc.algebra.fingerprint import Fingerprints
from bgc.driver import Stages, compile_scene
from bgc.equations.audit import power_defect
from bgc.equations.loops.rates import rate_terms
from bgc.equations.start.given import values_to_check
from bgc.ir.program import Loop, LoopKind, LoopSolution
from bgc.options import Options

MODELS = Path(__file__).parents[1] / "models" / "loops.bg"


@pytest.fixture
def written(tmp_path):
    def of(text: str) -> Path:
        path = tmp_path / "loop.bg"
        path.write_text(text)
        return path

    return of


@pytest.fixture
def compilation(written):
    def of(text: str) -> Stages:
        return compile_scene(written(text), Options(), until="equations")

    return of


def loops_of(scene: str) -> tuple[Loop, ...]:
    return compile_scene(MODELS, Options(scene=scene), until="equations").equations.loops


# --- what is reported ---------------------------------------------------------------------------


def test_a_linear_loop_is_reported_with_its_bonds_and_elements():
    (loop,) = loops_of("ladder")
    assert loop.elements == ("first", "shunt", "last")
    assert {"left -> first", "node -> shunt", "right -> last"} <= set(loop.bonds)
    assert (loop.kind, loop.solution) == (LoopKind.CONSTANT, LoopSolution.ELIMINATION)


def test_a_loop_in_one_unknown_is_closed_for_good_where_its_law_allows(compilation):
    program = compilation(
        "model M { s : Se(e = 5); j : J1; a : R { e = f*abs(f); } b : R(2); s -> j -> a, b; }"
        "scene s1 of M { observe j.f; run 1 s; }"
    ).equations
    (loop,) = program.loops
    assert (loop.kind, loop.solution) == (LoopKind.NONLINEAR, LoopSolution.CLOSED_FORM)
    assert program.states == ()


@pytest.mark.parametrize(("scene", "turned"), [("tank", False), ("turned_tank", True)])
def test_a_law_is_turned_round_only_where_it_has_to_be(scene, turned):
    program = compile_scene(MODELS, Options(scene=scene), until="equations").equations
    assert program.loops == ()
    (state,) = program.states
    numbers = {program.dag.value(n) for n in program.dag.reachable([state.derivative])}
    assert (1_000_000 in numbers) == turned  # of the law that gives the pressure


# --- linear loops -------------------------------------------------------------------------------


def test_the_factors_of_a_constant_matrix_are_made_once(compilation):
    emitted = compile_scene(MODELS, Options(scene="ladder"), until="emit").emitted
    text = "".join(unit.text for unit in emitted.units)
    (rhs,) = re.findall(r"void \w*rhs\([^)]*\)\s*\{(.*?)\n\}", text, re.S)
    (prepare,) = re.findall(r"void \w*prepare\([^)]*\)\s*\{(.*?)\n\}", text, re.S)
    assert "/" in prepare
    assert "/" not in rhs


def test_divisors_that_change_their_sign_are_left_to_newton(compilation):
    # [[a, b], [b, c]] with a = x, b = 1, c = -x: regular everywhere, but no pivot is.
    equations = compilation(
        "model M { state x = -1; der(x) = 1; let g = x; pair : MR[2] { e = [x*f[1] + cos(x)*f[2],"
        " cos(x)*f[1] - x*f[2]]; } s : MSe[2](e = [1, 2]); j : J1[2]; s -> j -> pair; }"
        "scene s1 of M { observe pair.f; run 2 s; }"
    ).equations
    (loop,) = equations.loops
    assert (loop.kind, loop.solution) == (LoopKind.VARYING, LoopSolution.NEWTON)


def test_cycles_that_share_what_follows_a_torn_variable_are_all_torn(written):
    """Four rates of inertias lead to one effort, over the same nodes."""
    path = written(
        "model M { loop : J1; gap : J0; motor : GY(ratio = -200000 Pa*s/m); loop -> motor -> gap;"
        " state slow : Pa; der(slow) = (gap.e - slow) / 0.36 s; gap -> cell[1];"
        " feed : MSf(39e-10 m^3/s/Pa * (72000 Pa - slow)); feed -> gap;"
        " ends : J1[2]; map : TF[1, 2] { f2 = [[0.33], [0.17]] * f1; } loop -> map -> ends;"
        " param k = 0.47 N; param b = 0.49 N/m^3; let a : m = 0.65 m * (1 + k / 0.47 N);"
        " spring : C[2] { e[1] = 0.55 N/m * q[1] + b * q[1]^3;"
        " e[2] = 0.62 N * atan(q[2] / a) + 2.6 N/m * q[2]; } ends -> spring;"
        " let inertia : Pa*s^2/m^3 = 150000000 Pa*s^2/m^3 * (1 + b / 0.49 N/m^3);"
        " for i in 1..4 { cell[i] : J1; mass[i] : I(inertia * (1 + i / 3)); cell[i] -> mass[i]; }"
        " for i in 1..3 { couple[i] : J0; buffer[i] : C(stiffness = 31000000 Pa/m^3);"
        " cell[i] -> couple[i] -> cell[i + 1]; couple[i] -> buffer[i]; } }"
        "scene s1 of M { observe energy.stored, energy.supplied; run 4 s every 1 s; }"
    )
    model = bgc.compile(path, preview=True)
    result = model.simulate(rtol=1e-8)
    supplied, stored = result["energy.supplied"], result["energy.stored"]
    np.testing.assert_allclose(stored, supplied, rtol=1e-6, atol=1e-6 * max(supplied))


def test_checks_of_divisors_that_nothing_divides_by_any_more_are_removed(written):
    """Nothing moves, so that the modulus, and the state that it depends on, are left out."""
    path = written(
        "model M { hub : J0; node : J0; a : C(stiffness = 2); b : C(stiffness = 3);"
        " state angle = 0.3; der(angle) = 1; motor : MGY(ratio = 1.5 + 1.6*sin(angle)*cos(angle));"
        " hub -> a; hub -> motor; motor -> node; node -> b; }"
        "scene still of M { observe a.e; run 1 s; }"
    )
    stages = compile_scene(path, Options(), until="optimise")
    assert stages.equations.divisors
    assert "angle" not in [state.name for state in stages.optimised.states]
    assert not stages.optimised.divisors


@pytest.mark.parametrize(("least", "watched"), [("2", 0), ("0", 1), ("-1", 1)])
def test_only_divisors_that_may_vanish_at_the_defaults_are_watched(written, least, watched):
    path = written(
        f"model M {{ param least = {least}; state x = 1; der(x) = -1; push : Se(e = 1);"
        " lever : MTF(ratio = least + x^2); damper : R(1); push -> lever -> damper; }"
        "scene s of M { observe damper.f; run 3 s; }"
    )
    stages = compile_scene(path, Options(), until="equations")
    assert len(stages.equations.divisors) == watched


# --- nonlinear loops ----------------------------------------------------------------------------


def test_the_audit_sees_a_slip_beside_a_loop(compilation):
    right = compilation(
        "model M { s : Se(e = 5); j : J1; a : R { e = f + sinh(f); } n : J0; "
        "b : R { f = e + e^3; } c : C(1); k : J1; d : R(2); "
        "s -> j -> a; j -> n -> b; n -> k -> c, d; }"
        "scene s1 of M { observe c.q, energy.residual; run 1 s; }"
    ).equations
    assert [state.kind for state in right.states].count("algebraic") > 0
    assert power_defect(right) < 1e-9
    k = [state.name for state in right.states].index("c.q")
    states = list(right.states)
    states[k] = replace(states[k], derivative=right.dag.neg(states[k].derivative))
    assert power_defect(replace(right, states=tuple(states))) > 1e-3


# --- equations with a singular mass matrix ------------------------------------------------------


HIDDEN = (
    "model M {{ param k = 1; state x = 1; state y = 5; equation k*der(x) + k*der(y) = -x;"
    "equation 2*der(x) + 2*der(y) = y - 3*x; }} scene s1 of M {{ observe x, y; run 1 s; {} }}"
)


@pytest.mark.parametrize("method", ["", "step 10 ms; solver ros34prw;", "solver radau5;"])
def test_what_equations_say_without_rates_is_found(written, method):
    # Less twice the first, the second says y = x; x + y = 6 is what the rates leave.
    result = bgc.compile(written(HIDDEN.format(method))).simulate(every=0.1)
    exact = 3 * np.exp(-result.time / 2)
    np.testing.assert_allclose(result["x"], exact, rtol=1e-5)
    np.testing.assert_allclose(result["y"], exact, rtol=1e-5)


def test_equations_whose_rates_vanish_with_a_parameter_are_refused(written):
    model = bgc.compile(written(HIDDEN.format("")))
    assert codes_of(model.simulate, parameters={"k": 0}) == ["BG707"]


def test_states_with_one_rate_add_up() -> None:
    dag = Dag()
    x, y, rate = (dag.symbol(Kind.STATE, k) for k in range(3))
    time = dag.symbol(Kind.TIME)
    found = rate_terms(dag, dag.add(time, dag.mul(x, y)), {x: rate, y: rate})
    assert found.by_time == dag.one
    assert found.weights == {rate: dag.add(y, x)}


def test_a_value_of_a_loop_is_not_proven_before_the_loop_is_solved() -> None:
    dag = Dag()
    states = [
        SimpleNamespace(kind=kind, projection=None, initial=dag.zero)
        for kind in ("momentum", "algebraic")
    ]
    causal = SimpleNamespace(closures=(), fingerprints=Fingerprints(dag))
    given = [SimpleNamespace(node=dag.symbol(Kind.STATE, k), value=dag.zero) for k in range(2)]
    variables = SimpleNamespace(dag=dag, causal=causal)
    assert values_to_check(variables, given, states, ()) == (given[1],)


@pytest.mark.parametrize(
    "momenta",
    [("2 + tanh(j.f)", ["a.p"]), ("2 + tanh(j.f) + (if time < 0.5 then 0 else 1)", ["j.p"])],
)
def test_a_modulus_that_jumps_keeps_the_common_momentum(
    momenta: tuple[str, list[str]], tmp_path: Path
) -> None:
    modulus, expected = momenta
    path = tmp_path / "m.bg"
    path.write_text(
        "model M { s : Se(1); j : J1; a : I(1); k : J1; b : I(2); "
        f"m : MTF {{ f2 = ({modulus})*f1; }} s -> j -> a; j -> m -> k -> b; }} "
        "scene t of M { observe a.f, b.f; run 1 s; }"
    )
    states = compile_scene(path, Options(), until="equations").equations.states
    assert [state.name for state in states if state.kind == "momentum"] == expected
