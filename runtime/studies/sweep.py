"""A sweep: many runs of a model over values of its parameters, or observables of them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeAlias

import numpy as np

from bgc.building.recall import processors
from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.language.solver import Solver
from bgc.record_class import dataclass, field
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.ensemble import Ensemble
from bgc.runtime.results.observables import (
    Observable,
    read_observables,
)
from bgc.runtime.results.statistics import check_enough
from bgc.runtime.results.study import Study
from bgc.runtime.results.study_kinds import check_kind
from bgc.runtime.running.batches import Outcome
from bgc.runtime.running.cases import checked_cases
from bgc.runtime.running.csv_tables import read_cases
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.many import (
    Plan,
    lane_library,
    outcome,
    plan_many,
    run_many,
)
from bgc.runtime.running.parameter_grid import Axis, Listed, points, read_axis
from bgc.runtime.running.parameters import Parameters, ParameterValue
from bgc.runtime.running.progress import ProgressBar
from bgc.runtime.running.quantity import read_quantity
from bgc.runtime.running.requirements import observed_columns
from bgc.runtime.studies.chunks import Waiting, locally
from bgc.runtime.studies.study_store import Store

Vary: TypeAlias = Mapping[str, str | Sequence[float | str] | Array] | Sequence[str]
"""Values by parameter: `{"m": "1..4 kg:4", "k": [1, 2, "5 N/m"]}`, or `["m=1..4 kg:4"]`."""


@dataclass(frozen=True, slots=True)
class Design:
    """The points of a sweep: axes, and the way in which points are taken from them.

    `sample` is the number of points of a `latin` or `sobol` sample, or of the base points of a
    `saltelli` one; None for all combinations of the values. `cases` is a CSV file of given points,
    each of which is combined with all combinations of the axes.
    """

    vary: Vary = field(default_factory=dict)
    sample: int | None = None
    design: str = "latin"
    seed: int = 0
    cases: str | Path | None = None

    @property
    def name(self) -> str:
        """`grid`, `cases`, or the design of the sample."""
        if self.sample is not None:
            return self.design
        return "cases" if self.cases is not None else "grid"

    def values(self, parameters: Parameters) -> dict[str, Array]:
        """The values of all runs by parameter, SI.

        Raises BgError: BG743 to BG745, BG788, BG066, and those of a wrong name, unit or number.
        """
        if self.sample is not None and self.sample < 1:
            raise BgError([bad_option("sample", self.sample, "a positive whole number", "64")])
        if self.design == "saltelli" and self.sample is None:
            wanted = "given with a sample, the number of base points"
            raise BgError([bad_option("design", self.design, wanted, "sample 256")])
        given = read_cases(self.cases, parameters) if self.cases is not None else None
        return points(read_axes(self.vary, parameters), self.sample, self.design, self.seed, given)


def check_reports(model: LoadedModel, chosen: Design, kind: str | None, rank: bool) -> None:
    """Raise BG066, before any run, for a plot or a ranking that the points do not permit."""
    values = chosen.values(model.parameters)
    if kind is not None:
        check_kind(kind, len(values))
    if rank:
        runs = len(next(iter(values.values()), ()))
        check_enough(runs // (len(values) + 2) if chosen.name == "saltelli" else runs)


def read_axes(vary: Vary, parameters: Parameters) -> list[Axis]:
    """Read the axes of a sweep from texts, or from a mapping of texts and lists."""
    if not isinstance(vary, Mapping):
        return [read_axis(text, parameters.unit_of) for text in vary]
    axes: list[Axis] = []
    for name, value in vary.items():
        if isinstance(value, str):
            axes.append(read_axis(f"{name}={value}", parameters.unit_of))
        else:
            listed = np.atleast_1d(np.asarray(value, dtype=object))
            numbers = (_number(each, name, parameters) for each in listed)
            axes.append(Listed(name, tuple(numbers)))
    return axes


def _number(value: ParameterValue, name: str, parameters: Parameters) -> float:
    (number,) = parameters.checked(name, value).values()
    return number


def observables_of(model: LoadedModel, texts: Sequence[str]) -> tuple[Observable, ...]:
    """Read observables of the columns of a scene; see `read_observables`."""
    return read_observables(texts, observed_columns(model), read_quantity)


def sweep(
    model: LoadedModel,
    design: Design,
    method: Solver,
    times: Array,
    observables: Sequence[Observable] = (),
    *,
    progress: bool = False,
    notices: Sequence[Diagnostic] = (),
    resume: bool = False,
    vectorised: bool = True,
    scheduler: str | None = None,
    store: str | Path | None = None,
) -> Ensemble | Study:
    """Run all points of a design; see `Model.sweep`.

    With a scheduler or a store, the runs go in chunks of about a second, which are written as they
    are done. After Ctrl-C or the end of this process, the same call goes on with what is missing.
    """
    cases = checked_cases(design.values(model.parameters), model.parameters)
    plan = plan_many(model, method, cases, times, vectorised, tuple(observables))
    if scheduler is None and store is None:
        return run_many(plan, progress, notices, resume, design.name)
    work = plan.work(None)
    kept = Store(store, plan, design.name) if store is not None else None
    recalled = kept.load(work) if kept is not None else 0
    count = len(cases)
    ended = work.completed | work.failures.keys()
    waiting = Waiting(count, [k in ended for k in range(count)])
    try:
        with ProgressBar(float(count), progress, unit=" instances") as bar:
            for chunk in _chunks(plan, scheduler, waiting):
                work.add(chunk)
                if kept is not None:
                    kept.write(chunk)
                bar.show(float(len(work.completed) + len(work.failures)))
    except KeyboardInterrupt:
        work.stopping = True
    return outcome(plan, work, notices, design.name, recalled, kept is not None)


def _chunks(plan: Plan, scheduler: str | None, waiting: Waiting) -> Iterator[Outcome]:
    """Run what is waiting on the workers of a scheduler, or on this machine's processors."""
    if scheduler is not None:
        # Only this needs Dask.
        from bgc.runtime.studies.cluster import on_cluster

        return on_cluster(plan, scheduler, waiting)
    library = None if plan.alone or not waiting else lane_library(plan.model)
    return locally(plan, library, waiting, processors())
