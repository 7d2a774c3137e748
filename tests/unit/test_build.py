import errno
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from own_caches import with_runtime

from bgc.building.build import (
    EVERY_PART,
    Unit,
    build_shared_object,
    lane_runtime_units,
    needed_sources,
    runtime_directory,
    runtime_sources,
    runtime_units,
    tangent_runtime_units,
    unit_flags,
)
from bgc.building.cache import Cache
from bgc.building.toolchain import (
    GCC_PASSES,
    RUNTIME_FLAGS,
    ZIGLANG,
    Toolchain,
    find_toolchain,
    try_compiler,
)
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.running.binding import Instance, Library
from bgc.runtime.running.structures import Status

pytestmark = pytest.mark.slow

OSCILLATOR = Path(__file__).with_name("oscillator.c").read_text()
# Without parts of the runtime that the oscillator does not need: half of its compilation.
UNITS = (Unit("model", OSCILLATOR, parts=frozenset()),)


@pytest.fixture(scope="module")
def toolchain() -> Toolchain:
    return find_toolchain()


@pytest.fixture(scope="module")
def filled(tmp_path_factory, toolchain) -> Path:
    """A cache that holds the compiled runtime, so that the tests compile little."""
    root = with_runtime(tmp_path_factory.mktemp("filled"))
    build_shared_object(UNITS, toolchain, Cache(root))
    return root


@pytest.fixture
def cache(filled, tmp_path) -> Cache:
    shutil.copytree(filled, tmp_path / "cache")
    return Cache(tmp_path / "cache")


class Counting(Toolchain):
    """A compiler that remembers what it was asked."""

    calls: list[tuple[str, ...]]

    def __init__(self, toolchain: Toolchain) -> None:
        super().__init__(toolchain.command, toolchain.kind, toolchain.version)
        object.__setattr__(self, "calls", [])

    def run(self, arguments, *rest):
        self.calls.append(arguments)
        return super().run(arguments, *rest)

    def compiled(self) -> list[str]:
        return [a for call in self.calls for a in call if a.endswith(".c")]


def test_what_is_built_can_be_loaded(cache, toolchain):
    path = build_shared_object(UNITS, toolchain, cache)
    assert Library(path).model.name == b"oscillator"


def test_a_second_build_runs_no_compiler(cache, toolchain):
    counting = Counting(toolchain)
    build_shared_object(UNITS, counting, cache)
    assert counting.calls == []


def test_only_the_changed_unit_is_compiled(cache, toolchain):
    counting = Counting(toolchain)
    changed = replace(UNITS[0], text=OSCILLATOR + "\n/* changed */\n")
    build_shared_object((changed,), counting, cache)
    assert counting.compiled() == ["model.c"]


def test_parts_that_a_model_has_no_use_for_change_no_bit(cache, toolchain):
    whole = tuple(replace(unit, parts=EVERY_PART) for unit in UNITS)
    runs = []
    for units in (UNITS, whole):
        library = Library(build_shared_object(units, toolchain, cache))
        made = Instance(library)
        assert made.reset() is Status.OK
        rows = np.empty((50, library.model.n_output))
        status, done = made.run(np.linspace(0.0, 5.0, 50), rows)
        assert status is Status.OK and done == 50
        assert made.open_device(0, 0, "")[1] == "the model has no device 0"
        runs.append((rows.tobytes(), made.state.tobytes()))
    assert runs[0] == runs[1]


def test_the_runtime_has_what_any_of_the_units_needs():
    texts = {
        parts: "".join(unit.text for unit in runtime_units(parts))
        for parts in (EVERY_PART, frozenset(("events",)), frozenset[str]())
    }
    assert [text.count("locate_first(") > 0 for text in texts.values()] == [True, True, False]
    assert ["trace_read" in text for text in texts.values()] == [True, False, False]


@pytest.mark.parametrize("kind", ["objects", "models"])
def test_damaged_entries_are_rebuilt(cache, toolchain, kind):
    whole = build_shared_object(UNITS, toolchain, cache)
    for path in (cache.root / kind).iterdir():
        if path.suffix in (".o", ".so"):
            path.write_bytes(b"damaged")
    if kind == "objects":
        whole.unlink()
    assert Library(build_shared_object(UNITS, toolchain, cache)).model.n_state == 2


