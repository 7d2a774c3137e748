"""Instances in batches that switch, each at its own times, and that have devices of their own."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from model_files import model_file

import bgc
from bgc.runtime.model import Model
from bgc.runtime.results.ensemble import Ensemble

pytestmark = pytest.mark.slow

SCENES = Path(__file__).parents[2] / "library" / "scenes"

# A ball that bounces on a spring and is pushed, from a time of its own on and at intervals; a stair
# of every kind of switch, with a root that only its `if` guards; a law that nothing guards; and two
# laws that switch and return within a step.
FILE = model_file("ensemble_events_switching")

BALL = {
    "mass": (0.5, 2.0), "height": (0.1, 1.0), "stiffness": (3e3, 3e4), "late": (0.2, 1.8)
}  # fmt: skip
STAIR = {"a": (0.6, 1.5)}


def at_random(ranges: dict[str, tuple[float, float]], count: int) -> dict[str, np.ndarray]:
    random = np.random.default_rng(20261121)  # one for each test, since they run in any order
    return {name: random.uniform(*span, count) for name, span in ranges.items()}


def both(model: Model, values: object, **options: object) -> tuple[Ensemble, Ensemble]:
    """The same ensemble in batches and one by one."""
    together = model.simulate_many(values, **options)
    alone = model.simulate_many(values, vectorised=False, **options)
    assert (together.alone, alone.together) == ("", 0)
    assert together.status == alone.status
    return together, alone


def distance(computed: np.ndarray, expected: np.ndarray) -> float:
    """The largest difference over the largest value of each output."""
    return float((np.abs(computed - expected) / np.abs(expected).max(axis=(0, 1))).max())


# --- events -----------------------------------------------------------------------------------


@pytest.mark.parametrize("count", [7, 9])
@pytest.mark.parametrize("solver", ["ros34prw", "rk4"])
@pytest.mark.parametrize(("scene", "ranges"), [("ball", BALL), ("stair", STAIR)])
def test_fixed_steps_pass_events_as_alone_to_rounding(scene, ranges, solver, count):
    model = bgc.compile(FILE, scene=scene)
    together, alone = both(model, at_random(ranges, count), solver=solver, step=1e-3)
    assert together.together == count
    assert distance(together.values, alone.values) < 1e-10


@pytest.mark.parametrize("solver", ["rodas5p", "dopri5"])
@pytest.mark.parametrize(("scene", "ranges"), [("ball", BALL), ("stair", STAIR)])
def test_error_control_holds_through_events(scene, ranges, solver):
    model = bgc.compile(FILE, scene=scene)
    values = at_random(ranges, 9)
    together, alone = both(model, values, solver=solver, rtol=1e-7)
    exact = model.simulate_many(values, solver="rodas5p", rtol=1e-11, vectorised=False).values
    assert together.together == 9
    assert distance(together.values, exact) < 10 * distance(alone.values, exact) + 1e-7


def test_energy_accounts_go_on_through_events():
    model = bgc.compile(FILE, scene="counted")
    together, alone = both(model, at_random(BALL, 6), solver="ros34prw", step=1e-3)
    assert together.together == 6
    assert distance(together.values, alone.values) < 1e-9


@pytest.mark.parametrize(
    "options", [{"solver": "dopri5", "rtol": 1e-7}, {"solver": "rk4", "step": 0.02}]
)
def test_a_law_that_switches_and_returns_within_a_step_is_seen(options):
    """x = sin(t) is above its level around three maxima, and twelve pulses begin in 20 s."""
    gap, width = np.geomspace(1e-6, 1e-2, 9), np.geomspace(1e-6, 1e-2, 9)
    model = bgc.compile(FILE, scene="short")
    found = model.simulate_many({"level": 1 - gap, "width": width}, **options)
    assert found.together == 9
    above = found["above"][:, -1] / (6 * np.arccos(1 - gap))
    assert np.abs((above - 1) * gap).max() < 2e-7  # as an amplitude that is so much off
    assert np.allclose(found["pulsed"][:, -1], 12 * width, rtol=1e-8)


def test_an_argument_that_becomes_undefined_ends_its_instance_alone():
    model = bgc.compile(FILE, scene="unguarded")
    late = [3.0, 1.0, 3.0, 4.0, 1.5]
    for options in ({"solver": "ros34prw", "step": 0.01}, {"rtol": 1e-6}):
        together, alone = both(model, {"late": late}, **options)
        assert together.status == ("done", "failed", "done", "done", "failed")
        assert together.together == 3
        np.testing.assert_allclose(together.values, alone.values, rtol=1e-6)
        codes = {k: why.code for k, why in alone.failures.items()}
        assert {k: why.code for k, why in together.failures.items()} == codes


# --- devices ----------------------------------------------------------------------------------


@pytest.mark.parametrize("solver", ["ros34prw", "rodas5p"])
def test_the_crane_follows_its_handle_as_alone(solver):
    model = bgc.compile(SCENES / "two_beam_crane.bg")
    values = {"crane.post.mass": np.linspace(5e3, 7e3, 5)}
    together, alone = both(model, values, duration=3.5, every=0.05, solver=solver)
    assert together.together == 5
    moved = ["tip_height", "elevation", "handle_z", "force_z"]
    assert np.ptp(alone["handle_z"]) > 1e-3
    for name in moved:
        scale = np.abs(alone[name]).max()
        limit = 1e-10 if solver == "ros34prw" else 1e-5
        assert np.abs(together[name] - alone[name]).max() < limit * scale
