"""Write and check 9: serve an editor: diagnostics, completion, hover, hints, names."""

import os
import sys
from contextlib import redirect_stdout

from bgc.diagnostics.catalogue.machine import package_missing
from bgc.diagnostics.diagnostic import BgError
from bgc.runtime.cli.command import command, option
from bgc.runtime.documents.method_entries import GROUP


@command()
def lsp(
    stdio: bool = option("Accepted for editors; always so.", hidden=True),
) -> None:
    """Serve an editor: diagnostics, completion, hover, hints, names, formatting.

    It speaks the language server protocol over standard input and output, and is started by the
    editor.
    """
    try:
        # An optional package, which no other command needs.
        from bgc.runtime.editor.language_server import make_server
    except ImportError as problem:
        raise BgError([package_missing("pygls", "`bgc lsp`", "lsp")]) from problem
    # The server closes its output at the end; and what a package prints is no message of it.
    output = os.fdopen(os.dup(sys.stdout.fileno()), "wb")
    with redirect_stdout(sys.stderr):
        make_server(dict(GROUP.summaries())).start_io(stdout=output)
