"""Write and check 2: report errors and warnings without compiling."""

from bgc.diagnostics.diagnostic import BgError, Diagnostic, Severity, as_error
from bgc.driver import check_source
from bgc.runtime.cli.command import command, option
from bgc.runtime.cli.completion import scenes_of
from bgc.runtime.cli.options import Files, Strict, Verify
from bgc.runtime.cli.printing import AT_FAULT, print_diagnostics, print_text


@command()
def check(
    files: Files,
    *,
    scene: str | None = option(
        "Scene to check; by default all scenes of each file.",
        metavar="NAME",
        shell_complete=scenes_of,
    ),
    strict: Strict,
    verify: Verify,
) -> int:
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
    kinds = [diagnostic.severity for diagnostic in found]
    errors, warnings = kinds.count(Severity.ERROR), kinds.count(Severity.WARNING)
    counts = ((len(files), "file"), (errors, "error"), (warnings, "warning"))
    shown = [f"{number or 'no'} {noun}{'' if number == 1 else 's'}" for number, noun in counts]
    print_text(f"{shown[0]}: {', '.join(shown[1:])}", err=True)
    return AT_FAULT if errors else 0


def _each_once(found: list[Diagnostic]) -> list[Diagnostic]:
    """Drop diagnostics that imports by several files repeat."""
    kept: dict[tuple[object, ...], Diagnostic] = {}
    for diagnostic in found:
        span = diagnostic.span
        place = (span.source.name, span.start, span.end) if span else None
        kept.setdefault((diagnostic.code, diagnostic.message, place), diagnostic)
    return list(kept.values())
