"""Closed chains of rigid joints, against bars with pins in maximal coordinates."""

import re
from pathlib import Path

import numpy as np
import pytest
from bars import GRAVITY, Bars, across, bar_from, direction, four_bar
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import bgc
from bgc.driver import compile_scene
from bgc.options import Options
from bgc.runtime.linearising.operating_point import OpenedModel
from bgc.runtime.running.failures import SimulationError
from bgc.runtime.running.structures import Status

TESTS = Path(__file__).parents[1]


def turned(result, *names):
    return np.cumsum(np.column_stack([result[name] for name in names]), axis=1)


def closed(result, name="gap"):
    return np.abs(result[name]).max()


def test_a_four_bar_moves_as_bars_with_pins(load):
    result = load("closed_chains", "four_bar").simulate()
    angles = turned(result, "a", "b", "c")
    np.testing.assert_allclose(angles, four_bar(result.time, angles[0]), atol=2e-7)
    assert np.ptp(angles[:, 0]) > 10, "it has to turn over"
    assert closed(result) < 1e-12
    assert np.abs(result["energy.residual"]).max() < 1e-6


def test_a_four_bar_goes_through_the_dead_centres_of_its_bars(load):
    """No bar can turn round: where two lie in one line, the third stands still and turns back."""
    result = load("closed_chains", "between_dead_centres").simulate()
    angles = turned(result, "a", "b", "c")
    np.testing.assert_allclose(angles, four_bar(result.time, angles[0], crank=3.4), atol=1e-6)
    for name, line in (("b", np.pi), ("c", -4 * np.pi)):
        passes = np.count_nonzero(np.diff(result[name] > line))
        assert passes >= 2, f"{name} has to pass the line"
    assert closed(result) < 1e-12
    exchanged = np.ptp(result["energy.stored"])
    assert np.abs(result["energy.residual"]).max() < 1e-9 * exchanged


