"""`bgc new`: each template is a model that runs, and its numbers are right."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from own_caches import with_runtime

import bgc
from bgc.runtime.cli.app import application
from bgc.runtime.cli.new import TEMPLATES


def run(*arguments: object) -> Result:
    return CliRunner().invoke(application, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def cache(tmp_path_factory) -> Path:
    return with_runtime(tmp_path_factory.mktemp("cache"))


@pytest.fixture
def folder(tmp_path, cache, monkeypatch) -> Path:
    monkeypatch.setenv("BGC_CACHE_DIR", str(cache))
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("template", TEMPLATES)
def test_every_template_is_canonical_and_without_a_warning(folder, template):
    result = run("new", "my_model", "--template", template)
    assert result.exit_code == 0
    assert TEMPLATES[template] in result.stdout
    assert "bgc run my_model.bg --plot my_model.png" in result.stdout
    assert run("fmt", "--check", "my_model.bg").exit_code == 0
    assert run("check", "--strict", "my_model.bg").exit_code == 0
    assert "model MyModel {" in Path("my_model.bg").read_text()
    assert "scene my_model of MyModel {" in Path("my_model.bg").read_text()


def test_what_is_printed_to_do_next_can_be_done(folder):
    for line in run("new", "first").stdout.split("next:\n")[1].splitlines():
        command = line.strip().split("  ")[0]
        assert run(*command.split()[1:]).exit_code == 0, command
    assert Path("first.png").is_file()


def test_the_plain_model_is_a_damped_oscillator(folder):
    run("new", "plain")
    result = bgc.compile("plain.bg").simulate(rtol=1e-9)
    mass, stiffness, damping, force = 2.0, 200.0, 4.0, 10.0
    decay = damping / (2 * mass)
    omega = np.sqrt(stiffness / mass - decay**2)
    t = result.time
    swing = np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
    assert result["position"] == pytest.approx(force / stiffness * (1 - swing), abs=1e-9)


def test_the_motor_reaches_the_speed_of_its_equations(folder):
    run("new", "motor", "--template", "mechanism")
    result = bgc.compile("motor.bg").simulate(rtol=1e-9)
    voltage, winding, k, gear, friction = 24.0, 0.5, 0.05, 20.0, 0.1
    speed = voltage / (k * gear + winding * friction / (k * gear))
    last_on = int(np.searchsorted(result.time, 1.0)) - 1
    assert result["speed"][last_on] == pytest.approx(speed, rel=1e-6)
    current = friction * speed / (k * gear)
    assert result["current"][last_on] == pytest.approx(current, rel=1e-6)


def test_the_crane_turns_as_far_as_its_drives_turn_it(folder):
    run("new", "crane", "--template", "crane")
    result = bgc.compile("crane.bg").simulate(rtol=1e-8)
    slewed, luffed = result["slew_angle"][-1], result["luff_angle"][-1]
    assert slewed == pytest.approx(0.5 * 0.1 * 6, abs=0.01)
    assert luffed == pytest.approx(np.radians(30) + 0.05 * 4, abs=0.1)
    tip = [result[f"tip[{k}]"][-1] for k in (1, 2, 3)]
    across = 12 * np.cos(luffed)
    expected = [across * np.cos(slewed), across * np.sin(slewed), 3 + 12 * np.sin(luffed)]
    assert tip == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(("name", "model"), [("r", "RModel"), ("beam", "BeamModel"), ("a_b", "AB")])
def test_a_name_that_is_taken_is_extended(folder, name, model):
    assert run("new", name, "--template", "crane").exit_code == 0
    assert f"model {model} " in Path(f"{name}.bg").read_text()
    assert run("check", f"{name}.bg").exit_code == 0


def test_a_file_is_never_replaced(folder):
    Path("mine.bg").write_text("mine")
    result = run("new", "mine")
    assert result.exit_code == 1 and "error[BG042]" in result.stderr
    assert Path("mine.bg").read_text() == "mine"


@pytest.mark.parametrize("name", ["2dof", "a-b", "scene", "deep/", "ünter", ""])
def test_a_name_that_no_model_can_have_is_refused(folder, name):
    result = run("new", name)
    assert result.exit_code == 1 and "error[BG043]" in result.stderr
    assert list(folder.iterdir()) == []


def test_a_folder_may_be_named_and_must_exist(folder):
    (folder / "sub").mkdir()
    assert run("new", "sub/one.bg").exit_code == 0
    assert (folder / "sub" / "one.bg").is_file()
    stderr = run("new", "none/one").stderr
    assert "error[BG055]" in stderr and "there is no such directory" in stderr


def test_an_unknown_template_is_wrong_usage(folder):
    assert run("new", "x", "--template", "ship").exit_code == 2
