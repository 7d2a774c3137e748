"""The guard of the linear algebra: growth, refinement, dense fallback."""

from __future__ import annotations

import ctypes
import shutil
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Floats, run_compiler

from bgc.building.build import runtime_directory
from bgc.driver import compile_scene
from bgc.emission.emit import amalgamate
from bgc.options import Options
from bgc.runtime.running.binding import Instance, Library
from bgc.runtime.running.structures import OptionsStruct, Status

CORPUS = Path(__file__).parents[1] / "models"
TIMES = np.linspace(0.0, 2.0, 5)
INFINITE = "(1e300 * 1e300)"  # in C, where math.h is not included


def solve_pivots(instance: Any, tiny: float) -> Any:
    instance.set(p0=tiny)
    instance.start("rodas5p", rtol=1e-8)
    return instance


@pytest.mark.parametrize("tiny", [1e-6, 1e-10, 1e-14, 1e-17, 0.0])
@pytest.mark.parametrize("model", ["pivots", "pivots_unreported"])
def test_pivots_that_vanish_are_caught(c_model: Any, model: str, tiny: float) -> None:
    pivots = solve_pivots(c_model(model), tiny)
    rows = pivots.finish(TIMES)
    np.testing.assert_allclose(rows[:, 2], np.exp(-TIMES), atol=1e-5 if tiny > 1e-7 else 1e-7)
    if 1e-12 < tiny < 1e-9:
        assert pivots.counts.refinements > 0
        assert pivots.counts.fallbacks == 0
    if tiny < 1e-15:
        assert pivots.counts.fallbacks > 0


def test_without_the_guard_the_same_model_fails(
    c_model: Any, compile_c: Any, runtime_c: Path, runtime_objects: list[Path], tmp_path: Path
) -> None:
    source = (runtime_c / "solutions.h").read_text()
    unguarded = source.replace("bgc_acceptable = 1e-11;", f"bgc_acceptable = {INFINITE};")
    assert unguarded != source
    (tmp_path / "solutions.h").write_text(unguarded)  # found before that of the runtime
    (tmp_path / "linear.c").write_text((runtime_c / "linear.c").read_text())
    others = [item for item in runtime_objects if item.stem != "linear"]
    model = Path(__file__).parent / "cmodels" / "pivots.c"
    target = tmp_path / "pivots.so"
    compile_c(
        f"-I{runtime_c}", "-shared", tmp_path / "linear.c", model, *others, "-o", target, "-lm"
    )
    pivots = solve_pivots(c_model("pivots", ctypes.CDLL(str(target))), 1e-17)
    pivots.options("rodas5p", rtol=1e-8, max_steps=1000)
    status, rows = pivots.run(TIMES)
    assert status != "OK" or np.abs(rows[:, 2] - np.exp(-TIMES)).max() > 1e-3


def test_solutions_are_checked_for_a_while_after_a_large_growth(c_library: Any) -> None:
    static, once, watched = range(3)  # bgc_pivoting
    choose = c_library("kaps").bgc_choose_checks
    choose.argtypes = (ctypes.c_long, ctypes.c_double, ctypes.POINTER(ctypes.c_int))
    left = ctypes.c_int(0)

    def chosen(numbers: range, growth: float) -> list[int]:
        return [choose(number, growth, left) for number in numbers]

    assert chosen(range(1, 34), 1e5) == [once, *[static] * 15, once, *[static] * 15, once]
    assert chosen(range(34, 35), 1.1e5) == [watched]
    assert chosen(range(35, 134), 1.0) == [watched] * 99
    assert chosen(range(134, 146), 1.0) == [*[static] * 11, once]


def test_well_behaved_pivots_cost_nothing(c_model: Any) -> None:
    for stiffness in (1e4, 1e8, 1e14):
        pendulum = c_model("pendulum")
        pendulum.set(p0=stiffness)
        pendulum.start("ros34prw", step=1e-3)
        pendulum.finish([1.0])
        assert pendulum.counts.refinements == pendulum.counts.fallbacks == 0


