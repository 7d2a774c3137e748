"""Emitted C under the address and undefined-behaviour sanitisers and valgrind, and its bits."""

from __future__ import annotations

import re
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest

from bgc.building.build import runtime_directory
from bgc.building.toolchain import find_toolchain
from bgc.driver import compile_scene
from bgc.emission.emit import amalgamate
from bgc.options import Options

pytestmark = pytest.mark.slow

TESTS = Path(__file__).parents[1]
FOLDERS = (TESTS / "golden").iterdir()
GOLDEN = sorted(f.name for f in FOLDERS if (TESTS / "models" / f"{f.name}.bg").is_file())
# More than the golden ones have: switches, algebraic loops, fields.
FURTHER = ["events", "loops", "pivots"]
SANITISERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")


@cache
def self_contained(model: str) -> str:
    """One C file with the model, the runtime and a main that runs it with every method."""
    emitted = compile_scene(TESTS / "models" / f"{model}.bg", Options(), until="emit").emitted
    main = (Path(__file__).parent / "sanitised_main.c").read_text()
    return amalgamate(emitted, runtime_directory()) + main


def build(model: str, folder: Path, *flags: str) -> Path:
    source, program = folder / "program.c", folder / "program"
    source.write_text(self_contained(model))
    command = [
        *find_toolchain().command,
        "-std=c11",
        *flags,
        str(source),
        "-o",
        str(program),
        "-lm",
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if "-fsanitize" in " ".join(flags) and "cannot find" in done.stderr:
        pytest.skip("the C compiler has no sanitisers here")
    assert done.returncode == 0, done.stderr
    return program


def output(*command: str | Path) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr + done.stdout
    return done.stdout


@pytest.mark.parametrize("model", [*GOLDEN, *FURTHER])
def test_emitted_c_is_clean_under_sanitisers(model: str, tmp_path: Path) -> None:
    assert output(build(model, tmp_path, "-O0", *SANITISERS))


@pytest.mark.parametrize("model", ["duffing", "events"])
def test_two_runs_give_the_same_bits(model: str, tmp_path: Path) -> None:
    program = build(model, tmp_path, "-O2")
    assert output(program) == output(program)


def test_nothing_is_allocated_inside_a_step(tmp_path: Path) -> None:
    """As many allocations for a hundred times the steps."""
    if shutil.which("valgrind") is None:
        pytest.skip("valgrind is not installed")
    program = build("duffing", tmp_path, "-O1")

    def allocations(steps: str) -> int:
        done = subprocess.run(
            ["valgrind", "--error-exitcode=9", "--leak-check=full", program, steps],
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        found = re.search(r"total heap usage: ([\d,]+) allocs", done.stderr)
        assert found is not None
        return int(found.group(1).replace(",", ""))

    assert allocations("20") == allocations("400")
