"""Rows within a step that ends at an event, or passes a kink, satisfy the equations."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import bgc
from bgc.runtime.model import Model

MODELS = {
    # The force of the source moves nothing: the flow is given. Its kink is not worth an event.
    "clamp": (
        "model M { loop : J1; state slow : m/s; der(slow) = (loop.f - slow) / 0.19 s;"
        " push : MSe(16 N*s/m * max(0.076 m/s - slow, -0.152 m/s)); push -> loop;"
        " spring : C(stiffness = 2 N/m); loop -> spring; "
        " feed : Sf(f = 0.26 m/s * tanh(time / 1.1 s) + 0.13 m/s * cos(1.3 rad/s * time));"
        " feed -> loop; }"
        "scene test of M { observe slow, push.e, energy.supplied; run 10 s every 0.01 s; }"
    ),
    # The feed, through a modulus that may vanish, closes a chain.
    "chain": (
        "model M { motion : J1; body : I(2 kg); motion -> body; damper : R(3 N*s/m);"
        " motion -> damper; state angle : m = 0.05 m; der(angle) = motion.f;"
        " gear : MTF(cos(angle / 1 m)); node : J0; motion -> gear -> node;"
        " feed : Sf(f = 0.47 m/s * max(sin(3.4 rad/s * time), 0)); feed -> node; }"
        "scene test of M { observe angle, motion.f, energy.supplied; run 2 s every 0.01 s; }"
    ),
}


def model(name: str, folder: Path) -> Model:
    path = folder / f"{name}.bg"
    path.write_text(MODELS[name], encoding="utf-8")
    return bgc.compile(path, preview=True)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-10])
def test_outputs_follow_a_kink_that_changes_no_rate(rtol: float, tmp_path: Path) -> None:
    result = model("clamp", tmp_path).simulate(rtol=rtol)
    slow = np.asarray(result["slow"])
    force = 16 * np.maximum(0.076 - slow, -0.152)
    assert force.min() == pytest.approx(-2.432)
    np.testing.assert_allclose(result["push.e"], force, rtol=0, atol=1e-12)


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-10])
def test_a_closed_chain_follows_the_input_before_an_event(rtol: float, tmp_path: Path) -> None:
    result = model("chain", tmp_path).simulate(rtol=rtol)
    feed = 0.47 * np.maximum(np.sin(3.4 * np.linspace(0, 2, 201)), 0)
    flow = np.asarray(result["motion.f"]) * np.cos(np.asarray(result["angle"]))
    np.testing.assert_allclose(flow, -feed, rtol=0, atol=1e-12)
