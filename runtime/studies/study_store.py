"""Results of a study in a Zarr group, written while it goes on."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from bgc.building.cache import digest_of
from bgc.diagnostics.catalogue.machine import cannot_write
from bgc.diagnostics.catalogue.studies import other_study
from bgc.diagnostics.diagnostic import BgError, Diagnostic, Severity
from bgc.runtime.results.columns import optional_package
from bgc.runtime.running.batches import Outcome, Work
from bgc.runtime.running.many import Plan
from bgc.runtime.running.run_warnings import read_warnings, written_warnings

_TO_DO, _DONE, _FAILED = 0, 1, 2
_BYTES = 1 << 20  # of an array's chunk


class Store:
    """A directory with a Zarr group (version 3), of which this process is the only writer.

    Arrays along `instance`: `status` (0: to do, 1: done, 2: failed), `parameters` (instance,
    parameter), and `observables` (instance, observable) or `rows` (instance, time, output). Their
    names and units are attributes, and so are the messages of failed runs and of warnings. The
    status of a chunk is written after its values, so what a killed process was writing is computed
    again.
    """

    def __init__(self, path: str | Path, plan: Plan, design: str) -> None:
        """Make the skeleton, or open that of the same study.

        Raises BgError: BG058 without Zarr, BG789 for another study, BG055 where writing fails.
        """
        zarr = optional_package("zarr", "a `.zarr` store", "cluster")
        self.path = str(path)
        self._selection = plan.model.selection()
        identity = digest_of((plan.identity, design))
        try:
            try:
                Path(path).mkdir(parents=True)  # by one of several processes
            except FileExistsError:
                self._group = self._opened(zarr, identity)
            else:
                self._group = zarr.create_group(self.path)
                self._make(plan, design, identity)
        except OSError as problem:
            raise BgError([cannot_write(self.path, problem.strerror or str(problem))]) from problem

    def _opened(self, zarr: Any, identity: str) -> Any:
        try:
            group = zarr.open_group(self.path, mode="r+")
        except (OSError, ValueError, KeyError) as problem:
            raise BgError([other_study(self.path, "it holds no Zarr group")]) from problem
        if group.attrs.get("study") is None:
            raise BgError([other_study(self.path, "bgc has not written it, or not completely")])
        if group.attrs["study"] != identity:
            reason = "its model, method, cases or observables are others"
            raise BgError([other_study(self.path, reason)])
        return group

    def _make(self, plan: Plan, design: str, identity: str) -> None:
        group, count, model = self._group, len(plan.cases), plan.model

        def array(name: str, dims: tuple[str, ...], shape: tuple[int, ...], kind: str) -> None:
            size = max(1, int(np.prod(shape[1:])) * np.dtype(kind).itemsize)
            chunk = max(1, min(count, _BYTES // size))
            group.create_array(
                name, shape=shape, chunks=(chunk, *shape[1:]), dtype=kind, dimension_names=dims,
                fill_value=0 if kind == "int8" else float("nan"),
            )  # fmt: skip

        array("status", ("instance",), (count,), "int8")
        array("parameters", ("instance", "parameter"), (count, len(plan.varied)), "float64")
        names = {name: model.parameters[name].unit for name in plan.varied}
        group["parameters"].attrs.update({"names": list(names), "units": list(names.values())})
        if plan.observables:
            some = plan.observables
            array("observables", ("instance", "observable"), (count, len(some)), "float64")
            about = {"names": [o.name for o in some], "units": [o.unit for o in some]}
            group["observables"].attrs.update(about)
        else:
            outputs = model.outputs
            shape = (count, len(plan.times), len(outputs))
            array("rows", ("instance", "time", "output"), shape, "float64")
            about = {"names": [v.name for v in outputs], "units": [v.unit for v in outputs]}
            group["rows"].attrs.update(about)
            group.create_array("time", data=plan.times, dimension_names=("time",))
        group.create_group("failures")
        group.create_group("warnings")
        # Last: a group without it is not complete.
        facts = {"scene": model.facts.name, "solver": plan.method.name, "design": design}
        group.attrs.update({**facts, "study": identity})

    def load(self, work: Work) -> int:
        """Fill in what an earlier process wrote, and count it; missing numbers are to do.

        Raises BgError: BG789 where an array is missing or cannot be read.
        """
        results = "observables" if work.rows is None else "rows"
        try:
            status, values, found = (
                self._group[name][:] for name in ("status", "parameters", results)
            )
            work.values[:] = values
            if work.rows is None:
                work.reduced[:] = found
            else:
                self._selection.fill(work.rows, found)
        except (OSError, KeyError, ValueError, RuntimeError) as problem:
            reason = f"it is damaged ({problem})"
            raise BgError([other_study(self.path, reason)]) from problem
        there = np.isfinite(values).all(axis=1)
        there &= np.isfinite(found).any(axis=tuple(range(1, found.ndim)))
        work.completed |= set(np.flatnonzero((status == _DONE) & there).tolist())
        known = dict(self._group["failures"].attrs)
        for k in np.flatnonzero(status == _FAILED).tolist():
            code, message, way_out = known.get(str(k), ("BG700", "it failed", ""))
            work.failures[k] = Diagnostic(code, Severity.ERROR, message, help=way_out)
        if "warnings" in self._group:
            work.warned |= read_warnings(dict(self._group["warnings"].attrs))
        return len(work.completed) + len(work.failures)

    def write(self, chunk: Outcome) -> None:
        """Write the runs of a chunk, then their status; BG055 where the disk is full."""
        part = slice(chunk.first, chunk.first + len(chunk.values))
        status = np.full(len(chunk.values), _TO_DO, dtype=np.int8)
        status[list(chunk.completed)] = _DONE
        status[list(chunk.failures)] = _FAILED
        try:
            self._group["parameters"][part] = chunk.values
            if chunk.rows is not None:
                self._group["rows"][part] = self._selection.of(chunk.rows)
            elif "observables" in self._group:
                self._group["observables"][part] = chunk.reduced
            if chunk.failures:
                messages = {
                    str(chunk.first + k): [why.code, why.message, why.help]
                    for k, why in chunk.failures.items()
                }
                self._group["failures"].attrs.update(messages)
            if chunk.warned and "warnings" in self._group:
                warned = {chunk.first + k: some for k, some in chunk.warned.items()}
                self._group["warnings"].attrs.update(written_warnings(warned))
            self._group["status"][part] = status
        except OSError as problem:
            raise BgError([cannot_write(self.path, problem.strerror or str(problem))]) from problem
