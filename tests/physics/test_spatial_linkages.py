"""Linkages in space with redundant constraints: which of them are needed changes as they move."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from fmpy import simulate_fmu
from scipy.optimize import brentq
from spatial_loops import bennett, bricard

from bgc.runtime.cli.app import application
from bgc.runtime.fmi import binaries
from bgc.runtime.running.structures import Status

SOLVERS = [
    {},
    {"solver": "dopri5", "rtol": 1e-10},
    {"solver": "radau5", "rtol": 1e-10},
    {"solver": "rk4", "step": 1e-3},
    {"solver": "ros34prw", "step": 5e-4},
]


@pytest.fixture(scope="module")
def unit(tmp_path_factory):
    """The linkage on the ground as an FMU."""
    folder = tmp_path_factory.mktemp("unit")
    file = Path(__file__).parents[1] / "models" / "spatial_linkages.bg"
    arguments = ["build", str(file), "--scene", "standing", "--target", "fmu2", "-o", str(folder)]
    with pytest.MonkeyPatch.context() as patch:  # compile time is most of this test
        patch.setattr(binaries, "_FLAGS", ("-std=c11", "-O0", "-fPIC", "-shared"))
        assert CliRunner().invoke(application, arguments).exit_code == 0
    return folder / "spatial_linkages_standing.fmu"


def turned(result):
    return np.column_stack([result[f"q{k}"] for k in (1, 2, 3, 4)])


def test_a_bricard_linkage_goes_where_one_constraint_replaces_another(load):
    """BG735 at 0.55 s before, although the constraints have one rank everywhere."""
    result = load("spatial_linkages", "standing").simulate()
    q = result["q"]
    exact = bricard().motion(np.zeros(6), result.time, -0.1, np.pi + 0.1)
    np.testing.assert_allclose(q[:, 0], exact, atol=1e-7)
    assert np.ptp(q[:, 0]) > 3, "from one end to the other"
    assert np.abs(result["gap"]).max() < 1e-10
    exchanged = np.ptp(result["energy.stored"])
    assert exchanged > 29 and np.abs(result["energy.residual"]).max() < 1e-8 * exchanged


@pytest.mark.parametrize("options", SOLVERS[1:], ids=lambda options: options["solver"])
def test_methods_go_on_where_the_choice_changes(load, options):
    model = load("spatial_linkages", "standing")
    result = model.simulate(duration=3, **options)
    exact = bricard().motion(np.zeros(6), result.time, -0.1, np.pi + 0.1)
    np.testing.assert_allclose(result["q"][:, 0], exact, atol=2e-6)
    assert np.abs(result["gap"]).max() < 1e-10


def test_a_bennett_linkage_moves_with_three_redundant_constraints(load):
    result = load("spatial_linkages", "bennett").simulate()
    exact = bennett().motion(turned(result)[0], result.time, 0.95, 3.1)
    np.testing.assert_allclose(result["q1"], exact, atol=1e-7)
    assert np.ptp(exact) > 1.9
    np.testing.assert_allclose(result["q3"], -result["q1"], atol=1e-11)
    assert np.abs(result["gap"]).max() < 1e-10
    assert np.abs(result["energy.residual"]).max() < 1e-8 * np.ptp(result["energy.stored"])


def test_a_drifting_linkage_keeps_its_momentum(load):
    """The torque at its pin is an inner one; nothing acts from outside."""
    result = load("spatial_linkages", "drifting").simulate()
    linear = angular = 0.0
    for k in range(6):
        p, r, axes = (result[f"{name}{k}"] for name in "prA")
        axes = axes.reshape(-1, 3, 3)
        own = np.einsum("tij,tj->ti", axes, p[:, :3])
        linear = linear + own
        angular = angular + np.einsum("tij,tj->ti", axes, p[:, 3:]) + np.cross(r, own)
    assert np.ptp(result["q"][:, 0]) > 3, "it has to move"
    np.testing.assert_allclose(linear, np.broadcast_to(linear[0], linear.shape), atol=1e-7)
    np.testing.assert_allclose(angular, np.broadcast_to(angular[0], angular.shape), atol=1e-7)
    assert np.abs(result["gap"]).max() < 1e-10
    assert np.abs(result["energy.residual"]).max() < 1e-7


def test_a_linearisation_chooses_the_rows_at_its_point(load):
    """About the position of rest, far from the start: `m s^2 + V'' = 0` in the first angle."""
    inertia, potential = bricard().along_first(np.zeros(6), -0.1, np.pi + 0.1)
    at_rest = brentq(potential.deriv(), 1.0, 2.0)
    frequency = np.sqrt(potential.deriv(2)(at_rest) / inertia(at_rest))
    found = np.linalg.eigvals(load("spatial_linkages", "standing").linearise(at="steady").A)
    np.testing.assert_allclose(np.sort_complex(found), [-1j * frequency, 1j * frequency], rtol=1e-6)


def test_an_instance_is_saved_with_its_choice(load):
    """The first choice holds no longer at 0.7 s."""
    model = load("spatial_linkages", "standing")
    rows = np.empty((1, model.row_width))
    one, other = (model.instance_at(None, 0.0, {}) for _ in range(2))
    assert one.run(np.array([0.7]), rows)[0] is Status.OK
    assert other.restore(one.save()) is Status.OK
    for instance in (one, other):
        assert instance.run(np.array([2.5]), rows)[0] is Status.OK
    np.testing.assert_array_equal(one.state, other.state)


@pytest.mark.parametrize("kind", ["ModelExchange", "CoSimulation"])
def test_an_fmu_goes_on_where_the_choice_changes(kind, unit):
    found = simulate_fmu(
        str(unit), stop_time=2, fmi_type=kind, output_interval=0.05, relative_tolerance=1e-9
    )
    times, places = np.unique(found["time"], return_index=True)
    exact = bricard().motion(np.zeros(6), times, -0.1, np.pi + 0.1)
    np.testing.assert_allclose(found["q[1]"][places], exact, atol=1e-6)
