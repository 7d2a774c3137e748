"""The model of an FMU: a scene compiled, with the facts of its run and its variables."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from bgc.building.backends import BACKENDS
from bgc.building.build import runtime_directory
from bgc.building.build_result import Built
from bgc.building.cache import digest_of
from bgc.diagnostics.catalogue.fmu_parts import fmu_left_out
from bgc.diagnostics.catalogue.fmus import solver_not_in_fmu
from bgc.diagnostics.diagnostic import BgError
from bgc.driver import Stages, compile_scene
from bgc.emission.c_tables import number, quoted
from bgc.emission.mockup import Mockup, MockupSource, mockup_source
from bgc.emission.prefix import prefix_problem, with_prefix
from bgc.grammar.latin import latin
from bgc.language.methods import METHODS
from bgc.language.solver import Solver
from bgc.options import Options
from bgc.record_class import dataclass, replace
from bgc.runtime.fmi.fmu_inputs import ChosenInputs
from bgc.runtime.fmi.fmu_variables import Table, arrays_of, variable_table
from bgc.runtime.fmi.model_description import Description
from bgc.runtime.fmi.structure import Structure, model_structure, tunable_parameters
from bgc.runtime.results.arrays import Array
from bgc.runtime.running.loaded_model import LoadedModel
from bgc.runtime.running.run import choose_method, option_values, with_capped_step
from bgc.runtime.running.simulate import times_of

_LONGEST_IDENTIFIER = 60


@dataclass(frozen=True)
class FmuModel:
    """A scene ready for export as an FMU of one version of the standard."""

    version: int
    stages: Stages
    loaded: LoadedModel
    method: Solver
    table: Table
    structure: Structure
    description: Description
    source: MockupSource

    @property
    def built(self) -> Built:
        """The shared object of the scene, which `bgc run` uses."""
        return self.stages.built


def prepare_model(
    file: Path, options: Options, version: int, inputs: Sequence[str] = ()
) -> FmuModel:
    """Compile a scene, and write the C source and the variables of its FMU.

    `inputs` are inputs of models, sources or parameters that become inputs of the FMU, besides the
    channels of devices.

    The FMU's solver is that of the scene. A start at rest and settled fast modes are found here:
    the FMU starts from the states that they have at the present values of the parameters.
    """
    chosen = ChosenInputs(inputs)
    if inputs:
        options = replace(options, inputs=tuple(inputs))
        stages = compile_scene(file, options, prepare=chosen.applied_to, until="equations")
        chosen.check(stages.equations)
        stages = compile_scene(file, options, prepare=ChosenInputs(inputs).applied_to)
    else:
        stages = compile_scene(file, options)
    loaded = LoadedModel(stages.built, file.absolute().parent, (file, options))
    facts = loaded.facts
    if facts.solver.name in BACKENDS:
        raise BgError([solver_not_in_fmu(facts.solver.name, tuple(METHODS))])
    if facts.fmus:
        way = "export the rest of the model, and join both in a system of FMUs"
        raise BgError([fmu_left_out("an FMU", facts.fmus[0].name, way)])
    method = choose_method(loaded.library, facts)
    if facts.duration is not None:
        method = with_capped_step(method, times_of(loaded, method), facts.timed)
    program = stages.lowered.program
    parameters, start, scale = _starting_point(loaded, method)
    tunable = tunable_parameters(program)
    indicators = len(stages.lowered.switches) if version == 3 else 0
    table = variable_table(
        stages.optimised, parameters, tunable, facts.accounts, indicators, chosen, version == 2
    )
    table = _with_nominals(table, scale)
    structure = model_structure(stages.lowered, table, start is not None)
    identifier = identifier_of(file, options.scene)
    counts = _counts(table, version)
    text = repr((table, structure, method, counts, version))
    token = digest_of([stages.emitted.source_hash, text])
    source_key = token
    token = "-".join((token[:8], token[8:12], token[12:16], token[16:20], token[20:]))
    token = f"{{{token}}}"
    derivatives = not _couples(table, stages)
    mockup = Mockup(
        version=version,
        token=token,
        options=_options(method, bool(loaded.accounts)),
        input_start=tuple(v.start or 0.0 for v in table.of("input")),
        start=() if start is None else tuple(start.tolist()),
        tunable=tunable,
        free_states=table.free,
        accounts=bool(loaded.accounts),
        derivatives=derivatives,
        counts=counts,
    )
    source = mockup_source(stages.emitted, mockup, runtime_directory())
    prefix = f"m{source_key}" if prefix_problem(identifier, source.text) else identifier
    source = replace(source, text=with_prefix(source.text, prefix))
    interval = facts.every or (facts.duration / 1000 if facts.duration else None)
    description = Description(
        name=identifier,
        identifier=identifier,
        token=token,
        text=f"Scene {facts.name} of the bond graph model {facts.model}.",
        tool=_tool(),
        duration=facts.duration,
        tolerance=None if method.fixed else method.rtol or 1e-6,
        interval=method.step if method.fixed else interval,
        indicators=len(stages.lowered.switches),
        derivatives=derivatives,
    )
    return FmuModel(version, stages, loaded, method, table, structure, description, source)


def _tool() -> str:
    # The metadata of the installed package take some milliseconds.
    from importlib.metadata import version

    return f"bgc {version('bgc-lang')}"


def _couples(table: Table, stages: Stages) -> bool:
    """Return whether a mass matrix couples states that follow from algebraic equations."""
    states = stages.lowered.program.states
    return len(table.free) == len(states) and any(s.kind == "algebraic" for s in states)


def _starting_point(loaded: LoadedModel, method: Solver) -> tuple[list[float], Array | None, Array]:
    """Values of all parameters, the states of a start that is searched for, and their scales."""
    facts = loaded.facts
    rests = facts.rest_for(method.start) is not None
    if rests or method.settle or facts.solver.settle:
        with loaded.started(method, bool(loaded.accounts)) as instance:
            size = instance.library.model.n_param
            values = [instance.parameter(k) for k in range(size)]
            return values, instance.start_values(), np.array(instance.scale)
    instance = loaded.instance_at(None, 0.0)
    values = [instance.parameter(k) for k in range(instance.library.model.n_param)]
    return values, None, np.array(instance.scale)


def _with_nominals(table: Table, scale: Array) -> Table:
    scales = scale.tolist()
    return replace(
        table,
        variables=tuple(
            replace(v, nominal=scales[v.index]) if v.kind == "state" else v for v in table.variables
        ),
    )


def _counts(table: Table, version: int) -> tuple[int, ...]:
    """The numbers behind each value reference."""
    counts = [1] * len(table.variables)
    if version == 3:
        for array in arrays_of(table):
            for component in array.components:
                counts[component.reference] = 0
            counts[array.variable.reference] = len(array.components)
    return tuple(counts)


def _options(method: Solver, accounts: bool) -> tuple[tuple[str, str], ...]:
    """The fields of `bgc_options` with C texts."""
    values = option_values(method, accounts)
    texts = ((name, number(v) if isinstance(v, float) else str(v)) for name, v in values.items())
    return (("name", quoted(method.name)), *texts)


def identifier_of(file: Path, scene: str | None) -> str:
    """Return a name for files and C functions: letters, digits and single underscores."""
    text = file.stem if scene is None or scene == file.stem else f"{file.stem}_{scene}"
    words = re.findall(r"[A-Za-z0-9]+", latin(text))
    name = "_".join(words)[:_LONGEST_IDENTIFIER].strip("_")
    return name if name and name[0].isalpha() else f"fmu_{name}".strip("_")
