"""`bgc check`."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import click

from bgc.diagnostics.diagnostic import BgError, Diagnostic, Severity, as_error
from bgc.driver import check_source
from bgc.runtime.cli.app import AT_FAULT, print_diagnostics
from bgc.runtime.cli.options import MODEL_FILE, scene_option, strict_option, verify_option

_scene_option = partial(scene_option, text="Scene to check; by default all scenes of each file.")


@click.command()
@click.argument("files", type=MODEL_FILE, nargs=-1, required=True)
@_scene_option
@strict_option
@verify_option
@click.pass_context
def check(
    context: click.Context, files: tuple[Path, ...], scene: str | None, strict: bool, verify: bool
) -> None:
    """Report the errors and warnings of FILES, in all scenes or in one.

    Nothing is written or run.
    """
    found: list[Diagnostic] = []
    for file in files:
        try:
            found.extend(check_source(file, scene, verify))
        except BgError as problem:
            found.extend(problem.diagnostics)
    found = _each_once([as_error(d) for d in found] if strict else found)
    print_diagnostics(found)
    errors = sum(diagnostic.severity is Severity.ERROR for diagnostic in found)
    warnings = sum(diagnostic.severity is Severity.WARNING for diagnostic in found)
    click.echo(
        f"{_counted(len(files), 'file')}: {_counted(errors, 'error')}, "
        f"{_counted(warnings, 'warning')}",
        err=True,
    )
    if errors:
        context.exit(AT_FAULT)


def _each_once(found: list[Diagnostic]) -> list[Diagnostic]:
    """Drop diagnostics that imports by several files repeat."""
    kept: dict[tuple[object, ...], Diagnostic] = {}
    for diagnostic in found:
        span = diagnostic.span
        place = (span.source.name, span.start, span.end) if span else None
        kept.setdefault((diagnostic.code, diagnostic.message, place), diagnostic)
    return list(kept.values())


def _counted(number: int, noun: str) -> str:
    return f"{number or 'no'} {noun}{'' if number == 1 else 's'}"
