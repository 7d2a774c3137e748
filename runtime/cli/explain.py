"""Write and check 6: look up a diagnostic (the same as doc)."""

from bgc.reference.codes import GROUP
from bgc.reference.index import answer
from bgc.runtime.cli.command import argument, command
from bgc.runtime.documents.terminal import print_entries


@command()
def explain(code: str | None = argument()) -> None:
    """Show what a diagnostic means and how to resolve it: bgc explain BG201.

    Without a code, list all diagnostics; with a word, those that mention it. The same as
    `bgc doc CODE`.
    """
    print_entries(answer(GROUP.name if code is None else code, [GROUP]))
