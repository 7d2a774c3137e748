"""Single faults of bgc and the tests that find them: a yardstick for changes of the tests.

    python tests/mutation/freeze.py --work DIR draw     # choose breaks, write breaks.tsv
    python tests/mutation/freeze.py --work DIR reach    # which quick tests run which blocks
    python tests/mutation/freeze.py --work DIR try      # run tests against those not tried yet
    python tests/mutation/freeze.py --work DIR again [FILE ..]   # each kill once more

`again` works on the present tree and tests: a break is found by its function and text, wherever
these are now. FILEs leave out kills of other files of tests. It prints what is lost.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import random
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path

from blocks import spans
from breaks import Break, breaks_of_c, breaks_of_python
from forked import Outcome, load_packages, run

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
TABLE = HERE / "breaks.tsv"
FOLDERS = ("compiler", "grammar", "runtime", "library")
ROOMS = {
    "language": ("grammar", "compiler/language"),
    "values": ("compiler/values", "compiler/algebra"),
    "elaboration": ("compiler/elaboration", "compiler/resolution"),
    "diagnostics": ("compiler/diagnostics",),
    "causality": ("compiler/causality",),
    "equations": ("compiler/equations",),
    "slicing": ("compiler/slicing", "compiler/passivity", "compiler/ir"),
    "emission": ("compiler/emission", "compiler/building"),
    "printing": ("compiler/printing", "compiler/reference", "compiler/symbolic",
                 "compiler/linearising", "runtime/documents"),
    "editing": ("compiler/editing", "runtime/editor"),
    "command line": ("runtime/cli",),
    "FMI": ("runtime/fmi",),
    "web": ("runtime/web",),
    "view": ("runtime/view",),
    "importing": ("runtime/importing",),
    "studies": ("runtime/studies", "runtime/trade", "runtime/stress", "runtime/activity",
                "runtime/measuring", "runtime/linear", "runtime/linearising"),
    "results": ("runtime/results",),
    "running": ("runtime/running", "runtime/realtime", "runtime/"),
}  # fmt: skip
"""Rooms and where they are; of breaks in C, all in `C`."""
_OTHERS = 5
QUICK = ("tests/test_golden.py", "tests/test_wrong_models.py", "tests/generated/test_generated.py")
_TEXTS = ("diagnostics", "command line", "printing")  # rooms whose strings are broken, too


@dataclass(frozen=True, slots=True)
class Row:
    """A break and its outcome; `nth` counts equal breaks of the function."""

    room: str
    file: str
    function: str
    nth: int
    before: str
    after: str
    outcome: str = ""  # killed, survived, timeout, unreached, gone (no such place)
    test: str = ""
    seconds: str = ""
    others: str = ""  # files of tests that run the broken line, too, the nearest first


def read_table() -> list[Row]:
    with TABLE.open(encoding="utf-8", newline="") as file:
        rows = csv.DictReader(file, dialect="excel-tab", quoting=csv.QUOTE_NONE, quotechar=None)
        return [Row(**{**row, "nth": int(row["nth"])}) for row in rows]


def write_table(rows: Iterable[Row]) -> None:
    names = [field.name for field in fields(Row)]
    lines = ["\t".join(str(v) for v in asdict(row).values()) for row in rows]
    TABLE.write_text("\n".join(["\t".join(names), *lines, ""]), encoding="utf-8")


# --- breaks ------------------------------------------------------------------------------------


def breaks_of(path: Path, text: str, room: str) -> list[tuple[Break, int]]:
    """The breaks of a file that the table can hold, each with its number among equal ones."""
    in_python = path.suffix == ".py"  # else C, in headers too
    found = breaks_of_python(text, room in _TEXTS) if in_python else breaks_of_c(text)
    seen = Counter[tuple[str, str, str]]()
    numbered = []
    for each in found:
        before, after = each.before.strip(), each.after.strip()
        key = (each.function, before, after)
        numbered.append((each, seen[key]))
        seen[key] += 1
    return [
        (each, nth)
        for each, nth in numbered
        if not {"\t", "\n"} & {*each.before.strip(), *each.after.strip()} and len(each.before) < 400
    ]


def draw(root: Path, per_room: int, c: int, seed: int) -> list[Row]:
    """Breaks by room, each place of a room as likely as another; those of C as listed before."""
    rows = []
    taken: set[Path] = set()
    for room, folders in ROOMS.items():
        dice = random.Random(f"{seed} {room}")
        paths = sorted({p for f in folders for p in (root / f).rglob("*.py")} - taken)
        taken.update(paths)
        each = []
        for path in paths:
            name = path.relative_to(root).as_posix()
            for b, nth in breaks_of(path, path.read_text(encoding="utf-8"), room):
                each.append(Row(room, name, b.function, nth, b.before.strip(), b.after.strip()))
        rows += dice.sample(each, per_room)
    dice = random.Random(f"{seed} C")
    logged = {}
    for line in (HERE / "log.jsonl").read_text(encoding="utf-8").splitlines():
        row = json.loads(line)
        logged[row["path"], row["name"], row["nth"]] = row
    killed = [row for row in logged.values() if row["outcome"] == "killed" and row["test"]]
    for row in dice.sample([r for r in killed if r["path"].endswith(".c")], c):
        before, _, after = row["name"].partition("  ->  ")
        rows.append(Row("C", row["path"], "", row["nth"], before, after, test=row["test"]))
    dice.shuffle(rows)
    return rows


def place(root: Path, row: Row) -> tuple[Path, Break] | None:
    """Where a break of the table is in a tree: in its file, else in any with such a function."""
    path = root / row.file
    paths = [path] if path.exists() else []
    if path.suffix == ".py":
        name = row.function.rpartition(".")[2]
        for folder in FOLDERS[:3]:
            others = sorted((root / folder).rglob("*.py"))
            paths += [p for p in others if p != path and f" {name}" in p.read_text("utf-8")]
    elif not paths:
        paths = sorted((root / "runtime" / "c").rglob("*.[ch]"))
    for each in paths:
        for found, nth in breaks_of(each, each.read_text(encoding="utf-8"), row.room):
            same = found.before.strip() == row.before and found.after.strip() == row.after
            if same and nth == row.nth and found.function == row.function:
                return each, found
    return None


# --- tests -------------------------------------------------------------------------------------


class Reach:
    """Which files of tests run which blocks, from the files of `reach.py`."""

    def __init__(self, work: Path) -> None:
        blocks = work / "blocks.json"
        self.first: dict[str, int] = json.loads(blocks.read_text()) if blocks.exists() else {}
        self.seconds: dict[str, float] = {}
        self.failed: dict[str, list[str]] = {}
        self.hits: dict[str, set[int]] = {}
        for store in sorted(work.glob("reach*.jsonl")):
            for line in store.read_text("utf-8").splitlines():
                row = json.loads(line)
                self.seconds[row["file"]] = row["seconds"]
                self.failed[row["file"]] = row["failed"]
                self.hits[row["file"]] = set(row["hits"])

    def files(self, name: str, text: str, line: int, function: str) -> list[str]:
        """Files that run a line, those first that run most of its module in the least time."""
        first, where = self.first[name], spans(text)
        numbers = set(range(first, first + len(where)))
        around = [(last - begin, first + k) for k, (begin, last) in enumerate(where)
                  if begin <= line <= last]  # fmt: skip
        wanted = {min(around)[1]} if around else numbers
        worth = {}
        for file, hits in self.hits.items():
            if wanted & hits:
                share = len(numbers & hits) / len(numbers)
                own = Path(file).stem.removeprefix("test_") in name
                worth[file] = (share + own) / (self.seconds[file] + 2.0)
        return sorted(worth, key=lambda file: -worth[file])


def name_in_package(path: str) -> str:
    return path.removeprefix("compiler/")


class Bench:
    """A copy of the tree that a process changes, and the tests that it runs."""

    def __init__(self, work: Path, number: int, reach: Reach, limit: float) -> None:
        self.root, self.work = work / f"tree{number}", work / f"w{number}"
        self.work.mkdir(exist_ok=True)
        self.reach, self.limit = reach, limit
        self.clock = time.time() - 1e6

    def write(self, path: Path, text: str) -> None:
        path.write_text(text, encoding="utf-8")
        self.clock += 10.0  # bytecode is found by seconds and size
        os.utime(path, (self.clock, self.clock))

    def try_row(self, row: Row, known: Sequence[str]) -> Row:
        """Run the tests of a break, `known` ones first, until one fails."""
        found = place(self.root, row)
        if found is None:
            return replace(row, outcome="gone")
        path, each = found
        text = path.read_text(encoding="utf-8")
        files = row.others.split()
        if self.reach.hits and path.suffix == ".py" and not files:
            name = name_in_package(path.relative_to(self.root).as_posix())
            files = self.reach.files(name, text, each.line, each.function)
            if not files:
                return replace(row, outcome="unreached")
        os.environ["FREEZE_LEVEL"] = "" if path.suffix == ".py" else "-O1"
        begun = time.monotonic()
        self.write(path, each.text())
        try:
            outcome = self.run(known, files)
        finally:
            self.write(path, text)
        seconds = f"{time.monotonic() - begun:.0f}"
        test = outcome.failed[0] if outcome.failed else ""
        others = " ".join(files[:_OTHERS])
        return replace(row, outcome=outcome.kind, test=test, seconds=seconds, others=others)

    def run(self, known: Sequence[str], files: Sequence[str]) -> Outcome:
        """Run single tests, then files in groups of growing cost, until one fails."""
        known = [test for test in known if (self.root / test.split("::")[0]).exists()]
        groups, cost = ([known] if known else []), 0.0
        size = 5.0
        group: list[str] = []
        used = 0.0
        for file in files:
            seconds = self.reach.seconds.get(file, 5.0)
            cost += seconds
            if cost > self.limit and (groups or group):
                break
            group.append(file)
            used += seconds
            if used > size:
                groups.append(group)
                group, used, size = [], 0.0, 3.0 * size
        groups += [group] if group else []
        for names in groups:
            failed = [t for f in names for t in self.reach.failed.get(f.split("::")[0], ())]
            expected = sum(self.reach.seconds.get(f.split("::")[0], 10.0) for f in names)
            outcome = run(self.work, names, failed, 20.0 + 6.0 * expected)
            if outcome.kind in ("killed", "timeout"):
                return outcome
        return Outcome("survived", (), 0.0)


def work_on(work: Path, number: int, share: Sequence[tuple[int, Row]], limit: float,
            known: dict[int, list[str]]) -> None:  # fmt: skip
    """Try breaks one after the other; the results go to a file of the process."""
    load_packages()
    reach = Reach(work)
    bench = Bench(work, number, reach, limit)
    with (work / f"outcomes{number}.jsonl").open("a", encoding="utf-8") as out:
        for place_in_table, row in share:
            done = bench.try_row(row, known.get(place_in_table, ()))
            out.write(json.dumps([place_in_table, asdict(done)]) + "\n")
            out.flush()
            print(done.outcome, done.file, done.function, done.before, "->", done.after, done.test,
                  done.seconds, flush=True)  # fmt: skip


def prepare(work: Path, number: int) -> dict[str, str]:
    """Copy the present tree to `work`; return the environment in which tests use the copy."""
    tree, site = work / f"tree{number}", work / f"site{number}" / "bgc"
    for folder in (tree, site):
        shutil.rmtree(folder, ignore_errors=True)
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, check=True)
    for name in listed.stdout.decode().split("\0")[:-1]:
        if (ROOT / name).exists():
            (tree / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, tree / name)
    page = "runtime/view/static"
    if (ROOT / page).exists():
        shutil.copytree(ROOT / page, tree / page)
    site.mkdir(parents=True)
    for path in (tree / "compiler").iterdir():
        (site / path.name).symlink_to(path)
    for name in FOLDERS[1:]:
        (site / name).symlink_to(tree / name)
    programs = work / "bin"
    (work / "objects").mkdir(exist_ok=True)
    if not programs.exists():
        programs.mkdir()
        for name in ("cc", "gcc"):
            shutil.copy2(HERE / "cc.py", programs / name)
    return {
        **os.environ,
        "PATH": f"{programs}:{os.environ['PATH']}",
        "PYTHONPATH": f"{site.parent}:{HERE}",
        "PYTHONPYCACHEPREFIX": str(work / "bytecode"),
        "XDG_CACHE_HOME": str(work / "cache"),
        "OPENBLAS_NUM_THREADS": "1",  # a process with threads cannot be forked
        "FREEZE_CC": shutil.which("gcc") or "cc",
        "FREEZE_OBJECTS": str(work / "objects"),
    }


def measure(work: Path, workers: int, words: Sequence[str]) -> None:
    """Run the quick tests once, files in turn to each process; write which blocks they run."""
    processes = []
    files = words or [f for f in QUICK if (ROOT / f).exists()] + sorted(
        path.relative_to(ROOT).as_posix() for path in (ROOT / "tests" / "unit").glob("test_*.py")
    )
    for k in range(workers):
        environment = prepare(work, k)
        first: dict[str, int] = {}
        count = 0
        for name in sorted(path for f in FOLDERS for path in (work / f"tree{k}" / f).rglob("*.py")):
            inner = name_in_package(name.relative_to(work / f"tree{k}").as_posix())
            first[inner] = count
            count += len(spans(name.read_text(encoding="utf-8")))
        (work / "blocks.json").write_text(json.dumps(first), encoding="utf-8")
        (work / f"hits{k}").write_bytes(bytes(count))
        environment["PYTHONPATH"] += f":{HERE / 'hits'}"
        environment |= {"BGC_BLOCKS": str(work / "blocks.json"), "BGC_HITS": str(work / f"hits{k}"),
                        "REACH": str(work / f"reach{k}.jsonl")}  # fmt: skip
        command = [sys.executable, "-m", "pytest", "-s", "-p", "no:xdist", "-p", "reach", "-m",
                   "not slow", f"--basetemp={work / f'tmp{k}'}", *files[k::workers]]  # fmt: skip
        processes.append(subprocess.Popen(command, cwd=work / f"tree{k}", env=environment))
    for process in processes:
        process.wait()


def share_out(work: Path, numbers: Sequence[int], workers: int,
              arguments: Sequence[str]) -> list[tuple[int, Row]]:  # fmt: skip
    """Try the rows of the table with these numbers in several processes; return the outcomes."""
    started = []
    for k in range(workers):
        command = [sys.executable, __file__, "--work", str(work), *arguments, "--share", str(k),
                   "--rows", *map(str, numbers[k::workers])]  # fmt: skip
        environment = prepare(work, k)
        started.append(subprocess.Popen(command, cwd=work / f"tree{k}", env=environment))
    for process in started:
        process.wait()
    found = []
    for k in range(workers):
        outcomes = work / f"outcomes{k}.jsonl"
        for line in outcomes.read_text(encoding="utf-8").splitlines():
            number, row = json.loads(line)
            found.append((number, Row(**row)))
        outcomes.unlink()
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description="Freeze the faults that the tests find.")
    parser.add_argument("command", choices=("draw", "reach", "try", "again"))
    parser.add_argument("files", nargs="*", help="again: files of tests whose kills are repeated")
    parser.add_argument("--work", type=Path, required=True)
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--seed", type=int, default=26)
    parser.add_argument("--limit", type=float, default=12.0, help="s of tests against a break")
    parser.add_argument("--share", type=int, help=argparse.SUPPRESS)
    parser.add_argument("--rows", type=int, nargs="*", help=argparse.SUPPRESS)
    given = parser.parse_args()
    work = given.work.absolute()
    if given.command == "draw":
        write_table(draw(ROOT, 14, 60, given.seed))
        return
    if given.command == "reach":
        measure(work, given.workers, given.files)
        return
    rows = read_table()
    again = given.command == "again"
    if given.share is not None:
        known = {k: [rows[k].test] for k in given.rows if rows[k].test}
        work_on(work, given.share, [(k, rows[k]) for k in given.rows], given.limit, known)
        return
    wanted = [k for k, row in enumerate(rows) if not row.outcome and not again]
    if again:
        wanted = [k for k, row in enumerate(rows) if row.outcome == "killed"
                  and (not given.files or row.test.split("::")[0] in given.files)]  # fmt: skip
    for k, row in share_out(work, wanted, given.workers, [given.command]):
        if again and row.outcome != "killed":
            print("lost:", row)
        rows[k] = row if not again else rows[k]
    if not again:
        write_table(rows)
    print(Counter(row.outcome for row in rows))


if __name__ == "__main__":
    main()
