"""Rows of an ensemble that Ctrl-C ended, kept in the cache for the next equal call."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Mapping, Sequence, Set
from contextlib import suppress
from dataclasses import astuple, dataclass
from pathlib import Path

import numpy as np

from bgc.building.cache import digest_of, digest_of_bytes, open_cache
from bgc.building.recall import machine_identity
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.files import write_arrays
from bgc.runtime.results.observables import Observable
from bgc.runtime.running.cases import Cases
from bgc.runtime.running.identity import scene_identity
from bgc.runtime.running.loaded import LoadedModel
from bgc.runtime.running.run import Method
from bgc.runtime.running.warned import read_warnings, written_warnings

FOLDER = "sweeps"  # of the cache

_DAMAGED = (OSError, ValueError, KeyError, zipfile.BadZipFile)


@dataclass(frozen=True, slots=True)
class Unfinished:
    """The file for the rows of one ensemble."""

    path: Path

    def recall(self, rows: Array, warned: dict[int, tuple[Diagnostic, ...]]) -> set[int]:
        """Fill in rows and warnings of an earlier call; return the numbers of its instances."""
        with suppress(*_DAMAGED), self.path.open("rb") as file, np.load(file) as archive:
            numbers, kept = archive["numbers"], archive["rows"]
            if kept.shape == (len(numbers), *rows.shape[1:]):
                warned |= read_warnings(json.loads(str(archive["warned"])))
                rows[numbers] = kept
                return set(numbers.tolist())
        return set()

    def keep(self, rows: Array, done: Set[int], warned: Mapping[int, Sequence[Diagnostic]]) -> bool:
        """Write the rows and warnings of finished instances; return whether there are any."""
        numbers = np.array(sorted(done), dtype=np.int64)
        if not len(numbers):
            return False
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            text = np.array(json.dumps(written_warnings(warned)))
            arrays = {"numbers": numbers, "rows": rows[numbers], "warned": text}
            write_arrays(self.path, arrays)
        except (BgError, OSError):  # a full disk: the caller has the rows all the same
            return False
        return True

    def clear(self) -> None:
        """Delete the file."""
        with suppress(OSError):
            self.path.unlink(missing_ok=True)


def find_unfinished(
    model: LoadedModel,
    method: Method,
    cases: Cases,
    times: Array,
    alone: str,
    observables: Sequence[Observable] = (),
) -> Unfinished:
    """Find the file of an ensemble, by everything that decides its rows."""
    key = (ensemble_identity(model, method, cases, times, alone, observables), machine_identity())
    return Unfinished(open_cache().root / FOLDER / f"{digest_of(key)}.npz")


def ensemble_identity(
    model: LoadedModel,
    method: Method,
    cases: Cases,
    times: Array,
    alone: str,
    observables: Sequence[Observable] = (),
) -> str:
    """Hash everything but the machine that decides the rows of an ensemble."""
    arrays = (digest_of_bytes(each.tobytes()) for each in (times, cases.values))
    columns = model.facts.columns
    state = repr((astuple(method), alone, cases.names, tuple(observables), columns))
    return digest_of((*scene_identity(model, {}), state, *arrays))
