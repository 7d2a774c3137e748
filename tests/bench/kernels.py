"""Figures of the emitted code itself: operations, times of f, J, factor, solve and of a step, cold
compilation, and the accuracy of stiff springs.

Rules: times are the least of several batches of calls in one copy of the shared object, and the
median over fresh copies. Absolute times are printed for orientation only. Compilation is measured
in processor time, the least of three. The accuracy of stiff springs is that of a fixed step of 1 ms
from springs that have settled under their load (1 s before), against rodas5p at rtol 1e-11, checked
with radau5; the dampers have a ratio of the critical one, so they grow with the stiffness.

What is left to grow is c h^3, c the constant of the dampers: they turn with the poses within a
step, so the trees of order four hold c, and no stability takes that away. Equal c give equal errors
of ros34prw at any stiffness, half the step an eighth of them; a method of order four leaves c h^4.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from ctypes import POINTER, c_double, c_int, c_void_p
from dataclasses import dataclass
from statistics import median

import numpy as np
from crane import COPIES, HERE, copies, crane, instance, parameters, positions, run, shared_object
from table import Row

from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance, Library
from bgc.runtime.running.structures import OptionsStruct, Status

_KERNELS = ("rhs", "jacobian", "factor", "solve")
_STEPS = (
    ("ros34prw", 1), ("ros34prw", 5), ("ros23", 1), ("ros23", 5), ("rodas5p", 1),
)  # fmt: skip
STIFFNESSES = (1e6, 1e8, 1e10, 1e12)


def kernel_times(library: Library, calls: int = 2000, batches: int = 15) -> list[float]:
    """Seconds a call of f, J, factor and solve in one copy."""
    clock = shared_object(["clock.c"])
    assert not isinstance(clock, str), clock
    made = instance(library)
    doubles = POINTER(c_double)
    seconds = (c_double * 4)()
    clock.clock_kernels.argtypes = (
        c_void_p, doubles, doubles, doubles, c_double, c_int, c_int, doubles
    )  # fmt: skip
    p, x, u = parameters(made), made.state.copy(), np.zeros(library.model.n_input + 1)
    arrays = [array.ctypes.data_as(doubles) for array in (p, x, u)]
    clock.clock_kernels(library.pointer, *arrays, 0.1, calls, batches, seconds)
    return list(seconds)


def median_times(scene: str, count: int = COPIES) -> list[float]:
    """The same, the median over fresh copies."""
    with copies(crane(scene).path, count) as libraries:
        measured = [kernel_times(library) for library in libraries]
    return [median(column) for column in zip(*measured, strict=True)]


def step_time(library: Library, method: str, step: float = 1e-3, keep: int = 1) -> float:
    """Seconds a fixed step in one copy, without energy accounts."""
    made = instance(library)
    best = np.inf
    for _ in range(25):
        status, _, counts = run(made, np.array([500 * step]), method, step=step, keep=keep)
        assert status is Status.OK
        best = min(best, counts["processor_seconds"] / counts["steps"])
    return float(best)


def report() -> None:
    """Prints operations and times."""
    for scene in ("near_rigid", "reduced"):
        made = crane(scene)
        times = median_times(scene)
        parts = [
            f"{name} {made.operations[name]:,} operations {1e6 * seconds:.2f} us"
            for name, seconds in zip(_KERNELS, times, strict=True)
        ]
        print(f"{scene}: " + "; ".join(parts))
        with copies(made.path) as libraries:
            for method, keep in _STEPS:
                each = median(step_time(library, method, keep=keep) for library in libraries)
                kept = f", J kept {keep} steps" if keep > 1 else ""
                print(f"  {method}{kept}: {1e6 * each:.2f} us a step")


def uniform_accuracy(damping_ratio: float) -> Row:
    """The error of one method and step from soft to rigid springs, once they have settled."""
    with copies(crane("near_rigid").path, 1) as libraries:
        errors = {k: _stiff_error(libraries[0], k, damping_ratio) for k in STIFFNESSES}
    note = ", ".join(f"{error:.1e} m at {k:.0e}" for k, error in errors.items())
    on = f"error at k = 1e12 / at 1e6, ros34prw 1 ms, zeta {damping_ratio:g}"
    return Row("itself", on, errors[1e12] / errors[1e6], 10, 3, True, note)


def equal_dampers() -> Row:
    """The error where the dampers are the same and the stiffness is not."""
    with copies(crane("near_rigid").path, 1) as libraries:
        soft, stiff = (_stiff_error(libraries[0], k, z) for k, z in ((1e12, 1.0), (1e14, 0.1)))
    on = "error at k = 1e14, zeta 0.1 / at k = 1e12, zeta 1: equal dampers, ros34prw 1 ms"
    return Row("itself", on, stiff / soft, note=f"{soft:.1e} m, {stiff:.1e} m")


def _stiff_error(library: Library, stiffness: float, damping_ratio: float) -> float:
    made = instance(library, stiffness=stiffness, damping_ratio=damping_ratio)
    settled = _run_from(made, None, "rodas5p", 1e-10).end
    exact = _run_from(made, settled, "rodas5p", 1e-11).rows
    check = _run_from(made, settled, "radau5", 1e-11).rows
    error = np.abs(_run_from(made, settled, "ros34prw", 0.0).rows - exact).max()
    doubt = np.abs(check - exact).max()
    assert doubt < 0.3 * error, f"the reference at k = {stiffness:g} is not converged"
    return float(error)


@dataclass(frozen=True, slots=True)
class _Ended:
    rows: Array
    end: Array


def _run_from(made: Instance, settled: Array | None, method: str, rtol: float) -> _Ended:
    """One second from the start, or two more from a settled state; without rtol at 1 ms."""
    begin, end = (0.0, 1.0) if settled is None else (1.0, 3.0)
    assert made.reset(begin) is Status.OK
    if settled is not None:
        made.state[:] = settled
    options = OptionsStruct(name=method.encode(), rtol=rtol, step=0.0 if rtol else 1e-3)
    assert made.set_options(options) is Status.OK
    times = np.linspace(begin, end, 201)
    out = np.full((len(times), made.library.model.n_output), np.nan)
    status, _ = made.run(times, out)
    assert status is Status.OK
    return _Ended(positions(out), made.state.copy())


_COLD = """
import os, sys
from pathlib import Path
from bgc.building.build_result import run_facts
from bgc.building.cache import digest_of, open_cache
from bgc.driver import build_model, compile_scene
from bgc.emission.emit import emit_model
from bgc.emission.simplification import optimise
from bgc.options import Options

