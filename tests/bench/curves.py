"""Benchmarks as curves over the size of a model, on one page: `python tests/bench/curves.py`.

    python tests/bench/curves.py                       # measure everything, write the page
    python tests/bench/curves.py compile --of arm      # measure one figure of one family
    python tests/bench/curves.py --draw --out FOLDER   # write the page from the stored points

The points are in `curves.csv`: measuring everything begins a new file, whose points are of one
machine and one run, and measuring a part replaces its points. The page, `benchmarks.md` with its
plots, goes to the folder `--out`. Everything takes a quarter of an hour on one processor. The
rules of each comparison stand at the top of `growth.py`, `drake_peers.py`, `arm_peers.py` and of
the functions below. Peers that are missing have no points; `run.py` says how to install them.
"""

from __future__ import annotations

import argparse
import csv
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

import arm_peers
import drake_peers
import growth
from compile_growth import ALONE
from curves_page import Point, page, read_points
from growing import HYDRAULIC, text_of
from table import machine, pin

STORE = Path(__file__).with_name("curves.csv")
_ERROR = 1e-4
_ENDS = {"crane": 1.0, "beam": 1.0, "arm": 1.0, "tree": 1.0}  # s of a run; of the others 10 s
_RUNS, _LONG = 3, 6.0  # of `bgc build`; s of processor time after which there is no other

_SIZES = {
    "error": {
        "crane": (2, 4, 8, 16, 32, 64), "beam": (5, 10, 20, 40), "arm": (3, 6, 12, 24, 48),
        "tree": (7, 15, 31), "chain": (100, 300, 1000), "circuit": (100, 200, 400),
        "grid": (5, 10, 20, 30), "field": (15, 30, 60), "hydraulic": tuple(HYDRAULIC),
    },
    "rates": {"arm": (3, 6, 12, 24, 48), "tree": (7, 15, 31)},
    "compile": {
        "crane": (2, 4, 8, 16, 32, 64), "beam": (5, 10, 20, 40), "arm": (3, 6, 12, 24, 30, 48, 60),
        "tree": (7, 15, 31), "chain": (100, 200, 500, 1000), "motors": (50, 100, 200, 500),
        "circuit": (100, 200, 400), "ladder": (50, 100, 200, 400), "grid": (5, 10, 20, 30),
        "field": (15, 25, 40, 60), "hydraulic": tuple(HYDRAULIC),
    },
}  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("figures", nargs="*", choices=[[], *_SIZES], metavar="FIGURE")
    parser.add_argument("--of", nargs="*", help="families; by default all")
    parser.add_argument("--draw", action="store_true", help="draw the stored points only")
    parser.add_argument("--out", type=Path, help="folder of the page; by default none is written")
    given = parser.parse_args()
    pin()
    if not (given.draw or given.figures or given.of):
        STORE.unlink(missing_ok=True)
    begun, failed = time.monotonic(), []
    for figure in () if given.draw else given.figures or _SIZES:
        for family in given.of or _SIZES[figure]:
            for size in _SIZES[figure].get(family, ()):
                try:
                    for point in _MEASURE[figure](family, size):
                        print(point, flush=True)
                        store(point)
                except (Exception, SystemExit) as problem:  # the others are measured all the same
                    failed.append(f"{figure} of {family}:{size}: {problem!r}")
    if given.out is not None:
        lines = page(read_points(STORE), given.out, "")
        (given.out / "benchmarks.md").write_text("\n".join(lines) + "\n", "utf-8")
    print(f"{(time.monotonic() - begun) / 60:.1f} minutes")
    if failed:
        raise SystemExit("\n".join(failed))


def store(point: Point) -> None:
    """Add a point in the place of the one that has the same figure, family, tool and size."""
    points = [each for each in read_points(STORE) if each.key != point.key]
    points = sorted([*points, point], key=lambda each: each.key)
    with STORE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(("figure", "family", "tool", "size", "value", "machine"))
        for each in points:
            writer.writerow((*each.key, f"{each.value:.4g}", each.machine))


def _points(figure: str, family: str, size: int, values: dict[str, float]) -> Iterator[Point]:
    where = machine("mujoco", "pin", "scipy", "casadi", "drake")
    for tool, value in values.items():
        yield Point(figure, family, tool, size, value, where)