def solve_dense(library: ctypes.CDLL, matrix: Floats, b: Floats) -> tuple[Floats, list[int]]:
    """The solution, and the row that partial pivoting takes for each pivot."""
    n, doubles = len(b), ctypes.POINTER(ctypes.c_double)
    lu, x, pivot = matrix.copy(), b.copy(), (ctypes.c_int * n)()
    factors = lu.ctypes.data_as(doubles)
    assert library.bgc_factorise_dense(n, factors, pivot, (ctypes.c_double * n)()) == -1
    library.bgc_solve_dense.restype = None
    library.bgc_solve_dense(n, factors, pivot, x.ctypes.data_as(doubles))
    return x, list(pivot)


def as_doubles(values: Floats) -> Any:
    return values.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


@pytest.mark.parametrize(
    ("factors", "first"),
    [
        ([[2.0, 1.0], [1.0, 1.0]], -1),
        ([[1.0, 1.0], [-1.0, 8.0e-16]], 1),  # below the rounding of two terms, 2 * 2 epsilon
        ([[1.0, 1.0], [-1.0, 1.0e-15]], -1),
        ([[1.0, 1.0], [1.0, -8.0e-16]], 1),  # whatever its sign
        ([[1.0, 0.0, 0.0], [0.0, 1.0, 1.0], [0.0, 1.0, 1.0e-15]], 2),  # a later term
        ([[1.0, 0.0, 2.0], [0.0, 1.0, 2.0], [1.0, -1.0, 5.0e-15]], 2),  # terms that cancel
        ([[0.0]], 0),
    ],
)
def test_a_pivot_of_rounding_errors_is_found(
    c_library: Any, factors: list[list[float]], first: int
) -> None:
    lu = np.array(factors)
    assert c_library("kaps").bgc_rounded_pivot(len(lu), as_doubles(lu)) == first


@pytest.mark.parametrize(
    ("rows", "undetermined"),
    [
        ([[1.0, 2.0], [2.0, 4.0]], 1),
        ([[0.0, 1.0], [0.0, 2.0]], 0),
        ([[1.0, 2.0, 3.0], [0.0, 0.0, 0.0], [1.0, 0.0, 1.0]], 2),
        ([[np.nan, 1.0], [np.nan, 2.0]], 0),
        ([[0.0, 1.0], [1.0, 0.0]], -1),
    ],
)
def test_rows_that_do_not_determine_a_state_are_found(
    c_library: Any, rows: list[list[float]], undetermined: int
) -> None:
    matrix, pivot, scratch = np.array(rows), np.zeros(3, np.intc), np.zeros(3)
    found = c_library("kaps").bgc_factorise_dense(
        len(rows), as_doubles(matrix), pivot.ctypes.data_as(ctypes.c_void_p), as_doubles(scratch)
    )
    assert found == undetermined


def test_units_of_the_rows_do_not_pick_the_pivots(c_library: Any) -> None:
    library = c_library("kaps")
    random = np.random.default_rng(3)
    matrix, x = random.normal(size=(8, 8)), random.normal(size=8)
    units = 2.0 ** random.integers(-40, 40, size=8)
    found, pivots = solve_dense(library, matrix, matrix @ x)
    same, others = solve_dense(library, units[:, None] * matrix, units * (matrix @ x))
    np.testing.assert_allclose(found, x, rtol=1e-12)
    assert others == pivots
    np.testing.assert_array_equal(same, found)


def test_room_grows_and_a_lack_of_memory_is_seen(c_library: Any) -> None:
    library = c_library("kaps")
    matrix, room = ctypes.POINTER(ctypes.c_double)(), ctypes.c_size_t(0)
    make = library.bgc_make_room
    make.argtypes = (ctypes.c_void_p, ctypes.c_void_p, ctypes.c_size_t)
    for n, wanted in ((3, 3), (2, 3), (5, 5)):
        assert make(ctypes.byref(matrix), ctypes.byref(room), n) == 1
        assert room.value == wanted and matrix[wanted * wanted - 1] == 0.0
    assert make(ctypes.byref(matrix), ctypes.byref(room), 2**31) == 0
    assert room.value == 0 and not matrix


