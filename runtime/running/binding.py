"""The functions of a compiled model, as `bgc.h` declares them, through ctypes.

A `Library` is a loaded model, an `Instance` one running copy of it; neither knows of scenes,
results or messages.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Sequence
from ctypes import POINTER, byref, c_char_p, c_double, c_int, c_size_t, c_void_p
from functools import cached_property
from itertools import count, takewhile
from pathlib import Path
from typing import Any, Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from bgc.diagnostics.catalogue.fmu_parts import fmu_not_opened
from bgc.diagnostics.catalogue.machine import cannot_load
from bgc.diagnostics.catalogue.run import no_memory
from bgc.diagnostics.diagnostic import BgError
from bgc.ir.port_facts import FmuFacts
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.fmu_folders import FmuFolder
from bgc.runtime.running.structures import (
    ABI,
    CountsStruct,
    ModelStruct,
    OptionsStruct,
    Status,
    SubtoleranceState,
)

_Doubles = POINTER(c_double)
_Model = POINTER(ModelStruct)

AtFault: TypeAlias = Literal[
    "parameter", "assertion", "state", "switch", "divisor", "chain", "jump", "held", "device", "fmu"
]
"""What a call may fail at; `held` is a value that a sampled part holds."""

# name: result, arguments after `const bgc_model *m` and `bgc_data *d`
_ON_INSTANCE: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "bgc_free": (None, ()),
    "bgc_set_param": (c_int, (c_int, c_double)),
    "bgc_get_param": (c_double, (c_int,)),
    "bgc_reset": (c_int, (c_double,)),
    "bgc_reset_unchecked": (c_int, (c_double,)),
    "bgc_closing_moves": (None, (_Doubles,)),
    "bgc_restart": (c_int, ()),
    "bgc_rhs": (c_int, (_Doubles,)),
    "bgc_switch_arguments": (None, (_Doubles,)),
    "bgc_jacobian": (c_int, (_Doubles, _Doubles)),
    "bgc_mass": (c_int, (_Doubles,)),
    "bgc_outputs": (c_int, (_Doubles,)),
    "bgc_evaluate_chain_rows": (c_int, (_Doubles, _Doubles)),
    "bgc_energy": (c_int, (_Doubles,)),
    "bgc_set_options": (c_int, (POINTER(OptionsStruct),)),
    "bgc_run": (c_int, (_Doubles, c_size_t, _Doubles, POINTER(c_size_t))),
    "bgc_advance": (c_int, (c_double,)),
    "bgc_state_at": (c_int, (c_double, _Doubles)),
    "bgc_save": (c_int, (c_void_p,)),
    "bgc_restore": (c_int, (c_void_p,)),
    "bgc_next_held": (c_int, (_Doubles, _Doubles)),
    "bgc_get_subtolerance": (c_int, (c_int, POINTER(SubtoleranceState))),
    "bgc_open_device": (c_int, (c_int, c_void_p, c_char_p, c_char_p, c_size_t)),
    "bgc_close_devices": (None, ()),
    "bgc_device_handle": (c_void_p, (c_int,)),
    "bgc_open_fmu": (c_int, (c_int, c_char_p, c_char_p, c_char_p, c_size_t)),
    "bgc_fmu_reason": (c_char_p, ()),
}
# name: result, all arguments
_OTHERS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "bgc_get_model": (_Model, ()),
    "bgc_chain_rows": (c_int, (_Model,)),
    "bgc_chain_state": (c_int, (_Model, c_int)),
    "bgc_new": (c_void_p, (_Model,)),
    "bgc_save_size": (c_size_t, (_Model,)),
    **{f"bgc_failed_{what}": (c_int, (c_void_p,)) for what in get_args(AtFault)},
    "bgc_failed_time": (c_double, (c_void_p,)),
    "bgc_count_jumps": (c_int, (_Model,)),
    "bgc_has_lane_factors": (c_int, (_Model,)),
    "bgc_explicit_cost": (c_double, (_Model,)),
    "bgc_count_rates": (c_int, (_Model,)),
    "bgc_count_held": (c_int, (_Model,)),
    "bgc_held_input": (c_int, (_Model, c_int)),
    "bgc_device_reason": (c_char_p, (c_void_p,)),
    "bgc_sample_period": (c_double, (c_void_p,)),
    "bgc_chain_name": (c_char_p, (_Model, c_int)),
    "bgc_condition_name": (c_char_p, (_Model, c_int)),
    "bgc_time": (c_double, (c_void_p,)),
    "bgc_state": (_Doubles, (c_void_p,)),
    "bgc_scale": (_Doubles, (c_void_p,)),
    "bgc_input": (_Doubles, (c_void_p,)),
    "bgc_stop": (None, (c_void_p,)),
    "bgc_get_counts": (POINTER(CountsStruct), (c_void_p,)),
    "bgc_find_driver": (c_void_p, (c_char_p,)),
    "bgc_feed_pointer": (None, (c_void_p, _Doubles)),
}


class Library:
    """A loaded shared object: the model's constant data and the functions of the C runtime."""

    def __init__(self, path: Path, fmus: Sequence[FmuFacts] = ()) -> None:
        self.fmus = fmus
        try:
            self.functions = ctypes.CDLL(str(path))
            for name, (result, arguments) in _ON_INSTANCE.items():
                self._declare(name, result, (_Model, c_void_p, *arguments))
            for name, (result, arguments) in _OTHERS.items():
                self._declare(name, result, arguments)
        except (OSError, AttributeError) as problem:
            raise BgError([cannot_load(str(path), str(problem))]) from problem
        self.pointer = self.functions.bgc_get_model()
        self.model: ModelStruct = self.pointer.contents
        if self.model.abi != ABI:
            reason = f"it speaks version {self.model.abi} of the interface, this bgc {ABI}"
            raise BgError([cannot_load(str(path), reason)])

    @property
    def has_chains(self) -> bool:
        """Return whether the model has closed rigid chains, or conditions on positions."""
        names = (self.functions.bgc_chain_name, self.functions.bgc_condition_name)
        return any(name(self.pointer, 0) is not None for name in names)

    @property
    def has_jumps(self) -> bool:
        """Return whether states of the model jump."""
        return bool(self.functions.bgc_count_jumps(self.pointer))

    @property
    def has_lane_factors(self) -> bool:
        """Return whether the matrix of the model can be factorised for a batch of instances."""
        return bool(self.functions.bgc_has_lane_factors(self.pointer))

    @property
    def explicit_cost(self) -> float:
        """Operations of an explicit step over those of an implicit one; 0: not worth while."""
        return float(self.functions.bgc_explicit_cost(self.pointer))

    @cached_property
    def held_inputs(self) -> NDArray[np.intp]:
        """The input of each value that sampled parts hold."""
        count = self.functions.bgc_count_held(self.pointer)
        places = [self.functions.bgc_held_input(self.pointer, k) for k in range(count)]
        return np.array(places, dtype=np.intp)

    @property
    def is_sampled(self) -> bool:
        """Return whether the model has sampled parts."""
        return bool(self.functions.bgc_count_rates(self.pointer))

    def _declare(self, name: str, result: Any, arguments: tuple[Any, ...]) -> None:
        function = getattr(self.functions, name)
        function.restype = result
        function.argtypes = arguments


