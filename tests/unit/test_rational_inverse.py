"""Inverses of rational matrices, against elimination in fractions and against the matrix itself."""

import random
from fractions import Fraction
from operator import mul

import pytest

from bgc.algebra import rational_inverse
from bgc.algebra.rational_inverse import SingularRowsError, inverse_of

Rows = list[list[Fraction]]


def coupled(size: int, units: float = 0.0, near: float = 0.0) -> Rows:
    """A symmetric definite matrix of decimals; the condition number is about 10^(units or near)."""
    rng = random.Random(size)
    basis = [[rng.uniform(-1, 1) for _ in range(size)] for _ in range(size)]
    for k, row in enumerate(basis):
        row[:] = [10 ** (-near / 2 * k / size) * x for x in row]
    scale = [10 ** (units / 2 * k / size) for k in range(size)]
    return [
        [
            Fraction(scale[i] * scale[j] * sum(r[i] * r[j] for r in basis))
            for j in range(size)
        ]
        for i in range(size)
    ]  # fmt: skip


def nearest(matrix: Rows) -> list[list[float]]:
    return [[float(x) for x in row] for row in rational_inverse._eliminated(matrix, None)]


@pytest.mark.parametrize("matrix", [
    coupled(9), coupled(10, near=8), coupled(9, units=24),
    [[x + Fraction(i / 7.1) for x in row] for i, row in enumerate(coupled(9))],
    [[x * (i != j) for j, x in enumerate(row)] for i, row in enumerate(coupled(9))],
], ids=["coupled", "near singular", "in other units", "not symmetric", "no diagonal"])  # fmt: skip
def test_a_long_calculation_gives_the_nearest_doubles(matrix: Rows) -> None:
    expected = nearest(matrix)
    assert rational_inverse._by_newton(matrix) == expected
    assert inverse_of(matrix) == expected


def test_a_field_of_many_ports_is_not_eliminated_in_fractions(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    size = 24
    matrix = coupled(size)
    monkeypatch.setattr(rational_inverse, "_eliminated", _only_short)
    found = inverse_of(matrix)
    assert all(found[i][j] == found[j][i] for i in range(size) for j in range(i))
    product = [
        [sum(map(mul, row, column)) for column in zip(*found, strict=True)] for row in matrix
    ]
    assert all(abs(product[i][j] - (i == j)) < 1e-12 for i in range(size) for j in range(size))


def _only_short(matrix: Rows, longest: int | None) -> Rows:
    """Elimination whose numbers become too long at once."""
    assert longest is not None, "finished in fractions"
    raise rational_inverse._LongError


def test_entries_that_vanish_are_exactly_zero() -> None:
    wanted = coupled(8)
    wanted[0][7] = wanted[7][0] = Fraction(0)
    full = rational_inverse._eliminated(wanted, None)
    assert rational_inverse._by_newton(full) is None
    assert inverse_of(full) == wanted


def test_short_numbers_stay_exact() -> None:
    size = 20
    matrix = [[Fraction(min(i, j) + 1, 3) for j in range(size)] for i in range(size)]
    found = inverse_of(matrix)
    assert found[0][:3] == [6, -3, 0]
    assert found[-1][-2:] == [-3, 3]


def test_numbers_beyond_doubles_are_eliminated_in_fractions() -> None:
    matrix = coupled(8)
    matrix[0] = [x * Fraction(10) ** 700 if j else x for j, x in enumerate(matrix[0])]
    assert inverse_of(matrix) == rational_inverse._eliminated(matrix, None)


@pytest.mark.parametrize("factor", [Fraction(1), Fraction(1) + Fraction(1, 2**80)])
def test_a_singular_matrix_is_refused_and_a_nearly_singular_one_is_not(factor: Fraction) -> None:
    matrix = coupled(9)
    matrix[3] = [2 * x for x in matrix[5]]
    matrix[3][0] *= factor
    if factor == 1:
        with pytest.raises(SingularRowsError):
            inverse_of(matrix)
        return
    found = inverse_of(matrix)
    assert found == rational_inverse._eliminated(matrix, None)