def test_complex_factors_of_a_large_model_are_not_reserved(c_model: Any) -> None:
    """4,000,000 states: their dense factors would be 256 TB, more than an address space."""
    kaps = c_model("kaps")
    model = ctypes.create_string_buffer(ctypes.string_at(kaps.model, 1024), 1024)
    states = ctypes.c_int.from_buffer(model, 32)  # behind abi, name, hash, n_param and n_hoist
    assert states.value == 2
    kaps.model = ctypes.cast(model, ctypes.c_void_p)
    states.value = 4_000_000
    found = kaps.options("radau5", rtol=1e-6)
    states.value = 2
    assert found == "OK"


ENTRIES = [(1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (1.0, -1.0)]  # one of them vanishes at each


@cache
def emitted(guarded: bool, folder: Path) -> Library:
    """`tests/models/pivots.bg` as a library, with the guard or with one that accepts everything."""
    runtime = folder / f"runtime_{guarded}"
    shutil.copytree(runtime_directory(), runtime)
    if not guarded:
        for file, guard, none in (
            ("solutions.h", "bgc_acceptable = 1e-11;", f"bgc_acceptable = {INFINITE};"),
            ("solutions.h", "bgc_growth_limit = 1e5;", f"bgc_growth_limit = {INFINITE};"),
            ("linear_kinds.h", "if (failed != 0 || !isfinite(growth))", "if (failed < 0)"),
        ):
            source = (runtime / file).read_text()
            assert guard in source
            (runtime / file).write_text(source.replace(guard, none))
    units = compile_scene(CORPUS / "pivots.bg", Options(), until="emit").emitted
    text, target = folder / f"model_{guarded}.c", folder / f"model_{guarded}.so"
    text.write_text(amalgamate(units, runtime))
    run_compiler("-O0", "-shared", text, "-o", target, "-lm")
    return Library(target)


def run_emitted(
    library: Library, entries: tuple[float, float]
) -> tuple[Status, Floats, dict[str, float]]:
    """Status, the error of y, and the counts."""
    instance = Instance(library)
    for index, value in enumerate(entries):
        instance.set_parameter(index, value)
    options = OptionsStruct(name=b"rodas5p", rtol=1e-8, atol=1e-10, max_steps=10_000)
    assert instance.set_options(options) is Status.OK
    assert instance.reset() is Status.OK
    rows = np.full((len(TIMES), library.model.n_output), np.nan)
    status, done = instance.run(TIMES, rows)
    return status, np.abs(rows[:done, 0] - np.exp(-TIMES[:done])), instance.counts


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("pivots")


@pytest.mark.slow
@pytest.mark.parametrize("entries", [*ENTRIES, (1.0, 1e-14), (1e-14, 1.0), (0.7, 0.2)])
def test_a_model_that_breaks_static_pivots_is_solved(
    folder: Path, entries: tuple[float, float]
) -> None:
    status, error, _ = run_emitted(emitted(True, folder), entries)
    assert status is Status.OK
    assert error.max() < 1e-7


@pytest.mark.slow
def test_the_fallback_solves_it_and_nothing_else_would(folder: Path) -> None:
    """Some values break the pivots, depending on the order of elimination."""
    guarded, blind = emitted(True, folder), emitted(False, folder)
    broken = [e for e in ENTRIES if run_emitted(guarded, e)[2]["fallbacks"] > 0]
    assert broken
    assert run_emitted(guarded, (0.7, 0.2))[2]["fallbacks"] == 0
    assert run_emitted(blind, (0.7, 0.2))[0] is Status.OK
    for entries in broken:
        status, error, _ = run_emitted(blind, entries)
        assert status is not Status.OK or error.max() > 1e-3


@pytest.mark.parametrize(("method", "step"), [("rodas5p", 0.0), ("radau5", 0.0), ("gauss4", 0.02)])
def test_a_solution_that_is_acceptable_is_not_refined(
    c_model: Any, method: str, step: float
) -> None:
    pivots = c_model("pivots")
    pivots.set(p0=1e-3)
    pivots.start(method, rtol=1e-8, step=step)
    pivots.finish(TIMES)
    assert pivots.counts.refinements == 0


# --- complex systems of collocation methods ------------------------------------------------------


@pytest.mark.parametrize("tiny", [1e-6, 1e-10, 1e-14, 1e-17, 0.0])
@pytest.mark.parametrize("model", ["pivots", "pivots_unreported"])
@pytest.mark.parametrize(("method", "step"), [("radau5", 0.0), ("gauss4", 0.02)])
def test_complex_pivots_that_vanish_are_caught(
    c_model: Any, method: str, step: float, model: str, tiny: float
) -> None:
    pivots = c_model(model)
    pivots.set(p0=tiny)
    pivots.start(method, rtol=1e-8, step=step)
    rows = pivots.finish(TIMES)
    np.testing.assert_allclose(rows[:, 2], np.exp(-TIMES), atol=1e-5 if tiny > 1e-7 else 1e-7)
    if tiny == 1e-10:
        assert pivots.counts.refinements > 0
    assert (pivots.counts.fallbacks > 0) == (tiny < 1e-15)


def test_dense_complex_factors_are_those_of_the_matrix(c_model: Any) -> None:
    """Newton's method on a linear model ends after one solution, which wrong factors delay."""
    counts = []
    for tiny in (1e-3, 0.0):
        pivots = c_model("pivots")
        pivots.set(p0=tiny)
        pivots.start("gauss4", step=0.02)
        pivots.finish(TIMES)
        counts.append(pivots.counts.solves)
        assert (pivots.counts.fallbacks > 0) == (tiny == 0.0)
    assert counts[0] == counts[1]


def test_complex_solutions_are_checked_at_intervals(c_model: Any) -> None:
    # A growth that is not reported: only the check of every sixteenth factorisation finds the loss.
    pivots = c_model("pivots_unreported")
    pivots.set(p0=1e-10)
    pivots.start("gauss4", step=0.02)
    pivots.finish(TIMES)
    assert pivots.counts.refinements > 0


@pytest.mark.parametrize("method", ["ros34prw", "gauss4"])
def test_factors_that_serve_a_whole_run_are_checked_at_first(c_model: Any, method: str) -> None:
    pivots = c_model("pivots_unreported")
    pivots.set(p0=1e-10)
    pivots.start(method, step=0.02, keep=1000)
    pivots.finish(TIMES)
    assert pivots.counts.factorisations == 1
    assert pivots.counts.refinements > 0


@pytest.mark.parametrize("keep", [1, 4])
def test_a_restored_run_has_its_dense_complex_factors(c_model: Any, keep: int) -> None:
    pivots = c_model("pivots")
    pivots.set(p0=0.0)
    pivots.start("gauss4", step=0.02, keep=keep)
    pivots.finish([0.02, 0.2])
    saved = pivots.save()
    expected = pivots.finish([0.5, 1.0])

    other = c_model("pivots")
    assert other.restore(saved) == "OK"
    assert other.finish([0.5, 1.0]).tobytes() == expected.tobytes()


def test_options_of_another_method_discard_the_factors(c_model: Any) -> None:
    pivots = c_model("pivots")
    pivots.set(p0=0.0)
    pivots.start("gauss4", step=0.02)
    pivots.finish([0.1])
    assert pivots.options("ros34prw", step=0.02, keep=4) == "OK"
    pivots.finish([0.14])
    saved = pivots.save()
    expected = pivots.finish([0.3])

    other = c_model("pivots")
    assert other.restore(saved) == "OK"
    assert other.finish([0.3]).tobytes() == expected.tobytes()
