"""Starts at rest, against closed forms of the equilibrium."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from model_files import model_text
from refusals import refusal
from scipy.optimize import brentq

import bgc
from bgc.elaboration.elaborate import elaborate
from bgc.resolution.library import library_folder
from bgc.resolution.resolve import load_text
from bgc.runtime.cli.app import application
from bgc.runtime.model import Model
from bgc.runtime.results.summary import summarise
from bgc.runtime.running import relations
from bgc.runtime.running.relations import orthonormal
from bgc.runtime.running.rest_equations import RestEquations
from bgc.runtime.running.structures import Status

Load = Callable[[str, str | None], Model]

SAG = 2 * 9.81 / 100
SCENES = library_folder() / "scenes"
CRANES = SCENES / "two_beam_crane.bg"


def test_the_spring_takes_the_weight_and_the_place_follows(load: Load) -> None:
    model = load("rest", "hanging")
    result = model.simulate()
    for name, value in (("stretch", SAG), ("place", 5 + SAG), ("across", 0.3), ("momentum", 0)):
        np.testing.assert_allclose(result[name], value, atol=1e-12)
    assert result["energy.residual"][0] == 0
    found = result.at_rest
    assert found is not None and found.residual < 1e-12
    assert {move.name for move in found.moves} == {"spring.q", "place"}
    assert [m.after - m.before for m in found.moves] == pytest.approx([SAG, SAG])
    assert model.initial_state() == pytest.approx([*_state(model, result)])


def _state(model: Model, result) -> list[float]:
    known = {"spring.q": SAG, "place": 5 + SAG, "across": 0.3}
    return [known.get(state.name, 0.0) for state in model.states]


def test_rest_follows_parameters_of_a_run(load: Load) -> None:
    result = load("rest", "hanging").simulate(parameters={"m": 5, "across0": 7})
    assert result["stretch"][-1] == pytest.approx(5 * 9.81 / 100)
    assert result["across"][-1] == 7


def test_a_start_is_chosen_for_a_run(load: Load) -> None:
    given = load("rest", "hanging").simulate(start="given")
    assert given["stretch"][0] == 0 and given.at_rest is None
    swinging = load("settling", "hanger")
    assert swinging.simulate(1e-3, start="rest")["place"][0] == pytest.approx(2 * 9.81 / 40)
    with pytest.raises(bgc.BgError, match="BG066"):
        swinging.simulate(1e-3, start="standing")


def test_a_value_is_held_by_a_parameter(load: Load) -> None:
    result = load("rest", "held").simulate()
    np.testing.assert_allclose(result["stretch"], 0, atol=1e-12)
    assert result["place"][-1] == pytest.approx(5)
    (pull,) = result.at_rest.varied
    assert (pull.name, pull.unit, pull.before) == ("pull", "N", 0)
    assert pull.after == pytest.approx(-2 * 9.81)


def test_an_initial_value_is_varied_so_that_the_rest_stays(load: Load) -> None:
    result = load("rest", "stretched").simulate()
    assert result["stretch"][-1] == pytest.approx(SAG)
    assert result["place"][-1] == pytest.approx(5)
    (stretch,) = result.at_rest.varied
    assert stretch.after == pytest.approx(SAG)


def test_what_is_conserved_without_momentum_is_kept(load: Load) -> None:
    result = load("rest", "levels").simulate()
    np.testing.assert_allclose(result["first"], 2, rtol=1e-12)  # 3 shared by 2 and 1
    np.testing.assert_allclose(result["second"], 1, rtol=1e-12)


def test_a_large_nonlinear_move(load: Load) -> None:
    result = load("rest", "torsion").simulate(start="rest")
    angle = brentq(lambda a: 20 * np.cos(a) - 30 * a, 0, 2)
    np.testing.assert_allclose(result["angle"], angle, rtol=1e-10)
    np.testing.assert_allclose(result["twist"], angle, rtol=1e-10)


@pytest.mark.parametrize(
    ("scene", "given", "x"),
    [
        ("sliding", {"x0": 1e-3}, 3.0),
        ("sliding", {"x0": 5.0, "pull": 3.0}, 0.3),
        ("sliding_pulled", {}, 2.0),
        ("sliding_placed", {"x0": 0.5}, 3.0),
    ],
)
def test_a_relation_that_is_not_linear_holds_after_a_long_way(load, scene, given, x) -> None:
    """From 5 m to 0.3 m, say, and where a parameter moves the start along the relation."""
    result = load("rest", scene).simulate(parameters=given)
    np.testing.assert_allclose(result["x"], x, rtol=1e-9)
    np.testing.assert_allclose(result["stretch"], np.sqrt(x**2 + 1), rtol=1e-10)


def test_what_has_no_rate_at_the_start_takes_part_in_relations(load: Load) -> None:
    result = load("rest", "turned").simulate()
    angle = 1.5
    np.testing.assert_allclose(result["angle"], angle, rtol=1e-12)
    half = [np.cos(angle / 2), np.sin(angle / 2)]
    np.testing.assert_allclose(result["h"], np.tile(half, (len(result.time), 1)), rtol=1e-11)


def test_a_relation_holds_beside_others_that_hardly_move(load: Load) -> None:
    """The rates of two states are 1e-14 of the others: they must not spoil the third relation."""
    result = load("rest", "sliding_wheels").simulate()
    np.testing.assert_allclose(result["x"][0], 3, rtol=1e-9)
    np.testing.assert_allclose(result["stretch"][0], np.sqrt(10), rtol=1e-10)
    np.testing.assert_allclose(result["first"][0], [1, 0], atol=1e-12)
    np.testing.assert_allclose(result["second"][0], [1, 0], atol=1e-12)


def test_a_basis_of_columns_whose_rows_differ_in_size() -> None:
    """The third column differs from the others only beside their large entries."""
    small = np.array([1, 1 / 3, 0.7])
    large = 1e13 * np.array([[3, 1, 2 / 3], [1, -2, 0.1]])
    basis = orthonormal(np.vstack([np.outer(small, [1, 0.2, 3]), large]))
    np.testing.assert_allclose(basis.T @ basis, np.eye(3), atol=1e-14)
    found = basis[:3] @ basis[:3].T  # the projection onto `small`
    np.testing.assert_allclose(found, np.outer(small, small) / (small @ small), atol=1e-14)
    depends = orthonormal(np.array([[1.0, 2.0], [1.0, 2.0]]))
    np.testing.assert_allclose(np.abs(depends[:, 0]), np.sqrt(0.5))


def test_speeds_of_the_start_do_not_steer_the_search(load: Load) -> None:
    """The pendulum hangs where it stopped, not a turn further: nothing restores the shaft."""
    result = load("rest", "whirling").simulate()
    for name, value in (("angle", 0.0), ("turn", 0.3), ("spin", 0.0)):
        np.testing.assert_allclose(result[name], value, atol=1e-12)


def test_sampled_parts_rest_with_the_states(load: Load) -> None:
    result = load("rest", "controlled").simulate()
    for name, value in (("place", 0.01), ("speed", 0.0), ("force", 30.0), ("sum", 30.0)):
        np.testing.assert_allclose(result[name], value, rtol=1e-11, atol=1e-14)
    assert result.at_rest is not None
    assert {"spring.q", "sum", "force"} == {move.name for move in result.at_rest.moves}
    # 20 N = 1 kN/m * -x + 500 N/m * (wanted - x) with x = wanted: the sum is at rest.
    held = load("rest", "controlled_sum").simulate()
    np.testing.assert_allclose(held["place"], -0.02, rtol=1e-9)
    np.testing.assert_allclose(held["wanted"], -0.02, rtol=1e-9)


def test_programs_in_c_start_with_sampled_values(load: Load) -> None:
    """FMUs and pages in a browser call `bgc_restart_at` with the values that were found."""
    instance = load("rest", "controlled").instance_at(None, 0.0)
    found = instance.start_values()
    assert instance.reset(0.0) is Status.OK and not instance.start_values().any()
    functions, model = instance.library.functions, instance.library.pointer
    doubles = found.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
    assert functions.bgc_restart_at(model, ctypes.c_void_p(instance._data), doubles) == 0
    np.testing.assert_array_equal(instance.start_values(), found)
    np.testing.assert_allclose(instance.rhs()[1], 0, atol=1e-12)


def test_sources_have_their_first_values(load: Load) -> None:
    assert load("rest", "blown").simulate()["stretch"][0] == pytest.approx(0.4)


def test_without_a_rest_the_rates_that_remain_are_named(load: Load) -> None:
    model = load("rest", "falling")
    diagnostic = refusal(model.simulate)
    assert diagnostic.code == "BG760"
    assert "`mass.p` changes by 13.08 N (nothing balances it)" in diagnostic.message
    ensemble = model.simulate_many({"pull": [0.0, -2 * 9.81]}, 1.0)
    assert ensemble.status == ("failed", "done")
    assert ensemble.failures[0].code == "BG760"


def test_a_rest_that_tears_positions_apart_is_none(load: Load) -> None:
    """Place 3.4 m and stretch 6.3 m would balance, but the one is the other and 4 m."""
    with pytest.raises(bgc.BgError, match=r"BG760.*`mass.p` changes by"):
        load("rest", "pushed").simulate()


def test_a_held_value_that_allows_no_rest(load: Load, tmp_path: Path) -> None:
    path = tmp_path / "a.bg"
    source = Path(__file__).parents[1] / "models" / "rest.bg"
    path.write_text(source.read_text().replace("hold spring.q vary pull", "hold spring.q"))
    with pytest.raises(bgc.BgError, match="BG761"):
        bgc.compile(path, "held").simulate()


def test_the_summary_reports_the_start(load: Load) -> None:
    text = summarise(load("rest", "held").simulate())
    assert "starts at rest, rates are zero to" in text
    assert "pull = -19.62 N, given as 0" in text
    text = summarise(load("rest", "hanging").simulate())
    assert "moved" in text and "given values that moved: spring.q by 0.1962 m, place by" in text


def test_the_command_line_starts_at_rest() -> None:
    file = Path(__file__).parents[1] / "models" / "settling.bg"
    done = CliRunner().invoke(
        application, ["run", str(file), "--scene", "hanger", "--rest", "--time", "1 ms"]
    )
    assert done.exit_code == 0 and "starts at rest" in done.output


def test_an_inherited_start_loses_the_paths_of_removed_parts() -> None:
    text = (
        "interface L { port p in; }\n"
        "model A is L { port p in; c : C(1, q0 = 1); r : R(1); j : J1; p -> j -> c, r; }\n"
        "model B is L { port p in; i : I(1); p -> i; }\n"
        "model M { param v = 1; s : Se(v); k : C(2); r : R(1); j : J1; x : L = A;\n"
        "  s -> j -> k, r, x; }\n"
        "scene a of M { start rest hold x.c.q, k.q vary v; observe k.q; run 1 s; }\n"
        "scene b is a { use x = B; }\n"
        "scene c is a { start rest; }\n"
    )
    package = load_text(text)
    rests = [elaborate(package, scene).scene.rest for scene in ("a", "b", "c")]
    assert [(r.hold, r.vary) for r in rests if r is not None] == [
        (("x.c.q", "k.q"), ("v",)),
        (("k.q",), ("v",)),
        ((), ()),
    ]


def test_instances_of_an_ensemble_start_at_rest(load: Load) -> None:
    masses = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0]
    ensemble = load("rest", "hanging").simulate_many({"m": masses}, 1.0)
    assert ensemble["stretch"][:, -1] == pytest.approx(np.array(masses) * 9.81 / 100)


def test_linear_models_are_taken_at_rest(load: Load) -> None:
    model = load("rest", "torsion")
    angle = brentq(lambda a: 20 * np.cos(a) - 30 * a, 0, 2)
    slope = 20 * np.sin(angle) + 30
    pairs = [v for v in model.linearise().eigenvalues() if abs(v) > 1e-3]
    assert np.abs(pairs) == pytest.approx(np.sqrt(slope / 2) * np.ones(2), rel=1e-9)


@pytest.mark.parametrize("scene", ["two_beam_crane", "telescopic"])
def test_the_crane_floats_at_rest(scene: str) -> None:
    """Nothing moves while the hand does not; the vessel carries the weight of the crane."""
    model = bgc.compile(CRANES, scene=scene)
    state = dict(zip((s.name for s in model.states), model.initial_state(), strict=True))
    mass = 20e3 if scene == "two_beam_crane" else 19e3
    weights = {"two_beam_crane": 6e3 + 8e3 + 4e3 + 2e3, "telescopic": 6e3 + 7e3 + 4e3 + 2e3}
    assert mass == weights[scene]
    q = [state[f"vessel.restoring.q[{k}]"] for k in (1, 2, 3)]
    G = [model.parameters[f"vessel.G[1,{k}]"].value for k in (1, 3)]
    assert G[0] * q[0] + G[1] * q[2] == pytest.approx(-mass * 9.81, rel=1e-6)
    assert state["vessel.pose.r[3]"] == pytest.approx(state["vessel.restoring.q[1]"], rel=1e-9)
    roll = 2 * np.arctan2(state["vessel.pose.attitude.h[2]"], state["vessel.pose.attitude.h[1]"])
    assert roll == pytest.approx(state["vessel.restoring.q[2]"], rel=1e-4)
    assert [state[f"vessel.pose.r[{k}]"] for k in (1, 2)] == pytest.approx([0, 0], abs=1e-9)
    assert state["crane.pedestal.angle"] == pytest.approx(np.pi / 2, abs=1e-6)
    rates = model.rhs()
    scales = model.instance_at(None, 0.0).scale
    assert np.abs(rates / scales).max() < 1e-9
    result = model.simulate(1.0)
    assert np.ptp(result["tip_height"]) < 1e-9  # the hand stays within the dead band
    assert np.abs(result["energy.residual"]).max() < 1e-6


@pytest.mark.parametrize("scene", ["four_bar", "tilted"])
def test_a_closed_chain_comes_to_rest_closed(load: Load, scene: str) -> None:
    """The linkage stays closed, and its potential energy is stationary: no virtual work."""
    model = load("closed_chains", scene)
    result = model.simulate(0.5, start="rest")
    assert result.at_rest is not None and result.at_rest.moves
    for name, column in result.columns.items():
        if name != "energy.residual":
            assert np.ptp(column) < 1e-6 * (1 + np.abs(column).max()), name


def test_what_nothing_moves_stays_to_the_last_bit(tmp_path: Path) -> None:
    """A counter of jumps beside a body that a sampled force and its weight move to its rest."""
    path = tmp_path / "a.bg"
    path.write_text("""
