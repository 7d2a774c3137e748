"""The hydraulic library against closed forms: laws, powers, passivity, extremes, ranges."""

from __future__ import annotations

import numpy as np
import pytest
from refusals import refusals
from scipy.integrate import cumulative_trapezoid, solve_ivp
from scipy.optimize import brentq

from bgc.diagnostics.diagnostic import BgError

BAR, LPM, ATMOSPHERE, MODULUS = 1e5, 1e-3 / 60, 1.01325e5, 1.6e9
SIZE = 240 * LPM / np.sqrt(10 * BAR)  # flow for each root of pressure


def root(difference, small=0.1 * BAR):
    """The square root of a pressure difference with its sign, linear near zero."""
    return difference / (difference**2 + small**2) ** 0.25


def strain(pressure, air, stiffening=0.0, modulus=MODULUS):
    """Strain of oil and isothermal air, by adding their volumes."""
    linear = pressure
    if stiffening:
        linear = modulus / stiffening * (np.sqrt(1 + 2 * stiffening * pressure / modulus) - 1)
    return linear / modulus + air * (1 - ATMOSPHERE / (linear + ATMOSPHERE))


@pytest.mark.parametrize(
    ("high", "low", "pilot", "opening"),
    [(100, 20, 110, 0.5), (20, 100, 40, 1), (60, 59.99, 0, 7), (1000, 1000 - 1e-7, 900, 0)],
)
def test_restrictions_pass_what_their_data_sheet_says(load, high, low, pilot, opening):
    given = {"high": high * BAR, "low": low * BAR, "pilot": pilot * BAR, "opening": opening}
    result = load("hydraulics", "restrictions").simulate(parameters=given)
    drop = (high - low) * BAR
    check = SIZE * root(max(drop - 0.5 * BAR, 0), BAR)
    hold = np.clip((pilot - 20) / 180, 0, 1)
    relief = np.clip((drop / BAR - 70) / 20, 0, 1) * 240 * LPM / np.sqrt(90 * BAR)
    against = max(-drop - 0.5 * BAR, 0)
    expected = {
        "throttle": min(opening, 1) * SIZE * root(drop),
        "check": check,
        "against": -1e-3 * LPM / BAR * drop + SIZE * root(against, BAR),
        "relief": relief * root(drop),
        "hold": check + hold * SIZE * root(drop),
        "sensing": 240 * LPM / np.sqrt(5 * BAR) * root(drop),
    }
    for name, flow in expected.items():
        assert result[name][-1] == pytest.approx(flow, rel=1e-6, abs=1e-14), name
    assert result["hold_opening"][-1] == pytest.approx(hold, abs=1e-9)
    assert min(result["taken"].min(), 0) > -1e-9, "no restriction gives power"
    assert np.abs(result["energy.residual"]).max() <= 1e-9 * result.counts["exchanged"]


@pytest.mark.parametrize("flow", [30, -0.3, -30])
def test_a_volume_follows_the_law_of_oil_and_air_into_cavitation(load, flow):
    given = {"flow": flow * LPM, "store.charge0": 2e-4}
    result = load("hydraulics", "volumes").simulate(parameters=given)
    pressure, oil = result["pressure"], result["oil"]
    clear = pressure > -0.999 * ATMOSPHERE
    np.testing.assert_allclose(
        oil[clear] / 1e-3, strain(pressure[clear], 0.01, 10), rtol=1e-7, atol=1e-9
    )
    assert (pressure > -ATMOSPHERE).all(), "no absolute pressure below zero"
    if flow == -30:
        assert pressure.min() < -0.9 * ATMOSPHERE, "drawn empty"
    # The wall pressure is what the energy V g(q/V) loses by growing: p = e (1 + s) - g.
    stored = cumulative_trapezoid(pressure, oil, initial=0) / 1e-3
    moved = result["wall"] - pressure * (1 + oil / 1e-3)
    scale = np.abs(pressure).max()
    np.testing.assert_allclose(moved - moved[0], -stored, atol=2e-4 * scale)
    assert np.abs(result["energy.residual"]).max() < 1e-8 * result.counts["exchanged"]


