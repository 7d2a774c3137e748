"""Resolved-rate control against the singular value decomposition, and through singular postures."""

from __future__ import annotations

import numpy as np
import pytest

from bgc.diagnostics.diagnostic import BgError

THRESHOLD, DAMPING = 0.1, 0.1


def parameters(**values: np.ndarray) -> dict[str, float]:
    """Parameters of `Given` by component."""
    return {
        f"{name}[{','.join(str(k + 1) for k in index)}]": float(x)
        for name, value in values.items()
        for index, x in np.ndenumerate(value)
    }


def expected(J, v, best, rate, speed):
    """Rates, lambda^2 over the mean, and the measure, from singular values."""
    S = J * rate / speed[:, None]
    left, sigma, right = np.linalg.svd(S, full_matrices=False)
    mean = np.mean(sigma**2)
    w = np.prod(sigma / np.sqrt(mean))
    damped = DAMPING**2 * max(1 - w**2 / THRESHOLD**2, 0) ** 2
    scaled = right.T @ (sigma / (sigma**2 + damped * mean) * (left.T @ ((v - J @ best) / speed)))
    free = best + rate * scaled
    return free / max(np.abs(free / rate).max(), 1), damped, w


@pytest.mark.parametrize(
    ("scene", "m", "n"), [("square", 3, 3), ("six", 6, 6), ("redundant", 2, 3)]
)
def test_rates_are_the_damped_least_squares(load, scene, m, n):
    """Regular, nearly singular, singular and empty Jacobians; weights and limits of rates."""
    rng = np.random.default_rng(m)
    model = load("resolved_rate", scene)
    seen = set()
    for k in range(24):
        left, _, right = np.linalg.svd(rng.normal(size=(m, n)), full_matrices=False)
        sigma = 10 ** rng.uniform(-0.3, 0.3, m)
        sigma[-1] *= (1, 0.1, 1e-3, 0)[k % 4]
        J = left * (sigma * 3.0) @ right * (k != 23)
        rate, speed = rng.uniform(0.5, 2, n), rng.uniform(0.5, 2, m)
        v, best = rng.normal(size=m) * 10 ** rng.uniform(-2, 1.3), rng.normal(size=n) * 0.1
        given = parameters(J=J, v=v, best=best, rate=rate, speed=speed)
        found = model.observe(parameters=given)
        rates, damped, measure = (
            (best / max(np.abs(best / rate).max(), 1), DAMPING**2, 0.0)
            if k == 23
            else expected(J, v, best, rate, speed)
        )
        own = np.array([found[f"rates[{j + 1}]"] for j in range(n)])
        np.testing.assert_allclose(own, rates, rtol=1e-8, atol=1e-9)
        assert found["damped"] == pytest.approx(damped, abs=1e-9)
        assert found["measure"] == pytest.approx(measure, rel=1e-6, abs=2e-6)
        if damped == 0 and np.abs(own / rate).max() < 1 - 1e-9:
            np.testing.assert_allclose(J @ own, v, atol=1e-9)
            seen.add("exact")
        if np.abs(own / rate).max() > 1 - 1e-12:
            seen.add("limited")
    assert {"limited"} <= seen
    assert scene == "six" or "exact" in seen


def test_a_tip_follows_a_line(load):
    result = load("resolved_rate", "reach").simulate(rtol=1e-8)
    np.testing.assert_allclose(result["miss"], 0, atol=1e-7)
    assert result["damped"].max() == 0


def test_a_tip_that_is_to_leave_its_reach_waits_at_its_end(load):
    """Exact rates would have no bound there; the tip stays as near as it can, and returns."""
    result = load("resolved_rate", "reach").simulate(parameters={"far": 24})
    reached = np.linalg.norm([result[f"position[{k}]"] for k in (1, 2, 3)], axis=0)
    assert reached.max() <= 21 * (1 + 1e-12)
    assert result["measure"].min() < 1e-3
    out = 24 * np.sqrt(1.04) - 21
    assert result["miss"].max() == pytest.approx(out, rel=1e-3)
    rates = np.abs([result[f"rates[{k}]"] for k in (1, 2, 3)])
    assert np.all(rates.max(axis=1) <= np.array([0.3, 0.2, 0.2]) * (1 + 1e-12))
    assert result["miss"][-1] < 1e-3


def test_a_rate_of_zero_is_refused(load):
    with pytest.raises(BgError, match=r"(?s)BG705.*positive|BG707"):
        load("resolved_rate", "square").simulate(parameters={"rate[2]": 0})
