"""Every command that compiles a scene prints what the compiler warns of."""

from pathlib import Path

import pytest
from click.testing import CliRunner
from model_files import model_text

import bgc
from bgc.runtime.cli.app import application

ODD = model_text("warnings_odd")
COMMANDS = [
    "activity",
    "bode --input supply.e --output loop.f",
    "build --target c",
    "build --target so",
    "causality",
    "check",
    "cost",
    "equations",
    "equations --latex",
    "equations --linear",
    "graph --out odd.dot",
    "run",
    "show --after elaborate",
    "show --after causality",
    "show --after equations",
    "stress --budget 2",
    "sweep --vary r=1..2:2 --out odd.csv",
    "trade --budget 2",
]


@pytest.mark.parametrize("command", COMMANDS)
@pytest.mark.slow
def test_a_negative_resistance_is_reported_by_every_command(command, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("odd.bg").write_text(ODD)
    name, *options = command.split()
    result = CliRunner().invoke(application, [name, "odd.bg", *options])
    assert "BG460" in result.stderr, (result.exception, result.output)
    assert result.stderr.count("BG460") == 1


@pytest.fixture(scope="module")
def odd(tmp_path_factory):
    path = tmp_path_factory.mktemp("odd") / "odd.bg"
    path.write_text(ODD.replace("-2 ohm", "2 ohm"), encoding="utf-8")
    return bgc.compile(path)


def steps(model, parameters):
    with model.step(parameters=parameters) as run:
        run.advance("0.1 ms")
        under_way = run.warnings
    assert run.warnings == under_way  # they stay when it is over
    return run


def fitted(model, values):
    """The estimate of a resistance from a run with it."""
    found = model.simulate(parameters=values)
    motion = {"time": found.time, "loop.f": found["loop.f"]}
    return model.fit(motion, {"r": f"{values['r'] - 1}..{values['r'] + 1} ohm"})


def least(model, values):
    """The design with the least current, that of the largest resistance."""
    ranges = {"r": f"{values['r'] - 1}..{values['r']} ohm"}
    return model.optimise(ranges, minimise="max(loop.f)")


ENTRIES = {
    "simulate": lambda model, values: model.simulate(parameters=values),
    "step": steps,
    "simulate_many": lambda model, values: model.simulate_many([values, {"r": 1}]),
    "one by one": lambda model, values: model.simulate_many([values], vectorised=False),
    "sweep": lambda model, values: model.sweep({"r": [1, values["r"]]}),
    "observed": lambda model, values: model.sweep({"r": [values["r"]]}, ["max(loop.f)"]),
    "fit": fitted,
    "optimise": least,
    "linearise": lambda model, values: model.linearise(["supply.e"], parameters=values),
    "symbolic": lambda model, values: model.symbolic(["supply.e"], parameters=values),
}


@pytest.mark.parametrize("values", [{"r": -3}, {"r": 3}], ids=["negative", "positive"])
@pytest.mark.parametrize("entry", ENTRIES)
def test_a_negative_resistance_is_reported_by_what_a_method_returns(odd, entry, values):
    found = [warning.code for warning in ENTRIES[entry](odd, values).warnings]
    assert found == (["BG460"] if values["r"] < 0 else [])


def test_a_parameter_that_all_runs_have_is_reported_once(odd):
    odd.parameters["r"] = -3
    try:
        found = odd.simulate_many([{}, {}])
    finally:
        odd.parameters["r"] = 2
    assert [warning.code for warning in found.warnings] == ["BG460"]
