import gc
import math
import os
import shutil
import signal
import threading
import weakref
from pathlib import Path

import numpy as np
import pytest
from refusals import code_of, refusal

import bgc
from bgc.building.build import Unit, build_shared_object
from bgc.building.build_result import Built, RunFacts
from bgc.building.cache import Cache
from bgc.building.toolchain import find_toolchain
from bgc.diagnostics.diagnostic import BgError
from bgc.language.column_names import AccountColumn
from bgc.language.solver import Solver
from bgc.runtime.linear.state_space import pencil_eigenvalues
from bgc.runtime.model import Model
from bgc.runtime.running import binding
from bgc.runtime.running.binding import Library
from bgc.runtime.running.failures import RunInterrupted, SimulationError
from bgc.runtime.running.run import choose_method

OSCILLATOR = Path(__file__).with_name("oscillator.c").read_text()
COLUMNS = ("v", "q", "energy.residual", "r[1]", "r[2]")
ACCOUNTS = tuple(AccountColumn(name, f"energy.{name}") for name in ("residual",))


@pytest.fixture(scope="module")
def library(tmp_path_factory) -> Path:
    cache = Cache(tmp_path_factory.mktemp("cache"))
    return build_shared_object((Unit("model", OSCILLATOR),), find_toolchain(), cache)


@pytest.fixture
def model(library) -> Model:
    return Model(Built(library, RunFacts("swing", "Oscillator", COLUMNS, ACCOUNTS, duration=2.0)))


# --- simulation -------------------------------------------------------------------------------


def test_a_run_gives_the_observed_columns_in_the_scenes_order(model):
    result = model.simulate(rtol=1e-10)
    assert tuple(result) == COLUMNS
    assert result.units["v"] == "m/s" and result.units["energy.residual"] == "J"
    assert result.status == "done"
    assert (len(result.time), result.time[-1]) == (1001, 2.0)
    np.testing.assert_allclose(result["q"], np.cos(2 * result.time), atol=1e-8)
    np.testing.assert_allclose(result["r"][:, 1], 3 * result["q"], rtol=1e-15)
    assert np.max(np.abs(result["energy.residual"])) < 1e-8


def test_a_fixed_step_gives_a_row_each_step(model):
    result = model.simulate(1.0, solver="rk4", step=0.01)
    assert (len(result.time), result.solver) == (101, "rk4")
    assert abs(result["q"][-1] - math.cos(2.0)) < 1e-7


@pytest.mark.parametrize("error", [True, False])
@pytest.mark.parametrize(
    ("options", "within"),
    [({"solver": "gauss4", "step": 0.01}, 2e-9), ({"solver": "radau5"}, 1e-5)],
)
def test_complex_systems_of_a_model_without_tables_are_solved_densely(
    model, options, within, error
):
    """A model written by hand has no tables of its factors; complex systems have no other code."""
    result = model.simulate(**options, error=error)
    assert result.status == "done" and result.counts["fallbacks"] > 0
    np.testing.assert_allclose(result["q"], np.cos(2 * result.time), atol=within)


def test_a_step_without_a_solver_chooses_the_fixed_default(model):
    assert model.simulate(0.1, step=0.01).solver == "ros34prw"


def test_the_scenes_solver_is_used_and_can_be_replaced(library):
    facts = RunFacts("s", "M", ("q",), solver=Solver("rk4"), step=0.1, duration=1.0, every=0.5)
    model = Model(Built(library, facts))
    result = model.simulate()
    assert (result.solver, result.time.tolist()) == ("rk4", [0.0, 0.5, 1.0])
    assert model.simulate(solver="rodas5p", every=0.25).time.tolist()[1] == 0.25


def test_runs_are_the_same_to_the_last_bit(model):
    first, second = model.simulate(), model.simulate()
    assert all(np.array_equal(first[name], second[name]) for name in first)


