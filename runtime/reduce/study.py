"""The steps of a reduction: references, coarser forms, the search, the method, and the proof."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from copy import copy
from dataclasses import replace
from typing import Any

from bgc.diagnostics.diagnostic import BgError
from bgc.elaboration.scenes.variants import Change
from bgc.language.solver import Solver
from bgc.resolution.scene_digest import scene_digest
from bgc.runtime.activity.powers import activities, below, metered_model
from bgc.runtime.measuring.measured_store import open_store
from bgc.runtime.measuring.session import changed_model
from bgc.runtime.measuring.timed_run import Budget, machine_description, timed_run
from bgc.runtime.reduce.ladders import Elaborations, Ladder, Ladders
from bgc.runtime.reduce.method_choice import MethodChoice
from bgc.runtime.reduce.reduced_scene import ReducedScene
from bgc.runtime.reduce.reduction import ReductionResult, limits, summary
from bgc.runtime.reduce.search import Search
from bgc.runtime.reduce.trial import Case, Trial, Trials
from bgc.runtime.reduce.validity import Validities, Validity
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.progress import StatusLine
from bgc.runtime.trade.measurement import DONE, Measurement
from bgc.runtime.trade.trade_session import TradeSession, open_session

_ENOUGH = 1e-3  # of the requirement: the accuracy of references
_FOR_LADDERS = 0.2  # of the budget, to find the coarser forms
_FOR_VALIDITY = 0.2  # of the budget, to drive parameters
_FOR_METHODS = 0.35  # of the budget, kept from the search for the choice of the method
_MANY = 9  # ladders, from which on activities are worth a compilation


def reduce_scene(
    model: LoadedModel,
    duration: float,
    over: Mapping[str, Any],
    budget: Budget,
    line: StatusLine,
    *,
    fresh: bool = False,
) -> ReductionResult:
    """Reduce a scene within a budget.

    Parameters
    ----------
    model
        The model with its source, whose facts have the requirements.
    duration
        Seconds of the scene.
    over
        Values of parameters in all cases, SI; empty for the scene as it is.
    line
        Says what goes on.
    fresh
        Whether to delete what was kept.

    Raises
    ------
    BgError
        BG092: there is no reference.
    """
    count = len(next(iter(over.values()))) if over else 1
    cases = []
    for k in range(count):
        line.show(f"reference of case {k + 1} of {count}" if over else "reference")
        values = {name: float(column[k]) for name, column in over.items()}
        cases.append(_case(model, values, duration, budget, fresh))
    session = cases[0].session
    elaborations = Elaborations(*model.source_for("variants"))
    trials = Trials(cases, elaborations)
    whole = trials.whole
    line.show("looking for coarser forms")
    found_forms = _ladders(session, elaborations)
    ladders = found_forms.all
    kept = _FOR_METHODS * session.left

    def watch(trial: Trial) -> None:
        line.show(f"{len(trials.tried)} tried, {trial.states} states: error {trial.error:.1e}")

    shares = _shares(session, trials.method, ladders) if len(ladders) >= _MANY else {}
    search = Search(trials, shares, lambda: session.left < kept, watch)
    best = search.run(ladders)
    measurements: tuple[Measurement, ...] = ()
    proof = None
    valid: tuple[Validity, ...] = ()
    if search.stages:
        line.show("choosing the method")
        choice = MethodChoice(cases, elaborations.expanded(best.changes), trials.method)
        measurements = choice.measurements
        line.show("comparing times")
        proof = choice.proof()
        if proof is not None and not proof.is_whole:
            line.show("driving parameters")
            valid = _validities(cases[0], elaborations, choice, trials.method)
    found = ReductionResult(
        scene=model.facts.name or model.facts.model,
        model=model.facts.model,
        machine=machine_description(),
        duration=duration,
        cases=tuple(case.values for case in cases),
        target=cases[0].target,
        reference=cases[0].reference,
        whole=whole,
        tried=tuple(trials.tried.values()),
        stages=tuple(search.stages),
        forms=sum(len(ladder.forms) for ladder in ladders),
        measurements=measurements,
        proof=proof,
        valid=valid,
        reduced=None,
        ended=search.ended or not found_forms.complete,
    )
    return replace(found, reduced=_reduced(found, elaborations, model))


def _case(
    model: LoadedModel, values: Mapping[str, float], duration: float, budget: Budget, fresh: bool
) -> Case:
    """The whole scene with values of parameters, and its reference."""
    own = copy(changed_model(model, (), values)) if values else model
    own.facts = model.facts
    demands = (model.facts.requirements, model.facts.deadline)
    store = open_store(own, "reduce", duration, own.facts.every, demands, fresh=fresh)
    session = open_session(own, duration, budget, store)
    session.enough = _ENOUGH
    reference = session.reference()
    return Case(values, session, reference, session.target(reference))


def _ladders(session: TradeSession, elaborations: Elaborations) -> Ladders:
    """The coarser forms of all parts, kept once they are complete."""
    end = session.left * (1 - _FOR_LADDERS)
    return session.kept(
        Ladders,
        lambda: elaborations.ladders(lambda: session.left < end),
        "ladders",
        final=lambda found: found.complete,
    )


def _shares(
    session: TradeSession, method: Solver, ladders: Sequence[Ladder]
) -> Mapping[str, float]:
    """The shares of the activity of the parts that have coarser forms; none where it fails."""

    def find() -> dict[str, float]:
        with suppress(BgError):
            metered, graph = metered_model(session.model)
            run = timed_run(
                metered, method, session.times, accounts=False, limit=0.1 * session.left
            )
            if run.status == DONE:
                found, _ = activities(metered, graph, session.times, run.rows)
                total = sum(each.activity for each in found) or 1.0
                plain = {ladder.part.replace("[*]", "[1]") for ladder in ladders}
                return {part: (below(found, part) or 0.0) / total for part in plain}
        return {}

    return session.kept(dict[str, float], find, "activity")


def _validities(
    case: Case, elaborations: Elaborations, choice: MethodChoice, method: Solver
) -> tuple[Validity, ...]:
    """Where the reduced scene holds, for as many parameters as a share of the budget allows."""
    session, chosen = case.session, choice.chosen
    assert chosen is not None
    end = max(session.left - _FOR_VALIDITY * session.budget.seconds, 0.0)
    reduced = choice.sessions[0].model
    driven = Validities(case, reduced, method, chosen.method, lambda: session.left < end)
    found: list[Validity] = []
    for drive in driven.drives(elaborations.whole):
        key = (choice.changes, chosen.method, method, drive)
        one = session.store.read(Validity, *key) or driven.of(drive)
        if one is not None:
            session.store.keep(one, *key)
            found.append(one)
    return tuple(found)


def _reduced(
    found: ReductionResult, elaborations: Elaborations, model: LoadedModel
) -> ReducedScene | None:
    """The scene to be written, if there is a proof."""
    proof = found.proof
    if proof is None:
        return None
    package, options = elaborations.package, elaborations.options
    scenes = [s for s in package.root.scenes if options.scene in (None, s.declaration.name)]
    if not scenes:
        return None
    one, other = found.reference.methods
    cases = f" in {len(found.cases)} cases" if len(found.cases) > 1 else ""
    text = (
        f"{summary(found, proof)} Proved by `bgc reduce` by a run over "
        f"{found.duration:g} s{cases}, against a reference on which {one} and {other} agree."
        f"{limits(found.valid)}"
    )
    return ReducedScene(
        path=elaborations.path,
        base=scenes[0].declaration.name,
        digest=scene_digest(package, scenes[0]),
        given=(
            *(Change(name, value) for name, value in options.uses),
            *(Change(name, value, is_use=False) for name, value in options.overrides),
            *(
                Change(name, repr(value), is_use=False)
                for name, value in model.parameters.given({}).items()
            ),
        ),
        changes=elaborations.expanded(found.best.changes),
        solver=proof.method,
        proof=text,
    )
