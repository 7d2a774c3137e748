"""A plugin of pytest that collects tests once and runs them against one break at a time."""

from __future__ import annotations

import hashlib
import json
import os
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import pytest
from breaks import Break, breaks_of_c, breaks_of_python
from children import Outcome, run_items
from executed import Trace, read_gcov
from objects import NotC, Objects
from swap import NotSwapped, swap
from targets import C_FOLDERS, PYTHON_FOLDER

_FIRST = 4  # tests with the most kills, which are run first
_LONGEST = 2.5  # s; tests that take longer are not run


def candidates(
    root: Path, words: list[str], seed: int, folders: Sequence[str]
) -> dict[str, list[tuple[int, Break]]]:
    """The breaks of each source in an order that edits elsewhere do not change.

    A break is numbered among those of its file that have the same name. Of `folders`, the C files
    are taken, and of PYTHON_FOLDER all modules.
    """
    sources = [path for folder in folders for path in sorted((root / folder).glob("*.c"))]
    if PYTHON_FOLDER in folders:
        sources += sorted((root / PYTHON_FOLDER).rglob("*.py"))
    found: dict[str, list[tuple[int, Break]]] = {}
    for source in sources:
        path = source.relative_to(root).as_posix()
        if source.name == "__init__.py" or not (not words or any(word in path for word in words)):
            continue
        text = source.read_text(encoding="utf-8")
        seen = Counter[str]()
        order = []
        for each in breaks_of_c(text) if source.suffix == ".c" else breaks_of_python(text):
            nth, seen[each.name] = seen[each.name], seen[each.name] + 1
            digest = hashlib.sha1(f"{seed} {path} {each.name} {nth}".encode()).hexdigest()
            order.append((digest, nth, each))
        found[path] = [(nth, each) for _, nth, each in sorted(order, key=lambda row: row[0])]
    return found


def in_rounds(breaks: dict[str, list[tuple[int, Break]]], per_file: int) -> Iterator[Any]:
    """Breaks of all files in turn."""
    for k in range(per_file):
        for path, each in breaks.items():
            if k < len(each):
                yield path, *each[k]


