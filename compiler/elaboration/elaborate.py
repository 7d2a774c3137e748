"""Expand a package and a scene into the flat bond graph, without models, slots and widths."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import replace

from bgc.algebra.dag import Dag
from bgc.diagnostics.catalogue import graph as messages
from bgc.diagnostics.catalogue.names import hides_parameter_of_file
from bgc.diagnostics.catalogue.scenes import device_name_taken
from bgc.diagnostics.collection import Report
from bgc.diagnostics.diagnostic import BgError, Diagnostic
from bgc.diagnostics.source import Span
from bgc.elaboration.bonds.bond_units import BondUnits
from bgc.elaboration.bonds.bond_values import BondValues
from bgc.elaboration.bonds.domains import Domains
from bgc.elaboration.bonds.port_signals import Carried
from bgc.elaboration.bonds.scalarise import Scalars, scalarise
from bgc.elaboration.bonds.widths import join_nets, settle_widths
from bgc.elaboration.bonds.wiring import Wiring, wire
from bgc.elaboration.instances.census import Census
from bgc.elaboration.instances.components import component_name, indices
from bgc.elaboration.instances.instantiate import Builder
from bgc.elaboration.instances.limits import MAX_PARTS
from bgc.elaboration.instances.quantities import Quantities
from bgc.elaboration.instances.tree import Instance, Quantity
from bgc.elaboration.instances.world import Edits, World
from bgc.elaboration.laws.couplings import read_ports
from bgc.elaboration.laws.flat_elements import read_elements
from bgc.elaboration.laws.held_values import read_fmus, read_sampled, refuse_held_early
from bgc.elaboration.laws.statements import (
    collect_assignments,
    collect_definitions,
    evaluate_parameters,
    evaluate_values,
    read_statements,
)
from bgc.elaboration.laws.table_guards import guards_of_tables
from bgc.elaboration.laws.unit_inference import infer_units
from bgc.elaboration.scenes.edits import check_edits, check_overrides, collect_edits
from bgc.elaboration.scenes.observations import Observed, read_observed
from bgc.elaboration.scenes.overrides import with_drives, with_observations, with_uses
from bgc.elaboration.scenes.removed_parts import without_removed
from bgc.elaboration.scenes.rest_statement import StartAtRest, read_start
from bgc.elaboration.scenes.run_facts import read_facts, read_kept, read_requirements
from bgc.elaboration.scenes.scene_choice import Scene, choose_scene
from bgc.elaboration.scenes.scene_devices import read_devices
from bgc.elaboration.scenes.scene_shapes import read_shapes
from bgc.grammar import syntax
from bgc.ir.graph import Bond, DataSource, FlatGraph, Observation, Part, Slot
from bgc.ir.scene_nodes import Requirement
from bgc.options import RUN_NUMBER
from bgc.resolution.modules import Package
from bgc.values.units import shown_of, si_text


def elaborate(
    package: Package,
    scene: str | None = None,
    overrides: Sequence[tuple[str, str]] = (),
    observe: Sequence[str] = (),
    uses: Sequence[tuple[str, str]] = (),
    shapes: bool = False,
    inputs: Sequence[str] = (),
    drives: Sequence[tuple[str, str]] = (),
) -> FlatGraph:
    """Build the flat graph of a scene of the package's root file.

    Parameters
    ----------
    scene
        Name of the scene. None selects the file's first scene or, in a file without scenes, an
        implicit scene that observes all states and outputs of the file's last model.
    overrides
        Pairs of texts from `--set`: new defaults of parameters, or new values of constants, which
        may change the structure.
    observe
        Expressions that replace the scene's observations; empty keeps those of the scene.
    uses
        Slots and the types that fill them, as pairs of texts: `("crane.elbow.lock", "Rigid[5]")`.
    shapes
        Whether to record the poses of all shapes, as further outputs.
    inputs
        Inputs of models, or components of them, to which a parameter of their name is added, zero
        by default. A name that is not an input is ignored.
    drives
        Inputs and the expressions that give them, as pairs of texts, in place of the scene's. They
        may use the parameter RUN_NUMBER, which the graph has then.

    Raises
    ------
    BgError
        With all independent errors that were found.
    """
    chosen = with_drives(with_uses(choose_scene(package, scene), uses), drives)
    chosen = with_observations(chosen, observe)
    numbered = any(RUN_NUMBER in text for _, text in drives)
    return _elaborate(package, chosen, overrides, shapes, inputs, numbered)


def _elaborate(
    package: Package,
    scene: Scene,
    overrides: Sequence[tuple[str, str]],
    shapes: bool,
    inputs: Sequence[str],
    numbered: bool,
) -> FlatGraph:
    """Elaborate a chosen scene.

    Instances come first, then widths and units with placeholders for the variables of bonds, and
    last all values and laws with the numbered scalar bonds.
    """
    report = Report()
    world = World(package, Dag(), report, Edits())
    builder, quantities, bonds = _connect(world, inputs)
    domains, carried = bonds.domains, bonds.carried
    if numbered:
        scene.env.locals[RUN_NUMBER] = quantities.run_number(scene.model.syntax.name_span)

    for declared in package.root.domains.values():
        with report.collecting():
            domains.facts(declared)
    collect_edits(world, scene, overrides)
    report.raise_errors()
    root = _root(world, builder, scene)
    changed = without_removed(world, scene) if scene.inherited and not report.errors else None
    if changed is not None:
        graph = _elaborate(package, changed[0], overrides, shapes, inputs, numbered)
        return replace(graph, warnings=(*changed[1], *graph.warnings))
    wiring = wire(world, root)
    with _provisional(world, quantities):
        quantities.enter_set()
        check_edits(world, scene, [slot.path for slot in builder.slots])
        check_overrides(world, scene, overrides)
    bonds_are_sound = not report.errors
    collect_definitions(world, wiring)
    evaluate_parameters(world, wiring)
    if bonds_are_sound:
        report.set_aside()  # report an invalid value and an invalid width together
    report.raise_new_errors()

    nets = join_nets(world, wiring, domains)
    collect_assignments(world, wiring, domains, carried)
    report.raise_new_errors()
    with _provisional(world, quantities):
        settle_widths(nets)
        scalars = scalarise(world, wiring)
        _number_storage(wiring, scalars)
        units = infer_units(world, wiring, domains, scalars)
    report.raise_new_errors()
    bonds.scalars, bonds.units = scalars, units
    evaluate_values(world, wiring, carried)
    return _flat_graph(world, scene, root, wiring, bonds, tuple(builder.slots), shapes)


def _flat_graph(
    world: World,
    scene: Scene,
    root: Instance,
    wiring: Wiring,
    bonds: BondValues,
    slots: tuple[Slot, ...],
    shapes: bool,
) -> FlatGraph:
    """Read laws, statements and the scene, once widths, units and values are known."""
    package, report, scalars, units = world.package, world.report, bonds.scalars, bonds.units
    assert scalars is not None and units is not None
    elements = read_elements(world, wiring, bonds, scalars)
    statements = read_statements(world, wiring)
    held, rates = read_sampled(world, wiring)
    ports = read_ports(world, wiring)
    observed = read_observed(world, scene, root, ports)
    if scene.implicit:
        observed = _observe_all(world, bonds, wiring, root)
    devices = read_devices(world, scene)
    requirements = read_requirements(world, scene, observed)
    kept = read_kept(world, scene)
    rest = read_start(world, scene, observed)
    facts = read_facts(world, scene, observed, rest.facts if rest else None)
    _check_world(world, root)
    drawn = read_shapes(world, bonds, wiring, shapes and not report.errors)
    contents = (elements, statements.states, statements.equations, held, observed.columns)
    if not report.errors and not any(contents):
        span = scene.model.syntax.name_span
        report.add(messages.nothing_to_compute(span, scene.model.syntax.name))
    report.raise_errors()
    graph = FlatGraph(
        dag=world.dag,
        scene=facts,
        bonds=tuple(_bonds(scalars, units)),
        elements=elements,
        parameters=tuple(world.quantities.parameters),
        states=statements.states,
        unknowns=statements.unknowns,
        equations=statements.equations,
        guards=statements.guards,
        conditions=statements.conditions,
        jumps=statements.jumps,
        held=held,
        rates=rates,
        ports=ports,
        fmus=read_fmus(world, wiring),
        solver_span=next((item.span for item in scene.statements(syntax.Solver)), None),
        observations=(
            *_with_hidden(observed.observations, requirements, rest),
            *drawn.observations,
        ),
        requirements=requirements,
        devices=devices,
        kept=(*kept, *rest.facts.vary) if rest else kept,
        warnings=(*package.warnings, *report.warnings),
        slots=slots,
        data=tuple(
            DataSource(name, str(path.absolute()), digest)
            for name, path, digest in package.read_files
        ),
        shapes=tuple(drawn.uses),
        parts=tuple(map(_part, wiring.instances)),
    )
    refuse_held_early(graph)
    return replace(graph, guards=(*graph.guards, *guards_of_tables(graph)))


def _part(instance: Instance) -> Part:
    declared, sizes = instance.kinds[0]
    formals = (formal.name for formal in declared.syntax.formals)
    dims = tuple(zip(formals, sizes, strict=True))
    return Part(instance.path, declared.syntax.name, instance.span, dims)


def check_file_values(package: Package) -> tuple[Diagnostic, ...]:
    """Return the errors and warnings of the root file's own constants and parameters.

    They are evaluated with their defaults, also those that no scene uses.
    """
    world = World(package, Dag(), Report(), Edits())
    _, quantities, _ = _connect(world, ())
    with suppress(BgError):  # the report is full
        for declared in package.root.constants.values():
            if declared.module is package.root:
                with world.report.collecting():
                    quantities.constant(declared, declared.syntax.name_span)
    return (*world.report.errors, *world.report.warnings)


def _connect(world: World, inputs: Sequence[str]) -> tuple[Builder, Quantities, BondValues]:
    """Construct the services of a world."""
    builder, quantities = Builder(world), Quantities(world, inputs)
    bonds = BondValues(world, Domains(world), Carried(world))
    world.connect(builder, quantities, bonds)
    return builder, quantities, bonds


def _root(world: World, builder: Builder, scene: Scene) -> Instance:
    """Create the root of the instance tree; parts are built when they are first needed."""
    model = scene.model
    if Census().least_parts(model) > MAX_PARTS:
        raise BgError([messages.too_many_parts(model.syntax.name_span, MAX_PARTS)])
    dims = builder.dimensions(model.syntax, scene.use, scene.env)
    arguments = builder.arguments_by_name(scene.use, scene.env, model.syntax.name)
    root = builder.instantiate(
        model, dims, arguments, "", None, model.syntax.name_span, home=scene.env
    )
    for name, device in scene.devices.items():
        if name in root.members:
            world.report.add(device_name_taken(device.item.span, name, None))
    return root


def _check_world(world: World, root: Instance) -> None:
    """Report parameters of the scene's model that have the name of one of a file that it uses."""
    first: dict[str, Span] = {}
    for parameter in world.quantities.parameters:
        if "." in parameter.name:
            continue  # of a part of the model: `leg[1].mass`
        name = parameter.name.partition("[")[0]
        if first.setdefault(name, parameter.span) != parameter.span:
            member = root.members[name]
            assert isinstance(member, Quantity)
            own = member.declaration.name_span
            other = parameter.span if parameter.span != own else first[name]
            world.report.add(hides_parameter_of_file(own, name, other))


