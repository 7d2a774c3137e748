"""`bgc fmt`."""

from __future__ import annotations

from pathlib import Path

import click

from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.grammar.files import read_source
from bgc.grammar.format import format_source
from bgc.runtime.cli.app import AT_FAULT, print_diagnostics, printable
from bgc.runtime.cli.options import MODEL_FILE
from bgc.runtime.results.files import written_whole


@click.command()
@click.argument("files", type=MODEL_FILE, nargs=-1, required=True)
@click.option(
    "--check", is_flag=True, help="Change nothing; exit with status 1 if a file would change."
)
@click.pass_context
def fmt(context: click.Context, files: tuple[Path, ...], check: bool) -> None:
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
                with written_whole(file) as aside:
                    aside.write_text(canonical, encoding="utf-8", newline="\n")
            done = "would reformat" if check else "reformatted"
            click.echo(printable(f"{done} {file}"), err=True)
        except BgError as problem:
            problems.extend(problem.diagnostics)
    print_diagnostics(problems)
    if problems or (check and changed):
        context.exit(AT_FAULT)
