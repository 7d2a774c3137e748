"""What a run says of the `require` statements of its scene."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import bgc
from bgc.runtime.cli.app import application
from bgc.runtime.results.summary import requirements

# Its largest values, 2 F/k and 2 F, lie between the rows.
PULL = """
model Pull {
  param F = 10 N;
  mass : I(1 kg);
  spring : C(stiffness = 100 N/m);
  pull : Se(e = F);
  motion : J1;
  pull -> motion -> mass, spring;
}
scene pulled of Pull {
  observe spring.q in cm as stretch, spring.e as tension, motion.f as v, [motion.f, -motion.f] as w;
  require tension < 20.5 N;
  require v > -2 m/s;
  require abs(w) < 1.1 m/s;
  require stretch within 0.1 mm;
  require motion.f^2 within 1000 mm^2/s^2;
  run 3 s every 1 s;
}
"""


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("required") / "pull.bg"
    path.write_text(PULL)
    return path


@pytest.fixture(scope="module")
def model(path):
    return bgc.compile(path, preview=True)


def test_values_margins_and_verdicts(model):
    run = model.simulate()
    tension, slow, *fast, stretch, square = run.requirements
    assert tension.text == "max(tension) < 20.5 N" and slow.text == "min(v) > -2 m/s"
    assert tension.value == pytest.approx(20, abs=2e-3) and tension.margin > 0.49
    assert tension.value > run["tension"].max() + 0.5  # between the rows
    assert np.sin(10 * tension.time / 2) ** 2 == pytest.approx(1, abs=1e-4)
    assert slow.value == pytest.approx(-1, abs=1e-3) and slow.margin == slow.value + 2
    assert [each.text for each in fast] == ["peak(w[1]) < 1.1 m/s", "peak(w[2]) < 1.1 m/s"]
    assert all(each.value == pytest.approx(1, abs=1e-3) for each in fast)
    assert stretch.value == pytest.approx(run.error["stretch"].max() / 100)  # of a column in cm
    assert stretch.value < 1e-5
    assert square.value < 1e-3 and square.text == "motion.f^2 within 0.001 m^2/s^2"
    assert all(each.holds for each in run.requirements) and not run.warnings
    text = requirements(run)
    assert text.count("holds") == 6 and "max(tension) < 20.5 N" in text and " x " in text


def test_what_does_not_hold_is_a_warning(model):
    run = model.simulate(parameters={"F": 10.5}, rtol=1e-2)
    assert [each.code for each in run.warnings] == ["BG720", "BG721", "BG721"]
    tension, *_, stretch, _ = run.requirements
    assert tension.holds is False and tension.margin < -0.4
    assert stretch.holds is False and stretch.margin < 0


def test_a_limit_within_the_error_is_not_told_for_certain(model):
    run = model.simulate(parameters={"F": 10.25}, rtol=1e-2)
    assert run.requirements[0].verdict.endswith("within the error")
    assert "+- " in requirements(run)


def test_accuracy_is_unknown_without_an_estimate(model):
    run = model.simulate(error=False)
    *limits, stretch, square = run.requirements
    assert all(each.holds for each in limits)
    assert stretch.holds is None is square.holds and not run.warnings
    assert requirements(run).count("unknown") == 2


def test_rows_are_the_same_bits_without_requirements(model, path):
    text = "\n".join(line for line in PULL.splitlines() if "require" not in line)
    other = path.with_name("free.bg")
    other.write_text(text)
    free = bgc.compile(other, preview=True).simulate()
    run = model.simulate()
    assert requirements(free) == "" and not free.requirements
    for name, column in free.columns.items():
        assert column.tobytes() == run[name].tobytes()
        assert (run.error[name] >= 0.9 * free.error[name]).all()  # looked for at more instants


def test_a_file_of_rows_has_its_requirements(model, tmp_path, monkeypatch):
    monkeypatch.setattr("bgc.runtime.running.row_stream.MOST_VALUES", 10)
    run = model.simulate(out=tmp_path / "r.csv")
    assert run.rows == 4 and [each.holds for each in run.requirements] == [True] * 4 + [None] * 2


def test_the_status_is_that_of_warnings(path):
    def bgc_run(*more):
        return CliRunner().invoke(application, ["run", str(path), "--preview", *more])

    good = bgc_run("--json")
    found = json.loads(good.stdout)
    assert good.exit_code == 0 and found["columns"]["tension"]["unit"] == "N"
    assert found["columns"]["tension"]["error"] < 1e-4
    assert [each["holds"] for each in found["requirements"]] == [True] * 6
    missed = ("--set", "F=11 N")
    assert bgc_run(*missed).exit_code == 0 and "missed" in bgc_run(*missed).stdout
    strict = bgc_run(*missed, "--strict")
    assert strict.exit_code == 1 and "error[BG720]" in strict.stderr
    unknown = json.loads(bgc_run("--json", "--no-error").stdout)
    assert unknown["requirements"][-1]["holds"] is None
    assert unknown["columns"]["v"]["error"] is None
    assert bgc_run("--json", "--out", "-").exit_code == 2
