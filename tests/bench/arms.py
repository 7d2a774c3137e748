"""Arms and trees of rigid links: operations, size of the C, its compilation, and steps.

    python tests/bench/arms.py [arm:12 tree:15 ..]

Rules: each mechanism is compiled as it is, and with the speeds solved for in f and df/dx
accumulated (`explicit`), in one process. Operations are those of J (with df/dt), one factorisation
and one solution; the total has six solutions. Compilation of the C is processor time of the C
compiler, all units. A step is the least of several runs from the same start, without accounts:
ros34prw at 1 ms, and rodas5p at rtol 1e-6, over its own steps.
"""

from __future__ import annotations

import os
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from crane import instance, run
from growing import text_of
from table import Row

from bgc.driver import Stages, compile_scene
from bgc.emission import least_cost
from bgc.options import Options
from bgc.runtime.running.binding import Library
from bgc.runtime.running.structures import Status

MECHANISMS = ("arm:3", "arm:6", "arm:12", "arm:24", "arm:30", "tree:15", "tree:31")
_ROUNDS, _STEPS = 7, 200
_SOLUTIONS = 6


@dataclass(frozen=True)
class Measured:
    """The figures of one plan."""

    states: int
    inner: int
    operations: dict[str, int]
    kilobytes: float
    lowering: float  # s of processor time, from the text to the lowered program
    compiling: float  # s of processor time of the C compiler
    fixed: float  # s a step of ros34prw
    adaptive: float  # s a step of rodas5p

    @property
    def total(self) -> int:
        """Operations of J, LU and six solutions."""
        parts = self.operations
        return parts["jacobian"] + parts["factor"] + _SOLUTIONS * parts["solve"]


def measure(name: str, *, explicit: bool) -> Measured:
    """Compile a mechanism, without inner unknowns if `explicit`, and run it."""
    usual = least_cost.implicit_forms
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "boxes.bg"
        path.write_text(text_of(name), "utf-8")
        os.environ["BGC_CACHE_DIR"] = folder
        try:
            if explicit:
                least_cost.implicit_forms = lambda program: None
            begun = os.times()
            compile_scene(path, Options(), until="lower")
            between = os.times()
            stages = compile_scene(path, Options())
            done = os.times()
        finally:
            least_cost.implicit_forms = usual
            del os.environ["BGC_CACHE_DIR"]
        fixed, adaptive = _steps(stages)
    lowered, units = stages.lowered, stages.emitted.units
    return Measured(
        states=len(lowered.program.states),
        inner=lowered.jacobian.inner,
        operations=dict(stages.emitted.operations),
        kilobytes=sum(len(unit.text) for unit in units) / 1000,
        lowering=between.user - begun.user,
        compiling=done.children_user - between.children_user,
        fixed=fixed,
        adaptive=adaptive,
    )


def _steps(stages: Stages) -> tuple[float, float]:
    """Seconds a step of ros34prw and of rodas5p."""
    made = instance(Library(stages.built.library))
    least = [np.inf, np.inf]
    for _ in range(_ROUNDS):
        for k, options in enumerate(({"step": 1e-3}, {"rtol": 1e-6})):
            method = ("ros34prw", "rodas5p")[k]
            status, _, counts = run(made, np.array([1e-3 * _STEPS]), method, **options)
            assert status is Status.OK
            least[k] = min(least[k], counts["processor_seconds"] / counts["steps"])
    return least[0], least[1]


def rows() -> list[Row]:
    """Ratios of the explicit plan to the one that is chosen, of what compiles soon."""
    found = []
    for name in ("arm:6", "arm:12", "tree:15"):
        before, now = (measure(name, explicit=explicit) for explicit in (True, False))
        found.append(Row("derivatives of explicit rates", f"{name}, operations",
                         before.total / now.total, must=1.2))  # fmt: skip
        found.append(Row("derivatives of explicit rates", f"{name}, step of ros34prw",
                         before.fixed / now.fixed, must=1.0, aim=1.5))  # fmt: skip
    return found


def main() -> None:
    print("mechanism  plan      states+inner         f       J      LU  solve   J+LU+6s"
          "   kB  lower s   cc s  ros34prw us  rodas5p us")  # fmt: skip
    for name in sys.argv[1:] or MECHANISMS:
        for explicit in (True, False):
            found = measure(name, explicit=explicit)
            count = found.operations
            figures = (
                f"{name:10} {'explicit' if explicit else 'chosen':9}",
                f"{found.states:4} + {found.inner:<4} {count['rhs']:9,} {count['jacobian']:7,}",
                f"{count['factor']:7,} {count['solve']:6,} {found.total:9,}",
                f"{found.kilobytes:5,.0f} {found.lowering:7.1f} {found.compiling:7.1f}",
                f"{1e6 * found.fixed:11.2f} {1e6 * found.adaptive:11.2f}",
            )
            print(*figures, flush=True)


if __name__ == "__main__":
    main()