def _number_storage(wiring: Wiring, scalars: Scalars) -> None:
    """Number the ports of all storage elements consecutively."""
    count = 0
    for element in wiring.elements:
        if element.row.stored:
            element.first_state = count
            count += len(scalars.ports(element.faces["all"]))


def _bonds(scalars: Scalars, units: BondUnits) -> Iterator[Bond]:
    for index, bond in enumerate(scalars.bonds):
        yield Bond(
            index,
            bond.name,
            bond.component,
            bond.width,
            si_text(units.dimension("effort", index)),
            si_text(units.dimension("flow", index)),
            units.is_power(index),
            bond.span,
        )


def _observe_all(world: World, bonds: BondValues, wiring: Wiring, root: Instance) -> Observed:
    """Observe the states of all storage elements, all declared states and all outputs."""
    found: list[Observation] = []
    for element in wiring.elements:
        for name in element.row.stored:
            with world.report.collecting():
                value = bonds.storage(element, name)
                for k, index in enumerate(indices(value.shape)):
                    label = component_name(f"{element.path}.{name}", index)
                    unit = value.units[k]
                    shown = shown_of(unit)
                    found.append(
                        Observation(label, si_text(unit), value.nodes[k], element.span, shown)
                    )
    outputs = [m for m in root.members.values() if isinstance(m, Quantity) and m.kind == "output"]
    sampled = (q for q in world.quantities.held if q.kind == "state")
    for quantity in (*world.quantities.states, *sampled, *outputs):
        if quantity.value is None:
            continue  # its evaluation failed, which has been reported
        components = zip(indices(quantity.value.shape), quantity.value.components, strict=True)
        for index, component in components:
            label = component_name(quantity.path, index)
            unit, span = component.unit, quantity.declaration.name_span
            found.append(Observation(label, si_text(unit), component.node, span, shown_of(unit)))
    return Observed(tuple(found), (), tuple(o.name for o in found))


def _with_hidden(
    observations: tuple[Observation, ...],
    requirements: Sequence[Requirement],
    rest: StartAtRest | None,
) -> tuple[Observation, ...]:
    """The observations, followed by required and held quantities that are not among them."""
    shown = {o.name: o for o in observations}
    for r in requirements:
        shown.setdefault(r.name, Observation(r.name, r.unit, r.node, r.span, r.shown))
    for held in rest.observations if rest else ():
        shown.setdefault(held.name, held)
    return tuple(shown.values())


@contextmanager
def _provisional(world: World, quantities: Quantities) -> Iterator[None]:
    """Evaluate with placeholder symbols for the variables of bonds.

    Values that depend on bonds have only their shape here; they are discarded at the end.
    """
    world.provisional = True
    try:
        yield
    finally:
        world.provisional = False
        quantities.forget_provisional()
