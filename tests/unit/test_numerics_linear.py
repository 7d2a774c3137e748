"""The guard of the linear algebra: growth, refinement, dense fallback."""

from __future__ import annotations

import ctypes
from pathlib import Path
from typing import Any

import numpy as np
import pytest

TIMES = np.linspace(0.0, 2.0, 5)


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
    if tiny < 1e-9:
        assert pivots.counts.refinements + pivots.counts.fallbacks > 0
    if tiny < 1e-15:
        assert pivots.counts.fallbacks > 0


def test_without_the_guard_the_same_model_fails(
    c_model: Any, compile_c: Any, runtime_c: Path, runtime_objects: list[Path], tmp_path: Path
) -> None:
    source = (runtime_c / "linear.c").read_text()
    unguarded = source.replace("acceptable = 1e-11;", "acceptable = INFINITY;")
    assert unguarded != source
    (tmp_path / "linear.c").write_text(unguarded)
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


def test_well_behaved_pivots_cost_nothing(c_model: Any) -> None:
    for stiffness in (1e4, 1e8, 1e14):
        pendulum = c_model("pendulum")
        pendulum.set(p0=stiffness)
        pendulum.start("ros34prw", step=1e-3)
        pendulum.finish([1.0])
        assert pendulum.counts.refinements == pendulum.counts.fallbacks == 0
