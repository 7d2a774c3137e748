"""Run many generated programs, resumable: `python tests/generated/campaign.py TABLE FIRST LAST`.

Seeds that TABLE has are left out; each other gives one line: seed, outcome, detail, seconds. With
FIRST alone, the program of this seed is printed with its outcome. `--summary` counts the table.

`unjudged.tsv` beside this file keeps the seeds without a verdict, in the form of a table, and the
commit of their outcome. `--record` enters those of TABLE there and removes those that TABLE judges;
`--unjudged` runs the seeds that are there, with `--seconds` as the limit of a program.
"""

from __future__ import annotations

import argparse
import collections
import signal
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

from program_check import Outcome, check_equations, check_seed, program_of
from program_text import write

LONGEST = 10.0  # seconds of processor time of a program, after which it counts as slow
UNJUDGED = Path(__file__).with_name("unjudged.tsv")
WITHOUT_VERDICT = ("reference", "refused", "open", "slow", "same", "differs", "crash", "harness")


class _TooLong(BaseException):
    pass


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("table", type=Path)
    parser.add_argument("first", type=int, nargs="?")
    parser.add_argument("last", type=int, nargs="?")
    parser.add_argument("--variants", type=int)
    parser.add_argument("--summary", action="store_true")
    parser.add_argument("--record", action="store_true")
    parser.add_argument("--unjudged", action="store_true")
    parser.add_argument("--seconds", type=float, default=LONGEST)
    given = parser.parse_args()
    if given.summary:
        print(summary(given.table))
    elif given.record:
        record(given.table)
    elif given.unjudged:
        run(given.table, [int(row[0]) for row in _rows(UNJUDGED)], given.variants, given.seconds)
        print(summary(given.table))
    elif given.last is None:
        print(write(program_of(given.first)))
        print(check(given.first, given.variants).row())
    else:
        seeds = range(given.first, given.last + 1)
        run(given.table, seeds, given.variants, given.seconds)
        print(summary(given.table))


def check(seed: int, variants: int | None) -> Outcome:
    """The outcome by equations; of every twentieth seed by the reference instead.

    One of four seeds tries a variant, those by the reference two, unless `variants` says how many.
    """
    if seed % 20 == 0:
        return check_seed(seed, variants=2 if variants is None else variants)
    count = int(seed % 4 == 1) if variants is None else variants
    return check_equations(seed, variants=count)


def run(table: Path, seeds: Iterable[int], variants: int | None, longest: float) -> None:
    done = {int(row[0]) for row in _rows(table)}
    signal.signal(signal.SIGPROF, _stop)
    with table.open("a", encoding="utf-8") as out:
        for seed in seeds:
            if seed in done:
                continue
            signal.setitimer(signal.ITIMER_PROF, longest)
            try:
                outcome = check(seed, variants)
            except _TooLong:
                outcome = Outcome(seed, "slow", "", longest)
            except Exception as err:
                outcome = Outcome(seed, "harness", f"{type(err).__name__}: {err}"[:100])
            finally:
                signal.setitimer(signal.ITIMER_PROF, 0)
            out.write(outcome.row().replace("\n", " ") + "\n")
            out.flush()


def record(table: Path) -> None:
    """Enter the seeds of a table that have no verdict, and remove those that have one now."""
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=UNJUDGED.parent, text=True,
                            capture_output=True, check=True).stdout.strip()  # fmt: skip
    kept = {int(row[0]): row for row in _rows(UNJUDGED)}
    for seed, kind, about, _ in _rows(table):
        kept.pop(int(seed), None)
        if kind in WITHOUT_VERDICT:
            kept[int(seed)] = [seed, kind, about, commit]
    lines = ["\t".join(kept[seed]) + "\n" for seed in sorted(kept)]
    UNJUDGED.write_text("".join(lines), encoding="utf-8")


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
