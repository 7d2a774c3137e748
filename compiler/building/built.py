"""What a compilation leaves behind: a shared object, and the scene's facts about running it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from bgc.diagnostics.diagnostic import Diagnostic
from bgc.diagnostics.source import Span

if TYPE_CHECKING:  # a warm start does without the compiler's own modules
    from bgc.ir.graph import Requirement, SceneFacts

ENERGY_ACCOUNTS = ("stored", "supplied", "dissipated", "residual")  # as rows of C have them


@dataclass(frozen=True, slots=True)
class Panel:
    """Columns to draw together, against the column `across`: `time`, or another one."""

    columns: tuple[str, ...]
    across: str = "time"


@dataclass(frozen=True, slots=True)
class RunFacts:
    """What a scene says of its run, in plain values; None where it says nothing.

    `columns` are the observed names in the scene's order; those that are no outputs of the
    model are its energy accounts, `stored`, `supplied`, `dissipated` or `residual`, which
    `accounts` lists in the same order. Times are in seconds, `solver_options` are SI numbers.
    `folded` are the parameters that were compiled in, zeros and ones. `requirements` are the
    accuracies asked for, by output, of which some may be no column. `content` tells apart models
    that differ in more than their text: it is a hash of what was compiled. `timed` says whether
    rates or observed powers depend on the time itself. `passive` are the parameters that a run
    should not make negative, each with what it is and of which element.
    """

    scene: str
    model: str
    columns: tuple[str, ...]
    accounts: tuple[str, ...] = ()
    solver: str | None = None
    solver_options: tuple[tuple[str, float], ...] = ()
    step: float | None = None
    duration: float | None = None
    every: float | None = None
    deadline: float | None = None
    panels: tuple[Panel, ...] = ()
    folded: tuple[tuple[str, float], ...] = ()
    requirements: tuple[tuple[str, float], ...] = ()
    content: str = ""
    timed: bool = True
    passive: tuple[tuple[str, str, str], ...] = ()


@dataclass(frozen=True, slots=True)
class Place:
    """What a run may have to point at: in the source, and the states that decide on it."""

    span: Span | None
    states: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Places:
    """Where the assertions and the switches of a model were written, in the order of its tables."""

    assertions: tuple[Place, ...] = ()
    switches: tuple[Place, ...] = ()


@dataclass(frozen=True, slots=True)
class Built:
    """A model that is ready to load. `warm` tells that nothing was compiled for it."""

    library: Path
    facts: RunFacts
    warnings: tuple[Diagnostic, ...] = ()
    warm: bool = False
    places: Places = Places()


def run_facts(
    scene: SceneFacts,
    folded: tuple[tuple[str, float], ...] = (),
    requirements: Sequence[Requirement] = (),
    content: str = "",
    timed: bool = True,
    passive: tuple[tuple[str, str, str], ...] = (),
) -> RunFacts:
    """Take from a scene what its run needs, and note what was folded and what is required."""
    solver = scene.solver
    return RunFacts(
        scene=scene.name,
        model=scene.model,
        columns=scene.columns,
        accounts=scene.accounts,
        solver=solver.name if solver else None,
        solver_options=solver.options if solver else (),
        step=scene.step,
        duration=scene.duration,
        every=scene.every,
        deadline=scene.deadline,
        panels=tuple(Panel(plot.columns, plot.against or "time") for plot in scene.plots),
        folded=folded,
        requirements=tuple((r.name, r.tolerance) for r in requirements),
        content=content,
        timed=timed,
        passive=passive,
    )
