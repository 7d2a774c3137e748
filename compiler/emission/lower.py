"""From a program to what each C function computes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction

from bgc.algebra.dag import Dag, Kind, Level, Op
from bgc.emission.differentiate import differentiate
from bgc.emission.kernels import hoisted_nodes
from bgc.emission.optimise import number_values
from bgc.emission.sparse import plan_lu
from bgc.emission.switches import hold_modes
from bgc.ir.graph import Node
from bgc.ir.lowered import Jacobian, Kernel, Lowered, Reads, Store, Switch
from bgc.ir.program import MassEntry, Program
from bgc.ir.program_nodes import map_program, program_roots

_RUNNING = "h t x u"


def lower(program: Program) -> Lowered:
    """Differentiates the program, plans its linear algebra and lays out its kernels.

    The program should be optimised before. Nodes of the result are those of its own program,
    on a graph of its own.
    """
    program, switches, jacobian = _differentiated(*hold_modes(program))
    program = _with_a_mass(program, jacobian)
    kernels = _kernels(program, switches, jacobian)
    for kernel in kernels:
        _verify(program.dag, kernel)
    hoisted = hoisted_nodes(program.dag, kernels)
    prepare = Kernel(
        "prepare",
        "Everything that depends on parameters alone.",
        ("p",),
        ("h",),
        Reads.PARAMETERS,
        _stores("h", hoisted),
    )
    return Lowered(
        program=program,
        switches=switches,
        jacobian=jacobian,
        plan=plan_lu(program, jacobian),
        hoisted=hoisted,
        kernels=(prepare, *kernels),
    )


def _with_a_mass(program: Program, jacobian: Jacobian) -> Program:
    """The program with a zero in a mass matrix that is empty: no entries mean the identity."""
    if program.mass != () or not program.states:
        return program
    place = next(zip(jacobian.rows, jacobian.columns, strict=True), (0, 0))
    return replace(program, mass=(MassEntry(*place, program.dag.zero),))


def _verify(dag: Dag, kernel: Kernel) -> None:
    """Asserts that a kernel's nodes need no more than its arguments."""
    arguments = {*kernel.inputs, *(kernel.results if kernel.in_place else ())}
    if "x" not in arguments:
        highest = Level.TIME if "t" in arguments else Level.PARAM
        for store in kernel.stores:
            assert dag.level[store.node] <= highest, f"{kernel.name} reads what it is not given"
    elif "u" not in arguments:
        symbols = (dag.symbol_of(n) for n in dag.reachable(s.node for s in kernel.stores))
        inputs = [s for s in symbols if s is not None and s.kind is Kind.INPUT]
        assert not inputs, f"{kernel.name} reads device inputs"


def _differentiated(
    program: Program, switches: tuple[Switch, ...]
) -> tuple[Program, tuple[Switch, ...], Jacobian]:
    """The program and its Jacobian, optimised together; entries found to be zero are gone."""
    program, jacobian = differentiate(program)
    others = (*jacobian.entries, *jacobian.by_time, *(switch.argument for switch in switches))
    dag, new = number_values(program.dag, (*program_roots(program), *others))
    switches = tuple(replace(switch, argument=new[switch.argument]) for switch in switches)
    kept = [
        (row, column, new[node])
        for row, column, node in zip(jacobian.rows, jacobian.columns, jacobian.entries, strict=True)
        if new[node] != dag.zero
    ]
    optimised = Jacobian(
        rows=tuple(row for row, _, _ in kept),
        columns=tuple(column for _, column, _ in kept),
        entries=tuple(node for _, _, node in kept),
        by_time=tuple(new[node] for node in jacobian.by_time),
    )
    return map_program(program, dag, new.__getitem__), switches, optimised


def _stores(array: str, nodes: Iterable[Node]) -> tuple[Store, ...]:
    return tuple(Store(array, index, node) for index, node in enumerate(nodes))


