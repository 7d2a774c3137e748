"""Figures of the emitted code itself: operations, times of f, J, factor, solve and of a step, cold
compilation, and the accuracy of stiff springs.

Rules: times are the least of several batches of calls in one copy of the shared object, and the
median over fresh copies. Absolute times are printed for orientation only.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from ctypes import POINTER, c_double, c_int, c_void_p
from statistics import median

import numpy as np
from crane import COPIES, HERE, copies, crane, instance, parameters, positions, run, shared_object
from table import Row

from bgc.runtime.binding import Library, Status

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
        best = min(best, counts["run_seconds"] / counts["steps"])
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


def uniform_accuracy() -> Row:
    """The error of one method and step from soft to rigid springs."""
    times = np.linspace(0.0, 3.0, 301)
    errors = {}
    with copies(crane("near_rigid").path, 1) as libraries:
        for k in STIFFNESSES:
            made = instance(libraries[0], stiffness=k)
            _, exact, _ = run(made, times, "rodas5p", rtol=1e-11)
            _, check, _ = run(made, times, "radau5", rtol=1e-11)
            _, rows, _ = run(made, times, "ros34prw", step=1e-3)
            doubt = np.abs(positions(check - exact)).max()
            errors[k] = np.abs(positions(rows - exact)).max()
            assert doubt < 0.3 * errors[k], f"the reference at k = {k:g} is not converged"
    note = ", ".join(f"{error:.1e} m at {k:.0e}" for k, error in errors.items())
    ratio = errors[1e12] / errors[1e6]
    return Row("itself", "error at k = 1e12 / at 1e6, 1 ms", ratio, 10, 3, True, note)


def cold_compilation() -> list[Row]:
    """The 70-state crane with an empty cache: C generated, C compiled."""
    program = (
        "import sys; from pathlib import Path; from bgc.driver import Compilation;"
        "from bgc.options import Options;"
        "c = Compilation(Path(sys.argv[1]), Options(scene='near_rigid')); c.built;"
        "print(repr(c.seconds))"
    )
    generated, compiled = [], []
    for _ in range(3):
        with tempfile.TemporaryDirectory() as cache:
            done = subprocess.run(
                (sys.executable, "-c", program, str(HERE / "crane.bg")),
                env={**os.environ, "BGC_CACHE_DIR": cache},
                capture_output=True, text=True, check=True,
            )  # fmt: skip
        seconds = eval(done.stdout)  # of our own process
        compiled.append(seconds["C compiler"])
        generated.append(seconds["optimise"] + seconds["emit"])
    made = crane("near_rigid").operations
    note = f"f {made['rhs']:,}, J {made['jacobian']:,}, LU {made['factor']:,} operations"
    return [
        Row("a clock", "70 states: C generated, s", median(generated), 0.3, 0.05, True, note),
        Row("a clock", "70 states: C compiled, s", median(compiled), 2.0, 1.0, True,
            "runtime and model, empty cache, two processors"),
    ]  # fmt: skip


def rows() -> list[Row]:
    """What the compiled code has to reach by itself."""
    report()
    return [uniform_accuracy(), *cold_compilation()]
