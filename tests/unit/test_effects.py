"""Effects of parameters on observables, against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner
from model_files import model_file

import bgc
from bgc.runtime.cli.app import application

FILE = model_file("optimise_spring")


@pytest.fixture(scope="module")
def spring() -> bgc.Model:
    found = bgc.compile(FILE)
    found.parameters["k"] = 50.0
    return found


@pytest.mark.parametrize("options", [{}, {"solver": "radau5", "rtol": 1e-9}])
def test_the_stretch_of_a_spring_is_v_sqrt_of_m_over_k(spring, options):
    """`radau5` has no sensitivities, so that differences take their place."""
    k, v, m = (spring.parameters[name].value for name in ("k", "v", "mass"))
    found = spring.effects(["max(x)", "max(force)"], of=["k", "v"], **options)
    stretch, force = v * np.sqrt(m / k), v * np.sqrt(m * k)
    assert found.values == pytest.approx([1e3 * stretch, force], rel=1e-5)
    expected = 0.01 * np.array([[-1e3 * stretch / 2, force / 2], [1e3 * stretch, force]])
    assert found.per_cent == pytest.approx(expected, rel=1e-3)
    assert found.ranking("max(x)") == ["v", "k"]


def test_parameters_without_effect_are_counted_and_bars_drawn(spring, tmp_path):
    found = spring.effects(["max(x)"])
    (table,) = found.tables()
    assert [row[0] for row in table.rows][-1] != "unused" and "1 parameter with" in table.note
    assert found.texts("max(x)")["v"].endswith(" mm")
    assert len(found.plot().axes) == 1
    found.to_csv(tmp_path / "e.csv")
    head, *lines = (tmp_path / "e.csv").read_text().splitlines()
    assert head == "parameter,value,observable,of,slope,effect"
    assert len(lines) == len(found.parameters)


def test_what_has_no_effects_is_refused(spring):
    with pytest.raises(bgc.BgError, match="BG787"):
        spring.effects(["above(x, 1 mm)"])
    with pytest.raises(bgc.BgError, match="BG060"):
        spring.effects(["max(x)"], of=["stiff"])


def test_the_commands_print_effects(tmp_path):
    plot = tmp_path / "t.svg"
    given = [str(FILE), "--set", "k=50 N/m"]
    done = CliRunner().invoke(application, ["sensitivity", *given, "--plot", str(plot)])
    assert done.exit_code == 0, done.output
    assert "by 1 % more" in done.output and "peak(x)" in done.output
    assert plot.read_text("utf-8").startswith("<?xml")
    many = ["--vary", "k=20..90 N/m", "--sample", "8", "--rank"]
    observed = ["--observe", "max(x)", "--observe", "above(x, 200 mm)"]
    done = CliRunner().invoke(application, ["sweep", *given, *many, *observed])
    assert done.exit_code == 0, done.output
    (row,) = [line for line in done.output.splitlines() if line.startswith("  k ")][:1]
    assert row.endswith(" mm") and "-" in row
