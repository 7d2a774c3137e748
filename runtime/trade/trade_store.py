"""Measurements kept between runs of `bgc trade`.

Each compiled scene with its parameters on this machine has a folder in the cache. It has the
reference, a file for each finished configuration, and the answers for `solver auto`
(`running.recommended`). Files are written to a temporary name and renamed: a killed run loses
only its present configuration, and two runs may write at the same time.
"""

from __future__ import annotations

import json
import os
import platform
import shutil
import zipfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from bgc.building.cache import digest_of, open_cache, write_aside
from bgc.building.record_json import from_json, to_json
from bgc.diagnostics.diagnostic import BgError
from bgc.language.solver import Solver
from bgc.runtime.results.files import write_arrays
from bgc.runtime.running.identity import bgc_version
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.recommendation import keep_recommendation, scene_folder
from bgc.runtime.trade.configurations import Configuration
from bgc.runtime.trade.measurement import Measurement
from bgc.runtime.trade.reference_solution import Reference

_DAMAGED = (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile)


@dataclass(slots=True)
class Store:
    """The folder of one scene; `problem` is the reason why something could not be written."""

    folder: Path
    problem: str = ""

    def clear(self) -> None:
        """Delete all measurements."""
        shutil.rmtree(self.folder, ignore_errors=True)

    def measurement(self, content: str, configuration: Configuration) -> Measurement | None:
        """Read the measurement of a configuration of a model with that content, if there is one."""
        with suppress(*_DAMAGED):
            value = json.loads(self._row(content, configuration).read_text(encoding="utf-8"))
            found: Measurement = from_json(Measurement, value)
            return found if found.configuration == configuration else None
        return None

    def keep(self, content: str, measurement: Measurement) -> None:
        """Store a finished measurement."""
        self._write(self._row(content, measurement.configuration), to_json(measurement))

    def reference(self) -> Reference | None:
        """Read the stored reference, if there is one."""
        with suppress(*_DAMAGED), np.load(self.folder / "reference.npz") as archive:
            about = json.loads(str(archive["about"]))
            return Reference(
                rows=archive["rows"],
                methods=tuple(about["methods"]),
                rtol=about["rtol"],
                agreement=tuple(about["agreement"]),
                accuracy=about["accuracy"],
                levels=tuple((rtol, tuple(map(float, each))) for rtol, each in about["levels"]),
                seconds=about["seconds"],
                required=about["required"],
            )
        return None

    def keep_reference(self, reference: Reference) -> None:
        """Store the reference, and delete measurements against another one."""
        self.clear()
        about = {name: value for name, value in to_json(reference).items() if name != "rows"}
        with self._noted():
            self.folder.mkdir(parents=True, exist_ok=True)
            text = np.array(json.dumps(about))
            write_arrays(self.folder / "reference.npz", {"rows": reference.rows, "about": text})

    def keep_answer(self, model: LoadedModel, method: Solver | None) -> None:
        """Store the method that is recommended, or that none is."""
        with self._noted():
            keep_recommendation(self.folder, model, method)

    def _write(self, path: Path, value: object) -> None:
        with self._noted():
            path.parent.mkdir(parents=True, exist_ok=True)
            write_aside(path, json.dumps(value))

    @contextmanager
    def _noted(self) -> Iterator[None]:
        """Continue if the disk is full: measurements are shown all the same."""
        try:
            yield
        except OSError as problem:
            self.problem = problem.strerror or str(problem)
        except BgError as problem:
            self.problem = problem.diagnostics[0].message

    def _row(self, content: str, configuration: Configuration) -> Path:
        return self.folder / "rows" / f"{digest_of((content, repr(configuration)))}.json"


def open_store(model: LoadedModel, duration: float, every: float | None) -> Store:
    """Open the store of a model with its present parameters, for a duration and row interval, s."""
    return Store(open_cache().root / scene_folder(model, {}, duration, every))


def machine_description() -> str:
    """Describe the processor and the system."""
    name = ""
    with suppress(OSError), Path("/proc/cpuinfo").open(encoding="ascii", errors="replace") as file:
        lines = (line.partition(":") for line in file)
        name = next((value.strip() for key, _, value in lines if key.strip() == "model name"), "")
    processor = name or platform.processor() or platform.machine()
    cores = os.cpu_count() or 1
    system = f"{platform.system()} {platform.release()}"
    return f"{processor}, {cores} core{'s' if cores > 1 else ''}, {system}, bgc {bgc_version()}"