def spent():
    t = os.times()
    return t.user + t.system, t.children_user + t.children_system

compile_scene(Path(sys.argv[1]), Options(scene="fall"))
marks = [spent()]
crane = compile_scene(Path(sys.argv[2]), Options(scene="near_rigid"), until="slice")
marks.append(spent())
emitted = emit_model(optimise(crane.sliced), digest_of(s.text for s in crane.package.sources))
marks.append(spent())
build_model(emitted, run_facts(crane.graph.scene), Options(), (), open_cache())
marks.append(spent())
print(marks[1][0] - marks[0][0], marks[2][0] - marks[1][0], marks[3][1] - marks[2][1])
"""


def cold_compilation() -> list[Row]:
    """The 70-state crane with an empty cache, in processor time: C generated, C compiled."""
    measured = []
    for _ in range(3):
        with tempfile.TemporaryDirectory() as cache:
            done = subprocess.run(
                (sys.executable, "-c", _COLD, str(HERE / "pendulum.bg"), str(HERE / "crane.bg")),
                env={**os.environ, "BGC_CACHE_DIR": cache},
                capture_output=True, text=True, check=True,
            )  # fmt: skip
        measured.append([float(word) for word in done.stdout.split()])
    front, generated, compiled = (min(column) for column in zip(*measured, strict=True))
    made = crane("near_rigid").operations
    counts = f"f {made['rhs']:,}, J {made['jacobian']:,}, LU {made['factor']:,} operations"
    return [
        Row("a clock", "70 states, C generated: s of one processor", generated, 0.3, 0.05, True,
            f"{counts}; from text to equations {front:.2f} s before"),
        Row("a clock", "70 states, C compiled: s of one processor", compiled, 2.0, 1.0, True,
            "the runtime is compiled already"),
    ]  # fmt: skip


def rows() -> list[Row]:
    """Targets of the compiled code by itself."""
    report()
    return [uniform_accuracy(0.1), uniform_accuracy(1.0), equal_dampers(), *cold_compilation()]
