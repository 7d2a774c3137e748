"""Folders for temporary files."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bgc.diagnostics.catalogue.machine import no_temporary_files
from bgc.diagnostics.diagnostic import BgError


@contextmanager
def temporary_folder() -> Iterator[Path]:
    """Yield an empty folder, which is removed afterwards.

    Raises BgError BG642 where the operating system refuses the folder or a file in it.
    """
    try:
        with tempfile.TemporaryDirectory(prefix="bgc-") as place:
            yield Path(place)
    except OSError as problem:
        reason = problem.strerror or str(problem)
        raise BgError([no_temporary_files(tempfile.gettempdir(), reason)]) from problem
