"""CasADi's C for the same equations, against ours.

Rules: the compiler's graph of f, before its Jacobian is made, becomes CasADi's, node for node
(SX); what depends on parameters alone is an argument of both, as in our code. CasADi
differentiates (its own choice of modes and colours), and its C is compiled with -O2 and the
flags for this machine that ours has; J is its sparse J and df/dt in one function. Calls in a
loop in C, the least of batches, both in turn, the median over fresh copies.
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from ctypes import CDLL, POINTER, byref, c_double, c_int, c_longlong
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from crane import COPIES, copies, crane, instance, shared_object
from kernels import kernel_times
from table import Row

from bgc.algebra.dag import Kind, Level
from bgc.building.toolchain import COMMON_FLAGS, find_toolchain
from bgc.ir.program import Program
from bgc.runtime.linearising.casadi_expressions import expressions
from bgc.runtime.results.arrays import Array

_Doubles = POINTER(c_double)


def rows() -> list[Row]:
    """f and J with df/dt, of the crane with springs and the reduced one."""
    try:
        import casadi
    except ImportError:
        return [Row("CasADi", "f, J", None, note="pip install casadi")]
    return [row for scene in ("near_rigid", "reduced") for row in _compare(casadi, scene)]


def _translated(casadi: Any, program: Program) -> tuple[Any, Any]:
    """f, and J with df/dt, as CasADi functions of (t, x, h)."""
    sx = casadi.SX
    dag, t, x = program.dag.copy(), sx.sym("t"), sx.sym("x", len(program.states))
    rates = [state.derivative for state in program.states]
    known = [
        n for n in dag.reachable(rates) if dag.level[n] <= Level.PARAM and dag.value(n) is None
    ]
    hoisted = {node: dag.symbol(Kind.START, k) for k, node in enumerate(known)}
    h = sx.sym("h", len(known))
    of = {Kind.STATE: lambda k: x[k], Kind.START: lambda k: h[k], Kind.TIME: lambda k: t}
    nodes = dag.substitute(rates, hoisted)
    f = casadi.vertcat(*expressions(casadi, dag, nodes, lambda s: of[s.kind](s.index), {}))
    used = [h[k] for k in range(len(known)) if casadi.depends_on(f, h[k])]
    h = casadi.vertcat(sx(0, 1), *used)
    both = [casadi.jacobian(f, x), casadi.jacobian(f, t)]
    return casadi.Function("f", [t, x, h], [f]), casadi.Function("j", [t, x, h], both)


def measured(program: Program, x: Array, derivatives: bool) -> tuple[float, ...] | str:
    """Seconds of f and, if asked for, of J with df/dt near x; or why there are none."""
    try:
        import casadi
    except ImportError:
        return "pip install casadi"
    functions = _translated(casadi, program)[: 1 + derivatives]
    with tempfile.TemporaryDirectory() as folder:
        peer = CDLL(str(_compiled(casadi, functions, Path(folder))))
        return tuple(
            _seconds(_clock(), peer, name, function, x)
            for name, function in zip("fj", functions, strict=False)
        )


def _clock() -> CDLL:
    clock = shared_object(["casadi_clock.c", "clock.c"])
    assert not isinstance(clock, str), clock
    clock.casadi_seconds.restype = c_double
    return clock


def _compare(casadi: Any, scene: str) -> list[Row]:
    clock = _clock()
    f, j = _translated(casadi, crane(scene).stages.optimised)
    ratios: dict[str, list[float]] = {"f": [], "j": []}
    with tempfile.TemporaryDirectory() as folder, copies(crane(scene).path) as libraries:
        made = _compiled(casadi, [f, j], Path(folder))
        x = instance(libraries[0]).state.copy()
        x += np.random.default_rng(1).normal(size=x.size) * 1e-3
        for k in range(COPIES):
            copy = Path(folder) / f"{k}.so"
            shutil.copyfile(made, copy)
            peer = CDLL(str(copy))
            ours = kernel_times(libraries[k], 500, 40)
            for name, function, mine in (("f", f, ours[0]), ("j", j, ours[1])):
                theirs = _seconds(clock, peer, name, function, x)
                ratios[name].append(theirs / mine)
    counts = crane(scene).operations
    return [
        Row("CasADi, -O2", f"f, {scene}", median(ratios["f"]), 1 / 1.05, 1 / 0.8,
            note=f"{counts['rhs']:,} operations against {f.n_instructions():,} instructions"),
        Row("CasADi, -O2", f"J with df/dt, {scene}", median(ratios["j"]), 1 / 1.05, 1 / 0.9,
            note=f"{counts['jacobian']:,} operations against {j.n_instructions():,} instructions"),
    ]  # fmt: skip


def _compiled(casadi: Any, functions: Sequence[Any], folder: Path) -> Path:
    generator = casadi.CodeGenerator("peer.c", {"with_header": False})
    for function in functions:
        generator.add(function)
    generator.generate(str(folder) + "/")
    made = folder / "peer.so"
    flags = [flag for flag in COMMON_FLAGS if not flag.startswith("-std")]
    subprocess.run(
        (*find_toolchain().command, "-O2", *flags, "-ffp-contract=fast", "-shared", "peer.c",
         "-o", str(made), "-lm"),
        cwd=folder, check=True,
    )  # fmt: skip
    return made


def _seconds(clock: CDLL, peer: CDLL, name: str, function: Any, x: np.ndarray) -> float:
    sizes = [c_longlong() for _ in range(4)]
    getattr(peer, f"{name}_work")(*map(byref, sizes))
    rng = np.random.default_rng(2)
    t, h = np.array([0.1]), rng.uniform(0.5, 2.0, max(1, function.size1_in(2)))
    out = np.zeros(sum(function.nnz_out(k) for k in range(function.n_out())) + 1)
    first = function.nnz_out(0)
    return float(
        clock.casadi_seconds(
            getattr(peer, name), *(a.ctypes.data_as(_Doubles) for a in (t, x, h, out)),
            c_int(first), c_int(int(sizes[3].value)), c_int(500), c_int(40),
        )
    )  # fmt: skip