def _kernels(
    program: Program, switches: tuple[Switch, ...], jacobian: Jacobian
) -> tuple[Kernel, ...]:
    """All kernels but `prepare`, those of the inner loop first."""

    def kernel(
        name: str, purpose: str, inputs: str, results: str, *stores: Store, in_place: bool = False
    ) -> Kernel:
        return Kernel(
            name,
            purpose,
            tuple(inputs.split()),
            tuple(results.split()),
            Reads.HOISTED,
            stores,
            in_place,
        )

    states = program.states
    energy = program.energy
    projections = [
        Store("x", index, state.projection)
        for index, state in enumerate(states)
        if state.projection is not None
    ]
    project = kernel(
        "project",
        "States that are set after each completed step.",
        "h t",
        "x",
        *projections,
        in_place=True,
    )
    return (
        kernel(
            "rhs",
            "The right-hand sides f of M y' = f.",
            _RUNNING,
            "f",
            *_stores("f", (s.derivative for s in states)),
        ),
        kernel(
            "jacobian",
            "The entries of df/dx in the order of jac_row and jac_col, and df/dt.",
            _RUNNING,
            "jac dfdt",
            *_stores("jac", jacobian.entries),
            *_stores("dfdt", jacobian.by_time),
        ),
        kernel(
            "energy",
            "Stored energy, supplied power, dissipated power.",
            _RUNNING,
            "out",
            *_stores("out", (energy.stored, energy.supplied, energy.dissipated)),
        ),
        kernel(
            "outputs",
            "What the scene observes.",
            _RUNNING,
            "y",
            *_stores("y", (o.node for o in program.observations)),
        ),
        kernel(
            "commands",
            "What the devices are told.",
            _RUNNING,
            "c",
            *_stores("c", (value for d in program.devices for value in d.values)),
        ),
        kernel(
            "asserts",
            "Conditions that have to hold: nonzero where they do.",
            _RUNNING,
            "a",
            *_stores("a", (g.condition for g in program.guards)),
        ),
        *([project] if projections else []),
        *(
            [
                kernel(
                    "switches",
                    "The arguments of discontinuous operations.",
                    _RUNNING,
                    "z",
                    *_stores("z", (switch.argument for switch in switches)),
                )
            ]
            if switches
            else []
        ),
        kernel(
            "mass",
            "The entries of M in the order of mass_row and mass_col.",
            "h",
            "m",
            *_stores("m", (entry.value for entry in program.mass or ())),
        ),
        kernel(
            "initial",
            "The states at the start.",
            "h t u",
            "x",
            *_stores("x", (s.initial for s in states)),
        ),
        kernel(
            "scale",
            "The unit in which the error of each state is measured.",
            "h",
            "scale",
            *_stores("scale", (s.scale for s in states)),
        ),
        kernel(
            "positive",
            "Parameters and expressions of them that have to be positive.",
            "p h",
            "check",
            *_stores("check", _checks(program)),
        ),
    )


_ROUNDING = Fraction(1, 2**48)  # of the terms of a sum: what is left of nothing


def _checks(program: Program) -> list[Node]:
    """Nodes that have to be positive; of one that must only not be zero, how far it is from it."""
    dag = program.dag
    return [
        check.node if check.strictly_positive else _size(dag, check.node)
        for check in program.positive
    ]


def _size(dag: Dag, node: Node) -> Node:
    """The size of a node, less what the rounding of its terms may leave of a zero."""
    terms, stack, seen = [], [node], set()
    while stack:
        top = stack.pop()
        if top in seen:
            continue
        seen.add(top)
        if dag.op[top] in {Op.ADD, Op.SUB, Op.NEG}:
            stack.extend(dag.operands(top))
        else:
            terms.append(dag.call(Op.ABS, top))
    size = dag.call(Op.ABS, node)
    if len(terms) == 1:
        return size
    return dag.sub(size, dag.mul(dag.const(_ROUNDING), dag.sum(terms)))


def dependent_defaults(program: Program) -> list[tuple[int, Node]]:
    """Parameters whose default is computed from others."""
    return [
        (parameter.index, parameter.value)
        for parameter in program.parameters
        if _has_symbols(program.dag, parameter.value)
    ]


def _has_symbols(dag: Dag, node: Node) -> bool:
    return any(dag.op[n] == Op.SYMBOL for n in dag.reachable([node]))
