"""A pendulum for tests of the view, and live runs of it."""

from __future__ import annotations

from pathlib import Path

import bgc
from bgc.runtime.model import Model
from bgc.runtime.running.simulate import method_of
from bgc.runtime.view.live import LiveRun

MODEL = """
model Swing {
  param length = 2 m in 0.5 m .. 8 m;
  param limit = 10 rad/s;
  param angle0 = 30 deg;
  param g = 9.81 m/s^2;
  state angle = angle0;
  state rate : rad/s = 0 rad/s;
  der(angle) = rate;
  der(rate) = -g/length*sin(angle);
  assert abs(rate) < limit, "too fast";
  signal bob[3] : m = [length*sin(angle), 0, -length*cos(angle)];
  shape sphere(0.2 m) at bob colour "red";
  shape sea([[0.5 m, 1, 0, 0]]);
}
scene swing of Swing {
  observe angle in deg, bob as bob, rate;
  plot angle;
  plot rate against angle;
  solver rodas5p(rtol = 1e-8);
  run 3 s every 0.1 s;
}
"""


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
