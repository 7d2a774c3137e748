"""Linear analysis against python-control on random systems: each function by another author."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest

from bgc.runtime import control
from bgc.runtime.linear.state_space import Linearisation

peer = pytest.importorskip("control")


def systems(count: int, inputs: int = 1, outputs: int = 1) -> list[Linearisation]:
    """Stable systems of 1 to 6 states, without a direct term."""
    rng, found = np.random.default_rng(3), []
    for _ in range(count):
        n = int(rng.integers(1, 7))
        A = rng.normal(size=(n, n))
        A -= (np.linalg.eigvals(A).real.max() + rng.uniform(0.1, 1)) * np.eye(n)
        B, C = rng.normal(size=(n, inputs)), rng.normal(size=(outputs, n))
        names = [
            tuple(f"{k}{i}" for i in range(m))
            for k, m in zip("xuy", (n, inputs, outputs), strict=True)
        ]
        units = {name: "1" for some in names for name in some}
        D = np.zeros((outputs, inputs))
        found.append(Linearisation(3 * A, B, 20 * C, D, np.eye(n), *names, units, np.zeros(n), 0.0))
    return found


def near(found: np.ndarray, wanted: np.ndarray, rel: float = 1e-6) -> None:
    """Compare complex numbers without their order."""
    assert len(found) == len(wanted)
    left = list(wanted)
    for value in found:
        k = int(np.argmin([abs(value - other) for other in left]))
        assert abs(value - left.pop(k)) <= rel * max(1.0, abs(value))


@pytest.fixture(scope="module")
def single() -> list[tuple[Linearisation, object]]:
    return [(each, each.to_ss("control")) for each in systems(40)]


def test_poles_zeros_and_static_gain(single):
    for linear, other in single:
        found = control.factors(linear)
        near(found.poles, peer.poles(other))
        near(found.zeros, peer.zeros(other), 1e-5)
        static = found.gain * np.prod(-found.zeros) / np.prod(-found.poles)
        assert static == pytest.approx(float(np.real(peer.dcgain(other))), rel=1e-5)


def test_margins_and_crossovers(single):
    compared = 0
    for linear, other in single:
        found = control.margins(linear)
        near(control.close_loop(linear).eigenvalues(), peer.poles(peer.feedback(other, 1)))
        gains, phases, _, at_phase, at_gain, _ = peer.stability_margins(other, returnall=True)
        inside = [mark for mark in found.phase if math.isfinite(mark.amount)]
        assert len(inside) == len(at_gain)
        for mark, omega, margin in zip(inside, at_gain, phases, strict=True):
            assert mark.omega == pytest.approx(omega, rel=1e-5)
            assert (mark.amount - margin + 180) % 360 - 180 == pytest.approx(0, abs=1e-3)
            compared += 1
        for mark in found.gain:
            k = int(np.argmin(np.abs(at_phase - mark.omega)))
            assert mark.omega == pytest.approx(at_phase[k], rel=1e-5)
            assert mark.amount == pytest.approx(20 * math.log10(gains[k]), abs=1e-3)
            compared += 1
    assert compared > 40


def test_step_and_impulse_responses(single):
    for linear, other in single[:12]:
        found = control.step_response(linear)
        _, wanted = peer.step_response(other, found.time)
        size = np.abs(wanted).max()
        np.testing.assert_allclose(found.value[:, 0], wanted, atol=1e-7 * size)
        struck = control.impulse_response(linear)
        _, wanted = peer.impulse_response(other, struck.time)
        size = np.abs(wanted).max()
        np.testing.assert_allclose(struck.value[:, 0], wanted, atol=1e-7 * size)


def test_a_root_locus_at_its_gains(single):
    for linear, other in single[:8]:
        found = control.root_locus(linear)
        some = np.flatnonzero(np.isfinite(found.gain))[:: max(1, len(found.gain) // 12)]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            wanted = peer.root_locus_map(other, gains=found.gain[some]).loci
        for row, poles in zip(found.poles[some], wanted, strict=True):
            near(row[np.isfinite(row)], poles, 1e-5)


def test_several_inputs_and_outputs():
    omega = np.geomspace(0.05, 50, 15)
    for linear in systems(15, 2, 3):
        other = linear.to_ss("control")
        wanted = np.moveaxis(other(1j * omega), 2, 0)
        np.testing.assert_allclose(linear.response(omega), wanted, rtol=1e-8, atol=1e-12)
        damped = peer.damp(other, doprint=False)
        ratios = sorted(mode.damping for mode in linear.modes())
        near(np.array(ratios), np.array(sorted(damped[1][damped[2].imag >= 0])), 1e-8)


def test_a_square_plant_in_a_closed_loop():
    for linear in systems(15, 2, 2):
        alone = linear.to_ss("control")
        zeros = peer.zeros(alone)  # infinite ones are NaN or 1e19 there
        near(control.transmission_zeros(linear), zeros[np.abs(zeros) < 1e9], 1e-5)
        linear = replace(linear, D=np.array([[0.3, 0.1], [-0.2, 0.5]]))
        other = peer.feedback(1.5 * linear.to_ss("control"), np.eye(2))
        closed = control.close_loop(linear, 1.5)
        near(closed.eigenvalues(), peer.poles(other))
        assert closed.inputs == tuple(f"reference {name}" for name in linear.outputs)
        omega = np.geomspace(0.05, 50, 5)
        wanted = np.moveaxis(other(1j * omega), 2, 0)
        np.testing.assert_allclose(closed.response(omega), wanted, rtol=1e-6, atol=1e-9)
