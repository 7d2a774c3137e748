"""The crane of flexible members: its sag by beam theory, and how few states its load requires."""

from pathlib import Path

import numpy as np
import pytest

import bgc
import bgc.library

SCENE = Path(bgc.library.__path__[0]) / "scenes" / "flexible_crane.bg"

pytestmark = pytest.mark.slow


def test_the_sag_at_rest_and_the_load_of_34_states():
    """Euler and Bernoulli's cantilever under the load, its rope and its own weight; n^-2 less."""
    whole = bgc.compile(SCENE).simulate(solver="ros34prw", step=5e-3, error=False)
    luff, length, g, modulus = np.radians(50), 20.0, 9.81, 210e9
    outer, inner = (0.4, 0.55), (0.384, 0.534)
    second = (outer[0] * outer[1] ** 3 - inner[0] * inner[1] ** 3) / 12
    area = outer[0] * outer[1] - inner[0] * inner[1]
    load, weight = 4000 * g * np.cos(luff), 7850 * area * length * g * np.cos(luff)
    sag = (load / 3 + weight / 8) * length**3 / (modulus * second)
    # The post leans under the load, and the boom is pressed along its axis: both add a little.
    assert -whole["sag"][0] == pytest.approx(sag, rel=0.1)

    few = bgc.compile(
        SCENE,
        parameters={"boom.n": 1, "post.n": 1},
        uses={
            "pedestal.lock": "Rigid[5]",
            "hanging.swivel.lock": "Rigid[3]",
            "hanging.swivel.attitude": "EulerXyz",
        },
    )
    assert len(few.states) == 34
    reduced = few.simulate(solver="radau5", rtol=1e-7, error=False)
    off = np.max(np.abs(reduced["load"] - whole["load"]))
    assert 0.01 < off < 0.05
