"""Run 9: compile a scene to C, to a shared object or to an FMU."""

from collections.abc import Mapping
from dataclasses import fields
from pathlib import Path
from typing import Any, get_type_hints

from bgc.runtime.cli.command import Declared, OptionGroup, command, option, require, signature
from bgc.runtime.cli.options import SceneOptions, Strict, Verify, Whole
from bgc.runtime.cli.printing import print_diagnostics, print_paths, print_text
from bgc.runtime.results.files import write_files
from bgc.runtime.targets.target import TARGETS, Order, documentation, targets_taking

_TYPES = get_type_hints(Order)
_FLAGS = {field.name: field.metadata["flag"] for field in fields(Order) if field.metadata}


def _declared(name: str) -> tuple[Any, Declared]:
    """Declare the option that gives a field of an order."""
    metadata = Order.__dataclass_fields__[name].metadata
    *names, last = targets_taking(metadata["flag"])
    targets = f"{', '.join(names)} or {last}" if names else last
    metavar = {"metavar": metadata["metavar"]} if metadata["metavar"] else {}
    text = f"With --target {targets}: {metadata['doc']}"
    return _TYPES[name], option(text, metadata["flag"], **metavar)


class TargetOptions(OptionGroup):
    """The options that only some targets take."""

    __signature__ = signature({name: _declared(name) for name in _FLAGS})

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
        "Folder to write to; with --target c, - for standard output.",
        "-o",
        "--out",
        metavar="DIR",
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
    for name, flag in _FLAGS.items():
        taken = flag in TARGETS[target].options or more.given[name] in (None, (), False)
        require(taken, f"{flag} needs --target {' or '.join(targets_taking(flag))}")
    options = scene.options(whole=whole, strict=strict, verify=verify)
    made = TARGETS[target].make(Order(scene.file, options, **more.given))
    print_diagnostics(made.warnings)
    if timings and made.seconds:
        print_text(_table(made.seconds), err=True)
    if out == "-":
        print_text(next(iter(made.files.values())).decode())
    else:
        paths = write_files(Path(out), {**made.files, **made.companions})
        print_paths(path for path in paths if path.name in made.files)


def _table(seconds: Mapping[str, float]) -> str:
    """Tabulate the seconds of the stages, and their sum."""
    rows = {**seconds, "together": sum(seconds.values())}
    width = max(map(len, rows))
    return "\n".join(f"{name:<{width}} {spent:8.3f} s" for name, spent in rows.items())
