"""Many runs of a model as one labelled array, and its export to files and xarray."""

from __future__ import annotations

import csv
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import numpy as np

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.arguments import unknown_column
from bgc.diagnostics.catalogue.machine import package_missing
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.doors import with_doors
from bgc.runtime.results.arrays import Array, Mask
from bgc.runtime.results.files import write_arrays, written_whole
from bgc.runtime.results.finite import not_finite
from bgc.runtime.results.result import Result, UnknownColumn
from bgc.values.shown import Shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DONE, FAILED, INTERRUPTED = "done", "failed", "interrupted"
_LISTED = 10  # numbers of instances in a warning


@with_doors
@dataclass(frozen=True, eq=False, repr=False)
class Ensemble:
    """Rows of many runs, SI values: an array over instances, times and outputs.

    `ensemble["tip.z"]` is one output of all instances, (n, rows); `ensemble["tip"]` the outputs
    `tip[1]`, `tip[2]`, .. side by side, (n, rows, 3). `len(ensemble)` is n.

    Attributes
    ----------
    scene, solver
        The scene, and the integration method.
    time
        Times of the rows, s, (rows,).
    values
        (n, rows, outputs); NaN in the rows that a run did not reach.
    names, units
        Outputs in the scene's order, and the units of their values.
    parameters
        The varied parameters by name, SI, (n,) each.
    status
        `done`, `failed` or `interrupted`, for each instance.
    failures
        The errors, by the number of the instance (from 0).
    not_finite
        The warnings about instances that are done and have a value that is not finite in their
        rows (BG712), by the number of the instance, as a single run gives them.
    together
        The number of instances computed in the lanes of vector registers, not alone.
    alone
        The reason why all were run one by one; empty where vector registers were used.
    warnings
        Warnings about the method, and of `run_warnings` the first of each code, with the numbers of
        the instances that have one.
    run_warnings
        The warnings about the steps and the energies of instances, as single runs give them, by the
        number of the instance.
    recalled
        The number of instances whose rows an earlier, interrupted call computed.
    shown
        The units as written, in which tables show outputs, as in `Result.shown`.
    """

    scene: str
    solver: str
    time: Array
    values: Array
    names: tuple[str, ...]
    units: Mapping[str, str]
    parameters: Mapping[str, Array]
    status: tuple[str, ...]
    failures: Mapping[int, Diagnostic] = field(default_factory=dict)
    together: int = 0
    alone: str = ""
    warnings: tuple[Diagnostic, ...] = ()
    recalled: int = 0
    shown: Mapping[str, Shown] = field(default_factory=dict)
    run_warnings: Mapping[int, tuple[Diagnostic, ...]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.values)

    def __contains__(self, name: object) -> bool:
        return isinstance(name, str) and bool(self._places(name))

    def __getitem__(self, name: str) -> Array:
        places = self._places(name)
        if not places:
            raise UnknownColumn([unknown_column(name, self.names)])
        if places == [self._place_of(name)]:
            return self.values[:, :, places[0]]
        return self.values[:, :, places]

    def __repr__(self) -> str:
        bad = len(self.status) - self.status.count(DONE)
        ended = f", {bad} not completed" if bad else ""
        end = f"{self.time[-1]:g} s" if len(self.time) else "its start"
        return (
            f"<bgc ensemble of {self.scene}: {counted(len(self), 'instance')}, "
            f"{counted(len(self.time), 'row')} to {end}{ended}>"
        )

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.names)

    def _repr_html_(self) -> str:
        # Only a notebook needs it.
        from bgc.runtime.results.notebook import ensemble_html

        return ensemble_html(self)

    def run(self, number: int) -> Result:
        """Return one instance, from 0, as a result: to plot it, to write it.

        Raises IndexError for a number that no instance has.
        """
        columns = dict(zip(self.names, self.values[number].T, strict=True))
        failure = self.failures.get(number)
        message = failure.message if failure is not None else ""
        return Result(
            self.scene, self.time, columns, self.units, self.solver, {}, self.status[number],
            message, shown=self.shown, notices=self.run_warnings.get(number, ()),
        )  # fmt: skip

    def plot(self, path: str | Path | None = None, columns: Sequence[str] | None = None) -> Figure:
        """Plot columns of all instances against time, a panel for each; return the figure.

        Parameters
        ----------
        path
            The file to write (`.png`, `.svg`, `.pdf`); none by default.
        columns
            Outputs or vectors; by default all, up to 12.
        """
        # Loads matplotlib, which most ensembles do without.
        from bgc.runtime.results.plot import plot_ensemble

        return plot_ensemble(self, path, columns)

    def to_pandas(self) -> Any:
        """Return a pandas DataFrame over `instance` and `time`, with the outputs as columns.

        The varied parameters are levels of the index too; undone rows are NaN.
        """
        try:
            import pandas as pd  # optional, and slow to load
        except ImportError as problem:
            raise BgError([package_missing("pandas", "`to_pandas`", "pandas")]) from problem
        count, rows = len(self), len(self.time)
        given = {name: np.repeat(v, rows) for name, v in self.parameters.items()}
        levels = {"instance": np.repeat(np.arange(count), rows), **given}
        index = pd.MultiIndex.from_arrays(
            [*levels.values(), np.tile(self.time, count)], names=[*levels, "time"]
        )
        return pd.DataFrame(
            self.values.reshape(count * rows, len(self.names)), index=index, columns=self.names
        )

    @cached_property
    def not_finite(self) -> Mapping[int, Diagnostic]:
        """The warnings about values that are not finite, by instance; found when first asked."""
        marked = np.flatnonzero(self.done & ~np.isfinite(self.values).all(axis=(1, 2)))
        found: dict[int, Diagnostic] = {}
        for k in marked.tolist():
            columns = dict(zip(self.names, self.values[k].T, strict=True))
            found[k] = next(not_finite(self.time, columns))
        return found

    @property
    def done(self) -> Mask:
        """Mask of the instances with all their rows, (n,) of bool: an index for `values`."""
        return np.array([status == DONE for status in self.status])

    def _place_of(self, name: str) -> int:
        return self.names.index(name) if name in self.names else -1

    def _places(self, name: str) -> list[int]:
        """Find the columns of an output, or of a vector's components in order."""
        if name in self.names:
            return [self.names.index(name)]
        count = 0
        while f"{name}[{count + 1}]" in self.names:
            count += 1
        return [self.names.index(f"{name}[{k + 1}]") for k in range(count)]

    def expand(self, names: Sequence[str]) -> list[str]:
        """Replace the names of vectors by those of their columns; BG065 for unknown names."""
        found: list[str] = []
        for name in names:
            places = self._places(name)
            if not places:
                raise UnknownColumn([unknown_column(name, self.names)])
            found += [self.names[place] for place in places]
        return found

    def to_csv(self, path: str | Path) -> None:
        """Write a line for each row of each instance: `instance,<parameter>,..,time,<name>,..`.

        Instances that an interruption left undone are omitted; the others keep their numbers.
        """
        with written_whole(path) as aside, aside.open("w", encoding="utf-8", newline="") as file:
            self.write_csv(file)

    def write_csv(self, file: TextIO) -> None:
        """Write as `to_csv` does, to an open file."""
        given = [self.parameters[name].tolist() for name in self.parameters]
        header = ("instance", *self.parameters, "time", *self.names)
        csv.writer(file, lineterminator="\n").writerow(header)
        for k in self._written():
            rows = self.values[k]
            start = ",".join((str(k), *(repr(values[k]) for values in given)))
            for time, row in zip(self.time.tolist(), rows.tolist(), strict=True):
                file.write(f"{start},{time!r},{','.join(map(repr, row))}\n")

    def placed_failures(self) -> Iterator[Diagnostic]:
        """List the errors, each with the number and the values (SI) of its instance."""
        return placed(self.failures, self.parameters)

    def placed_warnings(self) -> Iterator[Diagnostic]:
        """List the warnings about rows, each with the number and the values of its instance."""
        return placed(self.not_finite, self.parameters)

    def to_npz(self, path: str | Path) -> None:
        """Write NumPy's compressed archive: `values`, `time`, `names`, `status` and `about`.

        `instance` has the numbers of the instances; those that an interruption left undone are
        omitted. Each varied parameter is an array `parameter:<name>`. `about` is a JSON text with
        the units, the scene, the solver, the failures, the values that are not finite and the
        warnings about runs.
        """
        about = {
            "scene": self.scene,
            "solver": self.solver,
            "units": {"time": "s", **self.units},
            "failures": {str(k): why.message for k, why in self.failures.items()},
            "not_finite": {str(k): why.message for k, why in self.not_finite.items()},
            "warnings": {
                str(k): [w.message for w in some] for k, some in self.run_warnings.items()
            },
        }
        written = self._written()
        arrays = {
            "values": self.values[written],
            "instance": np.array(written, dtype=np.int64),
            "time": self.time,
            "names": np.array(self.names),
            "status": np.array(self.status)[written],
            "about": np.array(json.dumps(about)),
            **{f"parameter:{name}": v[written] for name, v in self.parameters.items()},
        }
        write_arrays(path, arrays)

    def _written(self) -> list[int]:
        """The numbers of the instances that files hold: all that ended by themselves."""
        return [k for k, status in enumerate(self.status) if status != INTERRUPTED]

    def to_xarray(self) -> Any:
        """An xarray DataArray over `instance`, `time` and `output`.

        The varied parameters and the status are coordinates along `instance`.
        """
        try:
            import xarray as xr  # optional, and slow to load
        except ImportError as problem:
            raise BgError([package_missing("xarray", "`to_xarray`", "xarray")]) from problem
        along: dict[str, Any] = {name: ("instance", v) for name, v in self.parameters.items()}
        return xr.DataArray(
            self.values,
            dims=("instance", "time", "output"),
            coords={
                **along,
                "status": ("instance", list(self.status)),
                "time": self.time,
                "output": list(self.names),
                "unit": ("output", [self.units[name] for name in self.names]),
            },
            name=self.scene,
        )


