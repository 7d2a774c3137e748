"""Rows at the time of a comparison with the time show its value at that time, by every method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from model_files import model_file

import bgc
from bgc.runtime.model import Model
from bgc.runtime.running.rows import row_times

METHODS: tuple[dict[str, Any], ...] = (
    {},
    {"solver": "dopri5"},
    {"solver": "radau5"},
    *({"solver": "ros34prw", "step": step} for step in (0.1, 0.01, 0.02, 0.03, 0.1 / 3)),
)
RULES: dict[str, tuple[str, Callable[[Any, Any], Any]]] = {
    "above.source": ("edge", np.greater),
    "before": ("edge", np.greater),
    "reached.source": ("least", np.greater_equal),
    "after": ("least", np.greater_equal),
}


@pytest.fixture(scope="module")
def model() -> Model:
    return bgc.compile(model_file("rows_at_edges"), preview=True)


def edges() -> dict[str, Any]:
    """Values of both edges: times of rows, those beside them by one bit, products of the interval.

    The other edge is between two rows.
    """
    rows = row_times(9.0, 0.1, None, 1)[[3, 7, 12, 43, 79]]
    near = [*rows, *np.nextafter(rows, 0), *np.nextafter(rows, 99), 3 * 0.1, 7 * 0.1]
    far = [8.05] * len(near)
    return {"edge": np.array(near + far), "least": np.array(far + near)}


@pytest.mark.parametrize("options", METHODS, ids=lambda o: "-".join(map(str, o.values())) or "auto")
def test_a_row_at_an_edge_has_the_values_of_its_time(model: Model, options: dict[str, Any]) -> None:
    cases = edges()
    many = model.simulate_many(cases, **options)
    for name, (edge, rule) in RULES.items():
        expected = [2.0 * rule(np.asarray(many.time), each) for each in cases[edge]]
        np.testing.assert_array_equal(many[name], expected, err_msg=name)
    for k in (0, 5, 22, 27):
        single = model.simulate(parameters={n: v[k] for n, v in cases.items()}, **options)
        for name in RULES:
            np.testing.assert_array_equal(single[name], many[name][k], err_msg=name)


def test_rows_and_fixed_steps_are_at_the_numbers_nearest_to_decimals() -> None:
    assert row_times(1.0, 0.1, None, 1).tolist() == [k / 10 for k in range(11)]
    assert row_times(2.0, None, 0.001, 1).tolist() == [k / 1000 for k in range(2001)]
    assert row_times(3.0, 1 / 3, None, 1).tolist() == [k / 3 for k in range(10)]


def test_an_edge_at_the_start_is_passed(model: Model) -> None:
    for options in METHODS[:4]:
        result = model.simulate(parameters={"edge": 0.0}, **options)
        assert [result[name][0] for name in ("above.source", "before")] == [0.0, 0.0]
        assert [result[name][1] for name in ("above.source", "before")] == [2.0, 2.0]
