"""Guards of haptic couplings with devices, and the damping that a loop needs before it starts."""

from __future__ import annotations

import socket
import struct
import threading
from pathlib import Path

import numpy as np
import pytest

from bgc import compile
from bgc.runtime.model import Model
from bgc.runtime.realtime.passivity import (
    Coupling,
    Sampled,
    growth_with,
    lag_warnings,
    needed_damping,
    response,
)
from bgc.runtime.realtime.servo_binding import CapabilitiesStruct
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.structures import Status

MODELS = Path(__file__).parents[1] / "models" / "sampled_ports.bg"
WALLS = ("plain", "paid", "observed")
T, MASS, DAMPING = 1e-3, 0.25, 0.5
BOUND = DAMPING / (T / 2)  # N/m: b = K T/2


@pytest.fixture(scope="module")
def walls() -> Model:
    return compile(MODELS, scene="guards")


def stiff(value: float) -> dict[str, float]:
    return {f"{wall}.hand.stiffness": value for wall in WALLS}


def late(x: np.ndarray, end: int) -> float:
    return float(np.ptp(x[end - 1000 : end]))


def test_a_hand_buzzes_at_a_wall_unless_a_guard_acts(walls: Model) -> None:
    """At .9 of the bound the swing decays; at 2 the guards cut it at least 20 times."""
    below = walls.simulate(parameters=stiff(0.9 * BOUND))
    assert late(below["plain.x"], 5000) < 0.95 * late(below["plain.x"], 2500)
    above = walls.simulate(parameters=stiff(2 * BOUND))
    loud = late(above["plain.x"], 5000)
    assert loud > 1.5 * late(above["plain.x"], 1500)
    assert loud > 3000e-6
    assert late(above["paid.x"], 5000) < loud / 1000
    assert late(above["observed.x"], 5000) < loud / 20
    assert (
        np.abs(above["energy.residual"]).max() < 1e-6
    )  # of the two without coupling_energies: as sources


# --- the bound -----------------------------------------------------------------------------------


def spring(stiffness: float, damping: float) -> Sampled:
    """A sampled spring and damper: s is the position before, e = K x + B (x - s)/T."""
    eye, none = np.eye(3), np.zeros((3, 3))
    d = np.hstack([(stiffness + damping / T) * eye, none])
    return Sampled(none, np.hstack([eye, none]), -damping / T * eye, d)


@pytest.mark.parametrize("lag", [0, 1, 5, 20])
@pytest.mark.parametrize(("stiffness", "damping"), [(2000.0, 0.0), (0.0, 3.0), (2000.0, 3.0)])
def test_the_bound_is_that_of_colgate(stiffness: float, damping: float, lag: int) -> None:
    """K T/2 + |B|, and K T (d + 1/2) of a spring with delay."""
    turns = np.geomspace(1e-3, np.pi, 500)
    needed = needed_damping(response(spring(stiffness, damping), turns, T, lag), turns, T).max()
    if lag == 0:
        assert needed == pytest.approx(stiffness * T / 2 + damping, rel=1e-6)
    elif damping == 0:
        assert needed == pytest.approx(stiffness * T * (lag + 0.5), rel=1e-3)
    else:
        assert needed >= stiffness * T * (lag + 0.5) - damping * (2 * lag + 1)


@pytest.mark.parametrize(("part", "grows"), [(0.8, False), (1.3, True)])
def test_a_device_of_a_mass_grows_above_the_bound(part: float, grows: bool) -> None:
    """With its mass the loop of a plain spring has the same limit, b = K T/2."""
    growth = growth_with(spring(part * BOUND, 0.0), MASS, DAMPING, T, 0)
    assert (growth > 1 + 1e-6) is grows
    # A delay of one period triples what is needed.
    assert growth_with(spring(0.5 * BOUND, 0.0), MASS, DAMPING, T, 1) > 1 + 1e-6


