"""Run many generated programs, resumable: `python tests/generated/campaign.py TABLE FIRST LAST`.

Seeds that TABLE has are left out; each other gives one line: seed, outcome, detail, seconds. With
FIRST alone, the program of this seed is printed with its outcome. `--summary` counts the table.
"""

from __future__ import annotations

import argparse
import collections
import signal
import sys
from pathlib import Path

from program_check import Outcome, check_equations, check_seed, program_of
from program_text import write

LONGEST = 10  # seconds of processor time of a program, after which it counts as slow


class _TooLong(BaseException):
    pass


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("table", type=Path)
    parser.add_argument("first", type=int, nargs="?")
    parser.add_argument("last", type=int, nargs="?")
    parser.add_argument("--variants", type=int)
    parser.add_argument("--summary", action="store_true")
    given = parser.parse_args()
    if given.summary:
        print(summary(given.table))
    elif given.last is None:
        print(write(program_of(given.first)))
        print(check(given.first, given.variants).row())
    else:
        run(given.table, range(given.first, given.last + 1), given.variants)
        print(summary(given.table))


def check(seed: int, variants: int | None) -> Outcome:
    """The outcome by equations; of every twentieth seed by the reference instead.

    One of four seeds tries a variant, those by the reference two, unless `variants` says how many.
    """
    if seed % 20 == 0:
        return check_seed(seed, variants=2 if variants is None else variants)
    count = int(seed % 4 == 1) if variants is None else variants
    return check_equations(seed, variants=count)


def run(table: Path, seeds: range, variants: int | None) -> None:
    done = {int(row[0]) for row in _rows(table)}
    signal.signal(signal.SIGPROF, _stop)
    with table.open("a", encoding="utf-8") as out:
        for seed in seeds:
            if seed in done:
                continue
            signal.setitimer(signal.ITIMER_PROF, LONGEST)
            try:
                outcome = check(seed, variants)
            except _TooLong:
                outcome = Outcome(seed, "slow", "", LONGEST)
            except Exception as err:
                outcome = Outcome(seed, "harness", f"{type(err).__name__}: {err}"[:100])
            finally:
                signal.setitimer(signal.ITIMER_PROF, 0)
            out.write(outcome.row().replace("\n", " ") + "\n")
            out.flush()


def _stop(*_: object) -> None:
    raise _TooLong


def _rows(table: Path) -> list[list[str]]:
    if not table.exists():
        return []
    return [line.split("\t") for line in table.read_text(encoding="utf-8").splitlines()]


def summary(table: Path) -> str:
    rows = _rows(table)
    counts = collections.Counter(row[1] for row in rows)
    refusals = collections.Counter(row[2] for row in rows if row[1] == "refused")
    seconds = sum(float(row[3]) for row in rows) / max(len(rows), 1)
    lines = [f"{len(rows)} programs, {seconds:.2f} s of processor time each"]
    lines += [f"  {count:6d}  {kind}" for kind, count in counts.most_common()]
    lines += [f"  {count:6d}  refused {about}" for about, count in refusals.most_common()]
    listed = ("differs", "crash", "loose", "harness")
    lines += ["\t".join(row) for row in rows if row[1] in listed]
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
