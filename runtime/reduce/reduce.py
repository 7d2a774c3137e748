"""`bgc.reduce`: leave out of a scene what its requirements do not need, and prove it by runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bgc.diagnostics.catalogue.arguments import bad_option
from bgc.diagnostics.catalogue.studies import nothing_required
from bgc.diagnostics.catalogue.trade import nothing_to_measure
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.public import public_class, public_function
from bgc.runtime.measuring.judging import duration_of
from bgc.runtime.measuring.timed_run import Budget
from bgc.runtime.reduce.reduction import ReductionResult
from bgc.runtime.reduce.reduction_tables import records, write_csv
from bgc.runtime.reduce.study import reduce_scene
from bgc.runtime.results.files import written_whole
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameter_grid import points
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.progress import StatusLine
from bgc.runtime.running.quantity import Quantity, in_si
from bgc.runtime.studies.sweep import Vary, read_axes
from bgc.runtime.trade.goal import loaded_model, requirers, with_goal

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BUDGET = 600.0  # s


@public_class
class Reduction(ReductionResult):
    """A reduction of a scene, to be printed, drawn and written.

    Attributes are those of `ReductionResult`.
    """

    @property
    def table(self) -> list[dict[str, Any]]:
        """A row for each trial, as `to_csv` writes them."""
        return records(self)

    def to_csv(self, path: str | Path) -> None:
        """Write the table."""
        write_csv(self, path)

    def to_bg(self, path: str | Path) -> None:
        """Write the reduced scene as a file that imports the original's.

        Raises ValueError where nothing can be left out.
        """
        if self.reduced is None:
            raise ValueError(self.sentence)
        with written_whole(path) as aside:
            aside.write_text(self.reduced.file(Path(path).parent), encoding="utf-8")

    def to_html(self, path: str | Path) -> None:
        """Write a page with the plot, all tables and the scene."""
        # Loads matplotlib and Jinja2, which most reductions do without.
        from bgc.runtime.reduce.reduction_page import write_page

        write_page(self, path)

    def plot(self, path: str | Path | None = None) -> Figure:
        """Draw error against operations of everything tried; written where a path is given."""
        # Loads matplotlib, which most reductions do without.
        from bgc.runtime.reduce.reduction_plot import plot_reduction

        return plot_reduction(self, path)


@public_function
def reduce(
    model: str | Path | LoadedModel,
    scene: str | None = None,
    *,
    parameters: Mapping[str, ParameterValue] | None = None,
    uses: Mapping[str, str] | None = None,
    within: Mapping[str, Quantity] | None = None,
    over: Vary = (),
    deadline: Quantity | None = None,
    duration: Quantity | None = None,
    budget: Quantity = BUDGET,
    fresh: bool = False,
    progress: bool = False,
) -> Reduction:
    """Find the coarsest form of a scene that meets its requirements, with its method.

    Parts take smaller dimensions and other models in their slots; then a method and its tolerance
    or step are chosen. Each form is run and compared with the whole scene, whose solution is one on
    which two methods agree. What was run is kept in the cache, so that another call continues.

    Parameters
    ----------
    model, scene
        A `.bg` file and its scene, by default the first; or a model with its source.
    parameters, uses
        As for `bgc.compile`.
    within, deadline
        The goal, beside that of the scene, as for `bgc.trade`: the largest error of observed
        columns, and the longest time of a step or a sample, s.
    over
        Values of parameters, as for `bgc.sweep`: the reduced scene is within the requirements for
        all of their combinations.
    duration
        Seconds to simulate; by default the scene's.
    budget
        Seconds for the whole study.
    fresh
        Whether to delete what was kept.
    progress
        Whether to show progress on a terminal.

    Raises
    ------
    BgError
        The model or an argument is at fault; BG661 if nothing is required, BG092 if there is no
        reference.
    """
    clock = Budget(in_si(budget, "budget", "s") or 0.0)
    loaded = loaded_model(model, scene, parameters, uses)
    asked = with_goal(loaded, within or {}, in_si(deadline, "deadline", "s"))
    end = duration_of(asked, in_si(duration, "duration", "s"), nothing_to_measure)
    if not asked.facts.requirements:
        raise BgError([nothing_required(asked.facts.name)])
    if not clock.seconds > 0:
        raise BgError([bad_option("budget", clock.seconds, "a positive number")])
    cases = points(read_axes(over, asked.parameters), None) if over else {}
    with StatusLine(progress) as line:
        found = reduce_scene(asked, end, cases, clock, line, fresh=fresh)
    target = replace(found.target, required_by=requirers(loaded, asked))
    values = {each.name: getattr(found, each.name) for each in fields(found)}
    return Reduction(**{**values, "target": target})
