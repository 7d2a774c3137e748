"""A vessel with post and two beams on free joints, against MuJoCo and the laws of momentum."""

from functools import cache

import mujoco
import numpy as np

GRAVITY = 9.81
NED = np.diag([1.0, -1, -1])

# The vessel without water: M_RB of its data, about midships, turned from NED axes.
SHIP_MASS = 4976887.5
SHIP_CENTRE = NED @ [-4.5, 0, -1.2]
SHIP_INERTIA = (
    NED
    @ [
        [204699382.875, 0, -26875192.5],
        [0, 2250809814.09375, 0],
        [-26875192.5, 0, 2243643096.09375],
    ]
    @ NED
)
DECK = np.array([-20.0, 0, 3])

X, Y, Z = np.eye(3)
JOINTS = [(Z, np.pi / 2), (-Y, np.pi / 4), (-Y, -np.pi / 3)]
BEAMS = [(5e3, 3.0, 1.0, Z), (3e3, 12.0, 0.8, X), (1.5e3, 9.0, 0.6, X)]  # mass, length, side, axis


def skew(v: np.ndarray) -> np.ndarray:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


def beam_inertia(mass: float, length: float, side: float, axis: np.ndarray) -> np.ndarray:
    """About the centre of mass."""
    along = np.outer(axis, axis)
    return mass / 12 * ((length**2 + side**2) * (np.eye(3) - along) + 2 * side**2 * along)


def inertial(mass: float, centre: np.ndarray, inertia: np.ndarray) -> str:
    """MuJoCo's inertial element; inertia about the centre of mass, in the body's axes."""
    full = [inertia[i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    return f'<inertial pos="{row(centre)}" mass="{mass!r}" fullinertia="{row(full)}"/>'


def row(values: object) -> str:
    return " ".join(repr(float(v)) for v in np.asarray(values))


def mujoco_xml(timestep: float) -> str:
    """The mechanism: exact joints; nothing weighs on the vessel, which floats in equilibrium."""
    body = f'<site name="tip" pos="{row(BEAMS[-1][1] * BEAMS[-1][3])}"/>'
    places = [DECK] + [length * axis for _, length, _, axis in BEAMS]
    for k in (2, 1, 0):
        mass, length, _, axis = BEAMS[k]
        shape = inertial(mass, length / 2 * axis, beam_inertia(*BEAMS[k]))
        joint = f'<joint type="hinge" axis="{row(JOINTS[k][0])}"/>'
        body = f'<body pos="{row(places[k])}">{joint}{shape}{body}</body>'
    about_centre = SHIP_INERTIA + SHIP_MASS * skew(SHIP_CENTRE) @ skew(SHIP_CENTRE)
    ship = inertial(SHIP_MASS, SHIP_CENTRE, about_centre)
    return f"""<mujoco>
      <option timestep="{timestep}" integrator="RK4" gravity="0 0 {-GRAVITY}">
        <flag contact="disable"/>
      </option>
      <worldbody><body gravcomp="1"><freejoint/>{ship}{body}</body></worldbody>
    </mujoco>"""


@cache
def mujoco_path(timestep: float) -> np.ndarray:
    """The tip's path, a row each 0.1 s to 2 s."""
    model = mujoco.MjModel.from_xml_string(mujoco_xml(timestep))
    data = mujoco.MjData(model)
    data.qpos[7:] = [angle for _, angle in JOINTS]
    mujoco.mj_forward(model, data)
    path = [data.site("tip").xpos.copy()]
    for _ in range(20):
        for _ in range(round(0.1 / timestep)):
            mujoco.mj_step(model, data)
        mujoco.mj_kinematics(model, data)
        path.append(data.site("tip").xpos.copy())
    return np.array(path)


def difference(result) -> float:
    return float(np.linalg.norm(result["tip"] - mujoco_path(1e-3), axis=1).max())


def keeps_balances(result, tolerance: float) -> None:
    """Energy, and momenta that only the weights change."""
    supplied = np.abs(result["energy.supplied"]).max()
    assert np.abs(result["energy.residual"]).max() < tolerance * supplied

    weight = sum(mass for mass, *_ in BEAMS) * GRAVITY
    linear = result["linear"]
    np.testing.assert_allclose(linear[:, 2], -weight * result.time, atol=tolerance * weight)
    np.testing.assert_allclose(linear[:, :2], 0, atol=tolerance * weight)
    scale = np.abs(result["weight_moment"]).max()
    np.testing.assert_allclose(result["angular"], result["weight_moment"], atol=tolerance * scale)


def test_the_reference_has_converged():
    assert np.abs(mujoco_path(2e-3) - mujoco_path(1e-3)).max() < 1e-8
    assert np.ptp(mujoco_path(1e-3)[:, 2]) > 10, "the beams have to fall"


def test_tip_path_of_the_free_fall(load):
    """Within 1 mm at 1e9 N/m, and nearer in proportion to the stiffness."""
    model = load("mechanism", "fall")
    soft, stiff, stiffest = (
        difference(model.simulate(parameters={"stiffness": k})) for k in (1e8, 1e9, 1e10)
    )
    assert stiff < 1e-3
    np.testing.assert_allclose(soft / stiff, 10, rtol=0.1)
    np.testing.assert_allclose(stiff / stiffest, 10, rtol=0.1)


def test_rigid_joints_are_exact(load):
    """Inertias merged by the compiler: MuJoCo's path to solver accuracy."""
    result = load("mechanism", "rigid").simulate()
    assert difference(result) < 1e-7
    keeps_balances(result, 1e-8)


def test_soft_joints_keep_energy_and_momentum(load):
    """At 3e5 N/m joints give way by centimetres and degrees: their kinematics is exact."""
    soft = {"stiffness": 3e5}
    result = load("mechanism", "fall").simulate(rtol=1e-10, parameters=soft)
    assert difference(result) > 0.1, "the joints have to give way"
    keeps_balances(result, 1e-9)