def test_an_accumulator_follows_the_polytropic_law_and_closes_its_neck(load):
    model = load("hydraulics", "volumes")
    result = model.simulate()
    volume, charge = 1e-3, result["charge"]
    law = (90 * BAR + ATMOSPHERE) * (volume / (volume - charge)) ** 1.2 - ATMOSPHERE
    np.testing.assert_allclose(result["store_pressure"], law, rtol=1e-9)
    empty = model.simulate(parameters={"flow": -30 * LPM})
    assert empty["charge"].min() < -5e-5
    assert empty["store_pressure"].min() > -ATMOSPHERE
    assert np.abs(empty["energy.residual"]).max() < 1e-8 * empty.counts["exchanged"]
    with pytest.raises(BgError, match="accumulator is full"):
        model.simulate(parameters={"flow": 300 * LPM})


def test_a_lumped_line_has_the_quarter_wave_of_its_pieces(load):
    """n pieces: the frequency of the continuous line times sin(x)/x with x = pi/(4 n)."""
    values = load("hydraulics", "lumped").eigenvalues(
        parameters={"line.bulk_modulus": MODULUS, "line.air": 1e-6}
    )
    lowest = np.sort(values.imag[values.imag > 1])[0] / (2 * np.pi)
    x = np.pi / 32
    expected = np.sqrt(MODULUS / 900) / (4 * 10) * np.sin(x) / x
    assert lowest == pytest.approx(expected, rel=2e-4)
    assert values.real.max() <= 1e-9, "passive"


@pytest.mark.parametrize("reynolds", [1e-3, 300, 4000, -20000])
def test_friction_of_a_line_is_laminar_and_then_that_of_blasius(load, reynolds):
    diameter, length, density, viscosity = 0.02, 10, 900, 3.2e-5
    flow = reynolds * np.pi * diameter * viscosity / 4
    drop = load("hydraulics", "friction").simulate(parameters={"flow": flow})["drop"][-1]
    factor = 64 / abs(reynolds) if abs(reynolds) < 1188 else 0.3164 / abs(reynolds) ** 0.25
    speed = flow / (np.pi / 4 * diameter**2)
    expected = factor * length / diameter * density / 2 * speed * abs(speed)
    assert drop == pytest.approx(expected, rel=3e-3)


def test_pump_and_motor_balance_their_flows_and_torques(load):
    result = load("hydraulics", "machines").simulate(parameters={"load": 300})
    pressure, rate = result["pressure"][-1], result["rate"][-1]
    leak = 0.01 * LPM / BAR
    big, small = 0.2e-3 / (2 * np.pi), 0.1e-3 / (2 * np.pi)
    assert rate > 1
    assert big * pressure == pytest.approx(300 + 0.1 * rate, rel=1e-4)
    swash = np.clip((200 * BAR - pressure) / (20 * BAR), 0, 1)
    assert result["swash"][-1] == pytest.approx(swash)
    delivered = swash * small * result["pump_rate"][-1] - leak * pressure
    assert result["flow"][-1] == pytest.approx(delivered, rel=1e-9)
    assert delivered == pytest.approx(big * rate + leak * pressure, rel=1e-4)
    assert result["pump_torque"][-1] == pytest.approx(swash * small * pressure)
    assert np.diff(result["energy.dissipated"]).min() > -1e-6
    assert np.abs(result["energy.residual"]).max() < 1e-8 * result.counts["exchanged"]


def test_an_overloaded_motor_turns_back_and_the_pump_limits_its_pressure(load):
    result = load("hydraulics", "machines").simulate(parameters={"load": 2000})
    assert result["rate"][-1] < 0
    assert result["swash"].min() >= 0
    assert np.abs(result["energy.residual"]).max() < 1e-8 * result.counts["exchanged"]


AREA, RING = np.pi / 4 * 0.16, np.pi / 4 * (0.16 - 0.09)


