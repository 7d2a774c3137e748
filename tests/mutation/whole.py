"""Breaks of C files whose tests start processes or build files of their own: servo loop and FMUs.

    python tests/mutation/whole.py --work DIR [--seed N] [--minutes M] [--per-file N] [WORD ..]

Each break is written into a copy of the repository, and the tests that `targets.WHOLE` names are
run in a process of their own until one fails, which takes 5 to 60 s. A test that fails without a
break is left out; one that fails with it is run again without (`unsound` where it fails then).
DIR/log.jsonl is that of `mutants.py`, whose `--survivors` and `--table` read it.
"""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from breaks import Break
from mutants import HERE, ROOT, begin_parser, prepare
from targets import WHOLE
from trials import candidates, in_rounds, key_of, read_rows

_FAILED = re.compile(r"^(?:FAILED|ERROR) (\S+)", re.MULTILINE)
_LONGEST = 300.0  # s of the clock for the tests of a break


def run_tests(work: Path, environment: dict[str, str], arguments: list[str]) -> tuple[str, str]:
    """`passed`, `failed` or `timeout`, and the first test that failed."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider",
               f"--basetemp={work / 'tmp'}", *arguments]  # fmt: skip
    try:
        done = subprocess.run(command, cwd=work / "tree", env=environment, timeout=_LONGEST,
                              text=True, capture_output=True, check=False)  # fmt: skip
    except subprocess.TimeoutExpired:
        return "timeout", ""
    failed = _FAILED.findall(done.stdout)
    return ("passed", "") if done.returncode == 0 else ("failed", failed[0] if failed else "")


def sound_arguments(work: Path, environment: dict[str, str], tests: list[str]) -> list[str]:
    """The arguments of pytest that leave out what fails without a break."""
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider",
               f"--basetemp={work / 'tmp'}", *tests]  # fmt: skip
    done = subprocess.run(command, cwd=work / "tree", env=environment, text=True,
                          capture_output=True, check=False)  # fmt: skip
    failed = _FAILED.findall(done.stdout)
    print("left out, for they fail without a break:", *failed, flush=True)
    return [*tests, *(f"--deselect={test}" for test in failed), "-x"]


def try_break(
    work: Path, environment: dict[str, str], path: str, each: Break, arguments: list[str]
) -> tuple[str, str]:
    """The outcome of a break, and the test that found it."""
    place = work / "site" / "bgc" / path
    whole = place.read_text(encoding="utf-8")
    place.write_text(each.text(), encoding="utf-8")
    try:
        outcome, test = run_tests(work, environment, arguments)
    finally:
        place.write_text(whole, encoding="utf-8")
    if outcome == "passed":
        return "survived", ""
    if outcome == "failed" and test and run_tests(work, environment, [test])[0] != "passed":
        return "unsound", test
    return ("timeout" if outcome == "timeout" else "killed"), test


def main() -> None:
    parser = begin_parser(__doc__, per_file=3)
    given = parser.parse_args()
    work = given.work.absolute()
    work.mkdir(parents=True, exist_ok=True)
    log = work / "log.jsonl"
    if not log.exists():
        shutil.copy(HERE / "log.jsonl", log)
    environment = prepare(work)
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, text=True,
                            capture_output=True, check=False).stdout.strip()  # fmt: skip
    end = time.monotonic() + 60.0 * given.minutes
    done = {key_of(row) for row in read_rows(log)}
    for folder, tests in WHOLE.items():
        breaks = candidates(work / "tree", given.words, given.seed, [folder])
        wanted = [each for each in in_rounds(breaks, given.per_file)
                  if (each[0], each[2].name, each[1]) not in done]  # fmt: skip
        arguments = sound_arguments(work, environment, tests) if wanted else []
        for path, nth, each in wanted:
            if time.monotonic() > end:
                return
            begun = time.monotonic()
            outcome, test = try_break(work, environment, path, each, arguments)
            clock = round(time.monotonic() - begun, 1)
            row: dict[str, Any] = {
                "path": path, "line": each.line, "name": each.name, "nth": nth,
                "outcome": outcome, "test": test, "seconds": clock, "clock": clock,
                "files": len(tests), "left_out": [], "commit": commit,
            }  # fmt: skip
            with log.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
            print(f"{outcome:9} {path}:{each.line}", each.name, test, f"{clock} s", flush=True)


if __name__ == "__main__":
    main()
