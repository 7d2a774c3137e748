"""`--strict` makes every warning an error, from the cache too."""

import subprocess
import sys
from pathlib import Path

import pytest
from refusals import refusal

import bgc
from bgc.diagnostics.diagnostic import Severity, as_error

pytestmark = pytest.mark.slow

ODD = """
model M { push : Se(e = 1); node : J1; mass : I(1); drag : R(-2); push -> node -> mass, drag; }
scene s of M { observe mass.f; run 10 ms; }"""
SOUND = ODD.replace("-2", "2")
UNDEFINED = SOUND.replace("observe mass.f", "observe sqrt(mass.f - 1) as x")


def command(*arguments: str, cwd: Path) -> tuple[int, str]:
    made = "from bgc.runtime.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", made, *arguments], cwd=cwd, capture_output=True, text=True
    )
    return done.returncode, done.stderr


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    for name, text in {"odd": ODD, "sound": SOUND, "undefined": UNDEFINED}.items():
        (tmp_path / f"{name}.bg").write_text(text)
    return tmp_path


@pytest.mark.parametrize("words", [("check",), ("build", "--target", "c"), ("run",)])
def test_a_warning_ends_the_command_with_status_1(folder, words):
    status, said = command(*words, "odd.bg", cwd=folder)
    assert status == 0 and "warning[BG460]" in said
    status, said = command(*words, "--strict", "odd.bg", cwd=folder)
    assert status == 1 and "error[BG460]" in said and "`strict`" in said
    assert command(*words, "--strict", "sound.bg", cwd=folder)[0] == 0


def test_a_build_in_the_cache_makes_no_difference(folder):
    path = folder / "odd.bg"
    for _ in range(2):
        assert [w.code for w in bgc.compile(path).warnings] == ["BG460"]
        problem = refusal(bgc.compile, path, strict=True)
        assert (problem.code, problem.severity) == ("BG460", Severity.ERROR)
    bgc.compile(folder / "sound.bg", strict=True)
    assert bgc.compile(folder / "sound.bg", strict=True).warm


def test_a_warning_of_the_run_itself_counts_and_its_rows_are_kept(folder):
    status, said = command("run", "undefined.bg", "--out", "rows.csv", cwd=folder)
    assert status == 0 and "warning[BG712]" in said
    status, said = command("run", "--strict", "undefined.bg", "--out", "strict.csv", cwd=folder)
    assert status == 1 and "error[BG712]" in said
    assert (folder / "strict.csv").read_text() == (folder / "rows.csv").read_text()


def test_errors_stay_what_they_are(folder):
    problem = refusal(bgc.compile, folder / "nowhere.bg")
    assert as_error(problem) is problem
