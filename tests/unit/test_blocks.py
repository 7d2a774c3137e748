"""LU factors in blocks of rows: the plan, and the runtime's kernels against dense solutions."""

from __future__ import annotations

import ctypes
from collections.abc import Collection
from ctypes import POINTER, c_double, c_int, c_void_p
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import run_compiler

from bgc.building.build import runtime_directory
from bgc.emission.block_tables import BlockTables, lay_out_blocks
from bgc.emission.blocks import MOST_ROWS, plan_blocks
from bgc.emission.factorisation import choose_blocks
from bgc.emission.sparse import plan_pattern
from bgc.ir.lowered import BlockPlan

SHIM = Path(__file__).parent / "cprograms" / "block_trial.c"
SETS = {
    "native": ("-march=native",),
    "avx2": ("-march=x86-64-v3",),
    "plain": ("-DBGC_NO_VECTORS",),
}
CPU = Path("/proc/cpuinfo")


class BlockInfo(ctypes.Structure):
    """`bgc_block_info`."""

    _fields_ = [
        *((name, c_int) for name in ("n_block", "n_place", "in_lanes")),
        *((f"list{k}", POINTER(c_int)) for k in range(9)),
    ]


@pytest.fixture(scope="module", params=SETS)
def kernels(request: Any, tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """The runtime's kernels, compiled for this machine's registers, for AVX2 and for none."""
    if request.param == "avx2" and not (CPU.exists() and " avx2 " in CPU.read_text("ascii")):
        pytest.skip("the processor has no AVX2")
    folder = tmp_path_factory.mktemp("blocks")
    target = folder / "blocks.so"
    files = [runtime_directory() / f"{name}.c" for name in ("block_pivots", "blocks")]
    flags = ("-O1", "-ffp-contract=fast", f"-I{runtime_directory()}", *SETS[request.param])
    run_compiler(*flags, "-shared", SHIM, *files, "-o", target, "-lm")
    return ctypes.CDLL(str(target))


def planned(
    size: int,
    mass: list[tuple[int, int]] | None,
    jacobian: list[tuple[int, int]],
    pivots: Collection[tuple[int, int]] = (),
) -> tuple[BlockPlan, BlockTables]:
    """Blocks of a pattern, and their tables; without `mass` M is the identity.

    Pivots are on the diagonal, then among `pivots`.
    """
    own = [(k, k) for k in range(size)] if mass is None else mass
    plan = plan_pattern(size, {*own, *pivots}, jacobian)
    blocks = plan_blocks(plan, {*own, *jacobian})
    numbered = None if mass is None else {place: k for k, place in enumerate(mass)}
    return blocks, lay_out_blocks(blocks, numbered, {place: k for k, place in enumerate(jacobian)})


def solve(
    kernels: ctypes.CDLL,
    tables: BlockTables,
    mass: np.ndarray,
    jac: np.ndarray,
    c: complex,
    b: np.ndarray,
    scale: np.ndarray | None = None,
) -> tuple[int, float, np.ndarray]:
    """Status, growth and (c M - J)^-1 b; every result and all scratch is NaN before the call."""
    rows = (np.ravel(tables.blocks), *tables.arrays.values())
    lists = [np.array([*row, 0], dtype=np.int32) for row in rows]
    pointers = [each.ctypes.data_as(POINTER(c_int)) for each in lists]
    info = BlockInfo(len(tables.blocks) - 1, tables.places, 0, *pointers)
    is_complex = isinstance(c, complex)
    lu = np.full((1 + is_complex) * tables.factors, np.nan)
    work, growth = np.full(18 * tables.places, np.nan), np.full(1, np.nan)
    x = b.astype(complex if is_complex else float)
    shift = (c_double(c.real), c_double(c.imag)) if is_complex else (c_double(c.real),)
    function = kernels.complex_trial if is_complex else kernels.trial
    scale = np.ones(len(b)) if scale is None else scale
    arrays = [c_void_p(each.ctypes.data) for each in (scale, mass, jac, lu, growth, work, x)]
    status = function(ctypes.byref(info), len(b), len(mass), *arrays[:3], *shift, *arrays[3:])
    return status, float(growth[0]), x


def dense(size: int, places: list[tuple[int, int]], entries: np.ndarray) -> np.ndarray:
    matrix = np.zeros((size, size))
    for (row, column), entry in zip(places, entries, strict=True):
        matrix[row, column] += entry
    return matrix


def random_pattern(rng: np.random.Generator, size: int) -> list[tuple[int, int]]:
    """Entries near the diagonal and far from it, not symmetric, of several densities."""
    count, band = int(size * rng.uniform(0.5, 4)), int(rng.integers(1, 9))
    rows = rng.integers(0, size, count)
    near = zip(rows, rows + rng.integers(-band, band + 1, count), strict=True)
    far = rng.integers(0, size, (int(size * rng.uniform(0, 0.5)), 2))
    arrow = [(size // 2, j) for j in range(size)] if rng.random() < 0.3 else []
    return sorted({(int(i), int(j)) for i, j in (*near, *far, *arrow) if 0 <= j < size})


@pytest.mark.slow
@pytest.mark.parametrize("c", [37.0, 31.0 + 22.0j], ids=["real", "complex"])
def test_solutions_are_those_of_dense_elimination(kernels: ctypes.CDLL, c: complex) -> None:
    rng = np.random.default_rng(5)
    sizes = set()
    for trial in range(120):
        size = int(rng.integers(1, 70))
        jacobian = random_pattern(rng, size)
        blocks, tables = planned(size, None, jacobian)
        sizes.update(blocks.sizes)
        entries = rng.normal(size=len(jacobian))
        b = rng.normal(size=size) + (1j * rng.normal(size=size) if isinstance(c, complex) else 0)
        status, growth, x = solve(kernels, tables, np.zeros(0), entries, c, b)
        assert status == 0 and growth > 0.5 * size, trial
        expected = np.linalg.solve(c * np.eye(size) - dense(size, jacobian, entries), b)
        np.testing.assert_allclose(x, expected, rtol=1e-9, atol=1e-11 * np.abs(expected).max())
    assert sizes == set(range(1, MOST_ROWS + 1))


def one_block(size: int) -> BlockTables:
    full = [(i, j) for i in range(size) for j in range(size)]
    everything = tuple(range(size))
    plan = BlockPlan(everything, everything, (size,), ((),), ((),))
    return lay_out_blocks(plan, {}, {place: k for k, place in enumerate(full)})


def test_units_choose_no_pivots(kernels: ctypes.CDLL) -> None:
    """The small pivot is the largest of its row where columns are not in units of the states."""
    matrix, columns = np.array([[2**-33, 1], [1, 1]]), np.array([1, 2**-40])
    scaled = matrix / columns[:, None] * columns
    x = np.array([0.3, 0.7]) / columns
    for c in (0.0, 0j):
        status, _, found = solve(
            kernels, one_block(2), np.ones(1), -scaled.ravel(), c, scaled @ x, 1 / columns
        )
        assert status == 0
        np.testing.assert_allclose(found, x, rtol=1e-13)


@pytest.mark.parametrize("size", [0, 1, 40, 300])
def test_a_chain_is_cut_into_few_blocks(size: int) -> None:
    """A band of width 4 has no fill: blocks of 8 rows, one left of each."""
    band = banded(size, 4)
    plan = plan_pattern(size, [(k, k) for k in range(size)], band)
    blocks = plan_blocks(plan, band)
    assert sum(blocks.sizes) == size and len(blocks.sizes) <= size / 4 + 2
    assert sum(map(len, blocks.left)) <= 2 * len(blocks.sizes)
    assert sorted(zip(blocks.rows, blocks.columns, strict=True)) == [(k, k) for k in range(size)]


def banded(size: int, half: int) -> list[tuple[int, int]]:
    return [(i, j) for i in range(size) for j in range(max(0, i - half), min(size, i + half + 1))]


def lattice(size: int) -> list[tuple[int, int]]:
    """Each node of a square grid with its neighbours."""
    return [
        (size * i + j, size * k + m)
        for i in range(size)
        for j in range(size)
        for k, m in ((i - 1, j), (i + 1, j), (i, j - 1), (i, j + 1))
        if 0 <= k < size and 0 <= m < size
    ]


@pytest.mark.parametrize(
    ("size", "pattern", "in_blocks"),
    [
        (40, banded(40, 8), False),  # few operations
        (400, banded(400, 12), True),  # as a crane of 30 bodies
        (144, lattice(12), False),  # few rows with the same pattern
    ],
    ids=["small", "band", "lattice"],
)
def test_blocks_are_chosen_where_rows_have_the_same_pattern(
    size: int, pattern: list[tuple[int, int]], in_blocks: bool
) -> None:
    own = [(k, k) for k in range(size)]
    plan = plan_pattern(size, own, pattern)
    assert (choose_blocks(plan, {*own, *pattern}) is not None) == in_blocks
