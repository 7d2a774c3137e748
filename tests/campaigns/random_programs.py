"""Programs drawn at random (`../generated`): by their equations, every twentieth by the reference.

`../generated/unjudged.tsv` keeps the numbers without a verdict, and the commit of their outcome.
"""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from functools import cache
from pathlib import Path
from unittest.mock import patch

GENERATED = Path(__file__).parents[1] / "generated"
sys.path.insert(0, str(GENERATED))

from judging import Verdict  # noqa: E402
from program_check import Outcome, check_equations, check_seed, program_of  # noqa: E402
from program_text import write  # noqa: E402
from workers import Portion  # noqa: E402

from bgc.building import ahead, preview, recall  # noqa: E402

CPU_SECONDS = 10.0
PORTION = 20
TABLE = GENERATED / "unjudged.tsv"
UNJUST = "unjust"  # refused, although the reference has a solution
CODE = re.compile(r"BG\d{3}")


@contextmanager
def machine_asked_once() -> Iterator[None]:
    """Keep what no program changes: the state of bgc's own files, and the compilers found."""
    answers = ((recall, "_compiler_identity"), (ahead, "find_toolchain"),
               (preview, "_quick_compiler"))  # fmt: skip
    with ExitStack() as kept:
        for module, name in answers:
            kept.enter_context(patch.object(module, name, cache(getattr(module, name))))
        yield


def text_of(seed: int, number: int) -> tuple[str, bytes]:
    """The program of a number, which the seed of the campaign leaves as it is."""
    del seed
    return f"program {number}", write(program_of(number)).encode()


def judge(seed: int, number: int, folder: Path) -> list[Verdict]:
    """The outcome of a program, as `program_check` explains them."""
    del seed, folder
    found = outcome_of(number)
    kind = UNJUST if found.kind == "refused" else found.kind
    return [Verdict(kind, tuple(CODE.findall(found.about)), found.about)]


def outcome_of(number: int) -> Outcome:
    """By equations, one of four with a variant; every twentieth by the reference and with two."""
    if number % 20 == 0:
        return check_seed(number, variants=2)
    return check_equations(number, variants=int(number % 4 == 1))


def unjudged() -> list[int]:
    """The numbers that have no verdict."""
    return [int(row[0]) for row in _rows()]


def record(portions: Iterable[Portion]) -> None:
    """Enter the numbers without a verdict, or that differ, and remove those that have one now."""
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=GENERATED, text=True,
                            capture_output=True, check=True).stdout.strip()  # fmt: skip
    kept = {int(row[0]): row for row in _rows()}
    for portion in portions:
        for number in range(portion.first, portion.first + portion.size):
            kept.pop(number, None)
        for number, outcome, about in portion.faults:
            about = "" if outcome == "hang" else " ".join(about.split())[:120]
            kept[number] = [str(number), outcome, about, commit]
    lines = ["\t".join(kept[number]) + "\n" for number in sorted(kept)]
    TABLE.write_text("".join(lines), encoding="utf-8")


def _rows() -> list[list[str]]:
    return [line.split("\t") for line in TABLE.read_text(encoding="utf-8").splitlines()]
