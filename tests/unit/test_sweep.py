"""`bgc sweep`: ranges, points, and what is wrong with them."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from model_files import model_text

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.app import application
from bgc.runtime.running.parameter_grid import Listed, Range, points, read_axis
from bgc.runtime.running.parameters import Parameters

TEXT = model_text("sweep")


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "m.bg"
    path.write_text(TEXT)
    return path


@pytest.fixture
def parameters(file: Path) -> Parameters:
    return bgc.compile(file).parameters


def test_a_unit_at_the_end_is_for_both_and_each_may_have_its_own(parameters: Parameters) -> None:
    for text, axis in (
        ("mass=2..5 kg:4", Range("mass", 2, 5, 4)),
        ("mass=2, 0.005 t", Listed("mass", (2000.0, 5.0))),
        ("mass = 2 t", Listed("mass", (2000.0,))),
        ("mass = 200 g .. 0.005 t : 3", Range("mass", 0.2, 5, 3)),
        ("mass=2..5", Range("mass", 2, 5)),
    ):
        assert read_axis(text, parameters.unit_of) == axis
    assert len(Range("mass", 2, 5).values()) == 10


@pytest.mark.parametrize(
    ("text", "code"),
    [
        ("mass", "BG743"),
        ("mass=2,", "BG743"),
        ("mass=2:3", "BG743"),
        ("mass=2..", "BG743"),
        ("mass=2..3:0", "BG743"),
        ("mass=2..3:x", "BG743"),
        ("mass=2..3:1000000000000", "BG745"),
        ("mass=2..3:" + 5000 * "9", "BG745"),
        ("mass=2..3 V", "BG063"),
        ("mass=two..3", "BG062"),
        ("n=2..3", "BG060"),
    ],
)
def test_what_is_no_range_is_refused(parameters: Parameters, text: str, code: str) -> None:
    with pytest.raises(BgError) as caught:
        read_axis(text, parameters.unit_of)
    assert [d.code for d in caught.value.diagnostics] == [code]


def test_every_combination_is_a_point() -> None:
    found = points([Range("a", 0, 1, 2), Range("b", 0, 2, 3)], None)
    pairs = set(zip(found["a"].tolist(), found["b"].tolist(), strict=True))
    assert pairs == {(a, b) for a in (0.0, 1.0) for b in (0.0, 1.0, 2.0)}


def test_a_sample_covers_each_range_evenly() -> None:
    found = points([Range("a", 0, 1), Range("b", -10, 10)], 20)
    for name, low, high in (("a", 0, 1), ("b", -10, 10)):
        cells = np.floor((found[name] - low) / (high - low) * 20)
        assert sorted(cells) == list(range(20))


def test_ranges_that_contradict_or_are_too_many_are_refused() -> None:
    with pytest.raises(BgError, match="BG744"):
        points([Range("a", 0, 1), Range("a", 2, 3)], None)
    with pytest.raises(BgError, match="BG745"):
        points([Range(name, 0, 1, 10) for name in "abcdefg"], None)
    with pytest.raises(BgError, match="BG745"):
        points([Range("a", 0, 1)], 10**9)
    with pytest.raises(BgError, match=r"BG066.*seed.*-1"):
        points([Range("a", 0, 1)], 4, seed=-1)


def run(*arguments: str) -> Result:
    return CliRunner().invoke(application, ["sweep", *arguments])


@pytest.mark.slow
def test_the_command_runs_what_another_model_in_a_slot_gives(file: Path, tmp_path: Path) -> None:
    out = tmp_path / "o.csv"
    done = run(str(file), "--vary", "mass=1..4 kg:4", "--use", "mount=Stiff", "--out", str(out))
    assert done.exit_code == 0, done.output
    rows = list(csv.DictReader(out.read_text().splitlines()))
    last = [row for row in rows if float(row["time"]) == 1.0]
    assert [float(row["mass"]) for row in last] == [1, 2, 3, 4]
    for row in last:
        expected = np.cos(np.sqrt(16 / float(row["mass"])))
        assert float(row["v"]) == pytest.approx(expected, abs=1e-4)


def test_an_instance_out_of_a_parameters_range_is_refused(file: Path, tmp_path: Path) -> None:
    done = run(str(file), "--vary", "mass=-1..4 kg", "--out", str(tmp_path / "o.csv"))
    assert done.exit_code == 1 and "BG061" in done.output


@pytest.mark.slow
def test_rows_go_to_standard_output_and_errors_name_their_instance(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    model = 'model M { param a = 1; state x = 1; der(x) = a; assert x < 4, "over"; }'
    Path("m.bg").write_text(f"{model}\nscene s of M {{ observe x; run 1 s every 1 s; }}")
    done = run("m.bg", "--vary", "a=1..4:3", "--out", "-")
    assert done.exit_code == 1
    rows = list(csv.DictReader(done.stdout.splitlines()))
    assert [float(row["x"]) for row in rows[:4]] == pytest.approx([1, 2, 1, 3.5], abs=1e-6)
    assert "in instance 2, with `a` = 4" in done.stderr and "1 failed" in done.stderr
    assert not Path("-").exists()


@pytest.mark.parametrize("command", ["trade", "stress"])
def test_a_command_with_one_kind_of_file_refuses_standard_output(command: str, file: Path) -> None:
    done = CliRunner().invoke(application, [command, str(file), "--out", "-"])
    assert done.exit_code and "BG" in done.output and not Path("-").exists()
