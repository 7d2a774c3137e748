"""`bgc.trade`: run a scene with many methods and settings, and recommend the cheapest."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from bgc.building.backends import BACKENDS
from bgc.diagnostics.catalogue.arguments import bad_option, unknown_solver
from bgc.diagnostics.catalogue.trade import nothing_to_measure
from bgc.diagnostics.diagnostic import BgError
from bgc.diagnostics.public import public_class, public_function
from bgc.language.methods import METHODS, SWITCHING, SWITCHING_FIXED
from bgc.language.solver import Solver
from bgc.printing.text_tables import Table
from bgc.runtime.measuring.judging import duration_of
from bgc.runtime.measuring.measured_store import open_store
from bgc.runtime.measuring.timed_run import Budget, machine_description
from bgc.runtime.results.html import figure_html, table_html
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.parameters import ParameterValue
from bgc.runtime.running.quantity import Quantity, in_si
from bgc.runtime.running.recommendation import keep_recommendation
from bgc.runtime.trade.configurations import (
    KEEPS,
    RTOLS,
    scene_configurations,
)
from bgc.runtime.trade.goal import loaded_model, requirers, with_goal
from bgc.runtime.trade.judge import Target, judge
from bgc.runtime.trade.measured_variants import ACTIVITY, audited, chosen_variants, measure_variants
from bgc.runtime.trade.measurement import OUT_OF_BUDGET, Measurement
from bgc.runtime.trade.reference_solution import Reference
from bgc.runtime.trade.trade_result import TradeResult
from bgc.runtime.trade.trade_session import (
    FOR_REPETITIONS,
    FOR_VARIANTS,
    REPEATS,
    open_session,
)
from bgc.runtime.trade.trade_tables import records, write_csv

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BUDGET = 300.0  # s


@public_class
class Trade(TradeResult):
    """A trade study of a scene, to be printed, drawn and written.

    Attributes are those of `TradeResult`.
    """

    @property
    def table(self) -> list[dict[str, Any]]:
        """A row for each configuration, as `to_csv` writes them; times in s, errors in SI units."""
        return records(self)

    def _repr_html_(self) -> str:
        """The recommendation, the table and the plot."""
        rows = tuple(tuple(_cell(v) for v in row.values()) for row in self.table)
        header = tuple(self.table[0]) if rows else ()
        return table_html(Table(self.sentence, header, rows)) + figure_html(self.plot())

    def to_csv(self, path: str | Path) -> None:
        """Write the table."""
        write_csv(self, path)

    def to_html(self, path: str | Path) -> None:
        """Write one self-contained page: plot, table, reference and machine."""
        # Loads matplotlib, which most trades do without.
        from bgc.runtime.trade.trade_page import write_page

        write_page(self, path)

    def plot(self, path: str | Path | None = None) -> Figure:
        """Draw error against time, with the Pareto front; written where a path is given."""
        # Loads matplotlib, which most trades do without.
        from bgc.runtime.trade.work_precision import plot_trade

        return plot_trade(self, path)


def _cell(value: object) -> str:
    if value is None:
        return ""
    return f"{value:.3g}" if isinstance(value, float) else str(value)


@public_function
def trade(
    model: str | Path | LoadedModel,
    scene: str | None = None,
    *,
    parameters: Mapping[str, ParameterValue] | None = None,
    uses: Mapping[str, str] | None = None,
    solvers: Sequence[str] | None = None,
    rtols: Sequence[float] = RTOLS,
    steps: Sequence[Quantity] | None = None,
    keeps: Sequence[float] = KEEPS,
    variants: Sequence[str] = (),
    within: Mapping[str, Quantity] | None = None,
    deadline: Quantity | None = None,
    faster_than: float = 0.0,
    duration: Quantity | None = None,
    budget: Quantity = BUDGET,
    repeats: int = REPEATS,
    fresh: bool = False,
    progress: bool = False,
) -> Trade:
    """Measure speed against accuracy of a scene over methods and settings.

    Earlier measurements of the same scene on the same machine are taken from the cache; the
    recommendation is stored there for `solver auto`.

    Devices are sampled at the scene's step, so that all configurations see the same inputs. A
    longer fixed step takes fewer samples, which counts as its error, and is never recommended.

    Parameters
    ----------
    model, scene
        A `.bg` file and its scene, by default the first; or a model.
    parameters, uses
        As for `bgc.compile`.
    solvers
        Methods; by default all, and the installed external solvers.
    rtols, steps, keeps
        Tolerances of adaptive methods; steps of fixed-step ones, s, by default around the scene's
        step; numbers of steps over which a Jacobian is kept.
    variants
        Variants of the scene to measure: a slot's path, for each type that fits it; a pattern with
        `*` for several slots together; `all` for each slot; `activity` for the simplifications
        that `bgc activity` finds; or statements, `"use link = Joined; set friction = 0"`. Their
        errors are against the unchanged scene. They are measured with the configurations on
        its front, and with explicit methods that could not complete it.
    within, deadline, faster_than
        The goal, beside that of the scene: the largest error of observed columns, `{"tip": "1 mm"}`
        as `require tip within 1 mm;`; the longest time of a step (of a sample of the devices), s;
        and the seconds of the scene for a second of processor time. Measurements serve every goal.
        The recommendation is stored for `solver auto` where the goal is the scene's own.
    duration
        Seconds to simulate; by default the scene's.
    budget
        Seconds for the whole study; configurations beyond it are reported as not run.
    repeats
        The number of runs for the median times of configurations on or near the front.
    fresh
        Whether to delete earlier measurements.
    progress
        Whether to show a progress bar on a terminal.

    Raises
    ------
    BgError
        The model or an argument is at fault; BG091 if the scene observes nothing, BG092 if there
        is no reference.
    """
    duration, budget = in_si(duration, "duration", "s"), in_si(budget, "budget", "s") or 0.0
    deadline = in_si(deadline, "deadline", "s")
    lengths = () if steps is None else [in_si(step, "steps", "s") or 0.0 for step in steps]
    clock = Budget(budget)
    loaded = loaded_model(model, scene, parameters, uses)
    asked = with_goal(loaded, within or {}, deadline)
    own_goal = asked.facts == loaded.facts and not faster_than
    required_by, loaded, facts = requirers(loaded, asked), asked, asked.facts
    end = duration_of(loaded, duration, nothing_to_measure)
    _check(rtols, lengths, keeps, budget, deadline, faster_than)
    adaptive, fixed = adaptive_and_fixed(loaded, solvers)
    store = open_store(loaded, end, facts.every, fresh=fresh)
    session = open_session(loaded, end, clock, store, repeats=repeats, progress=progress)
    session.audited = audited(loaded)
    others = chosen_variants(session, variants) if variants else ()
    reference = session.reference()
    target = replace(session.target(reference), faster_than=faster_than, required_by=required_by)
    ladder = session.step_ladder(reference) if steps is None and fixed else tuple(lengths)
    configurations = scene_configurations(
        adaptive,
        fixed,
        rtols,
        ladder,
        [int(keep) for keep in keeps],
        explicit=[name for name in fixed if not METHODS[name].family.jacobian],
    )
    session.reserve_share(FOR_VARIANTS if others else FOR_REPETITIONS)
    rows = session.measure(configurations, reference, target)
    rows = session.repeat(session.with_worst_times(rows, target), target)
    if others:
        session.reserve_share(FOR_REPETITIONS)
        rows += measure_variants(session, others, rows, reference, target)
    verdict = judge(rows, target)
    complete = end == facts.duration
    best = verdict.recommended
    if complete and own_goal and reference.converged:
        with session.store.noted():
            method = best.configuration.method if best is not None else None
            keep_recommendation(session.store.folder, loaded, method)
    warnings = _warnings(reference, target, rows, complete)
    if complete and not own_goal:
        warnings.append("the goal is not that of the scene: nothing is stored for `solver auto`")
    if ACTIVITY in variants and not others:
        warnings.append("`activity`: no simplification of the scene was found")
    if session.store.problem:
        warnings.append(f"some measurements could not be stored: {session.store.problem}")
    return Trade(
        scene=facts.name or facts.model,
        model=facts.model,
        machine=machine_description(),
        duration=end,
        measurements=rows,
        target=target,
        reference=reference,
        verdict=verdict,
        complete=complete,
        warnings=tuple(warnings),
    )


def _check(
    rtols: Sequence[float],
    steps: Sequence[float],
    keeps: Sequence[float],
    budget: float,
    deadline: float | None,
    faster_than: float,
) -> None:
    """Raise BG066 for numbers that are not positive, or not whole where they must be."""
    named = {"rtols": rtols, "steps": steps, "keep": keeps, "budget": (budget,)}
    named["deadline"] = () if deadline is None else (deadline,)
    named["faster_than"] = (faster_than,) if faster_than else ()
    for name, values in named.items():
        for value in values:
            if not value > 0:
                raise BgError([bad_option(name, value, "a positive number")])
    for keep in keeps:
        if keep != int(keep):
            raise BgError([bad_option("keep", keep, "a whole number", "5")])


def adaptive_and_fixed(
    model: LoadedModel, solvers: Sequence[str] | None
) -> tuple[list[str], list[str]]:
    """Divide the requested methods, by default all, into adaptive and fixed-step ones.

    `switching` and `switching_fixed` are among them by default where they differ from `rodas5p` and
    `ros34prw`.
    """
    known = (*model.solvers, *BACKENDS)
    for name in solvers or ():
        if name not in known:
            raise BgError([unknown_solver(name, known)])
    differs = model.library.explicit_cost > 0
    usual = [name for name in known if name not in (SWITCHING, SWITCHING_FIXED) or differs]
    chosen = usual if solvers is None else [name for name in known if name in solvers]
    fixed = [name for name in chosen if Solver(name).fixed]
    return [name for name in chosen if name not in fixed], fixed


def _warnings(
    reference: Reference, target: Target, rows: Sequence[Measurement], complete: bool
) -> list[str]:
    found: list[str] = []
    if not reference.converged:
        found.append(
            f"the reference is not converged: {' and '.join(reference.methods)} differ by "
            f"{reference.accuracy:.2g} of {target.scale} at best, so errors mean little and "
            "nothing is stored for `solver auto`; a shorter `--time` may converge, a chaotic scene "
            "never does"
        )
    if not complete:
        found.append("only part of the scene was run: nothing is stored for `solver auto`")
    left = sum(row.message == OUT_OF_BUDGET for row in rows)
    if left:
        found.append(
            f"{left} configurations were not run within the budget: the same command continues"
        )
    return found
