"""Standard streams: repaired where the caller closed them, and written out at the end."""

import os
import sys
from contextlib import suppress

_FOR_INPUT, _FOR_OUTPUT, _FOR_ERRORS = 0, 1, 2


def repair_streams() -> None:
    """Open what stands in for closed standard streams (`bgc run .. 2>&-`).

    A file that is opened later would get the number of a closed stream, and messages would go
    into it. Errors are discarded. Standard output is opened for reading alone, so that writing
    to it is an error as it is without a file.
    """
    modes = {_FOR_INPUT: os.O_RDONLY, _FOR_OUTPUT: os.O_RDONLY, _FOR_ERRORS: os.O_WRONLY}
    for number, mode in modes.items():
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, mode)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
    if sys.stdin is None:
        sys.stdin = open(_FOR_INPUT, closefd=False)  # noqa: SIM115
    if sys.stdout is None:
        sys.stdout = open(_FOR_OUTPUT, "w", closefd=False)  # noqa: SIM115
    if sys.stderr is None:
        sys.stderr = open(_FOR_ERRORS, "w", closefd=False)  # noqa: SIM115


def discard_output() -> None:
    """Discard what standard output still holds, which Python would try to write at its end."""
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, sys.stdout.fileno())
        os.close(nowhere)
        sys.stdout.flush()
