"""Write and check 4: rewrite files in canonical form."""

from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.grammar.format import format_source
from bgc.grammar.source_files import read_source
from bgc.runtime.cli.command import command, option
from bgc.runtime.cli.options import Files
from bgc.runtime.cli.printing import (
    AT_FAULT,
    print_diagnostics,
    print_text,
    write_file,
)


@command()
def fmt(
    files: Files,
    check: bool = option("Change nothing; exit with status 1 if a file would change."),
) -> int:
    """Rewrite FILES in canonical form; comments are kept."""
    problems: list[Diagnostic] = []
    changed = 0
    for file in files:
        try:
            source = read_source(file)
            canonical = format_source(source)
            if canonical == source.text:
                continue
            changed += 1
            if not check:
                write_file(file, canonical)
            done = "would reformat" if check else "reformatted"
            print_text(f"{done} {file}", err=True)
        except BgError as problem:
            problems.extend(problem.diagnostics)
    print_diagnostics(problems)
    return AT_FAULT if problems or (check and changed) else 0
