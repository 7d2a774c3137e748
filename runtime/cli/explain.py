"""`bgc explain`, an alias of `bgc doc` for diagnostics."""

from __future__ import annotations

import click

from bgc.reference.codes import GROUP
from bgc.runtime.cli.doc import show


@click.command()
@click.argument("code", required=False)
def explain(code: str | None) -> None:
    """Show what a diagnostic means and how to resolve it: bgc explain BG201.

    Without a code, list all diagnostics; with a word, those that mention it. The same as
    `bgc doc CODE`.
    """
    show(GROUP.name if code is None else code, [GROUP])