class Campaign:
    """Measures the tests, then tries breaks until the time is over."""

    def __init__(self, work: Path) -> None:
        given = json.loads((work / "given.json").read_text())
        self.work, self.root = work, work / "tree"
        self.given = given
        self.package = work / "site" / "bgc"
        self.measured: dict[str, Any] = {}
        self.items: dict[str, list[pytest.Item]] = defaultdict(list)
        self.sound: dict[str, bool] = {}
        self.only_python = bool(given["words"]) and all("equations" in w for w in given["words"])
        self.log = work / "log.jsonl"
        self.rows = read_rows(self.log)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtestloop(self, session: pytest.Session) -> bool:
        for item in session.items:
            self.items[item.nodeid.split("::")[0]].append(item)
        plugins = session.config.pluginmanager.get_plugins()
        conftest = next(
            p for p in plugins if str(getattr(p, "__file__", "")).endswith("unit/conftest.py")
        )
        self.objects = Objects(self.work, self.package / "runtime" / "c", conftest.MODELS)
        self.objects.install(conftest)
        os.environ["XDG_CACHE_HOME"] = str(self.work / "cache")
        self.objects.compile_all()
        self.measure()
        self.try_breaks()
        return True

    # --- what tests execute, and how long they take ---------------------------------------------

    def measure(self) -> None:
        store = self.work / "measured.json"
        if store.exists():
            self.measured = json.loads(store.read_text())
        for file, items in self.items.items():
            key = hashlib.sha1((self.root / file).read_bytes()).hexdigest()
            if self.measured.get(file, {}).get("key") != key or (
                self.measured[file]["only_python"] and not self.only_python
            ):
                self.measured[file] = {"key": key, **self.measure_file(items)}
                store.write_text(json.dumps(self.measured))
                row = self.measured[file]
                print(f"{file}: {row['seconds']:.1f} s, fail: {row['failed']}", flush=True)

    def measure_file(self, items: list[pytest.Item]) -> dict[str, Any]:
        objects, trace = self.objects, Trace(str(self.package / "equations"))
        lines = self.work / "lines.json"
        lines.unlink(missing_ok=True)
        read_gcov(self.work / "covered")

        def begin() -> None:
            objects.changed, objects.coverage, objects.light = None, not self.only_python, True
            trace.start()

        def end() -> None:
            sys.settrace(None)
            lines.write_text(json.dumps({k: sorted(v) for k, v in trace.lines.items()}))

        objects.clear()
        first = run_items(items, {}, self.work / "output.txt", begin, end, stop=False)
        ran, known = read_gcov(self.work / "covered")
        objects.clear()
        second = first
        if not self.only_python:
            second = run_items(items, {}, self.work / "output.txt", nothing, stop=False)
        python = json.loads(lines.read_text()) if lines.exists() else {}
        executed = {Path(k).relative_to(self.package).as_posix(): v for k, v in python.items()}
        executed = {f"compiler/{k}": v for k, v in executed.items()}
        executed |= {f"runtime/c/{k}": sorted(v) for k, v in ran.items()}
        return {
            "only_python": self.only_python,
            "seconds": second.seconds,
            "light": first.seconds,
            "tests": second.passed,
            "light_tests": first.passed,
            "failed": sorted({*first.failed, *second.failed}),
            "lines": executed,
            "known": {f"runtime/c/{k}": sorted(v) for k, v in known.items()},
        }

    # --- breaks ---------------------------------------------------------------------------------

    def try_breaks(self) -> None:
        given = self.given
        known: dict[str, set[int]] = defaultdict(set)
        for row in self.measured.values():
            for path, lines in row["known"].items():
                known[path].update(lines)
        last = {key_of(row): row for row in self.rows}
        end = time.monotonic() + 60.0 * given["minutes"]
        breaks = candidates(self.root, given["words"], given["seed"], (*C_FOLDERS, PYTHON_FOLDER))
        per_file = max(map(len, breaks.values())) if given["again"] else given["per_file"]
        for path, nth, each in in_rounds(breaks, per_file):
            done = last.get((path, each.name, nth))
            survived = done is not None and done["outcome"] == "survived"
            survived = survived and f"{path}: {each.name}" not in given["explained"]
            if not (survived if given["again"] else done is None):
                continue
            if time.monotonic() > end:
                return
            row = self.try_break(path, nth, each, known[path])
            self.rows.append(row)
            with self.log.open("a", encoding="utf-8") as file:
                file.write(json.dumps(row) + "\n")
            print(f"{row['outcome']:9} {path}:{each.line}", each.name, row["test"],
                  f"{row['seconds']} s", flush=True)  # fmt: skip

    def try_break(self, path: str, nth: int, each: Break, known: set[int]) -> dict[str, Any]:
        begun, used = time.monotonic(), sum(os.times()[:4])
        files, left_out = self.files_for(path, each.line, known)
        items, limits = self.items_of(path, files)
        outcome = self.outcome_of(path, each, items, limits)
        kind, test = outcome.kind, outcome.test
        if kind in ("killed", "timeout") and test and not self.is_sound(test):
            kind = "unsound"
        if kind == "killed" and not test:
            kind = "invalid"
        return {
            "path": path, "line": each.line, "name": each.name, "nth": nth, "outcome": kind,
            "test": test, "seconds": round(sum(os.times()[:4]) - used, 1),
            "clock": round(time.monotonic() - begun, 1), "files": len(files),
            "left_out": left_out, "commit": self.given["commit"],
        }  # fmt: skip

    def outcome_of(
        self, path: str, each: Break, items: list[pytest.Item], limits: dict[str, float]
    ) -> Outcome:
        text = each.text()
        before: Callable[[], None] = nothing
        if path.endswith(".c"):
            try:
                if not self.objects.break_file(path.removeprefix("runtime/c/"), text):
                    return Outcome("same code", "", 0.0, {}, ())
            except NotC:
                return Outcome("invalid", "", 0.0, {}, ())
        else:
            name = "bgc." + path.removeprefix("compiler/").removesuffix(".py").replace("/", ".")
            before = partial(self.change_python, name, text)
        try:
            return run_items(items, limits, self.work / "output.txt", before)
        finally:
            self.objects.changed = None

    def change_python(self, name: str, text: str) -> None:
        self.objects.light = True
        try:
            swap(name, text)
        except NotSwapped:
            raise
        except Exception as problem:  # the module cannot be loaded: the first test would fail
            raise NotSwapped(repr(problem)) from problem

    def files_for(self, path: str, line: int, known: set[int]) -> tuple[list[str], list[str]]:
        """Test files that execute a line, in the order of their worth, and those left out."""
        kills = Counter(row["test"].split("::")[0] for row in self.rows if row["path"] == path)
        worth: dict[str, float] = {}
        tests = "tests" if path.endswith(".c") else "light_tests"
        cost = {
            file: sum(took for took in self.measured[file][tests].values() if took < _LONGEST)
            for file in self.items
        }
        for file in self.items:
            row = self.measured[file]
            lines = row["lines"].get(path, ())
            unknown = path.endswith(".c") and line not in known and (lines or not known)
            if line in lines or unknown:
                worth[file] = (kills[file] + 0.3) / (cost[file] + 0.2)
        order = sorted(worth, key=lambda file: -worth[file])
        left, chosen, left_out = self.given["cost"], [], []
        for file in order:
            if cost[file] <= left or not chosen:
                chosen.append(file)
                left -= cost[file]
            else:
                left_out.append(file)
        return chosen, left_out

    def items_of(self, path: str, files: list[str]) -> tuple[list[pytest.Item], dict[str, float]]:
        """Tests, those with most kills of the source first, and their limits."""
        killers = Counter(
            row["test"] for row in self.rows if row["path"] == path and row["test"]
        ).most_common(_FIRST)
        first = [test for test, _ in killers]
        items, limits = [], {}
        seconds = "tests" if path.endswith(".c") else "light_tests"
        for file in files:
            row = self.measured[file]
            for item in self.items[file]:
                took = row[seconds].get(item.nodeid, _LONGEST)
                if took < _LONGEST and item.nodeid not in row["failed"]:
                    items.append(item)
                    limits[item.nodeid] = 1.0 + 10.0 * took
        rank = {test: k for k, test in enumerate(first)}
        return sorted(items, key=lambda item: rank.get(item.nodeid, len(rank))), limits

    def is_sound(self, test: str) -> bool:
        """True where the test passes by itself without a break."""
        if test not in self.sound:
            item = [i for i in self.items[test.split("::")[0]] if i.nodeid == test]
            self.objects.changed = None
            result = run_items(item, {test: 10.0}, self.work / "sound.txt", nothing)
            self.sound[test] = result.kind == "survived"
        return self.sound[test]


def nothing() -> None:
    """Run the tests without a break."""


def key_of(row: dict[str, Any]) -> tuple[str, str, int]:
    return row["path"], row["name"], row["nth"]


def read_rows(log: Path) -> list[dict[str, Any]]:
    return [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []


def pytest_configure(config: pytest.Config) -> None:
    config.pluginmanager.register(Campaign(Path(os.environ["MUTATION_WORK"])))
