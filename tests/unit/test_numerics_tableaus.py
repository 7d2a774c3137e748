"""The committed coefficients: order conditions, stability, and index-1 conditions.

Explicit and collocation methods are read as Rosenbrock methods without Gamma. In their usual form,
with beta = alpha + Gamma, the condition of a rooted tree takes alpha at vertices with several
branches and beta at those with one: E. Hairer, G. Wanner, Solving Ordinary Differential Equations
II, IV.7 (order) and VI.4 (index 1). A W-method takes alpha or Gamma at the latter, in all
combinations, and each with a Gamma sums to nothing.
"""

from __future__ import annotations

import ctypes
import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from bgc.language.methods import METHODS

Floats = npt.NDArray[np.float64]
Tree = tuple["Tree", ...]

ROSENBROCK = tuple(method.name for method in METHODS.values() if method.family.name == "Rosenbrock")
COLLOCATION = tuple(method.name for method in METHODS.values() if "colloc" in method.family.name)
ADAPTIVE = tuple(m.name for m in METHODS.values() if not m.fixed and m.name not in COLLOCATION)
DIVISIBLE = tuple(method.name for method in METHODS.values() if method.embedded_order)
STIFFLY_ACCURATE = ("rodas5p", "rodas4p2", "ros34prw", "rodas23w", "lie", "radau5")
L_STABLE = (*ROSENBROCK, "radau5")
TOLERANCE = 5e-11


class CTableau(ctypes.Structure):
    _fields_ = (
        *((name, ctypes.c_int) for name in ("stages", "w_order", "dense")),
        ("gamma", ctypes.c_double),
        ("a", ctypes.c_double * 64),
        ("c", ctypes.c_double * 64),
        *((name, ctypes.c_double * 8) for name in ("m", "alpha", "g", "e", "embedded")),
        ("h", ctypes.c_double * 24),
    )


class CCollocation(ctypes.Structure):
    _fields_ = (
        ("stages", ctypes.c_int),
        *((name, ctypes.c_double * 3) for name in ("node", "weight", "last", "e")),
        ("value", ctypes.c_double),
        ("left", ctypes.c_double * 3),
        ("right", ctypes.c_double * 3),
        ("value2", ctypes.c_double * 2),
        ("left2", ctypes.c_double * 6),
        ("right2", ctypes.c_double * 6),
    )


class CMethod(ctypes.Structure):
    _fields_ = (
        ("name", ctypes.c_char_p),
        ("family", ctypes.c_void_p),
        ("tableau", ctypes.POINTER(CTableau)),
        ("collocation", ctypes.POINTER(CCollocation)),
        *((name, ctypes.c_int) for name in ("order", "error_order")),
        *((name, ctypes.c_int) for name in ("embedded_order", "substeps")),
        ("partner", ctypes.c_char_p),
        ("check_dense", ctypes.c_int),
        ("purpose", ctypes.c_char_p),
    )


@dataclass(frozen=True)
class Tableau:
    """A committed tableau: orders, and its coefficients in the usual form."""

    order: int
    w_order: int
    error_order: int
    embedded_order: int
    dense: int
    nodes: Floats
    slopes: Floats
    alpha: Floats
    gamma: Floats
    b: Floats
    error: Floats
    embedded: Floats
    interpolant: Floats  # one row for each power of the dense output's nesting

    @property
    def beta(self) -> Floats:
        return self.alpha + self.gamma

    def dense_weights(self, s: float) -> Floats:
        """Weights of the solution at the fraction s of a step."""
        k1, k2, k3 = self.interpolant
        weights: Floats = s * (self.b + (1.0 - s) * (k1 + s * (k2 + s * k3)))
        return weights


