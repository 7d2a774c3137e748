"""Animated modes of the page against closed forms: phases, frequencies, rotations, refusals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from model_files import model_text

from bgc.diagnostics.diagnostic import BgError
from bgc.options import Options
from bgc.runtime.cli.app import application
from bgc.runtime.model import Model
from bgc.runtime.running.model_loading import load_as
from bgc.runtime.view.history import TIMES
from bgc.runtime.view.mode_shapes import record_modes
from bgc.runtime.view.recording import Recording

# Two equal masses between walls on three springs k, k and k: one of the books' examples.
PAIR = model_text("view_modes_pair")
PENDULUM = model_text("view_modes_pendulum")


def modes_of(text: str, folder: Path, at=None, **options) -> Recording:
    path = folder / "m.bg"
    path.write_text(text)
    chosen = Options(shapes=True, **options)
    return record_modes(load_as(Model, path, chosen, {}), path, chosen, at)


def column(found: Recording, shape: int, name: str, mode: int) -> np.ndarray:
    """The values of a quantity of a shape over the cycle of a mode, (rows, ..)."""
    place = found.description["shapes"][shape]["values"][name]["columns"]
    span = found.description["modes"][mode]
    time = found.rows[:, 0] + found.rows[:, 1].astype(float)
    inside = (time >= span["first"] - 1e-6) & (time <= span["last"] + 1e-6)
    return found.rows[inside][:, [TIMES + k for k in place]].astype(float)


def test_two_masses_swing_in_phase_and_opposite(tmp_path):
    found = modes_of(PAIR, tmp_path)
    first, second = found.description["modes"]
    assert first["frequency"] == pytest.approx(10 / (2 * np.pi), rel=1e-9)
    assert second["frequency"] == pytest.approx(np.sqrt(300) / (2 * np.pi), rel=1e-9)
    assert first["damping"] == 0 and found.description["still"] == 1  # springs in a loop
    for mode, sign in ((0, 1), (1, -1)):
        left, right = (column(found, k, "r", mode)[:, 0] - rest for k, rest in ((0, 1.0), (1, 2.0)))
        assert np.abs(left).max() > 0.05
        np.testing.assert_allclose(right, sign * left, atol=1e-6)
        np.testing.assert_allclose(left[0], left[-1], atol=1e-6)


def test_a_pendulum_turns_by_rotations_about_its_rest(tmp_path):
    found = modes_of(PENDULUM, tmp_path, "steady")
    (mode,) = found.description["modes"]
    omega = np.sqrt(9.81 - 0.01)
    assert mode["frequency"] == pytest.approx(omega / (2 * np.pi), rel=1e-9)
    assert mode["damping"] == pytest.approx(0.1 / np.sqrt(9.81), rel=1e-9)
    turns = column(found, 0, "A", 0).reshape(-1, 3, 3)
    np.testing.assert_allclose(turns @ turns.transpose(0, 2, 1), np.tile(np.eye(3), (49, 1, 1)),
                               atol=1e-6)  # fmt: skip
    angle = np.arctan2(turns[:, 2, 0], turns[:, 0, 0])
    assert angle.max() == pytest.approx(-angle.min(), rel=1e-2) and 0.2 < angle.max() < 0.31


def test_a_scene_without_moving_shapes_is_refused(tmp_path):
    with pytest.raises(BgError, match="BG659"):
        modes_of(PAIR, tmp_path, scene="bare")


def test_the_command_writes_a_page(tmp_path):
    (tmp_path / "m.bg").write_text(PAIR)
    out = tmp_path / "modes.html"
    file = str(tmp_path / "m.bg")
    done = CliRunner().invoke(application, ["view", file, "--modes", "--export", str(out)])
    assert done.exit_code == 0, done.output
    assert '"modes":[{"frequency":1.59' in out.read_text()
    refused = CliRunner().invoke(application, ["view", file, "--steady", "--export", str(out)])
    assert refused.exit_code == 2 and "--modes" in refused.output
