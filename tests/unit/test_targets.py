"""The C of `bgc build --target c`: five systems, and two models in one program."""

from __future__ import annotations

import math
import subprocess
from pathlib import Path

import pytest
from click.testing import CliRunner
from model_files import model_text

from bgc.building.build import runtime_directory
from bgc.building.toolchain import ZIGLANG, find_toolchain
from bgc.driver import compile_scene
from bgc.emission.emit import amalgamate
from bgc.emission.prefix import prefix_problem
from bgc.options import Options
from bgc.runtime.cli.app import application

TARGETS = (
    "x86_64-linux-gnu",
    "aarch64-linux-gnu",
    "x86_64-macos",
    "aarch64-macos",
    "x86_64-windows-gnu",
)
MODEL = model_text("targets")


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


PROGRAM = Path(__file__).parent / "cprograms" / "two_models.c"


def build(*arguments: object):
    return CliRunner().invoke(application, ["build", *map(str, arguments)])


def test_two_models_link_into_one_program(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, rate, prefix in (("first", 1, "left"), ("second", 2, "right_hand")):
        Path(f"{name}.bg").write_text(
            f"model M {{ param bgc_rate = {rate}; state x = 1; der(x) = -bgc_rate*x; }}"
            "scene s of M { observe x; run 1 s; }"
        )
        done = build(f"{name}.bg", "--target", "c", "--prefix", prefix)
        assert (done.exit_code, done.stdout) == (0, f"{name}.c\n"), done.output
    compiler = find_toolchain().command
    strict = ("-std=c11", "-Wall", "-Wextra", "-Wpedantic", "-Werror", "-O0")
    subprocess.run(
        [*compiler, *strict, "-I.", PROGRAM, "first.c", "second.c", "-o", "both", "-lm"], check=True
    )
    done = subprocess.run(["./both"], capture_output=True, text=True, check=True)
    found = [line.split() for line in done.stdout.splitlines()]
    assert [name for name, _ in found] == ["bgc_rate", "bgc_rate"]
    assert [float(x) for _, x in found] == pytest.approx([math.exp(-1), math.exp(-2)], rel=1e-3)


def test_without_a_prefix_the_header_is_that_of_the_runtime(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("m.bg").write_text(MODEL)
    assert build("m.bg", "--target", "c", "-o", "out").exit_code == 0
    header = (runtime_directory() / "bgc.h").read_text()
    device = (runtime_directory() / "bgc_device.h").read_text()
    assert Path("out/m.h").read_text() == header.replace('#include "bgc_device.h"\n', device)
    assert build("m.bg", "--target", "c", "-o", "-", "--prefix", "x").stdout.count("bgc_") == 0


@pytest.mark.parametrize("prefix", ["1a", "a-b", "a__b", "", "_a", "a_", "model"])
def test_a_prefix_that_cannot_serve_is_refused(tmp_path, prefix):
    path = tmp_path / "m.bg"
    path.write_text(MODEL)
    done = build(path, "--target", "c", "--prefix", prefix, "-o", tmp_path)
    assert (done.exit_code, "--prefix" in done.stderr) == (2, True), done.output
    assert build(path, "--prefix", "a").exit_code == 2


def test_only_a_name_that_two_would_have_stands_against_a_prefix():
    text = "int bgc_new; int left_hand; int model_new; /* bgc_hand */"
    assert prefix_problem("right", text) == ""
    assert prefix_problem("model", text) == "the C file has a name `model_new` already"
    assert "left_hand" in prefix_problem("left", text)
    assert prefix_problem("left", text.replace("bgc_hand", "")) == ""


ROWS = """
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "used.h"
int main(void) {
    enum { n = 3, room = 100 };
    const double times[n] = {0.1, 0.2, 0.3};
    for (int accounts = 0; accounts < 2; accounts++) {
        double rows[room];
        size_t done = 0;
        bgc_options options;
        for (int k = 0; k < room; k++) rows[k] = NAN;
        memset(&options, 0, sizeof options);
        options.accounts = accounts;
EXAMPLE
        int width = 0;
        while (!isnan(rows[n * width])) width++;
        printf("%d %d %d\\n", (int)done, m->n_output, width);
    }
    return 0;
}
"""


def test_the_example_at_the_top_of_the_c_file_runs(tmp_path, monkeypatch):
    """C7: it said that each row holds four energies, which `accounts` alone adds."""
    monkeypatch.chdir(tmp_path)
    Path("used.bg").write_text(
        "model M { j : J1; m : I(2, f0 = 1); r : R(1); j -> m, r; }"
        "scene s of M { observe m.f, r.e; run 1 s; }"
    )
    assert build("used.bg", "--target", "c").exit_code == 0
    comment = Path("used.c").read_text().partition("*/")[0]
    lines = [line.partition("   a row: ")[0][7:] for line in comment.splitlines()]
    example = [line for line in lines if line.rstrip().endswith(";")]
    assert len(example) == 5
    example.insert(2, "if (accounts) bgc_set_options(m, d, &options);")
    Path("rows.c").write_text(ROWS.replace("EXAMPLE", "\n".join(example)))
    compiler = find_toolchain().command
    subprocess.run(
        [*compiler, "-std=c11", "used.c", "rows.c", "-o", "rows", "-lm", "-lpthread"], check=True
    )
    done = subprocess.run(["./rows"], capture_output=True, text=True, check=True)
    without, with_accounts = ([int(x) for x in line.split()] for line in done.stdout.splitlines())
    assert without == [3, 2, 2]
    assert with_accounts == [3, 2, 6]
    assert "four energies behind" in comment and "asked for `accounts`" in comment
