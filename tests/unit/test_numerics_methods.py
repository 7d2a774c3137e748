"""Observed orders of the methods, and accuracy on problems with known answers."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

ORDER = {"rodas5p": 5, "rodas4p2": 4, "ros34prw": 3, "rodas23w": 2, "ros23": 2, "lie": 1, "rk4": 4}
FIXED = ("ros34prw", "rodas23w", "ros23", "lie", "rk4")
ADAPTIVE = ("rodas5p", "rodas4p2")


def observed_order(steps: list[float], errors: list[float]) -> float:
    return float(np.polyfit(np.log(steps), np.log(errors), 1)[0])


@pytest.mark.parametrize("method", FIXED)
def test_order_on_smooth_problem(c_model: Any, method: str) -> None:
    steps = [0.02, 0.01, 0.005]
    errors = []
    for step in steps:
        kaps = c_model("kaps")
        kaps.set(p0=1.0)
        kaps.start(method, step=step)
        errors.append(np.abs(kaps.finish([1.0])[0] - [np.exp(-2.0), np.exp(-1.0)]).max())
    assert observed_order(steps, errors) == pytest.approx(ORDER[method], abs=0.15)
