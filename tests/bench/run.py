"""Benchmarks against peers: `python tests/bench/run.py [NAMES] [--csv FILE]`.

Each prints ratios beside what they have to reach; the rules of a comparison stand at the top of its
module. Peers that are missing on the machine are rows that say so; all are there after

    pip install mujoco pin casadi drake
    apt-get install libsundials-dev libsuitesparse-dev libeigen3-dev libboost-dev

All take ten minutes of one processor. Nothing of this is a test. `curves.py` measures over sizes.
"""

from __future__ import annotations

import argparse
import time
from collections import Counter
from importlib import import_module
from pathlib import Path

from table import machine, pin, show

_NAMES = ("kernels", "arms", "sundials", "growth", "scipy_solvers", "rigid_peers", "casadi_code",
          "arm_peers", "drake_peers", "ensembles", "long_runs", "compile_growth")  # fmt: skip
_PACKAGES = ("numpy", "scipy", "mujoco", "pin", "casadi", "drake")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", choices=[[], *_NAMES], metavar="NAME",
                        help=f"of {', '.join(_NAMES)}; all without one")  # fmt: skip
    parser.add_argument("--csv", type=Path, help="append the rows to a file")
    given = parser.parse_args()
    pin()
    print(machine(*_PACKAGES))
    begun, found = time.monotonic(), Counter[str]()
    for name in given.names or _NAMES:
        rows = import_module(name).rows()
        show(name, rows, given.csv)
        found.update(row.verdict for row in rows if row.verdict)
    counts = ", ".join(f"{count} {verdict}" for verdict, count in found.items())
    print(f"{counts}; {time.monotonic() - begun:.0f} s")


if __name__ == "__main__":
    main()
