"""Sensitivities of a run: against closed formulas, and differences at fixed steps."""

from functools import cache

import numpy as np
import pytest
from click.testing import CliRunner
from model_files import model_file
from scipy.linalg import expm, expm_frechet

import bgc
from bgc.runtime.cli.app import application


@cache
def model(scene: str) -> bgc.Model:
    return bgc.compile(model_file("sensitivities"), scene=scene)


def run(scene: str, names: list[str], **options) -> bgc.Result:
    return model(scene).simulate(error=False, sensitivities=names, **options)


def difference(scene: str, name: str, column: str, part: float = 1e-3, **options) -> np.ndarray:
    """A difference of order 4 at the steps of the run."""
    value = model(scene).parameters[name].value

    def at(factor: float) -> np.ndarray:
        changed = {name: value * (1 + factor * part)}
        return model(scene).simulate(error=False, parameters=changed, **options)[column]

    return (8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * part * value)


# --- an oscillator ---------------------------------------------------------------------------

MASS, STIFFNESS = 2.0, 50.0


def oscillator(time: np.ndarray, change: dict[str, float]) -> np.ndarray:
    """The derivatives of (q, f) along a direction of mass, stiffness, damping, speed and q0."""
    damping = 0.02 * STIFFNESS
    matrix = np.array([[0.0, 1.0], [-STIFFNESS / MASS, -damping / MASS]])
    m, k, b = (change.get(name, 0.0) for name in ("mass", "stiffness", "damping"))
    by_mass = np.array([STIFFNESS, damping]) * m / MASS**2
    moved = np.array([[0.0, 0.0], by_mass - np.array([k, b]) / MASS])
    start = np.array([0.1, 0.5])
    other = np.array([change.get("q0", 0.0), change.get("speed", 0.0)])
    return np.array(
        [expm_frechet(matrix * t, moved * t)[1] @ start + expm(matrix * t) @ other for t in time]
    )


@pytest.mark.parametrize(
    ("name", "change"),
    [
        ("mass", {"mass": 1}),
        ("stiffness", {"stiffness": 1, "damping": 0.02}),  # the damping follows it
        ("damping", {"damping": 1}),
        ("speed", {"speed": 1}),
        ("spring.q", {"q0": 1}),
    ],
)
@pytest.mark.parametrize("solver", ["rodas5p", "switching"])
def test_derivatives_of_an_oscillator(name, change, solver):
    result = run("oscillator", [name], solver=solver, rtol=1e-10)
    exact = oscillator(result.time, change)
    for column, expected, factor in (("spring.q", exact[:, 0], 1), ("speed", exact[:, 1], 1e3)):
        found = result.sensitivity(column, name)
        assert found == pytest.approx(expected * factor, abs=2e-8 * factor * np.abs(expected).max())


def test_a_parameter_that_is_set_follows_no_other():
    given = {"damping": 1.0}
    result = run("oscillator", ["stiffness"], parameters=given, rtol=1e-10)
    exact = oscillator(result.time, {"stiffness": 1})[:, 0]
    assert result.sensitivity("spring.q", "stiffness") == pytest.approx(exact, abs=1e-10)


@pytest.mark.parametrize("solver", ["ros34prw", "rodas5p", "rodas4p2", "ros23", "lie", "rk4"])
def test_derivatives_are_those_of_the_computed_steps(solver):
    """At steps so long that the solution itself is off, derivatives agree with differences."""
    options = {"solver": solver, "step": 0.05} if solver != "rodas4p2" else {"solver": solver}
    if solver == "rodas5p":
        options = {"solver": solver, "rtol": 1e-11}
    result = run("oscillator", ["mass", "stiffness"], **options)
    tolerance = 1e-9 if "step" in options else 1e-5
    for name in ("mass", "stiffness"):
        expected = difference("oscillator", name, "spring.q", **options)
        size = np.abs(expected).max()
        assert result.sensitivity("spring.q", name) == pytest.approx(expected, abs=tolerance * size)


def test_rows_are_those_of_a_run_without():
    plain = model("oscillator").simulate()
    result = model("oscillator").simulate(sensitivities=["mass"])
    for column in plain:
        assert np.array_equal(plain[column], result[column])
    assert {**plain.errors}.keys() == {**result.errors}.keys()


