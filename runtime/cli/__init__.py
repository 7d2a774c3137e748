"""The `bgc` command."""

from __future__ import annotations

import gc
import signal
import sys
from types import FrameType

from bgc.runtime.cli.app import INTERRUPTED, TERMINATED, application

_ALLOCATIONS = 50_000  # between two garbage collections: a compiler makes little garbage


def main() -> None:
    """Run the command line, and exit with its status.

    0 done; 1 the model, the run or the machine is at fault; 2 wrong usage; 70 a bug in bgc;
    130 interrupted; 143 ended by SIGTERM (which a batch system sends), rows kept as after Ctrl-C.
    """
    gc.set_threshold(_ALLOCATIONS)
    terminated = False

    def interrupt(number: int, frame: FrameType | None) -> None:
        nonlocal terminated
        terminated = True
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, interrupt)
    if hasattr(signal, "SIGPIPE"):
        # `bgc run f.bg --out - | head` ends quietly, as other commands do.
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    try:
        application.main(prog_name="bgc")
    except SystemExit as end:
        if terminated and end.code == INTERRUPTED:
            sys.exit(TERMINATED)
        raise
