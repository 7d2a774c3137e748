"""Mutation testing of the C runtime and of `compiler/equations`.

    python tests/mutation/mutants.py --work DIR [--seed N] [--minutes M] [WORD ..]

One deliberate break at a time (`breaks.py`), in random order by the seed, goes into a copy of the
repository in DIR, and the tests that `targets.py` names for its file run until one fails. WORDs
choose files by parts of their paths. DIR/log.jsonl keeps the outcomes: the same command goes on
where it ended. `--survivors` prints those that `equivalent.txt` does not explain, `--table` the
counts.
"""

from __future__ import annotations

import argparse
import json
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from pathlib import Path

from breaks import Break, breaks_of_c, breaks_of_python
from targets import PYTHON, C, test_file

ROOT = Path(__file__).parents[2]
LONGEST = 600  # s of the tests of one break

# The C compiler at -O1 without warnings as errors; objects of unchanged files are kept.
CC = """#!/bin/bash
arguments=() source= target= last=
for a in "$@"; do
  [ "$last" = -o ] && target=$a
  last=$a
  case $a in -O2|-O3) a=-O1;; -Werror) continue;; *.c) source=$a;; esac
  arguments+=("$a")
done
case " $* " in *" -c "*) ;; *) exec gcc "${arguments[@]}";; esac
key=$(cat "$source" "${source%/*}"/*.h HEADERS/*.h 2>/dev/null | cat - <(
  for a in "${arguments[@]}"; do [ "$a" = "$target" ] || echo "$a"; done) | sha1sum | cut -c1-40)
kept=OBJECTS/$key.o
[ -f $kept ] || { gcc "${arguments[@]}" || exit; cp "$target" $kept.$$; mv $kept.$$ $kept; }
cp $kept "$target"
"""


def prepare(work: Path) -> dict[str, str]:
    """Copy the repository to `work`; return the environment that uses the copy.

    The package is laid out as it is installed; breaks go there.
    """
    tree, package = work / "tree", work / "site" / "bgc"
    no_bytecode = shutil.ignore_patterns("__pycache__")
    for folder in (tree, package):
        if folder.exists():
            shutil.rmtree(folder)
    shutil.copytree(ROOT / "compiler", package, ignore=no_bytecode)
    for name in ("grammar", "library", "runtime"):
        shutil.copytree(ROOT / name, package / name, ignore=no_bytecode)
    for name in ("compiler", "grammar", "library", "runtime", "tests"):
        shutil.copytree(ROOT / name, tree / name, ignore=no_bytecode)
    for name in ("pyproject.toml", "README.md"):
        shutil.copy(ROOT / name, tree / name)
    for folder in (work / "bin", work / "objects"):
        folder.mkdir(exist_ok=True)
    wrapper = work / "bin" / "cc"
    text = CC.replace("HEADERS", str(package / "runtime" / "c"))
    wrapper.write_text(text.replace("OBJECTS", str(work / "objects")))
    wrapper.chmod(0o755)
    return {
        **os.environ,
        "PYTHONPATH": str(work / "site"),
        "PATH": f"{work / 'bin'}:{os.environ['PATH']}",
        "XDG_CACHE_HOME": str(work / "cache"),
        "PYTHONDONTWRITEBYTECODE": "1",
    }


def tests_of(path: str) -> tuple[str, ...]:
    """The test files for a source file."""
    source = Path(path)
    if source.suffix == ".c":
        return tuple(map(test_file, C[source.stem]))
    folder = source.parent.name
    return tuple(map(test_file, PYTHON[folder if folder != "equations" else ""]))


def run_tests(files: tuple[str, ...], work: Path, environment: dict[str, str]) -> tuple[str, str]:
    """The outcome `survived`, `killed` or `timeout`, and the test that failed.

    A test that fails without a break as well makes the outcome `unsound` later.
    """
    command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider", "--tb=line",
               f"--basetemp={work / 'tmp'}", *files]  # fmt: skip
    with subprocess.Popen(command, cwd=work / "tree", env=environment, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          start_new_session=True) as tests:  # fmt: skip
        try:
            output, _ = tests.communicate(timeout=LONGEST)
        except subprocess.TimeoutExpired:
            os.killpg(tests.pid, signal.SIGKILL)
            return "timeout", ""
    failed = re.findall(r"^(?:FAILED|ERROR) (.*?)(?: - .*)?$", output, re.MULTILINE)
    return ("survived", "") if tests.returncode == 0 else ("killed", (failed or files)[0])


