"""Operability: cells, governing criteria, limiting heights, extremes over seeds, downtime."""

from __future__ import annotations

import numpy as np
import pytest
from click.testing import CliRunner
from model_files import model_file

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.app import application
from bgc.runtime.model import Model
from bgc.runtime.studies.operability import extreme
from bgc.runtime.studies.operability_result import read_scatter

# Closed forms: the load is height/2 times an amplification over the period, and a pitch that grows
# with the period; a run in the highest sea of the longest period fails.
FILE = model_file("operability")
SEA = ("height=1..5 m:5", "period=4, 8, 12 s")
CRITERIA = ("max(load) < 1.75 kN", "peak(pitch) < 0.14 rad")


@pytest.fixture(scope="module")
def model() -> Model:
    return bgc.compile(FILE)


def test_cells_and_limits_are_those_of_the_closed_form(model, tmp_path):
    found = model.operability(*SEA)
    again = model.operability(*SEA, CRITERIA)
    np.testing.assert_allclose(again.utilisation, found.utilisation, rtol=1e-12)
    heights, periods = np.meshgrid(found.heights, found.periods)
    load, pitch = heights / 2 / 1.75, 0.01 * periods * heights / 2 / 0.14
    expected = np.where(heights * periods < 59, np.maximum(load, pitch), np.inf)
    np.testing.assert_allclose(found.worst[0], expected, rtol=1e-3)
    np.testing.assert_array_equal(found.operable[0], expected <= 1)
    # A limit is named in the unit in which the scene observes: 0.14 rad are 8.02141 deg.
    load, pitch = CRITERIA[0], "peak(pitch) < 8.02141 deg"
    # At 8 s both are as near to their limits.
    assert [found.governing(0, p, 1) for p in (0, 2)] == [load, pitch]
    assert found.governing(0, 2, 4) == "failed" and found.failed.sum() == 1
    np.testing.assert_allclose(found.limiting_heights()[0], [3.5, 3.5, 28 / 12], rtol=2e-3)
    text = repr(found)
    assert "*x" in text and "a run failed (1 runs)" in text and "*1.14 a" in text
    found.to_csv(tmp_path / "o.csv")
    lines = (tmp_path / "o.csv").read_text().splitlines()
    assert len(lines) == 1 + 15 * 2 and sum(line.endswith(",failed") for line in lines) == 2
    assert len(found.plot(tmp_path / "o.png").axes) == 2


def test_downtime_counts_the_sea_states_above_the_limit(model, tmp_path):
    found = model.operability(*SEA, CRITERIA)
    table = tmp_path / "scatter.csv"
    table.write_text("Hs,6,10,14\n1,50,20,\n3,10,10,2\n6,,5,3\n")
    # limits: 3.5 m at 6 s; (3.5 + 2.33)/2 = 2.92 m at 10 s; 2.33 m at 14 s, of the last period
    down = found.downtime(table)
    assert down.total == pytest.approx((10 + 2 + 5 + 3) / 100)
    assert down.outside == pytest.approx((2 + 3 + 5) / 100)
    for wrong in ("Hs,6\n1,-2\n", "Hs,6\n1,x\n", "Hs,6,8\n1,2\n", "Hs,6\n1,0\n", "Hs,6\n"):
        table.write_text(wrong)
        with pytest.raises(BgError, match="BG788"):
            read_scatter(table)


def test_seeds_make_extremes(model):
    seeds = (*SEA, ["max(load) < 1.75 kN"])
    found = model.operability(*seeds, seed="seed=1, 2, 3, 4, 5")
    factors = 1 + 0.1 * (np.arange(1, 6) - 3)
    mode = 1 - (0.5772156649 * np.sqrt(6) / np.pi) * factors.std(ddof=1)
    load = found.heights / 2
    np.testing.assert_allclose(found.values[0, 0, :, 0], mode * load, rtol=1e-3)
    long = model.operability(*seeds, seed="seed=1, 2, 3, 4, 5", exposure="100 s")
    more = np.sqrt(6) / np.pi * factors.std(ddof=1) * np.log(10)
    np.testing.assert_allclose(long.values[0, 0, :, 0], (mode + more) * load, rtol=1e-3)
    worst = model.operability(*seeds, seed="seed=1, 2, 3, 4, 5", judge="worst")
    np.testing.assert_allclose(worst.values[0, 0, :, 0], 1.2 * load, rtol=1e-3)


def test_the_most_probable_maximum_of_gumbel_samples():
    sample = np.random.default_rng(1).gumbel(10, 2, (1, 20000))
    assert extreme(sample, True, "gumbel")[0] == pytest.approx(10, abs=0.05)
    assert extreme(-sample, False, "gumbel")[0] == pytest.approx(-10, abs=0.05)
    # The largest of 50 such parts has its mode 2 ln 50 higher.
    largest = sample.reshape(-1, 50).max(axis=1)[None]
    moved = extreme(sample, True, "gumbel", np.log(50))[0]
    assert extreme(largest, True, "gumbel")[0] == pytest.approx(moved, abs=0.3)


@pytest.mark.parametrize(
    ("arguments", "options", "code"),
    [
        (("height=5..1 m:3", SEA[1], CRITERIA), {}, "BG743"),
        ((*SEA, ["max(load)"]), {}, "BG787"),
        ((*SEA, ["max(load) < 3 m"]), {}, "BG063"),
        ((*SEA, CRITERIA), {"judge": "best"}, "BG066"),
        ((*SEA, CRITERIA), {"exposure": -1}, "BG066"),
        ((*SEA, CRITERIA), {"exposure": "3 h"}, "BG066"),
        ((*SEA, CRITERIA), {"exposure": "3 h", "seed": "seed=1, 2", "judge": "worst"}, "BG066"),
        ((*SEA, CRITERIA), {"heading": "course=0, 90 deg"}, "BG060"),
    ],
)
def test_bad_arguments_are_refused(model, arguments, options, code):
    with pytest.raises(BgError) as caught:
        model.operability(*arguments, **options)
    assert [d.code for d in caught.value.diagnostics] == [code]


def test_a_scene_without_limits_needs_criteria():
    with pytest.raises(BgError, match=r"BG787.* there is no criterion"):
        bgc.compile(FILE, scene="free").operability(*SEA)


def test_the_command_prints_cells_and_downtime(tmp_path):
    table, plot = tmp_path / "scatter.csv", tmp_path / "o.png"
    table.write_text("Hs,6,10\n1,60,20\n3,10,10\n")
    sea = ("--height", SEA[0], "--period", SEA[1], "--require", CRITERIA[0])
    rest = ("--scatter", table, "--plot", plot, "-q")
    done = CliRunner().invoke(application, ["operability", *map(str, (FILE, *sea, *rest))])
    assert done.exit_code == 1, done.output  # of the sea state that fails, with all results
    assert "a  max(load) < 1.75 kN" in done.output and "downtime" in done.output
    assert "5 m    *1.43 a" in done.output and plot.read_bytes().startswith(b"\x89PNG")
    lower = ("--height", "height=1, 2 m", *sea[2:], "-q")
    assert CliRunner().invoke(application, ["operability", str(FILE), *lower]).exit_code == 0