def test_two_builds_at_once_make_one_whole_library(tmp_path, toolchain):
    def build_it(_: int) -> Path:
        return build_shared_object(UNITS, toolchain, Cache(tmp_path / "cache"))

    with_runtime(tmp_path / "cache")
    with ThreadPoolExecutor(2) as pool:
        first, second = pool.map(build_it, range(2))
    assert first == second
    assert Library(first).model.n_state == 2
    assert not list((tmp_path / "cache").glob("making-*"))


def test_rejected_code_is_kept_with_the_compilers_words(cache, toolchain):
    with pytest.raises(BgError) as error:
        broken = Unit("model", "int f(void) { return x; }\n", parts=frozenset())
        build_shared_object((broken,), toolchain, cache)
    (diagnostic,) = error.value.diagnostics
    assert diagnostic.code == "BG053"
    assert "undeclared" in diagnostic.note
    (kept,) = (cache.root / "failed").iterdir()
    assert str(kept) in diagnostic.help
    assert (kept / "model.c").is_file()
    assert "undeclared" in (kept / "output.txt").read_text()


def test_a_compiler_that_does_not_work_is_told_from_bad_code(cache, tmp_path):
    script = tmp_path / "cc"
    script.write_text("#!/bin/sh\necho 'math.h: No such file or directory' >&2\nexit 1\n")
    script.chmod(0o755)
    with pytest.raises(BgError) as error:
        build_shared_object(UNITS, Toolchain((str(script),), "cc", "1"), cache)
    (diagnostic,) = error.value.diagnostics
    assert diagnostic.code == "BG052"
    assert "math.h" in diagnostic.note


def test_temporary_files_of_a_compiler_vanish_with_its_folder(tmp_path):
    """A compiler that is killed leaves its `.s` and `.o` files there: megabytes of a model."""
    done = Toolchain(("sh", "-c", 'mktemp "$TMPDIR/cc.XXXXXX"'), "cc", "").run((), tmp_path)
    assert Path(done.stdout.strip()).parent == tmp_path


def test_a_folder_for_temporary_files_that_is_not_there_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "gone"))
    with pytest.raises(BgError, match=r"BG642: cannot write temporary files in .*gone"):
        try_compiler(find_toolchain())


def test_a_full_disk_is_named_as_such(cache, tmp_path):
    script = tmp_path / "cc"
    script.write_text("#!/bin/sh\necho 'cannot write x.o: No space left on device'\nexit 1\n")
    script.chmod(0o755)
    with pytest.raises(BgError) as error:
        build_shared_object(UNITS, Toolchain((str(script),), "cc", "1"), cache)
    assert error.value.diagnostics[0].code == "BG055"


def test_a_full_disk_under_the_cache_moves_the_build_elsewhere(tmp_path):
    script = tmp_path / "cc"
    script.write_text(
        "#!/bin/sh\n"
        'case "$PWD" in */small/*) echo "x.o: No space left on device"; exit 1;; esac\n'
        'while [ "$1" != -o ]; do shift; done; : > "$2"\n'
    )
    script.chmod(0o755)
    (tmp_path / "small").mkdir()
    cache = Cache(tmp_path / "small")
    path = build_shared_object(UNITS, Toolchain((str(script),), "cc", "1"), cache)
    assert path.is_file() and path.is_relative_to(cache.root)
    assert cache.root != tmp_path / "small"
    (warning,) = cache.warnings
    assert warning.code == "BG054"
    assert str(tmp_path / "small") in warning.message and "No space left" in warning.message


