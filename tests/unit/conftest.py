"""Small hand-written C models, compiled with the runtime and driven through its C interface."""

from __future__ import annotations

import ctypes
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_size_t, c_void_p
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import bgc
import bgc.runtime
from bgc.building.build import runtime_sources
from bgc.runtime.model import Model
from bgc.runtime.running.structures import CountsStruct, OptionsStruct, Status

RUNTIME = Path(bgc.runtime.__file__).parent / "c"
MODELS = Path(__file__).parent / "cmodels"
WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Wdouble-promotion", "-Werror")
FLAGS = ("-std=c11", "-O2", "-fPIC", "-ffp-contract=off")

Floats = npt.NDArray[np.float64]


class Instance:
    """One instance of a compiled model."""

    def __init__(self, library: ctypes.CDLL, outputs: int, states: int, inputs: int) -> None:
        self.library = library
        self.outputs, self.states, self.inputs = outputs, states, inputs
        self.model = c_void_p(library.bgc_get_model())
        self.data = c_void_p(library.bgc_new(self.model))
        self.accounts = False
        assert self.data.value is not None

    def __del__(self) -> None:
        self.library.bgc_free(self.model, self.data)

    def call(self, function: str, *arguments: Any) -> str:
        """Name of the status that `function(model, data, ...)` returns."""
        return Status(getattr(self.library, function)(self.model, self.data, *arguments)).name

    def set(self, **values: float) -> None:
        """Parameters by position in their names' order of the model: p0=..., p1=..."""
        for name, value in values.items():
            assert self.call("bgc_set_param", int(name[1:]), c_double(value)) == "OK"

    def reset(self, time: float = 0.0) -> str:
        return self.call("bgc_reset", c_double(time))

    def options(self, name: str | None = None, accounts: bool = False, **values: float) -> str:
        self.accounts = accounts
        encoded = None if name is None else name.encode()
        return self.call(
            "bgc_set_options", byref(OptionsStruct(encoded, accounts=accounts, **values))
        )

    def start(self, name: str | None = None, accounts: bool = False, **values: float) -> None:
        """Reset at time 0, with options."""
        assert self.options(name, accounts, **values) == "OK"
        assert self.reset() == "OK"

    def run(self, times: Sequence[float] | Floats) -> tuple[str, Floats]:
        """Status, and the rows that were finished; rows not written are NaN."""
        width = self.outputs + 4 * self.accounts
        grid = np.ascontiguousarray(times, dtype=float)
        rows = np.full((len(grid), width), np.nan)
        done = c_size_t(0)
        status = self.call(
            "bgc_run",
            grid.ctypes.data_as(POINTER(c_double)),
            c_size_t(len(grid)),
            rows.ctypes.data_as(POINTER(c_double)),
            byref(done),
        )
        return status, rows[: done.value]

    def finish(self, times: Sequence[float] | Floats) -> Floats:
        """All rows of a run that must succeed."""
        status, rows = self.run(times)
        assert status == "OK"
        return rows

    def save(self) -> ctypes.Array[ctypes.c_char]:
        memory = ctypes.create_string_buffer(self.library.bgc_save_size(self.model))
        assert self.call("bgc_save", memory) == "OK"
        return memory

    def restore(self, memory: ctypes.Array[ctypes.c_char]) -> str:
        return self.call("bgc_restore", memory)

    def energy(self) -> Floats:
        account = np.full(4, np.nan)
        assert self.call("bgc_energy", account.ctypes.data_as(POINTER(c_double))) == "OK"
        return account

    def open_device(self, options: str | None = None, driver: Any = None) -> tuple[str, str]:
        """Status and message of opening device 0."""
        message = ctypes.create_string_buffer(300)
        encoded = None if options is None else options.encode()
        status = self.call("bgc_open_device", 0, driver, encoded, message, c_size_t(300))
        return status, message.value.decode()

    @property
    def time(self) -> float:
        return float(self.library.bgc_time(self.data))

    @property
    def state(self) -> Floats:
        return np.ctypeslib.as_array(self.library.bgc_state(self.data), (self.states,))

    @property
    def input(self) -> Floats:
        return np.ctypeslib.as_array(self.library.bgc_input(self.data), (self.inputs,))

    @property
    def counts(self) -> CountsStruct:
        counts: CountsStruct = self.library.bgc_get_counts(self.data).contents
        return counts


