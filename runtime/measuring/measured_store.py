"""Measurements kept in the cache: those of `bgc trade`, `bgc stress` and `bgc activity`.

Each compiled scene with its parameters on this machine has a folder for each study, with a file for
each measurement. Files are written to a temporary name and renamed: a killed run loses only its
present measurement, and two runs may write at the same time.
"""

from __future__ import annotations

import json
import shutil
import zlib
from base64 import b64decode, b64encode
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from bgc.building.cache import digest_of, open_cache, write_aside
from bgc.building.record_json import from_json, to_json
from bgc.diagnostics.diagnostic import BgError
from bgc.record_class import dataclass
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.recommendation import study_folder

_DAMAGED = (OSError, ValueError, KeyError, TypeError, zlib.error)

_Kept = TypeVar("_Kept")


@dataclass(slots=True)
class Store:
    """The folder of a study; `problem` is the reason why something could not be written."""

    folder: Path
    problem: str = ""

    def clear(self) -> None:
        """Delete all measurements."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def read(self, kind: type[_Kept], *key: object) -> _Kept | None:
        """Read the record of a type that was kept under a key; None if there is none."""
        with suppress(*_DAMAGED):
            text = self._path(key).read_text(encoding="utf-8")
            found: _Kept = from_json(kind, json.loads(text, object_hook=_read_array))
            return found
        return None

    def keep(self, record: object, *key: object) -> None:
        """Keep a record of dataclasses, plain values and arrays; a full disk is only noted."""
        path = self._path(key)
        with self.noted():
            path.parent.mkdir(parents=True, exist_ok=True)
            write_aside(path, json.dumps(to_json(record), default=_written_array))

    @contextmanager
    def noted(self) -> Iterator[None]:
        """Continue if the disk is full: measurements are shown all the same."""
        try:
            yield
        except OSError as problem:
            self.problem = problem.strerror or str(problem)
        except BgError as problem:
            self.problem = problem.diagnostics[0].message

    def _path(self, key: tuple[object, ...]) -> Path:
        return self.folder / "rows" / f"{digest_of(map(repr, key))}.json"


def open_store(model: LoadedModel, *facts: object, fresh: bool = False) -> Store:
    """The store of a study of a model with its present parameters, which depends on the facts.

    With `fresh` it is empty.
    """
    store = Store(open_cache().root / study_folder(model, {}, *facts))
    if fresh:
        store.clear()
    return store


def _written_array(array: np.ndarray[Any, Any]) -> dict[str, Any]:
    data = b64encode(zlib.compress(array.tobytes())).decode("ascii")
    return {"dtype": array.dtype.str, "shape": array.shape, "compressed": data}


def _read_array(value: dict[str, Any]) -> Any:
    if "compressed" not in value:
        return value
    data = zlib.decompress(b64decode(value["compressed"]))
    return np.frombuffer(data, value["dtype"]).reshape(value["shape"])
