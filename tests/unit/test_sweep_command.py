"""`bgc sweep`: its ranges, samples and options, and what an interruption leaves."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from ensembles import interrupt_after

import bgc
from bgc.runtime.cli.app import application
from bgc.runtime.running import many, partial_ensemble

pytestmark = pytest.mark.slow


def sweep(*arguments: str | Path):
    return CliRunner().invoke(application, ["sweep", *map(str, arguments)])


def test_an_interrupted_sweep_writes_what_is_done_and_goes_on(
    oscillator_file, monkeypatch, tmp_path
):
    monkeypatch.setattr(partial_ensemble, "FOLDER", str(tmp_path / "sweeps"))
    out = tmp_path / "many.csv"
    command = (
        oscillator_file,
        "--vary",
        "k=5..7 N/m:40",
        "--solver",
        "ros34prw",
        "--step",
        "10 ms",
    )
    with monkeypatch.context() as patch:
        interrupt_after(patch, 1)
        ended = sweep(*command, "--out", out)
    assert ended.exit_code == 130
    match = re.match(r"interrupted when (\d+) of 40 instances were done; the same", ended.stderr)
    assert match is not None, ended.stderr
    with out.open() as file:
        assert len({row["instance"] for row in csv.DictReader(file)}) == int(match[1])
    done = sweep(*command, "--out", out)
    assert (done.exit_code, done.output) == (
        0,
        f"40 done; {match[1]} of them before\nwrote {out}\n",
    )
    assert "nan" not in out.read_text()


def test_a_sweep_that_is_interrupted_while_it_compiles_writes_nothing(
    oscillator_file, monkeypatch, tmp_path
):
    def interrupted(*arguments, **named):
        raise KeyboardInterrupt

    monkeypatch.setattr(many, "lane_library", interrupted)
    ended = sweep(oscillator_file, "--vary", "k=5..7 N/m:40", "--out", tmp_path / "many.csv")
    assert (ended.exit_code, "nothing is written" in ended.stderr) == (130, True)
    assert not (tmp_path / "many.csv").exists()


def test_a_sweep_runs_every_combination(oscillator_file, tmp_path):
    out = tmp_path / "many.csv"
    ranges = ("--vary", "k=5..7 N/m:3", "--vary", "mass=1000..2000 g:2")
    done = sweep(oscillator_file, *ranges, "--solver", "ros34prw", "--step", "10 ms", "--out", out)
    assert (done.exit_code, done.output) == (0, f"6 done\nwrote {out}\n")
    with out.open() as file:
        rows = list(csv.DictReader(file))
    pairs = list(dict.fromkeys((float(row["k"]), float(row["mass"])) for row in rows))
    assert pairs == [(5, 1), (5, 2), (6, 1), (6, 2), (7, 1), (7, 2)]


def test_a_sweep_takes_the_options_of_a_run(oscillator_file, tmp_path):
    out = tmp_path / "many.npz"
    method = ("--solver", "rodas5p", "--atol", "0.1", "--max-step", "0.05", "--time", "0.4")
    ranges = ("--vary", "k=5..7 N/m:3", "-q", "--out", out)
    assert sweep(oscillator_file, *ranges, *method).exit_code == 0
    model = bgc.compile(oscillator_file)
    sets = {"k": np.linspace(5, 7, 3)}
    expected = model.simulate_many(sets, 0.4, solver="rodas5p", atol=0.1, max_step=0.05)
    with np.load(out) as archive:
        assert np.array_equal(archive["values"], expected.values)
    other = model.simulate_many(sets, 0.4, solver="rodas5p", atol=0.1)
    assert not np.array_equal(other.values, expected.values)
    refused = sweep(oscillator_file, *ranges, "--solver", "rodas5p", "--substeps", "4")
    assert refused.exit_code == 1 and "BG044" in refused.output


def test_a_sample_covers_every_range_evenly(oscillator_file, tmp_path):
    out = tmp_path / "many.npz"
    options = ("--sample", "10", "--time", "0.1", "-q", "--out", out)
    done = sweep(oscillator_file, "--vary", "k=10..20", "--vary", "mass=1..3 kg", *options)
    assert (done.exit_code, done.output) == (0, "")
    with np.load(out) as archive:
        k, mass = np.floor(archive["parameter:k"] - 10), archive["parameter:mass"]
        m = np.floor((mass - 1) * 5)
    assert sorted(k) == sorted(m) == list(range(10))
    assert abs(np.corrcoef(k, m)[0, 1]) < 0.8  # not all along a diagonal


@pytest.mark.parametrize("text", ["k", "k=5:2", "k=5..", "k=5..6:many", "=1..2"])
def test_a_range_that_is_none(text, oscillator_file, tmp_path):
    done = sweep(oscillator_file, "--vary", text, "--out", tmp_path / "many.csv")
    assert done.exit_code == 1 and "BG743" in done.output


def test_commands_name_the_files_that_they_write(oscillator_file, tmp_path):
    given = ["--input", "push.e", "--output", "spring.q"]
    names = [str(tmp_path / f"{k}.{kind}") for k, kind in enumerate(("csv", "png"))]
    for command in (
        ["bode", *given, "--out", names[0], "--plot", names[1]],
        ["step", *given, "--out", names[0], "--plot", names[1]],
        ["locus", *given, "--out", names[0], "--plot", names[1]],
        ["modes", "--out", names[0], "--plot", names[1]],
        ["margins", *given, "--nyquist", names[0].replace("csv", "svg"), "--nichols", names[1]],
    ):
        done = CliRunner().invoke(application, [command[0], str(oscillator_file), *command[1:]])
        assert done.exit_code == 0, done.output
        first = command[command.index(names[1]) - 2]
        assert done.stdout.endswith(f"\nwrote {first} and {names[1]}\n")
    arguments = ["step", oscillator_file, *given, "--out", "-"]
    done = CliRunner().invoke(application, [*map(str, arguments), "--plot", names[1]])
    assert "wrote" not in done.stdout and done.stderr == f"wrote {names[1]}\n"
