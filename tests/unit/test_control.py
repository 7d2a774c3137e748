"""Margins, zeros, step responses, loci and closed loops against closed forms."""

import math

import numpy as np
import pytest
from refusals import refusals
from scipy import signal

from bgc.diagnostics.diagnostic import BgError
from bgc.runtime import control
from bgc.runtime.linear.state_space import Linearisation


def model(A, B, C, D, E=None) -> Linearisation:
    A, B, C, D = (np.array(matrix, dtype=float) for matrix in (A, B, C, D))
    names = tuple(f"x{k}" for k in range(len(A)))
    inputs = tuple(f"u{k}" for k in range(D.shape[1]))
    outputs = tuple(f"y{k}" for k in range(D.shape[0]))
    units = dict.fromkeys(names, "") | dict.fromkeys(inputs, "V") | dict.fromkeys(outputs, "m")
    mass = np.eye(len(A)) if E is None else np.array(E, dtype=float)
    return Linearisation(A, B, C, D, mass, names, inputs, outputs, units, np.zeros(len(A)), 0.0)


def rational(numerator, denominator) -> Linearisation:
    return model(*signal.tf2ss(numerator, denominator))


# --- poles and zeros --------------------------------------------------------------------------


def test_a_mode_that_is_not_reached_is_a_pole_and_a_zero():
    found = control.factors(model(np.diag([-1, -2]), [[1], [0]], [[1, 1]], [[0]]))
    assert found.zeros == pytest.approx([-2])


def test_a_descriptor_has_the_zeros_of_its_pencil():
    """x' + y' = u - x, 0 = x - y, out = x + u: (2 s + 2)/(2 s + 1)."""
    linear = model([[-1, 0], [1, -1]], [[1], [0]], [[1, 0]], [[1]], E=[[1, 1], [0, 0]])
    np.testing.assert_allclose(control.transmission_zeros(linear), [-1], rtol=1e-9)


# --- margins ----------------------------------------------------------------------------------


def test_a_loop_beyond_its_gain_margin_is_unstable():
    loop = control.with_gain(rational([6], [1, 3, 3, 1]), 1.4)
    found = control.margins(loop)
    assert (found.closed_right, found.encirclements) == (2, 2)
    assert math.isnan(found.delay)


def test_feedback_may_stabilise():
    """2/(s - 1): one encirclement against the clock."""
    found = control.margins(rational([2], [1, -1]))
    assert (found.open_right, found.closed_right, found.encirclements) == (1, 0, -1)


# --- closed loops -----------------------------------------------------------------------------


def test_a_loop_without_a_solution_is_refused():
    assert refusals(lambda: control.close_loop(rational([-2, 1], [1, 1]), 0.5))[0].code == "BG795"


# --- step responses ---------------------------------------------------------------------------


def test_a_stiff_mode_takes_no_accuracy():
    """1/(s + 1) beside a mode of -1e9, in states of very different scale."""
    linear = model([[-1, 0], [1e12, -1e9]], [[1], [0]], [[1, 0], [0, 1e-3]], [[0], [0]])
    found = control.step_response(linear, 5.0)
    np.testing.assert_allclose(found.value[:, 0], 1 - np.exp(-found.time), atol=1e-10)
    np.testing.assert_allclose(found.value[1:, 1], 1 - np.exp(-found.time[1:]), atol=1e-6)


def test_an_integrator_has_no_steady_value_unless_it_is_not_seen():
    A, B = [[-2, 0], [1, 0]], [[1], [0]]
    assert math.isnan(control.step_response(model(A, B, [[0, 1]], [[0]])).steady[0])
    assert control.step_response(model(A, B, [[1, 0]], [[0]])).steady[0] == pytest.approx(0.5)


def test_a_descriptor_has_no_step_response():
    linear = model([[-1, 0], [1, -1]], [[1], [0]], [[1, 0]], [[1]], E=[[1, 1], [0, 0]])
    for compute in (control.step_response, control.root_locus):
        assert refusals(compute, linear)[0].code == "BG796"


# --- root loci --------------------------------------------------------------------------------


def test_a_locus_goes_from_poles_to_zeros_and_crosses_where_it_should():
    """1/(s (s + 1) (s + 2)): unstable from gain 6 on, at sqrt(2) rad/s."""
    found = control.root_locus(rational([1], [1, 3, 2, 0]))
    (crossing,) = found.crossings
    assert (crossing.gain, crossing.omega) == (pytest.approx(6), pytest.approx(math.sqrt(2)))
    np.testing.assert_allclose(found.poles.sum(axis=1), -3, rtol=1e-6)  # the relative degree is 3
    jumps = np.abs(np.diff(found.poles[1:], axis=0)) / (0.1 + np.abs(found.poles[1:-1]))
    assert jumps.max() < 0.1, "each column is one branch"
    ends = control.root_locus(rational([1, 2], [1, 3, 0])).poles[-1]
    assert np.abs(ends + 2).min() < 1e-2


