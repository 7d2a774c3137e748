"""Previews compile fast and compute the same."""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import bgc
from bgc.algebra.random import random
from bgc.building import preview
from bgc.building.build import Unit
from bgc.runtime.cli.app import application

MODELS = Path(__file__).parents[1] / "models"
SCENES = [("dc_motor", "start"), ("events", "ball"), ("tumbling", "quaternion")]


@pytest.fixture(params=["tcc", "-O0"])
def compiler(request, monkeypatch):
    if request.param == "tcc" and shutil.which("tcc") is None:
        pytest.skip("there is no tcc")
    if request.param == "-O0":
        monkeypatch.setattr(preview, "_quick_compiler", lambda: None)
        # Builds are remembered by what was asked for, not by what was installed then.
        monkeypatch.setattr("bgc.building.recall.recall", lambda path, options: None)
    return request.param


@pytest.mark.parametrize(("name", "scene"), SCENES)
def test_a_preview_computes_the_same(name, scene, compiler):
    path = MODELS / f"{name}.bg"
    quick = bgc.compile(path, scene=scene, preview=True).simulate()
    usual = bgc.compile(path, scene=scene).simulate()
    assert list(quick) == list(usual)
    for column in usual:
        if column.startswith("energy"):
            continue
        size = np.abs(usual[column]).max()
        np.testing.assert_allclose(quick[column], usual[column], atol=1e-5 * size)


def test_a_preview_draws_the_same_random_numbers(tmp_path, compiler):
    """tcc has no function that converts an unsigned 64-bit integer to a double."""
    path = tmp_path / "drawn.bg"
    path.write_text(
        "model Drawn { param seed = 1; output x = random(seed, 3); }\n"
        "scene once of Drawn { keep seed; observe x; run 1 s; }\n",
        "utf-8",
    )
    for seed in (1, 5, -7):
        found = bgc.compile(path, preview=True).simulate(parameters={"seed": seed})["x"]
        np.testing.assert_array_equal(found, random(seed, 3))


def test_units_name_the_compiler_they_are_for(compiler):
    (unit,) = preview.previewed([Unit("model", "double x[] = {-INFINITY};\n")])
    assert (unit.compiler is not None) == (compiler == "tcc")
    assert "-O0" in unit.flags and "-march=native" not in unit.flags


def test_a_tcc_that_does_not_work_is_not_taken(tmp_path, monkeypatch):
    broken = tmp_path / "tcc"
    broken.write_text("#!/bin/sh\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}:{Path(sys.executable).parent}:/usr/bin:/bin")
    assert preview._quick_compiler() is None


@pytest.mark.skipif(shutil.which("readelf") is None, reason="readelf shows it")
def test_no_stack_becomes_executable(compiler):
    model = bgc.compile(MODELS / "dc_motor.bg", preview=True)
    library = model.library.functions._name
    shown = subprocess.run(["readelf", "-lW", library], capture_output=True, text=True, check=True)
    (stack,) = [line for line in shown.stdout.splitlines() if "GNU_STACK" in line]
    assert "RWE" not in stack


def test_run_takes_the_option(tmp_path):
    out = tmp_path / "rows.csv"
    command = ["run", str(MODELS / "dc_motor.bg"), "--preview", "--out", str(out), "-q"]
    done = CliRunner().invoke(application, command)
    assert done.exit_code == 0, done.output
    assert len(out.read_text().splitlines()) > 10
