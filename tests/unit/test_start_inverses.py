"""Inverses of large matrices of parameters, which a run computes when parameters are set."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from programs import CompiledModel, make_program, states

import bgc
from bgc.algebra.dag import Dag, Kind, Op, Symbol
from bgc.algebra.derivatives import directional_derivative, gradient
from bgc.algebra.double_inverse import inverse_in_doubles
from bgc.algebra.evaluate import evaluate_nodes
from bgc.algebra.fingerprint import Fingerprints
from bgc.algebra.infix import infix_lines
from bgc.algebra.linalg import SingularMatrixError, inverse, multiply, spelled_out
from bgc.algebra.nodes import Matrix
from bgc.algebra.rounding import RoundedEvaluator
from bgc.emission import inverses
from bgc.emission.emit import emit_model
from bgc.emission.simplification import optimise

SIZE = 9
Array = npt.NDArray[np.float64]


def matrices() -> dict[str, Array]:
    rng = np.random.default_rng(3)
    full = rng.normal(size=(SIZE, SIZE))
    saddle = full + full.T
    saddle[-3:, -3:] = 0
    np.fill_diagonal(saddle, 0)
    units = np.logspace(-9, 6, SIZE)
    return {
        "symmetric": full @ full.T + np.eye(SIZE),
        "full": full,
        "without a diagonal": saddle,
        "of many units": (full @ full.T + np.eye(SIZE)) * np.outer(units, units),
    }


def parameters(dag: Dag, array: Array) -> tuple[Matrix, dict[Symbol, float]]:
    """A matrix of parameters (mirrored entries are one), and their values."""
    number: dict[tuple[int, int], int] = {}
    values = {}
    symmetric = np.array_equal(array, array.T)
    for i, j in np.ndindex(*array.shape):
        place = (max(i, j), min(i, j)) if symmetric else (i, j)
        k = number.setdefault(place, len(number))
        values[Symbol(Kind.PARAM, k)] = float(array[i, j])
    rows = [[number.get((i, j), number.get((j, i))) for j in range(SIZE)] for i in range(SIZE)]
    return tuple(tuple(dag.symbol(Kind.PARAM, k) for k in row) for row in rows), values


def flat(rows: Matrix) -> list[int]:
    return [node for row in rows for node in row]


def distance(found: object, expected: Array) -> float:
    """The largest difference relative to the sizes of the row and the column of each entry."""
    found = np.reshape(found, expected.shape)
    size = np.sqrt(np.outer(np.abs(np.diag(expected)), np.abs(np.diag(expected))))
    return float((np.abs(found - expected) / np.maximum(size, np.abs(expected))).max())


@pytest.mark.parametrize("name", matrices())
def test_values_are_those_of_numpy(name: str) -> None:
    array, dag = matrices()[name], Dag()
    matrix, values = parameters(dag, array)
    first = len(dag)
    found = inverse(dag, matrix)
    assert len(dag) - first <= 3 * SIZE**2 + 2  # numbers of places among them
    expected = np.linalg.inv(array)
    assert distance(evaluate_nodes(dag, flat(found), values), expected) < 1e-13
    if name != "without a diagonal":  # spelled out, it divides by the diagonal
        spelled = spelled_out(dag, flat(found))
        assert all(dag.op[node] != Op.INVERTED for node in dag.reachable(spelled))
        assert distance(evaluate_nodes(dag, spelled, values), expected) < 1e-11
    rounded = RoundedEvaluator(dag, values.__getitem__).values(flat(found))
    for each, exact in zip(rounded, expected.ravel(), strict=True):
        assert abs(each.value - exact) <= 8 * each.error
        assert each.error < 1e-9 * np.abs(expected).max()


@pytest.mark.parametrize("rank", [SIZE - 1, 1, 0])
def test_the_inverse_of_a_singular_matrix_is_undefined(rank: int) -> None:
    basis = np.random.default_rng(1).normal(size=(SIZE, rank))
    assert np.isnan(inverse_in_doubles((basis @ basis.T).ravel().tolist())).all()


def test_matrices_that_are_always_singular_are_found() -> None:
    dag = Dag()
    p = [dag.symbol(Kind.PARAM, k) for k in range(SIZE)]
    with pytest.raises(SingularMatrixError):
        inverse(dag, tuple(tuple(dag.mul(a, b) for b in p) for a in p))


def test_fingerprints_know_the_product_with_the_inverse() -> None:
    dag = Dag()
    matrix, _ = parameters(dag, matrices()["full"])
    product = multiply(dag, matrix, inverse(dag, matrix))
    fingerprints = Fingerprints(dag)
    for i, j in np.ndindex(SIZE, SIZE):
        assert fingerprints.constant(product[i][j]) == (i == j)


@pytest.mark.parametrize("name", ["symmetric", "full"])
def test_derivatives_by_parameters(name: str) -> None:
    array, dag = matrices()[name], Dag()
    matrix, values = parameters(dag, array)
    entry = inverse(dag, matrix)[4][2]
    symbols = [dag.symbol(Kind.PARAM, k) for k in (0, 7, 20)]
    back = gradient(dag, entry, symbols)
    along = [directional_derivative(dag, entry, {symbol: dag.one}) for symbol in symbols]
    found_by = [evaluate_nodes(dag, slopes, values) for slopes in (back, along)]
    for k, *found in zip((0, 7, 20), *found_by, strict=True):
        step = 1e-5
        ends = [{**values, Symbol(Kind.PARAM, k): values[Symbol(Kind.PARAM, k)] + s}
                for s in (step, -step)]  # fmt: skip
        (high,), (low,) = (evaluate_nodes(dag, [entry], point) for point in ends)
        assert found == [pytest.approx((high - low) / (2 * step), rel=1e-6, abs=1e-8)] * 2


@pytest.mark.parametrize("as_table", [False, True])
def test_c_computes_inverses_and_inverses_of_inverses(
    as_table: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Rates Y x of Y = (X + 1)^-1 with X = A^-1, for parameters that are set twice."""
    if as_table:
        monkeypatch.setattr(inverses, "_LONG", 0)
    dag = Dag()
    array = matrices()["full"]
    matrix, values = parameters(dag, array)
    within = inverse(dag, matrix)
    moved = tuple(
        tuple(dag.add(x, dag.one) if i == j else x for j, x in enumerate(row))
        for i, row in enumerate(within)
    )
    outer = inverse(dag, moved)
    x = states(dag, SIZE)
    given = [(f"p{k}", dag.const(value)) for k, value in enumerate(values.values())]
    program = make_program(
        dag,
        [dag.dot(row, x) for row in outer],
        parameters=given,
        outputs=[within[1][2], dag.mul(within[3][4], x[0])],
        initial=[outer[0][k] for k in range(SIZE)],
    )
    model = CompiledModel(emit_model(optimise(program), ""), tmp_path, list(values.values()))
    place = np.linspace(1, 2, SIZE)
    for factor in (1.0, 3.0):
        model.set_parameters([factor * value for value in values.values()])
        first = np.linalg.inv(factor * array)
        second = np.linalg.inv(first + np.eye(SIZE))
        rates = model._evaluate("rhs", SIZE, 0.0, place, np.zeros(1))
        assert rates == pytest.approx(second @ place, rel=1e-12)
        outputs = model._evaluate("outputs", 2, 0.0, place, np.zeros(1))
        assert outputs == pytest.approx([first[1, 2], first[3, 4]], rel=1e-12)
    model.set_parameters([0.0] * len(values))
    assert np.isnan(model._evaluate("rhs", SIZE, 0.0, place, np.zeros(1))).all()


