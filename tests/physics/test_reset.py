"""A reset leaves nothing of an earlier run, whatever its parameters were."""

from __future__ import annotations

import numpy as np
import pytest

from bgc.language.solver import Solver
from bgc.runtime.running.run import set_method

SCENES = [  # and the factor of all parameters in the earlier run
    ("four_bar", "all_rigid", 0.7),
    ("sampled", "control", 1.3),
    ("jumps", "bounce", 1.3),
    ("hidden", "bump", 1.3),
    ("events", "rectifier", 0.7),
]


def rows_and_counts(instance, times, width):
    rows = np.full((len(times), width), np.nan)
    instance.run(times, rows)
    counts = {name: value for name, value in instance.counts.items() if "seconds" not in name}
    return rows, counts


@pytest.mark.parametrize(("name", "scene", "factor"), SCENES)
@pytest.mark.parametrize("method", [Solver("rodas5p"), Solver("ros34prw", step=2e-3)])
def test_a_run_after_a_reset_has_the_bits_of_a_new_instance(load, name, scene, factor, method):
    model = load(name, scene)
    times = np.linspace(0.0, 0.2, 5)
    width = model.library.model.n_output + 4
    found = []
    for used in (False, True):
        instance = model.parameters.instance({})
        assert set_method(instance, method, True) == 0
        if used:
            values = [instance.parameter(k) for k in range(model.library.model.n_param)]
            for k, value in enumerate(values):
                instance.set_parameter(k, factor * value)
            if instance.reset(0.1) == 0:
                rows_and_counts(instance, 0.1 + 1e-3 * times, width)
            for k, value in enumerate(values):
                instance.set_parameter(k, value)
        assert instance.reset() == 0
        found.append(rows_and_counts(instance, times, width))
    (rows, counts), (again, others) = found
    assert np.isfinite(rows).all()
    np.testing.assert_array_equal(again, rows)
    assert others == counts
