"""Domains whose units differ by orders share a gyrator: units choose no causality."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import bgc

# A hydraulic line drives a mass through a piston; 1 beside 2700 N*s/m^3 was a weak pivot (BG513).
PISTON = """model Piston {
  line : J0;
  fluid : I(7.6e7 Pa*s^2/m^3, p0 = -140000 Pa*s);
  leak : R(conductance = 12e-9 m^3/s/Pa);
  piston : GY(RATIO N*s/m^3);
  motion : J1;
  mass : I(p0 = -2.2 N*s) { f = 0.58 m/s * (p/2.6 N*s)/sqrt(1 + (p/2.6 N*s)^2); }
  line -> fluid, leak;
  line -> piston -> motion -> mass;
}
scene s of Piston { observe fluid.p, mass.p; run 10 s every 1 s; }"""


@pytest.mark.parametrize("ratio", [-2700.0, 27.0, 1e-3])
def test_a_piston_of_any_size_compiles(ratio: float, tmp_path: Path) -> None:
    path = tmp_path / "piston.bg"
    path.write_text(PISTON.replace("RATIO", repr(ratio)))
    result = bgc.compile(path, preview=True).simulate(rtol=1e-10)

    def rates(_: float, p: np.ndarray) -> list[float]:
        speed = 0.58 * (p[1] / 2.6) / np.sqrt(1 + (p[1] / 2.6) ** 2)
        effort = ratio * speed
        return [effort, -ratio * (p[0] / 7.6e7 + 12e-9 * effort)]

    exact = solve_ivp(
        rates, (0, 10), [-140000, -2.2], method="Radau", t_eval=result.time, rtol=1e-10, atol=1e-9
    )
    np.testing.assert_allclose(result["fluid.p"], exact.y[0], rtol=1e-6)
    np.testing.assert_allclose(result["mass.p"], exact.y[1], rtol=1e-6)