@pytest.mark.parametrize("extension", [0.05, 0.8, 1.5])
def test_shut_oil_is_a_spring_that_changes_with_the_stroke(load, extension):
    """k = K (A^2/V + ..), here at low pressure, where air is isothermal and nearly absent."""
    given = {"cylinder.extension0": extension, "cylinder.air": 1e-6, "force": 0.0}
    values = load("hydraulics", "full").eigenvalues(parameters=given)
    front, back = 0.01 + AREA * extension, 0.01 + RING * (1.6 - extension)
    # Second derivative of V g(n/V - 1) by V: K (1 + s)^2/V; s is the strain.
    s = np.array([28.125, 64.2857142857]) * BAR / MODULUS
    stiffness = MODULUS * (AREA**2 * (1 + s[0]) ** 2 / front + RING**2 * (1 + s[1]) ** 2 / back)
    assert values.imag.max() == pytest.approx(np.sqrt(stiffness / 5000), rel=1e-4)


def test_shut_ports_hold_a_rod_for_ever(load):
    """A load of 1 MN moves the rod until the pressures carry it, and not further."""
    given = {"force": 1e6, "cylinder.friction": 2e6, "mass": 1000.0}
    result = load("hydraulics", "full").simulate(parameters=given)

    def pressure_of(p, given):
        return strain(p, 1e-6) - given

    def force(x):
        """Force of both chambers on the rod."""
        oil = np.array([(0.01 + AREA * 0.8), (0.01 + RING * 0.8)])
        oil *= 1 + strain(np.array([28.125, 64.2857142857]) * BAR, 1e-6)
        s = oil / np.array([0.01 + AREA * x, 0.01 + RING * (1.6 - x)]) - 1
        e = np.array(
            [brentq(pressure_of, (1e-9 - 1) * ATMOSPHERE, 2e8, args=(each,)) for each in s]
        )
        energy = e**2 / (2 * MODULUS) + 1e-6 * ATMOSPHERE * np.log1p(e / ATMOSPHERE)
        wall = (1 + s) * e - energy
        return AREA * wall[0] - RING * wall[1] - 1e6

    at_rest = brentq(force, 0.79, 0.801)
    assert result["extension"][-1] == pytest.approx(at_rest, abs=1e-8)
    assert abs(result["speed"][-1]) < 1e-9, "and does not sink"


@pytest.mark.parametrize(("extension", "speed"), [(1.599, 3.0), (0.001, -3.0)])
def test_end_stops_take_energy_and_never_give_it(load, extension, speed):
    given = {
        "cylinder.extension0": extension,
        "speed0": speed,
        "mass": 2000.0,
        "cylinder.bulk_modulus": 1e6,
        "cylinder.pressure0": (0.0, 0.0),
    }
    result = load("hydraulics", "full").simulate(parameters=given)
    stiffness = 300 * BAR * AREA / 0.01

    def slope(_, state):
        """Motion of the mass on the stop alone: the oil is 200 times as soft."""
        depth, inwards = state
        return [inwards, -stiffness * depth * (1 + 2 * inwards) / 2000]

    alone = solve_ivp(slope, (0, 0.01), [0, abs(speed)], rtol=1e-8, atol=1e-12)
    beyond = np.maximum(result["extension"] - 1.6, -result["extension"])
    assert beyond.max() == pytest.approx(alone.y[0].max(), rel=0.03)
    assert result["stop_power"].min() >= 0
    assert result["energy.dissipated"][-1] > 0.01 * 0.5 * 2000 * speed**2
    kinetic = 0.5 * 2000 * speed**2
    assert np.abs(result["energy.residual"]).max() < 1e-7 * kinetic


def test_a_rod_thrown_through_its_cylinder_ends_the_run(load):
    """The pressure grows without bound as a chamber vanishes; only a step too long gets across."""
    with pytest.raises(BgError, match="dead_volume"):
        load("hydraulics", "full").simulate(
            solver="lie", step=1e-3, parameters={"speed0": -2000.0, "mass": 1e9}
        )


@pytest.mark.parametrize("rate", [0.5, -2])
def test_an_ideal_cylinder_is_two_areas(load, rate):
    result = load("hydraulics", "ideal").simulate(parameters={"rate": rate})
    assert result["flow_a"][-1] == pytest.approx(AREA * rate)
    assert result["flow_b"][-1] == pytest.approx(-RING * rate)
    push = AREA * 80 * BAR - RING * 30 * BAR - 1000 * rate
    assert result["force"][-1] == pytest.approx(-push)
    assert result["energy.dissipated"][-1] == pytest.approx(1000 * rate**2)
    assert np.abs(result["energy.residual"]).max() < 1e-9 * result.counts["exchanged"]


