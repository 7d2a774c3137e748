"""Time to equal error of models that grow, against CVODE with KLU: `python run.py growth`.

Rules: CVODE (BDF, Newton, KLU) gets our compiled f and J, as `solver cvode` of a scene does. Ours
is the default of the model. Tolerances of both run over the same ladder, absolute ones per state,
rtol times its scale. The error is the largest of the observed values in any row, over the largest
observed value, against rodas5p at rtol 1e-11. Time to an error is that of the cheapest tolerance
that reaches it, in processor time, the least of three runs, but for runs of a second or more. SciPy
(`curves.py` alone) gets our compiled f and takes J by its own differences, once for each tolerance.

The rows `tables` compare the factorisation that the compiler chooses with the one before blocks of
rows: unrolled code up to its limit, tables above it. `python growth.py crane:16` measures one
model, with the errors and times of all tolerances.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from ctypes import POINTER, c_double, c_void_p
from dataclasses import replace
from time import thread_time
from typing import NamedTuple

import numpy as np
from crane import instance, parameters, run, shared_object
from factorisation import lowered_model
from scipy.integrate import solve_ivp
from table import Row, pin

from bgc.building.backends import BACKENDS, build_backend
from bgc.building.build import build_shared_object
from bgc.building.cache import open_cache
from bgc.building.toolchain import find_toolchain
from bgc.diagnostics.diagnostic import BgError
from bgc.emission.emit import emit_lowered
from bgc.ir.lowered import Lowered
from bgc.language.methods import SWITCHING
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance, Library, backend_run
from bgc.runtime.running.structures import Status

# The models, the ends of their runs in s, and what CVODE's time over ours has to reach.
_MODELS: dict[str, tuple[float, float | None, float | None]] = {
    "crane:8": (1.0, 2, 3),
    "crane:16": (1.0, 2, 4),
    "crane:32": (1.0, 2, 4),
    "crane:64": (1.0, 2, 6),
    "arm:6": (1.0, 1.5, 3),
    "arm:12": (1.0, 1.5, 3),
    "arm:24": (1.0, 1.5, 3),
    "tree:15": (1.0, 1.5, 3),
    "tree:31": (1.0, 1.5, 3),
    "circuit:400": (10.0, None, None),
    "grid:20": (10.0, None, None),
    "chain:1000": (10.0, None, None),
    "field:60": (10.0, None, None),
}
TARGETS = (1e-3, 1e-4, 1e-5, 1e-6)
_LADDER = tuple(10.0 ** (-k / 2) for k in range(3, 21))
_SCIPY_LADDER = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
_MOST_DENSE = 400  # states
_LONG = 1.0  # s: such runs are not repeated


class Timed(NamedTuple):
    """The error of a run, its seconds, and its steps (0 if unknown)."""

    error: float
    seconds: float
    steps: int


Solve = Callable[[float], tuple[float, Array, int]]  # at a tolerance: seconds, rows, steps


def instance_of(lowered: Lowered) -> Instance:
    """The model, compiled."""
    units = emit_lowered(lowered, "").units
    return instance(Library(build_shared_object(units, find_toolchain(), open_cache())))


def default(made: Instance) -> str:
    """The adaptive default of a model."""
    return SWITCHING if made.library.explicit_cost > 0 else "rodas5p"


def solved(made: Instance, times: Array, method: str, rtol: float) -> tuple[float, Array, int]:
    """Seconds, rows and steps of a run."""
    status, rows, counts = run(made, times, method, rtol=rtol)
    seconds = counts["processor_seconds"] if status is Status.OK else np.inf
    return seconds, rows, int(counts["steps"])


def by_cvode(library: Library) -> Instance | str:
    """An instance whose runs are CVODE's, or why there is none."""
    try:
        path = build_backend(BACKENDS["cvode"], open_cache())
    except BgError as problem:
        return str(problem)
    made = instance(library)
    made.backend = backend_run(path, "cvode")
    return made