def to_error(family: str, size: int) -> Iterator[Point]:
    """Processor time of a run whose largest error is 1e-4: ms of the run, and us of its steps."""
    _, found = growth.measure(f"{family}:{size}", _ENDS.get(family, 10.0), with_scipy=True)
    if family in ("arm", "tree"):
        peer = drake_peers.measure(f"{family}:{size}", _ERROR)
        found |= {} if isinstance(peer, str) else {"Drake": peer.any_of_drake}
    runs = {way: growth.cheapest(_ERROR, timed) for way, timed in found.items()}
    reached = {way: run for way, run in runs.items() if run.error <= _ERROR}
    values = {way: 1e3 * run.seconds for way, run in reached.items()}
    yield from _points("error", family, size, values)
    values = {way: 1e6 * run.seconds / run.steps for way, run in reached.items() if run.steps > 0}
    yield from _points("controlled", family, size, values)


def rates(family: str, size: int) -> Iterator[Point]:
    """Microseconds of a call, of rates, their derivatives and steps."""
    found = arm_peers.measured(f"{family}:{size}")
    values = {tool: 1e6 * each for tool, each in found.items() if not isinstance(each, str)}
    figures = {
        "rates": ("our f", "Pinocchio ABA", "mj_forward", "CasADi f"),
        "derivatives": ("our J", "ABA derivatives", "CasADi J"),
        "steps": ("ours, 1 ms", "ros34prw, 1 ms", "mj_step implicitfast", "mj_step implicit"),
    }
    for figure, tools in figures.items():
        chosen = {tool: values[tool] for tool in tools if tool in values}
        yield from _points(figure, family, size, chosen)


def compilation(family: str, size: int) -> Iterator[Point]:
    """Seconds of processor time and memory of `bgc build`, and the size of the C.

    Those are the least of three builds, but for builds that take long. Of time and size, those of a
    model with one state are subtracted: imports, and the runtime. The C compiler's time is the
    difference between the targets `so` and `c`, each in a cache of its own.
    """
    (alone, alone_kilobytes, *_) = _built(ALONE)
    seconds, kilobytes, compiler, peak = _built(text_of(f"{family}:{size}"))
    times = {"bgc": seconds - alone, "C compiler": compiler}
    yield from _points("compile", family, size, times)
    yield from _points("size", family, size, {"C": kilobytes - alone_kilobytes})
    yield from _points("memory", family, size, {"bgc": peak})


@cache
def _built(text: str) -> tuple[float, float, float, float]:
    """Seconds of `bgc build --target c`, kB of C, seconds of the C compiler, and peak MB."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "model.bg"
        path.write_text(text, "utf-8")
        to_c: list[tuple[float, float]] = []
        while len(to_c) < _RUNS and sum(each for each, _ in to_c) < _LONG:
            to_c.append(_build(path, "c", Path(folder) / f"c{len(to_c)}"))
        kilobytes = sum(file.stat().st_size for file in path.parent.glob("*.[ch]")) / 1e3
        to_so = _build(path, "so", Path(folder) / "so")
    seconds = min(each for each, _ in to_c)
    peak = min(each for _, each in to_c)
    return seconds, kilobytes, max(0.0, to_so[0] - seconds), peak


# A process begins with the peak memory of the one that starts it, so a small one starts `bgc`.
_STARTER = """
import resource, subprocess, sys
ended = subprocess.run(sys.argv[1:], stdout=subprocess.DEVNULL)
print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)
sys.exit(ended.returncode)
"""


def _build(path: Path, target: str, cache: Path) -> tuple[float, float]:
    """Processor time in s, of all processes, and the largest memory of one in MB."""
    build = [str(Path(sys.executable).with_name("bgc")), "build", path.name, "--target", target]
    command = [sys.executable, "-c", _STARTER, *build]
    environment = {**os.environ, "BGC_CACHE_DIR": str(cache)}
    with subprocess.Popen(command, cwd=path.parent, env=environment, stdout=subprocess.PIPE,
                          text=True) as process:  # fmt: skip
        assert process.stdout is not None
        printed = process.stdout.read()
        _, status, used = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"{path.name}: bgc build ended with status {process.returncode}")
    return used.ru_utime + used.ru_stime, int(printed) / 1e3


_MEASURE: dict[str, Callable[[str, int], Iterator[Point]]] = {
    "error": to_error,
    "rates": rates,
    "compile": compilation,
}


if __name__ == "__main__":
    main()
