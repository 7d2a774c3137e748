"""Mutation testing of the C runtime and of `compiler/equations`.

    python tests/mutation/mutants.py --work DIR [--seed N] [--minutes M] [WORD ..]

One deliberate break at a time (`breaks.py`) is run against the tests that execute its line, until
one fails. Each file has `--per-file` breaks, drawn by the seed and tried in turn with those of
the other files. WORDs choose files by parts of their paths. DIR/log.jsonl, which begins as a copy
of the one beside this file, keeps the outcomes: the same command goes on where it ended. `--again`
tries survivors that `equivalent.txt` does not explain, and nothing else, `--survivors` prints them,
`--table` the counts by file.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import subprocess
import sys
from collections import Counter, defaultdict
from pathlib import Path
from statistics import median
from typing import Any

from targets import TESTS, test_file

HERE = Path(__file__).parent
ROOT = HERE.parents[1]


def prepare(work: Path) -> dict[str, str]:
    """Copy the repository to `work`; return the environment that uses the copy."""
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
    return {
        **os.environ,
        "PYTHONPATH": f"{work / 'site'}:{HERE}",
        "XDG_CACHE_HOME": str(work / "cache"),
        "OPENBLAS_NUM_THREADS": "1",  # a process with threads cannot be forked
        "MUTATION_WORK": str(work),
    }


def explained() -> dict[str, str]:
    """Breaks that no test can find, with the reason, from `equivalent.txt`: three lines each."""
    lines = (HERE / "equivalent.txt").read_text(encoding="utf-8").splitlines()
    blocks = [line for line in lines if line and not line.startswith("#")]
    return {f"{where}: {what}": why for where, what, why in zip(*[iter(blocks)] * 3, strict=True)}


def report(work: Path, table: bool) -> None:
    """Print the survivors without an explanation, or counts by file of first and last outcomes."""
    known = explained()
    first: dict[Any, str] = {}
    last: dict[Any, dict[str, Any]] = {}
    seconds = []
    for line in (work / "log.jsonl").read_text().splitlines():
        row = json.loads(line)
        key = (row["path"], row["name"], row["nth"])
        first.setdefault(key, row["outcome"])
        if key not in last and row["outcome"] in ("killed", "survived", "timeout"):
            seconds.append(row["seconds"])
        last[key] = row
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    for key, row in last.items():
        outcome = row["outcome"]
        if outcome == "survived" and f"{row['path']}: {row['name']}" in known:
            outcome = "equivalent"
        elif outcome == "survived" and not table:
            print(f"{row['path']}:{row['line']}: {row['name']}  [{row['files']} files"
                  f"{', cut' if row['left_out'] else ''}]")  # fmt: skip
        if outcome == "invalid":
            continue
        group = {"timeout": "killed", "same code": "equivalent"}.get(outcome, outcome)
        now = "killed later" if first[key] == "survived" and group == "killed" else group
        counts[row["path"]][now] += 1
    columns = ("killed", "killed later", "deleted", "equivalent", "survived", "unsound")
    total = Counter[str]()
    if table:
        print("| file | breaks |", " | ".join(columns), "|")
    for path, count in sorted(counts.items()):
        total += count
        if table:
            print(f"| {path} | {count.total()} |", " | ".join(str(count[c]) for c in columns), "|")
    print(f"| all | {total.total()} |", " | ".join(str(total[c]) for c in columns), "|")
    print(
        f"processor time of a break: median {median(seconds):.1f} s, longest {max(seconds):.0f} s"
    )


def begin_parser(text: str, per_file: int) -> argparse.ArgumentParser:
    """A parser of the options that both commands have; the first line of `text` describes it."""
    parser = argparse.ArgumentParser(description=text.splitlines()[0])
    parser.add_argument("words", nargs="*", metavar="WORD")
    parser.add_argument("--work", type=Path, required=True, help="folder for the copy and the log")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--minutes", type=float, default=30.0)
    parser.add_argument("--per-file", type=int, default=per_file)
    return parser


def main() -> None:
    parser = begin_parser(__doc__, per_file=10)
    parser.add_argument("--cost", type=float, default=30.0, help="s of tests against a break")
    parser.add_argument("--again", action="store_true", help="try survivors, and nothing else")
    parser.add_argument("--tests", nargs="*", default=TESTS, help="names as in targets.py")
    parser.add_argument("--survivors", action="store_true")
    parser.add_argument("--table", action="store_true")
    given = parser.parse_args()
    work = given.work.absolute()
    work.mkdir(parents=True, exist_ok=True)
    if given.survivors or given.table:
        report(work, given.table)
        return
    if not (work / "log.jsonl").exists() and (HERE / "log.jsonl").exists():
        shutil.copy(HERE / "log.jsonl", work)
    environment = prepare(work)
    commit = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, text=True,
                            capture_output=True, check=False).stdout.strip()  # fmt: skip
    passed = {key: getattr(given, key) for key in ("words", "seed", "minutes", "per_file", "cost",
                                                   "again")}  # fmt: skip
    passed |= {"commit": commit, "explained": sorted(explained())}
    (work / "given.json").write_text(json.dumps(passed))
    files = [test_file(name) for name in given.tests]
    command = [sys.executable, "-m", "pytest", "-q", "-s", "-p", "trials", "-p",
               "no:cacheprovider", f"--basetemp={work / 'tmp'}", *files]  # fmt: skip
    sys.exit(subprocess.run(command, cwd=work / "tree", env=environment, check=False).returncode)


if __name__ == "__main__":
    main()