def test_units_names_and_columns_of_derivatives():
    result = run("oscillator", ["mass", "stiffness"])
    assert result.sensitivity_unit("spring.q", "mass") == "m/kg"
    assert result.sensitivity_unit("speed", "stiffness") == "mm/s/(N/m)"
    wide = result.with_sensitivities()
    assert wide.units["d spring.q/d mass"] == "m/kg"
    assert np.array_equal(wide["d spring.q/d mass"], result.sensitivity("spring.q", "mass"))
    assert [*wide][:3] == [*result]
    with pytest.raises(bgc.BgError, match="BG065"):
        result.sensitivity("energy.stored", "mass")
    with pytest.raises(bgc.BgError, match="BG060"):
        result.sensitivity("spring.q", "damping")


# --- algebraic equations ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "tolerance"),
    [({"rtol": 1e-9}, 1e-7), ({"solver": "rk4", "step": 0.01}, 1e-5)],
)
def test_derivatives_through_an_algebraic_loop_and_its_event(options, tolerance):
    names = ["load", "capacity", "opens"]
    result = run("loop", names, **options)
    for name in names:
        for column in ("first.f", "store.e"):
            expected = difference("loop", name, column, **options)
            size = np.abs(expected).max()
            found = result.sensitivity(column, name)
            assert size > 0 and found == pytest.approx(expected, abs=tolerance * size)


# --- closed chains ---------------------------------------------------------------------------


def test_derivatives_on_a_constraint_through_a_jump_across_it():
    names = ["pull", "mass", "moved", "edge"]
    result = run("skate", names, rtol=1e-10)
    for name in names:
        for column in ("x", "y", "u"):
            expected = difference("skate", name, column, rtol=1e-11)
            size = np.abs(expected).max()
            assert result.sensitivity(column, name) == pytest.approx(expected, abs=1e-6 * size)


def test_derivatives_of_a_linkage_and_of_its_closed_start():
    """The crank is 1 m, the chain is closed by the angles that nothing sets."""
    linkage = bgc.compile(
        model_file("sensitivities").parents[1] / "closed_chains.bg", scene="four_bar"
    )
    options = {"error": False, "duration": 0.8}
    result = linkage.simulate(sensitivities=["crank_length"], **options)
    step = 1e-4
    above, below = (
        linkage.simulate(parameters={"crank_length": 1 + sign * step}, **options)
        for sign in (1, -1)
    )
    for column in ("a", "b", "c"):
        expected = (above[column] - below[column]) / (2 * step)
        size = np.abs(expected).max()
        found = result.sensitivity(column, "crank_length")
        assert np.abs(found[0]) > 0 or column == "a"
        assert found == pytest.approx(expected, abs=2e-6 * size)


# --- sampled parts ---------------------------------------------------------------------------


def test_derivatives_through_a_sampled_controller_and_its_instants():
    names = ["wanted", "gain", "first", "period", "late"]
    result = run("sampled", names, rtol=1e-9)
    for name in names:
        for column in ("place", "speed", "sum"):
            expected = difference("sampled", name, column, rtol=1e-10)
            size = np.abs(expected).max()
            assert result.sensitivity(column, name) == pytest.approx(expected, abs=1e-6 * size)


def test_derivatives_of_a_sampled_controller_at_rest():
    """The spring carries what its law gives at the wanted place, and the integral the rest."""
    result = run("sampled_rest", ["wanted", "load"], rtol=1e-9)
    stiffness = 1000 + 3e6 * 0.01**2
    for column, name, expected in [
        ("place", "wanted", 1.0),
        ("sum", "wanted", stiffness),
        ("place", "load", 0.0),
        ("sum", "load", 1.0),
    ]:
        assert result.sensitivity(column, name) == pytest.approx(expected, rel=1e-6, abs=1e-9)


def test_derivatives_where_the_inputs_of_a_device_make_states_jump():
    names = ["load", "kept"]
    result = run("handled", names, rtol=1e-9)
    for name, column in (("load", "y"), ("load", "first.f"), ("kept", "y")):
        expected = difference("handled", name, column, rtol=1e-10)
        size = np.abs(expected).max()
        assert result.sensitivity(column, name) == pytest.approx(expected, abs=1e-7 * size)


