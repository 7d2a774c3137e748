"""CVODE on the crane with springs, against the adaptive default.

Rules: CVODE (BDF, Newton) gets our compiled f, and with KLU our J too; tolerances of both run
over the same ladder, absolute ones per state, rtol times its scale. Both write the same rows in
C. The error is the largest distance of a body from the reference in any row (rodas5p at rtol
1e-11, checked with radau5). Time to 1e-5 m is that of the cheapest tolerance that reaches it, the
least of three runs in turn; the ratio is the median over fresh copies of our code. Both start from
rest with the springs unloaded, as a user's first model would.
"""

from __future__ import annotations

import ctypes
import time
from ctypes import POINTER, c_double, c_int, c_long, c_size_t, c_void_p
from dataclasses import dataclass
from statistics import median

import numpy as np
from crane import copies, crane, instance, parameters, positions, run, shared_object
from table import Row

from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.structures import Status

_FLAGS = (
    "-I/usr/include/suitesparse", "-lsundials_cvode", "-lsundials_nvecserial",
    "-lsundials_sunlinsolklu", "-lsundials_sunlinsoldense", "-lsundials_sunmatrixsparse", "-lklu",
)  # fmt: skip
_DURATION = 3.0
_TARGET = 1e-5  # m
_LADDER = tuple(10.0 ** (-k / 2) for k in range(4, 19))
_STIFFNESSES = (1e6, 1e8, 1e10, 1e12)
_DAMPING = (0.1, 1.0)  # ratios: of springs that ring, and critical, as in the paper
_PATIENCE = 40.0  # s of one run of a peer
_LONG = 0.5  # s of one that is not repeated

_Doubles = POINTER(c_double)


@dataclass(frozen=True, slots=True)
class Run:
    """One run: its seconds, its rows of positions and its steps."""

    seconds: float
    rows: Array
    steps: int


def cvode() -> ctypes.CDLL | str:
    """The peer, or why there is none."""
    made = shared_object(["cvode.c", "clock.c"], _FLAGS)
    if isinstance(made, str):
        return f"{made} (Debian: apt-get install libsundials-dev libsuitesparse-dev)"
    made.cvode_run.restype = c_double
    made.cvode_run.argtypes = (
        c_void_p, _Doubles, _Doubles, _Doubles, c_size_t, _Doubles, c_double, c_int,
        POINTER(c_long),
    )  # fmt: skip
    return made


def run_cvode(peer: ctypes.CDLL, made: Instance, times: Array, rtol: float, sparse: bool) -> Run:
    """CVODE from the instance's initial state."""
    assert made.reset() is Status.OK
    out = np.full((len(times), made.library.model.n_output), np.nan)
    counts = (c_long * 3)()
    arrays = [parameters(made), made.state.copy(), times]
    pointers = [array.ctypes.data_as(_Doubles) for array in arrays]
    seconds = peer.cvode_run(
        made.library.pointer, *pointers, len(times), out.ctypes.data_as(_Doubles), rtol,
        int(sparse), counts,
    )  # fmt: skip
    return Run(seconds if seconds > 0 else np.inf, positions(out), counts[0])


def run_ours(made: Instance, times: Array, rtol: float, method: str = "rodas5p") -> Run:
    """One of our adaptive methods from the instance's initial state."""
    status, out, counts = run(made, times, method, rtol=rtol)
    seconds = counts["processor_seconds"] if status is Status.OK else np.inf
    return Run(seconds, positions(out), int(counts["steps"]))


def reference(made: Instance, times: Array) -> Array:
    """Rows that two methods agree on."""
    exact = run_ours(made, times, 1e-11).rows
    check = run_ours(made, times, 1e-11, "radau5").rows
    assert np.abs(exact - check).max() < 0.01 * _TARGET, "the reference is not converged"
    return exact


def rows() -> list[Row]:
    """CVODE with a dense difference-quotient J, with KLU and our J, and undamped."""
    peer = cvode()
    if isinstance(peer, str):
        return [Row("CVODE", "crane, 70 states", None, note=peer)]
    times = np.linspace(0.0, _DURATION, 301)
    found: list[Row] = []
    with copies(crane("near_rigid").path) as libraries:
        for zeta in _DAMPING:
            for k in _STIFFNESSES:
                made = [instance(one, stiffness=k, damping_ratio=zeta) for one in libraries]
                found += _to_target(peer, made, times, k, f"k = {k:.0e}, zeta = {zeta:g}")
        found.append(_undamped(peer, instance(libraries[0], stiffness=1e10, damping_ratio=0.0)))
    return found


def _to_target(
    peer: ctypes.CDLL, made: list[Instance], times: Array, k: float, case: str
) -> list[Row]:
    """Ratios of instances of several copies: the tolerances of the first, the median time."""
    exact = reference(made[0], times)

    def cheapest(run_at) -> tuple[float, float, Run] | None:  # type: ignore[no-untyped-def]
        begun, best = time.perf_counter(), None
        for rtol in _LADDER:
            one = run_at(rtol)
            if one.seconds < _LONG:
                one = min(one, run_at(rtol), run_at(rtol), key=lambda each: each.seconds)
            error = np.abs(one.rows - exact).max()
            if error <= _TARGET and (best is None or one.seconds < best[2].seconds):
                best = (rtol, error, one)
            if best is not None and one.seconds > 2 * best[2].seconds:
                break
            if time.perf_counter() - begun > _PATIENCE:
                break
        return best

    ours = cheapest(lambda rtol: run_ours(made[0], times, rtol))
    assert ours is not None
    made_rows = []
    for sparse, name, must, aim in (
        (False, "CVODE dense, difference quotients", 10, 30 if k >= 1e8 else None),
        (True, "CVODE + KLU + our J", 3, 12 if k >= 1e8 else None),
    ):
        on = f"time to 1e-5 m, {case}"
        theirs = cheapest(lambda rtol: run_cvode(peer, made[0], times, rtol, sparse))  # noqa: B023
        if theirs is None:
            made_rows.append(Row(name, on, np.inf, must, aim, note=f"not within {_PATIENCE:g} s"))
            continue
        ratios = []
        for one in made if theirs[2].seconds < _LONG else made[:1]:
            pairs = [
                (run_cvode(peer, one, times, theirs[0], sparse).seconds,
                 run_ours(one, times, ours[0]).seconds)
                for _ in range(3)
            ]  # fmt: skip
            second, first = (min(column) for column in zip(*pairs, strict=True))
            ratios.append(second / first)
        note = (
            f"{ours[2].steps:,} steps at rtol {ours[0]:.0e}, {ours[1]:.0e} m; "
            f"CVODE {theirs[2].steps:,} at {theirs[0]:.0e}, {theirs[1]:.0e} m"
        )
        made_rows.append(Row(name, on, median(ratios), must, aim, note=note))
    return made_rows


def _undamped(peer: ctypes.CDLL, made: Instance) -> Row:
    times = np.linspace(0.0, 10.0, 101)
    ours = min((run_ours(made, times, 1e-6) for _ in range(5)), key=lambda one: one.seconds)
    theirs = run_cvode(peer, made, times, 1e-6, sparse=True)
    apart = np.abs(ours.rows - theirs.rows).max()
    note = f"with KLU, 10 s; {ours.steps:,} steps against {theirs.steps:,}; {apart:.0e} m apart"
    on = "zeta = 0, k = 1e10, rtol 1e-6"
    return Row("CVODE", on, theirs.seconds / ours.seconds, 100, 300, note=note)
