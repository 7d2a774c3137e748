"""Events: steps end where a law switches, and what that is worth."""

from __future__ import annotations

import ctypes
import itertools
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from scipy.linalg import expm
from scipy.optimize import brentq

Floats = npt.NDArray[np.float64]

GAP, PUSH = 0.5, 2.0
END = 3.0
FREE = np.array([[0, 1, 0], [-9, 0, 0], [0, 0, 0.0]])  # of x, v, 1
STOPPED = np.array([[0, 1, 0], [-49, -2, 40 * GAP], [0, 0, 0.0]])
SETUPS: dict[str, dict[str, Any]] = {
    "adaptive": {"name": "rodas5p", "rtol": 1e-7, "accounts": True},
    "fixed": {"name": "ros34prw", "step": 0.013, "accounts": True},
    "kept": {"name": "ros34prw", "step": 0.01, "keep": 5},
    "explicit": {"name": "rk4", "step": 0.01, "accounts": True},
    "collocation": {"name": "radau5", "rtol": 1e-7, "accounts": True},
}
FIXED = ("fixed", "kept", "explicit")
GRID = np.concatenate([[0.0, 0.001], np.linspace(0.05, END, 60)])


def pieces(pushed_from: float = np.inf) -> Iterator[tuple[float, Floats, Floats]]:
    """Start, state (x, v, 1) and matrix of each piece of the motion."""
    t, y, stopped = 0.0, np.array([0.0, 3.0, 1.0]), False
    while True:
        matrix = (STOPPED if stopped else FREE).copy()
        matrix[1, 2] += PUSH * (t >= pushed_from)
        yield t, y, matrix
        touch = t + next_touch(matrix, y, stopped)
        pushed = t < pushed_from <= touch
        stopped = stopped if pushed else not stopped
        end = pushed_from if pushed else touch
        t, y = end, expm(matrix * (end - t)) @ y


def next_touch(matrix: Floats, y: Floats, stopped: bool) -> float:
    """Time until the stop is left, or met."""
    scan = 1e-3
    step = expm(matrix * scan)
    k, ahead = 0, y
    while ((ahead := step @ ahead)[0] > GAP) == stopped and k * scan < END:
        k += 1
    if k * scan >= END:
        return 2 * END

    def over(s: float) -> float:
        return float((expm(matrix * s) @ y)[0] - GAP)

    return float(brentq(over, max(k * scan, 1e-6), (k + 1) * scan, xtol=1e-15))


def exact(times: Floats, pushed_from: float = np.inf) -> Floats:
    """Displacement and velocity at rising times."""
    rows = []
    for (start, y, matrix), (end, _, _) in itertools.pairwise(pieces(pushed_from)):
        here = [t for t in times[len(rows) :] if t < end or start > END]
        rows += list((expm(np.multiply.outer(np.subtract(here, start), matrix)) @ y)[:, :2])
        if len(rows) == len(times):
            break
    return np.array(rows)


@pytest.fixture(scope="module")
def truth() -> Floats:
    return exact(GRID)


def started(c_model: Any, setup: str, model: str = "stop") -> Any:
    instance = c_model(model)
    instance.start(**SETUPS[setup])
    return instance


def end_error(instance: Any, truth: Floats) -> float:
    return float(np.abs(instance.finish([END])[0, :2] - truth[-1]).max())


# --- accuracy --------------------------------------------------------------------------------


@pytest.mark.slow
def test_contacts_at_tight_tolerance(c_model: Any, truth: Floats) -> None:
    stop = c_model("stop")
    stop.start("rodas5p", rtol=1e-11, atol=1e-12)
    np.testing.assert_allclose(stop.finish(GRID), truth, atol=3e-10)
    switches = exact(np.linspace(0, END, 3001)) > [GAP, 0]  # contact, and the way it moves
    assert stop.counts.events == np.count_nonzero(np.diff(switches, axis=0))