# --- events and starts -----------------------------------------------------------------------


def ball(time: np.ndarray, height: complex, kept: complex, gravity: complex) -> np.ndarray:
    first = np.sqrt(2 * height / gravity)
    later = time - first
    free = height - gravity * time**2 / 2
    return np.where(later.real < 0, free, kept * gravity * first * later - gravity * later**2 / 2)


@pytest.mark.parametrize("name", ["height", "kept", "gravity"])
def test_derivatives_through_a_bounce(name):
    result = run("ball", ["height", "kept", "gravity"], rtol=1e-9)
    given = {"height": 1.0, "kept": 0.8, "gravity": 9.81}
    expected = ball(result.time, **{**given, name: given[name] + 1e-30j}).imag / 1e-30
    assert result.sensitivity("z", name) == pytest.approx(expected, abs=1e-9)


def test_derivatives_through_a_jump_that_causes_another():
    names = ["speed", "gap", "kept"]
    result = run("carts", names, rtol=1e-9)
    for name in names:
        for column in ("a", "b", "v", "w"):
            expected = difference("carts", name, column, rtol=1e-11)
            size = np.abs(expected).max()
            assert result.sensitivity(column, name) == pytest.approx(expected, abs=1e-7 * size)


def test_derivatives_by_the_time_of_a_switch():
    result = run("pushed", ["begin", "force"])
    after = result.time > 0.505
    assert result.sensitivity("mass.f", "begin") == pytest.approx(
        np.where(after, -1.5, 0), abs=1e-12
    )
    expected = np.where(after, (result.time - 0.505) / 2, 0)
    assert result.sensitivity("mass.f", "force") == pytest.approx(expected, abs=1e-12)


def test_derivatives_begin_with_those_of_the_start_at_rest():
    """The spring carries m g at rest, and the position z follows its stretch."""
    result = run("hung", ["mass", "stiffness", "free"], rtol=1e-10)
    carried = {"mass": -9.81 / 50, "stiffness": 2 * 9.81 / 50**2, "free": 1.0}
    for name, expected in carried.items():
        assert result.sensitivity("spring.q", name)[0] == pytest.approx(expected, rel=1e-9)
        assert result.sensitivity("z", name)[0] == pytest.approx(-expected, rel=1e-7)
        found = difference("hung", name, "spring.q", rtol=1e-11)
        size = np.abs(found).max()
        assert result.sensitivity("spring.q", name) == pytest.approx(found, abs=1e-7 * size)


@pytest.mark.parametrize(
    ("scene", "names", "options", "code"),
    [
        ("grazing", ["top"], {}, "BG785"),
        ("together", ["top"], {}, "BG786"),
        ("oscillator", ["mass"], {"solver": "radau5"}, "BG784"),
        ("oscillator", ["mass"], {"settle": 10.0}, "BG784"),
        ("hung", ["spring.q"], {}, "BG784"),
        ("oscillator", ["masses"], {}, "BG060"),
    ],
)
def test_what_has_no_derivative_is_refused(scene, names, options, code):
    with pytest.raises(bgc.BgError, match=code):
        run(scene, names, **options)


def test_a_start_at_rest_that_ends_has_no_derivative():
    """A slightly weaker spring does not carry the weight."""
    with pytest.raises(bgc.BgError, match="BG774"):
        run("slack", ["strength"])


def test_the_command_writes_derivatives_beside_the_columns(tmp_path):
    out = tmp_path / "rows.csv"
    command = ["run", str(model_file("sensitivities")), "--scene", "oscillator"]
    result = CliRunner().invoke(
        application, [*command, "--sensitivities", "mass", "--out", str(out)]
    )
    assert result.exit_code == 0
    assert "d spring.q/d mass [m/kg]" in result.output
    head, first, *_ = out.read_text("utf-8").splitlines()
    columns = "spring.q,speed [mm/s],energy.stored,d spring.q/d mass,d speed [mm/s]/d mass"
    assert head == f"time,{columns}"
    assert first.split(",")[-2:] == ["0.0", "0.0"]
