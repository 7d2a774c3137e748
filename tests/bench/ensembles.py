"""Many instances in the lanes of a vector register against one at a time, per instance.

Rules: both are of the same shared object, measured in turn in one process on one processor; times
are the least of several batches of calls in one copy, ratios the median over fresh copies.
"""

from __future__ import annotations

from ctypes import POINTER, c_double, c_int, c_void_p
from pathlib import Path
from statistics import median
from time import thread_time

import numpy as np
from crane import COPIES, HERE, copies, instance, parameters, shared_object
from kernels import kernel_times
from table import Row

from bgc.driver import compile_scene
from bgc.options import Options
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.lane_interface import LaneLibrary
from bgc.runtime.running.structures import OptionsStruct, Status

_NAMES = ("f", "J with df/dt", "factor", "solve")
_RUNS = (
    ("ros34prw", {"step": 1e-3}), ("ros34prw, J kept 5 steps", {"step": 1e-3, "keep": 5}),
    ("ros23, J kept 5 steps", {"step": 1e-3, "keep": 5}), ("rodas5p, rtol 1e-6", {"rtol": 1e-6}),
)  # fmt: skip


def lane_times(library: LaneLibrary, calls: int = 500, batches: int = 15) -> list[float]:
    """Seconds of f, J, factor and solve per instance in one copy, all lanes at work."""
    clock = shared_object(["lane_clock.c", "clock.c"])
    assert not isinstance(clock, str), clock
    made = instance(library)
    doubles = POINTER(c_double)
    seconds = (c_double * 4)()
    library.functions.bgc_get_lane_model.restype = c_void_p
    clock.clock_lanes.argtypes = (
        c_void_p, c_void_p, doubles, doubles, c_double, c_int, c_int, doubles
    )  # fmt: skip
    assert clock.lane_clock_width() == library.width
    p, x = parameters(made), made.state.copy()
    arrays = [array.ctypes.data_as(doubles) for array in (p, x)]
    lanes = library.functions.bgc_get_lane_model()
    clock.clock_lanes(library.pointer, lanes, *arrays, 0.1, calls, batches, seconds)
    return [each / library.width for each in seconds]


def run_ratio(library: LaneLibrary, method: str, options: dict[str, float]) -> float:
    """Seconds of runs one at a time over those of a batch, per instance; a second is simulated."""
    times = np.linspace(0.0, 1.0, 11)
    name = method.partition(",")[0]
    together, alone = np.inf, np.inf
    rows = np.empty((library.width, len(times), library.model.n_output))
    for _ in range(5):
        batch = [_instance(library, name, options, k) for k in range(library.width)]
        start = thread_time()
        status, finished = library.run(batch, times, list(rows))
        together = min(together, (thread_time() - start) / library.width)
        assert status is Status.OK and all(finished)
        one = _instance(library, name, options, 0)
        start = thread_time()
        status, _ = one.run(times, rows[0])
        alone = min(alone, thread_time() - start)
        assert status is Status.OK
    return float(alone / together)


def _instance(library: LaneLibrary, name: str, options: dict[str, float], number: int) -> Instance:
    """An instance ready to run; they differ by some in a million in their first parameter."""
    made = instance(library)
    made.set_parameter(0, made.parameter(0) * (1.0 + 1e-6 * number))
    assert made.set_options(OptionsStruct(name=name.encode(), **options)) is Status.OK
    assert made.reset() is Status.OK
    return made


def rows() -> list[Row]:
    """Per instance, with a full register."""
    found = []
    for scene in ("near_rigid", "reduced"):
        path = compile_scene(HERE / "crane.bg", Options(scene=scene, lanes=True)).built.library
        with copies(path) as plain:
            libraries = [LaneLibrary(Path(each.functions._name)) for each in plain]
            pairs = [(kernel_times(lib), lane_times(lib)) for lib in libraries]
            width, n = libraries[0].width, libraries[0].model.n_state
            on = f"{n} states, {width} lanes"
            for k, name in enumerate(_NAMES):
                ratio = median(alone[k] / lanes[k] for alone, lanes in pairs)
                each = median(lanes[k] for _, lanes in pairs)
                note = f"{1e6 * each:.3f} us an instance, {COPIES} copies"
                found.append(Row("one at a time", f"{on}: {name}", ratio, None, 4, note=note))
            for method, options in _RUNS:
                ratio = median(run_ratio(lib, method, options) for lib in libraries)
                found.append(Row("one at a time", f"{on}: {method}", ratio, None, 4))
    return found
