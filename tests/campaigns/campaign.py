"""A campaign of many cases, in portions that are kept: mutated files, random programs, the library.

    python tests/campaigns/campaign.py mutants --count 100000 --results mutants.jsonl
    python tests/campaigns/campaign.py ill-posed --count 680
    python tests/campaigns/campaign.py programs --first 200000 --count 1000 --results programs.jsonl
    python tests/campaigns/campaign.py variants --of gantry/gantry --results variants.jsonl

The number of a random program is its seed in `../generated`. `--unjudged` runs those that have no
verdict yet, and `--record` enters in their list what the results hold.

Case N of a seed is the same file on every machine, as long as the files that it is made of are the
same. Portions in the file of results are not run again. `--show N` writes one case and its verdict.
"""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import tempfile
from collections.abc import Iterator
from functools import partial
from pathlib import Path

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ[_name] = "1"  # idle threads reserve memory

import ill_posed  # noqa: E402
import library_fuzz  # noqa: E402
import linkages  # noqa: E402
import mutants  # noqa: E402
import random_programs  # noqa: E402
import variants  # noqa: E402
import workers  # noqa: E402
from workers import keep_portion, kept_portions, run_portion, summary  # noqa: E402

KINDS = {
    "mutants": mutants, "ill-posed": ill_posed, "programs": random_programs,
    "library": library_fuzz, "variants": variants, "linkages": linkages,
}  # fmt: skip
LIMITS = ("CPU_SECONDS", "WALL_SECONDS", "MEMORY")  # of a case, where a kind has its own


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("kind", choices=KINDS)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--count", type=int, help="1,000; of library and variants all")
    parser.add_argument("--of", metavar="NAME", help="one part of the library, one scene")
    parser.add_argument("--results", type=Path, help="file of finished portions, to go on with")
    parser.add_argument("--show", type=int, metavar="N", help="write one case and its verdict")
    parser.add_argument("--summary", action="store_true", help="print the results so far")
    parser.add_argument("--seconds", type=float, help="processor time that a case may take")
    parser.add_argument("--unjudged", action="store_true", help="programs without a verdict")
    parser.add_argument("--record", action="store_true", help="list programs without a verdict")
    arguments = parser.parse_args()
    kind = KINDS[arguments.kind]
    for limit in LIMITS:
        setattr(workers, limit, getattr(kind, limit, getattr(workers, limit)))
    workers.CPU_SECONDS = arguments.seconds or workers.CPU_SECONDS
    if hasattr(kind, "groups"):
        names = list(kind.groups())
        if arguments.of is None:
            arguments.count = arguments.count or kind.SIZE * len(names)
        elif arguments.of in names:
            arguments.first += kind.SIZE * names.index(arguments.of)
            arguments.count = arguments.count or kind.SIZE
        else:
            parser.error(f"--of is one of {', '.join(names)}")
    if arguments.record:
        random_programs.record(kept_portions(arguments.results).values())
        return 0
    memory = Path("/dev/shm")
    home = memory if memory.is_dir() else None
    folder = Path(tempfile.mkdtemp(prefix="bgc-campaign-", dir=home))
    try:
        with mutants.library_parsed_once(), random_programs.machine_asked_once():
            run = _all if arguments.show is None else _show
            return run(arguments, folder)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def _show(arguments: argparse.Namespace, folder: Path) -> int:
    kind, number = KINDS[arguments.kind], arguments.show
    name, data = kind.text_of(arguments.seed, number)
    sys.stdout.buffer.write(data)
    sys.stdout.flush()
    portion = run_portion(number, 1, partial(kind.judge, arguments.seed), folder)
    print(f"{name}: {dict(portion.outcomes)} {' '.join(portion.codes)}", file=sys.stderr)
    for _, outcome, detail in portion.faults:
        print(outcome, detail, file=sys.stderr)
    return len(portion.faults)


def _all(arguments: argparse.Namespace, folder: Path) -> int:
    kept = kept_portions(arguments.results) if arguments.results else {}
    judge = partial(KINDS[arguments.kind].judge, arguments.seed)
    for first, size in _portions(arguments):
        if first in kept:
            continue
        portion = kept[first] = run_portion(first, size, judge, folder)
        if arguments.results:
            keep_portion(arguments.results, portion)
        for number, outcome, _ in portion.faults:
            print(f"case {number}: {outcome}", flush=True)
    print(summary(list(kept.values())))
    return 1 if any(portion.faults for portion in kept.values()) else 0


def _portions(arguments: argparse.Namespace) -> Iterator[tuple[int, int]]:
    """The first case and the size of each portion."""
    if arguments.summary:
        return
    if arguments.unjudged:
        yield from ((number, 1) for number in random_programs.unjudged())
        return
    size, end = KINDS[arguments.kind].PORTION, arguments.first + (arguments.count or 1_000)
    for first in range(arguments.first, end, size):
        yield first, min(size, end - first)


if __name__ == "__main__":
    sys.exit(main())
