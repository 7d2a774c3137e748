"""Emitted C under the address and undefined-behaviour sanitisers and valgrind, and its bits."""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from bgc.building.build import runtime_directory, runtime_sources
from bgc.building.toolchain import find_toolchain
from bgc.driver import compile_scene
from bgc.emission.amalgamate import joined
from bgc.options import Options

pytestmark = pytest.mark.slow

TESTS = Path(__file__).parents[1]
MODELS = TESTS / "models"
MAIN = Path(__file__).parent / "sanitised_main.c"
RUNTIME = runtime_directory()
FOLDERS = (TESTS / "golden").iterdir()
GOLDEN = sorted(f.name for f in FOLDERS if (MODELS / f"{f.name}.bg").is_file())
# More than the golden ones have: switches, algebraic loops, fields.
FURTHER = ["events", "loops", "pivots"]
SANITISERS = ("-fsanitize=address,undefined", "-fno-sanitize-recover=all")


@pytest.fixture(scope="module")
def build(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Path]:
    """Builds a program that runs a model with every method; each level has one runtime."""
    sources = [(name, path.read_text("utf-8")) for name, path in runtime_sources(RUNTIME).items()]

    def compile_c(folder: Path, *arguments: str | Path) -> None:
        command = [*find_toolchain().command, "-std=c11", f"-I{RUNTIME}", *arguments]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if "-fsanitize" in " ".join(map(str, arguments)) and "cannot find" in done.stderr:
            pytest.skip("the C compiler has no sanitisers here")
        assert done.returncode == 0, done.stderr

    @cache
    def runtime(*flags: str) -> Path:
        folder = tmp_path_factory.mktemp("runtime")
        (folder / "runtime.c").write_text(joined(sources, RUNTIME))
        compile_c(folder, *flags, "-c", "runtime.c")
        return folder / "runtime.o"

    def program(model: str, folder: Path, *flags: str) -> Path:
        units = compile_scene(MODELS / f"{model}.bg", Options(), until="emit").emitted.units
        for unit in units:
            (folder / f"{unit.name}.c").write_text(unit.text)
        own = [f"{unit.name}.c" for unit in units]
        compile_c(folder, *flags, *own, MAIN, runtime(*flags), "-o", "program", "-lm")
        return folder / "program"

    return program


def output(*command: str | Path) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr + done.stdout
    return done.stdout


@pytest.mark.parametrize("model", [*GOLDEN, *FURTHER])
def test_emitted_c_is_clean_under_sanitisers(
    build: Callable[..., Path], model: str, tmp_path: Path
) -> None:
    assert output(build(model, tmp_path, "-O0", *SANITISERS))


@pytest.mark.parametrize("model", ["duffing", "events"])
def test_two_runs_give_the_same_bits(
    build: Callable[..., Path], model: str, tmp_path: Path
) -> None:
    program = build(model, tmp_path, "-O1")
    assert output(program) == output(program)


def test_nothing_is_allocated_inside_a_step(build: Callable[..., Path], tmp_path: Path) -> None:
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
