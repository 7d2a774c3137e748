"""The outcome of many runs of a scene: what an ensemble of rows and a study of numbers share."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.arguments import unknown_column
from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.public import public_class
from bgc.record_class import dataclass, field, replace
from bgc.runtime.results.arrays import Array, Mask
from bgc.runtime.results.columns import InUnits, UnknownColumn, dataset
from bgc.runtime.results.files import WrittenAsCsv, write_arrays
from bgc.values.shown_units import Shown

DONE, FAILED, INTERRUPTED = "done", "failed", "interrupted"
_LISTED = 10  # numbers of instances in a warning


class Interrupted(KeyboardInterrupt):
    """Ctrl-C during a run or a study; `result` holds what was done by then, None if nothing was.

    `kept` is true where the next equal call goes on from there. It is a KeyboardInterrupt, so that
    a script with many runs ends as its user expects.
    """

    def __init__(self, message: str, result: Any = None, kept: bool = False) -> None:
        super().__init__(message)
        self.result = result
        self.kept = kept


@public_class
@dataclass(frozen=True, eq=False, repr=False)
class Runs(InUnits, WrittenAsCsv):
    """Runs with their varied parameters and their status; `values` has them in its first axis.

    The attributes are those of `Ensemble` and `Study`.
    """

    scene: str
    solver: str
    parameters: Mapping[str, Array]
    names: tuple[str, ...]
    units: Mapping[str, str]
    values: Array
    status: tuple[str, ...]
    failures: Mapping[int, Diagnostic] = field(default_factory=dict)
    shown: Mapping[str, Shown] = field(default_factory=dict)
    together: int = 0
    alone: str = ""
    warnings: tuple[Diagnostic, ...] = ()
    recalled: int = 0
    run_warnings: Mapping[int, tuple[Diagnostic, ...]] = field(default_factory=dict)

    noun: ClassVar[str]
    """What one of them is called."""

    @property
    def count(self) -> int:
        """The number of runs."""
        return len(self.values)

    @property
    def done(self) -> Mask:
        """Mask of the completed runs, (n,) of bool: an index for `values`."""
        return np.array([status == DONE for status in self.status], dtype=bool)

    @property
    def undone(self) -> str:
        """How many runs were not completed, in words; empty if all were."""
        bad = self.count - self.status.count(DONE)
        return f", {bad} not completed" if bad else ""

    def interrupted(self, kept: bool) -> Interrupted:
        """Make the error of Ctrl-C while these runs went on.

        `kept` says that the next equal call goes on from there.
        """
        done, total = self.status.count(DONE), counted(self.count, self.noun)
        return Interrupted(f"interrupted when {done} of {total} were done", self, kept)

    def placed_failures(self) -> Iterator[Diagnostic]:
        """List the errors, each with the number and the values (SI) of its run."""
        return placed(self.failures, self.parameters)

    def _dataset(
        self, dims: tuple[str, ...], times: Mapping[str, tuple[Array, str]], **about: str
    ) -> Any:
        """An xarray Dataset with a variable for each name over `dims`, of which runs are the first.

        Parameters and status are coordinates; a parameter with the name of another variable is
        `parameter:<name>`.
        """
        found = {name: self.values[..., k] for k, name in enumerate(self.names)}
        taken = {*found, "status", *dims}
        along: dict[str, tuple[Any, str]] = {
            # a column of the same name has the unit
            f"parameter:{name}" if name in taken else name: (
                values,
                "" if name in self.names else self.units.get(name, ""),
            )
            for name, values in self.parameters.items()
        }
        along["status"] = (list(self.status), "")
        coordinates = {"instance": along, "time": times}
        return dataset(found, self.units, dims, coordinates, {**self._about(), **about})

    def _about(self) -> dict[str, str]:
        return {"scene": self.scene, "solver": self.solver}

    def _write_archive(
        self, path: str | Path, arrays: Mapping[str, Any], about: Mapping[str, Any]
    ) -> None:
        """Write what all archives hold, with more arrays and facts."""
        written = self._written()
        facts = {
            **self._about(),
            "units": dict(self.units),
            "failures": {str(k): why.message for k, why in self.failures.items()},
            **about,
        }
        held = {
            "values": self.values[written],
            "instance": np.array(written, dtype=np.int64),
            **arrays,
            "names": np.array(self.names),
            "status": np.array(self.status)[written],
            "about": np.array(json.dumps(facts)),
            **{f"parameter:{name}": v[written] for name, v in self.parameters.items()},
        }
        write_arrays(path, held)

    def _written(self) -> list[int]:
        """The numbers of the runs that files hold: all that ended by themselves."""
        return [k for k, status in enumerate(self.status) if status != INTERRUPTED]


@public_class
@dataclass(frozen=True, eq=False, repr=False)
class ObservedRuns(Runs):
    """Runs of which each leaves numbers; `values` is (n, observables)."""

    design: str = field(default="cases", kw_only=True)

    def __len__(self) -> int:
        return self.count

    def __contains__(self, name: object) -> bool:
        return name in self.names or name in self.parameters

    def __getitem__(self, name: str) -> Array:
        if name in self.names:
            return self.values[:, self.names.index(name)]
        if name in self.parameters:
            return self.parameters[name]
        raise UnknownColumn([unknown_column(name, (*self.names, *self.parameters))])

    def in_words(self, name: str) -> Array:
        """A parameter or an observable in the unit in which it is shown, (n,)."""
        return self[name] / self.shown_in(name).factor


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