def declare(library: ctypes.CDLL) -> None:
    """Result types of the interface's functions that return no status."""
    library.bgc_get_model.restype = c_void_p
    library.bgc_new.restype = c_void_p
    library.bgc_free.restype = None
    library.bgc_get_param.restype = c_double
    library.bgc_status_text.restype = c_char_p
    library.bgc_time.restype = c_double
    library.bgc_state.restype = POINTER(c_double)
    library.bgc_input.restype = POINTER(c_double)
    library.bgc_save_size.restype = c_size_t
    library.bgc_get_counts.restype = POINTER(CountsStruct)
    library.bgc_close_devices.restype = None
    library.bgc_stop.restype = None


def run_compiler(*arguments: str | Path, warnings: bool = False) -> None:
    """Run the C compiler; BGC_TEST_CFLAGS adds flags, such as those of the sanitizers."""
    system = shutil.which("cc")
    cc = [system] if system is not None else [sys.executable, "-m", "ziglang", "cc"]
    flags = [*FLAGS, *shlex.split(os.environ.get("BGC_TEST_CFLAGS", ""))]
    flags += WARNINGS if warnings else ()
    done = subprocess.run([*cc, *flags, *arguments], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


@pytest.fixture(scope="session")
def compile_c() -> Callable[..., None]:
    """Runs the C compiler on its arguments."""
    return run_compiler


@pytest.fixture(scope="session")
def runtime_c() -> Path:
    """The folder of the C runtime."""
    return RUNTIME


@pytest.fixture(scope="session")
def runtime_objects(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """The C runtime, compiled once for all workers, with warnings as errors."""
    worker = os.environ.get("PYTEST_XDIST_WORKER", "")
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if worker else base) / "runtime"
    folder.mkdir(exist_ok=True)
    sources = list(runtime_sources(RUNTIME).values())
    # Two workers that begin at the same time start at both ends, and meet.
    for source in reversed(sources) if worker.endswith(("1", "3")) else sources:
        target = folder / f"{source.stem}.o"
        if not target.exists():
            own = folder / f"{source.stem}.{worker}.tmp"
            run_compiler(f"-I{RUNTIME}", "-c", source, "-o", own, warnings=True)
            own.replace(target)
    return [folder / f"{source.stem}.o" for source in sources]


@pytest.fixture(scope="session")
def c_library(
    runtime_objects: list[Path], tmp_path_factory: pytest.TempPathFactory
) -> Callable[[str], ctypes.CDLL]:
    """The shared library of a model in `cmodels/`, by name; each is built once."""
    folder = tmp_path_factory.mktemp("models")
    built: dict[str, ctypes.CDLL] = {}

    def build(name: str) -> ctypes.CDLL:
        if name not in built:
            target = folder / f"{name}.so"
            source = MODELS / f"{name}.c"
            run_compiler(f"-I{RUNTIME}", "-shared", source, *runtime_objects, "-o", target, "-lm")
            built[name] = ctypes.CDLL(str(target))
        return built[name]

    return build


@pytest.fixture(scope="session")
def c_model(c_library: Callable[[str], ctypes.CDLL]) -> Callable[..., Instance]:
    """A new instance of a model in `cmodels/`, by name, or of the model in another library."""

    class Sizes(ctypes.Structure):
        _fields_ = (
            ("abi", ctypes.c_uint32),
            ("name", c_char_p),
            ("hash", c_char_p),
            ("n_param", c_int),
            ("n_hoist", c_int),
            ("n_state", c_int),
            ("n_input", c_int),
            ("n_output", c_int),
        )

    def make(name: str, library: ctypes.CDLL | None = None) -> Instance:
        if library is None:
            library = c_library(name)
        declare(library)
        sizes = Sizes.from_address(library.bgc_get_model())
        return Instance(library, sizes.n_output, sizes.n_state, sizes.n_input)

    return make


@pytest.fixture
def measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A cache of the test's own for what trades measure; compiled code is shared."""
    folder = tmp_path / "measured"
    monkeypatch.setattr("bgc.runtime.running.recommendation.FOLDER", str(folder))
    return folder


@pytest.fixture(scope="module")
def oscillator_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    from ensembles import OSCILLATOR  # needs what runs ensembles, which most tests do not

    path = tmp_path_factory.mktemp("model") / "oscillator.bg"
    path.write_text(OSCILLATOR)
    return path


@pytest.fixture(scope="module")
def oscillator(oscillator_file: Path) -> Model:
    return bgc.compile(oscillator_file)


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    """Chromium, and the page bundled from the sources of the tree."""
    from chromium import launched  # needs Playwright, which most tests do not

    yield from launched()
