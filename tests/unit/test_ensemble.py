"""Many instances at once compute what each does alone."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from ensembles import OSCILLATOR

import bgc
from bgc.algebra.dag import Op
from bgc.algebra.evaluate import apply
from bgc.building.toolchain import find_toolchain
from bgc.runtime.cli.app import application
from bgc.runtime.model import Model
from bgc.runtime.results.ensemble import Ensemble
from bgc.runtime.running import many

pytestmark = pytest.mark.slow

MODELS = Path(__file__).parents[1] / "models"
FIXED = {"solver": "ros34prw", "step": 0.01}


def one_by_one(model: Model, ensemble: Ensemble, **options: float | str) -> np.ndarray:
    """The values of an ensemble, each instance simulated alone."""
    results = [
        model.simulate(parameters={n: v[k] for n, v in ensemble.parameters.items()}, **options)
        for k in range(ensemble.count)
    ]
    return np.array([np.column_stack(list(result.columns.values())) for result in results])


def distance(computed: np.ndarray, expected: np.ndarray) -> float:
    """The largest difference over the largest value of each output."""
    scale = np.abs(expected).max(axis=(0, 1))
    return float((np.abs(computed - expected) / np.where(scale > 0, scale, 1)).max())


# --- agreement --------------------------------------------------------------------------------

CASES = [
    ("dc_motor", "start", {"L": np.linspace(0.4, 0.6, 11)}),
    ("series_rlc", "step_response", {"R": np.linspace(1, 3, 11)}),
    ("two_lags", "step_response", {"tau2": np.geomspace(1e-5, 1e-2, 11)}),
    ("crane_sag", "sag", {"stiffness": np.geomspace(1e8, 1e10, 9)}),
    ("tumbling", "quaternion", {"com[1]": np.linspace(0.05, 0.2, 9)}),
]


@pytest.mark.parametrize(("name", "scene", "values"), CASES, ids=[case[0] for case in CASES])
@pytest.mark.parametrize("solver", ["ros34prw", "rk4"])
def test_fixed_steps_agree_with_runs_alone_to_rounding(name, scene, values, solver):
    model = bgc.compile(MODELS / f"{name}.bg", scene=scene)
    step = 1e-5 if solver == "rk4" else 1e-3
    options = {"duration": 200 * step, "every": 20.5 * step, "solver": solver, "step": step}
    ensemble = model.simulate_many(values, **options)
    assert ensemble.together == ensemble.count == len(next(iter(values.values())))
    assert np.isfinite(ensemble.values).all()
    outputs = [k for k, n in enumerate(ensemble.names) if n not in model.accounts.values()]
    expected = one_by_one(model, ensemble, **options)
    assert distance(ensemble.values[:, :, outputs], expected[:, :, outputs]) < 1e-12


OPERATORS = (
    *("(x + 3)^1.7", "x^3", "max(x, -0.25, x^2)", "if x > 0.5 then sin(x) else -x"),
    *("if x > 0 and not x > 1 then 1 else 2", "if x < -0.5 or x >= 0.5 then x else 1/(x + 3)"),
)


def calls() -> Iterator[str]:
    """A call of every function of real numbers, defined for x from -1.3 to 1.5, with a jump."""
    arguments = ("3*x", "x", "x/3", "x + 3")  # the first that it is defined for
    for op in (op for op in Op if op.row.name and op.row.smooth):
        others = [f"{0.7371 + k}" for k in range(op.row.arity - 1)]
        for text in arguments:
            ends = (eval(text, {"x": x}) for x in (-1.3, 1.5))
            if all(math.isfinite(apply(op, end, *map(float, others))) for end in ends):
                yield f"{op.row.name}({', '.join((text, *others))})"
                break
        else:
            raise AssertionError(f"no argument for {op.row.name}")


TABLES = (
    *(
        f"interpolate([-1, 0, 0.5, 2], [3, 1, 4, -1], x, method = {method})"
        for method in ("linear", "pchip", "spline", "nearest")
    ),
    "interpolate([-1, 0, 0.7, 1], [0, 2, 1, 0], 2*x, outside = repeat)",
    "interpolate([-1, 0, 2], [0, 1], [[1, 2], [4, 0], [-1, 3]], x, x^2, outside = extrapolate)",
)
EXPRESSIONS = (*calls(), *OPERATORS, *TABLES)


def test_functions_and_choices_of_every_kind_are_those_of_one_instance(tmp_path):
    observed = ", ".join(f"{text} as y{k}" for k, text in enumerate(EXPRESSIONS))
    (tmp_path / "functions.bg").write_text(
        "model Functions { param a = 0; state x = a; der(x) = 1; }\n"
        f"scene all of Functions {{ observe {observed}; run 1 every 0.1; }}\n"
    )
    model = bgc.compile(tmp_path / "functions.bg")
    ensemble = model.simulate_many({"a": np.linspace(-1.2987, 0.4113, 9)}, solver="rk4", step=0.1)
    assert ensemble.together == 9
    expected = one_by_one(model, ensemble, solver="rk4", step=0.1)
    np.testing.assert_allclose(ensemble.values, expected, rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize("keep", [1, 4])
def test_a_kept_jacobian_is_kept_as_long(tmp_path, keep):
    options = f"keep = {keep}, substeps = 1"
    source = OSCILLATOR.replace("run 3 s", f"solver ros34prw({options}, step = 20 ms); run 3 s")
    (tmp_path / "kept.bg").write_text(source)
    model = bgc.compile(tmp_path / "kept.bg")
    ensemble = model.simulate_many({"k": np.linspace(5, 40, 8)})
    assert ensemble.together == 8
    assert distance(ensemble.values, one_by_one(model, ensemble)) < 1e-12


@pytest.mark.parametrize("solver", ["rodas5p", "rodas4p2", "dopri5"])
def test_every_lane_is_within_tolerance_under_error_control(oscillator, solver):
    k = np.geomspace(1, 100, 13)
    ensemble = oscillator.simulate_many({"k": k}, solver=solver, rtol=1e-6)
    assert ensemble.together == 13
    exact = one_by_one(oscillator, ensemble, solver="radau5", rtol=1e-11)
    alone = one_by_one(oscillator, ensemble, solver=solver, rtol=1e-6)
    scale = np.abs(exact).max(axis=1)
    error = (np.abs(ensemble.values - exact).max(axis=1) / scale).max(axis=1)
    error_alone = (np.abs(alone - exact).max(axis=1) / scale).max(axis=1)
    assert (error <= 10 * error_alone + 1e-7).all()
    assert error.max() < 1e-4


def test_fixed_steps_keep_the_energy_accounts(oscillator_file):
    model = bgc.compile(oscillator_file, scene="watched")
    ensemble = model.simulate_many({"mass": np.linspace(1, 2, 8)}, solver="ros34prw", step=0.05)
    assert ensemble.together == 8
    assert ensemble.names == ("v", "residual", "q")
    assert ensemble.units["residual"] == "J"
    expected = one_by_one(model, ensemble, solver="ros34prw", step=0.05)
    assert distance(ensemble.values, expected) < 1e-10


def test_the_energy_accounts_are_under_error_control(oscillator_file):
    model = bgc.compile(oscillator_file, scene="watched")
    ensemble = model.simulate_many({"k": np.geomspace(5, 50, 9)}, rtol=1e-7)
    assert ensemble.together == 9
    alone = one_by_one(model, ensemble, rtol=1e-7)
    residual, alone_residual = (np.abs(each[:, :, 1]).max() for each in (ensemble.values, alone))
    assert 0 < residual < 2 * alone_residual + 1e-12
    assert distance(ensemble.values[:, :, [0, 2]], alone[:, :, [0, 2]]) < 1e-5


def test_energies_that_no_state_needs_are_as_accurate_as_alone():
    model = bgc.compile(MODELS / "accounts.bg", scene="lag")
    ensemble = model.simulate_many([{}] * 4, rtol=1e-6)
    exact = model.simulate(rtol=1e-11)
    assert ensemble.together == 4
    np.testing.assert_allclose(
        ensemble["energy.supplied"][:, -1], exact["energy.supplied"][-1], rtol=1e-5
    )


def test_long_runs_balance_within_the_tolerance_as_alone():
    model = bgc.compile(MODELS / "accounts.bg", scene="shaken")
    ensemble = model.simulate_many({"shake": np.linspace(10, 20, 4)}, rtol=1e-5)
    residual = np.abs(ensemble["energy.residual"]).max(axis=1)
    assert ensemble.together == 4
    assert (residual < 1e-5 * ensemble["energy.dissipated"][:, -1]).all()


@pytest.mark.parametrize("vectorised", [True, False])
def test_an_instance_that_does_not_settle_leaves_the_others_alone(tmp_path, vectorised):
    """x' = 1000 (a - x^2) has the fast rest sqrt(a), and none for a < 0."""
    file = tmp_path / "rest.bg"
    file.write_text(
        "model M { param a = 1; state x = 2; der(x) = 1000*(a - x^2); }\n"
        "scene s of M { observe x; run 1 ms; }"
    )
    ensemble = bgc.compile(file).simulate_many(
        {"a": [1, -4, 4, 9, 16]}, settle=1, vectorised=vectorised
    )
    assert ensemble.status == ("done", "failed", "done", "done", "done")
    assert ensemble.failures[1].code == "BG717"
    np.testing.assert_allclose(ensemble["x"][[0, 2, 3, 4], -1], [1, 2, 3, 4], rtol=1e-9)


