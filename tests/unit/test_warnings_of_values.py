"""Methods that return bare numbers warn as Python does, of what a result would warn of."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import pytest
from click.testing import CliRunner
from model_files import model_text

import bgc
from bgc.runtime.cli.app import application
from bgc.runtime.model import Model

# A pole of the spring at q = 1, behind which a step of 0.1 s ends, and a state that falls below its
# tolerance and grows by an instability of its own.
SCENES = model_text("warnings_of_values")


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("model") / "values.bg"
    path.write_text(SCENES)
    return path


@pytest.fixture(scope="module")
def wall(path: Path) -> Model:
    return bgc.compile(path, scene="wall")


@pytest.mark.parametrize(
    "name", ["initial_state", "rhs", "jacobian", "observe", "eigenvalues", "modes"]
)
def test_a_negative_parameter_is_warned_of_at_the_callers_line(wall: Model, name: str) -> None:
    method: Callable[..., object] = getattr(wall, name)
    with pytest.warns(bgc.BgWarning) as caught:
        method(parameters={"loss": -1.0})
    (warning,) = caught
    assert isinstance(warning.message, bgc.BgWarning)
    assert warning.message.diagnostic.code == "BG460"
    assert "`loss`" in str(warning.message)
    assert Path(warning.filename) == Path(__file__)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        method()


def test_the_state_at_a_time_warns_of_its_run(wall: Model) -> None:
    with pytest.warns(bgc.BgWarning, match="BG719") as caught:
        wall.state_at(1.5)
    assert len(caught) == 1
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        wall.state_at(0.5)


def test_a_state_that_rounding_decides_is_warned_of(path: Path) -> None:
    """The same warning as of a result, whose cure is a tolerance that was tried."""
    model = bgc.compile(path, scene="pitchfork")
    with pytest.warns(bgc.BgWarning, match="BG726") as caught:
        model.state_at(2.5)
    (expected,) = model.simulate().warnings
    (warning,) = caught
    assert isinstance(warning.message, bgc.BgWarning)
    assert warning.message.diagnostic.help == expected.help


def test_a_linear_form_at_a_time_warns_of_the_run_to_it(wall: Model, path: Path) -> None:
    linear = wall.linearise(at=1.5)
    assert [warning.code for warning in linear.warnings] == ["BG719"]
    assert not wall.linearise(at=0.5).warnings
    command = ["modes", str(path), "--scene", "wall", "--at"]
    told, quiet = (CliRunner().invoke(application, [*command, at]) for at in ("1.5", "0.5"))
    assert (told.exit_code, quiet.exit_code) == (0, 0)
    assert "warning[BG719]" in told.stderr and not quiet.stderr
