"""The C of a model for several instances at once: the kernels of a run, on vectors.

The same statements as of the scalar model, with a number of each instance in a lane of a vector
register (`bgc_lanes.h`). What happens once in a run, as the parameters and the initial state, is
left to the scalar functions of every instance.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

from bgc.building.build import Unit
from bgc.emission.emit import MODEL_FLAGS, is_large, print_matrix
from bgc.emission.kernels import KernelText, print_kernel, prototype
from bgc.emission.print_c import LANES
from bgc.emission.print_lu import matrix_prototypes
from bgc.ir.lowered import Kernel, Lowered

_KERNELS = ("rhs", "jacobian", "energy", "outputs", "asserts", "project", "switches")


def lane_units(lowered: Lowered) -> tuple[Unit, ...]:
    """The C units to link with a model and its runtime, and with those of `runtime/c/lanes`."""
    apart = is_large(lowered.program)
    kernels = {kernel.name: kernel for kernel in lowered.kernels if kernel.name in _KERNELS}
    texts = {
        name: _jacobian(lowered, kernel, apart) if name == "jacobian" else _text(lowered, kernel)
        for name, kernel in kernels.items()
    }
    matrix = print_matrix(lowered, apart, LANES)
    work = max(matrix.work, *(text.work for text in texts.values()))
    table = _table((*kernels, *(("factor", "solve") if matrix.text else ())), work, apart)
    if not apart:
        return (_unit("lanes", [*_texts(texts.values()), matrix.text, table]),)
    shared = [prototype(kernels["jacobian"], LANES), matrix_prototypes(LANES)]
    main = [text for name, text in texts.items() if name != "jacobian"]
    units = [
        _unit("lanes", [*shared, *_texts(main), table]),
        _unit("lanes_jacobian", [*shared, texts["jacobian"].text]),
    ]
    if matrix.text:
        units.append(_unit("lanes_matrix", [*shared, matrix.text]))
    return tuple(units)


def _text(lowered: Lowered, kernel: Kernel, shared: bool = False) -> KernelText:
    hoisted = {node: k for k, node in enumerate(lowered.hoisted)}
    return print_kernel(lowered.program.dag, kernel, hoisted, shared, LANES)


def _jacobian(lowered: Lowered, kernel: Kernel, shared: bool) -> KernelText:
    """The Jacobian, made by rows or by columns.

    Every number takes a cache line here, so those that wait to be used crowd the cache: of a crane
    of 70 states, 714 wait where it is made by rows, 239 by columns, and that takes 0.8 of the time.
    """
    columns = lowered.jacobian.columns
    entries, by_time = kernel.stores[: len(columns)], kernel.stores[len(columns) :]
    by_columns = (*sorted(entries, key=lambda store: columns[store.index]), *by_time)
    orders = (kernel, replace(kernel, stores=by_columns))
    return min((_text(lowered, each, shared) for each in orders), key=lambda text: text.work)


def _texts(kernels: Iterable[KernelText]) -> list[str]:
    return [kernel.text for kernel in kernels]


def _unit(name: str, parts: Sequence[str]) -> Unit:
    text = "\n".join(part for part in parts if part)
    return Unit(name, f'#include "bgc_lanes.h"\n\n{text}', MODEL_FLAGS)


def _table(functions: Sequence[str], work: int, apart: bool) -> str:
    """The table of the functions there are, and the function that gives it."""
    shared = {"jacobian", "factor", "solve"} if apart else set[str]()
    fields = {"n_work": str(work)}
    for name in functions:
        fields[name] = f"{LANES.shared if name in shared else LANES.prefix}_{name}"
    lines = "".join(f"    .{name} = {value},\n" for name, value in fields.items())
    return (
        f"static const bgc_lane_model lanes_info = {{\n{lines}}};\n\n"
        "const bgc_lane_model *bgc_get_lane_model(void)\n{\n    return &lanes_info;\n}\n"
    )