model Body {
  joint : J1;
  mass : I(2 kg);
  spring : C(stiffness = 50 N/m);
  damper : R(4 kg/s);
  weight : MSe(e = u * 1 N - 19.62 N);
  weight -> joint;
  joint -> mass, spring, damper;
  sample 0.1 s { state level = 0; output u = 0.2*level; next(level) = 0.5*level + 1; }
  state hits = 0;
  der(hits) = 0;
  when spring.q > -0.1 m { reset hits = hits + 1; }
  output rounds = floor(hits);
}
scene s of Body { observe hits, rounds, spring.q as q; start rest; run 0.1 s every 0.1 s; }
""")
    result = bgc.compile(path).simulate()
    assert result["hits"].tolist() == result["rounds"].tolist() == [0.0, 0.0]
    np.testing.assert_allclose(result["q"], (0.2 * 2 - 19.62) / 50, rtol=1e-9)


def test_a_held_joint_keeps_its_angle(tmp_path: Path) -> None:
    path = CRANES.parent / "held_for_a_test.bg"
    text = CRANES.read_text().replace(
        "vary handle.stretch0", "hold crane.pedestal.angle, crane.shoulder.angle, crane.elbow.angle"
    )
    copy = tmp_path / path.name
    trace = (library_folder() / "traces" / "up_down_up.csv").as_posix()
    copy.write_text(text.replace("../traces/up_down_up.csv", trace))
    model = bgc.compile(copy)
    state = dict(zip((s.name for s in model.states), model.initial_state(), strict=True))
    angles = [state[f"crane.{j}.angle"] for j in ("pedestal", "shoulder", "elbow")]
    np.testing.assert_allclose(np.degrees(angles), [90, 45, -60], rtol=1e-11)
    assert state["handle.spring.q[3]"] == pytest.approx(-0.0490465, rel=1e-4)


def test_a_pump_opens_the_relief_valve_behind_a_long_line(tmp_path: Path, monkeypatch) -> None:
    """A given flow fills 24 volumes up to a valve; the path to rest must not jump to and fro.

    At rest the flow and the friction of the line are those of the formulas, found in few
    decompositions: the search took 575, and found nothing.
    """
    path = tmp_path / "a.bg"
    path.write_text("""