def test_two_parallelograms_end_at_their_common_change_point(load):
    """Until there they are one pendulum: three bars turn, two go along."""
    diagnostic, result = simulated_until_singular(load("closed_chains", "double"))
    inertia, weight = 3 * (1 / 3 + 0.1**2 / 12) + 2, GRAVITY * (3 / 2 + 2)

    def rates(_, x):
        return [x[1], -weight / inertia * np.cos(x[0])]

    exact = solve_ivp(rates, (0, 2), [np.pi / 3, 0], "DOP853", result.time, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(result["a"], exact.y[0], atol=1e-7)
    assert 0 < result["a"][-1] < 0.05
    assert diagnostic.note.startswith("there `pin1.angle` = ")
    assert np.abs(result["gap"]).max() < 1e-12 and np.abs(result["gap2"]).max() < 1e-12


def on_mount(text: str, pin: str, turn: list[float], digits: int) -> str:
    """A four-bar with one pin between a mount in a general direction and the mount back."""

    def listed(values) -> str:
        return f"[{', '.join(f'{x:.{digits}f}' for x in values)}]"

    axes = Rotation.from_rotvec(turn).as_matrix()
    there, back = (f"[{', '.join(map(listed, m))}]" for m in (axes, axes.T))
    text = re.sub(rf"({pin} +: Revolute\(axis = )-y", rf"\g<1>{listed(-axes[1])}", text, count=1)
    text = text.replace(f"-> {pin} ->", f"-> {pin}_there -> {pin} -> {pin}_back ->", 1)
    mounts = f"  {pin}_there : Mount(axes = {there});\n  {pin}_back : Mount(axes = {back});\n"
    return text.replace("  ground -> mount ->", f"{mounts}  ground -> mount ->", 1)


def test_a_four_bar_on_mounts_in_general_directions_moves_as_without(load, tmp_path):
    """Rows that are redundant in exact directions are zero but for the digits of the mounts.

    With mounts at all pins, one of the independent rates moved nothing else (BG513 before).
    """
    text = "import arms.link;\n" + (TESTS / "models/closed_chains.bg").read_text("utf-8")
    text = on_mount(text, "pin1", [1.3, -0.4, 2.1], 11)
    text = on_mount(text, "pin2", [0.7, 1.1, -0.3], 16)
    text = on_mount(text, "pin3", [-0.2, 1.9, 0.6], 16)
    text = on_mount(text, "pin4", [-0.9, 0.1, 1.4], 11)
    path = tmp_path / "mounted.bg"
    path.write_text(text, "utf-8")
    result = bgc.compile(path, scene="four_bar", preview=True).simulate()
    plain = load("closed_chains", "four_bar").simulate()
    for name in "abcd":
        np.testing.assert_allclose(result[name], plain[name], atol=1e-8)
    assert closed(result) < 1e-10


@pytest.mark.parametrize("solver", ["dopri5", "rodas4p2", "radau5"])
def test_every_adaptive_method_gives_the_same_motion(load, solver):
    model = load("closed_chains", "four_bar")
    exact = model.simulate()
    result = model.simulate(solver=solver, rtol=1e-9)
    np.testing.assert_allclose(result["a"], exact["a"], atol=1e-6)
    assert closed(result) < 1e-12


@pytest.mark.parametrize("solver", ["ros34prw", "rodas23w", "rk4", "heun", "midpoint", "gauss4"])
def test_fixed_steps_keep_the_chain_closed(load, solver):
    model = load("closed_chains", "four_bar")
    exact = model.simulate()
    coarse, fine = (model.simulate(solver=solver, step=step) for step in (2e-3, 1e-3))
    errors = [np.abs(r["a"] - exact["a"]).max() for r in (coarse, fine)]
    assert errors[1] < 5e-3 and errors[1] < errors[0] / 3
    assert max(closed(coarse), closed(fine)) < 1e-12


def test_a_tilted_linkage_needs_its_redundant_rows_dropped(load):
    """In a plane in no special direction no row is identically zero, yet three are redundant."""
    model = load("closed_chains", "tilted")
    result = model.simulate()
    tilt, axis = 0.7, np.array([1, -4, 2]) / np.sqrt(21)
    assert closed(result) < 1e-12
    assert np.abs(result["energy.residual"]).max() < 1e-6

    # In the plane of the linkage gravity is what remains of it there.
    cos, sin = np.cos(tilt), np.sin(tilt)
    skew = np.cross(np.eye(3), axis)
    turn = cos * np.eye(3) + (1 - cos) * np.outer(axis, axis) + sin * skew
    pull = turn.T @ np.array([0, 0, -GRAVITY])
    bars = Bars((3, 1, 0.1), (8, 2.5, 0.1), (5, 1.7, 0.1))
    angles = turned(result, "a", "b", "c")
    start, at = [], np.zeros(2)
    for length, angle in zip((1, 2.5, 1.7), angles[0], strict=True):
        start += bar_from(at, length, angle)
        at = at + length * direction(angle)
    bars.pin(bars.at(0, -0.5))
    bars.pin(bars.at(0, 0.5), bars.at(1, -1.25))
    bars.pin(bars.at(1, 1.25), bars.at(2, -0.85))
    bars.pin(bars.at(2, 0.85))
    bars.torques[2] = 60
    extra = np.zeros(9)
    extra[0::3] = bars.mass * pull[0]
    extra[1::3] = bars.mass * (pull[2] + GRAVITY)
    exact = bars.motion(np.array(start), result.time, lambda q: extra)[:, 2::3]
    np.testing.assert_allclose(angles, exact, atol=2e-7)


def test_a_parallelogram_stays_one(load):
    result = load("closed_chains", "parallelogram").simulate()
    bars = Bars((3, 1, 0.1), (8, 2, 0.1), (5, 1, 0.1))
    angle = np.pi / 3
    top, right = direction(angle), np.array([2.0, 0.0])
    start = bar_from(np.zeros(2), 1, angle) + bar_from(top, 2, 0.0)
    start += bar_from(top + right, 1, angle + np.pi)
    bars.pin(bars.at(0, -0.5))
    bars.pin(bars.at(0, 0.5), bars.at(1, -1))
    bars.pin(bars.at(1, 1), bars.at(2, -0.5))
    bars.pin(bars.at(2, 0.5))
    exact = bars.motion(np.array(start), result.time)[:, 2]
    np.testing.assert_allclose(result["a"], exact, atol=1e-7)
    np.testing.assert_allclose(result["b"], -result["a"], atol=1e-12)
    assert closed(result) < 1e-12


def test_a_slider_crank_moves_as_bars_with_pins_and_a_guide(load):
    result = load("closed_chains", "slider_crank").simulate()
    bars = Bars((3, 0.5, 0.1), (4, 1.5, 0.05), (6, 0.2, 0.1))
    angles = turned(result, "a", "b")
    at, start = np.zeros(2), []
    for length, angle in ((0.5, angles[0, 0]), (1.5, angles[0, 1]), (0.2, 0.0)):
        start += bar_from(at, length, angle)
        at = at + length * direction(angle)
    assert abs(at[1]) < 1e-9
    bars.pin(bars.at(0, -0.25))
    bars.pin(bars.at(0, 0.25), bars.at(1, -0.75))
    bars.pin(bars.at(1, 0.75), bars.at(2, -0.1))
    bars.fix(np.eye(9)[7])
    bars.fix(np.eye(9)[8])
    bars.torques[2] = 20
    exact = bars.motion(np.array(start), result.time)
    np.testing.assert_allclose(angles, exact[:, [2, 5]], atol=5e-7)
    np.testing.assert_allclose(result["x"], exact[:, 6] + 0.1, atol=5e-7)
    assert closed(result) < 1e-12
    assert np.abs(result["energy.residual"]).max() < 1e-6


def test_a_derrick_moves_as_a_boom_with_a_cylinder(load):
    result = load("closed_chains", "derrick").simulate()
    bars = Bars((800, 6, 0.3), (60, 1.5, 0.1), (90, 1.2, 0.15))
    boom, eye, stroke = result["a"][0], result["b"][0], result["x"][0]
    rod = boom + eye
    head = 2 * direction(boom) + 1.5 * direction(rod)
    start = bar_from(np.zeros(2), 6, boom) + bar_from(2 * direction(boom), 1.5, rod)
    start += bar_from(head + stroke * direction(rod), 1.2, rod)
    bars.pin(bars.at(0, -3))
    bars.pin(bars.at(0, -1), bars.at(1, -0.75))
    bars.fix(np.eye(9)[5] - np.eye(9)[8])
    bars.slide(bars.at(2, -0.6), bars.at(1, 0.75), 1)
    bars.pin(bars.at(2, 0.6))

    def push(q):
        force = np.zeros(9)
        along = 12e3 * direction(q[5])
        for point, sign in ((bars.at(2, -0.6), 1), (bars.at(1, 0.75), -1)):
            force += sign * point[1](q).T @ along
        return force

    exact = bars.motion(np.array(start), result.time, push)
    np.testing.assert_allclose(result["a"], exact[:, 2], atol=1e-6)
    np.testing.assert_allclose(result["a"] + result["b"], exact[:, 5], atol=1e-6)
    assert np.ptp(result["a"]) > 0.5
    assert closed(result) < 1e-12


def test_a_skate_follows_its_cycloid(load):
    """A constraint on rates alone: no position is held."""
    result = load("closed_chains", "skate").simulate()
    t, turn, pull = result.time, 0.7, 2 / 3
    np.testing.assert_allclose(result["x"], pull / (2 * turn**2) * np.sin(turn * t) ** 2, atol=1e-8)
    exact = pull / (2 * turn**2) * (turn * t - np.sin(turn * t) * np.cos(turn * t))
    np.testing.assert_allclose(result["y"], exact, atol=1e-8)
    # The edge turns the momentum, and takes the pull across the blade.
    grip = 3 * (pull / turn * np.sin(turn * t)) * turn + 2 * np.sin(turn * t)
    np.testing.assert_allclose(np.abs(result["grip"]), np.abs(grip), atol=1e-6)
    assert np.abs(result["energy.residual"]).max() < 1e-8


@pytest.mark.parametrize("solver", ["rodas5p", "dopri5"])
def test_a_thousand_seconds_open_no_gap(load, solver):
    result = load("closed_chains", "four_bar").simulate(
        duration=1000, every=0.37, rtol=1e-6, solver=solver, parameters={"drive": 0}
    )
    angles, rates = turned(result, "a", "b", "c"), turned(result, "u", "v", "w")
    moved = [
        length * w * across(angle)
        for length, *pair in ((1, angles[:, 0], rates[:, 0]), (2.5, angles[:, 1], rates[:, 1]),
                              (1.7, angles[:, 2], rates[:, 2]))
        for angle, w in [pair]
    ]  # fmt: skip
    assert np.ptp(result["a"]) > 0.5 and np.abs(rates).max() > 1
    assert closed(result) < 1e-9
    assert np.abs(sum(moved)).max() < 1e-9


def simulated_until_singular(model, **options):
    with pytest.raises(SimulationError) as caught:
        model.simulate(**options)
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "BG735"
    return diagnostic, caught.value.result


@pytest.mark.parametrize(
    "options",
    [{}, {"rtol": 1e-3}, {"solver": "rk4", "step": 1e-3}, {"solver": "ros34prw", "step": 0.01}],
)
def test_a_parallelogram_ends_where_its_bars_lie_in_one_line(load, options):
    model = load("closed_chains", "through_the_line")
    diagnostic, result = simulated_until_singular(model, **options)
    assert all(f"`{name}`" in diagnostic.message for name in ("pin1", "crank", "pin4"))
    assert "t = 0.55" in diagnostic.message
    assert 0 < result["a"][-1] < 0.3


def test_a_restart_at_a_singular_position_is_refused_and_another_is_not(load):
    """BAD_ARGUMENT at the second one before, which a search for a state of rest cannot explain."""
    model = load("closed_chains", "through_the_line")
    instance = model.instance_at(None, 0.0, {})
    good, in_line = instance.state.copy(), np.zeros(len(model.states))
    names = [state.name for state in model.states]
    in_line[names.index("pin3.angle")], in_line[names.index("pin4.angle")] = -np.pi, np.pi
    for state, status in ((in_line, Status.SINGULAR_CHAIN), (good, Status.OK)):
        instance.state[:] = state
        assert instance.restart() is status
    np.testing.assert_allclose(instance.state, good, atol=1e-12)


def test_a_slider_crank_of_equal_bars_ends_at_its_dead_centre(load):
    diagnostic, result = simulated_until_singular(load("closed_chains", "dead_centre"))
    assert "`guide`" in diagnostic.message
    assert result["a"][-1] == pytest.approx(np.pi / 2, abs=0.02)


def test_a_given_angle_opens_the_chain(load):
    with pytest.raises(bgc.BgError) as caught:
        load("closed_chains", "four_bar").simulate(parameters={"crank_length": 6})
    (diagnostic,) = caught.value.diagnostics
    assert diagnostic.code == "BG736"
    assert "`weld.gap[3]`" in diagnostic.message  # the crank points up


def test_a_length_of_a_run_closes_anew(load):
    result = load("closed_chains", "four_bar").simulate(parameters={"crank_length": 0.8})
    assert closed(result) < 1e-12
    assert result["b"][0] != load("closed_chains", "four_bar").simulate()["b"][0]


def test_instances_of_an_ensemble_are_those_of_single_runs(load):
    model = load("closed_chains", "slider_crank")
    lengths = [1.3, 1.5, 1.7, 1.9]
    runs = model.simulate_many({"rod_length": lengths})
    assert "closed chains" in runs.alone
    for k, length in enumerate(lengths):
        alone = model.simulate(parameters={"rod_length": length})
        np.testing.assert_array_equal(runs.values[k][:, 0], alone["a"])


def test_small_swings_have_the_frequency_of_one_pendulum(load):
    """Crank and rocker swing about their pins, the coupler goes along without turning."""
    linear = load("closed_chains", "hanging").linearise()
    bars = sum(m * (1 / 3 + 0.1**2 / 12) for m in (3, 5))
    frequency = np.sqrt(GRAVITY * (3 / 2 + 5 / 2 + 8) / (bars + 8))
    assert len(linear.states) == 2
    np.testing.assert_allclose(sorted(np.linalg.eigvals(linear.A).imag), [-frequency, frequency])


def test_the_steady_state_of_a_chain_is_found_from_a_distance(load):
    """From 10 degrees beside it; the response of its angle to a torque is that of one pendulum."""
    model = load("closed_chains", "hanging")
    linear = model.linearise(
        ["pin1.drive.e"], ["pin1.angle"], at="steady", parameters={"start": -1.4}
    )
    bars = sum(m * (1 / 3 + 0.1**2 / 12) for m in (3, 5))
    omega = np.array([0.5, 2.0, 10.0])
    exact = 1 / (GRAVITY * 12 - (bars + 8) * omega**2)
    np.testing.assert_allclose(linear.response(omega)[:, 0, 0], exact, rtol=1e-6)


def test_a_derrick_comes_to_rest_where_its_cylinder_carries_it():
    """The potential of the weights, less the work of the cylinder, is least along the motion."""

    def potential(angle):
        eye = 2 * np.array([np.cos(angle), np.sin(angle)])
        anchor = np.array([0.5, -1.0])
        length = np.linalg.norm(eye - anchor)
        rod = eye + 0.75 * (anchor - eye) / length
        barrel = anchor + 0.6 * (eye - anchor) / length
        heights = 800 * 3 * np.sin(angle) + 60 * rod[1] + 90 * barrel[1]
        return GRAVITY * heights - 12e3 * length

    path = TESTS / "models" / "closed_chains.bg"
    opened = OpenedModel(path, Options(scene="derrick"))
    found = opened.operating_point("steady").state
    names = [state.name for state in opened.opened.program.states]
    angle = found[names.index("foot.angle")]
    slope = (potential(angle + 1e-5) - potential(angle - 1e-5)) / 2e-5
    assert abs(slope) < 1e-4 * GRAVITY * 800 * 3


def test_a_linearisation_by_a_length_of_the_chain_is_refused(load):
    with pytest.raises(bgc.BgError) as error:
        load("closed_chains", "slider_crank").linearise(["rod_length"])
    assert [d.code for d in error.value.diagnostics] == ["BG534"]


@pytest.mark.parametrize("feed", ["0.1 A * cos(4 rad/s * time)", "0.02 A"])
def test_a_saturating_coil_in_a_closed_chain_starts_closed(feed: str, tmp_path: Path) -> None:
    """The source closes the chain through a modulus that may vanish; the momentum follows."""
    text = """model M {
      motion : J1;
      loop : J1;
      state angle = 0.024;
      der(angle) = loop.f/1 A/10 s;
      body : I { f = 0.0032 A/V/s * p/sqrt(1 + (p/26 V*s)^2) + 0.00032 A/V/s * p; }
      gear : MTF(1.5 + sin(10*angle));
      feed : Sf(FEED);
      motion -> body;
      motion -> gear -> loop;
      feed -> loop;
    }
    scene s of M {
      observe body.f, body.p, loop.f, angle, energy.residual, energy.supplied;
      run 4 s every 0.1 s;
    }"""
    path = tmp_path / "coil.bg"
    path.write_text(text.replace("FEED", feed))
    result = bgc.compile(path).simulate(rtol=1e-9)
    assert result["loop.f"] == pytest.approx(
        (1.5 + np.sin(10 * result["angle"])) * result["body.f"]
    )
    p = result["body.p"]
    assert result["body.f"] == pytest.approx(0.0032 * p / np.sqrt(1 + (p / 26) ** 2) + 0.00032 * p)
    supplied = np.abs(result["energy.supplied"]).max()
    np.testing.assert_allclose(result["energy.residual"], 0, atol=1e-6 * supplied)


def test_flows_that_close_a_projected_chain_are_kept(tmp_path: Path) -> None:
    """One of them alone would be moved (BG546, `wrong/chain_that_moves_a_given_flow.bg`)."""
    wrong = Path(__file__).parents[1] / "wrong" / "chain_that_moves_a_given_flow.bg"
    text = wrong.read_text().replace("mass_y : I(2 kg)", "mass_y : I(2 kg, f0 = 0.75 m/s)")
    path = tmp_path / "pendulum.bg"
    path.write_text(text)
    start = bgc.compile(path).observe()
    assert list(start.values()) == pytest.approx([1, 0.75], rel=1e-12)


def test_rounded_angles_that_closing_a_chain_moves_are_named(load) -> None:
    """All four angles are given: in four digits they are moved and named, in fifteen kept."""
    model = load("closed_chains", "four_bar")
    begin = dict(zip((s.name for s in model.states), model.initial_state(), strict=True))
    angles = {f"{name}.angle0": begin[f"{name}.angle"] for name in ("pin2", "pin3", "pin4")}
    exact = model.simulate(1e-3, parameters=angles)
    assert not exact.warnings
    rounded = {name: round(angle, 4) for name, angle in angles.items()}
    result = model.simulate(1e-3, parameters=rounded)
    (warning,) = result.warnings
    shown = "moves initial values that are given: `pin4.angle0` by -2.44e-05 rad, `pin1.angle0` by"
    assert warning.code == "BG551" and shown in warning.message
    with pytest.raises(bgc.BgError, match="BG736"):
        model.simulate(1e-3, parameters=angles | {"pin2.angle0": angles["pin2.angle0"] + 0.1})


def test_rounded_positions_of_a_model_are_named_where_it_is_compiled(tmp_path: Path) -> None:
    """Exports therefore name them too; a run does not say it again, and a start at rest not."""
    wrong = Path(__file__).parents[1] / "wrong" / "chain_that_moves_a_given_flow.bg"
    text = wrong.read_text().replace("mass_y : I(2 kg)", "mass_y : I(2 kg, f0 = 0.75 m/s)")
    text = text.replace("-0.8 m", "-0.80005 m")
    path = tmp_path / "pendulum.bg"
    path.write_text(text)
    model = bgc.compile(path)
    (warning,) = model.warnings
    assert warning.code == "BG551"
    assert warning.message.endswith("`y` by 3.2e-05 m, `x` by -2.4e-05 m")
    assert not model.simulate(1e-3).warnings
    path.write_text(text.replace("run 1 s;", "start rest; run 1 s;"))
    assert not compile_scene(path, Options(), until="equations").warnings
