"""The check of solutions with static pivots: it passes right ones, and finds wrong ones."""

from __future__ import annotations

import ctypes
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import Floats, run_compiler

import bgc
from bgc.building.build import runtime_directory
from bgc.driver import compile_scene
from bgc.emission.blocks import plan_blocks
from bgc.emission.emit import amalgamate
from bgc.emission.sparse import entries_of_matrix
from bgc.options import Options
from bgc.runtime.running.binding import Instance, Library

MODEL = Path(__file__).parents[1] / "models" / "boom_of_beams.bg"
C = 1e3  # of W = C M - J, in 1/s
TRIALS = 1500
WRONG = 1e-6  # error over the largest component, both over the states' scales

TRIAL = """
/* Solves W x = b in place, with the factor `at` multiplied by `corrupted`. */
bgc_status bgc_trial(const bgc_model *m, bgc_data *d, int at, double corrupted, double *b) {
    bgc_status status;
    m->jacobian(d->h, d->core.t, d->x, d->u, d->jac, d->dfdt, d->work);
    status = bgc_factorise(m, d, 1e3);
    d->lu[at] *= corrupted;
    d->core.pivoting = BGC_CHECKED_ONCE;
    return status == BGC_OK ? bgc_solve(m, d, b) : status;
}
"""


@pytest.fixture(scope="module", params=["unrolled", "blocks"])
def boom(tmp_path_factory: pytest.TempPathFactory, request: Any) -> Instance:
    """A boom whose factors and whose limits of `solutions.h` can be changed."""
    folder = tmp_path_factory.mktemp("boom")
    runtime = folder / "runtime"
    shutil.copytree(runtime_directory(), runtime)
    text = (runtime / "solutions.h").read_text("utf-8")
    limits = text.replace("static const double", "double")  # one unit holds them all
    assert limits != text
    (runtime / "solutions.h").write_text(limits, "utf-8")
    with (runtime / "linear.c").open("a", encoding="utf-8") as file:
        file.write(TRIAL)
    units = compile_scene(MODEL, Options(scene="short"), until="emit").emitted
    if request.param == "blocks":
        lowered = units.lowered
        entries = entries_of_matrix(lowered.program, lowered.jacobian)
        blocks = plan_blocks(lowered.plan, entries)
        units = replace(units, lowered=replace(lowered, blocks=blocks))
    source, target = folder / "boom.c", folder / "boom.so"
    source.write_text(amalgamate(units, runtime))
    run_compiler("-O0", "-shared", source, "-o", target, "-lm")
    instance = Instance(Library(target))
    instance.reset()
    return instance


def solve(instance: Instance, b: Floats, at: int, corrupted: float) -> Floats:
    x, library = b.copy(), instance.library
    trial = library.functions.bgc_trial
    place, data = (
        x.ctypes.data_as(ctypes.POINTER(ctypes.c_double)),
        ctypes.c_void_p(instance.address),
    )
    assert trial(library.pointer, data, at, ctypes.c_double(corrupted), place) == 0
    return x


def wrong_ones_passed(boom: Instance, **limits: float) -> int:
    """The number of solutions with a corrupted factor that pass and are wrong."""
    for name, value in limits.items():
        ctypes.c_double.in_dll(boom.library.functions, f"bgc_{name}").value = value
    factors, scale = boom.library.model.n_lu, boom.scale
    rng = np.random.default_rng(11)
    passed = 0
    for _ in range(TRIALS):
        b = scale * rng.normal(size=len(scale)) * C
        at, corrupted = int(rng.integers(factors)), 1 + 10.0 ** rng.uniform(-9, 1)
        right = solve(boom, b, at, 1.0) / scale
        found = solve(boom, b, at, corrupted) / scale
        passed += bool(np.abs(found - right).max() > WRONG * np.abs(right).max())
    return passed


def test_rows_of_rounding_are_not_refined() -> None:
    result = bgc.compile(MODEL, scene="long").simulate()
    assert result.counts["solves"] > 500
    assert result.counts["refinements"] == result.counts["fallbacks"] == 0


@pytest.mark.slow
def test_the_floor_lets_no_more_wrong_solutions_pass(boom: Instance) -> None:
    strict = wrong_ones_passed(boom, least_part=0.0, acceptable=1e-11)
    with_floor = wrong_ones_passed(boom, least_part=1e-3, acceptable=1e-11)
    blind = wrong_ones_passed(boom, least_part=1e-3, acceptable=np.inf)
    assert blind > TRIALS / 20
    assert with_floor <= strict + blind / 100
