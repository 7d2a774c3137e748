"""The C that `bgc build --target c` writes compiles for five systems, with the compiler of zig."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from bgc.building.build import runtime_directory
from bgc.building.toolchain import ZIGLANG
from bgc.driver import compile_scene
from bgc.emission.emit import amalgamate
from bgc.options import Options

TARGETS = (
    "x86_64-linux-gnu",
    "aarch64-linux-gnu",
    "x86_64-macos",
    "aarch64-macos",
    "x86_64-windows-gnu",
)
MODEL = """
model M {
  input v : m/s = 0 m/s;
  push : Sf(f = v);
  motion : J1;
  drag : R { e = max(0 N, 2 N*s/m * f); }
  mass : C(1);
  push -> motion -> drag, mass;
  unknown z = 1;
  equation z^3 + z = 2 + time;
}
scene s of M {
  device hand = trace(file = "motion.csv");
  drive v = hand.velocity[1];
  observe drag.e, z, energy.residual;
  run 1 s;
}
"""


@pytest.fixture(scope="module")
def written(tmp_path_factory) -> Path:
    """A model with a device, events and an algebraic equation, with the whole runtime."""
    folder = tmp_path_factory.mktemp("targets")
    (folder / "m.bg").write_text(MODEL)
    emitted = compile_scene(folder / "m.bg", Options(), until="emit").emitted
    (folder / "m.c").write_text(amalgamate(emitted, runtime_directory()))
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("target", TARGETS)
def test_the_c_file_builds_for_other_systems(written, target):
    pytest.importorskip("ziglang")
    command = [*ZIGLANG, "-target", target, "-std=c11", "-O0", "-c", "m.c", "-o", f"{target}.o"]
    strict = ("-Wall", "-Wextra", "-Werror=implicit-function-declaration")
    done = subprocess.run(
        [*command, *strict], cwd=written, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert (written / f"{target}.o").stat().st_size > 1000
