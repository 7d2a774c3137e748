import subprocess
import sys
from pathlib import Path

import pytest
from refusals import code_of, refusal

from bgc.building import toolchain
from bgc.building.toolchain import (
    ZIGLANG,
    Compilations,
    Toolchain,
    find_toolchain,
    try_compiler,
)
from bgc.diagnostics.diagnostic import BgError


@pytest.fixture
def bare_machine(monkeypatch, tmp_path):
    """No compiler on the path, none in `CC`, no ziglang."""
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setattr(toolchain, "find_spec", lambda name: None)
    return tmp_path


def install(folder: Path, name: str, says: str) -> None:
    script = folder / name
    script.write_text(f"#!/bin/sh\necho '{says}'\n")
    script.chmod(0o755)


def test_no_compiler_says_what_to_install(bare_machine):
    with pytest.raises(BgError) as error:
        find_toolchain()
    assert code_of(error) == "BG050"
    assert "ziglang" in error.value.diagnostics[0].help


def test_cc_variable_comes_first(bare_machine, monkeypatch):
    install(bare_machine, "cc", "cc 1")
    install(bare_machine, "mine", "clang version 99")
    monkeypatch.setenv("CC", "mine -m64")
    found = find_toolchain()
    assert found == Toolchain(("mine", "-m64"), "clang", "clang version 99")


def test_cc_variable_is_never_silently_replaced(bare_machine, monkeypatch):
    install(bare_machine, "cc", "cc 1")
    monkeypatch.setenv("CC", "gcc-99")
    assert refusal(find_toolchain).code == "BG051"


def test_gcc_is_known_by_its_licence(bare_machine):
    install(bare_machine, "gcc", "gcc 12.2.0\nCopyright (C) Free Software Foundation, Inc.")
    found = find_toolchain()
    assert (found.kind, found.version) == ("gcc", "gcc 12.2.0")


def test_the_ziglang_wheel_serves_where_nothing_else_is(bare_machine, monkeypatch):
    monkeypatch.setattr(toolchain, "find_spec", lambda name: name)
    monkeypatch.setattr(toolchain, "identify", lambda command: Toolchain(command, "zig", ""))
    assert find_toolchain().command == ZIGLANG


def test_a_working_compiler_has_nothing_to_complain_about():
    assert try_compiler(find_toolchain()) == ""


def test_a_broken_compiler_is_heard(bare_machine):
    script = bare_machine / "cc"
    script.write_text("#!/bin/sh\necho 'stdint.h: no such file'\nexit 1\n")
    script.chmod(0o755)
    assert "stdint.h" in try_compiler(Toolchain((str(script),), "cc", ""))


def test_a_compiler_named_by_a_relative_path_is_found_from_other_directories(
    bare_machine, monkeypatch
):
    install(bare_machine, "mine", "gcc 1 Free Software Foundation")
    monkeypatch.chdir(bare_machine)
    monkeypatch.setenv("CC", "./mine -m64")
    found = find_toolchain()
    assert found.command == (str(bare_machine / "mine"), "-m64")
    assert found.kind == "gcc"


@pytest.mark.parametrize("started_first", [True, False])
def test_ending_compilations_ends_those_that_start_meanwhile_too(started_first):
    compilations = Compilations()
    if not started_first:
        compilations.end()
    with subprocess.Popen(
        [sys.executable, "-c", "import time; time.sleep(60)"], text=True
    ) as process:
        compilations.add(process)
        if started_first:
            compilations.end()
        assert process.wait(timeout=20) != 0
