"""The pipeline from source to shared object, for every command."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from time import perf_counter
from types import MappingProxyType
from typing import Any, Literal, TypeAlias, get_args

from bgc.building.ahead import RuntimeAhead
from bgc.building.backends import BACKENDS
from bgc.building.build import (
    Unit,
    build_shared_object,
    driver_names,
    lane_runtime_units,
    tangent_runtime_units,
)
from bgc.building.build_result import (
    Built,
    Place,
    RunFacts,
    run_facts,
    shapes_text,
    shown_names,
)
from bgc.building.cache import Cache, digest_of
from bgc.building.preview import previewed
from bgc.building.recall import remember
from bgc.building.toolchain import find_toolchain
from bgc.causality.procedure import Procedure, place_in_order
from bgc.diagnostics.catalogue.arguments import unknown_driver, unknown_solver
from bgc.diagnostics.diagnostic import BgError, Diagnostic, Severity, accepted, as_error
from bgc.elaboration.elaborate import check_file_values, elaborate
from bgc.elaboration.scenes.observations import with_accounts
from bgc.elaboration.scenes.scene_choice import models_alone, stands_alone
from bgc.emission.emit import EmittedModel, content_of, emit_lowered
from bgc.emission.lanes import function_unit, lane_units
from bgc.emission.lower import lower
from bgc.emission.simplification import optimise
from bgc.emission.switches import places_of
from bgc.emission.tangents import tangent_units
from bgc.equations.attempts import derive
from bgc.equations.start.given import given_names
from bgc.ir import verify as invariants
from bgc.ir.causal import CausalGraph
from bgc.ir.graph import FlatGraph
from bgc.ir.lowered import Lowered, Switch
from bgc.ir.program import Program
from bgc.ir.time_dependence import depends_on_time
from bgc.language.methods import METHODS
from bgc.language.scene import Rest, Sampled
from bgc.language.scene_tables import AUTO, DRIVER_BY_PATH
from bgc.options import Options
from bgc.passivity.coefficients import passive_coefficients
from bgc.passivity.passive_laws import check_physics
from bgc.record_class import dataclass, replace
from bgc.resolution.modules import Package
from bgc.resolution.resolve import load
from bgc.resolution.scene_digest import check_proof
from bgc.slicing.divisors import with_divisor_checks
from bgc.slicing.fold import Folding, fold_parameters
from bgc.slicing.port_analysis import fmu_facts, force_facts, port_facts
from bgc.slicing.slice import slice_program

Stage: TypeAlias = Literal[
    "parse", "elaborate", "physics", "fold", "causality",
    "equations", "slice", "optimise", "lower", "emit", "C compiler",
]  # fmt: skip
Prepare: TypeAlias = Callable[[FlatGraph], FlatGraph]


@dataclass(frozen=True, init=False)
class Stages:
    """The results of one compilation, up to the last stage that was asked for.

    Attributes
    ----------
    package
        The file and all it imports, parsed and with its names.
    graph
        Instances, widths and laws, down to scalar bonds.
    law_warnings
        Warnings about laws that no passive part has.
    folding
        The graph with the zeros and ones that the scene fixes put in.
    causal
        Strokes and independent flows, by the first choice for which there are equations.
    equations, sliced, optimised
        The assigned state equations, those that the scene needs, and their simplified form.
    lowered, emitted
        The contents of each C function, and its text.
    built
        The shared object.
    warnings
        The warnings of all stages that were run, in their order.
    seconds
        The time that each stage took, in the order of the stages. Equations are derived with the
        causality, whose choice they decide.
    """

    package: Package
    graph: FlatGraph
    law_warnings: tuple[Diagnostic, ...]
    folding: Folding
    causal: CausalGraph
    equations: Program
    sliced: Program
    optimised: Program
    lowered: Lowered
    source_hash: str
    emitted: EmittedModel
    built: Built
    warnings: tuple[Diagnostic, ...]
    seconds: Mapping[str, float]

    def __init__(self, results: Mapping[str, Any]) -> None:
        vars(self).update(results)

    def __getattr__(self, name: str) -> Any:
        raise AttributeError(f"the compilation ended before the stage that makes `{name}`")


def compile_scene(
    path: Path,
    options: Options,
    *,
    prepare: Prepare | None = None,
    package: Package | None = None,
    until: Stage = "C compiler",
    watch: Callable[[Stage], None] | None = None,
) -> Stages:
    """Compile a scene of a file, up to a stage.

    Parameters
    ----------
    path, options
        The file, and the scene with what the user changes about it.
    prepare
        A change of the flat graph, applied after elaboration: other observations or sources.
    package
        The file, if it has been parsed already.
    until
        The last stage to run.
    watch
        Called with each stage as it begins.

    Raises
    ------
    BgError
        The model is at fault; with every independent mistake that the failing stage found.
    """
    results: dict[str, Any] = {}
    seconds: dict[str, float] = {}
    order = get_args(Stage)
    begin = perf_counter()
    with RuntimeAhead() if until == "C compiler" else nullcontext() as ahead:
        stages = _stages(path, options, prepare, package, ahead)
        for place in range(len(order)):
            if watch is not None:
                watch(order[place])
            stage, found = next(stages)
            results.update(found)
            seconds[stage] = perf_counter() - begin
            if options.verify or "BGC_VERIFY" in os.environ:
                for result in found.values():
                    invariants.verify(result)
            if stage == until:
                break
            begin = perf_counter()
    return Stages({"warnings": (), **results, "seconds": MappingProxyType(seconds)})


def strokes_of(
    path: Path, options: Options, package: Package | None = None
) -> tuple[CausalGraph | Procedure, BgError | None]:
    """The causal strokes of a scene; of one that has none, those before a contradiction, and why.

    Raises BgError where the scene has no flat graph.
    """
    try:
        return compile_scene(path, options, package=package, until="causality").causal, None
    except BgError as refusal:
        stages = compile_scene(path, options, package=package, until="fold")
        return place_in_order(stages.folding.graph), refusal


def _stages(
    path: Path,
    options: Options,
    prepare: Prepare | None,
    given: Package | None,
    ahead: RuntimeAhead | None,
) -> Iterator[tuple[Stage, Mapping[str, Any]]]:
    """Run one stage after the other; yield each with its results, by their names in `Stages`."""
    package = given or load(path)
    yield "parse", {"package": package}

    graph = elaborate(
        package,
        options.scene,
        options.overrides,
        options.observe,
        options.uses,
        options.shapes,
        options.inputs,
        options.drives,
    )
    graph = with_accounts(graph) if options.audited else graph
    graph = replace(graph, warnings=(*graph.warnings, *check_proof(package, options.scene)))
    graph = prepare(graph) if prepare else graph
    yield "elaborate", {"graph": graph, "warnings": graph.warnings}

    law_warnings = check_physics(graph)
    warnings = (*graph.warnings, *law_warnings)
    yield "physics", {"law_warnings": law_warnings, "warnings": warnings}

    folding = Folding(graph, ()) if options.whole else fold_parameters(graph)
    yield "fold", {"folding": folding}

    derived = accepted(derive(folding.graph))
    warnings = (*warnings, *derived.causal.warnings)
    yield "causality", {"causal": derived.causal, "warnings": warnings}

    equations = accepted(derived.equations)
    warnings = (*warnings, *equations.warnings)
    yield "equations", {"equations": equations, "warnings": warnings}

    sliced = with_divisor_checks(equations if options.whole else slice_program(equations))
    yield "slice", {"sliced": sliced}

    optimised = optimise(sliced)
    yield "optimise", {"optimised": optimised}

    if options.strict and any(w.severity is Severity.WARNING for w in warnings):
        raise BgError([as_error(warning) for warning in warnings])
    lowered = lower(optimised)
    texts = [source.text for source in package.sources]
    source_hash = digest_of([*texts, *(file.digest for file in graph.data)])
    yield "lower", {"lowered": lowered, "source_hash": source_hash}

    emitted = emit_lowered(lowered, source_hash)
    yield "emit", {"emitted": emitted}

    facts = run_facts(
        graph.scene,
        folded=folding.parameters,
        requirements=tuple((r.name, r.tolerance) for r in graph.requirements),
        content=content_of(emitted),
        timed=depends_on_time(sliced),
        passive=passive_coefficients(graph),
        operations=emitted.operations,
        shown=shown_names(equations),
        resting=_resting(lowered, graph),
        shapes=shapes_text(graph.shapes) if options.shapes else "",
        ports=port_facts(optimised, graph.ports),
        forces=force_facts(optimised, graph.ports, graph.slots),
        slots=tuple((slot.path, slot.filled_by) for slot in graph.slots),
        fmus=fmu_facts(optimised.fmus),
    )
    if (rest := facts.rest) is not None:
        facts = replace(facts, rest=replace(facts.resting, hold=rest.hold, vary=rest.vary))
    assert ahead is not None
    built = build_model(emitted, facts, options, warnings, ahead.cache, ahead)
    ports = tuple(Place(port.span) for port in graph.ports)
    fmus = tuple(Place(fmu.span) for fmu in optimised.fmus)
    built = replace(built, places=replace(built.places, ports=ports, fmus=fmus))
    if prepare is None and given is None:
        data = [(file.path, file.digest) for file in graph.data]
        remember(ahead.cache, path, options, package.sources, built, data)
    yield "C compiler", {"built": built}


def _resting(lowered: Lowered, graph: FlatGraph) -> Rest:
    """Describe the states and switches of a program for a start at rest."""
    program = lowered.program
    momenta = (k for k, state in enumerate(program.states) if state.kind == "momentum")
    ports = tuple(f"{port.name}." for port in graph.ports)
    sampled = (
        Sampled(k, held.name, held.unit)
        for k, held in enumerate(program.held)
        if not held.name.startswith(ports)
    )
    return Rest(
        momenta=tuple(momenta),
        sampled=tuple(sampled),
        stiffness=tuple(state.stiffness for state in program.states),
        given=given_names(graph, [state.name for state in program.states]),
        switches=tuple(_name_of(switch, program) for switch in lowered.switches),
    )


def _name_of(switch: Switch, program: Program) -> str:
    """The element in whose law a switch stands, or whose state it reads alone; empty for others."""
    if switch.timed or switch.owner or len(switch.states) != 1:
        return "" if switch.timed else switch.owner
    (read,) = (state for state in program.states if state.name == switch.states[0])
    return read.stores[0] if len(read.stores) == 1 else read.name


def build_model(
    emitted: EmittedModel,
    facts: RunFacts,
    options: Options,
    warnings: Sequence[Diagnostic],
    cache: Cache,
    ahead: RuntimeAhead | None = None,
) -> Built:
    """Compile emitted C to a shared object in the cache; the runtime may have been begun ahead."""
    units = model_units(emitted, options)
    if ahead is None:
        library = build_shared_object(units, find_toolchain(), cache)
    else:
        library = build_shared_object(units, ahead.toolchain, cache, ahead.ready)
    places = places_of(emitted.lowered)
    return Built(library, facts, (*warnings, *cache.warnings), places=places)


def model_units(emitted: EmittedModel, options: Options) -> tuple[Unit, ...]:
    """The C files of a model, without those of the runtime that all models share."""
    units = previewed(emitted.units) if options.preview else emitted.units
    if options.lanes or options.tangents:
        units += (function_unit(),)
    if options.lanes:
        units += (*lane_runtime_units(), *lane_units(emitted.lowered))
    if options.tangents:
        units += (*tangent_runtime_units(), *tangent_units(emitted.lowered))
    return units


def check_source(path: Path, scene: str | None = None, verify: bool = False) -> list[Diagnostic]:
    """All that is wrong with a file's scenes, or with one of them, up to their equations.

    Without `scene`, complete models that no scene reaches are checked too, and the file's own
    constants and parameters. Of the models of a file of parts, which has no scene and no model that
    runs alone, only the syntax, names and interfaces are checked. `verify` checks the invariants of
    every intermediate result too. Drivers of devices are compared with those of this installation.
    """
    try:
        package = load(path)
    except BgError as err:
        return list(err.diagnostics)
    return check_package(path, package, scene, verify)


def check_package(
    path: Path,
    package: Package,
    scene: str | None = None,
    verify: bool = False,
    *,
    watch: Callable[[Stage], None] | None = None,
    seen: Callable[[Stages], None] | None = None,
) -> list[Diagnostic]:
    """Check a file that was read, as `check_source` does.

    `watch` is called with each stage as it begins, and may end the check by an exception; `seen`
    is called with the stages of each scene and model without an error.
    """
    checked: list[tuple[Package, str | None]]
    if scene is not None:
        checked = [(package, scene)]
    else:
        checked = [(package, name) for name in package.scene_names]
        checked += [(alone, None) for alone in models_alone(package)]
        if not checked and stands_alone(package):
            checked = [(package, None)]
    found = list(package.warnings)
    for reached, name in checked:
        try:
            options = Options(name, verify=verify)
            stages = compile_scene(path, options, package=reached, until="equations", watch=watch)
        except BgError as err:
            only_values = reached is not package and _fills_slots(reached)
            found += [d for d in err.diagnostics if not (only_values and d.code == "BG453")]
        else:
            graph = stages.graph
            found += [*_unknown_method(graph), *_unknown_drivers(graph), *stages.warnings]
            if seen is not None:
                seen(stages)
    if scene is None:
        known = {(d.code, d.span, d.message) for d in found}
        values = check_file_values(package)
        found += [d for d in values if (d.code, d.span, d.message) not in known]
    return found


def _fills_slots(alone: Package) -> bool:
    """Return whether a model implements an interface: it may hold values and nothing to compute."""
    return alone.root.own_models[-1].syntax.base is not None


def _unknown_method(graph: FlatGraph) -> list[Diagnostic]:
    """The error for a method that `bgc run` would not find."""
    name = graph.scene.solver.name
    have = (*METHODS, *BACKENDS)
    known = name in (*have, "", AUTO)
    return [] if known else [unknown_solver(name, have, graph.solver_span)]


def _unknown_drivers(graph: FlatGraph) -> list[Diagnostic]:
    """Errors for devices that `bgc run` could not open; a program may bring drivers of its own."""
    if not graph.devices:
        return []
    have = driver_names()
    return [
        unknown_driver(device.name, device.driver, have, device.span)
        for device in graph.devices
        if device.driver not in (*have, DRIVER_BY_PATH)
    ]
