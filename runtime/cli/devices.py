"""Run 9: list drivers and haptic devices, and why one cannot be used."""

import shutil
from pathlib import Path

from bgc.building.build import runtime_directory
from bgc.diagnostics.catalogue.machine import cannot_write
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.command import command, option
from bgc.runtime.cli.printing import hanging, print_text
from bgc.runtime.realtime.device_discovery import Finding, find_all

_INDENT = 23  # characters before a text
_EXAMPLE = ("example/mine.c", "example/Makefile", "bgc_device.h")


@command()
def devices(
    example: Path | None = option(
        "Write an example driver with its Makefile to DIR.", metavar="DIR"
    ),
) -> None:
    """List drivers and haptic devices, and why one cannot be used.

    Checks the manufacturers' libraries, USB devices, udev rules and permissions.
    """
    if example is not None:
        print_text(_write_example(example))
    else:
        print_text("\n".join(map(_line, find_all())))


def _line(finding: Finding) -> str:
    mark = "ok" if finding.usable else "--"
    text = hanging(f"{mark}  {finding.name:<18} ", finding.text, _INDENT)
    remedy = f"\n{hanging(' ' * _INDENT, finding.remedy, _INDENT)}" if finding.remedy else ""
    return text + remedy


def _write_example(folder: Path) -> str:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for name in _EXAMPLE:
            target = folder / Path(name).name
            if target.exists() and target.name == "mine.c":
                raise FileExistsError(None, "it is there already", str(target))
            shutil.copyfile(runtime_directory() / name, target)
    except OSError as problem:
        where = str(problem.filename or folder)
        raise BgError([cannot_write(where, problem.strerror or str(problem))]) from problem
    return (
        f"wrote mine.c, Makefile and bgc_device.h to {folder}\n"
        f"`make -C {folder}`, then `--device NAME={folder}/mine.so`"
    )
