"""Run 10: compile a scene to C, to a shared object or to an FMU."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from bgc.language.records import Option, Where, options_of
from bgc.runtime.cli.command import OptionGroup, command, option, require, signature
from bgc.runtime.cli.options import SceneOptions, Strict, Verify, Whole, rows_of
from bgc.runtime.cli.printing import print_diagnostics, print_paths, print_text
from bgc.runtime.results.files import write_files
from bgc.runtime.targets.target import TARGETS, Order, documentation, targets_taking

_OPTIONS = options_of(Order, Where.COMMAND)


def _text(known: Option) -> str:
    """The help of an option that only some targets take."""
    *names, last = targets_taking(known.flag)
    targets = f"{', '.join(names)} or {last}" if names else last
    return f"With --target {targets}: {known.doc}."


class TargetOptions(OptionGroup):
    """The options that only some targets take."""

    __signature__ = signature(rows_of(Order, {name: _text(o) for name, o in _OPTIONS.items()}))

    def __init__(self, **given: Any) -> None:
        self.given = given


@command()
def build(
    scene: SceneOptions,
    whole: Whole,
    strict: Strict,
    verify: Verify,
    *,
    target: str = option(f"{documentation()}.", choices=TARGETS, default="so", show_default=True),
    out: str = option(
        "Folder to write to, or the file (crane.fmu); with --target c, - for standard output.",
        "-o",
        "--out",
        metavar="PATH",
        default=".",
    ),
    more: TargetOptions,
    timings: bool = option("Print the time of each stage."),
) -> None:
    """Compile a scene of FILE to C, a shared object, an FMU or a live page, and print its path.

    With --target c the header of the C file is written beside it. Two C files link into one
    program if each has a --prefix of its own.
    """
    printable = [name for name, each in TARGETS.items() if each.printable]
    message = f"only --target {' or '.join(printable)} can be written to standard output"
    require(out != "-" or target in printable, message)
    for name, known in _OPTIONS.items():
        taken = known.flag in TARGETS[target].options or more.given[name] in (None, (), False)
        require(taken, f"{known.flag} needs --target {' or '.join(targets_taking(known.flag))}")
    options = scene.options(whole=whole, strict=strict, verify=verify)
    made = TARGETS[target].make(Order(scene.file, options, **more.given))
    print_diagnostics(made.warnings)
    if timings and made.seconds:
        print_text(_table(made.seconds), err=True)
    if out == "-":
        print_text(next(iter(made.files.values())).decode())
    else:
        paths = write_files(*_placed(Path(out), {**made.files, **made.companions}))
        print_paths(paths[: len(made.files)])


def _placed(out: Path, files: Mapping[str, bytes]) -> tuple[Path, dict[str, bytes]]:
    """The folder and its files; `-o crane.fmu` names the file of that kind, and others alike."""
    stem = next((Path(name).stem for name in files if Path(name).suffix == out.suffix != ""), None)
    if stem is None or out.is_dir():
        return out, dict(files)
    named = {
        out.stem + name.removeprefix(stem) if name.startswith(stem) else name: data
        for name, data in files.items()
    }
    return out.parent, named


def _table(seconds: Mapping[str, float]) -> str:
    """Tabulate the seconds of the stages, and their sum."""
    rows = {**seconds, "together": sum(seconds.values())}
    width = max(map(len, rows))
    return "\n".join(f"{name:<{width}} {spent:8.3f} s" for name, spent in rows.items())
