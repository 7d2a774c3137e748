"""The crane of `crane.bg`, compiled, and measured in fresh copies.

Straight-line code of 60 to 100 kB exceeds the instruction cache, so where a copy happens to lie
moves its time by up to 25 %: figures are medians over several copies of the shared object. Times
are those of the processor: what others do on the machine does not count.
"""

from __future__ import annotations

import ctypes
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from hashlib import blake2b
from pathlib import Path
from time import thread_time

import numpy as np

from bgc.building.build import runtime_directory
from bgc.building.toolchain import find_toolchain
from bgc.driver import Stages, compile_scene
from bgc.language.methods import METHODS
from bgc.options import Options
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance, Library
from bgc.runtime.running.structures import OptionsStruct, Status

HERE = Path(__file__).parent
BODIES = ("vessel", "column", "boom", "jib")
COPIES = 5


@dataclass(frozen=True)
class Crane:
    """A compiled scene: its shared object, and operations of each function."""

    path: Path
    operations: dict[str, int]
    stages: Stages


@cache
def crane(scene: str, file: str = "crane.bg") -> Crane:
    """A scene of the benchmarks' models."""
    stages = compile_scene(HERE / file, Options(scene=scene))
    return Crane(stages.built.library, dict(stages.emitted.operations), stages)


@contextmanager
def copies(path: Path, count: int = COPIES) -> Iterator[list[Library]]:
    """The same shared object, loaded several times from fresh copies."""
    with tempfile.TemporaryDirectory() as folder:
        made = []
        for k in range(count):
            copy = Path(folder) / f"{k}_{path.name}"
            shutil.copyfile(path, copy)
            made.append(Library(copy))
        yield made


def instance(library: Library, **parameters: float) -> Instance:
    """An instance at its initial state."""
    made = Instance(library)
    model = library.model
    names = {model.param[k].name.decode(): k for k in range(model.n_param)}
    for name, value in parameters.items():
        made.set_parameter(names[name], value)
    assert made.reset() is Status.OK
    return made


def parameters(made: Instance) -> Array:
    """All parameters of an instance."""
    return np.array([made.parameter(k) for k in range(made.library.model.n_param)])


def positions(rows: Array) -> Array:
    """Places of the four bodies out of rows of outputs, (n, 12)."""
    return rows[:, :12]


def run(
    made: Instance,
    times: Array,
    method: str,
    rtol: float = 0.0,
    step: float = 0.0,
    keep: int = 1,
    accounts: bool = False,
) -> tuple[Status, Array, dict[str, float]]:
    """A run from the start; rows of outputs, and what it cost."""
    assert made.reset() is Status.OK
    options = OptionsStruct(name=method.encode(), rtol=rtol, step=step, keep=keep)
    if step > 0.0 and not METHODS[method].fixed:
        options.max_step, options.rtol = step, 1e9  # an adaptive method at a fixed step
    options.accounts = int(accounts)
    assert made.set_options(options) is Status.OK
    rows = np.full((len(times), made.library.model.n_output + 4 * accounts), np.nan)
    begun = thread_time()
    status, _ = made.run(times, rows)
    return status, rows, {**made.counts, "processor_seconds": thread_time() - begun}


def _texts(paths: Sequence[str]) -> list[str]:
    """The texts of sources and of the headers of ours that they include."""
    found: dict[Path, str] = {}
    waiting = [Path(path) for path in paths]
    while waiting:
        path = waiting.pop()
        if path.exists() and path not in found:
            found[path] = path.read_text("utf-8")
            names = re.findall(r'^#include "(.+)"', found[path], re.MULTILINE)
            waiting += [folder / name for name in names for folder in (runtime_directory(), HERE)]
    return [found[path] for path in sorted(found)]


def shared_object(
    sources: Sequence[str], flags: Sequence[str] = (), language: str = "c"
) -> ctypes.CDLL | str:
    """C (or C++) of a benchmark, compiled; or the first line of why it cannot be."""
    paths = [str(HERE / source) for source in sources]
    compiler = find_toolchain().command if language == "c" else ("g++",)
    key = blake2b(digest_size=12)
    for part in (*compiler, *flags, *_texts(paths)):
        key.update(part.encode())
    folder = Path(tempfile.gettempdir()) / "bgc-bench"
    folder.mkdir(exist_ok=True)
    made = folder / f"{key.hexdigest()}.so"
    if not made.exists():
        command = (*compiler, "-O2", "-march=native", "-fPIC", "-shared")
        include = (f"-I{runtime_directory()}", f"-I{HERE}")
        try:
            done = subprocess.run(
                (*command, *include, "-o", str(made), *paths, *flags, "-lm"),
                capture_output=True, text=True, check=False,
            )  # fmt: skip
        except OSError as problem:
            return str(problem)
        if done.returncode != 0:
            lines = [line for line in done.stderr.splitlines() if "error" in line]
            return (lines or done.stderr.splitlines() or ["the compiler failed"])[0]
    return ctypes.CDLL(str(made))