@pytest.fixture(scope="module")
def tableaus(c_library: Any) -> dict[str, Tableau]:
    library = c_library("kaps")
    found = {}
    for method in (CMethod * len(METHODS)).in_dll(library, "bgc_methods"):
        if method.collocation:
            found[method.name.decode()] = collocation(method)
            continue
        raw = method.tableau.contents
        n = raw.stages

        def square(values: Any, n: int = n) -> Floats:
            return np.array(values).reshape(8, 8)[:n, :n]

        gamma = np.zeros((n, n))
        change = np.eye(n)  # from the committed variables to the usual ones
        if raw.gamma:
            gamma = change = np.linalg.inv(np.eye(n) / raw.gamma - square(raw.c))
        found[method.name.decode()] = Tableau(
            method.order,
            raw.w_order,
            method.error_order,
            method.embedded_order,
            raw.dense,
            nodes=np.array(raw.alpha)[:n],
            slopes=np.array(raw.g)[:n],
            alpha=square(raw.a) @ change,
            gamma=gamma,
            b=np.array(raw.m)[:n] @ change,
            error=np.array(raw.e)[:n] @ change,
            embedded=np.array(raw.embedded)[:n] @ change,
            interpolant=np.array(raw.h).reshape(3, 8)[:, :n] @ change,
        )
    return found


def collocation(method: CMethod) -> Tableau:
    """The method behind the eigenvectors of its inverse matrix."""
    raw = method.collocation.contents
    n = raw.stages

    def pair(values: Any) -> Any:
        re, im = np.array(values).reshape(2, -1)
        return (re + 1j * im)[:n]

    inverse = np.zeros((n, n))
    if n % 2:
        inverse += raw.value * np.outer(np.array(raw.right)[:n], np.array(raw.left)[:n])
    if n > 1:
        value = complex(*raw.value2)
        inverse += 2.0 * (value * np.outer(pair(raw.right2), pair(raw.left2))).real
    matrix = np.linalg.inv(inverse)
    none = np.zeros(n)
    weights = np.array(raw.last)[:n] @ matrix
    np.testing.assert_allclose(np.array(raw.weight)[:n], weights, atol=1e-15)
    return Tableau(
        method.order,
        0,
        method.error_order,
        method.embedded_order,
        0,
        nodes=np.array(raw.node)[:n],
        slopes=none,
        alpha=matrix,
        gamma=np.zeros((n, n)),
        b=weights,
        error=np.array(raw.e)[:n],  # weights of the stages less y, not of the slopes
        embedded=np.zeros(n),
        interpolant=np.zeros((3, n)),
    )


def trees(order: int) -> list[Tree]:
    """All rooted trees with so many vertices."""

    def forests(vertices: int, largest: int) -> Iterator[Tree]:
        if vertices == 0:
            yield ()
        for first in range(min(vertices, largest), 0, -1):
            for tree in trees(first):
                for rest in forests(vertices - first, first):
                    if not rest or size(rest[0]) < first or rest[0] <= tree:
                        yield (tree, *rest)

    return list(forests(order - 1, order - 1))


def size(tree: Tree) -> int:
    return 1 + sum(size(branch) for branch in tree)


def density(tree: Tree) -> int:
    product = size(tree)
    for branch in tree:
        product *= density(branch)
    return product


def single_branches(tree: Tree) -> int:
    return (len(tree) == 1) + sum(single_branches(branch) for branch in tree)


def elementary_weights(tree: Tree, alpha: Floats, single: Iterator[Floats]) -> Floats:
    """One number a stage; each vertex with one branch takes the next matrix of `single`."""
    matrix = next(single) if len(tree) == 1 else alpha
    product = np.ones(len(alpha))
    for branch in tree:
        product = product * (matrix @ elementary_weights(branch, alpha, single))
    return product


def assert_order(tableau: Tableau, weights: Floats, order: int, s: float = 1.0) -> None:
    for vertices in range(1, order + 1):
        for tree in trees(vertices):
            found = weights @ elementary_weights(
                tree, tableau.alpha, itertools.repeat(tableau.beta)
            )
            assert found == pytest.approx(s**vertices / density(tree), abs=TOLERANCE), tree