def test_levels_of_a_cylinder_agree_where_they_should(load):
    """Chambers of constant volume have the stiffness of the full cylinder at half its stroke."""
    values = load("hydraulics", "lumped_cylinder").eigenvalues()
    stiffness = MODULUS * (AREA**2 / (0.01 + AREA * 0.8) + RING**2 / (0.01 + RING * 0.8))
    soft = 1 / (1 + 1e-6 * MODULUS / ATMOSPHERE)  # air at no pressure
    assert values.imag.max() == pytest.approx(np.sqrt(soft * stiffness / 5000), rel=1e-4)


@pytest.mark.parametrize("command", [0.5, -0.8, 0.05, 30])
def test_four_edges_between_given_pressures(load, command):
    result = load("hydraulics", "valve").simulate(parameters={"command": command})
    x = np.clip(command, -1, 1)
    out, back = (np.clip((s * x - 0.1) / 0.9, 0, 1) for s in (1, -1))
    leak = 1e-3 * LPM / BAR

    def edge(opening, drop):
        return leak * drop * BAR + opening * SIZE * root(drop * BAR)

    into_a, from_a = edge(out, 200 - 120), edge(back, 120)
    into_b, from_b = edge(back, 200 - 60), edge(out, 60)
    assert result["a"][-1] == pytest.approx(into_a - from_a, rel=1e-9)
    assert result["b"][-1] == pytest.approx(into_b - from_b, rel=1e-9)
    assert result["p"][-1] == pytest.approx(into_a + into_b, rel=1e-9)
    assert result["t"][-1] == pytest.approx(from_a + from_b, rel=1e-9)
    sensed = (120 if out > 0 else 60 if back > 0 else 0) * BAR
    assert result["load"][-1] == pytest.approx(sensed, rel=1e-3, abs=1)
    assert result["energy.dissipated"][-1] > 0


def test_spools_and_swash_plates_follow_their_closed_forms(load):
    result = load("hydraulics", "spools").simulate()
    t = result.time
    np.testing.assert_allclose(result["lag"], 1 - np.exp(-t / 0.05), atol=1e-7)
    np.testing.assert_allclose(result["swash"], -1 + np.exp(-t / 0.1), atol=1e-7)
    w, zeta = 2 * np.pi * 10, 0.5
    damped = w * np.sqrt(1 - zeta**2)
    free = 1 - np.exp(-zeta * w * t) * (np.cos(damped * t) + zeta * w / damped * np.sin(damped * t))
    np.testing.assert_allclose(result["oscillating"], np.minimum(free, 1), atol=1e-7)


def test_a_whole_axis_lifts_holds_lowers_and_stops(load):
    result = load("hydraulics", "axis").simulate()
    t, speed = result.time, result["speed"]
    lifting = (t > 2) & (t < 2.9)
    margin = result["feed"] - result["load_pressure"]
    assert 10 * BAR < margin[lifting].min() <= margin[lifting].max() < 12 * BAR
    # The compensator makes the flow that of the spool alone; oil under pressure takes less room.
    flow = SIZE * np.sqrt(margin[lifting]) / (1 + strain(result["front"][lifting], 0.002))
    assert speed[lifting].mean() == pytest.approx(flow.mean() / AREA, rel=1e-3)
    holding = (t > 4) & (t < 4.9)
    assert np.ptp(result["way"][holding]) < 2e-5
    lowering = (t > 8) & (t < 12)
    assert (speed[lowering] < -0.03).all()
    assert -0.01 < result["extension"].min() < -1e-4, "on its stop"
    assert (result["back"] > -ATMOSPHERE).all()
    assert np.diff(result["energy.dissipated"]).min() > -1e-3
    assert np.abs(result["energy.residual"]).max() < 1e-8 * result.counts["exchanged"]