import hydraulics.lines; import hydraulics.volumes; import hydraulics.restrictions;
model Relief {
  pump : Sf(10 L/min);
  n : J0; line : LumpedLine[24](length = 50 m);
  relief : ReliefValve; tank : Tank;
  pump -> n; n -> line -> relief -> tank;
}
scene s of Relief { start rest; observe line.filling[1].e as first, relief.a.P as last; run 1 ms; }
""")
    model = bgc.compile(path, preview=True)
    svd, calls = np.linalg.svd, []

    def counted(*args, **kwargs):
        calls.append(1)
        return svd(*args, **kwargs)

    monkeypatch.setattr(np.linalg, "svd", counted)
    result = model.simulate()
    assert result.at_rest is not None and result.at_rest.residual < 1e-15 and len(calls) < 100
    assert result.at_rest.tipped == ("relief.seat",)
    flow, area = 10e-3 / 60, np.pi / 4 * 0.02**2
    laminar = (
        32 * 3.2e-5 * 900 * 50 / 0.02**2 * flow / area
    )  # of Hagen and Poiseuille; the law blends into turbulence
    assert result["first"][0] - result["last"][0] == pytest.approx(laminar, rel=2e-3)
    share = brentq(lambda p: (p - 350) / 20 * 240 * np.sqrt(p / 370) - 10, 350, 370)
    assert result["last"][0] == pytest.approx(share * 1e5, rel=1e-5)


def test_a_way_that_is_not_followed_to_its_end_is_an_error(load: Load, monkeypatch) -> None:
    """The point half-way there would put a spring and its ends at different places."""
    monkeypatch.setattr(relations, "_LONGEST_PATH", 1)
    with pytest.raises(bgc.BgError) as caught:
        load("rest", "sliding").simulate(parameters={"x0": 5.0, "pull": 3.0})
    assert caught.value.diagnostics[0].code == "BG773"


TWO_LINKS = model_text("rest_two_links")


def test_a_stiff_lock_does_not_hide_what_soft_servos_carry(tmp_path: Path) -> None:
    """Servos carry the slope of the potential energy, computed here by rotations.

    The lock's damping makes rows of both links 1e10, and steps short that balance 2 N m there.
    The tool's centre lies 5 cm beyond the flange.
    """
    path = tmp_path / "held.bg"
    path.write_text(TWO_LINKS)
    result = bgc.compile(path).simulate(0.01)

    def turned(angle: float) -> np.ndarray:
        c, s = np.cos(angle), np.sin(angle)
        return np.array([[c, -s, 0], [0, 0, -1], [s, c, 0]])

    def energy(first: float, second: float) -> float:
        one = turned(first)
        two = one @ turned(second)
        elbow = one @ [0.3, 0, 0]
        moments = 3 * (one @ [0.1, 0.05, 0.02]) + 1.2 * (elbow + two @ [0.05, 0.1, -0.04])
        return float(9.81 * (moments + elbow + two @ [0, 0, 0.15])[2])

    d = 1e-5
    carried = [
        (energy(0.3 + d, 0.5) - energy(0.3 - d, 0.5)) / (2 * d),
        (energy(0.3, 0.5 + d) - energy(0.3, 0.5 - d)) / (2 * d),
    ]
    for k, angle in enumerate([0.3, 0.5]):
        assert result[f"q[{k + 1}]"] == pytest.approx(angle, abs=1e-9)
        assert result[f"torque[{k + 1}]"] == pytest.approx(carried[k], abs=1e-6)


@pytest.mark.parametrize("load_of_rod", [1e4, 1e5, 2e5, 4e5])
@pytest.mark.parametrize("given", [{}, {"extension0": 0.3}, {"back0": 80e5}, {"expected": 2e5}])
def test_trapped_oil_carries_the_load_and_given_values_stay(
    load: Load, load_of_rod: float, given: dict[str, float]
) -> None:
    """Of a cylinder with shut valves, the pressure of the bore follows from the balance."""
    result = load("held_rod", "held").simulate(parameters={"load": load_of_rod, **given})
    area, ring = np.pi / 4 * 0.4**2, np.pi / 4 * (0.4**2 - 0.3**2)
    back = given.get("back0", 50e5)
    assert result["extension"][0] == pytest.approx(given.get("extension0", 1.2), rel=1e-12)
    assert result["back"][0] == pytest.approx(back, rel=1e-9)
    carried = area * result["bore"] - ring * result["ring"]
    np.testing.assert_allclose(carried, load_of_rod, rtol=1e-8)
    assert result.at_rest is not None and not result.at_rest.given
    free = {free.name: free.fixed for free in result.at_rest.free}
    assert [free.pop(f"axis.cylinder.chambers.q[{k}]") for k in (2, 3)] == ["kept", "kept"]
    assert "kept" not in free.values()


def test_slopes_by_differences_are_found_far_from_zero(tmp_path: Path) -> None:
    """Steps of differences grow with the state, or its rounding hides them.

    Those of a held value, and of what the next instant gives a sampled part.
    """
    path = tmp_path / "far.bg"
    path.write_text("""