def by_scipy(made: Instance, times: Array, rtol: float) -> tuple[float, Array, int]:
    """Seconds and rows of a run by LSODA with the compiled f."""
    clock = shared_object(["clock.c"])
    assert not isinstance(clock, str), clock
    clock.clock_open.restype = c_void_p
    clock.clock_rhs.argtypes = (c_void_p, c_double, c_void_p, c_void_p)
    p = parameters(made).ctypes.data_as(POINTER(c_double))
    opened = c_void_p(clock.clock_open(made.library.pointer, p))
    assert made.reset() is Status.OK

    def f(t: float, x: Array) -> Array:
        out = np.empty_like(x)
        clock.clock_rhs(opened, t, x.ctypes.data, out.ctypes.data)
        return out

    begun = thread_time()
    done = solve_ivp(
        f, (0.0, times[-1]), made.state.copy(), "LSODA", times, rtol=rtol, atol=rtol * made.scale
    )
    seconds = thread_time() - begun
    clock.clock_close(opened)
    rows = []
    for x in done.y.T:
        made.state[:] = x
        rows.append(made.outputs()[1])
    return seconds if done.success else np.inf, np.array(rows), 0


def _suits_scipy(library: Library) -> bool:
    model = library.model
    return model.n_state <= _MOST_DENSE and model.n_switch == model.n_input == 0


def ladder(
    exact: Array,
    solve: Solve,
    tolerances: tuple[float, ...] = _LADDER,
    times: int = 3,
) -> list[Timed]:
    """The runs of all tolerances until the smallest error is reached."""
    found: list[Timed] = []
    for rtol in tolerances:
        runs = [solve(rtol)]
        if runs[0][0] < _LONG:
            runs += [solve(rtol) for _ in range(times - 1)]
        error = float(np.abs(runs[0][1] - exact).max() / np.abs(exact).max())
        found.append(Timed(error, min(run[0] for run in runs), runs[0][2]))
        if error < 0.3 * TARGETS[-1]:
            break
    return found


def cheapest(target: float, timed: list[Timed]) -> Timed:
    """The quickest run whose error is at most the target; without one, a run of endless time."""
    reached = (run for run in timed if run.error <= target)
    return min(reached, key=lambda run: run.seconds, default=Timed(np.inf, np.inf, 0))


def time_to(target: float, timed: list[Timed]) -> float:
    return cheapest(target, timed).seconds


def measure(name: str, end: float, with_scipy: bool = False) -> tuple[str, dict[str, list[Timed]]]:
    """The states and factorisation of a model, and the runs of each way.

    With `with_scipy`, SciPy takes the place of our own factorisation by tables. It has dense
    matrices, and no events: models above `_MOST_DENSE` states or with switches go without it.
    """
    lowered = lowered_model(name)
    made = instance_of(lowered)
    times = np.linspace(0.0, end, 21)
    exact = solved(made, times, "rodas5p", 1e-11)[1]
    method = default(made)
    found = {"ours": ladder(exact, lambda rtol: solved(made, times, method, rtol))}
    if with_scipy and _suits_scipy(made.library):
        found["SciPy LSODA"] = ladder(
            exact, lambda rtol: by_scipy(made, times, rtol), _SCIPY_LADDER, 1
        )
    elif not with_scipy and lowered.blocks:
        before = instance_of(replace(lowered, blocks=None))
        found["tables"] = ladder(exact, lambda rtol: solved(before, times, method, rtol))
    peer = by_cvode(made.library)
    if isinstance(peer, str):
        print(peer)
    else:
        found["CVODE + KLU"] = ladder(exact, lambda rtol: solved(peer, times, "rodas5p", rtol))
    way = "blocks" if lowered.blocks else "no blocks"
    return f"{name}, {len(lowered.program.states)} states, {way}, {method}", found


def rows() -> list[Row]:
    """Times of CVODE, and by tables, over ours."""
    made: list[Row] = []
    for name, (end, must, aim) in _MODELS.items():
        about, found = measure(name, end)
        for target in TARGETS:
            own = time_to(target, found["ours"])
            for other, timed in found.items():
                if other != "ours":
                    bounds = (must, aim) if other.startswith("CVODE") else (None, None)
                    ratio = time_to(target, timed) / own
                    note = f"ours {1e3 * own:.2f} ms"
                    made.append(Row(other, f"{about}, to {target:.0e}", ratio, *bounds, note=note))
    return made


if __name__ == "__main__":
    pin()
    for model in sys.argv[1:] or _MODELS:
        about, found = measure(model, _MODELS.get(model, (1.0,))[0])
        print(about)
        for way, timed in found.items():
            print(f"  {way:12s}", *(f"{error:.0e} {1e3 * s:.2f} ms," for error, s, _ in timed))
        for target in TARGETS:
            own = time_to(target, found["ours"])
            ratios = (f"{way} {time_to(target, timed) / own:.2f}" for way, timed in found.items())
            print(f"  to {target:.0e}:", ", ".join(ratios), "of ours")
