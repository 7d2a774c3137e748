"""The recommendation, from measurements with given times."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bgc.building.record_json import from_json, to_json
from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.scenes.variants import Change
from bgc.runtime.measuring.instants import only_rows
from bgc.runtime.measuring.judging import Quantity, combined, quantities_of
from bgc.runtime.measuring.timed_run import Run
from bgc.runtime.running.loaded_model import Variable
from bgc.runtime.running.quantity import spelled_time
from bgc.runtime.trade.configurations import (
    Configuration,
    round_step,
    scene_configurations,
    step_ladder,
)
from bgc.runtime.trade.judge import Target, front, judge
from bgc.runtime.trade.measurement import OUT_OF_BUDGET, Measurement
from bgc.runtime.trade.reference_solution import find_reference

TIP = Quantity("tip", "m", scale=5e-3, required=True, decides=True)
ANGLE = Quantity("angle", "", scale=2.0, required=False, decides=False)
CHEAP = Configuration("lie", step=1e-3)
MIDDLE = Configuration("ros34prw", step=1e-3)
DEAR = Configuration("rodas5p", rtol=1e-6)


def measured(
    configuration: Configuration, error: float, cpu: float, worst: float = 1e-4, **more: float
) -> Measurement:
    """A measurement with an error of the tip in m, and times in s."""
    return Measurement(
        configuration,
        "done",
        errors=(error, 0.1),
        cpu=cpu,
        mean_step=cpu * 1e-3,
        worst_step=worst,
        repeats=3,
        counts={"steps": 1000.0},
        **more,  # type: ignore[arg-type]
    )


ROWS = (
    measured(CHEAP, error=20e-3, cpu=0.001),
    measured(MIDDLE, error=4e-3, cpu=0.003, worst=0.4e-3),
    measured(DEAR, error=1e-6, cpu=0.02, worst=2e-3),
)


def target(**given: object) -> Target:
    return Target((TIP, ANGLE), required=True, **given)  # type: ignore[arg-type]


def test_the_cheapest_within_the_tolerance_is_recommended() -> None:
    verdict = judge(ROWS, target())
    assert verdict.recommended is ROWS[1]
    assert "`solver ros34prw(step = 1 ms);`" in verdict.sentence
    assert "`tip` off by 0.004 m of 0.005" in verdict.sentence


def test_the_deadline_counts_too() -> None:
    late = (ROWS[0], measured(MIDDLE, 4e-3, cpu=0.003, worst=3e-3), ROWS[2])
    assert judge(late, target(deadline=2.5e-3)).recommended is late[2]
    assert judge(late, target(deadline=5e-3)).recommended is late[1]


def test_who_cannot_keep_up_with_time_misses_any_deadline() -> None:
    slow = (measured(MIDDLE, 4e-3, cpu=1.5, worst=1e-5),)
    assert judge(slow, target(deadline=1.0)).recommended is None
    assert judge(slow, target()).recommended is slow[0]


def test_a_speed_is_demanded_too_and_the_margins_are_stated() -> None:
    wanted = target(deadline=1e-3, faster_than=100.0)
    verdict = judge(ROWS, wanted)
    assert verdict.recommended is ROWS[1]
    assert "Margin: 1.2 x in error, 2.5 x in time, 3.3 x in speed." in verdict.sentence
    assert wanted.margins(ROWS[1]) == pytest.approx(
        {"error": 5 / 4, "time": 1 / 0.4, "speed": 1 / 0.003 / 100}
    )
    assert judge(ROWS[1:], target(faster_than=500.0)).recommended is None


def test_why_nothing_is_accurate_enough_and_what_would_be() -> None:
    verdict = judge(ROWS[:1], target(deadline=1e-3))
    assert verdict.recommended is None
    assert "No configuration is within `require`" in verdict.sentence
    assert "lie 1 ms" in verdict.sentence
    assert "`require tip within 0.02 m;` would be met" in verdict.sentence


def test_a_vector_is_named_as_a_whole_where_all_of_it_is_required() -> None:
    def wanted(*scales: float) -> str:
        quantities = tuple(
            Quantity(f"tip[{k + 1}]", "m", scale, required=scale < 1, decides=scale < 1)
            for k, scale in enumerate(scales)
        )
        row = Measurement(MIDDLE, "done", errors=(3e-3, 4.21e-3), cpu=1e-3, repeats=3)
        return judge((row,), Target(quantities, required=True)).sentence

    assert "`require tip within 0.0043 m;` would be met" in wanted(1e-3, 1e-3)
    assert "`require tip[2] within 0.0043 m;` would be met" in wanted(2.0, 1e-3)


def test_why_nothing_is_in_time_and_the_nearest_on_each_side() -> None:
    paced = measured(DEAR, error=1e-6, cpu=0.02, worst=7e-3, paced=2e-3)
    verdict = judge((ROWS[0], paced), target(deadline=1e-3))
    assert verdict.recommended is None
    assert "the quickest is rodas5p rtol 1e-06: worst 2 ms" in verdict.sentence
    assert "the most accurate is lie 1 ms" in verdict.sentence
    assert "A deadline of 2 ms would be kept" in verdict.sentence


def test_one_disturbed_step_does_not_decide_on_a_deadline_and_is_counted() -> None:
    slowest = (5e-3, 2e-3, 0.4e-3)
    row = replace(
        measured(DEAR, error=1e-6, cpu=0.02, worst=7e-3, paced=0.4e-3),
        slowest=slowest,
        periods=2500,
    )
    verdict = judge((row,), target(deadline=1e-3))
    assert verdict.recommended == row
    assert "2 of 2,500 steps late (slowest 5 ms)" in verdict.sentence
    kept = judge((replace(row, slowest=(0.5e-3, 0.4e-3, 0.4e-3)),), target(deadline=1e-3))
    assert "late" not in kept.sentence
    late = judge((replace(row, paced=1.5e-3),), target(deadline=1e-3))
    assert late.recommended is None


def test_neither_accurate_nor_in_time_is_said_of_both() -> None:
    verdict = judge(ROWS[:1], target(deadline=1e-5))
    assert "within `require` and the deadline of 10 us." in verdict.sentence
    assert "None is in time; the quickest is lie 1 ms" in verdict.sentence


def test_nothing_is_recommended_on_a_reference_that_is_not_verified() -> None:
    verdict = judge(ROWS, target(verified=False))
    assert verdict.recommended is None and verdict.front == {CHEAP, MIDDLE, DEAR}
    assert verdict.sentence.startswith("Nothing is recommended")


def test_a_spent_budget_is_not_taken_for_a_failure() -> None:
    rows = (Measurement(CHEAP, "skipped", OUT_OF_BUDGET),)
    assert "budget was spent" in judge(rows, target()).sentence
    failed = (Measurement(CHEAP, "failed", "BG703"),)
    assert judge(failed, target()).sentence == "No configuration completed the run."


def test_a_variant_that_alone_will_do_is_named() -> None:
    rigid = Configuration("rk4", step=1e-3, changes=(Change("d", "0", is_use=False),))
    verdict = judge((ROWS[0], measured(rigid, 1e-3, cpu=0.0015)), target())
    assert verdict.recommended is None and "No configuration is within" in verdict.sentence
    assert (
        "With `set d = 0;`, `solver rk4(step = 1 ms);` is acceptable: `tip` off" in verdict.sentence
    )


def test_a_worst_time_without_the_machines_noise_goes_before_one_with_it() -> None:
    row = measured(MIDDLE, 4e-3, cpu=0.003, worst=9e-3, paced=0.2e-3)
    assert judge((row,), target(deadline=1e-3)).recommended is row


def test_a_clock_that_is_coarser_than_a_step_does_not_make_it_longer() -> None:
    assert measured(MIDDLE, 4e-3, cpu=0.003, worst=0.3e-6, paced=1.8e-6).worst == 0.3e-6
    assert measured(MIDDLE, 4e-3, cpu=0.003, worst=9e-3, paced=1.8e-6).worst == 1.8e-6


def test_steps_that_sample_devices_less_often_are_not_recommended() -> None:
    rows = (measured(Configuration("ros34prw", step=2e-3), 1e-3, cpu=0.0015), ROWS[1])
    assert judge(rows, target()).recommended is rows[0]
    assert judge(rows, target(sample=1e-3)).recommended is rows[1]


def test_without_a_requirement_a_thousandth_of_the_range_is_asked_for() -> None:
    free = Target((Quantity("tip", "m", 10.0, required=False, decides=True), ANGLE), False)
    rows = tuple(row for row in ROWS)
    assert free.limit == 1e-3
    verdict = judge(rows, free)
    assert verdict.recommended is ROWS[1]  # 0.4 thousandths of 10 m; 2 are too many
    assert "no `require`" in verdict.sentence


def test_a_variant_is_named_but_is_not_what_solver_auto_takes() -> None:
    rigid = Configuration("ros34prw", step=1e-3, changes=(Change("lock", "Rigid[5]"),))
    verdict = judge((*ROWS, measured(rigid, 1e-3, cpu=0.0015)), target())
    assert verdict.recommended is ROWS[1]
    assert "With `use lock = Rigid[5];`, `solver ros34prw(step = 1 ms);`" in verdict.sentence
    assert "is acceptable too, in 50% of that time" in verdict.sentence


def test_what_tells_nothing_is_not_on_the_front() -> None:
    useless = measured(Configuration("lie", step=0.1), error=1e6, cpu=1e-6)
    assert judge((useless, *ROWS), target()).front == judge(ROWS, target()).front


def test_failed_runs_are_never_recommended_nor_on_the_front() -> None:
    failed = Measurement(CHEAP, "failed", "BG703: a value is not finite")
    assert judge((failed,), target()).recommended is None
    assert judge((failed, *ROWS[1:]), target()).front == {MIDDLE, DEAR}


def test_the_front_is_what_nothing_beats_in_both() -> None:
    beaten = measured(Configuration("ros23", step=1e-3), 5e-3, cpu=0.004)
    assert front((*ROWS, beaten), target()) == {CHEAP, MIDDLE, DEAR}


def test_errors_below_the_references_own_are_no_gain() -> None:
    finer = measured(Configuration("radau5", rtol=1e-9), 1e-9, cpu=0.1)
    assert finer.configuration in front((*ROWS, finer), target())
    assert finer.configuration not in front((*ROWS, finer), target(floor=1e-3))


# --- scales -----------------------------------------------------------------------------------


def scales(columns: dict[str, tuple[str, list[float]]], **required: float) -> dict[str, float]:
    variables = [Variable(name, unit) for name, (unit, _) in columns.items()]
    rows = np.array([values for _, values in columns.values()]).T
    return {q.name: q.scale for q in quantities_of(variables, rows, required)}


def test_errors_are_parts_of_the_range_or_of_what_is_required() -> None:
    columns = {"a": ("m", [1.0, 3.0]), "b": ("s", [0.0, 5.0])}
    assert scales(columns) == {"a": 2.0, "b": 5.0}
    assert scales(columns, a=0.1) == {"a": 0.1, "b": 5.0}


def test_noise_is_not_divided_by_noise() -> None:
    columns = {"big": ("m", [0.0, 10.0]), "noise": ("m", [0.0, 1e-16]), "none": ("N", [0.0, 0.0])}
    found = scales(columns)
    assert found["noise"] == pytest.approx(1e-5) and found["none"] == 1.0
    vector = {"r[1]": ("m", [0.0, 2.0]), "r[2]": ("m", [0.0, 1e-3])}
    assert scales(vector) == {"r[1]": 2.0, "r[2]": 2.0}


def test_what_is_required_decides_alone() -> None:
    assert combined((1e-3, 100.0), (TIP, ANGLE)) == pytest.approx(0.2)


# --- the reference ----------------------------------------------------------------------------


class Named:
    """A model of one output."""

    measured = (Variable("x", "m"),)


ENDS = only_rows(np.array([0.0, 1.0]))


def solver(difference: dict[float, float], fails: tuple[str, ...] = ()):  # type: ignore[no-untyped-def]
    """Solutions of which those of radau5 are off by so much at each tolerance."""
    asked: list[tuple[str, float]] = []

    def solve(method, seconds: float) -> Run:  # type: ignore[no-untyped-def]
        asked.append((method.name, method.rtol))
        rows = np.array([[0.0], [1.0]])
        if method.name in fails:
            return Run("failed", "BG703: a value is not finite", rows, 0.1, {})
        if method.name == "radau5":
            rows = rows + difference[method.rtol]
        return Run("done", "", rows, 0.1, {})

    return solve, asked


def test_the_level_at_which_two_methods_agree_best_is_the_reference() -> None:
    solve, _ = solver({1e-8: 1e-6, 1e-10: 1e-9, 1e-12: 1e-7})
    found = find_reference(Named(), {}, ENDS, solve, 100.0)  # type: ignore[arg-type]
    assert (found.rtol, found.accuracy) == (1e-10, pytest.approx(1e-9))
    assert [rtol for rtol, _ in found.levels] == [1e-8, 1e-10, 1e-12]
    assert found.converged


def test_methods_that_do_not_agree_well_below_what_is_required_are_no_reference() -> None:
    solve, _ = solver(dict.fromkeys((1e-8, 1e-10, 1e-12), 1e-4))
    assert find_reference(Named(), {"x": 1e-2}, ENDS, solve, 100.0).converged  # type: ignore[arg-type]
    assert not find_reference(Named(), {"x": 5e-4}, ENDS, solve, 100.0).converged  # type: ignore[arg-type]


def test_another_method_stands_in_for_one_that_fails() -> None:
    solve, asked = solver({}, fails=("radau5",))
    found = find_reference(Named(), {}, ENDS, solve, 100.0)  # type: ignore[arg-type]
    assert found.methods == ("rodas5p", "rodas4p2")
    assert [name for name, _ in asked] == ["radau5", "rodas5p", "rodas4p2"]


def test_a_method_that_takes_all_its_time_leaves_some_to_the_next() -> None:
    limits: list[float] = []
    good, _ = solver({})

    def solve(method, seconds: float) -> Run:  # type: ignore[no-untyped-def]
        limits.append(seconds)
        if method.name == "radau5":
            return Run("stopped", "it takes too long", np.zeros((2, 1)), seconds, {})
        return good(method, seconds)

    assert find_reference(Named(), {}, ENDS, solve, 100.0).methods == ("rodas5p", "rodas4p2")  # type: ignore[arg-type]
    assert limits[:3] == pytest.approx([50, 50, 100], rel=0.01)


def test_one_method_is_no_reference() -> None:
    solve, _ = solver({1e-8: 0.0}, fails=("rodas5p", "rodas4p2", "dopri5"))
    with pytest.raises(BgError, match="BG092"):
        find_reference(Named(), {}, ENDS, solve, 100.0)  # type: ignore[arg-type]


# --- configurations ---------------------------------------------------------------------------


def test_methods_take_turns_from_coarse_to_fine() -> None:
    found = scene_configurations(["a"], ["b"], [1e-6, 1e-3], [1e-3, 2e-3], [2, 1])
    assert [(c.solver, c.rtol or c.step, c.keep) for c in found] == [
        ("a", 1e-3, 1),
        ("b", 2e-3, 1),
        ("b", 2e-3, 2),
        ("a", 1e-6, 1),
        ("b", 1e-3, 1),
        ("b", 1e-3, 2),
    ]
    uneven = scene_configurations(["a"], ["b"], [1e-6, 1e-3, 1e-4], [2e-3], [1])
    assert [c.solver for c in uneven] == ["a", "b", "a", "a"]


def test_steps_below_the_scenes_divide_it_and_none_is_longer_than_the_run() -> None:
    assert step_ladder(1e-3, 1.0) == pytest.approx((5e-3, 2e-3, 1e-3, 5e-4, 2e-4))
    assert step_ladder(1e-3, 1.5e-3) == pytest.approx((1e-3, 5e-4, 2e-4))
    assert [round_step(s) for s in (0.9, 1.3e-3, 0.034, 6e-6)] == [1.0, 1e-3, 0.05, 5e-6]


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(2.5e-4, "250 us"), (1e-3, "1 ms"), (1.5, "1.5 s"), (3e-8, "30 ns"), (0.001 / 3, None)],
)
def test_times_are_spelled_without_loss(seconds: float, text: str | None) -> None:
    shown = spelled_time(seconds)
    number, unit = shown.split()
    assert text is None or shown == text
    factor = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}[unit]
    assert float(number) * factor == pytest.approx(seconds, rel=1e-11)


def test_a_measurement_survives_storage() -> None:
    import json

    changes = (Change("a", "B"), Change("c", "0", is_use=False))
    row = measured(Configuration("rk4", step=0.1, changes=changes), 1.0, 2.0, residual=1e-7)
    assert from_json(Measurement, json.loads(json.dumps(to_json(row)))) == row