@pytest.mark.parametrize(("method", "order"), [("ros34prw", 3), ("rodas23w", 2), ("rk4", 4)])
def test_fixed_steps_keep_their_order_across_events(
    c_model: Any, truth: Floats, method: str, order: int
) -> None:
    errors = []
    for step in (0.02, 0.01, 0.005, 0.0025, 0.00125):
        stop = c_model("stop")
        stop.start(method, step=step)
        errors.append(end_error(stop, truth))
    # Where in a step the events fall varies, so the order is that of the whole range.
    assert np.log2(errors[0] / errors[-1]) / 4 > order - 0.1


def test_without_location_the_order_is_lost(c_model: Any, truth: Floats) -> None:
    errors = []
    for step in (0.01, 0.0025, 0.000625):
        unlocated = c_model("stop_unlocated")
        unlocated.start("ros34prw", step=step)
        errors.append(end_error(unlocated, truth))
    assert np.log2(errors[0] / errors[-1]) / 4 < 1.6


def test_rodas5p_keeps_its_order_across_events(c_model: Any, truth: Floats) -> None:
    errors = []
    for longest in (0.08, 0.04, 0.02, 0.01):
        stop = c_model("stop")
        stop.start("rodas5p", rtol=1e3, atol=1e3, step=longest, max_step=longest)
        errors.append(end_error(stop, truth))
    assert np.log2(errors[0] / errors[-1]) / 3 > 4.5


def test_location_is_cheaper_than_grinding(c_model: Any, truth: Floats) -> None:
    cost, error = {}, {}
    for name in ("stop", "stop_unlocated"):
        model = c_model(name)
        model.start("rodas5p", rtol=1e-8)
        error[name] = end_error(model, truth)
        cost[name] = model.counts.rhs
    assert cost["stop"] < 0.8 * cost["stop_unlocated"]
    assert error["stop"] < error["stop_unlocated"]


@pytest.mark.parametrize("setup", ["adaptive", "fixed", "explicit", "collocation"])
def test_energy_is_accounted_for_up_to_each_event(c_model: Any, setup: str) -> None:
    stop = started(c_model, setup)
    rows = stop.finish(GRID)
    assert np.abs(rows[:, 5]).max() < {"adaptive": 1e-6, "collocation": 1e-5}.get(setup, 1e-3)
    assert rows[-1, 4] > 2  # what the stop has dissipated


# --- time events -----------------------------------------------------------------------------


@pytest.mark.parametrize("setup", SETUPS)
def test_a_switch_of_time_is_landed_on(c_model: Any, setup: str) -> None:
    stop = c_model("stop")
    stop.set(p1=1.2345)
    stop.start(**SETUPS[setup])
    times = np.linspace(0, END, 31)
    found = stop.finish(times)[:, :2]
    error = np.abs(found - exact(times, pushed_from=1.2345)).max()
    assert error < {"adaptive": 2e-6, "collocation": 2e-5}.get(setup, 1e-3)


@pytest.mark.parametrize("setup", SETUPS)
def test_a_step_ends_exactly_at_a_switch_of_time(c_model: Any, setup: str) -> None:
    stop = c_model("stop")
    stop.set(p1=1.2345)
    stop.start(**SETUPS[setup])
    stop.finish([1.2345])
    assert stop.time == np.nextafter(1.2345, 2)  # the first time that is greater


# --- steps -----------------------------------------------------------------------------------


@pytest.mark.parametrize("setup", FIXED)
def test_fixed_steps_return_to_their_grid(c_model: Any, setup: str) -> None:
    stop = started(c_model, setup)
    step = Fraction(str(SETUPS[setup]["step"]))
    for k in range(1, int(END / step)):
        row = stop.finish([float(k * step)])[0]
        assert stop.time == float(k * step)
        np.testing.assert_array_equal(row[:2], stop.state)
    assert stop.counts.events > 5
    # An event splits a step in two.
    assert stop.counts.steps == k + stop.counts.events


