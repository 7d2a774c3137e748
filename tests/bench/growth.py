"""Time to equal error of models that grow, against CVODE with KLU: `python run.py growth`.

Rules: CVODE (BDF, Newton, KLU) gets our compiled f and J, as `solver cvode` of a scene does. Ours
is the default of the model. Tolerances of both run over the same ladder, absolute ones per state,
rtol times its scale. The error is the largest of the observed values in any row, over the largest
observed value, against rodas5p at rtol 1e-11. Time to an error is that of the cheapest tolerance
that reaches it, in processor time, the least of three runs in turn.

The rows `tables` compare the factorisation that the compiler chooses with the one before blocks of
rows: unrolled code up to its limit, tables above it. `python growth.py crane:16` measures one
model, with the errors and times of all tolerances.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from crane import instance, run
from factorisation import lowered_model
from table import Row, pin

from bgc.building.backends import BACKENDS, build_backend
from bgc.building.build import build_shared_object
from bgc.building.cache import open_cache
from bgc.building.toolchain import find_toolchain
from bgc.diagnostics.diagnostic import BgError
from bgc.emission.emit import emit_lowered
from bgc.ir.lowered import Lowered
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance, Library, backend_run
from bgc.runtime.running.methods import SWITCHING
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
_TARGETS = (1e-3, 1e-4, 1e-5, 1e-6)
_LADDER = tuple(10.0 ** (-k / 2) for k in range(3, 21))

Timed = list[tuple[float, float]]  # errors and seconds


def instance_of(lowered: Lowered) -> Instance:
    """The model, compiled."""
    units = emit_lowered(lowered, "").units
    return instance(Library(build_shared_object(units, find_toolchain(), open_cache())))


def default(made: Instance) -> str:
    """The adaptive default of a model."""
    return SWITCHING if made.library.explicit_cost > 0 else "rodas5p"


def solved(made: Instance, times: Array, method: str, rtol: float) -> tuple[float, Array]:
    """Seconds and rows of a run."""
    status, rows, counts = run(made, times, method, rtol=rtol)
    return counts["processor_seconds"] if status is Status.OK else np.inf, rows


def by_cvode(library: Library) -> Instance | str:
    """An instance whose runs are CVODE's, or why there is none."""
    try:
        path = build_backend(BACKENDS["cvode"], open_cache())
    except BgError as problem:
        return str(problem)
    made = instance(library)
    made.backend = backend_run(path, "cvode")
    return made


def ladder(exact: Array, solve: Callable[[float], tuple[float, Array]]) -> Timed:
    """Errors and times of all tolerances until the smallest error is reached."""
    found: Timed = []
    for rtol in _LADDER:
        runs = [solve(rtol) for _ in range(3)]
        error = float(np.abs(runs[0][1] - exact).max() / np.abs(exact).max())
        found.append((error, min(seconds for seconds, _ in runs)))
        if error < 0.3 * _TARGETS[-1]:
            break
    return found


def time_to(target: float, timed: Timed) -> float:
    return min((seconds for error, seconds in timed if error <= target), default=np.inf)


def measure(name: str, end: float) -> tuple[str, dict[str, Timed]]:
    """The states and factorisation of a model, and errors and times of each way."""
    lowered = lowered_model(name)
    made = instance_of(lowered)
    times = np.linspace(0.0, end, 21)
    exact = solved(made, times, "rodas5p", 1e-11)[1]
    method = default(made)
    found = {"ours": ladder(exact, lambda rtol: solved(made, times, method, rtol))}
    if lowered.blocks:
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
        for target in _TARGETS:
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
            print(f"  {way:12s}", *(f"{error:.0e} {1e3 * s:.2f} ms," for error, s in timed))
        for target in _TARGETS:
            own = time_to(target, found["ours"])
            ratios = (f"{way} {time_to(target, timed) / own:.2f}" for way, timed in found.items())
            print(f"  to {target:.0e}:", ", ".join(ratios), "of ours")
