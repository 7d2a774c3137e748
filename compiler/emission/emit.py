"""Print a model as C: units to compile, or one self-contained file of model and runtime."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from bgc.building.build import EVERY_PART, Unit, needed_sources
from bgc.building.cache import digest_of, digest_of_bytes
from bgc.building.toolchain import COMMON_FLAGS, GCC_ALIASES, GCC_PASSES
from bgc.emission.amalgamate import joined
from bgc.emission.c_tables import Field, model_tables
from bgc.emission.explicit_cost import explicit_cost
from bgc.emission.frame import print_unit
from bgc.emission.inverses import print_prepare
from bgc.emission.kernels import KernelText, print_defaults, print_kernel, prototype
from bgc.emission.lower import dependent_defaults, lower
from bgc.emission.partials import PARTIALS
from bgc.emission.print_c import DOUBLES, HELPERS, Numbers
from bgc.emission.print_lu import MatrixText, matrix_prototypes, print_lu
from bgc.emission.print_ranges import RANGES
from bgc.emission.print_tables import print_tables, table_prototypes
from bgc.ir.graph import Node
from bgc.ir.lowered import Kernel, Lowered
from bgc.ir.program import Program
from bgc.record_class import dataclass, replace

# The optimisations that are effective on straight-line code. -ffp-contract=fast permits fused
# multiply-adds, which -std=c11 disables; they make the factorisation 1.5 times faster.
MODEL_FLAGS = ("-O1", *GCC_PASSES, *COMMON_FLAGS, "-ffp-contract=fast")
# Units with other flags, and what these save of their compile time.
_FLAGS = {
    "model_matrix": (*MODEL_FLAGS, *GCC_ALIASES),  # one array is read and written: a fourteenth
}

# Kernels that stay in one unit with the tables: what an edit of a number, a start or an output
# changes. The equations are units of their own, which are found in the cache after such an edit.
_WITH_TABLES = frozenset(
    [*"prepare initial scale positive given outputs commands defaults".split(), PARTIALS]
)
_SPLIT = 1_500  # number of nodes above which a model is split into units compiled in parallel
_LISTED = 200  # most names in each list of the comment at the top of the file

_HOW_TO_USE = """\
/* {name}: a bond graph and its solvers in one file of C11, made by bgc.
 *
 * Build a shared object:  cc -std=c11 -O2 -fPIC -shared THIS_FILE.c -o model.so -lm
 * or compile it along with a program of yours that includes the header beside this file:
 *
 *     const bgc_model *m = bgc_get_model();
 *     bgc_data *d = bgc_new(m);
 *     bgc_reset(m, d, 0.0);
 *     bgc_run(m, d, times, n, rows, &done);   a row: m->n_output outputs, and four energies behind
 *                                             them if `bgc_set_options` asked for `accounts`
 *     bgc_free(m, d);
 */
