"""Variants of a scene: their choice, and their measurement against the unchanged scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path

from bgc.diagnostics.catalogue.arguments import bad_assignment
from bgc.diagnostics.catalogue.trade import no_such_slot
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import compile_scene
from bgc.elaboration.scenes.variants import Change, variants_of, with_changes
from bgc.language.methods import METHODS
from bgc.options import Options
from bgc.runtime.activity.activity import activity_report
from bgc.runtime.activity.simplifications import stored_variants
from bgc.runtime.measuring.session import changed_model
from bgc.runtime.measuring.timed_run import reason_of
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.trade.configurations import Configuration, Variant
from bgc.runtime.trade.judge import Target, front
from bgc.runtime.trade.measurement import OUT_OF_BUDGET, REFUSED, SKIPPED, Measurement
from bgc.runtime.trade.reference_solution import Reference
from bgc.runtime.trade.trade_session import TradeSession

ALL, ACTIVITY = "all", "activity"
_ACTIVITY_SHARE = 0.25  # of the budget, to find simplifications of the scene


def chosen_variants(session: TradeSession, patterns: Sequence[str]) -> tuple[Variant, ...]:
    """Choose variants by the patterns that a user gives.

    `crane.elbow.lock` is one slot, and `all` each slot by itself. A pattern with `*` fills all
    matching slots together, with each type that fits all of them. `activity` stands for the
    simplifications that `bgc activity` finds; statements with `=` are used literally:
    `use crane.elbow.lock = Rigid[5]; set handle.damping = 0`.

    Raises
    ------
    BgError
        BG064 for a malformed statement, BG093 if no slot with another fitting type matches a
        pattern, and the errors of elaboration.
    """
    path, options = session.model.source_for("variants")
    by_slot = _types_by_slot(path, options)
    found: list[Variant] = []
    for pattern in patterns:
        if "=" in pattern:
            lines = _lines(pattern)
            # Report errors in the statements now.
            compile_scene(path, with_changes(options, lines), until="elaborate")
            found.append(lines)
        elif pattern == ALL and by_slot:
            found += [(Change(slot, type_),) for slot, types in by_slot.items() for type_ in types]
        elif pattern == ACTIVITY:
            found += _simplifications(session)
        else:
            found += _matching(pattern, by_slot)
    return tuple(dict.fromkeys(found))


def _types_by_slot(path: Path, options: Options) -> dict[str, list[str]]:
    stages = compile_scene(path, options, until="elaborate")
    by_slot: dict[str, list[str]] = {}
    for change in variants_of(stages.package, stages.graph):
        by_slot.setdefault(change.name, []).append(change.value)
    return by_slot


def _lines(text: str) -> Variant:
    """Read statements of a scene, `use` or `set`, or `SLOT=TYPE` as for `--use`."""
    changes = []
    for line in filter(None, (part.strip() for part in text.split(";"))):
        word, _, rest = line.partition(" ")
        stated = rest if word in ("use", "set") else line
        name, _, value = (part.strip() for part in stated.partition("="))
        if not (name and value):
            raise BgError([bad_assignment(line, '--variants "use elbow.lock = Rigid[5]"')])
        changes.append(Change(name, value, is_use=word != "set"))
    return tuple(changes)


def _matching(pattern: str, by_slot: dict[str, list[str]]) -> list[Variant]:
    slots = [slot for slot in by_slot if fnmatchcase(slot, pattern)]
    if not slots:
        raise BgError([no_such_slot(pattern, tuple(by_slot))])
    first, *others = (by_slot[slot] for slot in slots)
    common = [type_ for type_ in first if all(type_ in other for other in others)]
    return [tuple(Change(slot, type_) for slot in slots) for type_ in common]


def _simplifications(session: TradeSession) -> tuple[Variant, ...]:
    """Return the stored simplifications of `bgc activity`, or find them now."""
    if (stored := stored_variants(session.model)) is not None:
        return stored
    return activity_report(
        session.model,
        duration=session.duration,
        budget=_ACTIVITY_SHARE * session.budget.seconds,
        progress=session.progress,
    ).variants


def measure_variants(
    session: TradeSession,
    variants: Sequence[Variant],
    rows: Sequence[Measurement],
    reference: Reference,
    target: Target,
) -> tuple[Measurement, ...]:
    """Measure variants with the configurations on the front of the unchanged scene.

    Explicit methods that could not complete the unchanged scene are tried too, since a variant may
    lack its stiff parts; only their informative runs are returned.
    """
    on_front = front(rows, target)
    best = [row.configuration for row in rows if row.configuration in on_front]
    through = {row.configuration.solver for row in rows if target.is_informative(row)}
    explicit = [
        row.configuration
        for row in rows
        if row.configuration.solver in METHODS
        and not METHODS[row.configuration.solver].family.jacobian
    ]
    more = [configuration for configuration in explicit if configuration.solver not in through]
    found: dict[Variant, tuple[Measurement, ...]] = {}
    sessions: dict[Variant, TradeSession] = {}
    took = 0.0
    for variant in variants:
        if session.left <= took:  # compiling takes about as long as the one before
            skipped = _changed(best[:1], variant)
            found[variant] = tuple(Measurement(one, SKIPPED, OUT_OF_BUDGET) for one in skipped)
            continue
        before = session.left
        try:
            sessions[variant] = _session_of(session, variant)
        except BgError as problem:
            refused, why = _changed(best[:1], variant), reason_of(problem)
            found[variant] = tuple(Measurement(one, REFUSED, why) for one in refused)
        took = before - session.left
    for variant, varied in sessions.items():
        found[variant] = varied.measure(_changed(best, variant), reference, target)
    for variant, varied in sessions.items():
        tried = varied.measure(_changed(more, variant), reference, target)
        found[variant] += tuple(row for row in tried if target.is_informative(row))
        found[variant] = varied.repeat(varied.with_worst_times(found[variant], target), target)
    return tuple(row for variant in variants for row in found[variant])


def _changed(configurations: Sequence[Configuration], variant: Variant) -> list[Configuration]:
    return [replace(configuration, changes=variant) for configuration in configurations]


def _session_of(session: TradeSession, variant: Variant) -> TradeSession:
    """Make a session for the scene with changed lines."""
    model = changed_model(session.model, variant)
    return replace(session, model=model, audited=audited(model))


def audited(model: LoadedModel) -> LoadedModel | None:
    """Load the model with energy accounts; None if it has them already or has no source."""
    if model.accounts or model.origin is None:
        return None
    return changed_model(model, audited=True)
