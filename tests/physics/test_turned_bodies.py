"""Moduli that read states, flows and momenta of the bodies that they join, against dense equations.

Bodies joined by transformers share a merged momentum for each free flow. Where a modulus reads one
of these flows, the flow follows from a loop, and the compiler's check of the elimination has to
take the modulus as it is.
"""

from __future__ import annotations

import numpy as np
import pytest
from model_files import compiled, model_text
from scipy.integrate import solve_ivp
from turned_bodies import draw_bodies

from bgc.driver import check_source
from bgc.equations.storage import constrained_energy

WIDE = model_text("turned_bodies_wide")


def run(tmp_path, text):
    return compiled(tmp_path, text).simulate(rtol=1e-10, atol=1e-12)


def agrees_with_the_reference(result, bodies):
    rows = np.array([np.ravel(result[name]) for name in bodies.observed]).T
    times = result["time"]
    assert np.abs(bodies.gaps(rows[0, 0], rows[0, 1 : 1 + len(bodies.flows)])).max(initial=0) < 1e-9
    found = solve_ivp(bodies.rates, times[[0, -1]], rows[0], "LSODA", times, rtol=1e-9, atol=1e-11)
    assert found.success
    assert np.allclose(rows, found.y.T, rtol=0, atol=1e-5 * np.abs(rows).max())
    return np.abs(rows).max()


# 1, 9, 16, 25, 27, 30, 32, 38: programs that a check at inconsistent flows stopped
@pytest.mark.parametrize("seed", [1, 9, 16, 25, 27, 30, 32, 38])
def test_bodies_drawn_at_random(tmp_path, seed):
    bodies = draw_bodies(seed)
    result = run(tmp_path, bodies.text(1.0))
    assert agrees_with_the_reference(result, bodies) > 0.1


def test_no_check_stops_a_program(tmp_path):
    path, compiled = tmp_path / "m.bg", 0
    for seed in range(100, 130):
        path.write_text(draw_bodies(seed).text(1.0))
        compiled += not check_source(path)  # some are refused: widths that do not follow
    assert compiled > 24


def test_a_gyrator_that_reads_a_flow_of_merged_inertias(tmp_path):
    result = run(tmp_path, WIDE)
    assert abs(result["energy.residual"]).max() < 1e-9
    assert abs(np.ravel(result["b.f"])).max() > 0.1


def test_flows_that_fail_the_check_are_left_to_the_implicit_equations(tmp_path, monkeypatch):
    bodies = draw_bodies(9)
    monkeypatch.setattr(constrained_energy, "is_minimum", lambda *_: False)
    agrees_with_the_reference(run(tmp_path, bodies.text(1.0)), bodies)