model Far { slider : I(2); drag : R(1); side : J1; side -> slider, drag;
  state across = 1e11; der(across) = side.f; output twice = 2*across;
  sample 0.1 s { state level = 0; next(level) = 2*across; } }
scene s of Far { start rest hold twice; observe twice, level; run 1 s; }
""")
    model = bgc.compile(path)
    instance = model.parameters.instance({})
    instance.reset()
    equations = RestEquations(instance, model.facts.rest)
    slopes, _ = equations.slopes(equations.start)
    across = [state.name for state in model.states].index("across")
    scale, size = equations.scale[across], equations.scale[equations.size - 1]
    assert slopes[-1, across] == pytest.approx(2 * scale, rel=1e-9)
    assert slopes[equations.size - 1, across] == pytest.approx(2 / 0.1 * scale / size, rel=1e-9)


def test_what_nothing_reads_does_not_lead_the_search(tmp_path: Path) -> None:
    """Tanks at rest up to a difference of 1 Pa are equalised as if nothing counted the flow."""
    path = tmp_path / "counted.bg"
    path.write_text("""
model Tanks { param gain = 0;
  high : C(compliance = 1, q0 = 5); low : C(compliance = 2); side : J1; up : J0; down : J0;
  valve : R { f = max(e - 1, 0); }
  up -> high; up -> side; side -> valve; side -> down -> low;
  state counted = 0; der(counted) = gain*side.f; }