def test_text_names_the_first_entry_and_the_place() -> None:
    dag = Dag()
    matrix, _ = parameters(dag, matrices()["full"])
    node = dag.add(inverse(dag, matrix)[2][3], dag.one)
    assert infix_lines(dag, [("y", node)], lambda s: f"p{s.index}") == [
        "y = 1 + inv([p0, ..])[3, 4]"
    ]


# --- models -------------------------------------------------------------------------------------

FIELD = """
model Coils {{
  param a = 0.5; param b = 2;
  param M = b*eye(9) + a*outer(ones(9), ones(9));
  supply : Se[9](e = [1, 2, 3, 4, 5, 6, 7, 8, 9]); all : J1[9]; coils : I[9](M);
  loss : R[9](1); {more}
  supply -> all -> coils, loss{to_more};
}}
scene rise of Coils {{ observe coils.f as currents; run 1 s every 1 s; }}
"""
DRIVE = np.arange(1.0, 10.0)


def inertia(a: float = 0.5, b: float = 2.0) -> Array:
    return b * np.eye(SIZE) + a * np.ones((SIZE, SIZE))


def currents(mass: Array) -> Array:
    """The currents after a second: `M i' = e - i` from rest, by modes."""
    weights, modes = np.linalg.eigh(mass)
    return modes @ ((1 - np.exp(-1 / weights)) * (modes.T @ DRIVE))


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> bgc.Model:
    path = tmp_path_factory.mktemp("field") / "field.bg"
    path.write_text(FIELD.format(more="", to_more=""), "utf-8")
    return bgc.compile(path)


def test_a_field_follows_its_parameters(model: bgc.Model) -> None:
    assert np.asarray(model.jacobian()) == pytest.approx(-np.linalg.inv(inertia()), rel=1e-13)
    for a, b in ((0.5, 2.0), (-0.1, 3.0)):
        found = model.simulate(parameters={"a": a, "b": b}, rtol=1e-9)["currents"][-1]
        assert found == pytest.approx(currents(inertia(a, b)), rel=1e-7)


def test_a_field_in_lanes(model: bgc.Model) -> None:
    values = np.linspace(0.1, 0.9, 8)
    ensemble = model.simulate_many({"a": values}, solver="rk4", step=0.05)
    for a, found in zip(values, ensemble["currents"], strict=True):
        alone = model.simulate(parameters={"a": a}, solver="rk4", step=0.05)["currents"]
        assert found == pytest.approx(alone, rel=1e-13)


def test_a_singular_field_is_refused(model: bgc.Model) -> None:
    with pytest.raises(bgc.BgError, match="matrix of `M` must not be singular"):
        model.simulate(parameters={"a": -2 / 9})


def test_sensitivities_by_differences(model: bgc.Model) -> None:
    """The slope of the currents by a, from runs, against the derivative of the exact solution."""
    runs = [model.simulate(parameters={"a": a}, rtol=1e-11) for a in (0.501, 0.499)]
    high, low = (run["currents"][-1] for run in runs)
    exact = (currents(inertia(0.501)) - currents(inertia(0.499))) / 2e-3
    assert (high - low) / 2e-3 == pytest.approx(exact, rel=1e-5)


def test_a_field_in_derivative_causality(tmp_path: Path) -> None:
    path = tmp_path / "merged.bg"
    path.write_text(FIELD.format(more="more : I[9](2);", to_more=", more"), "utf-8")
    found = bgc.compile(path).simulate(rtol=1e-9)["currents"][-1]
    assert found == pytest.approx(currents(inertia() + 2 * np.eye(SIZE)), rel=1e-7)
