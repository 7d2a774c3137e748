"""Ropes, drums, winches and sheaves: formulas, independent integration, energy."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import bgc

GRAVITY = 9.81
STIFFNESS = 85e9 * 0.6 * np.pi / 4 * 0.02**2  # wire rope of 20 mm
MASS = 2200.0
PACKING = np.sqrt(3) / 2 * 0.02**2 / (np.pi * 3)  # r^2 = d^2/4 + PACKING wound


def tension(distance, paid, rate, loss):
    """Tension by the stretch, and damping that never pushes."""
    stretch = distance - paid
    if stretch <= 0:
        return 0.0, 0.0
    spring = STIFFNESS * stretch / paid
    return spring, max(STIFFNESS * loss / paid * rate, -spring)


def integrate(rates, start, time, **options):
    options = {"rtol": 1e-10, "atol": 1e-10, "max_step": 5e-3} | options
    answer = solve_ivp(rates, (time[0], time[-1]), start, t_eval=time, **options)
    assert answer.success
    return answer.y


def closed(result, share=1e-7):
    return np.abs(result["energy.residual"]).max() < share * result.counts["exchanged"]


@pytest.mark.parametrize("length", [2.0, 20.0, 40.0])
@pytest.mark.parametrize("loss", [0.0, 3e-3])
def test_a_load_has_the_axial_and_the_pendulum_frequency_of_its_rope(load, length, loss):
    model = load("rope", "pendulum")
    values = model.eigenvalues(parameters={"length": length, "loss": loss})
    found = np.sort_complex(values[values.imag > 1e-3])
    assert len(found) == 2
    axial = np.sqrt(STIFFNESS / (length * MASS))
    swing = np.sqrt(GRAVITY / (length * (1 + MASS * GRAVITY / STIFFNESS)))
    expected = [
        -loss * axial**2 / 2 + 1j * axial * np.sqrt(1 - (loss * axial / 2) ** 2),
        1j * swing,
    ]
    order = np.argsort(-found.imag)
    np.testing.assert_allclose(found[order], expected, rtol=1e-9)


def test_a_load_swings_on_a_rope_that_is_paid_out_and_wound_in(load):
    given = {"away": 6.0, "speed": 1.5, "loss": 5e-3}
    result = load("rope", "pendulum").simulate(parameters=given)

    def rates(t, y):
        r, v, paid = y[:2], y[2:4], y[4]
        speed = 1.5 * np.sin(2 * np.pi * t / 4)
        distance = np.hypot(*r)
        spring, loss = tension(distance, paid, r @ v / distance - speed, 5e-3)
        return [*v, *(-(spring + loss) / MASS * r / distance - [0, GRAVITY]), speed]

    hang = 20 * (1 + MASS * GRAVITY / STIFFNESS)
    x, z, _, _, paid = integrate(rates, [6, -hang, 0, 0, 20], result.time)
    np.testing.assert_allclose(result["r[1]"], x + 0.5, atol=1e-6)
    np.testing.assert_allclose(result["r[3]"], z, atol=1e-6)
    np.testing.assert_allclose(result["distance"], np.hypot(x, z), atol=1e-6)
    np.testing.assert_allclose(result["paid"], paid, atol=1e-6)
    assert np.ptp(paid) > 1.5
    assert closed(result)


def test_the_winch_bears_the_tension_and_the_energy_of_new_rope(load):
    result = load("rope", "pendulum").simulate(parameters={"away": 6.0, "speed": 1.5})
    pull = result["tension"]
    np.testing.assert_allclose(result["force"], -(pull + pull**2 / (2 * STIFFNESS)), rtol=1e-9)
    assert pull.max() > 2e4


def test_a_rope_is_drawn_between_its_points(load):
    result = load("rope", "pendulum").simulate(parameters={"away": 6.0}, shapes=True)
    (shape,) = [s for s in result.shapes if s.kind == "rope"]
    above = [0.8, -0.2, 30]  # the ground's place and `at_a`
    np.testing.assert_allclose(shape["from"], np.tile(above, (len(result.time), 1)), atol=1e-12)
    r = np.stack([result[f"r[{i}]"] for i in (1, 2, 3)], axis=1)
    np.testing.assert_allclose(shape["to"], r + np.array([0.3, -0.2, 30]), atol=1e-9)


def test_a_rope_at_another_distance_than_its_ends_is_refused(load):
    model = load("rope", "pendulum")
    with pytest.raises(bgc.BgError, match="distance0"):
        model.simulate(parameters={"wrong": 1e-3})


@pytest.mark.parametrize("loss", [0.0, 10e-3])
def test_a_load_that_falls_into_its_rope_keeps_the_account(load, loss):
    result = load("rope", "falling").simulate(parameters={"loss": loss})

    def rates(t, y):
        return [y[1], GRAVITY - sum(tension(20 + y[0], 20, y[1], loss)) / MASS]

    stretch, velocity = integrate(rates, [-0.5, 0], result.time, max_step=1e-3)
    np.testing.assert_allclose(result["stretch"], stretch, atol=2e-7)
    np.testing.assert_allclose(result["velocity"], velocity, atol=5e-6)
    pull = result["tension"]
    assert pull.min() >= 0 and pull.max() > 1e5
    slack = result["stretch"] < 0
    assert (pull[slack] == 0).all()
    # Slack and taut again, several times.
    assert np.count_nonzero(np.diff(slack.astype(int)) == 1) >= 2
    assert closed(result)
    if loss == 0:
        peak = MASS * GRAVITY * (1 + np.sqrt(1 + 2 * 0.5 * STIFFNESS / 20 / (MASS * GRAVITY)))
        assert pull.max() == pytest.approx(peak, rel=2e-3)


def drum_radius(wound):
    return np.sqrt(0.15**2 + PACKING * wound)


def test_a_winch_by_torque_and_brake_is_an_independent_model(load):
    """Gear with losses, drum that grows, rope with damping, brake from 3 s on."""
    result = load("rope", "torqued").simulate()

    def rates(t, y):
        rate, paid, distance, velocity, wound = y
        radius = drum_radius(wound)
        speed = radius * rate / 20
        spring, loss = tension(distance, paid, velocity - speed, 20e-3)
        stretching = spring**2 / (2 * STIFFNESS)
        pull = spring + stretching + loss
        torque = -250 + 200 * np.cos(np.pi * t)
        torque -= min(max((t - 3) / 0.5, 0), 1) * 400 * np.tanh(rate / 1e-3)
        # Inertias 2 and 150/20^2; the torque of the fast wheel decides about the losses.
        for share, wanted in ((1 / 0.8 - 1, 1), (1 - 0.8, -1)):
            sign = wanted * np.sign(rate) if rate else wanted
            lost = np.tanh(rate / 0.1) * share * sign
            # 2 a = torque - (1 + lost) wheel;  wheel = 150/400 a - pull radius/20
            a = (torque + (1 + lost) * pull * radius / 20) / (2 + (1 + lost) * 150 / 400)
            wheel = 150 / 400 * a - pull * radius / 20
            if wheel * sign >= 0:
                break
        return [a, speed, velocity, GRAVITY - (spring + loss) / MASS, -speed]

    start = [0, 20, 20 * (1 + MASS * GRAVITY / STIFFNESS), 0, 100]
    rate, paid, distance, _, wound = integrate(
        rates, start, result.time, method="Radau", rtol=1e-8, atol=1e-8, max_step=2e-2
    )
    np.testing.assert_allclose(result["rate"], rate, atol=1e-4)
    for name, expected in (("paid", paid), ("distance", distance), ("wound", wound)):
        np.testing.assert_allclose(result[name], expected, atol=2e-6, err_msg=name)
    assert np.ptp(paid) > 0.5 and rate.min() < -10 and rate.max() > 1
    assert abs(result["rate"][-1]) < 1e-3
    assert closed(result)


def test_the_radius_of_a_drum_at_a_given_rate_is_a_spiral(load):
    """2 r dr = PACKING dwound and dwound = -r dangle: the radius is linear in the angle."""
    result = load("rope", "rated").simulate(parameters={"rate": 200.0})
    angle = 200 / 20 * 4 / (2 * np.pi) * (1 - np.cos(np.pi * result.time / 2))
    radius = drum_radius(100.0) - PACKING * angle / 2
    np.testing.assert_allclose(result["radius"], radius, atol=1e-9)
    wound = (radius**2 - 0.15**2) / PACKING
    np.testing.assert_allclose(result["wound"], wound, atol=1e-6)
    np.testing.assert_allclose(result["paid"] + result["wound"], 120.0, atol=1e-9)
    assert np.ptp(wound) > 1.9
    assert closed(result)


@pytest.mark.parametrize("layers", [0, 1, 2, 7])
def test_full_layers_of_a_drum_have_the_length_of_their_turns(load, layers):
    width, diameter, rope = 1.2, 0.5, 0.03
    height = np.sqrt(3) / 2 * rope
    turns = width / rope
    length = sum(turns * np.pi * (diameter + (2 * k + 1) * height) for k in range(layers))
    # Enough rope for 10 ms; it is less than 1e-3 of a layer.
    given = {"width": width, "diameter": diameter, "rope_diameter": rope, "wound": length + 1e-3}
    result = load("rope", "layers").simulate(parameters=given)
    assert result["layers"][0] == pytest.approx(layers, abs=1e-4)
    assert result["radius"][0] == pytest.approx(diameter / 2 + layers * height, abs=1e-5)


@pytest.mark.parametrize("friction", [0.0, 0.05])
@pytest.mark.parametrize("speed", [-0.5, 0.5])
def test_a_sheave_takes_its_share_of_the_tension(load, friction, speed):
    result = load("rope", "reeved").simulate(parameters={"friction": friction, "speed": speed})

    def rates(t, y):
        first, second, distance, velocity, over = y
        pays = speed * np.tanh(t / 0.2)
        hang = 30 * (1 + MASS * GRAVITY / STIFFNESS)
        before = tension(hang, first, over - pays, 20e-3)
        after = tension(distance, second, velocity - over, 20e-3)
        push = sum(after) - sum(before) + (after[0] ** 2 - before[0] ** 2) / (2 * STIFFNESS)
        push -= friction * sum(after) * np.tanh(over / 1e-3)
        return [pays - over, over, velocity, GRAVITY - sum(after) / MASS, push * 0.25**2]

    strain = 1 + MASS * GRAVITY / STIFFNESS
    first, second, *_ = integrate(
        rates, [30, 20, 20 * strain, 0, 0], result.time, method="Radau", rtol=1e-9, max_step=2e-2
    )
    np.testing.assert_allclose(result["paid_first"], first, atol=1e-6)
    np.testing.assert_allclose(result["paid_second"], second, atol=1e-6)
    last = result["first"][-1], result["second"][-1]
    assert last[1] == pytest.approx(MASS * GRAVITY, rel=2e-3)
    assert last[0] / last[1] == pytest.approx(1 - np.sign(speed) * friction, abs=2e-4)
    assert closed(result)
