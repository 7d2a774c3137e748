"""LU of W and its solutions by unrolled code, tables and blocks of rows: `python factorisation.py`.

Of models that grow, each compiled in all three ways: microseconds of one factorisation and of one
solution, the median over fresh copies of the least of several batches, in processor time and in
turn; and the time of one factorisation with eight solutions over its estimate by
`emission/lu_cost.py`. The constants there are right where these ratios are equal in a row: then the
choice is. The last column has the largest difference of a solution from that by unrolled code or
tables, over its largest component, both over the states' scales.

`python factorisation.py crane:16 grid:20` measures these models. All take three minutes.
"""

from __future__ import annotations

import sys
import tempfile
from ctypes import POINTER, c_double, c_int, c_void_p, cast
from dataclasses import replace
from pathlib import Path
from statistics import median

import numpy as np
from crane import copies, instance, run, shared_object
from growing import text_of

from bgc.building.build import build_shared_object
from bgc.building.cache import open_cache
from bgc.building.toolchain import find_toolchain
from bgc.driver import compile_scene
from bgc.emission import print_lu
from bgc.emission.blocks import plan_blocks
from bgc.emission.emit import emit_lowered
from bgc.emission.lu_cost import block_cost, table_cost, unrolled_cost
from bgc.emission.sparse import entries_of_matrix
from bgc.ir.lowered import Lowered
from bgc.options import Options
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.binding import Library

_MODELS = ("crane:2", "crane:4", "crane:8", "crane:16", "crane:32",
           "circuit:100", "circuit:400", "grid:10", "grid:20")  # fmt: skip
_MOST_UNROLLED = 100_000  # operations: 6 s of gcc
_COPIES = 3
_Doubles = POINTER(c_double)


def lowered_model(name: str) -> Lowered:
    """A model such as `crane:16`."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.bg"
        path.write_text(text_of(name), "utf-8")
        return compile_scene(path, Options(), until="lower").lowered


def variants(lowered: Lowered) -> dict[str, tuple[Path, float]]:
    """The shared object by each way, and the estimated cost of that."""
    plan = lowered.plan
    entries = entries_of_matrix(lowered.program, lowered.jacobian)
    blocks = plan_blocks(plan, entries)
    ways = {
        "tables": (None, 0, table_cost(plan)),
        "blocks": (blocks, 0, block_cost(blocks.sizes, blocks.left, blocks.right, len(entries))),
    }
    if plan.operations <= _MOST_UNROLLED:
        ways = {"unrolled": (None, _MOST_UNROLLED, unrolled_cost(plan)), **ways}
    made = {}
    limit = print_lu.UNROLLED
    for name, (planned, unrolled, cost) in ways.items():
        print_lu.UNROLLED = unrolled
        units = emit_lowered(replace(lowered, blocks=planned), "").units
        print_lu.UNROLLED = limit
        made[name] = build_shared_object(units, find_toolchain(), open_cache()), cost
    return made


def measure(library: Library) -> tuple[float, float, Array]:
    """Seconds of a factorisation and of a solution in one copy, and a solution over the scales."""
    clock = shared_object(["linear_clock.c", "clock.c"])
    assert not isinstance(clock, str), clock
    made = instance(library)
    run(made, np.array([1e-3]), "ros23", step=1e-3)
    functions = [
        cast(getattr(library.functions, name), c_void_p) for name in ("bgc_factorise", "bgc_solve")
    ]
    seconds, scale, x = (c_double * 2)(), made.scale.copy(), made.scale.copy()
    calls = max(3, 400_000 // len(x) ** 2)
    clock.clock_linear.argtypes = (
        c_void_p, c_void_p, c_void_p, c_void_p, _Doubles, c_double, c_int, c_int, _Doubles, _Doubles
    )  # fmt: skip
    arrays = [array.ctypes.data_as(_Doubles) for array in (scale, x)]
    clock.clock_linear(
        library.pointer, made.address, *functions, arrays[0], 1e3, calls, 15, seconds, arrays[1]
    )
    return seconds[0], seconds[1], x / scale


def step_time(library: Library) -> float:
    """Seconds of a fixed step of the default method, with one factorisation and eight solutions."""
    made = instance(library)
    best = np.inf
    for _ in range(5):
        _, _, counts = run(made, np.array([200e-4]), "rodas5p", step=1e-4)
        best = min(best, counts["processor_seconds"] / counts["steps"])
    return float(best)


def report(name: str) -> None:
    """Print the rows of a model."""
    lowered = lowered_model(name)
    made = variants(lowered)
    solutions: list[Array] = []
    print(f"{name}: {len(lowered.program.states)} states, {lowered.plan.operations:,} operations, "
          f"{'blocks' if lowered.blocks else 'unrolled or tables'} chosen")  # fmt: skip
    for way, (path, cost) in made.items():
        with copies(path, _COPIES) as libraries:
            measured = [measure(library) for library in libraries]
            step = 1e6 * median(step_time(library) for library in libraries)
        factor, solve = (1e6 * median(row[k] for row in measured) for k in (0, 1))
        solutions.append(measured[0][2])
        difference = np.abs(solutions[-1] - solutions[0]).max() / np.abs(solutions[0]).max()
        total = factor + 8 * solve
        print(f"  {way:9s} LU {factor:8.2f} us, solution {solve:6.3f} us, with 8 solutions "
              f"{total:8.2f} us = {1e3 * total / cost:.2f} of the estimate; {difference:.1e}; "
              f"step {step:.2f} us")  # fmt: skip


if __name__ == "__main__":
    for model in sys.argv[1:] or _MODELS:
        report(model)
