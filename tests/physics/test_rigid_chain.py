"""Rigid joints in a row on the ground, merged into as many states as there are angles."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import bgc

MODEL = Path(__file__).parents[1] / "models/rigid_chain.bg"

ALONG, ACROSS = "{i} {t} {t}", "{t} {i} {t}"


def bar(mass, length, shape):
    """Principal inertia of a uniform bar of side 0.1 m, for MuJoCo."""
    return shape.format(i=mass * 0.01 / 6, t=mass * (length**2 + 0.01) / 12)


def angles_by_mujoco(axes, lower_at, shape, torque):
    """Both angles after 1 and 2 s."""
    lower = np.array(lower_at)
    model = mujoco.MjModel.from_xml_string(f"""
    <mujoco><option gravity="0 0 -9.81" timestep="2e-4" integrator="RK4"/><worldbody><body>
      <joint type="hinge" axis="{axes[0]}"/>
      <inertial pos="1 0 0" mass="10" diaginertia="{bar(10, 2, ALONG)}"/>
      <body pos="2 0 0">
        <joint type="hinge" axis="{axes[1]}"/>
        <inertial pos="{" ".join(map(str, lower / 2))}" mass="4" diaginertia="{bar(4, 1, shape)}"/>
        <body pos="{" ".join(map(str, lower))}">
          <inertial pos="0 0 0" mass="1" diaginertia="0.01 0.01 0.01"/>
        </body>
      </body>
    </body></worldbody></mujoco>""")
    data = mujoco.MjData(model)
    data.qpos[1] = np.deg2rad(10)
    data.qfrc_applied[0] = torque
    angles = []
    for _ in range(2):
        for _ in range(5000):
            mujoco.mj_step(model, data)
        angles.append(data.qpos.copy())
    return np.array(angles)


@pytest.mark.parametrize(
    ("scene", "axes", "lower_at", "shape", "torque"),
    [
        ("planar", ("0 1 0", "0 1 0"), (1, 0, 0), ALONG, 0),
        ("skew", ("0 0 1", "1 0 0"), (0, 1, 0), ACROSS, 20),
    ],
)
def test_angles_are_those_of_mujoco(load, scene, axes, lower_at, shape, torque):
    model = load("rigid_chain", scene)
    assert len(model.states) == 4
    result = model.simulate()
    expected = angles_by_mujoco(axes, lower_at, shape, torque)
    np.testing.assert_allclose(result["first"][1:], expected[:, 0], atol=1e-7)
    np.testing.assert_allclose(result["second"][1:], expected[:, 1], atol=1e-7)
    assert np.abs(result["energy.residual"]).max() < 1e-6


def test_a_link_without_length_leaves_a_pendulum(tmp_path):
    """The moduli of its shift underflow: differences of flows are rounding, and no power."""
    path = tmp_path / "short.bg"
    text = MODEL.read_text("utf-8").replace("length = 2 m", "length = 1e-308 m")
    path.write_text(text, "utf-8")
    result = bgc.compile(path, scene="planar").simulate()
    inertia = 4 * 1.01 / 12 + 4 * 0.25 + 0.01 + 1
    pull = 9.81 * (4 * 0.5 + 1)
    exact = solve_ivp(
        lambda _, x: (x[1], pull * np.cos(x[0]) / inertia), (0, 2), (np.deg2rad(10), 0),
        t_eval=(1, 2), rtol=1e-11, atol=1e-12,
    )  # fmt: skip
    np.testing.assert_allclose(result["second"][1:], exact.y[0], atol=1e-7)
    assert np.abs(result["first"]).max() < 1e-300
