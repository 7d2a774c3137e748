"""Benchmarks against peers: `python tests/bench/run.py [NAMES] [--csv FILE]`.

Each prints ratios beside what they have to reach; the rules of a comparison stand at the top of its
module. Peers that are missing on the machine are rows that say so. Nothing of this is a test.
"""

from __future__ import annotations

import argparse
from importlib import import_module
from pathlib import Path

from table import machine, pin, show

_NAMES = ("kernels", "sundials", "scipy_solvers", "rigid_peers", "casadi_code",
          "ensembles", "long_runs")  # fmt: skip
_PACKAGES = ("numpy", "scipy", "mujoco", "pin", "casadi")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", choices=[[], *_NAMES], metavar="NAME",
                        help=f"of {', '.join(_NAMES)}; all without one")  # fmt: skip
    parser.add_argument("--csv", type=Path, help="append the rows to a file")
    given = parser.parse_args()
    pin()
    print(machine(*_PACKAGES))
    for name in given.names or _NAMES:
        show(name, import_module(name).rows(), given.csv)


if __name__ == "__main__":
    main()
