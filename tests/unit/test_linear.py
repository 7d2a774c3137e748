"""Linear models: state space, operating points and modes against closed forms."""

import csv
import math

import numpy as np
import pytest
from linear_models import (
    EXACT_A,
    K1,
    K2,
    K12,
    M1,
    M2,
    MODELS,
    TWO_MASSES,
    D,
    linear,
    opened,
    state_space,
)
from refusals import code_of
from scipy import signal

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.linear.linear_tables import linear_tables, write_csv, write_npz
from bgc.runtime.linear.state_space import pencil_eigenvalues, without_algebraic

# --- state space ------------------------------------------------------------------------------


def test_an_output_that_the_input_reaches_at_once_is_in_D(tmp_path):
    lin = linear(tmp_path, TWO_MASSES, ["push.e"], ["body1.e", "3*left.f"])
    np.testing.assert_allclose(lin.D, [[1], [0]], atol=1e-15)
    np.testing.assert_allclose(lin.C[0], EXACT_A[0], rtol=1e-15)
    np.testing.assert_allclose(lin.C[1], [3 / M1, 0, 0, 0, 0], rtol=1e-15)


def test_a_parameter_is_an_input_wherever_it_acts(tmp_path):
    """About p = (1, 2): d p1'/d d is -(v1 - v2); d v2/d m2 = -v2/m2."""
    model = opened(tmp_path, TWO_MASSES, ["d", "F", "m2"])
    point = model.at_state({"body1.p": 1.0, "body2.p": 2.0}, 0.0)
    lin = model.linearise(point)
    v1, v2 = 1 / M1, 2 / M2
    by_mass = -v2 / M2
    expected = [
        [-(v1 - v2), 1, D * by_mass],
        [v1 - v2, 0, -D * by_mass],
        [0, 0, 0],
        [0, 0, by_mass],
        [0, 0, -by_mass],
    ]
    np.testing.assert_allclose(lin.B, expected, rtol=1e-14)
    np.testing.assert_allclose(lin.D, [[0, 0, by_mass], [0, 0, 0]], rtol=1e-14)


def test_what_follows_from_a_parameter_is_varied_with_it(tmp_path):
    text = TWO_MASSES.replace("param F = 4 N;", "param a = 2; param F = 3 N * a^2;")
    lin = linear(tmp_path, text, ["a"])
    np.testing.assert_allclose(lin.B[0], [12.0])


def test_derivatives_agree_with_differences_of_the_emitted_functions():
    """Nonlinear, in three dimensions, at a state off rest: central differences of the C."""
    model = bgc.compile(MODELS / "vessel_at_rest.bg", scene="rolling")
    rng = np.random.default_rng(3)
    state = model.initial_state()
    state[:6] += 1e5 * rng.standard_normal(6)
    lin = model.linearise(["load"], state=state)
    assert lin.states == tuple(v.name for v in model.states)
    np.testing.assert_allclose(lin.A, model.jacobian(state), rtol=1e-12, atol=1e-14)
    outputs = list(model.observe(state))
    for k, name in enumerate(lin.inputs):
        up, down = ({name: sign * 1e3} for sign in (1, -1))
        slope = (model.rhs(state, parameters=up) - model.rhs(state, parameters=down)) / 2e3
        np.testing.assert_allclose(lin.B[:, k], slope, rtol=1e-6, atol=1e-12)
    for j in range(len(state)):
        step = np.zeros(len(state))
        step[j] = 1e-6 * max(1.0, abs(state[j]))
        above, below = (model.observe(state + sign * step) for sign in (1, -1))
        slope = [(above[o] - below[o]) / (2 * step[j]) for o in outputs]
        np.testing.assert_allclose(lin.C[:, j], slope, rtol=1e-6, atol=1e-8)


def test_scipy_takes_the_matrices_as_they_are():
    lin = bgc.compile(MODELS / "dc_motor.bg").linearise(["supply.e"], ["speed"])
    _, speed = signal.step(signal.StateSpace(lin.A, lin.B, lin.C, lin.D), T=[0.0, 10.0, 20.0])
    k, R, b = 0.01, 1.0, 0.1
    np.testing.assert_allclose(speed[-1], k / (R * b + k**2), rtol=1e-9)


# --- operating points -------------------------------------------------------------------------