def test_the_bound_of_a_scene_is_known_before_the_loop(walls: Model) -> None:
    """From the compiled model: K T/2 of the plain wall, K T/2 + K T with the port's damping."""
    loop = walls.realtime(0.01, parameters=stiff(2 * BOUND))
    plain, paid, observed = loop.couplings()
    loop.stop()
    assert [one.stiffness for one in (plain, paid)] == pytest.approx([2 * BOUND] * 2, rel=1e-4)
    assert plain.needed == pytest.approx(BOUND * T, rel=1e-4)
    assert observed.needed == pytest.approx(BOUND * T, rel=1e-4)
    assert paid.needed == pytest.approx(3 * BOUND * T, rel=1e-3)
    assert plain.damping == DAMPING and paid.growth < 1.002
    assert "2000 N/m needs a damping of 1 N*s/m and has 0.5" in plain.line()
    assert paid.line().endswith("guard: sampled port `paid.hand.guard.bond`")
    assert observed.line().endswith("guard: observer `observed.hand.guard`")
    # Each device has the guard of its own wall: one of three warns.
    assert (plain.guard, plain.is_whole) == ("", False) and paid.is_whole and observed.is_whole
    assert [w.code for one in (plain, paid, observed) for w in one.warnings()] == ["BG780"]
    assert "`a`" in next(plain.warnings()).message


def test_each_device_has_its_own_period_guard_and_damping() -> None:
    """A wall at 4 ms needs K 4T/2; a spring beside a port K T/2 more; a damper its own |B|."""
    model = compile(MODELS, scene="unequal")
    loop = model.realtime(0.01)
    slow, beside, drag = loop.couplings()
    loop.stop()
    assert (slow.samples, slow.period) == (4, pytest.approx(4 * T))
    assert slow.stiffness == pytest.approx(1000, rel=1e-4)
    assert slow.needed == pytest.approx(1000 * 4 * T / 2, rel=1e-4)
    assert "1000 N/m, held over 4 samples needs" in slow.line()
    assert beside.stiffness == pytest.approx(1600, rel=1e-4) and not beside.is_whole
    assert beside.needed == pytest.approx(1600 * T / 2 + 1000 * T, rel=1e-3)
    assert beside.line().endswith("`beside.hand.guard.bond`, of a part of the force")
    assert drag.guard == "" and drag.needed == pytest.approx(3.0, rel=1e-3)


def test_the_lag_of_a_device_is_that_of_its_own_port(walls: Model) -> None:
    """BG782 concerns the port that reads the device, and no other."""
    instance = walls.parameters.instance({})
    instance.reset()
    late = CapabilitiesStruct(lag=5, echoes=1)
    assert not [*lag_warnings(walls, instance, {"a": late, "c": late})]
    assert len([*lag_warnings(walls, instance, {"a": late, "b": late})]) == 1


def test_a_loop_that_is_not_passive_is_a_warning() -> None:
    """BG780 without a guard, BG781 where the mass of the device lets it grow."""
    facts = Coupling("hand", T, 0, 2000.0, 1.0, 0.2, None, 0.5, "")
    (warning,) = facts.warnings()
    assert warning.code == "BG780" and "lower the stiffness" in warning.help
    (damper,) = Coupling("hand", T, 0, 200.0, 9.0, 0.2, None, 0.5, "").warnings()
    assert "0.1 of it for the stiffness" in damper.message and "lower the damping" in damper.help
    guarded = Coupling("hand", T, 0, 2000.0, 1.0, 0.2, 1.0, 0.5, "sampled port `tip`")
    assert not [*guarded.warnings()]
    partly = Coupling("hand", T, 0, 2000.0, 1.0, 0.2, 1.0, 0.5, "observer `tip`", is_whole=False)
    assert [w.code for w in partly.warnings()] == ["BG780"]
    growing = Coupling("hand", T, 0, 2e6, 1e3, 0.2, 1.5, 0.5, "sampled port `tip`")
    assert [w.code for w in growing.warnings()] == ["BG781"]
    unknown = Coupling("hand", T, 0, 2000.0, 1.0, 0.2, None, 0.0, "")
    assert not [*unknown.warnings()]


