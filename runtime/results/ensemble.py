"""Many runs of a model as labelled rows, and their export to files, pandas and xarray."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, TextIO

import numpy as np

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.public import public_class
from bgc.record_class import dataclass, field
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.columns import NamedColumns, optional_package
from bgc.runtime.results.files import append_rows
from bgc.runtime.results.result import Result, not_finite
from bgc.runtime.results.runs import Interrupted, Runs, placed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PANELS = 12  # of a plot


@public_class
@dataclass(frozen=True, eq=False, repr=False)
class Ensemble(NamedColumns, Runs):
    """Rows of many runs, SI values: an array over instances, times and outputs.

    A mapping from outputs to their values in all instances, as `Result` is of one run:
    `ensemble["tip.z"]` is (n, rows), `ensemble["tip"]` the vector `tip[1]`, `tip[2]`, .. in its
    shape, (n, rows, 3), and `ensemble["bore"]` the column `bore [bar]`. `ensemble.count` is n.

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

    time: Array = field(kw_only=True)

    noun: ClassVar[str] = "instance"

    def _names(self) -> tuple[str, ...]:
        return self.names

    def _values_of(self, column: str) -> Array:
        return self.values[:, :, self.names.index(column)]

    def __repr__(self) -> str:
        end = f"{self.time[-1]:g} s" if len(self.time) else "its start"
        return (
            f"<bgc ensemble of {self.scene}: {counted(self.count, self.noun)}, "
            f"{counted(len(self.time), 'row')} to {end}{self.undone}>"
        )

    def _repr_html_(self) -> str:
        # Only a notebook needs it.
        from bgc.runtime.results.notebook import ensemble_html

        return ensemble_html(self, self.time)

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

        chosen = self.expand(columns) if columns is not None else self.names[:_PANELS]
        return plot_ensemble(self, self.time, chosen, path)

    def to_pandas(self) -> Any:
        """Return a pandas DataFrame over `instance` and `time`, with the outputs as columns.

        The varied parameters are levels of the index too; undone rows are NaN.
        """
        pd = optional_package("pandas", "`to_pandas`")
        count, rows = self.count, len(self.time)
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

    def write_csv(self, file: TextIO) -> None:
        """Write a line for each row of each instance: `instance,<parameter>,..,time,<name>,..`."""
        given = [self.parameters[name].tolist() for name in self.parameters]
        header = ("instance", *self.parameters, "time", *self.names)
        append_rows(file, header, ())
        for k in self._written():
            rows = self.values[k]
            start = ",".join((str(k), *(repr(values[k]) for values in given)))
            for time, row in zip(self.time.tolist(), rows.tolist(), strict=True):
                file.write(f"{start},{time!r},{','.join(map(repr, row))}\n")

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
            "units": {"time": "s", **self.units},
            "not_finite": {str(k): why.message for k, why in self.not_finite.items()},
            "warnings": {
                str(k): [w.message for w in some] for k, some in self.run_warnings.items()
            },
        }
        self._write_archive(path, {"time": self.time}, about)

    def to_xarray(self) -> Any:
        """Return an xarray Dataset over `instance` and `time`: a variable for each name.

        The varied parameters and the status are coordinates along `instance`.
        """
        return self._dataset(("instance", "time"), {"time": (self.time, "s")})


EnsembleInterrupted = Interrupted
"""An earlier name of `Interrupted`."""
