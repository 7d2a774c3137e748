"""A load that a vessel in a sea lowers over its stern, without and with heave compensation."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import bgc
import bgc.library

SCENE = Path(bgc.library.__path__[0]) / "scenes" / "offshore_lift.bg"


@pytest.fixture(scope="module")
def lift():
    return bgc.compile(SCENE, scene="offshore_lift")


@pytest.fixture(scope="module")
def results(lift):
    return [lift.simulate(parameters={"compensation": share}) for share in (0, 1)]


def test_it_starts_at_rest_and_balances_its_books(results):
    for result in results:
        assert result["tension [kN]"][0] == pytest.approx(20 * 9.81, rel=1e-6)
        assert abs(result["deck_height"][1] - result["deck_height"][0]) < 1e-4
        potential = 20e3 * 9.81 * 8
        assert np.abs(result["energy.residual"]).max() < 1e-5 * potential


def test_the_load_is_lowered_by_what_the_winch_pays_out(results):
    """5 m, but for the motion of the top and the swing of the load."""
    compensated = results[1]
    at = np.searchsorted(compensated.time, 42)
    assert compensated["height"][0] - compensated["height"][at] == pytest.approx(5, abs=0.1)


def test_compensation_takes_the_heave_out_of_the_load(results):
    """At least 95 % of it, before it is lowered."""
    plain, compensated = (
        np.ptp(result["height"][(result.time > 5) & (result.time < 20)]) for result in results
    )
    assert plain > 1
    assert compensated < 0.05 * plain
