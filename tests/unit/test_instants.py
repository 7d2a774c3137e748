"""Comparisons that hold for an instant add nothing to a run, whatever its method."""

from __future__ import annotations

import pytest
from model_files import model_file

import bgc


@pytest.fixture(scope="module")
def model():
    return bgc.compile(model_file("instants"))


@pytest.mark.parametrize("options", [{}, {"solver": "ros34prw", "step": 0.01},
                                     {"solver": "rk4", "step": 0.5}])  # fmt: skip
def test_every_method_counts_an_instant_of_time_as_nothing(model, options) -> None:
    """A step of 10 ms that ends at 3 s counted it for 7.7 ms."""
    result = model.simulate(**options)
    assert result["never"][-1] == 0
    assert result["always"][-1] == pytest.approx(4, abs=1e-12)
    assert result["wave"][-1] == pytest.approx(1.758203138949, abs=2e-4)  # Si(4)
    assert result["second"][-1] == pytest.approx(1, abs=1e-12)


def test_a_state_that_keeps_up_with_time_counts(tmp_path) -> None:
    path = tmp_path / "m.bg"
    path.write_text(
        "model M { state x = 0; state y = 0; der(x) = 1/(1 s); "
        "der(y) = (if x == time/(1 s) then 1 else 0)/(1 s); } "
        "scene s of M { observe y; run 2 s; }"
    )
    result = bgc.compile(path).simulate(solver="rk4", step=0.5)
    assert result["y"][-1] == 2
