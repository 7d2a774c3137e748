"""Standard streams: repaired where the caller closed them, and written out at the end."""

import os
import sys
from contextlib import suppress
from typing import TextIO

# By their numbers: how what stands in for a closed one is opened, and the mode of its Python file.
_STREAMS = (("stdin", os.O_RDONLY, "r"), ("stdout", os.O_RDONLY, "w"), ("stderr", os.O_WRONLY, "w"))


def repair_streams() -> None:
    """Open what stands in for closed standard streams (`bgc run .. 2>&-`).

    A file that is opened later would get the number of a closed stream, and messages would go
    into it. Errors are discarded. Standard output is opened for reading alone, so that writing
    to it is an error as it is without a file.
    """
    for number, (name, flags, mode) in enumerate(_STREAMS):
        try:
            os.fstat(number)
        except OSError:
            opened = os.open(os.devnull, flags)
            if opened != number:
                os.dup2(opened, number)
                os.close(opened)
        if getattr(sys, name) is None:
            setattr(sys, name, open(number, mode, closefd=False))  # noqa: SIM115


def discard_output(stream: TextIO | None = None) -> None:
    """Discard what a stream, by default standard output, still holds.

    Python would try to write it at its end.
    """
    held = stream or sys.stdout
    with suppress(OSError, ValueError):
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, held.fileno())
        os.close(nowhere)
        held.flush()


def leave_streams() -> None:
    """Write out the standard streams, or discard what they hold: a terminal may be closed.

    Python itself would change the exit status to 120.
    """
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except (OSError, ValueError):
            discard_output(stream)