def test_a_nonlinear_equilibrium(tmp_path):
    text = """
    model M {
      push : Se(e = 10); node : J1; body : I(1); spring : C { H = q^4/4; } drag : R(1);
      push -> node -> body, spring, drag;
    }
    scene s of M { observe spring.q; run 1 s; }
    """
    lin = linear(tmp_path, text, ["push.e"], at="steady")
    place = dict(zip(lin.states, lin.point, strict=True))["spring.q"]
    assert place == pytest.approx(10 ** (1 / 3), rel=1e-9)
    gain = lin.response(np.array([1e-9]))[0, 0, 0]
    assert gain == pytest.approx(1 / (3 * place**2), rel=1e-6)


def test_no_equilibrium_is_said_so(tmp_path):
    text = """
    model M { feed : Sf(f = 2); tank : C(1); node : J0; feed -> node -> tank; }
    scene s of M { observe tank.q; run 1 s; }
    """
    with pytest.raises(BgError) as error:
        linear(tmp_path, text, at="steady")
    assert code_of(error) == "BG082"
    assert "`tank.q`" in str(error.value) and "2" in str(error.value)


def test_the_state_at_a_time_is_not_that_at_the_end_of_the_last_step(tmp_path):
    """The last step of an adaptive method ends behind the time that was asked for."""
    path = tmp_path / "model.bg"
    path.write_text(
        "model Swing { s : C(stiffness = 1, q0 = 1); m : I(1); j : J1; j -> s, m; }"
        " scene swing of Swing { observe s.q; run 1 s; }"
    )
    model = bgc.compile(path)
    state = dict(zip((s.name for s in model.states), model.state_at(0.7)[0], strict=True))
    assert state["s.q"] == pytest.approx(math.cos(0.7), rel=1e-5)
    assert state["m.p"] == pytest.approx(-math.sin(0.7), rel=1e-5)


def test_the_state_at_a_time_is_that_of_a_run(tmp_path):
    path = tmp_path / "model.bg"
    path.write_text(TWO_MASSES)
    model = bgc.compile(path)
    lin = model.linearise(["push.e"], at=0.7)
    result = model.simulate(0.7, rtol=1e-9)
    stretch = dict(zip(lin.states, lin.point, strict=True))["spring.q"]
    assert lin.time == 0.7
    assert stretch == pytest.approx(result["stretch"][-1], rel=1e-4)


def test_parameters_of_a_model_are_those_of_its_linear_form(tmp_path):
    path = tmp_path / "model.bg"
    path.write_text(TWO_MASSES)
    model = bgc.compile(path)
    model.parameters["d"] = 1.0
    lin = model.linearise(["push.e"], parameters={"m1": "4 kg"})
    assert lin.A[0, 0] == pytest.approx(-1.0 / 4)


def test_algebraic_equations_are_solved(tmp_path):
    text = """
    model M {
      input u = 0; param a = 3;
      state x = 1; unknown z = 1; unknown w = 1;
      equation 2*der(x) + 4*x + z = a;
      equation z^3 + z = 10*x;
      equation w = z + x;
    }
    scene s of M { observe w; run 1 s; }
    """
    lin = linear(tmp_path, text, ["a"])
    assert lin.states == ("x",) and lin.is_explicit
    # At x = 1: z = 2, dz/dx = 10 / (3 z^2 + 1) = 10/13
    np.testing.assert_allclose(lin.A, [[(-4 - 10 / 13) / 2]], rtol=1e-9)
    np.testing.assert_allclose(lin.B, [[0.5]], rtol=1e-12)
    np.testing.assert_allclose(lin.C, [[1 + 10 / 13]], rtol=1e-9)


def test_a_loop_that_newton_solves_is_linearised_about_its_solution(tmp_path):
    """A diode and a resistor in series: d i/d e = 1 / (R + dv/di), i = (e - v)/R."""
    text = """
    model M {
      s : Se(e = 3); d : R { f = 1e-3*(exp(e/0.1) - 1); } r : R(200); line : J1; c : C(1); n : J0;
      s -> line -> d, r; line -> n -> c;
    }
    scene a of M { observe line.f; run 1 s; }
    """
    lin = linear(tmp_path, text, ["s"])
    low, high = 0.0, 3.0
    for _ in range(80):  # the diode's effort by bisection
        v = (low + high) / 2
        low, high = (v, high) if 1e-3 * (math.exp(v / 0.1) - 1) < (3 - v) / 200 else (low, v)
    slope = 0.1 / (1e-3 * math.exp(v / 0.1))
    assert lin.states == ("c.q",)
    np.testing.assert_allclose(lin.D, [[1 / (200 + slope)]], rtol=1e-9)
    np.testing.assert_allclose(lin.A, [[-1 / (200 + slope)]], rtol=1e-9)


