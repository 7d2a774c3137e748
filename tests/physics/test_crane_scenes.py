"""The scenes of cranes and arms, and their mechanisms against Pinocchio."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from probe import probe
from published_arms import pinocchio_model
from scipy.integrate import solve_ivp

import bgc
import bgc.library
from bgc.runtime.running.structures import Status

SCENES = Path(bgc.library.__path__[0]) / "scenes"
G = 9.81


def bar(length, mass, side):
    """Moments of a uniform square bar along x."""
    along, across = mass * side**2 / 6, mass * (length**2 + side**2) / 12
    return f"{along!r} 0 0 {across!r} 0 {across!r}"


# Angles are positive upwards: about -y.
TELESCOPIC = f"""
post - turns  0 0 1  0 0 0  0 0 0
  6000  0 0 1.5  5000 0 0 5000 0 1000
outer post turns  0 -1 0  0 0 3  0 0 0
  7000  5 0 0  {bar(10, 7000, 0.8)}
inner outer slides  1 0 0  10 0 0  0 0 0
  4000  5 0 0  {bar(10, 4000, 0.6)}
tip inner fixed  0 0 0  10 0 0  0 0 0
  0  0 0 0  0 0 0 0 0 0
"""
EXCAVATOR = """
platform - turns  0 0 1  0 0 1.1  0 0 0
  9000  -1 0 0.9  9e3 0 0 15e3 0 18e3
boom platform turns  0 -1 0  0.3 0 0.8  0 0 0
  1600  2.7 0 0  150 0 0 4600 0 4600
stick boom turns  0 -1 0  5.7 0 0  0 0 0
  800  1 0 0  60 0 0 620 0 620
bucket stick turns  0 -1 0  2.9 0 0  0 0 0
  700  0.7 0 0  120 0 0 150 0 150
soil bucket fixed  0 0 0  1.5 0 0  0 0 0
  500  -0.7 0 -0.2  53.333333333333336 0 0 53.333333333333336 0 53.333333333333336
tip bucket fixed  0 0 0  1.5 0 0  0 0 0
  0  0 0 0  0 0 0 0 0 0
