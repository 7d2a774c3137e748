"""Print the derivatives of a model's kernels by parameters, for sensitivities along a run.

Each lane of a vector register holds the derivative by one parameter; what is differentiated is the
same in all lanes. A kernel here is the tangent of one of `program_kernels.py`: it takes the changes
d of the states (then of time, then of the unknowns of a start) and q of what depends on parameters
alone (then of what sampled parts hold), and stores the changes of its results. `prepare` computes
q, and elements of h that only derivatives read.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from textwrap import fill

from bgc.algebra.dag import Dag, Kind
from bgc.algebra.derivatives import directional_derivatives
from bgc.algebra.nodes import Node
from bgc.building.build import Unit
from bgc.emission.kernels import KernelText, by_dependence, hoisted_nodes, print_kernel, prototype
from bgc.emission.lanes import lane_unit
from bgc.emission.lower import dependent_defaults
from bgc.emission.print_c import HELPERS, LANES, Numbers
from bgc.emission.print_lu import is_unrolled, print_solve, solve_prototype
from bgc.emission.print_steps import print_steps
from bgc.emission.print_tables import table_prototypes
from bgc.emission.program_kernels import hoisted_kernel, projection_nodes, stores
from bgc.ir.lowered import Kernel, Lowered, Reads, Store
from bgc.record_class import dataclass, replace

TANGENTS: Numbers = replace(LANES, prefix="tangents", shared="bgc_tangents")
_LARGE = ("jacobian", "curvature")  # kernels with a unit of their own


def tangent_units(lowered: Lowered) -> tuple[Unit, ...]:
    """The additional C units of sensitivities, linked with `runtime/c/tangents`."""
    lowered = replace(lowered, program=replace(lowered.program, dag=lowered.program.dag.copy()))
    tangents = _Tangents(lowered)
    second, changing = tangents.second()
    kernels = (*tangents.kernels(), second)
    own = hoisted_nodes(tangents.dag, kernels)
    extra = tuple(node for node in own if node not in tangents.hoisted)
    places = {node: k for k, node in enumerate((*lowered.hoisted, *extra))}
    prepare = tangents.prepare(extra)
    texts = {k.name: print_kernel(tangents.dag, k, places, True, TANGENTS) for k in kernels}
    fields = {
        "n_work": str(max((text.work for text in texts.values()), default=0)),
        "n_prepare_work": str(prepare.work),
        "n_hoist": str(len(places)),
        "n_jac": str(len(changing)),
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
    if changing:
        fields |= {"jac_first": "tangents_jac_first", "jac_col": "tangents_jac_col"}
    table = "".join(f"    .{name} = {value},\n" for name, value in fields.items())
    model = (
        f"static const bgc_tangent_model tangents_info = {{\n{table}}};\n\n"
        "const bgc_tangent_model *bgc_get_tangent_model(void)\n{\n    return &tangents_info;\n}\n"
    )
    small = [text for name, text in texts.items() if name not in _LARGE]
    helpers = [HELPERS[name] for name in sorted(prepare.helpers)]
    rest = [*helpers, prepare.text, *_pattern(lowered, changing), model]
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

    def second(self) -> tuple[Kernel, tuple[int, ...]]:
        """The change of the Jacobian: of the entries that change, or of its product with r."""
        jacobian, running = self.lowered.jacobian, "h t x u d q"
        purpose = "Changes of the Jacobian."
        if jacobian.inner == 0:
            changes = self._changed(jacobian.entries)
            changing = tuple(k for k, change in enumerate(changes) if change != self.dag.zero)
            made = stores("jac", (changes[k] for k in changing))
            by_time = self._changes("dfdt", jacobian.by_time)
            kernel = hoisted_kernel("jacobian", purpose, running, "jac dfdt", (*made, *by_time))
            return kernel, changing
        count = len(self.lowered.program.states)
        along = {
            symbol: self.dag.symbol(Kind.RATE, place)
            for symbol, place in self._moving(count).items()
        }
        rates = [state.derivative for state in self.lowered.program.states]
        products = directional_derivatives(self.dag, rates, along)
        made = self._changes("f", products)
        kernel = hoisted_kernel("curvature", purpose, f"{running} r", "f", made)
        return kernel, ()

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


def _pattern(lowered: Lowered, changing: Sequence[int]) -> Iterator[str]:
    """Tables of the entries of the Jacobian that change: the first of each row, and columns."""
    rows = [lowered.jacobian.rows[k] for k in changing]
    first = [bisect_left(rows, row) for row in range(len(lowered.program.states) + 1)]
    columns = [lowered.jacobian.columns[k] for k in changing]
    for name, numbers in (("first", first), ("col", columns)):
        if changing:
            body = fill(
                ", ".join(map(str, numbers)), 96, initial_indent="    ", subsequent_indent="    "
            )
            yield f"static const int tangents_jac_{name}[] = {{\n{body}}};\n"


def _parameters_with_selectors(lowered: Lowered) -> int:
    """The number of elements of p: parameters, then the selectors of closing rows."""
    closures = lowered.program.closures
    return len(lowered.program.parameters) + (len(closures.selectors) if closures else 0)
