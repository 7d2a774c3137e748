"""Rows, chunks, saved states, failures and energy accounts of a run."""

from __future__ import annotations

import itertools
import math
import subprocess
import threading
import time
from ctypes import c_double
from pathlib import Path
from shutil import which
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from bgc.building.build import driver_names, runtime_sources
from bgc.runtime.running.structures import Status

SETUPS: dict[str, dict[str, Any]] = {
    "adaptive": {"name": "rodas5p", "rtol": 1e-6, "accounts": True},
    "fixed": {"name": "ros34prw", "step": 0.013, "accounts": True},
    "kept": {"name": "ros34prw", "step": 0.01, "keep": 5},
    "explicit": {"name": "rk4", "step": 0.01, "accounts": True},
}
GRID = np.concatenate([[0.0, 0.0, 0.001], np.linspace(0.01, 3.0, 57), [3.0]])


def started(c_model: Any, setup: str, model: str = "oscillator") -> Any:
    instance = c_model(model)
    instance.start(**SETUPS[setup])
    return instance


# --- rows ------------------------------------------------------------------------------------


def test_first_row_is_the_start(c_model: Any) -> None:
    oscillator = started(c_model, "adaptive")
    np.testing.assert_array_equal(oscillator.finish([0.0])[0], [0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    assert oscillator.counts.steps == 0


def test_rows_at_fixed_steps_are_the_states_themselves(c_model: Any) -> None:
    oscillator = started(c_model, "kept")
    for k in range(1, 400):
        row = oscillator.finish([0.01 * k])[0]
        assert oscillator.counts.steps == k
        np.testing.assert_array_equal(row, oscillator.state)
    assert oscillator.time == 399 * 0.01


def test_time_is_counted_and_not_accumulated(c_model: Any) -> None:
    prothero = c_model("prothero_robinson")
    prothero.start("lie", step=1e-3)
    prothero.finish([100.0])
    assert prothero.time == 100.0
    assert prothero.counts.steps == 100_000


@pytest.mark.parametrize("setup", SETUPS)
def test_same_bits_twice(c_model: Any, setup: str) -> None:
    first, second = (started(c_model, setup).finish(GRID) for _ in range(2))
    np.testing.assert_array_equal(first, second)


@pytest.mark.parametrize("setup", SETUPS)
@settings(
    deadline=None, max_examples=15, suppress_health_check=[HealthCheck.function_scoped_fixture]
)
@given(cuts=st.sets(st.integers(1, len(GRID) - 1), max_size=6))
def test_chunks_give_the_bits_of_one_run(c_model: Any, setup: str, cuts: set[int]) -> None:
    whole = started(c_model, setup).finish(GRID)
    chunked = started(c_model, setup)
    edges = [0, *sorted(cuts), len(GRID)]
    rows = [chunked.finish(GRID[a:b]) for a, b in itertools.pairwise(edges)]
    np.testing.assert_array_equal(np.concatenate(rows), whole)


def test_written_state_and_parameters_take_effect(c_model: Any) -> None:
    oscillator = started(c_model, "adaptive")
    oscillator.finish([1.0])
    oscillator.state[:] = [0.0, 5.0]
    assert oscillator.finish([oscillator.time])[0, 1] == 5.0
    oscillator.set(p1=100.0)
    assert oscillator.reset() == "OK"
    assert oscillator.finish([0.0, 0.1])[1, 1] < 0.8


def test_evaluation_at_the_present(c_model: Any) -> None:
    oscillator = started(c_model, "adaptive")
    oscillator.state[:] = [2.0, 1.0]
    f, jac, dfdt, y = np.full(2, np.nan), np.full(3, np.nan), np.full(2, np.nan), np.full(2, np.nan)
    assert oscillator.call("bgc_rhs", f.ctypes) == "OK"
    assert oscillator.call("bgc_jacobian", jac.ctypes, dfdt.ctypes) == "OK"
    assert oscillator.call("bgc_outputs", y.ctypes) == "OK"
    np.testing.assert_allclose(f, [-3.0 - 0.4, 1.0])
    np.testing.assert_allclose(jac, [-0.2, -3.0, 0.5])
    np.testing.assert_allclose(dfdt, [1.0, 0.0])
    np.testing.assert_allclose(y, [2.0, 1.0])


def test_rejected_steps_keep_f_and_its_jacobian(c_model: Any) -> None:
    """The first step takes four more Jacobians, which limit it."""
    robertson = c_model("robertson")
    robertson.start("rodas5p", rtol=1e-6, step=1.0)
    robertson.finish([1.0, 100.0])
    counts = robertson.counts
    assert counts.rejected >= 5
    assert counts.jacobians <= counts.steps + 4
    # Eight stages, and the first is kept; dense output and the first step evaluate f too.
    assert counts.rhs < 8 * (counts.steps + counts.rejected)


# --- saved states ----------------------------------------------------------------------------


@pytest.mark.parametrize("setup", SETUPS)
@pytest.mark.parametrize("at", [0.5, 0.537, 1.03])
def test_restored_run_continues_with_the_same_bits(c_model: Any, setup: str, at: float) -> None:
    original = started(c_model, setup)
    original.finish([0.1, at])
    memory = original.save()
    rest = original.finish(np.linspace(at, 3.0, 23))
    other = c_model("oscillator")
    other.set(p0=7.0)
    other.start("rk4", step=0.5, accounts=SETUPS[setup].get("accounts", False))
    assert other.restore(memory) == "OK"
    np.testing.assert_array_equal(other.finish(np.linspace(at, 3.0, 23)), rest)
    assert original.restore(memory) == "OK"
    np.testing.assert_array_equal(original.finish(np.linspace(at, 3.0, 23)), rest)


def test_restored_run_keeps_a_factorisation_that_fell_back(c_model: Any) -> None:
    pivots = c_model("pivots")
    pivots.set(p0=0.0)
    pivots.start("ros34prw", step=0.1, keep=10)
    pivots.finish([0.3])
    memory = pivots.save()
    rest = pivots.finish([0.5, 2.0])
    other = c_model("pivots")
    assert other.restore(memory) == "OK"
    np.testing.assert_array_equal(other.finish([0.5, 2.0]), rest)


def test_state_of_another_model_is_refused(c_model: Any) -> None:
    oscillator = started(c_model, "adaptive")
    assert oscillator.restore(started(c_model, "adaptive", "pendulum").save()) == "BAD_ARGUMENT"
    assert oscillator.finish([1.0]).shape == (1, 6)


# --- failures --------------------------------------------------------------------------------


def failing(c_model: Any, kind: int, *method: str, **options: float) -> Any:
    instance = c_model("failures")
    instance.set(p0=kind)
    instance.start(*method, **options)
    return instance


def test_finite_escape_keeps_rows_and_last_good_state(c_model: Any) -> None:
    escape = failing(c_model, 0, "rodas5p", rtol=1e-8)
    times = np.linspace(0.0, 1.8, 13)
    status, rows = escape.run(times)
    assert status in ("STEP_TOO_SMALL", "NOT_FINITE")
    assert len(rows) == 7
    np.testing.assert_allclose(rows[:, 0], 1.0 / (1.0 - times[:7]), rtol=1e-5)
    assert escape.time == pytest.approx(1.0, abs=1e-6)
    assert np.isfinite(escape.state).all()
    assert escape.library.bgc_failed_state(escape.data) in (0, 1)


@pytest.mark.parametrize("method", ["rodas5p", "rodas4p2", "radau5", "dopri5"])
def test_the_state_that_escapes_is_reported(c_model: Any, method: str) -> None:
    """Errors of either sign, at the end of the step or within it."""
    escape = failing(c_model, 0, method, rtol=1e-6)
    assert escape.run([2.0])[0] in ("STEP_TOO_SMALL", "NOT_FINITE")
    assert escape.library.bgc_failed_state(escape.data) == 0


def test_end_of_the_domain_is_reported_with_the_state(c_model: Any) -> None:
    for options in ({"name": "rodas5p"}, {"name": "ros34prw", "step": 0.01}):
        root = failing(c_model, 1, **options)
        status, rows = root.run(np.linspace(0.0, 4.0, 41))
        assert status in ("NOT_FINITE", "STEP_TOO_SMALL")
        assert 19 <= len(rows) <= 21
        assert np.isfinite(rows).all()
        assert np.isfinite(root.state).all()
        assert root.library.bgc_failed_state(root.data) == 0


def test_start_without_solution_is_reported(c_model: Any) -> None:
    for kind, status in ((3, "INCONSISTENT"), (4, "SINGULAR")):
        instance = c_model("failures")
        instance.set(p0=kind)
        assert instance.reset() == status
        assert instance.run([1.0])[0] == "BAD_ARGUMENT"


@pytest.mark.parametrize("method", ["ros34prw", "rodas23w", "ros23", "lie"])
@pytest.mark.parametrize("step", [0.25, 0.1, 0.01, 0.0037])
@pytest.mark.parametrize("keep", [1, 3])
def test_fixed_steps_end_where_the_algebraic_equations_lose_their_solution(
    c_model: Any, method: str, step: float, keep: int
) -> None:
    fold = c_model("fold")
    fold.set(p0=1.0)
    fold.start(method, step=step, keep=keep)
    status, rows = fold.run(step * np.arange(round(2.0 / step)))
    assert status in ("INCONSISTENT", "SINGULAR")
    assert 1.0 - 1.01 * step < fold.time < 1.0 + 1e-9
    assert len(rows) == math.floor(fold.time / step + 1e-9) + 1  # the last steps are shorter
    np.testing.assert_allclose(rows[:, 1] ** 2, rows[:, 0], atol=5e-3)
    assert (rows[:, 1] >= 0.0).all()
    assert fold.library.bgc_failed_state(fold.data) == 1
    assert fold.run([2.0])[0] == status


@pytest.mark.parametrize("step", [0.2, 0.01])  # with and without corrections
def test_corrected_run_has_the_same_bits_in_chunks_and_restored(c_model: Any, step: float) -> None:
    whole, chunked, other = (c_model("fold") for _ in range(3))
    grid = np.linspace(0.0, 1.0, 23)
    whole.start("lie", step=step, keep=3)
    chunked.start("lie", step=step, keep=3)
    rows = whole.finish(grid)
    np.testing.assert_array_equal(chunked.finish(grid[:9]), rows[:9])
    assert other.restore(chunked.save()) == "OK"
    np.testing.assert_array_equal(other.finish(grid[9:]), rows[9:])


def test_check_of_algebraic_equations_costs_one_solution_a_step(c_model: Any) -> None:
    fold = c_model("fold")
    fold.start("lie", step=0.01)
    fold.finish([1.0])
    assert fold.counts.solves == 2 * fold.counts.steps
    assert fold.counts.factorisations == fold.counts.steps
    row = 10  # evaluations at most that the one row takes, which satisfies the equations exactly
    assert fold.counts.rhs - fold.counts.steps in range(1, row)
    assert fold.counts.jacobians - fold.counts.steps in range(row)


def test_failed_assertion_stops_where_it_fails(c_model: Any) -> None:
    oscillator = c_model("oscillator")
    oscillator.start("rodas5p", rtol=1e-9)
    times = np.linspace(0.0, 20.0, 401)
    free = oscillator.finish(times)
    oscillator.set(p3=1.05)
    oscillator.start("rodas5p", rtol=1e-9)
    status, rows = oscillator.run(times)
    assert status == "ASSERTION"
    assert oscillator.library.bgc_failed_assertion(oscillator.data) == 0
    crossing = int(np.argmax(free[:, 1] >= 1.05))
    assert len(rows) == crossing  # every row before the event, though the step went beyond it
    np.testing.assert_allclose(rows, free[:crossing], atol=1e-7)
    assert oscillator.state[1] == pytest.approx(1.05, abs=1e-6)
    assert oscillator.state[1] < 1.05
    assert oscillator.run([20.0])[0] == "ASSERTION"


def test_failed_assertion_at_a_fixed_step_goes_back_one_step(c_model: Any) -> None:
    oscillator = c_model("oscillator")
    oscillator.set(p3=1.05)
    oscillator.start("ros34prw", step=0.01)
    assert oscillator.run([20.0])[0] == "ASSERTION"
    assert oscillator.state[1] < 1.05
    before = oscillator.time
    assert oscillator.run([20.0])[0] == "ASSERTION"
    assert oscillator.time == before == pytest.approx(0.01 * round(before / 0.01))


def test_assertion_that_fails_at_the_start(c_model: Any) -> None:
    oscillator = c_model("oscillator")
    oscillator.set(p3=0.5)
    oscillator.start("rodas5p")
    status, rows = oscillator.run([0.0, 1.0])
    assert (status, len(rows)) == ("ASSERTION", 0)


@pytest.mark.parametrize(
    ("values", "index"),
    [({"p0": -1.0}, 0), ({"p0": 101.0}, 0), ({"p2": float("nan")}, 2), ({"p0": 0.0}, 4)],
)
def test_parameter_out_of_range(c_model: Any, values: dict[str, float], index: int) -> None:
    oscillator = c_model("oscillator")
    oscillator.set(**values)
    assert oscillator.reset() == "BAD_PARAMETER"
    assert oscillator.library.bgc_failed_parameter(oscillator.data) == index


def test_defaults_that_depend_on_parameters(c_model: Any) -> None:
    oscillator = c_model("oscillator")

    def damping() -> float:
        return float(oscillator.library.bgc_get_param(oscillator.model, oscillator.data, 2))

    oscillator.set(p0=75.0)
    assert damping() == pytest.approx(30.0)
    oscillator.set(p2=1.0)
    assert damping() == 1.0
    assert oscillator.call("bgc_set_param", -1, c_double(0.0)) == "OK"
    assert damping() == 0.4
    assert np.isnan(oscillator.library.bgc_get_param(oscillator.model, oscillator.data, 9))


def test_wrong_arguments(c_model: Any) -> None:
    oscillator = c_model("oscillator")
    assert oscillator.run([1.0])[0] == "BAD_ARGUMENT"  # before any reset
    assert oscillator.options("euler") == "BAD_ARGUMENT"
    assert oscillator.options("ros34prw") == "BAD_ARGUMENT"  # without a step
    assert oscillator.options("rodas5p", rtol=-1.0) == "BAD_ARGUMENT"
    assert oscillator.options("rodas5p", rtol=float("nan")) == "BAD_ARGUMENT"
    assert oscillator.options("rodas5p", max_step=float("inf")) == "BAD_ARGUMENT"
    assert oscillator.reset(float("nan")) == "BAD_ARGUMENT"
    oscillator.start("rodas5p")
    for times in ([1.0, 0.5], [float("nan")], [float("inf")], [-1.0]):
        assert oscillator.run(times)[0] == "BAD_ARGUMENT"
    oscillator.finish([5.0])
    assert oscillator.run([0.1])[0] == "BAD_ARGUMENT"  # long past


def test_too_many_steps_and_then_on(c_model: Any) -> None:
    whole = started(c_model, "adaptive").finish([3.0])
    oscillator = c_model("oscillator")
    oscillator.start(**SETUPS["adaptive"], max_steps=3)
    for attempts in range(1, 1000):
        status, rows = oscillator.run([3.0])
        if status == "OK":
            break
        assert status == "TOO_MANY_STEPS"
        assert oscillator.counts.steps + oscillator.counts.rejected == 3 * attempts
    np.testing.assert_array_equal(rows, whole)


def test_stop_from_another_thread_and_then_on(c_model: Any) -> None:
    pendulum = c_model("pendulum")
    pendulum.start("ros34prw", step=1e-6)
    timer = threading.Timer(0.05, pendulum.library.bgc_stop, [pendulum.data])
    timer.start()
    begun = time.monotonic()
    assert pendulum.run([1e9])[0] == "INTERRUPTED"
    assert time.monotonic() - begun < 5.0
    timer.join()
    assert pendulum.run([pendulum.time + 1e-6])[0] == "OK"


def test_every_status_has_a_text(c_model: Any) -> None:
    library = c_model("kaps").library
    texts = [library.bgc_status_text(status).decode() for status in Status]
    assert len(set(texts)) == len(Status)
    assert "unknown status" not in texts
    assert library.bgc_status_text(len(Status)).decode() == "unknown status"


# --- energy ----------------------------------------------------------------------------------


def test_energy_residual_of_a_driven_damped_oscillator(c_model: Any) -> None:
    oscillator = c_model("oscillator")
    oscillator.start("rodas5p", accounts=True, rtol=1e-12)
    rows = oscillator.finish(np.linspace(0.0, 20.0, 333))
    p, q, stored, supplied, dissipated, residual = rows.T
    np.testing.assert_allclose(stored, 0.25 * p**2 + 1.5 * q**2 - 1.5, atol=1e-12)
    assert np.abs(residual).max() < 1e-10
    assert dissipated[-1] > 1.0
    assert supplied[-1] > 1.0
    assert (np.diff(dissipated) >= 0.0).all()
    oscillator.finish([oscillator.time])
    account = oscillator.energy()
    assert abs(account[3]) < 1e-10


@pytest.mark.parametrize(
    ("method", "order"), [("rodas5p", 4.5), ("rodas4p2", 3.5), ("ros34prw", 3), ("rk4", 4)]
)
def test_energy_residual_has_the_order_of_the_method(
    c_model: Any, method: str, order: float
) -> None:
    residuals = []
    for step in (0.1, 0.05, 0.025):
        oscillator = c_model("oscillator")
        adaptive = {"max_step": step, "rtol": 1e3} if method.startswith("rodas") else {}
        oscillator.start(method, accounts=True, step=step, **adaptive)
        residuals.append(np.abs(oscillator.finish(np.linspace(0.0, 10.0, 101))[:, -1]).max())
    assert np.log2(residuals[0] / residuals[2]) / 2.0 > order - 0.3


@pytest.mark.parametrize("damping", [0.0, 0.4])
@pytest.mark.parametrize("step", [0.01, 0.3])
@pytest.mark.parametrize("method", ["midpoint", "gauss4"])
def test_symmetric_methods_balance_energy_to_rounding(
    c_model: Any, method: str, step: float, damping: float
) -> None:
    oscillator = c_model("oscillator")
    oscillator.set(p2=damping)
    oscillator.start(method, accounts=True, step=step)
    stored, supplied, dissipated, residual = oscillator.finish(step * np.arange(10000))[:, -4:].T
    exchanged = max(np.abs(account).max() for account in (stored, supplied, dissipated))
    assert np.abs(residual).max() < 5e-15 * len(residual) * exchanged  # rounding of each step


@pytest.mark.parametrize(("setup", "most"), [("adaptive", 1e-5), ("fixed", 0.0)])
def test_accounts_change_the_solution_by_no_more_than_their_steps_do(
    c_model: Any, setup: str, most: float
) -> None:
    with_accounts = started(c_model, setup).finish(GRID)
    plain = c_model("oscillator")
    plain.start(**{**SETUPS[setup], "accounts": False})
    np.testing.assert_allclose(plain.finish(GRID), with_accounts[:, :2], rtol=0, atol=most)


# --- the code itself -------------------------------------------------------------------------


@pytest.mark.slow
def test_runtime_and_model_compile_as_one_unit(
    tmp_path: Path, compile_c: Any, runtime_c: Path
) -> None:
    unit = tmp_path / "all.c"
    model = Path(__file__).parent / "cmodels" / "oscillator.c"
    includes = [f'#include "{source}"' for source in (*runtime_sources(runtime_c).values(), model)]
    unit.write_text("\n".join(includes) + "\n")
    compile_c("-O0", f"-I{runtime_c}", "-c", unit, "-o", tmp_path / "all.o", warnings=True)


@pytest.mark.skipif(which("nm") is None, reason="needs nm")
def test_nothing_is_allocated_or_printed_while_running(runtime_objects: list[Path]) -> None:
    for item in runtime_objects:
        done = subprocess.run(["nm", "-u", item], capture_output=True, text=True, check=True)
        used = {line.split()[-1].split("@")[0] for line in done.stdout.splitlines()}
        # complex.c when a method is chosen; matrices.c for dense factors of over 1,000 states;
        # a driver or an FMU when it is opened
        if item.stem not in {
            "instance",
            "complex",
            "matrices",
            "fmus",
            "fmus2",
            "fmus3",
            *driver_names(),
        }:
            assert not used & {"malloc", "calloc", "realloc", "free", "aligned_alloc"}, item
        assert not used & {"printf", "puts", "fprintf", "exit", "abort", "stdout", "stderr"}, item
