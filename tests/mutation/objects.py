"""The C runtime as one object a file, and models that are linked again where one file changes.

`install` replaces the functions of bgc and of `tests/unit/conftest.py` that compile. Models are
compiled without optimisation.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any

from bgc import driver
from bgc.building import build, recall
from bgc.runtime.running import compiling

BGC, TESTS = "-march=native -fno-math-errno -ffp-contract=fast", "-ffp-contract=off"
COVERAGE = ("--coverage", "-fprofile-update=single")
GOLD = ("-fuse-ld=gold",) if shutil.which("ld.gold") else ()  # takes half the time
LINK = ("gcc", "-shared", *GOLD)


class NotC(Exception):
    """A break that the compiler does not accept."""


class Objects:
    """The objects of the runtime's files, of the present break and without it."""

    def __init__(self, work: Path, runtime: Path, models: Path) -> None:
        self.work, self.runtime, self.models = work, runtime, models
        self.changed: tuple[str, str] | None = None  # a file, relative to the runtime; its text
        self.coverage = False
        self.light = False  # compile models that are in the cache, too
        self.kept: dict[tuple[str, ...], Path] = {}
        headers = sorted(runtime.rglob("*.h"))
        self.headers = hashlib.sha1(b"".join(path.read_bytes() for path in headers)).hexdigest()
        for folder in ("objects", "covered", "records", "broken"):
            (work / folder).mkdir(exist_ok=True)

    def name_of(self, path: Path) -> str:
        return path.relative_to(self.runtime).as_posix()

    def of_file(self, name: str, flags: str, changed: bool = True) -> Path:
        """The object of a runtime file, or of another C file by its absolute path."""
        broken = changed and self.changed is not None and name == self.changed[0]
        key = (name, flags, str(broken and self.changed), str(self.coverage))
        if key not in self.kept:
            source = self.runtime / name
            text = self.changed[1] if broken and self.changed else source.read_text("utf-8")
            self.kept[key] = self.compile(source, text, flags)
        return self.kept[key]

    def compile(self, source: Path, text: str, flags: str) -> Path:
        folder = self.work / ("covered" if self.coverage else "objects")
        key = hashlib.sha1("\0".join((self.headers, source.name, text, flags)).encode()).hexdigest()
        made = folder / f"{source.stem}.{key}.o"
        if not made.exists():
            copy = folder / f"{source.stem}.{key}.c"
            copy.write_text(f'#line 1 "{self.name_or_path(source)}"\n{text}', "utf-8")
            includes = (f"-I{source.parent}", f"-I{self.runtime}")
            coverage = COVERAGE if self.coverage else ()
            command = ("gcc", "-std=c11", "-O1", "-w", "-fPIC", *flags.split(), *coverage,
                       *includes, "-c", str(copy), "-o", str(made))  # fmt: skip
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode != 0:
                raise NotC(done.stderr)
        return made

    def of_path(self, path: Path, flags: str) -> Path:
        if self.runtime in path.parents:
            return self.of_file(self.name_of(path), flags)
        return self.compile(path, path.read_text("utf-8"), flags)

    def name_or_path(self, source: Path) -> str:
        return self.name_of(source) if self.runtime in source.parents else str(source)

    def link(self, objects: list[Path], made: Path, flags: tuple[str, ...] = ()) -> None:
        coverage = ("--coverage",) if self.coverage else ()
        made.unlink(missing_ok=True)
        command = (*LINK, *coverage, *flags, "-o", str(made), *map(str, objects), "-lm")
        subprocess.run(command, check=True, capture_output=True)

    def compile_all(self) -> None:
        """Compile the runtime without a break, so that no test is charged with it."""
        for path in build.runtime_sources(self.runtime):
            for flags in (BGC, TESTS):
                self.of_file(f"{path}.c", flags)

    # --- models that bgc compiles ---------------------------------------------------------------

    def build(self, units: Any, toolchain: Any, cache: Any) -> Path:
        """Take the place of `build._build`."""
        parts = {part for unit in units for part in unit.parts}
        sources = build.needed_sources(self.runtime, parts)
        names = [self.name_of(path) for path in sources.values()]
        shared = build._shared_key(toolchain)
        lanes = [unit.name for unit in units if unit.name.startswith("lanes/")]
        own = [unit for unit in units if not unit.name.startswith("lanes/")]
        keys = [build._unit_key(shared, unit) for unit in own]
        flags = build._link_flags(toolchain, own)
        library = f"{build.digest_of((shared, *flags, *names, *lanes, *keys))}.so"
        path = cache.blob("models", library)
        if path is None or not self.record(library).exists():
            with cache.workplace() as place:
                objects = build._compile_all(own, keys, toolchain, cache, Path(place))
                made = Path(place) / library
                covered, self.coverage = self.coverage, False
                whole = [self.of_file(name, BGC, changed=False) for name in (*names, *lanes)]
                self.link([*objects, *whole], made, flags)
                self.coverage = covered
                path = cache.publish("models", library, made)
            record = {"names": [*names, *lanes], "objects": list(map(str, objects)),
                      "flags": list(flags)}  # fmt: skip
            self.record(library).write_text(json.dumps(record))
        return self.present(path)

    def record(self, library: str) -> Path:
        return self.work / "records" / f"{library}.json"

    def present(self, library: Path) -> Path:
        """A model's shared object with the present break, or for coverage."""
        if not self.record(library.name).exists():
            return library
        record = json.loads(self.record(library.name).read_text())
        broken = self.changed is not None and self.changed[0] in record["names"]
        if not (broken or self.coverage):
            return library
        made = self.work / "broken" / library.name
        if not made.exists():
            runtime = [self.of_file(name, BGC) for name in record["names"]]
            self.link([*map(Path, record["objects"]), *runtime], made, tuple(record["flags"]))
        return made

    def lanes(self) -> tuple[Any, ...]:
        """Take the place of `lane_runtime_units`: units without a text."""
        return tuple(
            build.Unit(f"lanes/{path.name}", "")
            for path in sorted((self.runtime / "lanes").glob("*.c"))
        )

    def unit_flags(self, unit: Any, toolchain: Any) -> tuple[str, ...]:
        return ("-O0", "-w", *(f for f in build._without_passes(unit.flags) if f[:2] != "-O"))

    # --- models in C ----------------------------------------------------------------------------

    def run_compiler(self, plain: Callable[..., None]) -> Callable[..., None]:
        """Take the place of `run_compiler` in tests/unit/conftest.py."""

        def run(*arguments: str | Path, warnings: bool = False) -> None:
            paths = [each for each in arguments if isinstance(each, Path)]
            if not paths or not any({self.runtime, self.models} & {*p.parents} for p in paths):
                plain(*arguments, warnings=warnings)
                return
            given = {"-lm", "-shared", "-c", "-o", f"-I{self.runtime}"}
            flags = " ".join(
                (TESTS, *(a for a in map(str, arguments) if a[0] == "-" and a not in given))
            )
            *sources, target = paths
            objects = [
                self.of_path(path, flags) if path.suffix == ".c" else path for path in sources
            ]
            if "-c" in arguments:
                shutil.copy(objects[0], target)
            else:
                self.link(objects, target)

        return run

    def install(self, conftest: ModuleType) -> None:
        build._build = self.build
        build.unit_flags = self.unit_flags
        driver.lane_runtime_units = self.lanes
        recall._compiler_identity = lambda: "unchanged"
        found = compiling.recall

        def recalled(path: Path, options: Any) -> Any:
            built = None if self.light else found(path, options)
            return built and replace(built, library=self.present(built.library))

        compiling.recall = recalled
        own = self.run_compiler(conftest.run_compiler)
        for module in list(sys.modules.values()):
            function = vars(module).get("run_compiler")
            if function is not None and function.__code__ == conftest.run_compiler.__code__:
                module.run_compiler = own  # type: ignore[attr-defined]
        conftest.run_compiler = own  # type: ignore[attr-defined]

    def clear(self) -> None:
        """Remove the models with an earlier break."""
        shutil.rmtree(self.work / "broken")
        (self.work / "broken").mkdir()

    def break_file(self, name: str, text: str) -> bool:
        """Change a file of the runtime; False where its machine code stays the same.

        Raises NotC where it is no longer C.
        """
        self.changed = None
        whole = self.of_file(name, BGC)
        self.changed = (name, text)
        self.clear()
        return self.of_file(name, BGC).read_bytes() != whole.read_bytes()
