"""The range that `bgc stress` states contains the scene's own value; values of use come first."""

from __future__ import annotations

from pathlib import Path

import pytest

from bgc.driver import compile_scene
from bgc.options import Options
from bgc.runtime.measuring.judging import Accuracy
from bgc.runtime.running.model_loading import load_model
from bgc.runtime.stress.drives import Drive, all_drives
from bgc.runtime.stress.stress import Point, StressMap, _in_order
from bgc.runtime.stress.stress_judge import Judgement, Verdict
from bgc.runtime.stress.stress_tables import summary

MODELS = Path(__file__).parents[1] / "models" / "stress.bg"


def stress_map(drive: Drive, holds: set[float]) -> StressMap:
    """A map of one drive that holds at some of its values."""
    points = tuple(
        Point(
            ((drive.name, x),),
            1.0,
            Judgement(Verdict.HOLDS if x in holds else Verdict.DEGRADED, 1e-6),
        )
        for x in drive.values
    )
    return StressMap(
        "scene", "rodas5p", 1.0, 1.0, Accuracy(1e-3), False, (drive,), points, len(points), (), 0.0
    )


@pytest.mark.parametrize(
    ("own", "holds", "stated"),
    [
        (9.0, {0.9, 9.0, 90.0}, "deck 0.9 s to 90 s"),
        (9.0, {9.0, 9e3, 9e4, 9e5, 1e300}, "deck 9 s"),
        (-20.0, {-200.0, -20.0, -2.0, 5e-324, 2e3, 2e4, 2e5}, "deck -200 s to -2 s"),
        (
            9.0,
            {9e3, 9e4, 9e5},
            "does not hold at its own value of deck (3 of 8 values hold)",
        ),
    ],
)
def test_the_range_that_is_stated_contains_the_own_value(
    own: float, holds: set[float], stated: str
) -> None:
    values = {*holds, own, own / 10, 10 * own, 0.1, 9e3, 9e4, 9e5, 1e300}
    drive = Drive("deck", "s", "source", tuple(sorted(values)), own=own)
    text = summary(stress_map(drive, holds))
    assert stated in text
    assert "e-324" not in text and "e+300" not in text


def test_the_own_value_comes_first_then_those_around_it_and_extremes_last() -> None:
    drive = Drive(
        "k", "N/m", "stiffness", (5e-324, 0.5, 1.0, 5.0, 50.0, 5e3, 5e4, 5e5, 1e300), own=5.0
    )
    order = [settings[0][1] for settings in _in_order([drive])]
    assert order[0] == 5.0
    assert set(order[1:4]) == {0.5, 1.0, 50.0}
    assert set(order[-2:]) == {5e-324, 1e300}


def test_every_parameter_is_driven_at_its_own_value_a_tenth_and_ten_times_it() -> None:
    graph = compile_scene(MODELS, Options(scene="oscillator"), until="elaborate").graph
    model = load_model(MODELS, Options(scene="oscillator"), {})
    known = [model.parameters[name] for name in model.parameters]
    own = {parameter.name: parameter for parameter in known}
    for drive in all_drives(graph, known, 1.0):
        for name in drive.parameters:
            parameter = own[name]
            assert drive.own == parameter.value
            for value in (parameter.value, parameter.value / 10, parameter.value * 10):
                assert value in drive.values or not parameter.low <= value <= parameter.high