def test_an_exceeded_quota_under_the_cache_moves_the_build_elsewhere(tmp_path, monkeypatch):
    script = tmp_path / "cc"
    script.write_text('#!/bin/sh\nwhile [ "$1" != -o ]; do shift; done; : > "$2"\n')
    script.chmod(0o755)
    (tmp_path / "small").mkdir()
    cache = Cache(tmp_path / "small")
    publish = Cache.publish

    def refuse(self: Cache, kind: str, name: str, made: Path) -> Path:
        if self.root == tmp_path / "small":
            raise OSError(errno.EDQUOT, "Disk quota exceeded")
        return publish(self, kind, name, made)

    monkeypatch.setattr(Cache, "publish", refuse)
    assert build_shared_object(UNITS, Toolchain((str(script),), "cc", "1"), cache).is_file()
    assert [warning.code for warning in cache.warnings] == ["BG054"]


def test_a_cache_that_vanishes_is_a_diagnostic(tmp_path, toolchain):
    with pytest.raises(BgError) as error:
        build_shared_object(UNITS, toolchain, Cache(tmp_path / "missing"))
    assert error.value.diagnostics[0].code == "BG055"


def test_only_gcc_is_given_gccs_own_flags():
    unit = Unit("model", "", ("-O1", "-fexpensive-optimizations", "-fno-dse"))
    assert unit_flags(unit, Toolchain(("gcc",), "gcc", "")) == unit.flags
    assert unit_flags(unit, Toolchain(("clang",), "clang", "")) == ("-O1",)


def test_a_gcc_without_some_passes_compiles_with_all(cache, toolchain, tmp_path):
    if toolchain.kind != "gcc":
        pytest.skip("flags of gcc")
    script = tmp_path / "gcc"
    refuse = (
        """case "$*" in *-fdisable-rtl-combine*) echo 'cc1: error: unknown pass'; exit 1;; esac"""
    )
    script.write_text(f'#!/bin/sh\n{refuse}\nexec {toolchain.name} "$@"\n')
    script.chmod(0o755)
    units = (replace(UNITS[0], flags=(*GCC_PASSES, *RUNTIME_FLAGS)),)
    path = build_shared_object(units, Toolchain((str(script),), "gcc", "1"), cache)
    assert Library(path).model.name == b"oscillator"


def test_the_runtime_is_clean_under_strict_warnings(toolchain, tmp_path):
    warnings = ("-Wall", "-Wextra", "-Wconversion", "-Wpedantic", "-Wdouble-promotion", "-Werror")
    folder = runtime_directory()
    sources = sorted((*runtime_sources(folder).values(), *folder.glob("absent/*.c")))
    for unit in (*lane_runtime_units(), *tangent_runtime_units()):
        sources.append(tmp_path / f"{unit.name}.c")
        sources[-1].write_text(unit.text)
    for source in sources:
        arguments = (*RUNTIME_FLAGS, *warnings, f"-I{folder}", "-fsyntax-only", str(source))
        done = toolchain.run(arguments, tmp_path)
        assert done.returncode == 0, done.stdout


@pytest.mark.skipif(sys.platform != "linux", reason="the wheel is tried on Linux only")
def test_zig_builds_a_model(tmp_path):
    pytest.importorskip("ziglang")
    toolchain = Toolchain(ZIGLANG, "zig", "")
    (tmp_path / "cache").mkdir()
    path = build_shared_object(UNITS, toolchain, Cache(tmp_path / "cache"))
    loaded = subprocess.run(
        [sys.executable, "-c", f"import ctypes; ctypes.CDLL({str(path)!r})"], check=False
    )
    assert loaded.returncode == 0


def test_a_model_with_other_parts_takes_the_rest_of_the_runtime_from_the_cache(cache, toolchain):
    counting = Counting(toolchain)
    with_events = (replace(UNITS[0], parts=frozenset(("events",))),)
    path = build_shared_object(with_events, counting, cache)
    assert set(counting.compiled()) <= {"runtime_events.c", "runtime_absent.c"}
    assert Library(path).model.name == b"oscillator"


def test_parts_and_stubs_make_up_every_source_of_the_runtime_once():
    folder = runtime_directory()
    for parts in (EVERY_PART, frozenset(("blocks", "devices")), frozenset[str]()):
        joined = "".join(unit.text for unit in runtime_units(parts))
        for path in needed_sources(folder, parts).values():
            assert joined.count(path.read_text(encoding="utf-8")) == 1
        assert joined.count("#line 1 ") == len(needed_sources(folder, parts))
