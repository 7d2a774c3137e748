"""Passivity of a servo loop before it starts: the damping that its sampled force needs.

The model from the position of a device to the force on it is linearised from sample to sample, by
differences of the compiled model itself: with its couplings, its guard and its method. With H(z)
from position to the force that resists it, a hand and device of damping b are stable with it if

    b > T/2 Re{(1 - e^{-jwT}) H(e^{jwT})}/(1 - cos wT)        for all w up to pi/T

(Colgate and Schenkel 1997): b > K T/2 + |B| for a spring K and a damper B, and K T (d + 1/2) for a
spring with d samples of delay. Of several axes the least favourable direction counts.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Iterator, Mapping
from ctypes import (
    CFUNCTYPE,
    POINTER,
    Structure,
    c_char_p,
    c_double,
    c_int,
    c_size_t,
    c_uint32,
    c_void_p,
)
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np

from bgc.diagnostics.catalogue import realtime as messages
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.ir.port_facts import ForceFacts
from bgc.record_class import dataclass, replace
from bgc.runtime.realtime.servo_binding import CapabilitiesStruct
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.port_bounds import number_of, parameter_places
from bgc.runtime.running.structures import OptionsStruct, Status

_POSE, _EFFORT = 27, 7  # doubles
_VELOCITY = 7  # first double of the velocity in a pose
_DEVICE_ABI = 2
_RTOL = 1e-9
_POSITION_STEP = 1e-6  # m
_SHIFT = 1e-3  # m: a wall near the start is touched from both sides
_MOVING, _RESTING = 20, 10  # samples
_FREQUENCIES = 400
_MUCH = 30.0  # N s/m: more than a hand and a device have
_OBSERVER = "observer"
_MOST_SAMPLES = 64  # of a device in one period of a slower part
_GROWTH = 2e-3  # of an unstable motion, in a sample


@dataclass(frozen=True, slots=True)
class Coupling:
    """The force of a model on a device, as a function of its position.

    Attributes
    ----------
    device
        Name of the device.
    period
        Time between two forces, s: a multiple of that between two samples of the device where a
        sampled part between them is slower.
    lag
        Delay, at worst, from a position to the force that answers it, in samples of the device.
    stiffness
        Stiffness at rest, N/m.
    needed
        Damping of hand and device that the loop needs, N s/m.
    frequency
        The frequency at which it does, Hz.
    growth
        Factor from sample to sample of the loop's slowest or fastest growing motion with the mass
        and the damping that the device states; None where it states no mass.
    damping
        Damping that the device states, N s/m; 0: not known.
    guard
        What keeps the loop passive all the same: a sampled port, an observer, or nothing. It is
        that of this device.
    is_whole
        Whether the guard makes the whole force. A part beside it needs damping, as without one.
    samples
        Samples of the device in a period.
    """

    device: str
    period: float
    lag: float
    stiffness: float
    needed: float
    frequency: float
    growth: float | None
    damping: float
    guard: str
    is_whole: bool = True
    samples: int = 1

    def line(self) -> str:
        """The coupling as a line of text."""
        delay = f" with {self.lag:.2g} samples of delay" if self.lag else ""
        part = "" if self.is_whole else ", of a part of the force"
        guard = f"; guard: {self.guard}{part}" if self.guard else ""
        if not self.stiffness and not self.needed:
            return f"`{self.device}`: its force does not depend on its position at the start{guard}"
        have = f" and has {self.damping:.3g}" if self.damping else ""
        slow = f", held over {self.samples} samples" if self.samples > 1 else ""
        return (
            f"`{self.device}`: {self.stiffness:.4g} N/m{slow}{delay} needs a damping of "
            f"{self.needed:.4g} N*s/m{have} (b > K T/2 + |B|, at {self.frequency:.3g} Hz){guard}"
        )

    def warnings(self) -> Iterator[Diagnostic]:
        """Warn of a loop that may buzz or grow."""
        have = self.damping or _MUCH
        is_guarded = bool(self.guard) and self.is_whole
        observed = is_guarded and self.guard.startswith(_OBSERVER)
        if self.growth is not None and self.growth > 1 + _GROWTH and not observed:
            yield messages.loop_grows(self.device, self.growth, self.period)
        elif not is_guarded and self.needed > have:
            of_stiffness = min(self.stiffness * self.period * (0.5 + self.lag), self.needed)
            yield messages.not_passive(
                self.device, self.needed, of_stiffness, self.damping, self.stiffness
            )


# --- the model from sample to sample --------------------------------------------------------


_Open = CFUNCTYPE(c_void_p, c_char_p, c_char_p, c_size_t)
_Read = CFUNCTYPE(c_int, c_void_p, c_double, POINTER(c_double))
_Write = CFUNCTYPE(c_int, c_void_p, c_double, POINTER(c_double))
_Close = CFUNCTYPE(None, c_void_p)


class _Driver(Structure):
    _fields_: ClassVar[list[tuple[str, Any]]] = [
        ("abi", c_uint32),
        ("name", c_char_p),
        ("open", _Open),
        ("read", _Read),
        ("write", _Write),
        ("close", _Close),
        ("capabilities", c_void_p),
        ("last_error", c_void_p),
    ]


class _Stand:
    """A driver in Python that gives a pose and keeps the effort."""

    def __init__(self) -> None:
        self.pose, self.effort = np.zeros(_POSE), np.zeros(_EFFORT)
        self.driver = _Driver(
            _DEVICE_ABI,
            b"probe",
            _Open(lambda options, message, size: 1),
            _Read(self._read),
            _Write(self._write),
            _Close(lambda handle: None),
        )

    @property
    def address(self) -> int:
        return ctypes.addressof(self.driver)

    def _read(self, handle: int, time: float, pose: Any) -> int:
        for k in range(_POSE - 4):  # the runtime knows what was held
            pose[k] = self.pose[k]
        return 0

    def _write(self, handle: int, time: float, effort: Any) -> int:
        self.effort[:] = effort[:_EFFORT]
        return 0


class _Probe:
    """A copy of a model at the start of a loop: one sample as a function of state and pose."""

    def __init__(self, instance: Instance, width: int, device: int) -> None:
        self._instance, self._rows = instance, np.empty((1, width))
        self._stands = [_Stand() for _ in range(instance.library.model.n_device)]
        for k, stand in enumerate(self._stands):
            instance.open_device(k, stand.address, "")
        self.stand = self._stands[device]
        model, inputs = instance.library.model, instance.input
        for k in range(model.n_input):
            use = model.input[k]
            if use.device >= 0 and use.channel < 6:
                first = (0, 3, _VELOCITY, 10, 13, 14)[use.channel]
                self._stands[use.device].pose[first + use.component] = inputs[k]
        for stand in self._stands:
            if not stand.pose[3:7].any():
                stand.pose[3] = 1.0

    def settle(self, saved: bytes, period: float, shift: float) -> bytes | None:
        """Move the device by a distance on each axis, and let it rest; None after a failure."""
        self._instance.restore(saved)
        for k in range(_MOVING + _RESTING):
            self.stand.pose[:3] += shift / _MOVING if k < _MOVING else 0.0
            if not self._step(period):
                return None
        return self._instance.save()

    def _step(self, period: float) -> bool:
        time = np.array([self._instance.time + period])
        return self._instance.run(time, self._rows)[0] is Status.OK

    def after(self, saved: bytes, change: Array, period: float) -> Array | None:
        """State, inputs and force after a sample from a state and inputs that are changed."""
        self._instance.restore(saved)
        state, inputs = self._instance.state, self._instance.input
        state += change[: len(state)]
        inputs += change[len(state) :]
        if not self._step(period):
            return None
        return np.concatenate([state, inputs, self.stand.effort[:3]])

    def saved(self) -> bytes:
        """The instance as it is."""
        return self._instance.save()

    def place(self) -> tuple[Array, Array]:
        """The state and the inputs, and the size of a small change of each."""
        state, inputs = self._instance.state.copy(), self._instance.input.copy()
        sizes = 1e-4 * np.concatenate([self._instance.scale, np.zeros(len(inputs))])
        sizes[len(state) :] = 1e-6 * np.maximum(np.abs(inputs), 1.0)
        return np.concatenate([state, inputs]), sizes


@dataclass(frozen=True, slots=True)
class Sampled:
    """`s' = A s + B p`, `e = C s + D p`: p are position and velocity, e resists the position."""

    a: Array
    b: Array
    c: Array
    d: Array


def linearised(probe: _Probe, saved: bytes, period: float, sign: float) -> Sampled | None:
    """Differences of one sample by state, inputs and pose; `sign` is that of the differences."""
    place, sizes = probe.place()
    count = len(place)
    base = probe.after(saved, np.zeros(count), period)
    if base is None:
        return None
    columns: list[tuple[Array | None, float]] = []
    for k in range(count):
        change = np.zeros(count)
        change[k] = sign * sizes[k]
        columns.append((probe.after(saved, change, period), change[k]))
    for first, size in ((0, _POSITION_STEP), (_VELOCITY, _POSITION_STEP / period)):
        for k in range(first, first + 3):
            probe.stand.pose[k] += sign * size
            columns.append((probe.after(saved, np.zeros(count), period), sign * size))
            probe.stand.pose[k] -= sign * size
    known = [(found - base) / size for found, size in columns if found is not None]
    slopes = np.array(known).T
    if len(known) < len(columns) or not np.isfinite(slopes).all():
        return None
    moving = (slopes[:count] != np.eye(count, count + 6)).any(axis=1)  # the others are constants
    rows, columns_of = np.flatnonzero(moving), [*np.flatnonzero(moving), *range(count, count + 6)]
    slopes = slopes[np.ix_([*rows, *range(count, count + 3)], columns_of)]
    n = len(rows)
    return Sampled(slopes[:n, :n], slopes[:n, n:], -slopes[n:, :n], -slopes[n:, n:])


# --- passivity ------------------------------------------------------------------------------


def response(model: Sampled, turns: Array, period: float, lag: float = 0.0) -> Array:
    """H(e^{jw}) from position to the force that resists it, (n, 3, 3), at w = `turns`.

    The velocity of the device is a difference of positions; `lag` is in periods.
    """
    found = np.empty((len(turns), 3, 3), dtype=complex)
    eye = np.eye(len(model.a))
    for k, turn in enumerate(turns):
        z = np.exp(1j * turn)
        whole = model.c @ np.linalg.solve(z * eye - model.a, model.b) + model.d
        found[k] = (whole[:, :3] + whole[:, 3:] * (1 - 1 / z) / period) * z ** (-lag)
    return found


def needed_damping(forces: Array, turns: Array, period: float) -> Array:
    """The damping that is needed at each of `turns`, N s/m; of H as `response` gives it."""
    factor = 0.5 * period * (1 - np.exp(-1j * turns)) / (1 - np.cos(turns))
    whole = forces * factor[:, None, None]
    return np.asarray(np.linalg.eigvalsh(0.5 * (whole + whole.conj().transpose(0, 2, 1)))[:, -1])


def growth_with(model: Sampled, mass: float, damping: float, period: float, lag: int) -> float:
    """The largest eigenvalue of the loop with a device of a mass and a damping on each axis."""
    n = len(model.a)
    ratio = damping / mass
    fade = np.exp(-ratio * period)
    travel = -np.expm1(-ratio * period) / ratio if ratio > 0 else period
    rise = (period - travel) / damping if damping > 0 else 0.5 * period**2 / mass
    push = travel / mass
    # The states: those of the model, position and velocity of the device, the position of before,
    # forces under way. The pose of a sample is that after the device has moved.
    size = n + 9 + 3 * lag
    loop = np.zeros((size, size))

    def block(k: int) -> slice:
        return slice(n + 3 * k, n + 3 * k + 3)

    x, v, before = block(0), block(1), block(2)
    pose = np.zeros((6, size))
    pose[:3, x] = np.eye(3)
    pose[3:, x], pose[3:, before] = np.eye(3) / period, -np.eye(3) / period
    own = np.eye(n, size)
    loop[:n] = model.a @ own + model.b @ pose
    held = model.c @ own + model.d @ pose
    for k in range(lag):
        loop[block(3 + k)] = held if k == 0 else np.eye(size)[block(2 + k)]
    if lag:
        held = np.eye(size)[block(2 + lag)]
    loop[x, x], loop[x, v], loop[v, v] = np.eye(3), travel * np.eye(3), fade * np.eye(3)
    loop[x] -= rise * held
    loop[v] -= push * held
    loop[before, x] = np.eye(3)
    return float(np.abs(np.linalg.eigvals(loop)).max())


def couplings(
    model: LoadedModel,
    begun: Instance,
    devices: Mapping[str, CapabilitiesStruct],
    parameters: Mapping[str, ParameterValue],
    ahead: Mapping[str, float] = MappingProxyType({}),
) -> list[Coupling]:
    """The couplings of a loop that is about to start, one for each device that takes a force.

    `begun` is the instance of the loop at its start, `devices` has what each device can do, `ahead`
    the time before its sample at which a device is read, s. A model that cannot be linearised has
    none.
    """
    places = {name: k for k, name in enumerate(devices)}
    found = []
    for force in model.facts.forces:
        if force.device not in places:
            continue
        index, can = places[force.device], devices[force.device]
        samples = _samples_of(force, model, begun)
        facts = Coupling(
            device=force.device,
            period=samples * begun.sample_period,
            lag=can.lag + ahead.get(force.device, 0.0) / begun.sample_period,
            stiffness=0.0,
            needed=0.0,
            frequency=0.0,
            growth=None,
            damping=can.damping,
            guard=_guard_of(force),
            is_whole=force.whole,
            samples=samples,
        )
        instance = _copy(model, begun, parameters)
        probe = _Probe(instance, model.row_width, index)
        with_numbers = coupling_of(probe, facts, can.mass)
        instance.close_devices()
        if with_numbers is not None:
            found.append(with_numbers)
    return found


def _guard_of(force: ForceFacts) -> str:
    """The guards of a device in words."""
    ports = [f"sampled port `{name}`" for name in force.ports]
    return ", ".join([*ports, *(f"{_OBSERVER} `{path}`" for path in force.observers)])


def _samples_of(force: ForceFacts, model: LoadedModel, begun: Instance) -> int:
    """Samples of a device until all parts between its position and its force have taken one."""
    index, folded = parameter_places(begun), dict(model.facts.folded)

    seconds = (
        number_of(begun, index, folded, period) if isinstance(period, str) else period
        for period in force.periods
    )
    counts = (round(period / begun.sample_period) for period in seconds)
    return min(math.lcm(*(max(count, 1) for count in counts)), _MOST_SAMPLES)


def _copy(
    model: LoadedModel, begun: Instance, parameters: Mapping[str, ParameterValue]
) -> Instance:
    """An instance like that of the loop, in which the brakes of sampled ports do not act."""
    instance = model.parameters.instance(parameters)
    instance.set_options(OptionsStruct(b"rodas5p", rtol=_RTOL, atol=0.0))
    places = parameter_places(instance)
    for port in model.facts.ports:
        if f"{port.name}.brake" in places:
            instance.set_parameter(places[f"{port.name}.brake"], 0.0)
    instance.reset(begun.time, checked=False)
    instance.state[:], instance.input[:] = begun.state, begun.input
    instance.restart()
    return instance


def lag_warnings(
    model: LoadedModel, begun: Instance, devices: Mapping[str, CapabilitiesStruct]
) -> Iterator[Diagnostic]:
    """Warn of sampled ports that know less of a delay than the device that they read states."""
    index, folded = parameter_places(begun), dict(model.facts.folded)
    ports = {port.name: port for port in model.facts.ports}
    for force in model.facts.forces:
        can = devices.get(force.device)
        if can is None:
            continue
        for name in force.ports:
            lag = number_of(begun, index, folded, f"{ports[name].name}.lag")
            if can.lag > lag or (can.lag > 0 and not can.echoes):
                yield messages.unknown_lag(force.device, name, can.lag, lag, bool(can.echoes))


def coupling_of(probe: _Probe, facts: Coupling, mass: float) -> Coupling | None:
    """Complete the facts of a coupling; None where the model cannot be linearised."""
    period = facts.period
    turns = np.geomspace(1e-3, np.pi, _FREQUENCIES)
    found = []
    start = probe.saved()
    for sign in (1.0, -2.0):  # back over the start
        begun = probe.settle(start, period, sign * _SHIFT)
        model = None if begun is None else linearised(probe, begun, period, sign)
        if model is None:
            return None
        lag = facts.lag / facts.samples
        forces = response(model, turns, period, lag)
        needed = needed_damping(forces, turns, period)
        worst = int(np.argmax(needed))
        still = float(np.linalg.norm(forces[0], 2))
        late = math.ceil(math.floor(facts.lag) / facts.samples)
        growth = growth_with(model, mass, facts.damping, period, late) if mass > 0 else None
        found.append(
            replace(
                facts,
                stiffness=still if still > 1e-6 else 0.0,
                needed=max(float(needed[worst]), 0.0),
                frequency=float(turns[worst]) / (2 * np.pi * period),
                growth=growth,
            )
        )
    return max(found, key=lambda one: one.needed)
