"""Rigid chains whose speeds are unknowns of the linear systems, against speeds solved for in f."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass

import numpy as np
import pytest
from chains import (
    arm_of_boxes,
    binary,
    chain,
    elimination_products,
    kept_vertices,
    lowered,
    operations,
    solved_in_f,
)
from mounted_arms import NOTHING_ALIGNED, mounted_arm
from numpy.typing import NDArray
from own_caches import with_runtime

import bgc
from bgc.algebra.dag import Kind, Symbol
from bgc.algebra.evaluate import evaluate_nodes
from bgc.emission import least_cost
from bgc.ir.defaults import default_values
from bgc.ir.lowered import Lowered

Floats = NDArray[np.float64]

ON_A_VESSEL = "hull : FreeBody(mass = 500 kg, inertia = 300*eye(3)); ground : J1; hull -> ground;"
MECHANISMS = {
    "arm on a vessel": chain(5, base=ON_A_VESSEL),
    "tree": chain(7, binary),
    "skew, floating": mounted_arm(2, 6, "free", NOTHING_ALIGNED).source,
    "aligned, floating": mounted_arm(3, 6, "free", (0, 90)).source,
}


def local_matrix(found: Lowered, states: Floats) -> Floats:
    """The entries of the Jacobian with inner unknowns, as a matrix."""
    program, jacobian = found.program, found.jacobian
    values = dict(default_values(program.dag, program.parameters))
    values[Symbol(Kind.TIME, 0)] = 0.3
    values |= {Symbol(Kind.STATE, k): x for k, x in enumerate(states.tolist())}
    matrix = np.zeros((jacobian.size, jacobian.size))
    entries = evaluate_nodes(program.dag, jacobian.entries, values)
    matrix[jacobian.rows, jacobian.columns] = entries
    return matrix


def iteration_matrix(found: Lowered, states: Floats, c: float) -> Floats:
    """W = c M - J with inner unknowns, where M is the identity."""
    diagonal = np.zeros(found.jacobian.size)
    diagonal[: len(found.program.states)] = c
    return np.diag(diagonal) - local_matrix(found, states)


def slopes(found: Lowered, states: Floats) -> Floats:
    """df/dx, where inner unknowns are eliminated by NumPy."""
    matrix, n = local_matrix(found, states), len(found.program.states)
    inner = np.linalg.solve(matrix[n:, n:], matrix[n:, :n])
    return matrix[:n, :n] - matrix[:n, n:] @ inner


@pytest.mark.parametrize("name", MECHANISMS)
def test_the_jacobian_is_that_of_explicit_rates(name: str) -> None:
    source = MECHANISMS[name]
    found = lowered(source)
    with solved_in_f():
        explicit = lowered(source)
    assert found.jacobian.inner > 0 and explicit.jacobian.inner == 0
    assert operations(found) < 0.9 * operations(explicit)
    assert {*zip(explicit.jacobian.rows, explicit.jacobian.columns, strict=True)} <= {
        *found.jacobian.slopes
    }
    rng = np.random.default_rng(4)
    for _ in range(3):
        states = rng.uniform(-1, 1, len(found.program.states))
        expected = slopes(explicit, states)
        error = np.abs(slopes(found, states) - expected).max()
        assert error <= 1e-10 * np.abs(expected).max()


def test_kept_vertices_have_pivots_of_one_and_leave_the_others() -> None:
    """The order is safe: pivots are those of the accumulated matrix in the same order."""
    with kept_vertices():
        found = lowered(MECHANISMS["tree"])
    accumulated = lowered(MECHANISMS["tree"])
    plan, few = found.plan, accumulated.jacobian.size
    assert found.jacobian.size > few + 10 and plan.columns == plan.rows
    assert all(plan.units[k, k] == 1 for k, row in enumerate(plan.rows) if row >= few)
    states = np.random.default_rng(2).uniform(-1, 1, len(found.program.states))
    np.testing.assert_allclose(slopes(found, states), slopes(accumulated, states), atol=1e-9)
    mine = pivots_of(iteration_matrix(found, states, 50.0), plan.rows)
    order = [row for row in plan.rows if row < few]
    expected = pivots_of(iteration_matrix(accumulated, states, 50.0), order)
    kept = [x for row, x in zip(plan.rows, mine, strict=True) if row < few]
    np.testing.assert_allclose(kept, expected, rtol=1e-9)


def pivots_of(matrix: Floats, order: Sequence[int]) -> list[float]:
    """The pivots of elimination on the diagonal in a given order."""
    left = matrix[np.ix_(order, order)].copy()
    for k in range(len(left)):
        left[k + 1 :, k:] -= np.outer(left[k + 1 :, k] / left[k, k], left[k, k:])
    return np.diag(left).tolist()


def test_operations_of_an_arm_grow_hardly_more_than_its_length() -> None:
    counts = [operations(lowered(arm_of_boxes(bodies))) for bodies in (12, 24)]
    assert math.log2(counts[1] / counts[0]) < 1.3
    assert counts[0] < 33_000


def test_the_order_of_elimination_follows_an_arm_with_slides() -> None:
    """Slides reach fewer vertices than hinges further out: in that order the ratio was 2.9."""
    few, many = (elimination_products(arm_of_boxes(n, slides=True)) for n in (12, 20))
    assert many / few < 2.3


@pytest.mark.parametrize("slides", [False, True])
def test_bounds_on_the_work_leave_the_cheapest_form(
    slides: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    source = arm_of_boxes(8, slides)
    monkeypatch.setattr(least_cost, "_LONG", 0)
    monkeypatch.setattr(least_cost, "_KEEPING_OPERATIONS", 0)
    bounded = operations(lowered(source))
    monkeypatch.setattr(least_cost, "_NODES", 1e9)
    assert bounded == operations(lowered(source))


# --- runs --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Pair:
    """The same scene with inner unknowns, and with speeds solved for in f."""

    inner: bgc.Model
    explicit: bgc.Model


@pytest.fixture(scope="module")
def models(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bgc.Model]:
    """An arm with speeds as unknowns, with intermediate values too, and with neither."""
    folder = tmp_path_factory.mktemp("arm")
    path = folder / "arm.bg"
    path.write_text(chain(4), "utf-8")
    found = {}
    forms = {"speeds": nullcontext(), "kept": kept_vertices(), "explicit": solved_in_f()}
    for name, form in forms.items():
        with pytest.MonkeyPatch.context() as patch, form:  # the keys of the cache hold the source
            patch.setenv("BGC_CACHE_DIR", str(with_runtime(folder / name)))
            found[name] = bgc.compile(path)
    sizes = {name: model.library.model.n_lu for name, model in found.items()}
    assert len(set(sizes.values())) == 3
    return found


@pytest.fixture(params=["speeds", "kept"])
def arm(models: dict[str, bgc.Model], request: pytest.FixtureRequest) -> Pair:
    return Pair(models[request.param], models["explicit"])


def test_the_jacobian_of_a_compiled_model_is_that_of_differences(arm: Pair) -> None:
    rng = np.random.default_rng(1)
    start = arm.inner.initial_state()
    for _ in range(3):
        x = start + rng.uniform(-0.3, 0.3, len(start))
        dense = arm.inner.jacobian(x)
        assert np.abs(dense - arm.explicit.jacobian(x)).max() <= 1e-12 * np.abs(dense).max()
        for k in range(len(x)):
            shift = np.zeros(len(x))
            shift[k] = 1e-6
            change = (arm.inner.rhs(x + shift) - arm.inner.rhs(x - shift)) / 2e-6
            np.testing.assert_allclose(
                dense[:, k], change, rtol=1e-5, atol=1e-6 * np.abs(dense).max()
            )


@pytest.mark.parametrize(
    ("solver", "options"),
    [
        ("ros34prw", {"step": 1e-3}),
        ("ros23", {"step": 2e-3}),
        ("rodas5p", {"rtol": 1e-8}),
        ("rodas4p2", {"rtol": 1e-8}),
        ("radau5", {"rtol": 1e-8}),
        ("gauss4", {"step": 5e-3}),
        ("dopri5", {"rtol": 1e-8}),
    ],
)
def test_runs_are_those_of_explicit_rates(
    arm: Pair, solver: str, options: dict[str, float]
) -> None:
    runs = [model.simulate(solver=solver, **options) for model in (arm.inner, arm.explicit)]
    for name in ("last", "first", "stored"):
        np.testing.assert_allclose(runs[0][name], runs[1][name], rtol=1e-9, atol=1e-10)
    counts = runs[0].counts
    assert counts["steps"] == runs[1].counts["steps"]
    assert counts["refinements"] == counts["fallbacks"] == 0
    assert np.abs(runs[0]["residual"]).max() < 1e-4 * np.ptp(runs[0]["stored"])


@pytest.mark.slow
def test_cvode_gets_the_whole_jacobian(arm: Pair) -> None:
    runs = [model.simulate(solver="cvode", rtol=1e-9) for model in (arm.inner, arm.explicit)]
    np.testing.assert_allclose(runs[0]["last"], runs[1]["last"], rtol=1e-7, atol=1e-9)


def test_stiffness_and_linear_forms_use_the_whole_jacobian(arm: Pair) -> None:
    runs = [m.simulate(solver="rodas5p", rtol=1e-6) for m in (arm.inner, arm.explicit)]
    assert runs[0].counts["fastest"] == pytest.approx(runs[1].counts["fastest"], rel=1e-6)
    np.testing.assert_allclose(
        np.sort_complex(arm.inner.eigenvalues(arm.inner.initial_state())),
        np.sort_complex(arm.explicit.eigenvalues(arm.explicit.initial_state())),
        rtol=1e-9,
        atol=1e-9,
    )


@pytest.mark.parametrize("solver", ["ros34prw", "rodas5p"])
def test_lanes_take_the_same_steps(arm: Pair, solver: str) -> None:
    options = {"step": 1e-3} if solver == "ros34prw" else {"rtol": 1e-7}
    angles = np.linspace(0.1, 0.6, 5)
    ensemble = arm.inner.simulate_many({"joint0.angle0": angles}, solver=solver, **options)
    assert ensemble.together == 5
    for angle, last in zip(angles, ensemble["last"], strict=True):
        alone = arm.inner.simulate(solver=solver, parameters={"joint0.angle0": angle}, **options)
        np.testing.assert_allclose(last, alone["last"], rtol=1e-6, atol=1e-8)


def test_scales_of_masses_far_apart_are_pivoted(arm: Pair) -> None:
    """Masses over sixteen decades: the check of solutions decides, and the runs agree."""
    masses = {f"mass{k}": 10.0 ** (5 - 5 * k) for k in range(4)}
    runs = [
        model.simulate(0.01, every=0.01, solver="ros34prw", step=1e-3, parameters=masses)
        for model in (arm.inner, arm.explicit)
    ]
    np.testing.assert_allclose(runs[0]["first"], runs[1]["first"], rtol=1e-6)
