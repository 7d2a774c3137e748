"""The answer of the compiler to one file, by class: accepted, refused with codes, or a fault."""

from __future__ import annotations

import os
import re
import signal
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from bgc.building.build import runtime_directory
from bgc.diagnostics.diagnostic import BgError, Diagnostic, Severity
from bgc.diagnostics.render import render
from bgc.driver import compile_scene
from bgc.elaboration.scenes.scene_choice import models_alone, stands_alone
from bgc.emission.emit import amalgamate
from bgc.grammar.format import format_source
from bgc.options import Options
from bgc.resolution import resolve
from bgc.resolution.modules import Package

CPU_SECONDS = 5.0
MEMORY = 1_000_000_000  # bytes beyond what the process has before
FAULTS = ("traceback", "hang", "memory", "died", "message", "not finite", "format", "silent")
FAULTS += ("crash", "differs", "unjust", "harness")  # of programs that are compared with equations
UNJUDGED = ("reference", "open", "same")  # programs of which no reference knows the answer

_CODE = re.compile(r"BG\d{3}")
_PYTHON = re.compile(r"(?<!`)``(?!`)|<[\w.]+ object at |frozenset\(|\bTraceback\b|\bdataclass\b")


@dataclass(frozen=True, slots=True)
class Verdict:
    """The class of an answer, its codes, and where it is a fault, what is needed to find it."""

    outcome: str
    codes: tuple[str, ...] = ()
    detail: str = ""

    @property
    def is_fault(self) -> bool:
        return self.outcome in FAULTS

    @property
    def is_listed(self) -> bool:
        return self.is_fault or self.outcome in UNJUDGED


@dataclass(slots=True)
class _Answer:
    """The diagnostics of all scenes of a file, and the scenes that compile."""

    diagnostics: list[Diagnostic] = field(default_factory=list)
    compiled: list[tuple[Package, str | None]] = field(default_factory=list)


def judged(path: Path, *, verify: bool, formatted: bool = False) -> Verdict:
    """Take a file through the stages of `bgc check` and `bgc build --target c`.

    With `verify` every intermediate result is verified and the C is put together to one file; with
    `formatted` the canonical form of the text is tried, too.
    """
    try:
        answer = _answered(path, verify=verify)
        if problem := _unreadable(answer.diagnostics):
            return Verdict("message", _codes(answer.diagnostics), problem)
        if formatted and (problem := _badly_formatted(path)):
            return Verdict("format", _codes(answer.diagnostics), problem)
    except MemoryError:
        return Verdict("memory", (), traceback.format_exc(limit=-8))
    except Exception:
        return Verdict("traceback", (), traceback.format_exc(limit=-8))
    errors = [d for d in answer.diagnostics if d.severity is Severity.ERROR]
    codes = _codes(answer.diagnostics)
    if errors:
        return Verdict("refused", codes)
    return Verdict("accepted" if answer.compiled else "parts only", codes)


def _answered(path: Path, *, verify: bool) -> _Answer:
    """Do what `bgc check` does, and go on to the C of each scene that compiles."""
    answer = _Answer()
    try:
        package = resolve.load(path)
    except BgError as error:
        answer.diagnostics += error.diagnostics
        return answer
    answer.diagnostics += package.warnings
    for reached, scene in _scenes(package):
        signal.setitimer(signal.ITIMER_PROF, CPU_SECONDS)  # a file may have many scenes
        try:
            stages = compile_scene(
                path, Options(scene, verify=verify), package=reached, until="emit"
            )
        except BgError as error:
            answer.diagnostics += error.diagnostics
        else:
            if verify:
                amalgamate(stages.emitted, runtime_directory())
            answer.diagnostics += stages.warnings
            answer.compiled.append((reached, scene))
    return answer


def _scenes(package: Package) -> Iterator[tuple[Package, str | None]]:
    """The scenes that `bgc check` compiles: all, and the complete models that none reaches."""
    found: list[tuple[Package, str | None]] = [(package, name) for name in package.scene_names]
    found += [(alone, None) for alone in models_alone(package)]
    if not found and stands_alone(package):
        found = [(package, None)]
    yield from found


def _codes(diagnostics: Sequence[Diagnostic]) -> tuple[str, ...]:
    return tuple(sorted({d.code for d in diagnostics}))


def _unreadable(diagnostics: Sequence[Diagnostic]) -> str:
    """The first message that lacks a code or a way out, or that shows the insides of Python."""
    if not diagnostics:
        return ""
    shown = render(diagnostics, colour=False)
    if any(not c.isprintable() and c != "\n" for c in shown):
        return f"control characters: {shown!r}"
    for diagnostic in diagnostics:
        texts = (diagnostic.message, diagnostic.help, diagnostic.note)
        if not _CODE.fullmatch(diagnostic.code):
            return f"no code: {diagnostic}"
        if diagnostic.severity is Severity.ERROR and not diagnostic.help:
            return f"{diagnostic.code} has no way out: {diagnostic.message}"
        if any(_PYTHON.search(text) for text in texts):
            return f"{diagnostic.code}: {diagnostic.message} | {diagnostic.help}"
        if "\n" in diagnostic.message:
            return f"{diagnostic.code} takes several lines: {diagnostic.message}"
    return ""


def _badly_formatted(path: Path) -> str:
    """Say where the canonical form of a file that parses is not a fixed point."""
    try:
        source = resolve.read_source(path)
        once = format_source(source)
        path.with_name("formatted.bg").write_text(once, "utf-8")
        twice = format_source(resolve.read_source(path.with_name("formatted.bg")))
    except BgError as error:
        return "" if "once" not in locals() else f"refused when formatted: {error}"
    return "" if once == twice else f"formatted twice differs from once: {once!r} {twice!r}"


# --- runs -------------------------------------------------------------------------------


def run_briefly(path: Path, seconds: float = CPU_SECONDS) -> Verdict:
    """Compile the first scene to a shared object and run it in a child process.

    A run that takes longer than the limit is `slow`, which is not a fault: a model may ask for it.
    """
    reading, writing = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(reading)
        signal.setitimer(signal.ITIMER_PROF, seconds)
        verdict = _ran(path)
        with os.fdopen(writing, "w") as out:
            out.write("\0".join((verdict.outcome, " ".join(verdict.codes), verdict.detail)))
        os._exit(0)
    os.close(writing)
    with os.fdopen(reading, errors="replace") as answer:
        text = answer.read()
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        number = os.WTERMSIG(status)
        if number == signal.SIGPROF:
            return Verdict("slow")
        return Verdict("died", (), f"signal {number} in a run")
    outcome, codes, detail = text.split("\0", 2)
    return Verdict(outcome, tuple(codes.split()), detail)


def _ran(path: Path) -> Verdict:
    import numpy as np

    import bgc

    try:
        model = bgc.compile(path, preview=True)
        result = model.simulate(error=False)
        codes = tuple(sorted({w.code for w in (*model.warnings, *result.warnings)}))
        finite = all(np.isfinite(result[name]).all() for name in result.columns)
        if not finite and "BG712" not in codes:
            return Verdict("not finite", codes, "a column is not finite, and nothing says so")
        return Verdict("ran", codes)
    except BgError as error:
        return Verdict("stopped", tuple(sorted({d.code for d in error.diagnostics})))
    except Exception:
        return Verdict("traceback", (), traceback.format_exc(limit=-8))
