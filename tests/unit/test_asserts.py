"""Asserts on constants are decided when a model is compiled, the others when it runs."""

from __future__ import annotations

from pathlib import Path

import pytest

import bgc
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.options import Options

MODEL = """
import arms.link;

model M {{
  param phi : rad = 0.3;
  param stretch = 1;
  ground : Ground;
  mount  : Mount(axes = {axes});
  joint  : Revolute(axis = {axis}, lock = Rigid[5]);
  body   : HeavyBody(mass = 1 kg, com = [0.1, 0, 0], inertia = eye(3));
  ground -> mount -> joint -> body;
}}

scene still of M {{
  observe joint.angle as a;
  run 1 s;
}}
"""


def written(tmp_path: Path, axes: str = "eye(3)", axis: str = "z") -> Path:
    path = tmp_path / "model.bg"
    path.write_text(MODEL.format(axes=axes, axis=axis))
    return path


@pytest.mark.parametrize(
    ("axes", "axis"),
    [
        ("rot_x(0.3)*rot_y(1.57079632679)", "[1, 2, 3]/norm([1, 2, 3])"),
        ("euler_matrix([0.1, 0.2, 0.3])", "[0.577350, 0.577350, 0.577350]"),
        ("[[0.955336, -0.295520, 0], [0.295520, 0.955336, 0], [0, 0, 1]]", "[0.6, 0, -0.8]"),
    ],
)
def test_what_constants_fulfil_costs_nothing(tmp_path: Path, axes: str, axis: str) -> None:
    """Also where rounding to six digits leaves a vector or a matrix slightly off."""
    stages = compile_scene(written(tmp_path, axes, axis), Options("still"), until="elaborate")
    assert stages.graph.guards == ()


@pytest.mark.parametrize("axis", ["[0, -2, 0]", "[0.6, 0.7, 0]", "zeros(3)"])
def test_an_axis_of_another_length_is_refused(tmp_path: Path, axis: str) -> None:
    with pytest.raises(BgError, match=r"BG456.*axis = v/norm"):
        compile_scene(written(tmp_path, axis=axis), Options("still"), until="elaborate")


@pytest.mark.parametrize("axes", ["diag([1, 2, 1])", "diag([1, 1, -1])", "zeros(3, 3)"])
def test_a_matrix_that_is_not_a_rotation_is_refused(tmp_path: Path, axes: str) -> None:
    with pytest.raises(BgError, match="BG456"):
        compile_scene(written(tmp_path, axes), Options("still"), until="elaborate")


def test_what_parameters_decide_is_checked_when_they_are_known(tmp_path: Path) -> None:
    model = bgc.compile(written(tmp_path, "rot_x(phi)*diag([1, stretch, 1])"))
    model.simulate(parameters={"phi": 0.7})
    with pytest.raises(BgError, match=r"BG705: `mount`: .*rotation"):
        model.simulate(parameters={"stretch": 2})


@pytest.mark.parametrize("start", ["", "start rest;"])
def test_an_assert_on_parameters_comes_before_a_start_that_they_spoil(
    tmp_path: Path, start: str
) -> None:
    """The root is undefined beyond 2, and so are the default of b and the start."""
    path = tmp_path / "model.bg"
    path.write_text(
        "model M { param a = 1; param b = sqrt(2 - a); state x = b; der(x) = b - x;"
        ' assert x < 100, "x is large"; assert a < 2, "a has to be below 2"; }'
        f"scene s of M {{ keep a, b; observe x; {start} run 1 s; }}"
    )
    model = bgc.compile(path)
    with pytest.raises(BgError, match="BG705: a has to be below 2"):
        model.simulate(parameters={"a": 3.0})
    # A value that is compiled in, and a parameter in its range whose default is undefined.
    with pytest.raises(BgError, match="BG705: a has to be below 2"):
        bgc.compile(path, parameters={"a": 3.0}).simulate()
    path.write_text(path.read_text().replace(' assert a < 2, "a has to be below 2";', ""))
    with pytest.raises(BgError, match=r"BG061: an undefined value is outside .* `b`"):
        bgc.compile(path).simulate(parameters={"a": 3.0})
