"""Random planar linkages on mounts, as many of each kind as asked for: do they compile and move?

    python tests/campaigns/linkages.py --count 4 [--first 100] [--kind triangle] [--mounts eleven]
                                       [--base body] [--digits 7] [--compile-only]

A linkage has to compile; run for 0.5 s, its loop and the rates in it have to stay closed to the
digits of its mounts by the lengths of its bars alone, and the account of energy has to be closed. A
run may also end with the status of a singular position. Outcomes are counted for each kind.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections import Counter
from itertools import product
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "physics"))

import numpy as np
from mounted_linkages import BASES, KINDS, MOUNTS, MountedLinkage, mounted_linkage

import bgc
from bgc.driver import compile_scene
from bgc.options import Options
from bgc.runtime.running.failures import SimulationError

OPEN = 1e-8  # m, rad and their rates
RESIDUAL = 1e-7  # of the energy that is exchanged, and J


def judged(linkage: MountedLinkage, folder: Path, tolerance: float, *, runs: bool) -> str:
    """`fine`, the code of a refusal, or what is wrong."""
    path = folder / "linkage.bg"
    path.write_text(linkage.source, "utf-8")
    try:
        if not runs:
            compile_scene(path, Options("linkage"), until="equations")
            return "fine"
        result = bgc.compile(path, scene="linkage", preview=True).simulate()
    except SimulationError as err:
        (diagnostic,) = err.diagnostics
        return "singular" if diagnostic.code == "BG735" else diagnostic.code
    except bgc.BgError as err:
        return err.diagnostics[0].code
    except Exception as err:
        return type(err).__name__
    q, v = (np.column_stack([result[f"{name}{k}"] for k in range(4)]) for name in "qv")
    if not linkage.misfit(q, v) < tolerance:
        return "open"
    exchanged = np.ptp(result["energy.stored"])
    balanced = np.abs(result["energy.residual"]).max() < RESIDUAL * (1 + exchanged)
    return "fine" if balanced else "energy"


def main() -> None:
    """Judge the cases, and print each that is not fine, and the counts."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=4, help="linkages of each kind")
    parser.add_argument("--first", type=int, default=100, help="seed of the first")
    parser.add_argument("--kind", choices=KINDS)
    parser.add_argument("--mounts", choices=MOUNTS)
    parser.add_argument("--base", choices=BASES)
    parser.add_argument("--digits", type=int, default=0, help="decimals of all mounts")
    parser.add_argument("--compile-only", action="store_true")
    given = parser.parse_args()
    tolerance = max(OPEN, 1e3 * 10.0**-given.digits if given.digits else 0.0)
    groups = product(
        [given.mounts] if given.mounts else MOUNTS,
        [given.kind] if given.kind else KINDS,
        [given.base] if given.base else BASES,
    )
    with tempfile.TemporaryDirectory() as folder:
        for mounts, kind, base in groups:
            counts: Counter[str] = Counter()
            for seed in range(given.first, given.first + given.count):
                linkage = mounted_linkage(seed, kind, mounts, base, 1 + seed % 4, given.digits)
                runs = not given.compile_only
                outcome = judged(linkage, Path(folder), tolerance, runs=runs)
                counts[outcome] += 1
                if outcome not in {"fine", "singular"}:
                    print(f"  seed {seed}: {outcome}", flush=True)
            print(mounts, kind, base, dict(counts), flush=True)


if __name__ == "__main__":
    main()