def test_a_locus_crosses_at_rest_too():
    """(s - 1)/(s + 1)^2: a pole passes 0 at gain 1."""
    (crossing,) = control.root_locus(rational([1, -1], [1, 2, 1])).crossings
    assert (crossing.gain, crossing.omega) == (pytest.approx(1), 0)


# --- the Python interface ---------------------------------------------------------------------


def test_gains_and_times_are_quantities_and_other_loops_are_refused():
    one = rational([1], [1, 1])
    closed = control.close_loop(one, "2000 mV/m")
    assert closed.A[0, 0] == pytest.approx(-3)
    assert pytest.approx(2 * one.B) == control.with_gain(one, "2 V/m").B
    assert control.step_response(one, "20 ms").time[-1] == pytest.approx(0.02)
    assert control.frequency_response(one, "1 rad/s", 10).omega[[0, -1]] == pytest.approx([1, 10])
    several = model([[-1]], [[1]], [[1], [2]], [[0], [0]])
    for function in (control.margins, control.factors, control.root_locus, control.close_loop):
        with pytest.raises(BgError, match=r"BG660.*2: `y0`, `y1`"):
            function(several)
    assert control.step_response(several).value.shape[1] == 2
    blind = model([[-1]], np.zeros((1, 0)), [[1]], np.zeros((1, 0)))
    with pytest.raises(BgError, match="BG660: one input is needed, and the linear model has none"):
        control.step_response(blind)
    with pytest.raises(BgError, match="BG063"):
        control.with_gain(one, "3 kg")


# --- charts -----------------------------------------------------------------------------------


@pytest.mark.parametrize("loop", [rational([6], [1, 3, 3, 1]), rational([20, 1], [1, 0.1, 4, 0])])
def test_charts_show_the_critical_point_and_the_curve(loop, tmp_path):
    response = control.frequency_response(loop)
    axes = control.plot_nyquist(response, tmp_path / "curve.png").axes[0]
    left, right = axes.get_xlim()
    assert left < -1 < right and axes.get_ylim()[0] < 0 < axes.get_ylim()[1]
    margins = [m.meaning for m in response.landmarks if "margin" in m.kind]
    assert margins and [text.get_text() for text in axes.texts if text.get_text()] == margins
    axes = control.plot_nichols(response, tmp_path / "chart.svg").axes[0]
    left, right = axes.get_xlim()
    assert left < -180 < right
    assert set(margins) <= {text.get_text() for text in axes.texts}
    poles = control.factors(loop)
    for axes in (
        control.plot_poles(poles.poles, poles.zeros, "map").axes[0],
        control.plot_locus(control.root_locus(loop), poles, "locus").axes[0],
    ):
        (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
        for place in (*poles.poles, *poles.zeros):
            assert left < place.real < right and low < place.imag < high
    curve = control.step_response(loop)
    axes = control.plot_time_response(curve, "step", tmp_path / "step.pdf").axes[0]
    assert (axes.get_legend() is not None) == np.isfinite(curve.steady[0])
    assert {path.suffix for path in tmp_path.iterdir()} == {".png", ".svg", ".pdf"}


@pytest.mark.parametrize("damping", [1e-4, 0.01, 0.1, 0.5])
def test_the_circle_of_a_resonance_is_a_smooth_curve(damping):
    value = control.frequency_response(rational([1], [1, 2 * damping, 1])).value
    steps = np.diff(value[np.abs(value) > 0.02 * np.abs(value).max()])
    turns = np.abs(np.angle(steps[1:] / steps[:-1]))
    assert np.rad2deg(turns.max()) < 12


def test_rays_of_equal_damping_have_labels_apart_from_each_other():
    poles = np.array([-1 + 10j, -1 - 10j])
    for some in (poles, 1j * poles, poles / 1e6):
        axes = control.plot_poles(some, np.empty(0, complex), "map").axes[0]
        places = axes.transData.transform([text.xy for text in axes.texts])
        assert 3 <= len(places) <= 6
        assert (np.abs(np.diff(places, axis=0)).max(axis=1) > 12).all()  # pixels at 100 dpi