@pytest.mark.parametrize("setup", SETUPS)
def test_same_bits_twice_and_in_chunks(c_model: Any, setup: str) -> None:
    whole = started(c_model, setup).finish(GRID)
    np.testing.assert_array_equal(started(c_model, setup).finish(GRID), whole)
    chunked = started(c_model, setup)
    rows = [chunked.finish(GRID[k : k + 7]) for k in range(0, len(GRID), 7)]
    np.testing.assert_array_equal(np.concatenate(rows), whole)


@pytest.mark.parametrize("setup", SETUPS)
@pytest.mark.parametrize("at", [0.2, 0.31, 1.03])  # in contact, between events of one step, later
def test_a_restored_run_continues_with_the_same_bits(c_model: Any, setup: str, at: float) -> None:
    original = started(c_model, setup)
    original.finish([0.1, at])
    memory = original.save()
    rest = original.finish(np.linspace(at, END, 23))
    other = c_model("stop")
    other.start("rk4", step=0.5, accounts=SETUPS[setup].get("accounts", False))
    assert other.restore(memory) == "OK"
    np.testing.assert_array_equal(other.finish(np.linspace(at, END, 23)), rest)
    assert other.counts.events == original.counts.events


def test_a_state_that_is_written_takes_its_own_modes(c_model: Any) -> None:
    stop = started(c_model, "adaptive")
    stop.finish([0.1])
    stop.state[:] = [0.8, 0.0]  # inside the stop
    f = np.full(2, np.nan)
    assert stop.call("bgc_rhs", f.ctypes) == "OK"
    np.testing.assert_allclose(f, [0, -9 * 0.8 - 40 * 0.3])
    start = stop.time
    row = stop.finish([start + 1e-3])[0]
    np.testing.assert_allclose(row[1], f[1] * 1e-3, rtol=3e-3)


@pytest.mark.parametrize("setup", SETUPS)
def test_arguments_behind_the_rates_cost_no_evaluation_and_change_no_bit(
    c_model: Any, setup: str
) -> None:
    """f at the end of a step is that of the next, but at events and where steps are rejected."""
    stop, kept = (started(c_model, setup, model) for model in ("stop", "stop_kept"))
    calls = [ctypes.c_int.in_dll(model.library, "switch_calls") for model in (stop, kept)]
    before = [count.value for count in calls]
    np.testing.assert_array_equal(kept.finish(GRID), stop.finish(GRID))
    alone, behind = (count.value - first for count, first in zip(calls, before, strict=True))
    assert alone - behind > 0.9 * stop.counts.steps
    for k in range(100):  # calls of about a step each, between which x may be written
        np.testing.assert_array_equal(*(model.finish([END + 0.01 * k]) for model in (kept, stop)))
    lost = stop.counts.events + stop.counts.rejected
    assert kept.counts.rhs <= stop.counts.rhs + lost


def test_a_variation_that_grows_unseen_by_the_ends_of_steps_is_found(c_model: Any) -> None:
    """Steps far from an edge are examined within less often, by how far they are."""
    swelling = c_model("swelling")
    swelling.start("ros34prw", step=0.01)
    (row,) = swelling.finish([0.6])
    times = (np.arange(600_000) + 0.5) * 1e-6
    above = 1e-6 * 1.3 ** (100 * times) * np.sin(100 * np.pi * times) ** 2 < 1.0
    assert row[1] == pytest.approx(above.sum() * 1e-6, abs=1e-5)
    assert 0.02 < 0.6 - row[1] < 0.04


# --- chattering ------------------------------------------------------------------------------


@pytest.mark.parametrize("setup", SETUPS)
def test_a_law_that_drives_back_to_its_switch_from_both_sides_ends_the_run(
    c_model: Any, setup: str
) -> None:
    stop = c_model("stop")
    stop.set(p0=100.0, p2=50.0)  # pushes back as long as it moves forward: it cannot stop at 0
    stop.start(**SETUPS[setup])
    stop.state[:] = [-1.0, 1.0]
    status, _ = stop.run([END])
    assert status == "CHATTERING"
    assert stop.library.bgc_failed_switch(stop.data) == 2
    assert abs(stop.state[1]) < 1e-10
    assert stop.counts.events <= 110