def test_what_batches_do_not_serve_runs_alone_and_gives_the_same_bits(oscillator):
    ensemble = oscillator.simulate_many({"k": np.linspace(5, 9, 5)}, solver="radau5")
    assert ensemble.together == 0
    np.testing.assert_array_equal(
        ensemble.values, one_by_one(oscillator, ensemble, solver="radau5")
    )


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"solver": "gauss4", "step": 0.05}, "`gauss4` is not a Rosenbrock or explicit method"),
        ({"vectorised": False}, "vector registers are not wanted"),
        ({}, ""),
    ],
)
def test_an_ensemble_tells_why_its_instances_ran_one_by_one(oscillator, options, reason):
    ensemble = oscillator.simulate_many({"k": np.linspace(5, 9, 5)}, **options)
    assert ensemble.alone == reason
    assert ensemble.together == (0 if reason else 5)


def test_algebraic_equations_and_few_instances_run_one_by_one(oscillator):
    loops = bgc.compile(MODELS / "loops.bg", scene="diodes").simulate_many([{}] * 4, 0.1)
    assert (loops.together, loops.alone) == (0, "the model has algebraic equations")
    two = bgc.compile(MODELS / "loops.bg", scene="diodes").simulate_many([{}] * 2, 0.1)
    assert two.alone == loops.alone, "more instances would not change it"
    few = oscillator.simulate_many({"k": [5.0, 6.0, 7.0]})
    assert (few.together, few.alone) == (0, "3 instances are too few to compile for")