def backend_run(path: Path, solver: str) -> Any:
    """Load the function of a backend that replaces `bgc_run`."""
    result, arguments = _ON_INSTANCE["bgc_run"]
    try:
        function = getattr(ctypes.CDLL(str(path)), f"bgc_{solver}_run")
    except (OSError, AttributeError) as problem:
        raise BgError([cannot_load(str(path), str(problem))]) from problem
    function.restype = result
    function.argtypes = (_Model, c_void_p, *arguments)
    return function


def text(value: bytes | None) -> str:
    """Decode a C string; NULL gives the empty text."""
    return "" if value is None else value.decode("utf-8", "replace")


@dataclass(frozen=True, slots=True)
class _Memory:
    """Doubles in C memory, as the base of a view: it keeps the instance that will free them."""

    owner: Instance
    address: int
    size: int

    @property
    def __array_interface__(self) -> dict[str, Any]:
        """The memory as NumPy reads it: writable, contiguous."""
        kind = np.dtype(np.float64).str
        return {"version": 3, "typestr": kind, "shape": (self.size,), "data": (self.address, False)}


class Instance:
    """One running copy of a model. Statuses are returned, never raised.

    Arrays that are views into its memory keep the instance.
    """

    def __init__(self, library: Library) -> None:
        self.library = library
        self.backend: Any = None  # replaces `bgc_run`, see `backend_run`
        self.given: dict[int, float] = {}  # parameters that were set, in their order
        self._data = library.functions.bgc_new(library.pointer)
        if not self._data:
            raise BgError([no_memory()])
        self._fmus: list[FmuFolder] = []
        for index, fmu in enumerate(library.fmus):
            self._fmus.append(FmuFolder(fmu))
            self._open_fmu(index, fmu, self._fmus[-1])

    def __del__(self) -> None:
        if getattr(self, "_data", None):
            self._call("bgc_free")
            self._data = None
        for folder in getattr(self, "_fmus", ()):
            folder.close()

    def _call(self, name: str, *arguments: Any) -> Any:
        function = getattr(self.library.functions, name)
        return function(self.library.pointer, self._data, *arguments)

    def _ask(self, name: str) -> Any:
        return getattr(self.library.functions, name)(self._data)

    @property
    def address(self) -> int:
        """Address of the instance's `bgc_data`; valid as long as the instance is kept."""
        return int(self._data)

    def set_parameter(self, index: int, value: float) -> None:
        """Set a parameter; takes effect at `reset`."""
        self.given[index] = value
        self._call("bgc_set_param", index, value)

    def parameter(self, index: int) -> float:
        """The present value of a parameter."""
        return float(self._call("bgc_get_param", index))

    def reset(self, time: float = 0.0, *, checked: bool = True) -> Status:
        """Compute the constants that depend on parameters, and take the initial state.

        Given values have to hold there, unless another state follows and nothing is `checked`.
        """
        return Status(self._call("bgc_reset" if checked else "bgc_reset_unchecked", time))

    def restart(self) -> Status:
        """Start again from the state that has been written to `state`."""
        return Status(self._call("bgc_restart"))

    @property
    def time(self) -> float:
        """The instance's time; may be read while another thread runs it."""
        return float(self._ask("bgc_time"))

    @property
    def state(self) -> Array:
        """The state, a view that keeps the instance: writing to it sets it."""
        return self._view("bgc_state", self.library.model.n_state)

    @property
    def scale(self) -> Array:
        """Scales of the states, of which absolute tolerances are a part; a view, set by a reset."""
        return self._view("bgc_scale", self.library.model.n_state)

    @property
    def input(self) -> Array:
        """The device inputs, a view: writing to it sets them."""
        return self._view("bgc_input", self.library.model.n_input)

    def _view(self, name: str, size: int) -> Array:
        if size == 0:
            return np.empty(0)
        view: Array = np.asarray(_Memory(self, ctypes.addressof(self._ask(name).contents), size))
        return view

    def failed(self, what: AtFault) -> int:
        """Index of what the last call failed at; -1 where none is known.

        That of a failed check of parameters is behind those of the parameters themselves.
        """
        return int(self._ask(f"bgc_failed_{what}"))

    @property
    def failed_chain(self) -> str:
        """The parts of the closed chain at which the last call failed; empty if none."""
        name = self.library.functions.bgc_chain_name
        return text(name(self.library.pointer, self.failed("chain")))

    @property
    def chain_position(self) -> dict[str, float]:
        """The states that describe the position of closed chains, by name."""
        numbers = (self.library.functions.bgc_chain_state(self.library.pointer, k) for k in count())
        states = self.library.model.state
        return {
            text(states[k].name): float(self.state[k]) for k in takewhile(lambda k: k >= 0, numbers)
        }

    @property
    def failed_condition(self) -> str:
        """The name of the condition that the start does not satisfy."""
        name = self.library.functions.bgc_condition_name
        return text(name(self.library.pointer, self.failed("chain")))

    @property
    def device_reason(self) -> str:
        """The reason that the driver of the device at fault gives; empty without one."""
        return text(self._ask("bgc_device_reason"))

    @property
    def sample_period(self) -> float:
        """Seconds between two samples of the devices; 0 in a model that samples nothing."""
        return float(self._ask("bgc_sample_period"))

    @property
    def failed_time(self) -> float:
        """The time at which the divisor at fault vanishes."""
        return float(self._ask("bgc_failed_time"))

    @property
    def counts(self) -> dict[str, float]:
        """Steps, evaluations and seconds of the run so far."""
        counts = self._ask("bgc_get_counts").contents
        return {name: getattr(counts, name) for name, _ in CountsStruct._fields_}

    def state_at(self, time: float) -> Array:
        """The state at a time within the last step; NaN at others."""
        x = np.full(self.library.model.n_state, np.nan)
        status = Status(self._call("bgc_state_at", time, _doubles(x)))
        return x if status is Status.OK else np.full_like(x, np.nan)

    def save(self) -> bytes:
        """The whole instance except its devices, for `restore`."""
        memory = ctypes.create_string_buffer(
            self.library.functions.bgc_save_size(self.library.pointer)
        )
        self._call("bgc_save", memory)
        return memory.raw

    def restore(self, saved: bytes) -> Status:
        """Return to a saved state of an instance of the same model."""
        return Status(self._call("bgc_restore", saved))

    def subtolerance(self, index: int) -> SubtoleranceState | None:
        """Report how a state fell below its tolerance and grew again in this run."""
        found = SubtoleranceState()
        return found if self._call("bgc_get_subtolerance", index, byref(found)) else None

    def rhs(self) -> tuple[Status, Array]:
        """f of M y' = f at the present time and state."""
        f = np.full(self.library.model.n_state, np.nan)
        return Status(self._call("bgc_rhs", _doubles(f))), f

    def jacobian(self) -> tuple[Status, Array, Array]:
        """df/dx, dense, and df/dt at the present time and state."""
        model = self.library.model
        entries = np.full(model.n_jac, np.nan)
        by_time = np.full(model.n_state, np.nan)
        status = Status(self._call("bgc_jacobian", _doubles(entries), _doubles(by_time)))
        dense = np.zeros((model.n_state, model.n_state))
        dense[model.jac_row[: model.n_jac], model.jac_col[: model.n_jac]] = entries
        return status, dense, by_time

    def mass(self) -> tuple[Status, Array]:
        """M of M y' = f, dense; it depends on parameters alone."""
        model = self.library.model
        if model.n_mass == 0:
            return Status.OK, np.eye(model.n_state)
        entries = np.full(model.n_mass, np.nan)
        status = Status(self._call("bgc_mass", _doubles(entries)))
        dense = np.zeros((model.n_state, model.n_state))
        dense[model.mass_row[: model.n_mass], model.mass_col[: model.n_mass]] = entries
        return status, dense

    def outputs(self) -> tuple[Status, Array]:
        """The observed values at the present time and state."""
        y = np.full(self.library.model.n_output, np.nan)
        return Status(self._call("bgc_outputs", _doubles(y))), y

    def closing_moves(self) -> Array:
        """By how much closed chains have moved the states at a start from their given values."""
        moves = np.full(self.library.model.n_state, np.nan)
        self._call("bgc_closing_moves", _doubles(moves))
        return moves

    def switch_arguments(self) -> Array:
        """The arguments of all switches at the present state."""
        arguments = np.full(self.library.model.n_switch, np.nan)
        self._call("bgc_switch_arguments", _doubles(arguments))
        return arguments

    def chain_rows(self) -> tuple[Status, Array, Array]:
        """The rows that keep closed chains closed, zero in a run, and their derivatives by x."""
        count = int(self.library.functions.bgc_chain_rows(self.library.pointer))
        values = np.full(count, np.nan)
        slopes = np.full((count, self.library.model.n_state), np.nan)
        where = (_doubles(values), _doubles(slopes))
        return Status(self._call("bgc_evaluate_chain_rows", *where)), values, slopes

    def start_values(self) -> Array:
        """The state, then all values that sampled parts hold: a start of C programs."""
        return np.concatenate([self.state, self.input[self.library.held_inputs]])

    def next_held(self) -> tuple[Status, Array, Array]:
        """The values that sampled parts would hold after an instant now, and their periods in s."""
        size = len(self.library.held_inputs)
        values, periods = np.full(size, np.nan), np.full(size, np.nan)
        where = (_doubles(values), _doubles(periods))
        return Status(self._call("bgc_next_held", *where)), values, periods

    def set_options(self, options: OptionsStruct) -> Status:
        """Choose the method and its options."""
        return Status(self._call("bgc_set_options", byref(options)))

    def run(self, times: Array, rows: Array) -> tuple[Status, int]:
        """Integrate to all times and fill their rows; return the number of finished rows.

        The interpreter lock is released: another thread may call `stop`.
        """
        assert rows.flags.c_contiguous and len(rows) == len(times)
        done = c_size_t(0)
        run = self.backend or self.library.functions.bgc_run
        where = (_doubles(times), len(times), _doubles(rows), byref(done))
        return Status(run(self.library.pointer, self._data, *where)), done.value

    def stop(self) -> None:
        """Make a `run` in another thread return after its present step."""
        self._ask("bgc_stop")

    def _open_fmu(self, index: int, fmu: FmuFacts, folder: FmuFolder) -> None:
        """Open an FMU; its files stay as long as the instance."""
        message = ctypes.create_string_buffer(512)
        where = (os.fsencode(folder.library), os.fsencode(folder.resources))
        status = Status(self._call("bgc_open_fmu", index, *where, message, len(message)))
        if status is not Status.OK:
            reason = text(message.value) if status is Status.FMU else "out of memory"
            raise BgError([fmu_not_opened(fmu.file, reason)])

    @property
    def fmu_reason(self) -> str:
        """The reason that the FMU at fault gives; empty without one."""
        return text(self._call("bgc_fmu_reason"))

    def find_driver(self, name: bytes) -> int | None:
        """Return the address of a device driver, or None if the name is unknown."""
        address: int | None = self.library.functions.bgc_find_driver(name)
        return address

    def open_device(self, index: int, driver: int, options: str) -> tuple[Status, str]:
        """Open a device with `key=value` lines as options; return the driver's message too."""
        message = ctypes.create_string_buffer(512)
        size = len(message)
        lines = os.fsencode(options)
        status = self._call("bgc_open_device", index, driver, lines, message, size)
        return Status(status), message.value.decode("utf-8", "backslashreplace")

    def feed_pointer(self, index: int, pose: Array) -> None:
        """Hand a pose (see `poses`) to a device whose open driver is `pointer` or `gamepad`."""
        handle = self._call("bgc_device_handle", index)
        if handle:
            self.library.functions.bgc_feed_pointer(handle, _doubles(pose))

    def close_devices(self) -> None:
        """Set the forces of all devices to zero, and close them."""
        self._call("bgc_close_devices")


def _doubles(array: Array) -> Any:
    return array.ctypes.data_as(_Doubles)
