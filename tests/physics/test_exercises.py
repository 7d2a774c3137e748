"""The answers to the exercises of the manual agree with closed formulas, at other values too."""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import numpy as np
import pytest
from manual import chapter_named

import bgc

CHAPTER = chapter_named("learn/exercises")
ANSWERS = dict(re.findall(r"^```bg exercise_(\d+)\.bg\n(.*?)^```$", CHAPTER, re.M | re.S))
GRAVITY = 9.81

Values = dict[str, float]
Claim = Callable[[bgc.Result, Values], list[tuple[float, float]]]


def charging(run: bgc.Result, p: Values) -> list[tuple[float, float]]:
    expected = p["U"] * (1 - np.exp(-run.time / (p["R"] * p["C"])))
    return list(zip(run["voltage"], expected, strict=True))


def mass_on_spring(run: bgc.Result, p: Values) -> list[tuple[float, float]]:
    expected = p["x0"] * np.cos(math.sqrt(p["k"] / p["m"]) * run.time)
    return list(zip(run["x"] + 1, expected + 1, strict=True))  # to 1e-5 m


def two_capacitors(run: bgc.Result, p: Values) -> list[tuple[float, float]]:
    total = p["C1"] + p["C2"]
    common = p["C1"] * p["U"] / total
    heat = p["U"] ** 2 / 2 * p["C1"] * p["C2"] / total
    return [(run["left"][-1], common), (run["right"][-1], common), (run["heat"][-1], heat)]


def overshoot(run: bgc.Result, p: Values) -> list[tuple[float, float]]:
    z = p["d"] / (2 * math.sqrt(p["k"] * p["m"]))
    most = p["F"] / p["k"] * (1 + math.exp(-math.pi * z / math.sqrt(1 - z * z)))
    return [(run["x"].max(), most)]


def gear(run: bgc.Result, p: Values) -> list[tuple[float, float]]:
    rate = p["torque"] / (p["J1"] + p["J2"] / p["n"] ** 2)
    drum = p["J2"] * rate / p["n"]
    return [(run["motor_speed"][-1], rate * run.time[-1]), (run["drum_torque"][-1], drum)]


def motor(run: bgc.Result, p: Values) -> list[tuple[float, float]]:
    speed = p["k"] * p["U"] / (p["k"] ** 2 + p["R"] * p["b"])
    return [(run["speed"][-1], speed), (run["current"][-1], p["b"] * speed / p["k"])]


def jack(run: bgc.Result, p: Values) -> list[tuple[float, float]]:
    pressure = p["m"] * p["g"] / p["A"]
    return [
        (run["pressure [bar]"][-1], pressure / 1e5),
        (run["speed"][-1], (p["Q"] - p["G"] * pressure) / p["A"]),
    ]


def pendulum(run: bgc.Result, p: Values) -> list[tuple[float, float]]:
    """The times of the zeros are odd quarters of the period."""
    a, b = 1.0, math.cos(p["angle0"] / 2)
    for _ in range(6):
        a, b = (a + b) / 2, math.sqrt(a * b)
    period = 2 * math.pi * math.sqrt(p["l"] / GRAVITY) / a
    angle, time = run["angle"], run.time
    before = np.flatnonzero(angle[:-1] * angle[1:] < 0)
    zeros = time[before] + angle[before] / (angle[before] - angle[before + 1]) * 1e-3
    return [(zero, (k + 0.5) * period / 2) for k, zero in enumerate(zeros)]


def actuator(run: bgc.Result, p: Values) -> list[tuple[float, float]]:
    pull = 8.854e-12 * 1e-4 * p["U"] ** 2 / 2
    roots = np.roots([p["k"], -p["k"] * p["gap0"], 0, pull])
    rest = max(root.real for root in roots if abs(root.imag) < 1e-12)
    return [(run["distance"][-1], rest)]


def boom(run: bgc.Result, p: Values) -> list[tuple[float, float]]:
    arm = p["mass"] * p["length"] / 2 + p["load"] * p["length"]
    return [(run["torque [kN*m]"][-1], arm * GRAVITY * math.cos(p["angle"]) / 1e3)]


EXERCISES: dict[str, tuple[Claim, Values]] = {
    "1": (charging, {"R": 2e3, "U": 3.0}),
    "2": (mass_on_spring, {"m": 3.0, "x0": 0.02}),
    "3": (two_capacitors, {"C1": 2e-4, "R": 20.0}),
    "4": (overshoot, {"d": 6.0, "F": 4.0}),
    "5": (gear, {"n": 5.0, "torque": 3.0}),
    "6": (motor, {"U": 9.0, "b": 2e-3}),
    "7": (jack, {"m": 700.0, "A": 1e-3}),
    "8": (pendulum, {"l": 0.7, "angle0": 1.5}),
    "9": (actuator, {"U": 40.0, "k": 12.0}),
    "10": (boom, {"angle": 0.3, "load": 5e3}),
}
"""The formula of each answer, and other values at which it is compared too."""


def test_every_exercise_has_its_formula() -> None:
    assert list(ANSWERS) == list(EXERCISES)


@pytest.mark.parametrize("number", EXERCISES)
def test_the_answer_agrees_with_its_formula(number: str, tmp_path) -> None:
    claim, others = EXERCISES[number]
    path = tmp_path / "exercise.bg"
    path.write_text(ANSWERS[number])
    model = bgc.compile(path)
    for values in ({}, others):
        for name, value in values.items():
            model.parameters[name] = value
        pairs = claim(model.simulate(), {n: p.value for n, p in model.parameters.items()})
        assert pairs
        for found, expected in pairs:
            assert found == pytest.approx(expected, rel=2e-5)