def test_units_do_not_decide_whether_algebraic_equations_can_be_solved():
    """x' = -x + y + 1e15 z, 0 = x - 2e-9 y, 0 = 1e9 x - 1e24 z: x' = (-1 + 5e8 + 1) x."""
    A = np.array([[-1, 1, 1e15], [1, -2e-9, 0], [1e9, 0, -1e24]])
    none = np.zeros((3, 0))
    found, *_, mass, left = without_algebraic(A, none, none.T, np.zeros((0, 0)), np.diag([1, 0, 0]))
    np.testing.assert_allclose(found, [[5e8]], rtol=1e-12)
    np.testing.assert_array_equal(mass, [[1]])
    assert list(left) == [0]


def test_a_descriptor_keeps_its_response(tmp_path):
    """x' + y' = u - x, 0 = x - y: 2 s X = U - X."""
    lin = state_space([[-1, 0], [1, -1]], E=[[1, 1], [0, 0]])
    omega = np.array([0.1, 1.0, 10.0])
    np.testing.assert_allclose(lin.response(omega)[:, 0, 0], 1 / (2j * omega + 1), rtol=1e-12)
    np.testing.assert_allclose(lin.eigenvalues(), [-0.5])
    assert not lin.is_explicit


# --- modes ------------------------------------------------------------------------------------


def test_a_state_that_only_follows_has_no_part_in_a_mode():
    """x0' = -x0 + 5 x1, x1' = -3 x1: x0 moves in the mode of x1, and does nothing for it."""
    slow, fast = state_space([[-1, 5], [0, -3]]).modes()
    assert (slow.eigenvalue, fast.eigenvalue) == (-1, -3)
    assert slow.shares == (("x0", 1.0), ("x1", 0.0))
    assert fast.shares == (("x1", 1.0), ("x0", 0.0))


def test_modes_of_two_masses_are_those_of_the_mechanical_pencil(tmp_path):
    lin = linear(tmp_path, TWO_MASSES.replace("d = 0.3", "d = 0"), ["push.e"])
    mass, stiffness = np.diag([M1, M2]), np.array([[K1 + K12, -K12], [-K12, K2 + K12]])
    squares = np.sort(np.linalg.eigvals(np.linalg.solve(mass, stiffness)).real)
    modes = [mode for mode in lin.modes() if mode.frequency > 0]
    periods = [mode.natural_period for mode in modes]
    np.testing.assert_allclose(periods, 2 * math.pi / np.sqrt(squares), rtol=1e-12)
    assert [mode.damping for mode in modes] == pytest.approx([0, 0], abs=1e-12)
    for mode in modes:
        assert sum(share for _, share in mode.shares) == pytest.approx(1)
    assert modes[0].shares[0][0] in {"body2.p", "body1.p", "wall2.q", "wall1.q"}


def test_eigenvalues_agree_with_those_of_the_pencil(tmp_path):
    lin = linear(tmp_path, TWO_MASSES, ["push.e"])
    found = np.sort_complex(lin.eigenvalues())
    expected = np.sort_complex(np.linalg.eigvals(EXACT_A))
    np.testing.assert_allclose(found, expected, atol=1e-12)
    assert len(pencil_eigenvalues(np.empty((0, 0)), np.empty((0, 0)))) == 0


# --- what may be asked for --------------------------------------------------------------------