"""
MECHANISMS = {
    "telescopic": (
        TELESCOPIC,
        ("crane.pedestal.angle", "crane.luff.angle", "crane.telescope.extension"),
        0.0,  # the drives carry the weights
    ),
    "excavator": (
        EXCAVATOR,
        tuple(f"machine.{joint}.angle" for joint in ("ring", "foot", "elbow", "wrist")),
        G,
    ),
}


@pytest.mark.parametrize("name", MECHANISMS)
def test_a_mechanism_has_pinocchios_mass_matrix_and_forces(name):
    pin = pytest.importorskip("pinocchio")
    table, joints, gravity = MECHANISMS[name]
    machine = probe("cranes", name, *(f"rates[{k + 1}]" for k in range(len(joints))))
    model = pinocchio_model(table, gravity)
    data = model.createData()
    tip = model.getFrameId("tip")
    rng = np.random.default_rng(3)
    for _ in range(30):
        q, v = rng.uniform(-1.5, 1.5, len(joints)), rng.normal(size=len(joints))
        state = machine.at(dict(zip(joints, q, strict=True)), v)
        mass, exact = machine.mass_matrix(state), pin.crba(model, data, q)
        exact = np.triu(exact) + np.triu(exact, 1).T
        np.testing.assert_allclose(mass, exact, rtol=0, atol=1e-12 * np.abs(exact).max())
        bias, forces = -mass @ machine.accelerations(state), pin.nonLinearEffects(model, data, q, v)
        np.testing.assert_allclose(bias, forces, rtol=0, atol=1e-11 * np.abs(forces).max())
        pin.framesForwardKinematics(model, data, q)
        found = machine.vector(state, "tip")
        np.testing.assert_allclose(found, data.oMf[tip].translation, rtol=0, atol=1e-12)


@cache
def model(name, scene=None):
    return bgc.compile(SCENES / f"{name}.bg", scene=scene or name)


# Scene, the column that a command moves, when it does, and where it is in the end.
MOVED = {
    "telescopic_crane": ("reach[2]", 1.0, 11.490666646784671 + 1.5),
    "knuckle_boom": ("reach[3]", 1.0, None),
    "gantry": ("position[1]", 1.0, None),
    "ur5": ("q[1] [deg]", 0.5, 0.0),
    "panda": ("q[4] [deg]", 0.5, -135.0),
    "excavator": ("cylinders[2]", 0.5, None),
}


# Values of one line, `set crane.outer.length = 16 m;` or `--set`: beams, ropes, loads and drives.
ONE_LINE = {
    "telescopic_crane": ("crane.outer.length=16", "crane.inner.mass=1000", "load.mass=6000"),
    "knuckle_boom": ("crane.arm.boom.length=12", "load.length=10", "load.mass=6000"),
    "gantry": ("crane.length=12", "crane.trolley_mass=9000"),
    "ur5": ("tool_mass=5",),
    "panda": ("tool_mass=3",),
    "excavator": ("machine.soil=1500",),
}


@pytest.mark.parametrize("name", MOVED)
def test_a_scene_starts_at_rest_moves_and_keeps_its_account(name):
    column, begins, end = MOVED[name]
    result = model(name).simulate()
    still = result[column][result.time < begins]
    assert np.ptp(still) < 1e-8
    assert np.ptp(result[column]) > 0.2
    if end is not None:
        assert result[column][-1] == pytest.approx(end, rel=2e-3, abs=0.05)
    assert np.abs(result["energy.residual"]).max() < 3e-6 * result.counts["exchanged"]
    for line in ONE_LINE[name]:  # a scene with one value changed starts at rest
        parameter, _, value = line.partition("=")
        instance = model(name).instance_at(None, 0.0, {parameter: float(value)})
        status, rates = instance.rhs()
        assert status is Status.OK
        assert np.abs(rates / instance.scale).max() < 1e-6, line


# Loads of a milligram and of a thousand times their mass, upright, stretched and singular arms.
UPRIGHT = 1.5707963267948966
EXTREMES = {
    "telescopic_crane": (
        {"load.mass": 1e-6},
        {"load.mass": 2e6},
        {"crane.luff.angle0": UPRIGHT},
    ),
    "knuckle_boom": (
        {"load.mass": 1e-6},
        {"load.mass": 2e6},
        {"crane.arm.elbow.angle0": 0.0},
        {"crane.arm.shoulder.angle0": UPRIGHT, "crane.arm.elbow.angle0": 0.0},
    ),
    "gantry": ({"crane.hang.mass": 0.5}, {"crane.hang.mass": 5e5}, {"crane.trolley_mass": 5.0}),
    "ur5": (
        {"tool_mass": 1e-6},
        {"tool_mass": 1000.0},
        {"q0[5]": 0.0},
        {"q0[2]": -UPRIGHT, "q0[3]": 0.0, "q0[4]": -UPRIGHT},
    ),
    "panda": (
        {"tool_mass": 1e-6},
        {"tool_mass": 1000.0},
        {"q0[2]": 0.0, "q0[4]": 0.0, "q0[6]": 0.0},
    ),
}


@pytest.mark.parametrize("name", EXTREMES)
def test_a_scene_starts_at_rest_at_its_extremes(name):
    for values in EXTREMES[name]:
        result = model(name).simulate(0.05, solver="rodas5p", rtol=1e-6, parameters=values)
        still = [column for column in result if not column.startswith("energy")]
        assert max(np.ptp(result[column], axis=0).max() for column in still) < 1e-7, values
        residual = np.abs(result["energy.residual"]).max()
        assert residual <= 1e-8 * result.counts["exchanged"], values


def test_a_heavy_load_stretches_the_spring_that_holds_the_tip_and_folds_no_crane():
    """Only `pilot.stretch0` is free: its spring carries m g, however far it is stretched."""
    values = {"load.mass": 2e6}
    rest = model("knuckle_boom").simulate(0.01, parameters=values).at_rest
    assert {move.name for move in rest.moves} == {"pilot.spring.q[3]"}
    assert rest.moves[0].after == pytest.approx(-2e6 * 9.81 / 4e5, rel=1e-9)


# Scene, slot and what fills it: `use SLOT = TYPE;`, or `--use`.
ANOTHER_PART = (
    ("compare_cranes", "vessel", "Quay"),
    ("compare_cranes", "vessel", "GuidedVessel"),
    ("two_beam_crane", "vessel", "OsvSeakeeping"),
    ("two_beam_crane", "crane.elbow.lock", "Rigid[5]"),
    ("telescopic_crane", "vessel", "GuidedVessel"),
    ("offshore_lift", "vessel", "SupplyAtRest"),
    ("ur5", "arm", "Ur10"),
)


@pytest.mark.parametrize(("name", "slot", "part"), ANOTHER_PART)
def test_a_scene_with_another_part_starts_at_rest(name, slot, part):
    changed = bgc.compile(SCENES / f"{name}.bg", uses={slot: part})
    result = changed.simulate(0.05, every=0.01, solver="rodas5p", rtol=1e-8)
    assert result.at_rest is not None
    still = [column for column in result if not column.startswith("energy")]
    assert max(np.ptp(result[column], axis=0).max() for column in still) < 1e-7


def _moved(damping, way, duration, mass, limit):
    """The end of a drive of the gantry: trolley, hook and load at small angles, two falls."""

    def share(t):
        return np.clip(t / duration, 0, 1)

    def rates(t, y):
        _, v, block, load, block_v, load_v = y
        s, lowered = share(t - 1), np.clip((t - 3) / 6, 0, 1)
        length = 8.04 + 2 * lowered**3 * (10 - 15 * lowered + 6 * lowered**2)
        g = G - 2 * 60 / 36 * lowered * (1 - lowered) * (1 - 2 * lowered)
        asked = way * 30 * s**2 * (1 - s) ** 2 / duration
        asked += 2 * damping * np.sqrt(G / length) * block
        rope, sling = 10.5e3 * g * block / length, 10e3 * g * load / 3.3
        drive = limit * np.tanh(1e6 * (asked - v) / limit)
        accelerations = (drive + rope) / mass, (sling - rope) / 500, -sling / 10e3
        return [v, accelerations[0], block_v - v, load_v - block_v, *accelerations[1:]]

    done = solve_ivp(rates, (0, 25), np.zeros(6), "LSODA", rtol=1e-7, atol=1e-7, max_step=0.05)
    return done.y[0, -1]


def test_anti_sway_brings_the_load_of_the_gantry_to_rest():
    left = []
    for damping in (0.0, 0.5):
        result = model("gantry").simulate(parameters={"crane.damping": damping})
        late = result.time > 20
        left.append(np.ptp(result["load_at[1]"][late]))
        # The rope becomes longer: anti-sway moves the suspension further than the command.
        ends = [_moved(damping, 8, 8, 30e3, 50e3), _moved(damping, 4, 6, 5e3, 20e3)]
        np.testing.assert_allclose(result["position"][-1], ends, atol=0.01)
    assert left[0] > 0.2
    assert left[1] < 0.1 * left[0]


def test_cranes_are_compared_with_one_operator_and_load():
    """The tips of all three do as asked; on a vessel that heels by what each of them weighs."""
    heel = {}
    for scene in ("compare_cranes", "two_beam", "telescopic"):
        result = model("compare_cranes", scene).simulate()
        moved = result["reach"] - result["reach"][0]
        assert np.abs(moved[-1] - [0, 0, 1]).max() < 0.02
        before = result.time < 1
        assert np.ptp(result["tip"][before], axis=0).max() < 1e-6
        assert result["force"][0, 2] == pytest.approx(2000 * G, rel=5e-3)
        heel[scene] = abs(result["roll [deg]"][0])
    assert heel["two_beam"] > heel["telescopic"] > heel["compare_cranes"]


def test_a_scene_with_one_line_changed_starts_at_rest(tmp_path):
    """Another beam, rope, crane or vessel. Cranes are compared above."""
    changes = (
        (model("compare_cranes", "two_beam"), {"crane.boom.length": 14.0}, "tip"),
        (model("telescopic_crane"), {"load.length": 9.0}, "load_at"),
    )
    at_sea = model("knuckle_boom_at_sea")  # many valves, a rope whose length the frames know, too
    for values in ({"length": 8.0, "mass": "1.5 t"}, {"compensation": 0.0}):
        start = at_sea.simulate(1e-3, parameters=values)
        mass = 1500 if "mass" in values else 2200
        assert start["tension [kN]"][0] == pytest.approx(mass * G / 1e3, rel=1e-6)
    for crane, values, column in changes:
        run = {"every": 0.1, "solver": "rodas5p", "rtol": 1e-6}
        result = crane.simulate(0.3, **run, parameters=values)
        assert np.ptp(result[column], axis=0).max() < 1e-6
    file = tmp_path / "changed.bg"
    text = (SCENES / "knuckle_boom.bg").read_text()
    text = text.replace("import crane.lift;", "import crane.lift;\nimport marine.osv;")
    file.write_text(text.replace("  use crane", "  use vessel = OsvSeakeeping;\n  use crane", 1))
    result = bgc.compile(file).simulate(1.0)
    assert np.ptp(result["load_at"], axis=0).max() < 1e-6


@pytest.mark.parametrize("seed", range(1, 6))
def test_the_winch_of_the_whole_machine_takes_out_the_heave(seed):
    """At least 90 % of it, in JONSWAP, Hs 2.5 m, Tp 8 s, with limits of flow and pressure.

    Without compensation the load heaves as the tip does: that is compared for the first sea, and
    the tip stands for it in the others.
    """
    machine = model("knuckle_boom_at_sea")

    def run(share: float) -> bgc.Result:
        given = {"compensation": share, "vessel.sea.seed": float(seed)}
        return machine.simulate(21, parameters=given)

    held = run(1)
    quiet = held.time > 10
    left, whole = (np.std(held[column][quiet]) for column in ("height", "tip_height"))
    assert whole > 0.1
    assert left < 0.1 * whole
    assert np.abs(held["pressure [bar]"]).max() < 300
    assert not held["at_limit"][quiet].any() and not held["relieved"][quiet].any()
    if seed == 1:
        assert np.std(run(0)["height"][quiet]) == pytest.approx(whole, rel=0.01)


@pytest.mark.parametrize(
    ("limit", "column"),
    [({"winch.flow": "20 L/min"}, "at_limit"), ({"winch.limit": "80 bar"}, "relieved")],
)
def test_a_winch_at_its_limits_says_so_and_leaves_heave(limit, column):
    """A small pump and low relief valves; the whole flow of the pump and the leak move the rope."""
    machine = model("knuckle_boom_at_sea")
    given = {"compensation": 1.0, **limit}
    held = machine.simulate(21, parameters=given)
    quiet = held.time > 10
    assert np.std(held["height"][quiet]) > 0.2 * np.std(held["tip_height"][quiet])
    assert held[column][quiet].mean() > 0.3
    if column == "at_limit":
        assert not held["relieved"].any()
        flow = 20 + 0.05 * held["pressure [bar]"]  # L/min; the leak pays out
        radius = np.sqrt(0.6**2 / 4 + np.sin(np.pi / 3) * 0.02**2 * 200 / np.pi)
        fastest = flow / 0.1 / 60 * 2 * np.pi / 50 * radius
        assert held["pay"].max() == pytest.approx(fastest[held["pay"].argmax()], rel=0.01)


def test_the_crane_at_sea_starts_at_rest_and_converges_at_a_millisecond():
    machine = model("knuckle_boom_at_sea")
    run = machine.simulate(error=True)
    exact = machine.simulate(solver="rodas5p", rtol=1e-8)
    assert np.ptp(exact["stroke"], axis=0).min() > 0.05
    assert run["tension [kN]"][0] == pytest.approx(2200 * G / 1e3, rel=1e-6)
    difference = np.abs(run["stroke"] - exact["stroke"]).max()
    assert difference < 1e-4
    # Arguments that stand at their edges while others meet theirs leave the estimate as it is.
    assert difference / 3 < np.abs(run.error["stroke"]).max() < 3 * difference
    assert np.abs(run["height"] - exact["height"]).max() < 2e-3
    assert np.abs(np.diff(exact["height"])[:2]).max() < 2e-3
