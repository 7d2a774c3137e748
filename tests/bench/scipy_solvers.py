"""SciPy's stiff solvers on the crane with springs, against the adaptive default.

Rules: SciPy gets f written out in NumPy (`numpy_crane.py`, all bodies at once; checked against
the compiled f first), and in further rows our C f through ctypes. J by its own difference
quotients. Tolerances of all run over a ladder, absolute ones per state, rtol times its scale;
the cheapest that reaches the error counts. The error is the largest distance of a body in any
row. SciPy's runs, which take seconds, are timed once.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from ctypes import POINTER, c_double, c_void_p

import numpy as np
from crane import copies, crane, instance, parameters, shared_object
from numpy_crane import NumPyCrane, order
from scipy.integrate import solve_ivp
from sundials import reference, run_ours
from table import Row

from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance

_STIFFNESS, _DAMPING = 1e8, 0.1
_DURATION = 1.0
_TARGET = 2e-8  # m
_PATIENCE = 90.0  # s for each method
_LADDER = tuple(10.0 ** (-k / 2) for k in range(10, 21))

_F = Callable[[float, Array], Array]


class CompiledCrane:
    """The compiled f in the layout of the NumPy one, and the scale of each state."""

    def __init__(self, made: Instance) -> None:
        clock = shared_object(["clock.c"])
        assert not isinstance(clock, str), clock
        doubles = POINTER(c_double)
        clock.clock_open.restype = c_void_p
        clock.clock_rhs.argtypes = (c_void_p, c_double, c_void_p, c_void_p)
        model = made.library.model
        self.places = order([model.state[k].name.decode() for k in range(model.n_state)])
        self._inverse = np.argsort(self.places)
        p = parameters(made)
        self._opened = c_void_p(clock.clock_open(made.library.pointer, p.ctypes.data_as(doubles)))
        self._call = clock.clock_rhs
        self._out = np.zeros(model.n_state)
        scale = np.zeros(model.n_state)
        clock.clock_scale(self._opened, scale.ctypes.data_as(doubles))
        self.scale = scale[self.places]

    def __call__(self, t: float, state: Array) -> Array:
        x = state[self._inverse]
        self._call(self._opened, t, x.ctypes.data, self._out.ctypes.data)
        return self._out[self.places]


def rows() -> list[Row]:
    """Radau with a NumPy f to the error asked for; others and our f for comparison."""
    times = np.linspace(0.0, _DURATION, 101)
    with copies(crane("near_rigid").path, 1) as libraries:
        made = instance(libraries[0], stiffness=_STIFFNESS, damping_ratio=_DAMPING)
        compiled = CompiledCrane(made)
        plain = NumPyCrane(_STIFFNESS, _DAMPING)
        start = made.state[compiled.places]
        _check(start, compiled, plain)
        exact = reference(made, times)
        ours = _cheapest_of_ours(made, times, exact)
        found = []
        cases: tuple[tuple[str, _F, str, float | None, float | None], ...] = (
            ("Radau", plain, "NumPy f", 200, 400),
            ("Radau", compiled, "our C f", None, None),
            ("BDF", compiled, "our C f", None, None),
            ("LSODA", compiled, "our C f", None, None),
        )
        for method, f, name, must, aim in cases:
            on = f"time to 2e-8 m, {name}"
            best = _cheapest(method, f, start, compiled.scale, times, exact)
            if best is None:
                note = f"not within {_PATIENCE:g} s"
                found.append(Row(f"SciPy {method}", on, None, must, aim, note=note))
                continue
            seconds, error, rtol = best
            note = f"{error:.0e} m at rtol {rtol:.0e}, ours {ours[1]}"
            found.append(Row(f"SciPy {method}", on, seconds / ours[0], must, aim, note=note))
    return found


def _check(start: Array, compiled: CompiledCrane, plain: NumPyCrane) -> None:
    """Asserts that both f agree at random states."""
    rng = np.random.default_rng(1)
    for t in (0.0, 1.3):
        state = start + rng.normal(size=start.size) * 10 ** rng.uniform(-3, 2, start.size)
        ours, theirs = compiled(t, state), plain(t, state)
        assert np.abs(ours - theirs).max() < 1e-12 * np.abs(ours).max(), "the NumPy f differs"


def _cheapest_of_ours(made: Instance, times: Array, exact: Array) -> tuple[float, str]:
    found = []
    for rtol in _LADDER:
        runs = [run_ours(made, times, rtol) for _ in range(7)]
        best = min(runs, key=lambda one: one.seconds)
        if np.abs(best.rows - exact).max() <= _TARGET:
            found.append((best.seconds, f"{best.steps:,} steps at rtol {rtol:.0e}"))
    return min(found)


def _cheapest(
    method: str, f: _F, start: Array, scale: Array, times: Array, exact: Array
) -> tuple[float, float, float] | None:
    begun = time.perf_counter()
    for rtol in _LADDER:
        started = time.process_time()
        done = solve_ivp(
            f, (0.0, times[-1]), start, method, times, rtol=rtol, atol=rtol * scale
        )  # fmt: skip
        seconds = time.process_time() - started
        if done.success:
            error = float(np.abs(done.y[40:52].T - exact).max())
            if error <= _TARGET:
                return seconds, error, rtol
        if time.perf_counter() - begun > _PATIENCE:
            return None
    return None