def test_number_of_rooted_trees() -> None:
    assert [len(trees(order)) for order in range(1, 7)] == [1, 1, 2, 4, 9, 20]


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_order_conditions(tableaus: dict[str, Tableau], method: str) -> None:
    assert_order(tableaus[method], tableaus[method].b, tableaus[method].order)


@pytest.mark.parametrize("method", METHODS)
def test_order_is_not_higher_than_stated(tableaus: dict[str, Tableau], method: str) -> None:
    with pytest.raises(AssertionError):
        assert_order(tableaus[method], tableaus[method].b, tableaus[method].order + 1)


@pytest.mark.parametrize("method", ADAPTIVE)
def test_embedded_solution_has_its_order_and_no_more(
    tableaus: dict[str, Tableau], method: str
) -> None:
    tableau = tableaus[method]
    assert_order(tableau, tableau.b - tableau.error, tableau.error_order)
    with pytest.raises(AssertionError):
        assert_order(tableau, tableau.b - tableau.error, tableau.error_order + 1)


@pytest.mark.parametrize("method", DIVISIBLE)
def test_embedded_solution_of_sub_steps_has_its_order_and_no_more(
    tableaus: dict[str, Tableau], method: str
) -> None:
    tableau = tableaus[method]
    assert tableau.embedded_order == tableau.order - 1 or method == "rk4"
    assert_order(tableau, tableau.b - tableau.embedded, tableau.embedded_order)
    with pytest.raises(AssertionError):
        assert_order(tableau, tableau.b - tableau.embedded, tableau.embedded_order + 1)


@pytest.mark.parametrize(("method", "order"), [("rodas5p", 4), ("rodas4p2", 3), ("dopri5", 4)])
@pytest.mark.parametrize("s", [0.1, 0.37, 0.5, 0.9])
def test_dense_output_order_conditions(
    tableaus: dict[str, Tableau], method: str, order: int, s: float
) -> None:
    tableau = tableaus[method]
    assert_order(tableau, tableau.dense_weights(s), order, s)


@pytest.mark.parametrize("method", METHODS)
def test_order_with_any_matrix_for_the_jacobian(tableaus: dict[str, Tableau], method: str) -> None:
    tableau = tableaus[method]
    for vertices in range(1, tableau.w_order + 1):
        for tree in trees(vertices):
            for picks in itertools.product((0, 1), repeat=single_branches(tree)):
                matrices = iter([(tableau.alpha, tableau.gamma)[pick] for pick in picks])
                found = tableau.b @ elementary_weights(tree, tableau.alpha, matrices)
                expected = 0.0 if any(picks) else 1.0 / density(tree)
                assert found == pytest.approx(expected, abs=TOLERANCE), (tree, picks)


@pytest.mark.parametrize("method", METHODS)
def test_nodes_are_the_sums_of_their_rows(tableaus: dict[str, Tableau], method: str) -> None:
    tableau = tableaus[method]
    np.testing.assert_allclose(tableau.nodes, tableau.alpha.sum(axis=1), atol=1e-12)
    np.testing.assert_allclose(tableau.slopes, tableau.gamma.sum(axis=1), atol=1e-12)


@pytest.mark.parametrize("method", COLLOCATION)
def test_eigenvectors_of_a_collocation_method(tableaus: dict[str, Tableau], method: str) -> None:
    """The matrix behind them is that of collocation: exact for polynomials up to the stages."""
    tableau = tableaus[method]
    for power in range(1, len(tableau.b) + 1):
        left = tableau.alpha @ tableau.nodes ** (power - 1)
        np.testing.assert_allclose(left, tableau.nodes**power / power, atol=1e-14)


