"""Print the C source of an FMU: model, runtime and the functions of the standard in one file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from bgc.building.build import needed_sources
from bgc.emission.amalgamate import joined
from bgc.emission.c_tables import number, quoted
from bgc.emission.emit import EmittedModel, emit_lowered, parts_in_one_file
from bgc.emission.partials import with_partials
from bgc.record_class import dataclass

_SHARED = (
    "fmi_instance",
    "fmi_present",
    "fmi_variables",
    "fmi_derivatives",
    "fmi_co_simulation",
    "fmi_model_exchange",
    "fmi_tuning",
)


@dataclass(frozen=True, slots=True)
class Mockup:
    """The facts of an FMU that its C source holds.

    `options` are fields of `bgc_options` with C texts. `input_start` are the values of the inputs
    before the importer sets any, `start` is a start at rest or empty. `free_states` are the numbers
    of the continuous states of Model Exchange. `counts` are the numbers behind each value
    reference: 1, the size of an array at its first component, 0 at the others.
    """

    version: int
    token: str
    options: tuple[tuple[str, str], ...]
    input_start: tuple[float, ...]
    start: tuple[float, ...]
    tunable: tuple[bool, ...]
    free_states: tuple[int, ...]
    accounts: bool
    derivatives: bool
    counts: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class MockupSource:
    """The C11 texts of an FMU, each of which requires no header of the runtime.

    `text` is the whole in one file. `model` and `runtime` are the two halves of it: `runtime` is
    that of many models, so that it is compiled once.
    """

    text: str
    model: str
    runtime: str


def mockup_source(emitted: EmittedModel, facts: Mockup, runtime_dir: Path) -> MockupSource:
    """Print the C11 file of an FMU, which requires only libm; equal input gives equal bytes."""
    lowered, pattern = with_partials(emitted.lowered, facts.accounts)
    own = emit_lowered(lowered, emitted.source_hash, split=False).units
    sources = needed_sources(runtime_dir, parts_in_one_file(lowered))
    kept = {name: path for name, path in sources.items() if not name.startswith("drivers/")}
    kept["devices"] = runtime_dir / "absent" / "devices.c"  # the importer takes their place
    glue = [f"fmi/{name}" for name in (*_SHARED, f"fmi{facts.version}")]
    model = [
        *((f"{unit.name}.c", unit.text) for unit in own),
        ("model_fmi.c", _tables(facts, pattern.rows, pattern.columns)),
    ]
    runtime = [
        *((f"{name}.c", path.read_text("utf-8")) for name, path in kept.items()),
        *((f"{name}.c", (runtime_dir / f"{name}.c").read_text("utf-8")) for name in glue),
    ]
    title = (
        f"/* {emitted.name}: an FMU of FMI {facts.version}.0, made by bgc. C11; link with -lm. */\n"
    )
    return MockupSource(
        title + joined([*model, *runtime], runtime_dir),
        joined(model, runtime_dir),
        joined(runtime, runtime_dir),
    )


def _tables(facts: Mockup, rows: Sequence[int], columns: Sequence[int]) -> str:
    """Print `bgc_fmi_info` of the model."""
    arrays = (
        ("input_start", "double", [number(x) for x in facts.input_start]),
        ("start", "double", [number(x) for x in facts.start]),
        ("tunable", "unsigned char", [str(int(x)) for x in facts.tunable]),
        ("free_state", "int", [str(k) for k in facts.free_states]),
        ("count", "int", [str(k) for k in facts.counts]),
        ("partial_row", "int", [str(k) for k in rows]),
        ("partial_col", "int", [str(k) for k in columns]),
    )
    fields = [
        ("token", quoted(facts.token)),
        ("options", f"{{{', '.join(f'.{name} = {text}' for name, text in facts.options)}}}"),
        ("n_input", str(len(facts.input_start))),
        ("n_continuous", str(len(facts.free_states) + 2 * facts.accounts)),
        ("n_free", str(len(facts.free_states))),
        ("derivatives", str(int(facts.derivatives))),
        ("n_partial", str(len(rows))),
        ("partials", "model_partials"),
    ]
    lines = ['#include "fmi.h"\n']
    for name, type_, values in arrays:
        if values:
            chunks = [", ".join(values[k : k + 16]) for k in range(0, len(values), 16)]
            body = "".join(f"    {chunk},\n" for chunk in chunks)
            lines.append(f"static const {type_} fmi_{name}[] = {{\n{body}}};\n")
        fields.append((name, f"fmi_{name}" if values else "NULL"))
    body = "".join(f"    .{name} = {value},\n" for name, value in fields)
    lines.append(f"static const bgc_fmi_info fmi_info = {{\n{body}}};\n")
    lines.append("const bgc_fmi_info *bgc_fmi_get_info(void) { return &fmi_info; }\n")
    return "\n".join(lines)
