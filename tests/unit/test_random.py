"""`random`: known values, the same in C, and the statistics of 1e5 draws."""

from __future__ import annotations

import math

import numpy as np
import pytest
from fake_scope import World
from programs import CompiledModel, make_program, states

import bgc
from bgc.algebra.dag import Dag, Op
from bgc.algebra.random import _mixed, random
from bgc.emission.emit import emit_model
from bgc.emission.simplification import optimise

COUNT = 100_000
SPLITMIX_OF_ZERO = (0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4, 0x06C45D188009454F)


def sequence(seed: int, first: int = 0, count: int = COUNT) -> np.ndarray:
    """Draws of one seed, by an own vectorised form of the generator."""

    def mixed(z: np.ndarray) -> np.ndarray:
        z = (z ^ z >> np.uint64(30)) * np.uint64(0xBF58476D1CE4E5B9)
        z = (z ^ z >> np.uint64(27)) * np.uint64(0x94D049BB133111EB)
        return z ^ z >> np.uint64(31)

    step = np.uint64(0x9E3779B97F4A7C15)
    start = mixed(mixed(np.array([seed % 2**64], np.uint64) + step) + step)
    index = np.arange(first + 1, first + 1 + count).astype(np.uint64)
    return (mixed(start + step * index) >> np.uint64(11)) * 2.0**-53


def test_mixer_is_that_of_splitmix64() -> None:
    """The first outputs of the published generator from state 0."""
    found = tuple(_mixed(0x9E3779B97F4A7C15 * k) for k in (1, 2, 3))
    assert found == SPLITMIX_OF_ZERO


@pytest.mark.parametrize("seed", [0, 1, 2, -1, 2**53 - 1])
def test_python_draws_the_sequence(seed: int) -> None:
    expected = sequence(seed, -50, 100)
    assert [random(seed, k) for k in range(-50, 50)] == expected.tolist()


def test_what_is_not_whole_gives_nan() -> None:
    for pair in ((0.5, 1), (1, 0.5), (2.0**53, 1), (math.nan, 1), (1, math.inf)):
        assert math.isnan(random(*pair))


@pytest.mark.slow
def test_c_draws_what_python_draws(tmp_path) -> None:
    dag = Dag()
    seed, index = states(dag, 2)
    program = make_program(dag, [dag.zero, dag.zero], outputs=[dag.call(Op.RANDOM, seed, index)])
    model = CompiledModel(emit_model(optimise(program), ""), tmp_path)
    for pair in ((0, 0), (1, 5), (-3, 7), (2**53 - 1, -(2**53) + 1), (12345, 10**9)):
        (found,) = model.outputs(0.0, np.array(pair, float), np.zeros(0))
        assert found == random(*pair)
    (found,) = model.outputs(0.0, np.array([1.5, 2.0]), np.zeros(0))
    assert math.isnan(found)


def test_constants_and_loops_may_draw() -> None:
    (value,) = World().numbers("random(7, 3)")
    assert value == random(7, 3)


@pytest.mark.parametrize("seed", [0, 1, 20261122])
def test_statistics_of_a_uniform_distribution(seed: int) -> None:
    """Mean, variance, serial correlation and chi-square, each within 4 standard deviations."""
    x = sequence(seed)
    assert x.min() >= 0 and x.max() < 1 and len(np.unique(x)) == COUNT
    assert abs(x.mean() - 1 / 2) < 4 * math.sqrt(1 / 12 / COUNT)
    assert abs(x.var() - 1 / 12) < 4 * math.sqrt(1 / 180 / COUNT)
    other = sequence(seed + 1)
    for lag in (1, 2, 7, 64, 1000):
        assert abs(np.corrcoef(x[lag:], x[:-lag])[0, 1]) < 4 / math.sqrt(COUNT)
        assert abs(np.corrcoef(x[lag:], other[:-lag])[0, 1]) < 4 / math.sqrt(COUNT)
    assert abs(np.corrcoef(x, other)[0, 1]) < 4 / math.sqrt(COUNT)


@pytest.mark.parametrize("stride", [1, 2, 1024])
def test_chi_square_of_values_and_pairs(stride: int) -> None:
    """1,000 bins of one draw and 32 x 32 of two in a row, also along seeds at one index."""
    along_index = sequence(3, 0, COUNT)
    along_seed = np.array([sequence(s * stride, 9, 1)[0] for s in range(20_000)])
    for x in (along_index, along_seed):
        for counts in (
            np.histogram(x, 100, (0, 1))[0],
            np.histogram2d(x[:-1:2], x[1::2], 10, ((0, 1), (0, 1)))[0].ravel(),
        ):
            expected, freedom = counts.sum() / len(counts), len(counts) - 1
            chi = ((counts - expected) ** 2).sum() / expected
            assert abs(chi - freedom) < 4 * math.sqrt(2 * freedom)


def test_a_seed_that_is_not_whole_is_refused_by_name(tmp_path) -> None:
    path = tmp_path / "a.bg"
    path.write_text(
        "model M { param seed = 3; param first = 1; "
        "sample 1 s { state x = 0; next(x) = random(2*seed, first); } }"
        "scene s of M { observe x; run 2 s; }"
    )
    model = bgc.compile(path)
    assert model.simulate(parameters={"seed": 2.5})["x"][-1] == random(5, 1)
    for name, operand, what in (("seed", "2*seed", "seed"), ("first", "first", "index")):
        with pytest.raises(bgc.BgError, match="BG707") as caught:
            model.simulate(parameters={name: 1.25})
        message = caught.value.diagnostics[0].message
        assert message == f"`{operand}` must be a whole number: it is the {what} of `random`"


def test_a_seed_is_named_before_what_is_divided_by_its_numbers(tmp_path) -> None:
    path = tmp_path / "a.bg"
    path.write_text(
        "model M { param seed = 3; state x = 1; der(x) = -x/(1 + random(seed, 1)); }"
        "scene s of M { observe x; run 2 s; }"
    )
    with pytest.raises(bgc.BgError, match="`seed` must be a whole number"):
        bgc.compile(path).simulate(parameters={"seed": 1.5})
