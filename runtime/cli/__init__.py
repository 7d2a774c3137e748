"""The `bgc` command."""

from __future__ import annotations

import signal

from bgc.runtime.cli.app import application


def main() -> None:
    """Run the command line; the exit status says how it went.

    0 done, 1 the model, the run or the machine is at fault, 2 wrong usage, 70 a bug of bgc,
    130 interrupted.
    """
    if hasattr(signal, "SIGPIPE"):
        # `bgc run f.bg --out - | head` ends quietly, as other commands do.
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    application.main(prog_name="bgc")