def test_error_of_radau5_vanishes_up_to_order_3(tableaus: dict[str, Tableau]) -> None:
    """`h f(t, y) + sum e_i Z_i` does for y' = p t^(p - 1) from 0, whose stages are c^p."""
    radau = tableaus["radau5"]
    found = [radau.error @ radau.nodes**power for power in range(1, radau.error_order + 1)]
    np.testing.assert_allclose(found, [-1.0, 0.0, 0.0], atol=1e-14)


@pytest.mark.parametrize("method", ["midpoint", "gauss4"])
def test_symplectic(tableaus: dict[str, Tableau], method: str) -> None:
    a, b = tableaus[method].alpha, tableaus[method].b
    np.testing.assert_allclose(b[:, None] * a + (b[:, None] * a).T, np.outer(b, b), atol=1e-15)


@pytest.mark.parametrize("y", [0.1, 3.0, 1e3])
@pytest.mark.parametrize("method", ["midpoint", "gauss4"])
def test_oscillations_keep_their_amplitude(
    tableaus: dict[str, Tableau], method: str, y: float
) -> None:
    a, b = tableaus[method].alpha, tableaus[method].b
    one = np.ones(len(b))
    growth = 1.0 + 1j * y * (b @ np.linalg.solve(np.eye(len(b)) - 1j * y * a, one))
    assert abs(growth) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("method", ["rk4", "heun"])
def test_some_estimate_of_an_explicit_method_is_large_wherever_it_is_unstable(
    tableaus: dict[str, Tableau], method: str
) -> None:
    """A correction above 0.15 of the range is told of: `corrections.c`."""
    tableau, ones = tableaus[method], np.ones(len(tableaus[method].b))
    for z in np.add.outer(np.linspace(-12, 0, 241), 1j * np.linspace(0, 12, 241)).ravel():
        stages = np.linalg.solve(np.eye(len(ones)) - z * tableau.alpha, z * ones)
        growth = abs(1 + tableau.b @ stages)
        if growth > 1.0001:
            part = max(abs(tableau.error @ stages), abs(tableau.embedded @ stages)) / growth
            assert part > 0.15 or abs(z) < 0.9, z


@pytest.mark.parametrize("method", L_STABLE)
def test_stability_function_on_the_imaginary_axis_and_at_infinity(
    tableaus: dict[str, Tableau], method: str
) -> None:
    tableau = tableaus[method]
    one = np.ones(len(tableau.b))
    assert 1.0 - tableau.b @ np.linalg.solve(tableau.beta, one) == pytest.approx(0.0, abs=1e-12)
    largest = 0.0
    for y in np.concatenate([np.linspace(0.0, 20.0, 801), np.geomspace(20.0, 1e6, 200)]):
        resolvent = np.linalg.solve(np.eye(len(one)) - 1j * y * tableau.beta, one)
        largest = max(largest, abs(1.0 + 1j * y * (tableau.b @ resolvent)))
    assert largest <= 1.0 + 1e-11


@pytest.mark.parametrize("method", STIFFLY_ACCURATE)
def test_stiffly_accurate(tableaus: dict[str, Tableau], method: str) -> None:
    tableau = tableaus[method]
    np.testing.assert_allclose(tableau.b, tableau.beta[-1], atol=1e-12)


@pytest.mark.parametrize("method", [m for m in ROSENBROCK if m not in ("lie", "ros23")])
def test_index_1_conditions(tableaus: dict[str, Tableau], method: str) -> None:
    tableau = tableaus[method]
    omega = np.linalg.inv(tableau.beta)
    c = tableau.nodes
    assert tableau.b @ omega @ c**2 == pytest.approx(1.0, abs=TOLERANCE)
    if tableau.order >= 3:
        assert tableau.b @ omega @ c**3 == pytest.approx(1.0, abs=TOLERANCE)
    if tableau.order >= 4:
        inner = tableau.alpha @ omega @ c**2
        assert tableau.b @ (c * inner) == pytest.approx(0.25, abs=TOLERANCE)
        assert tableau.b @ omega @ (c * inner) == pytest.approx(1.0, abs=TOLERANCE)