def test_a_port_that_does_not_know_the_delay_of_its_device_is_a_warning(walls: Model) -> None:
    """BG782 where the device states more lag than the port has, or does not say what it held."""

    def found(known: float, lag: int, echoes: int) -> list[str]:
        instance = walls.parameters.instance({"paid.hand.lag": known})
        instance.reset()
        devices = {"b": CapabilitiesStruct(lag=lag, echoes=echoes)}
        return [f"{w.code} {w.message}" for w in lag_warnings(walls, instance, devices)]

    assert found(0, 0, 0) == found(5, 5, 1) == found(6, 5, 1) == []
    (late,) = found(4, 5, 1)
    port = "the sampled port `paid.hand.guard.bond`"
    assert late == f"BG782 `b` has a delay of 5 samples, {port} a lag of 4"
    (silent,) = found(5, 5, 0)
    assert silent.startswith("BG782 `b` does not say which force it held") and port in silent


def test_a_recording_replays_the_force_that_the_hand_held(walls: Model, tmp_path: Path) -> None:
    """The ramp lets less through than the ports ask for; their books have what was held."""
    loop = walls.realtime(0.3, record=tmp_path / "motion.csv", parameters=stiff(2 * BOUND))
    loop.run_here()
    devices = {name: str(tmp_path / f"motion_{name}.csv") for name in loop.devices}
    again = walls.simulate(0.3, devices=devices, parameters=stiff(2 * BOUND))
    for k, column in enumerate(loop.columns):
        if column in again.columns:
            np.testing.assert_array_equal(again[column][: len(loop.rows)], loop.rows[:, k])
    held = np.loadtxt(devices["b"], delimiter=",", skiprows=1)
    header = Path(devices["b"]).read_text().partition("\n")[0].split(",")
    force, asked = np.abs(held[:, header.index("hx")]), np.abs(again["paid.force"])
    assert (force[1:] <= asked[: len(force) - 1]).all()
    assert (force[2:] < asked[1 : len(force) - 1]).sum() > 50


# --- through a network ---------------------------------------------------------------------------


