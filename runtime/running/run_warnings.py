"""Warnings about runs, which their results carry beside those of the compiler."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from bgc.diagnostics.catalogue.accuracy import (
    limited_by_rounding,
    samples_over_budget,
    step_too_long,
)
from bgc.diagnostics.catalogue.closures import moved_positions, named_moves
from bgc.diagnostics.catalogue.physics import negative_value
from bgc.diagnostics.diagnostic import Diagnostic, Severity
from bgc.language.solver import Solver
from bgc.runtime.results.arrays import Array
from bgc.runtime.results.result import balance_warnings, joules
from bgc.runtime.running.binding import Instance
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.port_bounds import port_diagnostics

_ROUNDED = 0.25  # of the steps examined: rounding limits them in a large part of the run


def run_warnings(model: LoadedModel, instance: Instance, method: Solver) -> Iterator[Diagnostic]:
    """Warn of parameters set to negative values, of steps too long, and of rounding.

    The codes are BG460; BG719 and BG730; BG731.
    """
    yield from turned_negative(model, instance)
    yield from step_warnings(model, instance.counts, method)


def start_warnings(model: LoadedModel, instance: Instance, method: Solver) -> Iterator[Diagnostic]:
    """Warn of sampled ports, and of given positions that close no chain, at the start of a run.

    The codes are those of `port_diagnostics`, and BG551 where the compiler has not given it.
    """
    yield from port_diagnostics(instance, model.facts, model.places)
    if instance.library.has_chains and model.facts.rest_for(method.start) is None:
        names = (state.name for state in model.states)
        units = (state.unit for state in model.states)
        given, moves = model.facts.resting.given, instance.closing_moves()
        shown = named_moves(zip(map(float, moves), given, names, units, strict=True))
        if shown:
            warning = moved_positions(shown)
            if warning.message not in {known.message for known in model.warnings}:
                yield warning


def turned_negative(model: LoadedModel, instance: Instance) -> Iterator[Diagnostic]:
    """Warn of parameters of an instance that are set to negative values (BG460)."""
    for name, what, element in model.facts.passive:
        value = model.parameters.turned_negative(instance, name)
        if value is not None:
            yield negative_value(None, element, what, value, f", as `{name}` is given")


def step_warnings(
    model: LoadedModel, counts: Mapping[str, float], method: Solver
) -> Iterator[Diagnostic]:
    """Warn of the steps of a run by its counts: BG719, BG730, BG731."""
    if counts["largest_correction"] > 0:
        state = model.states[int(counts["correction_state"])].name
        yield step_too_long(
            counts["correction_time"], state, counts["largest_correction"], method.step
        )
    if counts["rounding"] >= max(2, _ROUNDED * counts["rounding_samples"]):
        yield limited_by_rounding(int(counts["rounding"]), int(counts["rounding_samples"]))
    if counts["over_budget"]:
        yield samples_over_budget(
            int(counts["over_budget"]),
            method.step,
            method.parts,
            counts["excess_time"],
            counts["largest_excess"],
        )


def energy_warnings(
    model: LoadedModel, times: Array, rows: Array, exchanged: float
) -> Iterator[Diagnostic]:
    """Warn of energies that do not balance (BG716), as `Result.warnings` does.

    `rows` are those at `times`, s, (n, m); `exchanged` is the energy exchanged, J.
    """
    if (name := model.accounts.get("residual")) is not None:
        places = (k for k, variable in enumerate(model.outputs) if variable.name == name)
        place = next(places)
        residual = joules(model.selection().column(rows, place), model.outputs[place].unit)
        yield from balance_warnings(times, residual, exchanged)


def written_warnings(
    warned: Mapping[int, Sequence[Diagnostic]],
) -> dict[str, list[list[str]]]:
    """Write the warnings of runs by number as lists of texts, for files."""
    return {str(k): [[w.code, w.message, w.help] for w in some] for k, some in warned.items()}


def read_warnings(
    written: Mapping[str, Sequence[Sequence[str]]],
) -> dict[int, tuple[Diagnostic, ...]]:
    """Read the warnings that `written_warnings` has written."""
    return {
        int(k): tuple(
            Diagnostic(code, Severity.WARNING, message, help=way_out)
            for code, message, way_out in some
        )
        for k, some in written.items()
    }


def negative_among(
    model: LoadedModel, varied: Sequence[str], values: Array
) -> Iterator[Diagnostic]:
    """Warn of parameters that are negative in some of several runs (BG460).

    `values` are those of the `varied` parameters, (runs, varied); each diagnostic has the lowest.
    """
    common = model.parameters.given({})
    for name, what, element in model.facts.passive:
        if model.parameters.default_of(name) < 0:
            continue
        if name in varied:
            of_runs = values[:, list(varied).index(name)]
            negative = of_runs[of_runs < 0]
            if len(negative):
                some = f" in {len(negative)} of {len(of_runs)} runs" if len(of_runs) > 1 else ""
                lowest = float(negative.min())
                yield negative_value(None, element, what, lowest, f", as `{name}` is given{some}")
        elif (value := common.get(name, 0.0)) < 0:
            yield negative_value(None, element, what, value, f", as `{name}` is given")