scene s of Tanks { keep gain; start rest; observe high.q, low.q, counted; run 1 s; }
""")
    model = bgc.compile(path)
    plain, counted = (model.simulate(parameters={"gain": gain}) for gain in (0.0, 1e6))
    for name in ("high.q", "low.q"):
        assert counted[name] == pytest.approx(plain[name], rel=1e-9)
    assert plain["high.q"][0] + plain["low.q"][0] == pytest.approx(5)


def test_oil_between_valves_stays_near_its_start(monkeypatch) -> None:
    """A step along the oil of one line that would open a valve is taken up to the valve.

    The search took 706 decompositions and left the oil of the feed at 5e-5 m^3 from its start.
    """
    model = bgc.compile(SCENES / "knuckle_boom_hydraulic.bg", scene="knuckle_boom_hydraulic")
    calls = []
    for name in ("svd", "solve"):
        function = getattr(np.linalg, name)

        def counted(*args, function=function, **kwargs):
            calls.append(1)
            return function(*args, **kwargs)

        monkeypatch.setattr(np.linalg, name, counted)
    found = model.simulate(1e-3).at_rest
    assert found is not None and found.residual < 1e-15 and len(calls) < 600
    assert max(abs(m.after - m.before) for m in found.moves if "feed_oil" in m.name) < 1e-5


def test_a_brake_that_slips_is_named(tmp_path: Path) -> None:
    """A load of 9.81 kN on a brake: it holds 20 kN, slips beyond 5 kN, or gives 5 kN at most."""
    path = tmp_path / "drum.bg"
    path.write_text("""