# --- lanes that fail --------------------------------------------------------------------------


def test_a_lane_that_fails_tells_why_and_the_others_go_on(oscillator):
    limit, late = np.full(11, 10.0), np.full(11, -1.0)
    limit[3], late[9] = 0.9, 0.5  # torn at the start; the root of a negative number
    ensemble = oscillator.simulate_many({"limit": limit, "late": late}, **FIXED)
    assert [k for k, status in enumerate(ensemble.status) if status != "done"] == [3, 9]
    assert {k: why.code for k, why in ensemble.failures.items()} == {3: "BG705", 9: "BG703"}
    assert ensemble.together == 9
    assert list(np.flatnonzero(~ensemble.done)) == [3, 9]
    assert np.isfinite(ensemble.values[ensemble.done]).all()
    assert np.isnan(ensemble.values[[3, 9]]).any(axis=(1, 2)).all()
    good = oscillator.simulate(**FIXED)
    np.testing.assert_allclose(ensemble["q"][4], good["q"], rtol=1e-12)


def test_a_lane_that_fails_on_the_way_has_its_rows_up_to_there(oscillator):
    ensemble = oscillator.simulate_many({"limit": [10, 10, 1.0000001, 10]}, **FIXED, duration=20.0)
    alone = oscillator.simulate_many(
        {"limit": [10, 10, 1.0000001, 10]}, **FIXED, duration=20.0, vectorised=False
    )
    np.testing.assert_array_equal(np.isnan(ensemble.values), np.isnan(alone.values))
    np.testing.assert_allclose(ensemble.values, alone.values, rtol=1e-11, atol=1e-12)
    assert ensemble.status == alone.status