OUTSIDE = {
    "restrictions": {
        "throttle.flow": -1.0,
        "throttle.drop": 0.0,
        "check.cracking": -1.0,
        "relief.band": 0.0,
        "hold.lag": 0.0,
        "sensing.small": 0.0,
    },
    "volumes": {"oil.volume": 0.0, "oil.air": 0.0, "store.precharge": 0.0, "store.exponent": 0.9},
    "friction": {"line.length": 0.0, "line.diameter": -0.02},
    "lumped": {"line.viscosity": 0.0, "line.density": 0.0},
    "machines": {"pump.displacement": 0.0, "motor.displacement": -1e-4, "pump.control.band": 0.0},
    "full": {"cylinder.bore": 0.0, "cylinder.stroke": -1.0, "cylinder.bulk_modulus": 0.0},
    "valve": {"valve.dead_band": 1.0, "valve.flow": -1.0},
    "axis": {"drive.circuit.volume": 0.0, "drive.circuit.valve.spool.lag": 0.0},
}


@pytest.mark.parametrize("scene", OUTSIDE)
def test_values_outside_their_ranges_are_diagnosed(load, scene):
    model = load("hydraulics", scene)
    for name, value in OUTSIDE[scene].items():
        assert refusals(model.simulate, parameters={name: value})[0].code == "BG061", name


def characteristics(closing, times, n=600):
    """Pressure at the valve by the method of characteristics in pressures and flows, n reaches."""
    sound, area, flow0 = np.sqrt(2.2e6), np.pi / 4 * 0.01, np.pi / 4 * 0.01
    z, step, tank = 1000 * sound / area, 300 / n / sound, 25 * BAR

    def drop(q):
        reynolds = 4 * np.abs(q) / (np.pi * 0.1 * 1e-6)
        laminar = 128 * 1000 * 1e-6 * 300 / n / (np.pi * 0.1**4) * q
        return laminar * (1 + (reynolds / 1188) ** 4) ** (3 / 16)

    q = np.full(n + 1, flow0)
    p = tank - np.arange(n + 1) * drop(flow0)
    at, found = 0.0, []
    for wanted in times:
        while at < wanted:
            at += step
            ahead = p[:-1] + z * q[:-1] - drop(q[:-1])  # arrive at 1 .. n
            back = p[1:] - z * q[1:] + drop(q[1:])  # arrive at 0 .. n - 1
            p[1:-1], q[1:-1] = (ahead[:-1] + back[1:]) / 2, (ahead[:-1] - back[1:]) / (2 * z)
            p[0], q[0] = tank, (tank - back[0]) / z
            q[-1] = flow0 * (1 - np.clip((at - 0.2) / closing, 0, 1))
            p[-1] = ahead[-1] - z * q[-1]
        found.append(p[-1])
    return np.array(found)


@pytest.mark.parametrize(("scene", "error"), [("closing", 0.03), ("closing_fine", 0.01)])
def test_a_line_of_characteristics_agrees_with_a_fine_grid(load, scene, error):
    """A valve that closes in 0.15 s, 0.37 of the time of a wave to the tank and back."""
    result = load("hydraulics", scene).simulate(error=False)
    expected = characteristics(0.15, result.time)
    size = np.ptp(expected)
    difference = np.abs(result["pressure"] - expected)
    assert np.sqrt((difference**2).mean()) < error * size
    assert result["pressure"].max() == pytest.approx(expected.max(), rel=5e-3)


def test_an_instant_closure_gives_joukowskys_pressure(load):
    result = load("hydraulics", "closing").simulate(
        parameters={"closing": 1e-6}, error=False, every=2e-3
    )
    before, after = (result["pressure"][np.searchsorted(result.time, t)] for t in (0.19, 0.206))
    assert after - before == pytest.approx(1000 * np.sqrt(2.2e6), rel=1e-9)
    # Until it is back, friction that no longer acts adds to it; no volume is lost.
    packed = result["pressure"][np.searchsorted(result.time, 0.59)] - after
    assert 0 < packed < 1 * BAR
    stored = (result["entered"] - result["passed"])[-1]
    assert abs(stored) < 300 * np.pi / 4 * 0.01 * 20 * BAR / 2.2e9


def test_a_line_of_characteristics_never_gives_more_than_it_took(load):
    result = load("hydraulics", "shaken").simulate(error=False)
    assert result["taken"].min() > -1e-9
    assert result["taken"].max() > 1
