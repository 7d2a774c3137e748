"""A pendulum for tests of the view, and live runs of it."""

from __future__ import annotations

from pathlib import Path

from model_files import model_text

import bgc
from bgc.runtime.model import Model
from bgc.runtime.running.simulate import method_of
from bgc.runtime.view.live import LiveRun

MODEL = model_text("swing")


def write_swing(folder: Path) -> Path:
    """The file of the pendulum."""
    path = folder / "swing.bg"
    path.write_text(MODEL, "utf-8")
    return path


def compile_swing(file: Path) -> Model:
    """Its model, with shapes."""
    return bgc.compile(file, shapes=True)


def begin_run(model: Model) -> LiveRun:
    """A live run by the method of its scene."""
    return LiveRun(model, method_of(model)[0], {})