def test_runs_in_several_threads_do_not_disturb_each_other(model):
    ends = {}

    def run(k: float) -> None:
        ends[k] = model.simulate(rtol=1e-9, parameters={"spring.k": k})["q"][-1]

    threads = [threading.Thread(target=run, args=(float(k),)) for k in range(1, 9)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for k, end in ends.items():
        assert abs(end - math.cos(2 * math.sqrt(k))) < 1e-6


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        ({"solver": "ode45"}, "BG071"),
        ({"solver": "rk4"}, "BG072"),
        ({"solver": "rk4", "step": 0.01, "rtol": 1e-9}, "BG044"),
        ({"solver": "ros34prw", "step": 0.01, "substeps": 1, "atol": 1e-9}, "BG044"),
        ({"step": 0.01, "max_step": 1e-3}, "BG044"),
        ({"max_step": 0.0}, "BG066"),
        ({"solver": "ros34prw", "step": 0.01, "substeps": 5000}, "BG066"),
        ({"solver": "lie", "step": 0.01, "substeps": 2}, "BG044"),
        ({"substeps": 2}, "BG044"),
        ({"rtol": 0.0}, "BG066"),
        ({"rtol": 1e300}, "BG066"),
        ({"rtol": 1e-30}, "BG066"),
        ({"solver": "rk4", "step": 1e300}, "BG066"),
        ({"duration": -1.0}, "BG066"),
        ({"every": 1e-15}, "BG068"),
        ({"parameters": {"mess": 1.0}}, "BG060"),
        ({"parameters": {"mass": 5000.0}}, "BG061"),
        ({"parameters": {"mass": 0.0}}, "BG707"),
        ({"parameters": {"mass": "7 m"}}, "BG063"),
    ],
)
def test_arguments_at_fault(model, arguments, code):
    assert refusal(model.simulate, **arguments).code == code


@pytest.mark.parametrize(
    "solver",
    [Solver("ros23", rtol=1e-4), Solver("rodas5p", keep=2), Solver("ros23", max_step=1e-4)],
)
def test_an_option_in_the_scene_that_its_own_method_does_not_have(library, solver):
    facts = RunFacts("s", "M", ("q",), solver=solver, step=0.01, duration=1.0)
    model = Model(Built(library, facts))
    refused = refusal(model.simulate)
    assert refused.code == "BG044"
    if solver.name == "rodas5p":  # of no option of commands and keyword of Python
        assert refused.help.endswith("; in a scene, `solver rodas5p(..)` takes `max_steps` too")
    # It was not written for a method that the caller chooses instead.
    assert model.simulate(solver="rk4").solver == "rk4"


@pytest.mark.parametrize(
    ("own", "options", "other", "expected"),
    [
        ("rodas5p", {"rtol": 1e-10, "step": 1e-6}, "ros34prw", {"rtol": 0.0, "step": 0.01}),
        ("rodas5p", {"rtol": 1e-10, "step": 1e-6}, "dopri5", {"rtol": 1e-10, "step": 1e-6}),
        ("ros34prw", {"rtol": 0.1, "step": 2e-3}, "dopri5", {"rtol": 0.0, "step": 0.0}),
        ("ros34prw", {"substeps": 4, "step": 2e-3}, "lie", {"parts": 1, "step": 2e-3}),
        ("auto", {"rtol": 1e-10, "step": 2e-3}, "ros34prw", {"rtol": 0.0, "step": 2e-3}),
    ],
)
def test_tolerances_and_steps_of_the_scene_are_those_of_its_kind(
    library, own, options, other, expected
):
    facts = RunFacts("s", "M", ("q",), solver=Solver(own, **options), step=0.01)
    method = choose_method(Library(library), facts, Solver(other))
    assert {name: getattr(method, name) for name in expected} == expected


