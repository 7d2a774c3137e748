"""Print the derivatives of a model's kernels by parameters, for sensitivities along a run.

Each lane of a vector register holds the derivative by one parameter; what is differentiated is the
same in all lanes. A kernel here is the tangent of one of `program_kernels.py`: it takes the changes
d of the states (then of time, then of the unknowns of a start) and q of what depends on parameters
alone (then of what sampled parts hold), and stores the changes of its results. `prepare` computes
q, and elements of h that only derivatives read.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from bgc.algebra.dag import Dag, Kind, Level
from bgc.algebra.derivatives import directional_derivatives
from bgc.algebra.nodes import Node
from bgc.building.build import Unit
from bgc.emission.kernels import (
    KernelText,
    by_dependence,
    hoisted_nodes,
    print_kernel,
    prototype,
    schedule,
)
from bgc.emission.lanes import lane_unit
from bgc.emission.lower import dependent_defaults
from bgc.emission.print_c import HELPERS, LANES, Numbers
from bgc.emission.print_lu import is_unrolled, print_solve, solve_prototype
from bgc.emission.print_steps import print_steps
from bgc.emission.print_tables import table_prototypes
from bgc.emission.program_kernels import hoisted_kernel, projection_nodes, stores
from bgc.ir.lowered import SCRATCH, Kernel, Lowered, Reads, Store
from bgc.record_class import dataclass, replace

TANGENTS: Numbers = replace(LANES, prefix="tangents", shared="bgc_tangents", factors="double")
_LARGE = ("curvature_shared", "curvature")  # kernels with a unit of their own


def tangent_units(lowered: Lowered) -> tuple[Unit, ...]:
    """The additional C units of sensitivities, linked with `runtime/c/tangents`."""
    lowered = replace(lowered, program=replace(lowered.program, dag=lowered.program.dag.copy()))
    tangents = _Tangents(lowered)
    kernels = (*tangents.kernels(), tangents.curvature())
    own = hoisted_nodes(tangents.dag, kernels)
    extra = tuple(node for node in own if node not in tangents.hoisted)
    places = {node: k for k, node in enumerate((*lowered.hoisted, *extra))}
    prepare = tangents.prepare(extra)
    kernels = (*kernels[:-1], *tangents.shared(kernels[-1], places))
    texts = {k.name: print_kernel(tangents.dag, k, places, True, TANGENTS) for k in kernels}
    fields = {
        "n_work": str(max((text.work for text in texts.values()), default=0)),
        "n_prepare_work": str(prepare.work),
        "n_hoist": str(len(places)),
        "first_change": str(_parameters_with_selectors(lowered)),
        "prepare": "tangents_prepare",
        **{name: f"bgc_tangents_{name}" for name in texts},
    }
    data = table_prototypes(tangents.dag, "bgc_lane_tables.h")
    shared = [*data, *(prototype(kernel, TANGENTS) for kernel in kernels)]
    units = list[Unit]()
    if lowered.blocks is None and is_unrolled(lowered.plan):
        solve = print_solve(lowered.plan, lowered.jacobian.inner, TANGENTS)
        extent = lowered.jacobian.size + len(lowered.plan.rows)
        fields |= {"solve": "bgc_tangents_solve", "n_solve_work": str(extent)}
        shared.append(solve_prototype(TANGENTS))
        units.append(lane_unit("tangents_solve", shared, [], [solve]))
    table = "".join(f"    .{name} = {value},\n" for name, value in fields.items())
    model = (
        f"static const bgc_tangent_model tangents_info = {{\n{table}}};\n\n"
        "const bgc_tangent_model *bgc_get_tangent_model(void)\n{\n    return &tangents_info;\n}\n"
    )
    small = [text for name, text in texts.items() if name not in _LARGE]
    helpers = [HELPERS[name] for name in sorted(prepare.helpers)]
    rest = [*helpers, prepare.text, model]
    units.append(lane_unit("tangents", ['#include "bgc_tangents.h"\n', *shared], small, rest))
    units += [
        lane_unit(f"tangents_{name}", shared, [texts[name]]) for name in _LARGE if name in texts
    ]
    return tuple(units)


@dataclass(frozen=True, slots=True)
class _Tangents:
    """The tangents of a lowered program, which are made on its DAG."""

    lowered: Lowered

    @property
    def dag(self) -> Dag:
        return self.lowered.program.dag

    @property
    def hoisted(self) -> frozenset[Node]:
        return frozenset(self.lowered.hoisted)

    def kernels(self) -> Iterator[Kernel]:
        """The kernels of tangents by name; those of what the model does not have are left out."""
        program, running = self.lowered.program, "h t x u d q"
        yield self._kernel("rhs", running, "f", [s.derivative for s in program.states])
        yield self._kernel("outputs", running, "y", [o.node for o in program.observations])
        initial = [s.initial for s in program.states]
        yield self._kernel("initial", "h t u q", "x", initial)
        if program.mass:
            yield self._kernel("mass", "h q", "m", [entry.value for entry in program.mass])
        if self.lowered.switches:
            arguments = [switch.argument for switch in self.lowered.switches]
            yield self._kernel("switches", running, "z", arguments)
        if program.jumps:
            resets = [reset.value for jump in program.jumps for reset in jump.resets]
            yield self._kernel("resets", running, "z", resets)
        if any(state.projection is not None for state in program.states):
            states = [self.dag.symbol(Kind.STATE, k) for k in range(len(program.states))]
            ends = [s.projection or x for s, x in zip(program.states, states, strict=True)]
            yield self._kernel("project", "h t x d q", "z", ends)
        if program.closures is not None:
            yield self._kernel("closures", running, "c", projection_nodes(program.closures))
        if program.held:
            rates = [node for rate in program.rates for node in (rate.period, rate.offset)]
            yield self._kernel("sampling", "h q", "s", rates)
            yield self._kernel("held_start", "h t u q", "z", [h.initial for h in program.held])
            yield self._kernel("held", running, "z", [h.update for h in program.held])
        if program.start is not None:
            own = "h t u s d q"
            yield self._kernel("start", own, "r", program.start.residuals)
            values = dict(program.start.values)
            started = [values.get(k, node) for k, node in enumerate(initial)]
            yield self._kernel("started", own, "x", started)

    def curvature(self) -> Kernel:
        """The change of the product of the Jacobian with r, whose last element moves time."""
        states = self.lowered.program.states
        along = {
            symbol: self.dag.symbol(Kind.RATE, place)
            for symbol, place in self._moving(len(states)).items()
        }
        products = directional_derivatives(self.dag, [s.derivative for s in states], along)
        return self._kernel("curvature", "h t x u d q r", "f", products)

    def shared(self, kernel: Kernel, hoisted: Mapping[Node, int]) -> tuple[Kernel, Kernel]:
        """Split a kernel: what no change enters is left in w, where the other part finds it."""
        dag = self.dag
        planned = schedule(dag, [s.node for s in kernel.stores], int(Level.PARAM), hoisted.keys())
        changing, found = set[Node](), dict[Node, None]()
        for node in planned.order:
            operands = dag.operands(node)
            if not changing.isdisjoint(operands) or any(map(self._is_change, operands)):
                changing.add(node)
        computed = set(planned.order) - changing
        for node in changing:
            found |= dict.fromkeys(each for each in dag.operands(node) if each in computed)
        left = tuple(sorted(found))
        inputs = " ".join(name for name in kernel.inputs if name not in ("d", "q"))
        purpose = f"What all changes share of the results of {kernel.name}."
        before = hoisted_kernel(f"{kernel.name}_shared", purpose, inputs, "", stores(SCRATCH, left))
        return before, replace(kernel, found=left)

    def _is_change(self, node: Node) -> bool:
        symbol = self.dag.symbol_of(node)
        return symbol is not None and symbol.kind in (Kind.CHANGE, Kind.HOISTED_CHANGE)

    def _kernel(self, name: str, inputs: str, result: str, nodes: Sequence[Node]) -> Kernel:
        purpose = f"Changes of the results of {name}."
        return hoisted_kernel(name, purpose, inputs, result, self._changes(result, nodes))

    def _changes(self, array: str, nodes: Sequence[Node]) -> tuple[Store, ...]:
        """Stores of the changes of nodes."""
        return stores(array, self._changed(nodes))

    def _changed(self, nodes: Sequence[Node]) -> list[Node]:
        return directional_derivatives(self.dag, nodes, self._direction())

    def _direction(self) -> dict[Node, Node]:
        dag, states = self.dag, len(self.lowered.program.states)
        found = {node: dag.symbol(Kind.CHANGE, k) for node, k in self._moving(states).items()}
        held = [dag.symbol(Kind.INPUT, held.index) for held in self.lowered.program.held]
        for k, node in enumerate((*self.lowered.hoisted, *held)):
            found[node] = dag.symbol(Kind.HOISTED_CHANGE, k)
        return found

    def _moving(self, states: int) -> dict[Node, int]:
        """The symbols that move along a run, with their places: states, time, START unknowns."""
        dag, start = self.dag, self.lowered.program.start
        found = {dag.symbol(Kind.STATE, k): k for k in range(states)}
        found[dag.symbol(Kind.TIME)] = states
        for k in range(len(start.residuals) if start else 0):
            found[dag.symbol(Kind.START, k)] = states + 1 + k
        return found

    def prepare(self, extra: Sequence[Node]) -> KernelText:
        """Print the kernel that computes `extra` elements of h, and the changes behind them.

        p holds the parameters (and selectors), their changes, and 1 for those that follow the
        parameters in their defaults; h begins with what the model's own `prepare` has computed.
        """
        lowered, dag = self.lowered, self.dag
        count = len(lowered.hoisted)
        changes = directional_derivatives(dag, lowered.hoisted, self._parameter_changes())
        made = [Store("h", count + k, node) for k, node in enumerate(extra)]
        first = count + len(extra)
        made += [
            Store("h", first + k, change) for k, change in enumerate(changes) if change != dag.zero
        ]
        purpose = "What derivatives read of parameters alone, and the changes of all in h."
        kernel = Kernel("prepare", purpose, ("p",), ("h",), Reads.PARAMETERS, tuple(made))
        head = "static void tangents_prepare(const double *p, double *h, double *w)"
        if not made:
            unused = "    (void)p;\n    (void)h;\n    (void)w;\n"
            return KernelText(f"{head}\n{{\n{unused}}}\n", 0, 0, frozenset())
        return print_steps(dag, kernel, head, {n: k for k, n in enumerate(lowered.hoisted)})

    def _parameter_changes(self) -> dict[Node, Node]:
        """The changes of all parameters; those with a default that others give follow these."""
        dag, program = self.dag, self.lowered.program
        count, width = len(program.parameters), _parameters_with_selectors(self.lowered)
        symbols = [dag.symbol(Kind.PARAM, k) for k in range(count)]
        found = {symbol: dag.symbol(Kind.PARAM, width + k) for k, symbol in enumerate(symbols)}
        for index, default in by_dependence(dag, dependent_defaults(program)):
            follows = dag.symbol(Kind.PARAM, width + count + index)
            (change,) = directional_derivatives(dag, [default], found)
            own = found[symbols[index]]
            found[symbols[index]] = dag.add(own, dag.mul(follows, change))
        return found


def _parameters_with_selectors(lowered: Lowered) -> int:
    """The number of elements of p: parameters, then the selectors of closing rows."""
    closures = lowered.program.closures
    return len(lowered.program.parameters) + (len(closures.selectors) if closures else 0)