def test_names_of_inputs(tmp_path):
    text = """
    model M {
      param F[3] = [1, 2, 3];
      push : Se[3](e = F); hub : J1; body : I[3](2 kg); drag : R[3](4);
      push -> hub -> body, drag;
    }
    scene s of M { observe body.f as v, drag.e; run 1 s; }
    """
    assert linear(tmp_path, text, ["push.e"]).inputs == ("push.e[1]", "push.e[2]", "push.e[3]")
    assert linear(tmp_path, text, ["push"]).inputs == ("push.e[1]", "push.e[2]", "push.e[3]")
    assert linear(tmp_path, text, ["F[2]", "push.e[3]"]).inputs == ("F[2]", "push.e[3]")
    lin = linear(tmp_path, text, ["F"], ["v[2]", "drag.e"])
    assert lin.outputs == ("v[2]", "drag.e[1]", "drag.e[2]", "drag.e[3]")
    assert not linear(tmp_path, text).inputs
    joined = (
        "join : Mux[1, 2]; a : J1; b : J1; m : I(1); n : I[2](1); free : Se[3](e = F);"
        "a -> m; b -> n; a -> join; b -> join; join -> free;"
    )
    parted = (
        "model M { param F[3] = [1, 2, 3]; " + joined + " } scene s of M { observe m.f; run 1 s; }"
    )
    assert len(linear(tmp_path, parted, ["free.e"]).inputs) == 3
    with pytest.raises(BgError) as error:
        linear(tmp_path, text, ["push.g"])
    assert code_of(error) == "BG080" and "`push.e[1]`" in error.value.diagnostics[0].help


def test_channels_of_devices_are_inputs_by_default(tmp_path):
    text = """
    model M { input x[3]; state y = 0; der(y) = 5*x[2] - y; }
    scene s of M {
      device hand = trace(file = "motion.csv");
      drive x = hand.position;
      observe y;
      run 1 s;
    }
    """
    lin = linear(tmp_path, text)
    assert lin.inputs == ("hand.position[1]", "hand.position[2]", "hand.position[3]")
    np.testing.assert_allclose(lin.B, [[0, 5, 0]])
    assert lin.units["hand.position[2]"] == "m"
    np.testing.assert_allclose(linear(tmp_path, text, ["hand.position[2]"]).B, [[5]])


def test_inputs_and_outputs_that_cannot_be(tmp_path):
    for inputs, outputs, code in (
        (["push.e"], ["energy.stored"], "BG083"),
        (["push.e"], ["nothing.e"], "BG211"),
        (["push.e"], ["left.f +"], "BG"),
    ):
        with pytest.raises(BgError) as error:
            linear(tmp_path, TWO_MASSES, inputs, outputs)
        assert code_of(error).startswith(code)
    with pytest.raises(BgError) as error:
        linear(tmp_path, "model M { param m = 1; state x = 1; equation m*der(x) = 1; }", ["m"])
    assert code_of(error) == "BG081"


# --- tables and files -------------------------------------------------------------------------


def test_files_hold_the_matrices(tmp_path):
    lin = linear(tmp_path, TWO_MASSES, ["push.e"])
    write_csv(lin, tmp_path / "lin.csv")
    rows = list(csv.reader((tmp_path / "lin.csv").read_text().splitlines()))
    assert rows[0] == ["", *lin.states, "push.e"]
    assert [row[0] for row in rows[1:]] == [*(f"{s}'" for s in lin.states), "v2", "stretch"]
    numbers = np.array([[float(x) for x in row[1:]] for row in rows[1:]])
    assert np.array_equal(numbers, np.block([[lin.A, lin.B], [lin.C, lin.D]]))
    write_npz(lin, tmp_path / "lin.npz")
    with np.load(tmp_path / "lin.npz") as data:
        assert np.array_equal(data["A"], lin.A) and tuple(data["outputs"]) == lin.outputs


def test_large_matrices_are_shown_in_part(tmp_path):
    model = bgc.compile(MODELS / "vessel_at_rest.bg", scene="damped")
    lin = model.linearise(["load"])
    short, full = linear_tables(lin, False), linear_tables(lin, True)
    assert {len(row) for row in short[1].rows} == {1 + 8 + 1} and "16 x 16" in short[1].note
    assert {len(row) for row in full[1].rows} == {1 + 16} and full[1].note == ""
    assert len(full[-1].rows) == len(lin.modes())


def test_a_model_that_is_not_finite_at_the_point_is_refused(tmp_path):
    text = """
    model M { param k = 1; state x = 1; der(x) = -x/k; }
    scene s of M { observe x; keep k; run 1 s; }
    """
    with pytest.raises(BgError) as caught:
        linear(tmp_path, text.replace("k = 1", "k = 0"), ["k"], ["x"])
    assert code_of(caught) == "BG703"
