"""Find the C compiler of this machine."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path
from threading import Lock

from bgc.building.temporary import temporary_folder
from bgc.diagnostics.catalogue.machine import chosen_compiler_missing, no_c_compiler
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass

NO_FILE = "it ended with status 0 and wrote no file"
CANDIDATES = ("cc", "gcc", "clang")
# -P: a folder `ziglang` in the current directory, such as that of a stranger's model, is not run.
ZIGLANG = (sys.executable, "-P", "-m", "ziglang", "cc")

# The instruction set of this machine, mainly for fused multiply-add (LU 1.5 x faster). Without
# errno, sqrt is one instruction. -ffast-math was measured to gain nothing.
COMMON_FLAGS = ("-std=c11", "-march=native", "-fno-math-errno", "-fPIC")
RUNTIME_FLAGS = ("-O3", *COMMON_FLAGS, "-ffp-contract=fast")
# As fast as -O3 in half to two thirds of its compile time; gcc before 12 does not vectorise at -O2
# unless it is set to.
LOOP_FLAGS = ("-O2", "-ftree-vectorize", *COMMON_FLAGS, "-ffp-contract=fast")
# Half of the compile time with vectors; within 4 % of the speed where other files hold the loops.
SCALAR_FLAGS = ("-O2", "-fno-tree-vectorize", *COMMON_FLAGS, "-ffp-contract=fast")
STEP_FLAGS = ("-O1", *COMMON_FLAGS, "-ffp-contract=fast")
LIGHT_FLAGS = ("-Og", *COMMON_FLAGS, "-ffp-contract=fast")  # two thirds of the time of -O1

# Passes of gcc on straight-line code: one that pays off, and those that take a third of the compile
# time without making a step faster, measured on x86-64. The names after `-fdisable` may change
# between versions of gcc.
GCC_PASSES = (
    "-fexpensive-optimizations",
    "-fno-tree-dse",
    "-fno-dse",
    "-fno-tree-ccp",
    "-fno-tree-bit-ccp",
    "-fno-tree-fre",
    "-fno-forward-propagate",
    "-fno-ipa-modref",
    "-fno-inline-functions-called-once",  # the parts that long functions were cut into
    "-fdisable-rtl-combine",
    "-fdisable-rtl-postreload",
)
GCC_ALIASES = ("-fno-tree-pta",)  # one more, where a single array is read and written

_PROBE = """#include <math.h>
#include <stdint.h>
#include <string.h>
double bgc_probe(double x);
double bgc_probe(double x) { char t[8]; memset(t, 0, sizeof t); return sqrt(x) + t[0]; }
"""


class Compilations:
    """The compilers that several threads run, for one thread to end them all."""

    def __init__(self) -> None:
        self.ended = False
        self._lock = Lock()
        self._running: set[subprocess.Popen[str]] = set()

    def add(self, process: subprocess.Popen[str]) -> None:
        """Note a process that was started; kill it if the compilations were ended meanwhile."""
        with self._lock:
            self._running.add(process)
            if self.ended:
                process.kill()

    def discard(self, process: subprocess.Popen[str]) -> None:
        """Forget a process that has ended."""
        with self._lock:
            self._running.discard(process)

    def end(self) -> None:
        """Kill the processes that run, and those that other threads still start."""
        with self._lock:
            self.ended = True
            for process in self._running:
                process.kill()


@dataclass(frozen=True, slots=True)
class Toolchain:
    """A C compiler: its command, its kind and the first line of its version.

    `kind` is `gcc`, `clang`, `zig`, `tcc`, or `cc` where the version does not name it.
    """

    command: tuple[str, ...]
    kind: str
    version: str

    @property
    def name(self) -> str:
        """The command as a user would type it."""
        return shlex.join(self.command)

    def run(
        self, arguments: tuple[str, ...], directory: Path, among: Compilations | None = None
    ) -> subprocess.CompletedProcess[str]:
        """Run the compiler in a directory; return its output and errors as one text.

        The process is one of the compilations `among` which it runs. Its own temporary files are in
        that directory too, so that a compiler which is killed leaves none behind.
        """
        command = [*self.command, *arguments]
        among = among or Compilations()
        try:
            with subprocess.Popen(
                command,
                cwd=directory,
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                errors="replace",
                # Diagnostics quote the compiler, so it has to answer in English.
                env={**os.environ, "LC_ALL": "C", "TMPDIR": str(directory.absolute())},
            ) as process:
                among.add(process)
                try:
                    output, _ = process.communicate()
                except BaseException:
                    process.kill()
                    raise
                finally:
                    among.discard(process)
                return subprocess.CompletedProcess(command, process.returncode, output)
        except OSError as problem:  # not a program after all
            return subprocess.CompletedProcess(command, 127, str(problem))


def find_toolchain() -> Toolchain:
    """Find a C compiler: `$CC`, `cc`, `gcc`, `clang`, else that of the `ziglang` wheel.

    Raises BgError (BG050, BG051) when there is none. Whether it works shows when it is used.
    """
    if chosen := os.environ.get("CC", "").strip():
        try:
            command = tuple(shlex.split(chosen))
        except ValueError:  # a quote that is not closed
            command = ()
        found = shutil.which(command[0]) if command else None
        if found is None:
            raise BgError([chosen_compiler_missing(chosen)])
        if Path(command[0]).name != command[0]:  # compilers run in directories of their own
            command = (str(Path(found).absolute()), *command[1:])
        return identify(command)
    for candidate in CANDIDATES:
        if shutil.which(candidate) is not None:
            return identify((candidate,))
    if find_spec("ziglang") is not None:
        return identify(ZIGLANG)
    raise BgError([no_c_compiler(("$CC", *CANDIDATES, "ziglang"))])


def try_compiler(toolchain: Toolchain, flags: tuple[str, ...] = RUNTIME_FLAGS) -> str:
    """Build a trivial shared object; return the compiler's complaint, empty if there is none."""
    with temporary_folder() as place:
        (place / "probe.c").write_text(_PROBE, encoding="utf-8")
        arguments = (*flags, "-shared", "probe.c", "-o", "probe.so", "-lm")
        done = toolchain.run(arguments, place)
        if done.returncode == 0 and not (place / "probe.so").is_file():
            return NO_FILE
    return done.stdout.strip() or f"status {done.returncode}" if done.returncode else ""


def identify(command: tuple[str, ...]) -> Toolchain:
    """Ask a compiler for its version; one that does not answer fails when it is used.

    It runs in an empty directory, from which it can read nothing.
    """
    try:
        with tempfile.TemporaryDirectory(prefix="bgc-") as place:
            answer = subprocess.run(
                [*command, "--version"],
                cwd=place,
                capture_output=True,
                text=True,
                errors="replace",
                timeout=60,
                check=False,
            ).stdout
    except (OSError, subprocess.SubprocessError):
        answer = ""
    version = next((line.strip() for line in answer.splitlines() if line.strip()), "unknown")
    return Toolchain(command, _kind(command, answer), version)


def _kind(command: tuple[str, ...], answer: str) -> str:
    if "ziglang" in command or Path(command[0]).name == "zig":
        return "zig"
    if "clang" in answer:
        return "clang"
    if answer.startswith("tcc"):
        return "tcc"
    return "gcc" if "Free Software Foundation" in answer else "cc"