def test_the_longest_step_can_be_limited(model):
    long = model.simulate(1.0, every=1.0)
    short = model.simulate(1.0, every=1.0, max_step=1e-3)
    assert long.counts["steps"] < 100 < 1000 <= short.counts["steps"]
    ensemble = model.simulate_many({"mass": [1.0]}, 1.0, every=1.0, max_step=1e-3)
    assert ensemble["q"][0, -1] == short["q"][-1]


def test_a_scene_without_an_end_needs_a_duration(library):
    model = Model(Built(library, RunFacts("s", "M", ("q",))))
    assert refusal(model.simulate).code == "BG067"
    assert model.simulate(0.5).time[-1] == 0.5


# --- runs that end early ------------------------------------------------------------------------


def test_a_failed_run_keeps_its_rows(model):
    with pytest.raises(SimulationError) as error:
        model.simulate(parameters={"s": 5.0})
    result = error.value.result
    assert code_of(error) in ("BG701", "BG703")
    assert result.status == "failed" and "t = 1.9" in result.message
    assert 900 < len(result.time) < 1000
    assert np.all(np.isfinite(result["q"]))


def test_a_failed_assertion_is_told_in_the_models_words(model):
    with pytest.raises(SimulationError) as error:
        model.simulate(parameters={"limit": 0.5})
    assert code_of(error) == "BG705"
    assert "the spring is too long" in str(error.value)
    assert len(error.value.result.time) == 0


@pytest.mark.slow
@pytest.mark.usefixtures("terminal_signals")
def test_ctrl_c_stops_a_long_run_and_keeps_its_rows(model):
    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt) as error:
        model.simulate(1e6, every=10.0, rtol=1e-10)
    assert isinstance(error.value, RunInterrupted)
    result = error.value.result
    assert result.status == "interrupted"
    assert 10 < len(result.time) < 100_001 and np.all(np.isfinite(result["q"]))


# --- parameters ------------------------------------------------------------------------------


def test_parameters_tell_value_unit_and_range(model):
    mass = model.parameters["mass"]
    assert (mass.value, mass.unit, mass.low, mass.high) == (1.0, "kg", 0.0, 1000.0)
    assert list(model.parameters) == ["mass", "spring.k", "spring.c", "s", "limit"]
    assert "mass = 1 kg" in repr(model.parameters)


def test_a_parameter_set_holds_for_later_runs_until_it_is_deleted(model):
    model.parameters["mass"] = "4000 g"
    assert model.parameters["mass"].value == 4.0
    assert abs(model.simulate(rtol=1e-9)["q"][-1] - math.cos(2.0)) < 1e-6
    assert abs(model.simulate(parameters={"mass": 1})["q"][-1] - math.cos(4.0)) < 1e-4
    assert model.parameters["mass"].value == 4.0
    del model.parameters["mass"]
    assert model.parameters["mass"].value == 1.0


def test_misspelt_parameters_get_a_suggestion(model):
    for attempt in (
        lambda: model.parameters["spring_k"],
        lambda: model.parameters.__setitem__("spring_k", 1.0),
        lambda: model.parameters.__delitem__("spring_k"),
    ):
        with pytest.raises(BgError) as error:
            attempt()
        assert code_of(error) == "BG060"
        assert "spring.k" in error.value.diagnostics[0].help
    assert "spring_k" not in model.parameters


# --- evaluation ------------------------------------------------------------------------------


def test_jacobian_and_right_hand_side_at_a_state(model):
    state = np.array([0.5, 2.0])
    assert model.initial_state().tolist() == [1.0, 0.0]
    assert model.rhs(state).tolist() == [2.0, -2.0]
    assert model.jacobian(state, parameters={"spring.c": 3.0}).tolist() == [[0.0, 1.0], [-4, -3]]
    assert model.observe(state) == {"q": 0.5, "v": 2.0, "r[1]": 1.0, "r[2]": 1.5}
    assert [(s.name, s.unit) for s in model.states] == [("spring.q", "m"), ("body.p", "kg*m/s")]


