"""Results of many runs that Ctrl-C ended, kept in the cache for the next equal call."""

from __future__ import annotations

import json
import zipfile
from contextlib import suppress
from pathlib import Path

import numpy as np

from bgc.building.cache import digest_of, open_cache
from bgc.building.recall import machine_identity
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.results.files import write_arrays
from bgc.runtime.running.batches import Work
from bgc.runtime.running.run_warnings import read_warnings, written_warnings

FOLDER = "sweeps"  # of the cache

_DAMAGED = (OSError, ValueError, KeyError, zipfile.BadZipFile)


@dataclass(frozen=True, slots=True)
class Unfinished:
    """The file for the rows of one ensemble, or the numbers of one study."""

    path: Path

    def load(self, work: Work) -> int:
        """Fill in the numbers and warnings of an earlier call; return how many runs they are of."""
        with suppress(*_DAMAGED), self.path.open("rb") as file, np.load(file) as archive:
            numbers, kept = archive["numbers"], archive["rows"]
            if kept.shape == (len(numbers), *work.results.shape[1:]):
                work.warned |= read_warnings(json.loads(str(archive["warned"])))
                work.results[numbers] = kept
                work.completed |= set(numbers.tolist())
        return len(work.completed)

    def keep(self, work: Work) -> bool:
        """Write what is done where Ctrl-C ended the work, and return whether there is any.

        Delete the file where all is done.
        """
        if not work.stopping:
            with suppress(OSError):
                self.path.unlink(missing_ok=True)
            return False
        numbers = np.array(sorted(work.completed), dtype=np.int64)
        if not len(numbers):
            return False
        text = np.array(json.dumps(written_warnings(work.warned)))
        arrays = {"numbers": numbers, "rows": work.results[numbers], "warned": text}
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            write_arrays(self.path, arrays)
        except (BgError, OSError):  # a full disk: the caller has the rows all the same
            return False
        return True


def find_unfinished(ensemble: str) -> Unfinished:
    """Find the file of an ensemble, by its identity (`Plan.identity`) on this machine."""
    key = digest_of((ensemble, machine_identity()))
    return Unfinished(open_cache().root / FOLDER / f"{key}.npz")