def test_under_error_control_the_lane_at_fault_leaves(oscillator):
    late = np.array([-1.0, -1.0, 0.5, -1.0, -1.0])
    ensemble = oscillator.simulate_many({"late": late})
    assert ensemble.status == ("done", "done", "failed", "done", "done")
    assert ensemble.together == 4
    exact = oscillator.simulate(rtol=1e-10)
    np.testing.assert_allclose(ensemble["q"][4], exact["q"], atol=1e-4)


def test_energies_that_overflow_end_a_run_alone_and_in_a_batch(tmp_path):
    """The square of a speed overflows while the speed itself does not."""
    path = tmp_path / "a.bg"
    path.write_text(
        "model M { param grow = 800 N*s/m; j : J1; body : I(1 kg, f0 = 1 m/s);"
        " push : MR { e = -grow*f; } j -> body, push; }"
        "scene s of M { observe body.f as v, energy.stored; run 0.5 s every 10 ms; }"
    )
    model = bgc.compile(path)
    with pytest.raises(bgc.SimulationError) as caught:
        model.simulate()
    assert caught.value.diagnostics[0].code == "BG703"
    rows = caught.value.result
    speed = np.exp(800 * rows.time)
    assert rows["v"] == pytest.approx(speed, rel=1e-3)
    assert 0.5 * speed[-1] ** 2 > 1e300 and np.isfinite(rows["energy.stored"]).all()

    values = [-1.0, 800.0, 2.0, 700.0]
    ensemble = model.simulate_many({"grow": values}, solver="ros34prw", step=1e-4)
    assert ensemble.status == ("done", "failed", "done", "done")
    assert not ensemble.not_finite


def test_values_that_are_not_finite_are_reported_as_by_a_single_run(tmp_path):
    path = tmp_path / "a.bg"
    path.write_text(
        "model M { param k = 1; state q = 1; der(q) = -k; output root = sqrt(q); }"
        "scene s of M { observe q, root; run 2 s every 0.5 s; }"
    )
    model = bgc.compile(path)
    values = [0.1, 0.7, 0.1, 3.0]
    ensemble = model.simulate_many({"k": values})
    assert ensemble.status == ("done",) * 4 and ensemble.together == 4
    assert sorted(ensemble.not_finite) == [1, 3]
    for k, warning in ensemble.not_finite.items():
        (alone,) = model.simulate(parameters={"k": values[k]}).warnings
        assert warning == alone and alone.code == "BG712"
    notes = [d.note for d in ensemble.placed_warnings()]
    assert notes == ["in instance 1, with `k` = 0.7", "in instance 3, with `k` = 3"]
    command = ["sweep", str(path), "--vary", "k=0.1..3:2", "--out", "-"]
    done = CliRunner().invoke(application, command)
    assert done.exit_code == 0 and done.stderr.count("BG712") == 1
    assert "2 done; 1 with values that are not finite" in done.stderr


# --- other registers --------------------------------------------------------------------------

_X86 = os.uname().machine == "x86_64"
_COMPILERS = {
    "no vector types": ("cc", "-DBGC_LANES_SCALAR -O0", 1),
    "two": ("cc", "-mno-avx -O0", 2),
    "four": ("cc", "-mno-avx512f -mavx2 -O0", 4),
    "zig": (f"{sys.executable} -m ziglang cc", "-O1", None),
}
"""Compilers, their last flags, and the width; at -O0 they take a third of the time of -O3."""


@pytest.mark.parametrize("kind", _COMPILERS)
def test_registers_of_every_width_give_the_same_values(
    kind, oscillator_file, oscillator, monkeypatch, tmp_path
):
    compiler, flags, width = _COMPILERS[kind]
    if kind == "zig" and find_spec("ziglang") is None:
        pytest.skip("there is no ziglang")
    if kind != "zig" and not (_X86 and find_toolchain().kind == "gcc"):
        pytest.skip("flags of gcc on x86-64")
    values = {"k": np.linspace(5, 40, 10)}
    expected = oscillator.simulate_many(values, **FIXED)
    script = tmp_path / "cc"
    script.write_text(f'#!/bin/sh\nexec {compiler} "$@" {flags}\n')
    script.chmod(0o755)
    monkeypatch.setenv("CC", str(script))
    model = bgc.compile(oscillator_file)
    library = many.lane_library(model)
    assert width in (None, library.width)
    ensemble = model.simulate_many(values, **FIXED)
    assert ensemble.together == 10
    np.testing.assert_allclose(ensemble.values, expected.values, rtol=1e-11, atol=1e-12)