"""


@dataclass(frozen=True, slots=True)
class EmittedModel:
    """The C units of a model, and the cost of one call of each of its functions.

    `operations` counts additions, multiplications, divisions and function calls, by function.
    """

    name: str
    units: tuple[Unit, ...]
    operations: tuple[tuple[str, int], ...]
    lowered: Lowered
    source_hash: str


def emit_model(program: Program, source_hash: str) -> EmittedModel:
    """Print an optimised program as C; equal input gives identical bytes."""
    return emit_lowered(lower(program), source_hash)


def content_of(emitted: EmittedModel) -> str:
    """A hash of the emitted text without the source hash, so that source comments do not count."""
    contents = [digest_of_bytes(content) for unit in emitted.units for _, content in unit.files]
    texts = [unit.text.replace(emitted.source_hash, "") for unit in emitted.units]
    return digest_of([*texts, *contents])


def emit_lowered(lowered: Lowered, source_hash: str, split: bool = True) -> EmittedModel:
    """Print a lowered program as C; with `split`, a large program in several units."""
    program = lowered.program
    separate = split and is_large(program)
    names = {"factor", "solve", *(kernel.name for kernel in lowered.kernels)}
    shared = names - _WITH_TABLES if separate else set[str]()
    texts = _print_kernels(lowered, shared)
    matrix = print_matrix(lowered, separate)
    work = max(matrix.work, *(text.work for text in texts.values()))
    ranges = [_on_ranges(lowered, kernel, separate) for kernel in lowered.range_kernels]
    work = max(work, *(2 * text.work for text in ranges), 0)  # a range is two doubles
    tables, fields = model_tables(lowered, matrix, source_hash)
    prefix = RANGES.shared if separate else RANGES.prefix
    fields += [
        ("n_work", str(work)),
        *(
            (name, f"bgc_model_{name}" if name in shared else f"model_{name}")
            for name in (*texts, *(("factor", "solve") if matrix.text else ()))
            if name != PARTIALS
        ),
    ]
    fields += [(kernel.name, f"{prefix}_{kernel.name}") for kernel in lowered.range_kernels]
    if lowered.ranges is not None:
        fields.append(("n_term", str(len(lowered.ranges.stores) // 2)))
    if "project" not in texts:
        fields.append(("project", "NULL"))
    operations = (
        *((name, text.operations) for name, text in texts.items()),
        ("factor", matrix.operations),
        ("solve", matrix.solve_operations),
    )
    ratio = explicit_cost(lowered, dict(operations))
    if ratio is not None:
        fields.append(("explicit_cost", str(ratio)))
    frame = _Frame(
        f"{program.scene.name}: a bond graph of model {program.scene.model}, compiled by bgc.",
        [
            *table_prototypes(program.dag),
            *(prototype(k) for k in lowered.kernels if k.name in shared),
            *([matrix_prototypes()] if separate else []),
            *(prototype(kernel, RANGES) for kernel in lowered.range_kernels if separate),
        ],
        _needed_parts(lowered),
    )
    main = [text for name, text in texts.items() if name not in shared]
    if separate:
        rates = [text for name, text in texts.items() if name in shared - {"jacobian"}]
        units = [
            frame.unit("model", _about(lowered), main, tables=tables, fields=fields),
            frame.unit("model_rates", ["Rates, energies, projections, switches, asserts."], rates),
            frame.unit("model_jacobian", ["The Jacobian."], [texts["jacobian"]]),
        ]
        if matrix.text:
            units.append(frame.unit("model_matrix", ["The iteration matrix."], [], matrix.text))
        if ranges:
            units.append(
                frame.unit("model_ranges", ["Ranges of what depends on time alone."], ranges)
            )
    else:
        units = [frame.unit("model", _about(lowered), main + ranges, matrix.text, tables, fields)]
    if program.dag.tables:
        printed = print_tables(program.dag, alone=not split)
        units.append(
            Unit(
                "model_tables",
                printed.text,
                MODEL_FLAGS,
                parts=frozenset(),
                files=tuple(printed.files),
            )
        )
    return EmittedModel(
        name=program.scene.name,
        units=tuple(units),
        operations=operations,
        lowered=lowered,
        source_hash=source_hash,
    )


@dataclass(frozen=True, slots=True)
class _Frame:
    """The common parts of the units of a model."""

    title: str
    prototypes: Sequence[str]
    parts: frozenset[str]

    def unit(
        self,
        name: str,
        about: Sequence[str],
        kernels: Sequence[KernelText],
        matrix: str = "",
        tables: Sequence[str] = (),
        fields: Sequence[Field] = (),
    ) -> Unit:
        """One C file."""
        needed = {helper for text in kernels for helper in text.helpers}
        functions = [
            *(definition for name, definition in HELPERS.items() if name in needed),
            *self.prototypes,
            *(kernel.text for kernel in kernels),
            *([matrix] if matrix else []),
        ]
        text = print_unit(self.title, about, functions, tables, fields)
        return Unit(name, text, _FLAGS.get(name, MODEL_FLAGS), parts=self.parts)


def _needed_parts(lowered: Lowered) -> frozenset[str]:
    """The optional parts of the runtime that a model needs."""
    program = lowered.program
    uses = {
        "closures": program.closures is not None,
        "consistent": program.mass is not None,
        "devices": bool(program.devices),
        "events": bool(lowered.switches),
        "fmus": bool(program.fmus),
        "jumps": bool(program.jumps),
        "sampled": bool(program.held),
        "start": program.start is not None or bool(program.given),
        "timed": lowered.ranges is not None,
        "watch": bool(lowered.watches),
        "blocks": lowered.blocks is not None,
    }
    return frozenset(part for part, used in uses.items() if used)


def amalgamate(emitted: EmittedModel, runtime_dir: Path) -> str:
    """The same as `amalgamate_lowered`, of a model that has been printed in units too."""
    return amalgamate_lowered(emitted.lowered, emitted.source_hash, runtime_dir)


def amalgamate_lowered(lowered: Lowered, source_hash: str, runtime_dir: Path) -> str:
    """Print the model and the runtime as one C11 file that requires only libm.

    Factors in blocks of rows, which take the C compiler a second, and FMUs, which need the loader
    of POSIX, are left out where the model has none.
    """
    parts = parts_in_one_file(lowered)
    own = emit_lowered(lowered, source_hash, split=False).units
    sources = needed_sources(runtime_dir, parts)
    texts = [(f"{unit.name}.c", unit.text) for unit in own]
    texts += [(f"{name}.c", path.read_text("utf-8")) for name, path in sources.items()]
    return _HOW_TO_USE.format(name=lowered.program.scene.name) + joined(texts, runtime_dir)


def parts_in_one_file(lowered: Lowered) -> frozenset[str]:
    """The optional parts of the runtime in a file for any compiler and any use."""
    absent = {"blocks"} if lowered.blocks is None else set()
    return EVERY_PART - (absent if lowered.program.fmus else absent | {"fmus"})


def _print_kernels(lowered: Lowered, shared: set[str]) -> dict[str, KernelText]:
    """Print all kernels, by name."""
    program = lowered.program
    hoisted = _hoisted(lowered)
    prepare, *running = lowered.kernels
    texts = {prepare.name: print_prepare(program.dag, prepare, hoisted)}
    for kernel in running:
        texts[kernel.name] = print_kernel(program.dag, kernel, hoisted, kernel.name in shared)
    texts["defaults"] = print_defaults(program.dag, dependent_defaults(program))
    return texts


def _hoisted(lowered: Lowered) -> dict[Node, int]:
    """The index in h of each hoisted node."""
    return {node: k for k, node in enumerate(lowered.hoisted)}


def _on_ranges(lowered: Lowered, kernel: Kernel, shared: bool) -> KernelText:
    """Print a kernel on ranges, with the header that it needs."""
    text = print_kernel(lowered.program.dag, kernel, _hoisted(lowered), shared, RANGES)
    header = "bgc_table_ranges.h" if lowered.program.dag.tables else "bgc_ranges.h"
    return replace(text, text=f'#include "{header}"\n\n{text.text}')


def is_large(program: Program) -> bool:
    """Return whether a model is split into several units, which are compiled in parallel."""
    return len(program.dag) > _SPLIT


def print_matrix(lowered: Lowered, shared: bool, numbers: Numbers = DOUBLES) -> MatrixText:
    """Print the tables, `factor` and `solve` of the iteration matrix."""
    jacobian, mass = lowered.jacobian, lowered.program.mass
    positions = zip(jacobian.rows, jacobian.columns, strict=True)
    return print_lu(
        lowered.plan,
        None if mass is None else {(entry.row, entry.column): k for k, entry in enumerate(mass)},
        {position: k for k, position in enumerate(positions)},
        shared,
        numbers,
        jacobian.inner,
        lowered.blocks,
    )


def _about(lowered: Lowered) -> list[str]:
    """The comment that lists the names of the elements of each array of the model."""
    program = lowered.program
    inputs = [
        f"{device.name}.{channel}[{component}]"
        for device in program.devices
        for channel, component in device.inputs
    ]
    inputs += [_with_unit(held.name, held.unit) for held in program.held]
    sections = (
        ("Parameters p", [_with_unit(p.name, p.unit) for p in program.parameters]),
        ("States x", [_with_unit(s.name, s.unit) for s in program.states]),
        ("Inputs u", inputs),
        ("Outputs y", [_with_unit(o.name, o.unit) for o in program.observations]),
    )
    lines = [
        "Quantities are in SI units. t is time, h what depends on parameters alone, w scratch."
    ]
    for heading, names in sections:
        if names:
            lines += ["", f"{heading}:"]
            lines += [f"  {k:3d} {name}" for k, name in enumerate(names[:_LISTED])]
            if len(names) > _LISTED:
                lines.append(f"      and so on up to {len(names) - 1}: see the tables")
    return [line.replace("*/", "* /").replace("/*", "/ *") for line in lines]


def _with_unit(name: str, unit: str) -> str:
    return f"{name}  [{unit}]" if unit not in ("", "1") else name