def test_views_keep_the_instance_whose_memory_they_show(model):
    # initial_state() read freed memory: 4.67e-310 for 0, by the allocator's choice.
    names = [k for k, v in vars(binding.Instance).items() if isinstance(v, property)]
    found = {name: getattr(model.instance_at(None, 0.0), name) for name in names}
    views = {k: v for k, v in found.items() if isinstance(v, np.ndarray) and v.size}
    assert set(views) == {"state", "scale"}
    for name in views:
        instance = model.instance_at(None, 0.0)
        freed = weakref.ref(instance)
        part = getattr(instance, name)[1:]
        del instance
        gc.collect()
        assert freed() is not None, name
        part[:] = 7.0
        assert getattr(freed(), name)[1] == 7.0
        del part
        gc.collect()
        assert freed() is None, name


def test_modes_of_a_damped_oscillator(model):
    (mode,) = model.modes(parameters={"spring.c": 1.0})
    assert mode.damping == pytest.approx(0.25)
    assert mode.period == pytest.approx(2 * math.pi / math.sqrt(4 - 0.25))
    assert sorted(model.eigenvalues().imag) == pytest.approx([-2.0, 2.0])


def test_algebraic_equations_have_no_eigenvalues():
    # 2 x' = -x + z, 0 = x - 2 z + y, y' = -3 y: z = (x + y) / 2
    matrix = np.array([[-1.0, 1.0, 0.0], [1.0, -2.0, 1.0], [0.0, 0.0, -3.0]])
    found = pencil_eigenvalues(matrix, np.diag([2.0, 0.0, 1.0]))
    assert found.tolist() == pytest.approx([-3.0, -0.25])


def test_a_singular_mass_matrix_without_zero_rows():
    # x' + y' = -x, x' + y' = -y: one finite eigenvalue, with x = y: 2 x' = -x
    mass = np.array([[1.0, 1.0], [1.0, 1.0]])
    found = pencil_eigenvalues(-np.eye(2), mass)
    assert found.tolist() == pytest.approx([-0.5])


# --- loading ---------------------------------------------------------------------------------


def test_what_is_no_compiled_model_is_refused(tmp_path):
    (tmp_path / "x.so").write_bytes(b"not machine code")
    assert refusal(binding.Library, tmp_path / "x.so").code == "BG059"


def test_another_version_of_the_interface_is_refused(library, monkeypatch, tmp_path):
    monkeypatch.setattr(binding, "ABI", 99)
    shutil.copy(library, tmp_path / "copy.so")
    with pytest.raises(BgError) as error:
        binding.Library(tmp_path / "copy.so")
    assert code_of(error) == "BG059"
    assert "99" in error.value.diagnostics[0].message


STIFF = """
model Stiff { param k = 1; state x = 1; der(x) = -k*(x - cos(time)); }
scene s of Stiff { observe x; solver rodas5p; run 1 s every 0.1 s; }
"""


def test_a_step_below_the_least_ends_a_run_alone_and_in_a_batch(tmp_path):
    (tmp_path / "m.bg").write_text(STIFF)
    model = bgc.compile(tmp_path / "m.bg")
    values = {"k": [1.0, 2.0, 4.0, 1e5]}
    runs = model.simulate_many(values, solver="dopri5")
    assert runs.together and not runs.failures
    ended = model.simulate_many(values, solver="dopri5", min_step="0.1 ms")
    assert {k: failure.code for k, failure in ended.failures.items()} == {3: "BG701"}
    assert ended["x"][:3] == pytest.approx(runs["x"][:3], rel=1e-4)
    with pytest.raises(SimulationError) as caught:
        model.simulate(solver="dopri5", min_step=1e-4, parameters={"k": 1e5})
    assert code_of(caught) == "BG701"
    alone, least = (model.simulate(solver="dopri5", min_step=h) for h in (None, 1e-4))
    assert (alone["x"] == least["x"]).all()  # its steps are longer