class FarDevice:
    """A hand on a wall behind datagrams: 0.25 kg with a push, exactly discretised.

    Poses and forces are late by half of `delay` and up to `jitter` samples, or lost.
    """

    def __init__(self, port: int, delay: int, loss: float, jitter: int, seed: int) -> None:
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind(("127.0.0.1", 0))
        self.socket.setblocking(False)
        self.address = ("127.0.0.1", port)
        self.delay, self.loss, self.jitter = delay, loss, jitter
        self.draw = np.random.default_rng(seed)
        self.x = self.v = self.force = self.work = self.least = 0.0
        self.number, self.known, self.answered = 1, 0, 0
        self.poses: list[tuple[int, bytes]] = []
        self.forces: list[tuple[int, int, int, float]] = []
        self.places: list[float] = []
        fade = np.exp(-DAMPING / MASS * T)
        travel = (1 - fade) * MASS / DAMPING
        self.fade, self.travel, self.push = fade, travel, travel / MASS
        self.rise = (T - travel) / DAMPING

    def lost(self) -> bool:
        return bool(self.draw.random() < self.loss)

    def late(self, half: int) -> int:
        return half + int(self.draw.integers(0, self.jitter + 1))

    def pose(self, number: int, stamp: float) -> bytes:
        """A datagram with the work of the held force, and the pose that it answers."""
        pose = [self.x, 0, 0, 1.0, 0, 0, 0, self.v, *[0.0] * 14]
        return struct.pack(
            "<4sIQd22ddQ", b"BGCP", 3, number, stamp, *pose, self.work, self.answered
        )

    def send(self, tick: int) -> None:
        """Send the present pose on its way, and deliver those that have arrived."""
        self.number += 1
        text = self.pose(self.number, tick * T)
        if not self.lost():
            self.poses.append((tick + self.late(self.delay // 2), text))
        for _, ready in (one for one in self.poses if one[0] <= tick):
            self.socket.sendto(ready, self.address)
        self.poses = [one for one in self.poses if one[0] > tick]

    def move(self, tick: int) -> None:
        """Take the forces that have arrived, the newest, and move by a sample under it."""
        while True:
            try:
                answer = struct.unpack("<4sIQQ8d", self.socket.recv(100))
            except BlockingIOError:
                break
            if not self.lost():
                due = tick + self.late(self.delay - self.delay // 2)
                self.forces.append((due, answer[2], answer[3], answer[5]))
        for _, number, pose, force in (one for one in self.forces if one[0] <= tick):
            if number > self.known:
                self.known, self.answered, self.force = number, pose, force
        self.forces = [one for one in self.forces if one[0] > tick]
        total, before = 1.0 + self.force, self.x
        self.x += self.travel * self.v + self.rise * total
        self.v = self.fade * self.v + self.push * total
        self.work += self.force * (self.x - before)
        self.least = min(self.least, -self.work)
        self.places.append(self.x)


def opened(instance: Instance, index: int, **network: float) -> FarDevice:
    """A far device, and the driver `udp` of the model open to it."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    device = FarDevice(port, **network)
    stop = threading.Event()

    def first_pose() -> None:
        while not stop.wait(0.005):
            device.socket.sendto(device.pose(1, 0.0), device.address)

    sender = threading.Thread(target=first_pose)
    sender.start()
    driver = instance.find_driver(b"udp")
    assert driver is not None
    status, message = instance.open_device(index, driver, f"port={port}\nwait=20\n")
    stop.set()
    sender.join()
    assert status is Status.OK, message
    return device


def test_a_port_follows_the_lag_that_its_device_measures(walls: Model) -> None:
    """The lag of a pose is what the link adds; the damping is K T (lag + 1) of the largest lately.

    Nothing is given out that was not taken, also where the link is slower than was stated.
    """
    for delay, jitter, known in ((6, 2, 29.0), (20, 3, 29.0), (20, 3, 12.0)):
        instance = _far_walls(walls, 70.0, known)
        far = opened(instance, 1, seed=7, delay=delay, loss=0.1, jitter=jitter)
        names = [variable.name for variable in walls.measured]
        ages, rows = [], np.empty((1, len(names)))
        instance.reset()
        for tick in range(3000):
            far.send(tick)
            assert instance.run(np.array([tick * T]), rows)[0] is Status.OK
            far.move(tick)
            ages.append(rows[0, names.index("age")])
        instance.close_devices()
        far.socket.close()
        found = np.array(ages[500:]) / T - 1
        assert delay - 1e-9 <= found.min() <= delay + 1 and found.max() < delay + 2 * jitter + 12
        paid = rows[0, names.index("paid_lag")]
        forgotten = known * T * np.arange(len(found))[::-1]  # `lag` in a second
        past = np.minimum(found, known) - forgotten
        assert paid == pytest.approx(past.max(), abs=1e-9)
        assert far.least >= -1e-9 and np.ptp(far.places[-1000:]) < 0.5e-3


def _far_walls(walls: Model, stiffness: float, lag: float) -> Instance:
    return walls.parameters.instance(
        {**stiff(stiffness), **{f"{wall}.hand.lag": lag for wall in WALLS}}
    )


def test_a_port_behind_a_network_never_gives_more_than_it_took(walls: Model) -> None:
    """20 ms of delay, 10 % loss, 3 ms of jitter each way, at half of the largest stiffness.

    The observer has no damping for the lag: it lets energy out first.
    """
    lag, stiffness = 29.0, 70.0
    instance = _far_walls(walls, stiffness, lag)
    network = {"delay": 20, "loss": 0.1, "jitter": 3}
    plain, paid, observed = (opened(instance, k, seed=k + 1, **network) for k in range(3))
    far = (plain, paid, observed)
    instance.reset()
    rows = np.empty((1, walls.library.model.n_output))
    for tick in range(5000):
        for device in far:
            device.send(tick)
        assert instance.run(np.array([tick * T]), rows)[0] is Status.OK
        for device in far:
            device.move(tick)
    instance.close_devices()
    for device in far:
        device.socket.close()
    assert paid.least >= -1e-9 and np.ptp(paid.places[-1000:]) < 5e-6
    assert plain.least < -1.0 and np.ptp(plain.places[-1000:]) > 0.1
    assert -0.1 < observed.least < -1e-3
    names = [variable.name for variable in walls.measured]
    booked = rows[0, names.index("paid_supplied")]
    assert booked == pytest.approx(-paid.work, abs=2e-4)  # but for what is under way
