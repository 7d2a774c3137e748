"""Derivatives of a run by parameters and initial values: the C interface."""

from __future__ import annotations

from ctypes import POINTER, c_double, c_int, c_size_t, c_void_p
from itertools import count, takewhile
from typing import Any

import numpy as np

from bgc.diagnostics.catalogue.run import no_memory
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.structures import Status

_Doubles = POINTER(c_double)
_RUN = (_Doubles, c_size_t, _Doubles, _Doubles, POINTER(c_size_t))
# name: result, arguments behind the model
_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "bgc_new_sensitivities": (c_void_p, (c_int,)),
    "bgc_start_sensitivities": (c_int, (c_void_p, c_void_p, _Doubles, _Doubles)),
    "bgc_slope_by_parameters": (None, (c_void_p, c_void_p, c_int, _Doubles)),
    "bgc_closing_parameter": (c_int, (c_int,)),
    "bgc_get_sensitivity": (None, (c_void_p, c_int, _Doubles)),
    "bgc_set_sensitivity": (None, (c_void_p, c_int, _Doubles)),
    "bgc_run_sensitivities": (c_int, (c_void_p, c_void_p, *_RUN)),
}


class Tangents:
    """Derivatives of an instance's states along directions of its parameters, in C memory.

    The instance is of a library that was compiled with tangents.
    """

    def __init__(self, instance: Instance, directions: int) -> None:
        self.instance, self.count = instance, directions
        self._functions: Any = instance.library.functions
        self._model = instance.library.pointer
        for name, (result, arguments) in _FUNCTIONS.items():
            function = getattr(self._functions, name)
            function.restype, function.argtypes = result, (type(self._model), *arguments)
        self._functions.bgc_free_sensitivities.argtypes = (c_void_p,)
        self._memory = self._call("bgc_new_sensitivities", directions)
        if not self._memory:
            raise BgError([no_memory()])

    @property
    def _size(self) -> int:
        """The number of states and of values that sampled parts hold."""
        return len(self.instance.state) + len(self.instance.library.held_inputs)

    def __del__(self) -> None:
        if getattr(self, "_memory", None):
            self._functions.bgc_free_sensitivities(self._memory)
            self._memory = None

    def _call(self, name: str, *arguments: Any) -> Any:
        return getattr(self._functions, name)(self._model, *arguments)

    def start(self, parameters: Array, states: Array) -> Status:
        """Find the derivatives of the states of an instance that has just been reset.

        Each direction is a row: changes of the parameters, (count, parameters), and of the states
        beside what follows from these, (count, states).
        """
        each = self.instance.address, self._memory
        where = _doubles(parameters), _doubles(states)
        return Status(self._call("bgc_start_sensitivities", *each, *where))

    def slopes(self) -> Array:
        """Derivatives at the present with the states held, (count, states + chain rows + held).

        They are those of f, then those of the rows of closed chains (`Instance.chain_rows`) and of
        the values that sampled parts hold after an instant (`Instance.next_held`).
        """
        rows = self._functions.bgc_chain_rows(self._model)
        found = np.zeros((self.count, rows + self._size))
        for k, row in enumerate(found):
            each = self.instance.address, self._memory
            self._call("bgc_slope_by_parameters", *each, k, _doubles(row))
        return found

    @property
    def closing(self) -> list[int]:
        """The numbers of the parameters that may take values which close chains at the start."""
        numbers = (self._call("bgc_closing_parameter", k) for k in count())
        return list(takewhile(lambda number: number >= 0, numbers))

    @property
    def states(self) -> Array:
        """Derivatives at the present of the states and of held values, (count, states + held)."""
        found = np.zeros((self.count, self._size))
        for k, row in enumerate(found):
            self._call("bgc_get_sensitivity", self._memory, k, _doubles(row))
        return found

    @states.setter
    def states(self, values: Array) -> None:
        for k, row in enumerate(np.ascontiguousarray(values, dtype=float)):
            self._call("bgc_set_sensitivity", self._memory, k, _doubles(row))

    def follow(self, slopes: Array) -> None:
        """Make runs of the instance fill `slopes`, (rows, count, outputs)."""
        assert slopes.flags.c_contiguous and slopes.dtype == np.float64

        def run(model: Any, data: Any, times: Any, n: int, rows: Any, done: Any) -> int:
            return int(
                self._functions.bgc_run_sensitivities(
                    model, data, self._memory, times, n, rows, _doubles(slopes), done
                )
            )

        self.instance.backend = run


def _doubles(array: Array) -> Any:
    assert array.flags.c_contiguous
    return array.ctypes.data_as(_Doubles)
