"""Options of the whole test suite, and the check of every intermediate result in it."""

import os
import signal
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

PHYSICS = Path(__file__).parent / "physics"

os.environ["BGC_VERIFY"] = "1"  # commands in processes of their own inherit it
# Threads of BLAS wait for each other where tests run in parallel; matrices are small here.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

if os.environ.pop("PYTHONDONTWRITEBYTECODE", None):
    # Each of the hundreds of commands would compile every module anew, half of a short command's
    # time. The bytecode goes to a folder of pytest, beside the caches of its plugins.
    os.environ["PYTHONPYCACHEPREFIX"] = str(PHYSICS.parents[1] / ".pytest_cache" / "bytecode")
    sys.dont_write_bytecode = False
    sys.pycache_prefix = os.environ["PYTHONPYCACHEPREFIX"]


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--bless", action="store_true", help="rewrite the golden files")


def pytest_configure(config: pytest.Config) -> None:
    """Let pytest-xdist take the files in the order of the tests, not by how many they hold."""
    config.option.loadscopereorder = False


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the physics as slow, and as golden all that compares with blessed files.

    Files with slow tests come first, so that no worker is left with a long one at the end.
    """
    for item in items:
        if PHYSICS in item.path.parents:
            item.add_marker(pytest.mark.slow)
        if "bless" in getattr(item, "fixturenames", ()):
            item.add_marker(pytest.mark.golden)
    slow = {item.path for item in items if item.get_closest_marker("slow")}
    items.sort(key=lambda item: item.path not in slow)


@pytest.fixture
def terminal_signals() -> Iterator[None]:
    """Handle signals as at a terminal: children of `nohup` and of background shells ignore some."""
    handlers = {signal.SIGINT: signal.default_int_handler, signal.SIGTERM: signal.SIG_DFL}
    if hasattr(signal, "SIGHUP"):
        handlers[signal.SIGHUP] = signal.SIG_DFL
    before = {number: signal.signal(number, handler) for number, handler in handlers.items()}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


@pytest.fixture
def bless(request: pytest.FixtureRequest) -> bool:
    return bool(request.config.getoption("--bless"))
