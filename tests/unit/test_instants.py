"""Comparisons that hold for an instant add nothing to a run, whatever its method."""

from __future__ import annotations

from pathlib import Path

import pytest

import bgc

MODEL = """
model M {
  state never = 0; state always = 0; state wave = 0; state second = 0;
  der(never) = if time == 3 s then 1000 else 0;
  der(always) = if 2*time != 6 s then 1 else 0;
  der(wave) = if time == 0 then 1 else sin(time)/time;
  der(second) = if floor(time) == 2 then 1 else 0;
}
scene s of M { observe never, always, wave, second; run 4 s; }
"""


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory):
    file: Path = tmp_path_factory.mktemp("instants") / "m.bg"
    file.write_text(MODEL)
    return bgc.compile(file)


@pytest.mark.parametrize("options", [{}, {"solver": "ros34prw", "step": 0.01},
                                     {"solver": "rk4", "step": 0.5}])  # fmt: skip
def test_every_method_counts_an_instant_of_time_as_nothing(model, options) -> None:
    """A step of 10 ms that ends at 3 s counted it for 7.7 ms."""
    result = model.simulate(**options)
    assert result["never"][-1] == 0
    assert result["always"][-1] == pytest.approx(4, abs=1e-12)
    assert result["wave"][-1] == pytest.approx(1.758203138949, abs=2e-4)  # Si(4)
    assert result["second"][-1] == pytest.approx(1, abs=1e-12)