model Hoist {
  param hold : N = 20 kN;
  load : I(1000 kg); gravity : Se(e = 9810 N); n : J1; split : J0; wire : C(1e-6 m/N);
  brake : R { f = (max(e - hold, 0 N) + min(e + hold, 0 N))*1e-3 m/N/s; }
  gravity -> n; n -> load; n -> split; split -> wire; split -> brake;
}
model Drum {
  load : I(1000 kg); gravity : Se(e = 9810 N); n : J1;
  brake : R { e = min(max(f*1e6 N*s/m, -5 kN), 5 kN); }
  gravity -> n; n -> load; n -> brake;
}
scene hoist of Hoist { start rest; observe load.f; run 1 s; }
scene drum of Drum { start rest; observe load.f; run 1 s; }
""")
    hoist = bgc.compile(path, scene="hoist", preview=True)
    held = hoist.simulate().at_rest
    slipping = hoist.simulate(parameters={"hold": 5e3})
    assert held is not None and held.tipped == ()
    assert slipping.at_rest is not None and slipping.at_rest.tipped == ("brake",)
    assert slipping["load.f"][0] == pytest.approx(4.81)
    assert "switched on the way to rest: brake" in summarise(slipping)
    with pytest.raises(bgc.BgError, match="BG760") as refused:
        bgc.compile(path, scene="drum", preview=True).simulate()
    assert refused.value.diagnostics[0].note.startswith("`brake` has given way")