def candidates(words: list[str]) -> list[tuple[str, Break]]:
    """All breaks of all files that have tests."""
    found = []
    sources = [ROOT / "runtime" / "c" / f"{name}.c" for name in C]
    sources += sorted((ROOT / "compiler" / "equations").rglob("*.py"))
    for source in sources:
        path = source.relative_to(ROOT).as_posix()
        if source.name != "__init__.py" and (not words or any(word in path for word in words)):
            text = source.read_text(encoding="utf-8")
            breaks = breaks_of_c(text) if source.suffix == ".c" else breaks_of_python(text)
            found += [(path, each) for each in breaks]
    return found


def explained() -> dict[str, str]:
    """Breaks that no test can find, with the reason, from `equivalent.txt`: three lines each."""
    lines = (Path(__file__).parent / "equivalent.txt").read_text(encoding="utf-8").splitlines()
    blocks = [line for line in lines if line and not line.startswith("#")]
    return {f"{where}: {what}": why for where, what, why in zip(*[iter(blocks)] * 3, strict=True)}


def campaign(work: Path, words: list[str], seed: int, minutes: float) -> None:
    """Try breaks until the time is over."""
    environment = prepare(work)
    log = work / "log.jsonl"
    done = {(row["path"], row["name"]) for row in _rows(log)}
    order = [pair for pair in candidates(words) if (pair[0], pair[1].name) not in done]
    random.Random(seed).shuffle(order)
    end = time.monotonic() + 60.0 * minutes
    sound: dict[str, bool] = {}  # tests that pass without a break
    for path, each in order:
        if time.monotonic() > end:
            return
        files = tests_of(path)
        target = work / "site" / "bgc" / path.removeprefix("compiler/")
        whole = target.read_text(encoding="utf-8")
        begun = time.monotonic()
        try:
            target.write_text(each.text(), encoding="utf-8")
            outcome, test = run_tests(files, work, environment)
        finally:
            target.write_text(whole, encoding="utf-8")
        if outcome == "killed" and test not in sound:
            sound[test] = run_tests((test,), work, environment)[0] == "survived"
        if outcome == "killed" and not sound[test]:
            outcome = "unsound"
        row = {"path": path, "line": each.line, "name": each.name, "outcome": outcome,
               "test": test, "seconds": round(time.monotonic() - begun)}  # fmt: skip
        with log.open("a", encoding="utf-8") as file:
            file.write(json.dumps(row) + "\n")
        print(outcome, f"{path}:{each.line}", each.name, test, f"{row['seconds']} s", flush=True)


def _rows(log: Path) -> list[dict[str, str]]:
    return [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []


def report(work: Path, table: bool) -> None:
    """Print the survivors without an explanation, or counts by file."""
    known, counts = explained(), Counter[tuple[str, str]]()
    for row in _rows(work / "log.jsonl"):
        outcome, key = row["outcome"], f"{row['path']}: {row['name']}"
        if outcome == "survived" and key in known:
            outcome = "equivalent"
        elif outcome == "survived" and not table:
            print(f"{row['path']}:{row['line']}: {row['name']}")
        counts[row["path"], outcome] += 1
    for (path, outcome), count in sorted(counts.items()) if table else ():
        print(f"{path:45} {outcome:10} {count}")
    total = Counter[str]()
    for (_, outcome), count in counts.items():
        total[outcome] += count
    print(dict(total))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("words", nargs="*", metavar="WORD")
    parser.add_argument("--work", type=Path, required=True, help="folder for the copy and the log")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--survivors", action="store_true")
    parser.add_argument("--table", action="store_true")
    given = parser.parse_args()
    work = given.work.absolute()
    work.mkdir(parents=True, exist_ok=True)
    if given.survivors or given.table:
        report(work, given.table)
    else:
        campaign(work, given.words, given.seed, given.minutes)


if __name__ == "__main__":
    main()
