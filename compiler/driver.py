"""The compiler from source to shared object: each pass once, its result under its own name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from time import perf_counter
from typing import ParamSpec, TypeVar

from bgc.building.build import Unit, build_shared_object, lane_runtime_units
from bgc.building.built import Built, run_facts
from bgc.building.cache import digest_of, open_cache
from bgc.building.preview import previewed
from bgc.building.recall import remember
from bgc.building.toolchain import find_toolchain
from bgc.causality.assign import assign_causality
from bgc.diagnostics.diagnostic import BgError, Diagnostic, as_error
from bgc.elaboration.elaborate import elaborate
from bgc.elaboration.scenes.observed import with_accounts
from bgc.elaboration.scenes.scene import stands_alone
from bgc.emission.emit import EmittedModel, content_of, emit_model
from bgc.emission.lanes import lane_units
from bgc.emission.optimise import optimise
from bgc.emission.switches import places_of
from bgc.equations.derive import derive_equations
from bgc.ir.causal import CausalGraph
from bgc.ir.graph import FlatGraph
from bgc.ir.program import Program
from bgc.ir.time_dependence import depends_on_time
from bgc.options import Options
from bgc.passivity.checks import check_physics
from bgc.passivity.coefficients import passive_coefficients
from bgc.resolution.resolve import Package, load
from bgc.slicing.fold import Folding, fold_parameters
from bgc.slicing.slice import slice_program

_Result = TypeVar("_Result")
_Arguments = ParamSpec("_Arguments")


@dataclass
class Compilation:
    """One compilation: the result of each pass, made when it is first asked for.

    `seconds` fills with what each pass took, in the order they ran. Any result raises BgError
    when the model is at fault, with everything its pass found.
    """

    path: Path
    options: Options
    seconds: dict[str, float] = field(default_factory=dict)

    @cached_property
    def package(self) -> Package:
        """The file and all it imports, parsed and with its names."""
        return self._timed("parse", load, self.path)

    @cached_property
    def graph(self) -> FlatGraph:
        """Instances, widths and laws, down to scalar bonds."""
        options = self.options
        graph = self._timed(
            "elaborate",
            elaborate,
            self.package,
            options.scene,
            options.overrides,
            uses=options.uses,
        )
        return with_accounts(graph) if options.audited else graph

    @cached_property
    def oddities(self) -> tuple[Diagnostic, ...]:
        """Warnings of laws that no passive part has."""
        return self._timed("physics", check_physics, self.graph)

    @cached_property
    def folding(self) -> Folding:
        """The graph with the zeros and ones that the scene fixes put in."""
        if self.options.whole:
            return Folding(self.graph, ())
        return self._timed("fold", fold_parameters, self.graph)

    @cached_property
    def causal(self) -> CausalGraph:
        """Strokes, and the independent flows."""
        return self._timed("causality", assign_causality, self.folding.graph)

    @cached_property
    def equations(self) -> Program:
        """The assigned state equations."""
        return self._timed("equations", derive_equations, self.causal)

    @cached_property
    def sliced(self) -> Program:
        """What the scene needs of them."""
        if self.options.whole:
            return self.equations
        return self._timed("slice", slice_program, self.equations)

    @cached_property
    def optimised(self) -> Program:
        """The same, simplified."""
        return self._timed("optimise", optimise, self.sliced)

    @cached_property
    def emitted(self) -> EmittedModel:
        """Its C. Under `strict`, BgError with all warnings there are."""
        if self.options.strict and self.warnings:
            raise BgError([as_error(warning) for warning in self.warnings])
        digest = digest_of([source.text for source in self.package.sources])
        return self._timed("emit", emit_model, self.optimised, digest)

    @cached_property
    def lanes(self) -> tuple[Unit, ...]:
        """The C that runs many instances at once."""
        return (*lane_runtime_units(), *self._timed("lanes", lane_units, self.emitted.lowered))

    @cached_property
    def built(self) -> Built:
        """The shared object in the cache, noted there for a warm start."""
        cache = open_cache()
        units = self.emitted.units
        if self.options.preview:
            units = previewed(units)
        if self.options.lanes:
            units += self.lanes
        library = self._timed("C compiler", build_shared_object, units, find_toolchain(), cache)
        facts = run_facts(
            self.graph.scene,
            self.folding.parameters,
            self.graph.requirements,
            content_of(self.emitted),
            depends_on_time(self.sliced),
            passive_coefficients(self.graph),
        )
        places = places_of(self.emitted.lowered)
        built = Built(library, facts, (*self.warnings, *cache.warnings), places=places)
        remember(cache, self.path, self.options, self.package.sources, built)
        return built

    @property
    def warnings(self) -> tuple[Diagnostic, ...]:
        """What the passes warn of."""
        return (*self.graph.warnings, *self.oddities, *self.causal.warnings)

    def _timed(
        self,
        name: str,
        make: Callable[_Arguments, _Result],
        *arguments: _Arguments.args,
        **named: _Arguments.kwargs,
    ) -> _Result:
        start = perf_counter()
        result = make(*arguments, **named)
        self.seconds[name] = perf_counter() - start
        return result


def compile_source(path: Path, options: Options) -> Built:
    """The shared object of a scene."""
    return Compilation(path, options).built


def check_source(path: Path, scene: str | None = None) -> list[Diagnostic]:
    """All that is wrong with a file's scenes (or one of them), up to their equations.

    Of a file of parts, which has no scene and no model that runs alone, only the syntax, names
    and interfaces are checked.
    """
    try:
        package = load(path)
    except BgError as err:
        return list(err.diagnostics)
    found = list(package.warnings)
    names: Sequence[str | None] = package.scene_names
    if scene is not None:
        names = [scene]
    elif not names and stands_alone(package):
        names = [None]
    for name in names:
        try:
            graph = elaborate(package, name)
            causal = assign_causality(fold_parameters(graph).graph)
            derive_equations(causal)
            found += (*graph.warnings, *check_physics(graph), *causal.warnings)
        except BgError as err:
            found += err.diagnostics
    return found