def placed(
    diagnostics: Mapping[int, Diagnostic], parameters: Mapping[str, Array]
) -> Iterator[Diagnostic]:
    """Add to each diagnostic the number and the values (SI) of its instance."""
    for k, why in diagnostics.items():
        values = ", ".join(f"`{name}` = {parameters[name][k]:.6g}" for name in parameters)
        place = f"in instance {k}, with {values}" if values else f"in instance {k}"
        yield replace(why, note=f"{why.note}\n{place}" if why.note else place)


def gathered(
    warnings: Mapping[int, Sequence[Diagnostic]], parameters: Mapping[str, Array]
) -> Iterator[Diagnostic]:
    """Gather warnings by code: the first of each, with its instance and others that have it."""
    by_code: dict[str, dict[int, Diagnostic]] = {}
    for k in sorted(warnings):
        for each in warnings[k]:
            by_code.setdefault(each.code, {})[k] = each
    for found in by_code.values():
        first, *others = found
        (warning,) = placed({first: found[first]}, parameters)
        if others:
            listed = ", ".join(map(str, others[:_LISTED])) + (", .." if others[_LISTED:] else "")
            also = f"and in {counted(len(others), 'other instance')}: {listed}"
            warning = replace(warning, note=f"{warning.note}\n{also}")
        yield warning


class EnsembleInterrupted(KeyboardInterrupt):
    """Ctrl-C while an ensemble ran; `result` holds the rows computed by then.

    `kept` is true where the next equal call goes on from there.
    """

    def __init__(self, result: Ensemble, kept: bool = False) -> None:
        done = result.status.count(DONE)
        super().__init__(f"interrupted when {done} of {counted(len(result), 'instance')} were done")
        self.result = result
        self.kept = kept
