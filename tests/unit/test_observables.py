"""Observables of a run, criteria on them, and how their texts are read."""

from __future__ import annotations

import numpy as np
import pytest
from refusals import codes_of

from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.results.observables import read_criterion, read_observables
from bgc.runtime.running.quantity import read_quantity
from bgc.values.shown_units import Shown

COLUMNS = {
    "x": ("N", Shown("kN", 1e3)),
    "y [mm]": ("mm", Shown("mm")),
    "tip[1]": ("m", Shown("m")),
    "tip[2]": ("m", Shown("m")),
}
TIME = np.array([*np.linspace(0, 10, 4001), 10.001])
WAVE = 3 + 2 * np.sin(2 * np.pi * TIME)


def of(text: str) -> float:
    (found,) = read_observables([text], COLUMNS, read_quantity)
    return found.of(TIME, WAVE)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("max(x)", 5),
        ("min(x)", 1),
        ("mean(x)", 3),
        ("rms(x)", np.sqrt(9 + 2)),
        ("sd(x)", np.sqrt(2)),
        ("range(x)", 4),
        ("peak(x)", 5),
        ("first(x) from 0.25 s", 5),
        ("last(x) to 750 ms", 1),
        ("quantile(x, 0.75)", 3 + np.sqrt(2)),
        ("crossings(x, 0.004 kN)", 10),
        ("crossings(x, 4) from 1 s to 3.9 s", 3),
        ("above(x, 4)", 1 / 3),
    ],
)
def test_observables_are_those_of_the_wave(text, expected):
    assert of(text) == pytest.approx(expected, rel=3e-3)


@pytest.mark.parametrize(
    "text",
    "mean(x) from 1 s; rms(x); sd(x) to 2 s; first(x) from 0.3 s; last(x); quantile(x, 0.4); "
    "quantile(x, 1); max(x) to 0.01 s".split("; "),
)
def test_gradients_are_those_of_a_random_walk(text):
    rng = np.random.default_rng(1)
    time, walk = np.sort(rng.uniform(0, 4, 60)), -rng.normal(0, 1, 60).cumsum()
    time[0] = 0
    (found,) = read_observables([text], COLUMNS, read_quantity)
    by, step = found.gradient(time, walk), 1e-6
    for k, unit in enumerate(np.eye(60)):
        ends = (found.of(time, walk + sign * step * unit) for sign in (1, -1))
        assert by[k] == pytest.approx(-np.diff([*ends])[0] / (2 * step), abs=1e-8)


@pytest.mark.parametrize(
    ("text", "of_mean", "of_amplitude"),
    [("max(x)", 1, 1), ("min(x)", 1, -1), ("range(x)", 0, 2), ("peak(x)", 1, 1)],
)
def test_gradients_of_extremes_are_those_between_rows(text, of_mean, of_amplitude):
    """Of 3 + 2 sin w t; by w its extremes do not change, though the values at rows do."""
    time = np.linspace(0, 2.03, 400)
    (found,) = read_observables([text], COLUMNS, read_quantity)
    by = found.gradient(time, 3 + 2 * np.sin(7 * time))
    assert by.sum() == pytest.approx(of_mean)
    assert by @ np.sin(7 * time) == pytest.approx(of_amplitude, abs=1e-6)
    assert by @ (2 * time * np.cos(7 * time)) == pytest.approx(0, abs=1e-3)
    below = found.gradient(time, -3 + 2 * np.sin(7 * time))
    assert below.sum() == pytest.approx(-1 if text == "peak(x)" else of_mean)


def test_rows_of_unequal_intervals_are_weighted_by_time():
    time = np.array([0.0, 1.0, 1.25, 1.5, 4.0])
    (mean,) = read_observables(["mean(x)"], COLUMNS, read_quantity)
    assert mean.of(time, 2 * time) == pytest.approx(4.0, rel=1e-14)


def test_an_undefined_row_makes_only_its_part_undefined():
    broken = np.where(TIME > 5, np.nan, WAVE)
    early, late = read_observables(["max(x) to 4 s", "max(x)"], COLUMNS, read_quantity)
    assert early.of(TIME, broken) == pytest.approx(5) and np.isnan(late.of(TIME, broken))


def test_vectors_and_columns_in_other_units():
    found = read_observables(["max(tip)", "peak(tip.y)", "above(y, 3 cm)"], COLUMNS, read_quantity)
    assert [each.name for each in found[:3]] == ["max(tip[1])", "max(tip[2])", "peak(tip[2])"]
    assert (found[3].column, found[3].argument, found[3].unit) == ("y [mm]", 30, "1")


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("x", "BG787"),
        ("largest(x)", "BG787"),
        ("max(x, 3)", "BG787"),
        ("quantile(x)", "BG787"),
        ("quantile(x, 2)", "BG787"),
        ("max(x) from 3 s to 2 s", "BG787"),
        ("max(z)", "BG065"),
        ("above(x, 3 kg)", "BG063"),
        ("max(x) from 3 m", "BG063"),
        ("above(x, much)", "BG062"),
    ],
)
def test_other_texts_are_refused(text, code):
    assert codes_of(read_observables, [text], COLUMNS, read_quantity) == [code]


def test_criteria_compare_with_a_limit_in_any_unit():
    (upper,) = read_criterion("x < 300 kN", COLUMNS, read_quantity)
    assert (upper.name, upper.limit) == ("max(x) < 300 kN", 3e5)
    np.testing.assert_allclose(
        upper.utilisation(np.array([1.5e5, 6e5, -1.0, np.nan])), [0.5, 2, 0, np.nan]
    )
    (lower,) = read_criterion("min(tip.x) >= 2 m", COLUMNS, read_quantity)
    np.testing.assert_allclose(lower.utilisation(np.array([4.0, 1.0, -1.0])), [0.5, 2, 2])
    for wrong in ("max(x)", "max(x) < ", "max(x) = 3"):
        with pytest.raises(BgError, match="BG787"):
            read_criterion(wrong, COLUMNS, read_quantity)
