"""Frequency responses of linear models against closed forms: values, peaks, margins, ranges."""

import math

import numpy as np
import pytest
from linear_models import TWO_MASSES, linear, state_space
from refusals import code_of, refusal

from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.linear.frequency import frequency_response


def test_the_peak_and_the_margins_have_all_their_digits(tmp_path):
    """D4: the peak was the grid's highest point, 9849.87 for 9899.49."""
    circuit = (
        "model M { s : Se(1 V); l : I(1 mH); c : C(10 uF); r : R(2 ohm); j : J1;"
        " s -> j -> l, c, r; } scene s of M { observe c.e; run 1 ms; }"
    )
    response = frequency_response(linear(tmp_path, circuit, ["s.e"], ["c.e"]))
    peak, crossover = response.landmarks
    assert (peak.meaning, peak.omega) == ("peak", pytest.approx(math.sqrt(98e6), rel=1e-10))
    # |G| = 1 where (1 - w^2/1e8)^2 + (2e-5 w)^2 = 1, so w^2 = 2e8 - 4e-10*1e16.
    assert crossover.omega == pytest.approx(math.sqrt(1.96e8), rel=1e-12)
    assert {mark.omega for mark in response.landmarks} <= set(response.omega)

    loop = (
        "model L { s : Se(1); r : R(1); s -> r; param k = 6;"
        " state x[3] = [0, 0, 0]; der(x) = [k*s.e - x[1], x[1] - x[2], x[2] - x[3]]; }"
        " scene s of L { observe x[3] as out; run 1; }"
    )
    response = frequency_response(linear(tmp_path, loop, ["s.e"], ["out"]))
    gain, phase = response.landmarks  # of 6/(s + 1)^3
    assert gain.omega == pytest.approx(math.sqrt(6 ** (2 / 3) - 1), rel=1e-12)
    assert gain.meaning == "phase margin 10.17 deg"  # 180 - 3*atan(w)
    assert phase.omega == pytest.approx(math.sqrt(3), rel=1e-10)
    assert phase.meaning == "gain margin 2.499 dB"  # 8/6
    assert not np.isnan(response.phase).any()


def test_the_peak_of_an_undamped_mode_is_not_bounded(tmp_path):
    swing = (
        "model M { s : Se(1); l : I(1); c : C(1); j : J1; s -> j -> l, c; }"
        " scene s of M { observe c.e; run 1; }"
    )
    response = frequency_response(linear(tmp_path, swing, ["s.e"], ["c.e"]))
    assert [m.meaning for m in response.landmarks] == ["unbounded peak", "phase margin 0 deg"]
    assert response.landmarks[0].omega == pytest.approx(1.0, rel=1e-12)
    assert np.isfinite(response.value).all() and np.isfinite(response.phase).all()


def test_a_resonance_is_seen_however_sharp(tmp_path):
    text = TWO_MASSES.replace("d = 0.3", "d = 1e-6")
    response = frequency_response(linear(tmp_path, text, ["push.e"], ["right.f"]))
    modes = [m for m in linear(tmp_path, text, ["push.e"]).modes() if m.frequency > 0]
    for mode in modes:
        near = np.abs(response.omega - abs(mode.eigenvalue)) < 1e-2
        assert response.magnitude[near].max() > 60 + response.magnitude[0]
    assert np.abs(np.diff(response.phase)).max() < 180


@pytest.mark.parametrize(("low", "high"), [(0.0, 1.0), (2.0, 1.0), (1.0, math.inf)])
def test_a_range_that_is_none(tmp_path, low, high):
    with pytest.raises(BgError) as error:
        frequency_response(linear(tmp_path, TWO_MASSES, ["push.e"], ["right.f"]), low, high)
    assert code_of(error) == "BG085"


def test_the_widest_range_of_frequencies(tmp_path):
    """Velocity by force, of masses between springs: by the stiffnesses far below their modes."""
    push = linear(tmp_path, TWO_MASSES, ["push.e"], ["right.f"])
    response = frequency_response(push, 1e-300, 1e300)
    np.testing.assert_allclose(response.omega[[0, -1]], [1e-300, 1e300])
    stiffness = np.array([[70, -20], [-20, 90]])
    compliance = np.linalg.inv(stiffness)[1, 0]
    assert response.value[0] == pytest.approx(1e-300j * compliance, rel=1e-9, abs=0)
    assert abs(response.value[-1]) < 1e-290


def test_a_response_ends_where_it_has_faded_into_rounding():
    """1/(s + 1)^4 beside a mode at 1e6 rad/s: a billionth of its largest value near 178 rad/s."""
    A = np.diag([-1.0] * 4 + [-1e6]) + np.diag([1.0] * 3 + [0.0], -1)
    omega = frequency_response(state_space(A, output=3)).omega
    assert omega[-1] == pytest.approx(1e9**0.25, rel=0.05)


def test_an_input_before_a_sampled_part_moves_nothing(tmp_path):
    """A sampled part holds its values in a linear form; the message names it as a reason."""
    text = """
    model M {
      input wanted = 0; push : Se(e = u); body : I(1); drag : R(1); hub : J1;
      push -> hub -> body, drag;
      sample 10 ms { output u = wanted - hub.f; }
    }
    scene s of M { observe hub.f; run 1 s; }
    """
    with pytest.raises(BgError, match="sampled part") as error:
        frequency_response(linear(tmp_path, text, ["wanted"]))
    assert code_of(error) == "BG086"


def test_an_output_that_does_not_respond(tmp_path):
    text = """
    model M {
      param lever = 0; push : Se(e = 3*max(abs(lever) - 1, 0)); body : I(1); drag : R(1); hub : J1;
      push -> hub -> body, drag;
    }
    scene s of M { observe hub.f; run 1 s; }
    """
    assert refusal(lambda: frequency_response(linear(tmp_path, text, ["lever"]))).code == "BG086"
    moved = text.replace("lever = 0", "lever = 2")
    response = frequency_response(linear(tmp_path, moved, ["lever"]))
    np.testing.assert_allclose(response.value, 3 / (1j * response.omega + 1), rtol=1e-12)
