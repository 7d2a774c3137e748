"""The `bgc` command."""

import gc
import os
import sys
from typing import NoReturn

from bgc.runtime.cli.signals import catch_signals, end_at_signals
from bgc.runtime.cli.streams import leave_streams, repair_streams

_ALLOCATIONS = 50_000  # between two garbage collections: a compiler makes little garbage


def main() -> NoReturn:
    """Run the command line, and exit with its status.

    0 done; 1 the model, the run or the machine is at fault; 2 wrong usage; 70 a bug in bgc;
    128 and the number of a signal that ended it (130 Ctrl-C, 143 SIGTERM, which a batch system
    sends, 129 SIGHUP, a closed terminal), with the rows kept.
    """
    caught = catch_signals()
    status: int | str | None = 0
    # The matrices that NumPy factorises here are small: in threads, OpenBLAS took up to 50 times as
    # long for them on a busy machine. It reads this when NumPy is loaded.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        gc.set_threshold(_ALLOCATIONS)
        repair_streams()
        # Loading takes a tenth of a second, in which Ctrl-C should already end it quietly.
        from bgc.runtime.cli.app import application

        application.main(prog_name="bgc", obj=caught)
    except KeyboardInterrupt:
        pass
    except SystemExit as end:
        status = end.code
    end_at_signals()
    leave_streams()
    sys.exit(caught.status or status)
