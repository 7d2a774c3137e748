"""Print the kernels of a model for several instances at once, on vector registers.

The statements are those of the scalar model; each lane of a vector register (`bgc_lanes.h`) holds
the number of one instance. Parameters and initial states, which are computed once per run, use the
scalar functions of each instance.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from bgc.algebra.operation import Lanes
from bgc.algebra.operations import ROWS
from bgc.building.build import Unit
from bgc.emission.emit import MODEL_FLAGS, is_large, print_matrix
from bgc.emission.kernels import KernelText, print_kernel, prototype
from bgc.emission.print_c import LANES, function_text, lane_name
from bgc.emission.print_lu import matrix_prototypes
from bgc.emission.print_tables import table_prototypes
from bgc.ir.lowered import Kernel, Lowered

_KERNELS = ("rhs", "jacobian", "energy", "outputs", "asserts", "project", "switches", "watched")


_DEFINED_BY = {
    Lanes.LOOP: "LANE_LOOP",
    Lanes.LIBMVEC: "LANE_LIBMVEC",
    Lanes.LIBMVEC_2_35: "LANE_LIBMVEC_2_35",
}  # macros of `lane_functions.h`


def lane_units(lowered: Lowered) -> tuple[Unit, ...]:
    """The additional C units of an ensemble, linked with the model and `runtime/c/lanes`."""
    return _model_units(lowered)


def function_unit() -> Unit:
    """The unit of the language's functions on vector registers, the same for all models."""
    lines = [
        f"{_DEFINED_BY[row.lanes]}_{row.arity}({row.c})\n"
        for row in ROWS
        if row.c and row.lanes in _DEFINED_BY
    ]
    headers = dict.fromkeys(row.c_header for row in ROWS if row.c_header)
    includes = ["lanes/lane_functions.h", *headers]
    text = "".join(f'#include "{name}"\n' for name in includes)
    return Unit("lane_functions", f"{text}\n{''.join(lines)}")


def _declarations() -> dict[str, str]:
    """The declaration or definition of each function on vector registers, by its name."""
    declared = {}
    for row in ROWS:
        name = lane_name(row)
        if row.lanes is Lanes.FORMULA:
            declared[name] = function_text("lane", name, row.arity, row.lane_formula)
        elif row.c and row.lanes in _DEFINED_BY:
            operands = ", ".join(["lane"] * row.arity)
            declared[name] = f"lane {name}({operands});\n"
    return declared


def _model_units(lowered: Lowered) -> tuple[Unit, ...]:
    """The kernels of a model on vector registers."""
    separate = is_large(lowered.program)
    kernels = {k.name: k.without_left for k in lowered.kernels if k.name in _KERNELS}
    texts = {
        name: _jacobian(lowered, kernel, separate) if name == "jacobian" else _text(lowered, kernel)
        for name, kernel in kernels.items()
    }
    matrix = print_matrix(lowered, separate, LANES)
    work = max(matrix.work, *(text.work for text in texts.values()))
    data = table_prototypes(lowered.program.dag, "bgc_lane_tables.h")
    table = _table((*kernels, *(("factor", "solve") if matrix.text else ())), work, separate)
    if not separate:
        return (lane_unit("lanes", data, texts.values(), [matrix.text, table]),)
    shared = [*data, prototype(kernels["jacobian"], LANES), matrix_prototypes(LANES)]
    main = [text for name, text in texts.items() if name != "jacobian"]
    units = [
        lane_unit("lanes", shared, main, [table]),
        lane_unit("lanes_jacobian", shared, [texts["jacobian"]]),
    ]
    if matrix.text:
        units.append(lane_unit("lanes_matrix", shared, [], [matrix.text]))
    return tuple(units)


def _text(lowered: Lowered, kernel: Kernel, shared: bool = False) -> KernelText:
    hoisted = {node: k for k, node in enumerate(lowered.hoisted)}
    return print_kernel(lowered.program.dag, kernel, hoisted, shared, LANES)


def _jacobian(lowered: Lowered, kernel: Kernel, shared: bool) -> KernelText:
    """Print the Jacobian by rows or by columns, in the order with less scratch memory.

    Each number occupies a cache line here, so intermediate results crowd the cache. On a crane with
    70 states up to 714 are stored by rows and 239 by columns, which takes 0.8 of the time.
    """
    columns = lowered.jacobian.columns
    entries, by_time = kernel.stores[: len(columns)], kernel.stores[len(columns) :]
    by_columns = (*sorted(entries, key=lambda store: columns[store.index]), *by_time)
    orders = (kernel, replace(kernel, stores=by_columns))
    return min((_text(lowered, each, shared) for each in orders), key=lambda text: text.work)


def lane_unit(
    name: str, shared: Sequence[str], kernels: Iterable[KernelText], rest: Sequence[str] = ()
) -> Unit:
    """A C unit of kernels and other text, with the helper functions that the kernels call."""
    kernels = list(kernels)
    called = {helper for kernel in kernels for helper in kernel.helpers}
    functions = "".join(text for name, text in _declarations().items() if name in called)
    parts = [functions, *shared, *(kernel.text for kernel in kernels), *rest]
    text = "\n".join(part for part in parts if part)
    return Unit(name, f'#include "bgc_lanes.h"\n\n{text}', MODEL_FLAGS)


def _table(functions: Sequence[str], work: int, separate: bool) -> str:
    """The table of the model's functions, and the function that returns the table."""
    shared = {"jacobian", "factor", "solve"} if separate else set[str]()
    fields = {"n_work": str(work)}
    for name in functions:
        fields[name] = f"{LANES.shared if name in shared else LANES.prefix}_{name}"
    lines = "".join(f"    .{name} = {value},\n" for name, value in fields.items())
    return (
        f"static const bgc_lane_model lanes_info = {{\n{lines}}};\n\n"
        "const bgc_lane_model *bgc_get_lane_model(void)\n{\n    return &lanes_info;\n}\n"
    )
