"""The effect of each parameter on observables of a run, by their derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from bgc.diagnostics.catalogue import counted
from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.catalogue.studies import bad_observable
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.public import public_class
from bgc.language.solver import Solver
from bgc.printing.text_tables import Table
from bgc.record_class import dataclass
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.files import write_rows
from bgc.runtime.results.html import Tabled
from bgc.runtime.results.observables import STEPPED, Observable
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameter_grid import Range
from bgc.runtime.running.sensitivities import directions_of
from bgc.runtime.studies.designs import Designs
from bgc.runtime.studies.followed_runs import FollowedRuns
from bgc.runtime.studies.points import PointRuns
from bgc.values.shown_units import Shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_PER_CENT = 0.01
_MOST_ROWS = 12  # parameters of a table or a plot
_LEAST_SHARE = 1e-4  # of the largest effect on an observable, from which on effects are shown


@public_class
@dataclass(frozen=True, eq=False, repr=False)
class Effects(Tabled):
    """Effects of parameters on observables at the present values of the parameters.

    Attributes
    ----------
    parameters, at
        The parameters and their values, SI.
    observables, values
        The observables and their values, in the units of their columns.
    slopes
        Derivatives of the observables by the parameters, (parameters, observables).
    shown
        The units in which the parameters are shown.
    warnings
        Warnings about the method.
    """

    scene: str
    parameters: tuple[str, ...]
    at: Array
    observables: tuple[Observable, ...]
    values: Array
    slopes: Array
    shown: Mapping[str, Shown]
    warnings: tuple[Diagnostic, ...] = ()

    @property
    def per_cent(self) -> Array:
        """Changes of the observables where a parameter is 1 % larger, (parameters, observables).

        They are those of the linear model, in the units of the columns.
        """
        return np.asarray(_PER_CENT * self.at[:, None] * self.slopes)

    def ranking(self, name: str) -> list[str]:
        """The parameters of an observable, the one of the largest effect first."""
        return [self.parameters[i] for i in self._order(self._place(name))]

    def texts(self, name: str) -> dict[str, str]:
        """The effects on an observable of 1 % of each parameter, with their units."""
        k = self._place(name)
        shown = self.observables[k].shown
        return {
            parameter: f"{shown.number(effect):+.4g} {shown.label}".rstrip()
            for parameter, effect in zip(self.parameters, self.per_cent[:, k], strict=True)
        }

    def tables(self) -> list[Table]:
        """A table for each observable, the parameter of the largest effect first."""
        found = []
        for k, each in enumerate(self.observables):
            size, texts = abs(float(self.values[k])), self.texts(each.name)
            rows = []
            for i in self._largest(k):
                name = self.parameters[i]
                share = self.per_cent[i, k] / size if size > 0 else np.nan
                relative = f"{100 * share:+.3g} %" if np.isfinite(share) else "-"
                rows.append((name, self.shown[name].text(self.at[i]), texts[name], relative))
            title = f"{each.name} = {each.shown.text(float(self.values[k]))}"
            header = ("", "value", "by 1 % more", "of the observable")
            less = len(self.parameters) - len(rows)
            note = f"{counted(less, 'parameter')} with smaller effects, or none" if less else ""
            found.append(Table(title, header, tuple(rows), note, ("of the observable",)))
        return found

    def to_csv(self, path: str | Path) -> None:
        """Write `parameter,value,observable,of,slope,effect`; a line for each pair.

        `effect` is that of 1 %; parameters are SI, observables in the units of their columns.
        """
        rows = (
            (name, self.at[i], each.name, self.values[k], self.slopes[i, k], self.per_cent[i, k])
            for k, each in enumerate(self.observables)
            for i, name in enumerate(self.parameters)
        )
        write_rows(path, ("parameter", "value", "observable", "of", "slope", "effect"), rows)

    def plot(self, path: str | Path | None = None) -> Figure:
        """Draw a tornado: a bar for each parameter and observable; return the figure."""
        # Loads matplotlib.
        from bgc.runtime.studies.plots import plot_effects

        drawn = []
        for k, each in enumerate(self.observables):
            order = self._largest(k)
            names = [self.parameters[i] for i in order]
            changes = self.per_cent[order, k] / each.shown.factor
            drawn.append((each.shown.heading(each.name), names, changes))
        return plot_effects(drawn, self.scene, path)

    def _place(self, name: str) -> int:
        return [each.name for each in self.observables].index(name)

    def _largest(self, k: int) -> list[int]:
        """The parameters that are shown for an observable, the one of the largest effect first."""
        sizes = np.abs(self.per_cent[:, k])
        least = _LEAST_SHARE * sizes.max()
        return [i for i in self._order(k) if sizes[i] > 0 and sizes[i] >= least][:_MOST_ROWS]

    def _order(self, k: int) -> list[int]:
        by_size = np.argsort(-np.abs(self.per_cent[:, k]), kind="stable")
        return [int(i) for i in by_size]


def effects(
    model: LoadedModel,
    method: Solver,
    times: Array,
    observables: Sequence[Observable],
    names: Sequence[str] = (),
    notices: Sequence[Diagnostic] = (),
) -> Effects:
    """Find the effects of parameters; see `Model.effects`."""
    for each in observables:
        if each.function in STEPPED:
            reason = "it changes in steps, so that it has no derivatives"
            raise BgError([bad_observable(each.name, reason)])
    named = [each.name for each in directions_of(model, names) if not each.is_state]
    wanted = named if names else [name for name, each in model.parameters.items() if each.value]
    if not wanted or not observables:
        raise BgError([bad_option("of", "nothing", "a parameter that the run reads", "mass")])
    at = np.array([model.parameters[name].value for name in wanted])
    ranges = tuple(_around(model, name) for name in wanted)
    runs = PointRuns(model, method, times, tuple(observables))
    columns = tuple({each.column: None for each in observables})
    followed = FollowedRuns(runs, tuple(wanted), columns)
    designs = Designs(runs, ranges, {}, 4 * len(wanted) + 8, followed)
    found = designs.slopes(designs.place(at))
    if found is None:
        raise BgError(runs.failures[:1] or [bad_observable(observables[0].name, runs.reason)])
    by = np.array([each.slope(x) for each, x in zip(ranges, at.tolist(), strict=True)])
    return Effects(
        scene=model.facts.name,
        parameters=tuple(wanted),
        at=at,
        observables=tuple(observables),
        values=found.values[0],
        slopes=found.slopes[:, 0] / by[:, None],
        shown={name: model.parameters[name].shown for name in wanted},
        warnings=tuple(notices),
    )


def _around(model: LoadedModel, name: str) -> Range:
    """A range of a parameter around its value, within which differences are taken."""
    info = model.parameters[name]
    size = abs(info.value) or 1.0
    return Range(name, max(info.low, info.value - size), min(info.high, info.value + size))
