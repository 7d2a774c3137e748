"""A start with fast modes at rest, against closed forms of the slow motion."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from refusals import refusals

import bgc
from bgc.runtime.model import Model

Load = Callable[[str, str | None], Model]

CART, LOAD, STIFF, SOFT, START, GRAVITY = 10, 2, 1e9, 40, 0.3, 9.81  # of settling.bg, SI


def test_springs_start_with_the_deflection_of_the_slow_motion(load: Load) -> None:
    result = load("settling", "hanger").simulate(settle=100)
    fall = (LOAD * GRAVITY - SOFT * START) / (CART + LOAD)
    pull = LOAD * (GRAVITY - fall)
    assert result["stretch"][0] == pytest.approx(pull / STIFF, rel=1e-8)
    assert result["force"][0] == pytest.approx(pull, rel=1e-8)  # algebraic: follows the spring
    assert result["speed"][0] == pytest.approx(0, abs=1e-12)
    rest = LOAD * GRAVITY / SOFT
    swing = np.cos(np.sqrt(SOFT / (CART + LOAD)) * result.time)
    np.testing.assert_allclose(result["place"], rest + (START - rest) * swing, atol=2e-8)


@pytest.mark.parametrize("stiffness", [10.0**k for k in range(3, 15)])
def test_a_start_settles_at_every_stiffness(load: Load, stiffness: float) -> None:
    """The slow motion leaves out its own curvature, soft/stiff."""
    model = load("settling", "hanger")
    result = model.simulate(1e-6, settle=1, parameters={"k": stiffness})
    fall = (LOAD * GRAVITY - SOFT * result["place"][0]) / (CART + LOAD)
    assert result["force"][0] == pytest.approx(LOAD * (GRAVITY - fall), rel=SOFT / stiffness)
    assert result["stretch"][0] == pytest.approx(result["force"][0] / stiffness, rel=1e-12)


def test_energy_is_counted_from_the_settled_start(load: Load) -> None:
    result = load("settling", "hanger").simulate(settle=100)
    assert result["residual"][0] == 0
    assert np.abs(result["residual"]).max() < 1e-7


def test_what_is_slower_than_the_frequency_is_left_alone(load: Load) -> None:
    model = load("settling", "hanger")
    slow, fast = (mode.frequency for mode in model.modes())
    start = dict(zip((s.name for s in model.states), model.initial_state(), strict=True))
    beyond = model.simulate(1e-6, settle=10 * fast)
    assert beyond["place"][0] == start["base.q"]
    assert beyond["stretch"][0] == start["rope.q"]
    just = [model.simulate(1e-6, settle=factor * fast)["stretch"][0] for factor in (1.1, 0.9)]
    assert just[0] == start["rope.q"] != pytest.approx(just[1])
    between = model.simulate(1e-6, settle=10 * slow)
    assert between["place"][0] == pytest.approx(START, rel=1e-6)
    everything = model.simulate(1e-6, settle=0.1 * slow)  # static equilibrium
    assert everything["place"][0] == pytest.approx(LOAD * GRAVITY / SOFT, rel=1e-9)


def test_an_undamped_start_is_followed_in_a_tenth_of_the_steps(load: Load) -> None:
    boom = load("settling", "boom")
    ringing, settled = boom.simulate(), boom.simulate(settle=5)
    assert settled.counts["steps"] < ringing.counts["steps"] / 10
    place = [result["place"][-1] for result in (ringing, settled)]
    np.testing.assert_allclose(*place, atol=2e-6)


def test_a_scene_may_ask_for_it(tmp_path: Path) -> None:
    source = (Path(__file__).parents[1] / "models" / "settling.bg").read_text()
    file = tmp_path / "asked.bg"
    file.write_text(source.replace("rodas5p(rtol = 1e-8)", "rodas5p(rtol = 1e-8, settle = 100 Hz)"))
    result = bgc.compile(file, scene="hanger").simulate()
    assert result["stretch"][0] > 1e-8
    assert result.counts["steps"] < 1000


def test_a_mode_that_has_no_rest_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "restless.bg"
    file.write_text("model M { state x = 1; der(x) = 1000*(x^2 + 1); }\nscene s of M { run 1 us; }")
    assert refusals(lambda: bgc.compile(file).simulate(settle=1))[0].code == "BG717"


def test_rates_that_are_not_determined_are_refused(load: Load) -> None:
    amplifier = load("ivp/transistor_amplifier", None)
    assert refusals(amplifier.simulate, settle=1)[0].code == "BG718"
